//! A rail calibration's observations: profiles of several 2-D laser profilers, the INS' attitude, and the table's angles.
//!
//! Frames: the level frame of the INS, the body (x right, y forward along the rail, z up), each profiler's frame, whose light plane is its
//! x-z plane (x lateral, z up when its mounting angles are zero), and the rail frame (x across the rail, y along it, z up).

use nalgebra::{Vector2, Vector3};

use crate::observe::{AttitudeRecord, Mounting};

/// One laser profiler.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiler {
    /// Name for reports.
    pub name: String,
    /// Mounting as far as it is known before.
    pub nominal: Mounting,
    /// Noise of the lateral coordinate in its light plane, metres, one sigma.
    pub lateral_sigma_m: f64,
    /// Noise of the other coordinate, metres, one sigma.
    pub vertical_sigma_m: f64,
    /// Uncertainty of the nominal lever arm along the rail, metres: a single profile says nothing of it.
    pub along_sigma_m: f64,
}

/// Points of all profiles, in columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProfilePoints {
    /// Time of the profile, seconds, not descending.
    pub time_s: Vec<f64>,
    /// Profiler, counted from 0.
    pub profiler: Vec<u32>,
    /// Lateral coordinate in the light plane, metres.
    pub y_m: Vec<f64>,
    /// The other coordinate, metres, up.
    pub z_m: Vec<f64>,
}

impl ProfilePoints {
    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Point `k` in its profiler's frame: the light plane is the x-z plane.
    #[must_use]
    pub fn point(&self, k: usize) -> Vector3<f64> {
        Vector3::new(self.y_m[k], 0.0, self.z_m[k])
    }
}

/// White noise of each attitude record, one sigma; what is constant belongs to the rail's orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AttitudeNoise {
    /// Roll and pitch, radians.
    pub roll_pitch_rad: f64,
    /// Heading, radians.
    pub heading_rad: f64,
}

/// Where the table stood: one row per position at which it was at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableRecord {
    /// First moment of rest, seconds, ascending.
    pub from_s: Vec<f64>,
    /// Last moment of rest, seconds.
    pub to_s: Vec<f64>,
    /// Turn about the vertical, radians, clockwise.
    pub heading_rad: Vec<f64>,
    /// Turn about the lateral axis, radians, front up.
    pub pitch_rad: Vec<f64>,
}

impl TableRecord {
    /// Number of positions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.from_s.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.from_s.is_empty()
    }

    /// The position that holds at a time; `None` while the table turns.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<usize> {
        let after = self.from_s.partition_point(|&from| from <= time_s);
        let place = after.checked_sub(1)?;
        (time_s <= self.to_s[place]).then_some(place)
    }
}

/// How table, beam and rail stand to each other, as far as it is known before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Each of the table's two angles, radians, one sigma, independent from position to position.
    pub table_sigma_rad: f64,
    /// Tilt of the table's vertical axis about the level x and y, radians, one sigma.
    pub level_sigma_rad: f64,
    /// Zero of the table's turn about the vertical against the INS' north, radians, one sigma.
    pub zero_sigma_rad: f64,
    /// Seat of the beam on the table about the body's x, y, z, radians, one sigma.
    pub seating_sigma_rad: f64,
    /// Point about which the table turns, in the body, metres.
    pub pivot_body_m: Vector3<f64>,
    /// Its uncertainty per axis, metres.
    pub pivot_body_sigma_m: f64,
    /// The same point in the rail's cross-section (x, z), metres.
    pub pivot_rail_m: Vector2<f64>,
    /// Its uncertainty per axis, metres.
    pub pivot_rail_sigma_m: f64,
    /// How far the table's lateral axis may lie before its vertical one (backwards negative), metres, one sigma; 0 where they meet.
    pub axes_gap_sigma_m: f64,
    /// Orientation of the rail in the level frame: roll, pitch, heading, radians.
    pub rail_attitude_rad: [f64; 3],
    /// Its uncertainty about the level axes x, y, z, radians, constant errors of the INS included.
    pub rail_attitude_sigma_rad: Vector3<f64>,
    /// How far each element of the real rail lies off its standard profile along its normal, metres, one sigma; 0 for a perfect rail.
    pub profile_sigma_m: f64,
}

/// Everything that a rail calibration gets, except the standard profile.
#[derive(Clone, Debug, PartialEq)]
pub struct RailCampaign {
    /// The profilers.
    pub profilers: Vec<Profiler>,
    /// Their points.
    pub points: ProfilePoints,
    /// The INS.
    pub attitude: AttitudeRecord,
    /// Its noise.
    pub attitude_noise: AttitudeNoise,
    /// The table.
    pub table: TableRecord,
    /// What is known of the stand.
    pub stand: Stand,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_belongs_to_the_position_that_holds_then() {
        let table = TableRecord {
            from_s: vec![0.0, 2.0],
            to_s: vec![1.0, 3.0],
            heading_rad: vec![0.0; 2],
            pitch_rad: vec![0.0; 2],
        };
        let found: Vec<_> = [-0.1, 0.0, 1.0, 1.5, 2.5, 3.1].map(|t| table.at(t)).into();
        assert_eq!(found, [None, Some(0), Some(0), None, Some(1), None]);
    }
}
