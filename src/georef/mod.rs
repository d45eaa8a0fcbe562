//! The georeferencing equation and its derivatives.
