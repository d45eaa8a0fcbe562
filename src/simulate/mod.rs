//! Truth to observations with noise.
