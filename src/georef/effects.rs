//! What the unknowns of the caller's own make of a sounding.

use super::Beam;
use crate::observe::{Acts, Extra};

/// Corrects a beam by own unknowns at their values, one each; returns by how much the sounding stands higher, metres.
#[must_use]
#[inline]
pub fn act(extras: &[Extra], values: &[f64], row: usize, beam: &mut Beam) -> f64 {
    let mut lift_m = 0.0;
    for (extra, value) in extras.iter().zip(values) {
        let by = extra.at(row).map_or(0.0, |derivative| derivative * value);
        match extra.acts {
            Acts::Up => lift_m += by,
            Acts::Range => beam.range_m += by,
            Acts::Across => beam.across_rad += by,
            Acts::Along => beam.along_rad += by,
        }
    }
    lift_m
}
