//! From a geodetic trajectory to one in the target frame.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::geometry::ellipsoid::{TargetPose, ecef_from_level};
use crate::geometry::{Geodetic, rotation};
use crate::observe::{GeodeticTrajectory, Trajectory};

/// Position, attitude and velocity of one record in the target frame.
type LocalRecord = (Vector3<f64>, Matrix3<f64>, Option<Vector3<f64>>);

/// A trajectory in the target frame, and what was decided about its interpolation.
#[derive(Clone, Debug)]
pub struct Localised {
    /// The trajectory in the target frame.
    pub trajectory: Trajectory,
    /// A sentence when velocities were given but not used, because they disagree with the positions.
    pub note: Option<String>,
}

/// Positions and attitudes of every record in the frame of `target`; the local level turns with the position of each record.
///
/// Velocities are used (cubic interpolation) only when they agree with differenced positions within the position noise.
#[must_use]
pub fn local_trajectory(source: &GeodeticTrajectory, target: &TargetPose) -> Localised {
    let to_target = target.ecef_from_target().inverse();
    let records: Vec<LocalRecord> = (0..source.time_s.len())
        .into_par_iter()
        .map(|k| {
            let geodetic = Geodetic {
                latitude_rad: source.latitude_rad[k],
                longitude_rad: source.longitude_rad[k],
                height_m: source.height_m[k],
            };
            let target_from_level = to_target.rotation * ecef_from_level(&geodetic);
            let body = rotation::from_attitude(
                source.roll_rad[k],
                source.pitch_rad[k],
                source.heading_rad[k],
            );
            let velocity = source
                .velocity_m_s
                .as_ref()
                .map(|v| target_from_level.matrix * Vector3::from(v[k]));
            let position = to_target * source.ellipsoid.to_geocentric(&geodetic);
            (
                position.coordinates,
                target_from_level.matrix * body,
                velocity,
            )
        })
        .collect();
    let position: Vec<_> = records.iter().map(|r| r.0).collect();
    let attitude = records.iter().map(|r| r.1).collect();
    let velocity: Option<Vec<_>> = records.iter().map(|r| r.2).collect();
    let (velocity, note) = usable_velocity(source, &position, velocity);
    Localised {
        trajectory: Trajectory::new(
            source.time_s.clone(),
            position,
            attitude,
            velocity,
            source.max_gap_s,
        ),
        note,
    }
}

/// Velocities, if the trapezoid rule over them reproduces the position steps within three sigmas of the white noise.
fn usable_velocity(
    source: &GeodeticTrajectory,
    position: &[Vector3<f64>],
    velocity: Option<Vec<Vector3<f64>>>,
) -> (Option<Vec<Vector3<f64>>>, Option<String>) {
    let Some(velocity) = velocity else {
        return (None, None);
    };
    let mut misfit: Vec<f64> = (1..position.len())
        .filter(|&k| source.time_s[k] - source.time_s[k - 1] <= source.max_gap_s)
        .map(|k| {
            let step = source.time_s[k] - source.time_s[k - 1];
            (position[k] - position[k - 1] - (velocity[k] + velocity[k - 1]) * (0.5 * step)).norm()
        })
        .collect();
    let typical_m = crate::stats::median(&mut misfit).unwrap_or(0.0);
    let limit_m = 3.0 * source.noise.position_m.max(1e-4);
    if typical_m <= limit_m {
        return (Some(velocity), None);
    }
    let note = format!(
        "trajectory velocities disagree with differenced positions (median {typical_m:.4} m per record, limit {limit_m:.4} m): \
         positions are interpolated linearly"
    );
    (None, Some(note))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ellipsoid;
    use crate::observe::{Outside, TrajectoryNoise};

    #[test]
    fn one_degree_of_heading_and_ten_metres_east() {
        let origin = Geodetic {
            latitude_rad: 0.6,
            longitude_rad: 2.0,
            height_m: 15.0,
        };
        let target = TargetPose {
            ellipsoid: Ellipsoid::Wgs84,
            origin,
            azimuth_rad: 0.3,
        };
        let at = target.moved(&Vector3::new(-10.0, 0.0, 1.0), 0.0).origin;
        let source = GeodeticTrajectory {
            ellipsoid: Ellipsoid::Wgs84,
            time_s: vec![0.0, 1.0],
            latitude_rad: vec![at.latitude_rad; 2],
            longitude_rad: vec![at.longitude_rad; 2],
            height_m: vec![at.height_m; 2],
            roll_rad: vec![0.0; 2],
            pitch_rad: vec![0.0; 2],
            heading_rad: vec![0.3; 2],
            velocity_m_s: None,
            noise: TrajectoryNoise {
                position_m: 0.002,
                position_drift_m: 0.0,
                drift_correlation_time_s: 60.0,
                roll_pitch_rad: 0.0,
                heading_rad: 0.0,
                heading_drift_rad: 0.0,
            },
            max_gap_s: 1.0,
            outside: Outside::Error,
        };
        let local = local_trajectory(&source, &target).trajectory;
        assert!((local.positions_m()[0] - Vector3::new(-10.0, 0.0, 1.0)).norm() < 1e-8);
        // heading equals the azimuth of +Y: the body is parallel to the target, up to the curvature over 10 m
        assert!((local.attitudes()[0] - Matrix3::identity()).norm() < 1e-5);
    }
}
