//! Units at the border.
