//! The INS trajectory: geodetic as it was read, and local as the adjustment uses it.

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use crate::geometry::{Ellipsoid, rotation};

/// What happens to an observation outside the trajectory or in one of its gaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Outside {
    /// It is an error that names the observation.
    #[default]
    Error,
    /// It is dropped and counted.
    Drop,
}

/// A-priori noise of the trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryNoise {
    /// White position noise per record and axis, metres.
    pub position_m: f64,
    /// Standard deviation of the first-order Gauss-Markov position drift per axis, metres.
    pub position_drift_m: f64,
    /// Correlation time of the drift, seconds.
    pub drift_correlation_time_s: f64,
    /// White roll and pitch noise per record, radians.
    pub roll_pitch_rad: f64,
    /// White heading noise per record, radians.
    pub heading_rad: f64,
    /// Standard deviation of a slow (Gauss-Markov) heading error, radians; 0 for none.
    pub heading_drift_rad: f64,
}

/// A trajectory as files give it, in columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct GeodeticTrajectory {
    /// Ellipsoid of the positions.
    pub ellipsoid: Ellipsoid,
    /// Time, seconds, strictly ascending.
    pub time_s: Vec<f64>,
    /// Geodetic latitude, radians.
    pub latitude_rad: Vec<f64>,
    /// Longitude, radians.
    pub longitude_rad: Vec<f64>,
    /// Ellipsoidal height, metres.
    pub height_m: Vec<f64>,
    /// Roll, radians, positive starboard down.
    pub roll_rad: Vec<f64>,
    /// Pitch, radians, positive bow up.
    pub pitch_rad: Vec<f64>,
    /// True heading, radians, clockwise from north.
    pub heading_rad: Vec<f64>,
    /// Velocity east, north, up, metres per second, where the source gives it.
    pub velocity_m_s: Option<Vec<[f64; 3]>>,
    /// A-priori noise.
    pub noise: TrajectoryNoise,
    /// Longest interval that is interpolated, seconds.
    pub max_gap_s: f64,
    /// What to do with observations that have no position.
    pub outside: Outside,
}

/// How positions between two records are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionInterpolation {
    /// Linear.
    Linear,
    /// Linear plus the sag of a constant acceleration, the recorded velocities' change over the interval.
    Curved,
}

/// A trajectory in a local Cartesian frame, ready to be interpolated.
#[derive(Clone, Debug)]
pub struct Trajectory {
    time_s: Vec<f64>,
    position_m: Vec<Vector3<f64>>,
    attitude: Vec<Matrix3<f64>>,
    /// Rotation vector from record k to k+1 in the body of record k, radians.
    turn: Vec<Vector3<f64>>,
    velocity_m_s: Option<Vec<Vector3<f64>>>,
    max_gap_s: f64,
    slots_per_second: f64,
    slots: Vec<u32>,
}

/// Why a time has no pose.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TrajectoryError {
    /// Before the first or after the last record.
    #[error("time {time_s:.6} s is outside the trajectory ({first_s:.6} s to {last_s:.6} s)")]
    Outside {
        /// Time asked for.
        time_s: f64,
        /// First record.
        first_s: f64,
        /// Last record.
        last_s: f64,
    },
    /// Between two records further apart than the limit.
    #[error(
        "time {time_s:.6} s falls into a gap of {gap_s:.3} s that begins at {begin_s:.6} s (the limit is {limit_s} s)"
    )]
    Gap {
        /// Time asked for.
        time_s: f64,
        /// Begin of the gap.
        begin_s: f64,
        /// Its length.
        gap_s: f64,
        /// The limit.
        limit_s: f64,
    },
}

/// Pose of the body at one moment: position and `R_b^t`, and which records it hangs on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSample {
    /// INS centre in the local frame, metres.
    pub position_m: Vector3<f64>,
    /// Body into local frame.
    pub rotation: Matrix3<f64>,
    /// Record before the moment.
    pub record: u32,
    /// Weight of the record before in position and attitude alike; the record after has `1 - weight_before`.
    pub weight_before: f64,
}

