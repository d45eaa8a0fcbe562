//! Plane extraction and association.
