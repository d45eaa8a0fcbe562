//! The adjustment engine, blind to instruments.
