//! From a geodetic trajectory to one in the target frame.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::geometry::ellipsoid::{TargetPose, ecef_from_level};
use crate::geometry::{Geodetic, rotation};
use crate::math;
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
/// Velocities are used (curved interpolation) only when, summed over a second, they agree with the positions within their noise.
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

/// Time over which velocities are summed up before they are compared with positions, seconds: long enough that a wrong frame shows
/// (velocities in a wander frame taken as east and north), short enough that drift does not.
const WINDOW_S: f64 = 1.0;

/// Velocities, if their trapezoid sums reproduce the position steps of one second within three sigmas of noise and drift.
fn usable_velocity(
    source: &GeodeticTrajectory,
    position: &[Vector3<f64>],
    velocity: Option<Vec<Vector3<f64>>>,
) -> (Option<Vec<Vector3<f64>>>, Option<String>) {
    let Some(velocity) = velocity else {
        return (None, None);
    };
    let mut misfit_m = velocity_misfits_m(source, position, &velocity);
    let typical_m = crate::stats::median(&mut misfit_m).unwrap_or(0.0);
    let noise = &source.noise;
    let drift = 1.0 - math::exp(-WINDOW_S / noise.drift_correlation_time_s.max(WINDOW_S));
    let drift_m = noise.position_drift_m * drift.sqrt();
    let limit_m = 3.0 * math::hypot(noise.position_m.max(1e-4), drift_m);
    if typical_m <= limit_m {
        return (Some(velocity), None);
    }
    let note = format!(
        "trajectory velocities disagree with differenced positions (median {typical_m:.4} m over {WINDOW_S} s, limit {limit_m:.4} m): \
         positions are interpolated linearly"
    );
    (None, Some(note))
}

/// Distances between the position steps over windows of [`WINDOW_S`] and the velocities summed over them; gaps begin a new window,
/// a trajectory shorter than a window is one.
fn velocity_misfits_m(
    source: &GeodeticTrajectory,
    position: &[Vector3<f64>],
    velocity: &[Vector3<f64>],
) -> Vec<f64> {
    let time_s = &source.time_s;
    let (mut misfits, mut begin, mut sum) = (Vec::new(), 0, Vector3::zeros());
    for k in 1..position.len() {
        let step_s = time_s[k] - time_s[k - 1];
        if step_s > source.max_gap_s {
            (begin, sum) = (k, Vector3::zeros());
            continue;
        }
        sum += (velocity[k] + velocity[k - 1]) * (0.5 * step_s);
        let last = k + 1 == position.len() && misfits.is_empty();
        if last || time_s[k] - time_s[begin] >= WINDOW_S {
            misfits.push((position[k] - position[begin] - sum).norm());
            (begin, sum) = (k, Vector3::zeros());
        }
    }
    misfits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ellipsoid;
    use crate::observe::{Outside, PositionInterpolation, TrajectoryNoise};

    /// A straight run of 3 s at 200 Hz with the velocities `[east, north, up]` of the second argument.
    fn run(moved_m_s: Vector3<f64>, velocity_m_s: [f64; 3]) -> Localised {
        let origin = Geodetic {
            latitude_rad: 0.6,
            longitude_rad: 2.0,
            height_m: 15.0,
        };
        let target = TargetPose {
            ellipsoid: Ellipsoid::Wgs84,
            origin,
            azimuth_rad: 0.0,
        };
        let time_s: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.005).collect();
        let track: Vec<Geodetic> = time_s
            .iter()
            .map(|&t| target.moved(&(moved_m_s * t), 0.0).origin)
            .collect();
        let source = GeodeticTrajectory {
            ellipsoid: Ellipsoid::Wgs84,
            latitude_rad: track.iter().map(|g| g.latitude_rad).collect(),
            longitude_rad: track.iter().map(|g| g.longitude_rad).collect(),
            height_m: track.iter().map(|g| g.height_m).collect(),
            roll_rad: vec![0.0; 600],
            pitch_rad: vec![0.0; 600],
            heading_rad: vec![0.3; 600],
            velocity_m_s: Some(vec![velocity_m_s; 600]),
            time_s,
            noise: noise(0.005),
            max_gap_s: 1.0,
            outside: Outside::Error,
        };
        local_trajectory(&source, &target)
    }

    fn noise(position_m: f64) -> TrajectoryNoise {
        TrajectoryNoise {
            position_m,
            position_drift_m: 0.0,
            drift_correlation_time_s: 60.0,
            roll_pitch_rad: 0.0,
            heading_rad: 0.0,
            heading_drift_rad: 0.0,
        }
    }

    /// Figures of the real SBET: velocities x north-ish, y west, z up in a frame wandered by 1.02 degrees.
    #[test]
    fn velocities_count_only_in_their_true_frame() {
        let (north, west, wander) = (-102.624, -40.676, 1.02f64.to_radians());
        let (sine, cosine) = math::sin_cos(wander);
        let (x, y) = (north * cosine + west * sine, west * cosine - north * sine);
        let moved = Vector3::new(-west, north, 0.0);
        let resolved = [-(x * sine + y * cosine), x * cosine - y * sine, 0.0];
        let right = run(moved, resolved);
        assert_eq!(right.note, None);
        assert_eq!(
            right.trajectory.interpolation(),
            PositionInterpolation::Curved
        );
        for wrong in [[-y, x, 0.0], [x, y, 0.0], [-resolved[0], resolved[1], 0.0]] {
            let refused = run(moved, wrong);
            assert!(refused.note.is_some_and(|note| note.contains("linearly")));
            assert_eq!(
                refused.trajectory.interpolation(),
                PositionInterpolation::Linear
            );
        }
    }

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
            noise: noise(0.002),
            max_gap_s: 1.0,
            outside: Outside::Error,
        };
        let local = local_trajectory(&source, &target).trajectory;
        assert!((local.positions_m()[0] - Vector3::new(-10.0, 0.0, 1.0)).norm() < 1e-8);
        // heading equals the azimuth of +Y: the body is parallel to the target, up to the curvature over 10 m
        assert!((local.attitudes()[0] - Matrix3::identity()).norm() < 1e-5);
    }
}
