//! Results as plain serialisable data.
