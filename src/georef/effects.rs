//! What the unknowns of the caller's own make of a sounding.

use super::Beam;
use crate::observe::{Acts, Extra};

/// Own unknowns at their values: what they make of a sounding.
#[derive(Clone, Copy, Debug)]
pub struct Effects<'a> {
    extras: &'a [Extra],
    values: &'a [f64],
}

impl<'a> Effects<'a> {
    /// Of unknowns at their values, one each.
    #[must_use]
    pub fn new(extras: &'a [Extra], values: &'a [f64]) -> Self {
        Self { extras, values }
    }

    /// None.
    #[must_use]
    pub fn none() -> Self {
        Self::new(&[], &[])
    }

    /// Corrects a beam; returns by how much the sounding stands higher, metres.
    #[must_use]
    #[inline]
    pub fn act(&self, row: usize, beam: &mut Beam) -> f64 {
        let mut lift_m = 0.0;
        for (extra, value) in self.extras.iter().zip(self.values) {
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
}
