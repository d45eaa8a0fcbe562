//! Calibration procedures.
