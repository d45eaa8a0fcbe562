//! Calibration targets as faces.
