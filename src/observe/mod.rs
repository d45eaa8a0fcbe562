//! What instruments say.
