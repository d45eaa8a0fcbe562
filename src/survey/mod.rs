//! Survey and scenario files.
