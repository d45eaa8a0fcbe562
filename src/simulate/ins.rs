//! The recorded trajectory: the truth at the records' times, with the INS's errors.

use nalgebra::{Matrix3, Vector3};

use super::motion::{Leg, Motion};
use super::reality::Reality;
use super::scenario::Scenario;
use super::sources::{GaussMarkov, Source};
use super::switches::Draws;
use crate::geometry::ellipsoid::{Geodetic, ecef_from_level};
use crate::geometry::{Point, Target, rotation};
use crate::observe::{GeodeticTrajectory, Outside, TrajectoryNoise};

/// What the INS records.
pub(super) fn record(
    scenario: &Scenario,
    reality: &Reality,
    motion: &Motion,
    seed: u64,
) -> GeodeticTrajectory {
    let ins = &scenario.trajectory;
    let mut errors = InsErrors::new(scenario, seed);
    let mut out = empty(scenario, reality);
    let margin_s = margin_s(scenario, reality);
    for leg in motion.legs() {
        let first = ((leg.begin_s - margin_s) * ins.rate_hz).round() as i64;
        let last = ((leg.end_s + margin_s) * ins.rate_hz).round() as i64;
        for k in first..=last {
            let time_s = k as f64 / ins.rate_hz;
            push(&mut out, reality, motion, leg, time_s, &errors.at(time_s));
        }
    }
    out
}

/// How long before and after a pass the INS records: stamps may be late.
pub(super) fn margin_s(scenario: &Scenario, reality: &Reality) -> f64 {
    let steps = 5.0 / scenario.trajectory.rate_hz;
    steps + reality.latency_s.abs() + 8.0 * scenario.truth.latency_jitter_s
}

/// Errors of one record: position east, north, up (metres); roll, pitch, heading (radians).
struct RecordError {
    position_m: Vector3<f64>,
    attitude_rad: Vector3<f64>,
}

struct InsErrors {
    sigmas: TrajectoryNoise,
    white: Draws,
    drift: Draws,
    tilt: Draws,
    heading: Draws,
    slow: Draws,
    position: [GaussMarkov; 3],
    slow_heading: GaussMarkov,
}

impl InsErrors {
    fn new(scenario: &Scenario, seed: u64) -> Self {
        let sigmas = noise(scenario);
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let tau = sigmas.drift_correlation_time_s;
        Self {
            white: draws(Source::PositionWhite),
            drift: draws(Source::PositionDrift),
            tilt: draws(Source::RollPitch),
            heading: draws(Source::Heading),
            slow: draws(Source::HeadingDrift),
            position: [0, 1, 2].map(|_| GaussMarkov::new(sigmas.position_drift_m, tau)),
            slow_heading: GaussMarkov::new(sigmas.heading_drift_rad, tau),
            sigmas,
        }
    }

    fn at(&mut self, time_s: f64) -> RecordError {
        let s = &self.sigmas;
        let drift = self
            .position
            .each_mut()
            .map(|axis| axis.at(time_s, |sigma| self.drift.normal(sigma)));
        let white = [0, 1, 2].map(|_| self.white.normal(s.position_m));
        let (roll, pitch) = (
            self.tilt.normal(s.roll_pitch_rad),
            self.tilt.normal(s.roll_pitch_rad),
        );
        let slow = |sigma| self.slow.normal(sigma);
        let heading = self.heading.normal(s.heading_rad) + self.slow_heading.at(time_s, slow);
        RecordError {
            position_m: Vector3::from(drift) + Vector3::from(white),
            attitude_rad: Vector3::new(roll, pitch, heading),
        }
    }
}

fn push(
    out: &mut GeodeticTrajectory,
    reality: &Reality,
    motion: &Motion,
    leg: &Leg,
    time_s: f64,
    error: &RecordError,
) {
    let body = motion.pose(leg, time_s);
    let frame = reality.target.ecef_from_target();
    let place = frame * Point::<Target>::new(body.position_m);
    let level_at = |g: &Geodetic| ecef_from_level(g).matrix;
    let ellipsoid = out.ellipsoid;
    let truth = ellipsoid.to_geodetic(&place);
    let level = level_at(&truth);
    let ecef_from_body: Matrix3<f64> = frame.rotation.matrix * body.rotation;
    let (roll, pitch, heading) = rotation::to_attitude(&(level.tr_mul(&ecef_from_body)));
    let recorded = ellipsoid.to_geodetic(&Point::new(place.coordinates + level * error.position_m));
    out.time_s.push(time_s);
    out.latitude_rad.push(recorded.latitude_rad);
    out.longitude_rad.push(recorded.longitude_rad);
    out.height_m.push(recorded.height_m);
    out.roll_rad.push(roll + error.attitude_rad.x);
    out.pitch_rad.push(pitch + error.attitude_rad.y);
    out.heading_rad.push(heading + error.attitude_rad.z);
    if let Some(velocity) = &mut out.velocity_m_s {
        let v = level.tr_mul(&(frame.rotation.matrix * motion.velocity(leg, time_s)));
        velocity.push([v.x, v.y, v.z]);
    }
}

fn noise(scenario: &Scenario) -> TrajectoryNoise {
    let ins = &scenario.trajectory;
    TrajectoryNoise {
        position_m: ins.position_sigma_m,
        position_drift_m: ins.position_drift_sigma_m,
        drift_correlation_time_s: ins.drift_correlation_time_s,
        roll_pitch_rad: ins.roll_pitch_sigma_deg.to_radians(),
        heading_rad: ins.heading_sigma_deg.to_radians(),
        heading_drift_rad: ins.heading_drift_sigma_deg.to_radians(),
    }
}

fn empty(scenario: &Scenario, reality: &Reality) -> GeodeticTrajectory {
    GeodeticTrajectory {
        ellipsoid: reality.target.ellipsoid,
        time_s: vec![],
        latitude_rad: vec![],
        longitude_rad: vec![],
        height_m: vec![],
        roll_rad: vec![],
        pitch_rad: vec![],
        heading_rad: vec![],
        velocity_m_s: scenario.trajectory.velocity.then(Vec::new),
        noise: noise(scenario),
        max_gap_s: scenario.trajectory.max_gap_s,
        outside: Outside::Error,
    }
}