impl Trajectory {
    /// From columns in a local frame: positions (metres), body-to-local rotations and, where they may be used, velocities.
    ///
    /// Columns of different length are cut to the shortest.
    #[must_use]
    pub fn new(
        mut time_s: Vec<f64>,
        mut position_m: Vec<Vector3<f64>>,
        mut attitude: Vec<Matrix3<f64>>,
        mut velocity_m_s: Option<Vec<Vector3<f64>>>,
        max_gap_s: f64,
    ) -> Self {
        let velocities = velocity_m_s.as_ref().map_or(usize::MAX, Vec::len);
        let records = [position_m.len(), attitude.len(), velocities]
            .into_iter()
            .fold(time_s.len(), usize::min);
        time_s.truncate(records);
        position_m.truncate(records);
        attitude.truncate(records);
        velocity_m_s.iter_mut().for_each(|v| v.truncate(records));
        let turn = attitude
            .windows(2)
            .map(|pair| rotation::log(&(pair[0].transpose() * pair[1])))
            .collect();
        let (slots_per_second, slots) = index_by_time(&time_s);
        Self {
            time_s,
            position_m,
            attitude,
            turn,
            velocity_m_s,
            max_gap_s,
            slots_per_second,
            slots,
        }
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no record.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Times of the records, seconds.
    #[must_use]
    pub fn times_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Positions of the records in the local frame, metres.
    #[must_use]
    pub fn positions_m(&self) -> &[Vector3<f64>] {
        &self.position_m
    }

    /// Attitudes of the records, body into local frame.
    #[must_use]
    pub fn attitudes(&self) -> &[Matrix3<f64>] {
        &self.attitude
    }

    /// Which interpolation [`Self::pose_at`] uses for positions.
    #[must_use]
    pub fn interpolation(&self) -> PositionInterpolation {
        if self.velocity_m_s.is_some() {
            PositionInterpolation::Curved
        } else {
            PositionInterpolation::Linear
        }
    }

    /// The same trajectory in another local frame: `p' = R p + t`.
    #[must_use]
    pub fn transformed(&self, rotation: &Matrix3<f64>, translation_m: &Vector3<f64>) -> Self {
        let mut moved = self.clone();
        for p in &mut moved.position_m {
            *p = rotation * *p + translation_m;
        }
        for r in &mut moved.attitude {
            *r = rotation * *r;
        }
        for v in moved.velocity_m_s.iter_mut().flatten() {
            *v = rotation * *v;
        }
        moved
    }

    /// The record before `time_s`, or why there is no pose at that time. Never extrapolates.
    ///
    /// # Errors
    /// [`TrajectoryError`] when the time is outside or in a gap.
    pub fn record_before(&self, time_s: f64) -> Result<usize, TrajectoryError> {
        let (Some(&first_s), Some(&last_s)) = (self.time_s.first(), self.time_s.last()) else {
            return Err(TrajectoryError::Outside {
                time_s,
                first_s: f64::NAN,
                last_s: f64::NAN,
            });
        };
        if !(time_s >= first_s && time_s <= last_s) || self.time_s.len() < 2 {
            return Err(TrajectoryError::Outside {
                time_s,
                first_s,
                last_s,
            });
        }
        let slot =
            (((time_s - first_s) * self.slots_per_second) as usize).min(self.slots.len() - 1);
        let mut record = self.slots[slot] as usize;
        while record + 2 < self.time_s.len() && self.time_s[record + 1] <= time_s {
            record += 1;
        }
        while record > 0 && self.time_s[record] > time_s {
            record -= 1;
        }
        let gap_s = self.time_s[record + 1] - self.time_s[record];
        if gap_s > self.max_gap_s
            && time_s > self.time_s[record]
            && time_s < self.time_s[record + 1]
        {
            return Err(TrajectoryError::Gap {
                time_s,
                begin_s: self.time_s[record],
                gap_s,
                limit_s: self.max_gap_s,
            });
        }
        Ok(record)
    }

    /// Pose at a time: position linear (with velocities plus the sag of a constant acceleration), attitude by slerp. Errors of the
    /// two records enter both linearly in time.
    ///
    /// # Errors
    /// [`TrajectoryError`] when the time is outside or in a gap.
    pub fn pose_at(&self, time_s: f64) -> Result<PoseSample, TrajectoryError> {
        let k = self.record_before(time_s)?;
        let step_s = self.time_s[k + 1] - self.time_s[k];
        let f = (time_s - self.time_s[k]) / step_s;
        let rotation = self.attitude[k] * rotation::exp(&(self.turn[k] * f));
        let (p0, p1) = (self.position_m[k], self.position_m[k + 1]);
        let chord_m = p0 + (p1 - p0) * f;
        let position_m = match &self.velocity_m_s {
            None => chord_m,
            Some(v) => chord_m + (v[k] - v[k + 1]) * (0.5 * f * (1.0 - f) * step_s),
        };
        Ok(PoseSample {
            position_m,
            rotation,
            record: k as u32,
            weight_before: 1.0 - f,
        })
    }

    /// The time of a pose of this trajectory, seconds.
    #[must_use]
    pub fn time_of(&self, pose: &PoseSample) -> f64 {
        let k = pose.record as usize;
        let (before_s, after_s) = (self.time_s[k], self.time_s[k + 1]);
        before_s + (after_s - before_s) * (1.0 - pose.weight_before)
    }
}

/// A table of the record at the begin of evenly spaced slots, so that looking up a time costs a step or two.
fn index_by_time(time_s: &[f64]) -> (f64, Vec<u32>) {
    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else {
        return (0.0, vec![0]);
    };
    let span = last - first;
    if !(span > 0.0 && span.is_finite()) {
        return (0.0, vec![0]);
    }
    let count = (2 * time_s.len()).min(50_000_000);
    let per_second = count as f64 / span;
    let mut record = 0;
    let slots = (0..count)
        .map(|slot| {
            let begin = first + slot as f64 / per_second;
            while record + 2 < time_s.len() && time_s[record + 1] <= begin {
                record += 1;
            }
            record as u32
        })
        .collect();
    (per_second, slots)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight() -> Trajectory {
        let time_s: Vec<f64> = vec![0.0, 1.0, 2.0, 12.0, 13.0];
        let position = time_s
            .iter()
            .map(|t| Vector3::new(2.0 * t, 0.0, 1.0))
            .collect();
        let attitude = time_s
            .iter()
            .map(|t| rotation::from_attitude(0.0, 0.0, 0.01 * t))
            .collect();
        Trajectory::new(time_s, position, attitude, None, 5.0)
    }

    #[test]
    fn positions_are_linear_and_attitudes_turn_evenly() {
        let pose = straight().pose_at(1.25).expect("inside");
        assert!((pose.position_m - Vector3::new(2.5, 0.0, 1.0)).norm() < 1e-15);
        assert!((pose.rotation - rotation::from_attitude(0.0, 0.0, 0.0125)).norm() < 1e-15);
        assert_eq!((pose.record, pose.weight_before), (1, 0.75));
    }

    #[test]
    fn gaps_and_the_outside_are_errors_but_their_edges_are_not() {
        let trajectory = straight();
        assert!(matches!(
            trajectory.pose_at(5.0),
            Err(TrajectoryError::Gap { .. })
        ));
        assert!(matches!(
            trajectory.pose_at(-0.1),
            Err(TrajectoryError::Outside { .. })
        ));
        assert!(matches!(
            trajectory.pose_at(f64::NAN),
            Err(TrajectoryError::Outside { .. })
        ));
        assert!(
            trajectory.pose_at(2.0).is_ok()
                && trajectory.pose_at(12.0).is_ok()
                && trajectory.pose_at(13.0).is_ok()
        );
    }

    #[test]
    fn interpolation_with_velocities_follows_a_parabola_exactly() {
        let time_s = vec![0.0, 0.5, 1.5];
        let position = time_s
            .iter()
            .map(|t| Vector3::new(t * t, 0.0, 0.0))
            .collect();
        let velocity = time_s
            .iter()
            .map(|t| Vector3::new(2.0 * t, 0.0, 0.0))
            .collect();
        let trajectory = Trajectory::new(
            time_s,
            position,
            vec![Matrix3::identity(); 3],
            Some(velocity),
            5.0,
        );
        let pose = trajectory.pose_at(1.1).expect("inside");
        assert!((pose.position_m.x - 1.21).abs() < 1e-14);
    }

    /// A turning, accelerating body whose second record is off by `shift_m` along x and `turn_rad` about z.
    fn disturbed(shift_m: f64, turn_rad: f64) -> PoseSample {
        let off = rotation::exp(&Vector3::new(0.0, 0.0, turn_rad));
        let position = vec![Vector3::zeros(), Vector3::new(1.0 + shift_m, 0.0, 0.0)];
        let attitude = vec![
            rotation::from_attitude(0.0, 0.0, 0.3),
            off * rotation::from_attitude(0.0, 0.0, 0.5),
        ];
        let velocity = vec![Vector3::new(0.5, 0.0, 0.0), Vector3::new(1.5, 0.0, 0.0)];
        let trajectory = Trajectory::new(vec![0.0, 1.0], position, attitude, Some(velocity), 5.0);
        trajectory.pose_at(0.3).expect("inside")
    }

    #[test]
    fn a_records_error_enters_position_and_attitude_with_the_weight_that_is_given() {
        let (clean, moved, turned) = (
            disturbed(0.0, 0.0),
            disturbed(0.1, 0.0),
            disturbed(0.0, 0.1),
        );
        let weight_after = 1.0 - clean.weight_before;
        let shift_m = (moved.position_m - clean.position_m).x;
        assert!((shift_m - 0.1 * weight_after).abs() < 1e-15, "{shift_m}");
        let turn = rotation::log(&(turned.rotation * clean.rotation.transpose()));
        assert!((turn.z - 0.1 * weight_after).abs() < 1e-15, "{turn}");
    }

    #[test]
    fn columns_of_different_length_are_cut() {
        let three = vec![Matrix3::identity(); 3];
        let two = vec![Vector3::zeros(); 2];
        let velocity = Some(vec![Vector3::zeros(); 5]);
        let trajectory = Trajectory::new(vec![0.0, 1.0, 2.0, 3.0], two, three, velocity, 5.0);
        assert_eq!(trajectory.len(), 2);
        assert!(trajectory.pose_at(0.5).is_ok() && trajectory.pose_at(1.5).is_err());
    }
}
