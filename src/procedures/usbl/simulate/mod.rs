//! A USBL survey in memory: what would have been recorded, and the answer to it.

pub mod scenario;
pub mod sources;
mod water;

pub use scenario::Scenario;

pub use sources::{Source, Sources};

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::observed::{
    AttitudeNoise, Beacon, ControlPoint, DatumSigma, FixNoise, Fixes, Role, UsblCampaign,
};
use crate::geometry::rotation;
use crate::math;
use crate::observe::{SoundSpeed, SoundSpeedProfile, Trajectory};
use crate::simulate::SimulateError;
use crate::simulate::motion::{Oscillation, Wave};
use crate::simulate::sources::GaussMarkov;
use crate::simulate::switches::Draws;
use crate::units::degrees;

/// The scenario of `boresight demo usbl`.
pub const DEMO: &str = include_str!("../../../../models/scenarios/usbl.toml");
/// Time of the first fix, seconds.
pub const START_S: f64 = 1000.0;
/// Longest interval of attitude that is interpolated, in records.
const GAP_RECORDS: f64 = 2.5;

/// A simulated survey.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// What was observed, as a calibration gets it.
    pub campaign: UsblCampaign,
    /// The answer.
    pub truth: Truth,
    /// The attitude record: roll, pitch, heading of each time, radians.
    pub attitude_rad: Vec<[f64; 3]>,
}

/// What a calibration should have found, as `truth.json` gives it. Level coordinates are those of the surveyed transducer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// True `R_u^b`, row by row.
    pub rotation_matrix: [[f64; 3]; 3],
    /// Nominal `R_u^b`, row by row.
    pub nominal_rotation_matrix: [[f64; 3]; 3],
    /// `log(R R_nominal^T)` about the body axes, degrees.
    pub correction_deg: crate::simulate::truth::TrueCorrection,
    /// True minus surveyed position of the transducer, east, north, up, metres.
    pub transducer_m: [f64; 3],
    /// True position of every beacon from the surveyed transducer, east, north, up, metres.
    pub beacons_m: Vec<TrueBeacon>,
    /// True range = measured x (1 + scale).
    pub range_scale: f64,
    /// Turn of the control against the attitude sensor's level frame about east, north, up, degrees.
    pub datum_deg: [f64; 3],
    /// Rows of the fixes that are grossly wrong, from 0.
    pub gross_fixes: Vec<u32>,
}

/// Where a beacon truly is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueBeacon {
    /// Name.
    pub name: String,
    /// East, north, up of the surveyed transducer, metres.
    pub position_m: [f64; 3],
}

impl Truth {
    /// The true mounting.
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_row_iterator(self.rotation_matrix.into_iter().flatten())
    }

    /// The true position of the transducer.
    #[must_use]
    pub fn transducer(&self) -> Vector3<f64> {
        Vector3::from(self.transducer_m)
    }
}

/// Simulates a scenario under a seed.
///
/// # Errors
/// [`SimulateError`] with every fault of the scenario.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<Simulated, SimulateError> {
    simulate_with(scenario, &scenario.sources, seed)
}

/// The same with other factors on the error sources.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_with(
    scenario: &Scenario,
    sources: &Sources,
    seed: u64,
) -> Result<Simulated, SimulateError> {
    let faults = scenario.check();
    if !faults.is_empty() {
        return Err(SimulateError::Scenario { faults });
    }
    let reality = Reality::draw(scenario, sources, seed);
    let (attitude, attitude_rad) = attitude(scenario, sources, seed);
    let (fixes, gross_fixes) = fixes(scenario, &reality, sources, seed);
    Ok(Simulated {
        campaign: campaign(scenario, &reality, attitude, fixes),
        truth: truth(&reality, gross_fixes),
        attitude_rad,
    })
}

/// How things truly are, as against how the survey believes them to be.
struct Reality {
    /// Name, role and true position (m) from the surveyed transducer.
    beacons: Vec<(String, Role, Vector3<f64>)>,
    surveyed: Vec<Vector3<f64>>,
    transducer_m: Vector3<f64>,
    mounting: Matrix3<f64>,
    nominal: Matrix3<f64>,
    scale: f64,
    datum_rad: Vector3<f64>,
    water: SoundSpeedProfile,
}

impl Reality {
    fn draw(scenario: &Scenario, sources: &Sources, seed: u64) -> Self {
        let draws = |source| Draws::new(seed, source, sources);
        let three =
            |draws: &mut Draws, sigma: [f64; 3]| Vector3::from(sigma.map(|s| draws.normal(s)));
        // everything is laid out about the true transducer, then seen from the surveyed one
        let transducer_m = three(
            &mut draws(Source::TransducerSurvey),
            scenario.transducer.sigma_m,
        );
        let beacons: Vec<_> = layout(scenario)
            .into_iter()
            .map(|(name, role, place)| (name, role, place + transducer_m))
            .collect();
        let mut survey = draws(Source::BeaconSurvey);
        let surveyed = beacons
            .iter()
            .map(|(_, _, place)| place + three(&mut survey, scenario.beacons.sigma_m))
            .collect();
        let water = &scenario.sound_speed;
        let mut speed = draws(Source::SoundSpeed);
        let middle = water.profile.iter().map(|s| s[1]).sum::<f64>() / water.profile.len() as f64;
        let c = &scenario.control;
        let m = &scenario.transducer.mounting_deg;
        let [roll, pitch, heading] = [m.roll, m.pitch, m.heading].map(f64::to_radians);
        let nominal = rotation::from_attitude(roll, pitch, heading);
        let t = &scenario.truth.correction_deg;
        let turn = Vector3::new(t.pitch, t.roll, t.yaw).map(f64::to_radians);
        let sigmas = [c.tilt_sigma_deg, c.tilt_sigma_deg, c.azimuth_sigma_deg];
        Self {
            beacons,
            surveyed,
            transducer_m,
            mounting: rotation::exp(&turn) * nominal,
            nominal,
            scale: speed.normal(water.sigma_m_s / middle),
            datum_rad: three(&mut draws(Source::Datum), sigmas.map(f64::to_radians)),
            water: SoundSpeedProfile {
                depth_m: water.profile.iter().map(|s| s[0]).collect(),
                speed_m_s: water.profile.iter().map(|s| s[1]).collect(),
            },
        }
    }
}

/// The patent's square with its centre as check point, and the beacons of the list; positions from the true transducer.
fn layout(scenario: &Scenario) -> Vec<(String, Role, Vector3<f64>)> {
    let b = &scenario.beacons;
    let up = scenario.transducer.depth_m - b.water_depth_m;
    let centre = Vector3::new(b.centre_m[0], b.centre_m[1], up);
    let mut all = vec![];
    if b.centre_to_corner_m > 0.0 {
        for k in 0..4 {
            let azimuth = (b.azimuth_deg + 90.0 * f64::from(k)).to_radians();
            let corner =
                Vector3::new(math::sin(azimuth), math::cos(azimuth), 0.0) * b.centre_to_corner_m;
            all.push((format!("B{}", k + 1), Role::Common, centre + corner));
        }
        all.push(("B5".to_owned(), Role::Check, centre));
    }
    let role = |check| if check { Role::Check } else { Role::Common };
    let own = b.beacon.iter();
    all.extend(own.map(|o| (o.name.clone(), role(o.check), Vector3::from(o.position_m))));
    all
}

fn truth(reality: &Reality, gross_fixes: Vec<u32>) -> Truth {
    let correction = rotation::log(&(reality.mounting * reality.nominal.transpose())).map(degrees);
    let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]));
    let beacon = |(name, _, place): &(String, Role, Vector3<f64>)| TrueBeacon {
        name: name.clone(),
        position_m: (*place).into(),
    };
    Truth {
        rotation_matrix: rows(&reality.mounting),
        nominal_rotation_matrix: rows(&reality.nominal),
        correction_deg: crate::simulate::truth::TrueCorrection {
            pitch: correction.x,
            roll: correction.y,
            yaw: correction.z,
        },
        transducer_m: reality.transducer_m.into(),
        beacons_m: reality.beacons.iter().map(beacon).collect(),
        range_scale: reality.scale,
        datum_deg: reality.datum_rad.map(degrees).into(),
        gross_fixes,
    }
}

fn at(model: &Oscillation, time_s: f64) -> f64 {
    let wave = |w: &Wave| {
        let phase = std::f64::consts::TAU * (time_s - START_S) / w.period_s;
        w.amplitude * math::sin(phase + w.phase_deg.to_radians())
    };
    (model.mean + model.wave.iter().map(wave).sum::<f64>()).to_radians()
}

/// True roll, pitch, heading (radians) in the attitude sensor's own level frame.
fn true_attitude(scenario: &Scenario, time_s: f64) -> [f64; 3] {
    let m = &scenario.motion;
    [&m.roll, &m.pitch, &m.heading].map(|model| at(model, time_s))
}

fn duration_s(scenario: &Scenario) -> f64 {
    let beacons = layout(scenario).len() as f64;
    f64::from(scenario.fixes.per_beacon) * beacons / scenario.fixes.rate_hz
}

fn attitude(scenario: &Scenario, sources: &Sources, seed: u64) -> (Trajectory, Vec<[f64; 3]>) {
    let a = &scenario.attitude;
    let mut tilt = Draws::new(seed, Source::RollPitch, sources);
    let mut north = Draws::new(seed, Source::Heading, sources);
    let count = (duration_s(scenario) * a.rate_hz).ceil() as usize + 3;
    let time_s: Vec<f64> = (0..count)
        .map(|k| START_S + (k as f64 - 1.0) / a.rate_hz)
        .collect();
    let errors =
        |sigma_deg: f64| GaussMarkov::new(sigma_deg.to_radians(), a.attitude_correlation_time_s);
    let mut tilts = [0, 1].map(|_| errors(a.roll_pitch_sigma_deg));
    let mut turn = errors(a.heading_sigma_deg);
    let noisy = |time_s: &f64| {
        let [roll, pitch, heading] = true_attitude(scenario, *time_s);
        let [of_roll, of_pitch] = tilts.each_mut().map(|e| e.at(*time_s, |s| tilt.normal(s)));
        let of_heading = turn.at(*time_s, |s| north.normal(s));
        [roll + of_roll, pitch + of_pitch, heading + of_heading]
    };
    let angles: Vec<[f64; 3]> = time_s.iter().map(noisy).collect();
    let matrices = angles
        .iter()
        .map(|[r, p, h]| rotation::from_attitude(*r, *p, *h))
        .collect();
    let zero = vec![Vector3::zeros(); count];
    let gap_s = GAP_RECORDS / a.rate_hz;
    (Trajectory::new(time_s, zero, matrices, None, gap_s), angles)
}

/// Travel times and directions of all fixes, beacons in turn, and which are gross.
fn fixes(
    scenario: &Scenario,
    reality: &Reality,
    sources: &Sources,
    seed: u64,
) -> (Fixes, Vec<u32>) {
    let f = &scenario.fixes;
    let rays: Vec<(Vector3<f64>, f64)> = reality
        .beacons
        .iter()
        .map(|(_, _, place)| ray(scenario, reality, &(place - reality.transducer_m)))
        .collect();
    let noise = fix_noise(scenario);
    let mut out = Fixes {
        time_s: vec![],
        beacon: vec![],
        travel_time_s: vec![],
        direction: vec![],
        speed_m_s: f.nominal_speed_m_s,
        noise,
    };
    let mut range = Draws::new(seed, Source::Range, sources);
    let mut angle = Draws::new(seed, Source::Angle, sources);
    let mut gross = Draws::new(seed, Source::GrossErrors, sources);
    let mut wrong = vec![];
    for k in 0..f.per_beacon as usize * rays.len() {
        let (time_s, beacon) = (START_S + k as f64 / f.rate_hz, k % rays.len());
        let (in_level, true_time_s) = rays[beacon];
        let [roll, pitch, heading] = true_attitude(scenario, time_s);
        let level_from_body =
            rotation::exp(&reality.datum_rad) * rotation::from_attitude(roll, pitch, heading);
        let exact = (level_from_body * reality.mounting).tr_mul(&in_level);
        let range_m = true_time_s * f.nominal_speed_m_s / (1.0 + reality.scale);
        let measured_m = range_m + range.normal(noise.range_at(range_m));
        let offsets = [angle.normal(noise.angle_rad), angle.normal(noise.angle_rad)];
        let mut fix = (measured_m, moved(&exact, &noise.axes(&exact), offsets));
        if let Some(error) = gross_error(scenario, &mut gross) {
            fix = spoiled(&fix, &error);
            wrong.push(k as u32);
        }
        out.time_s.push(time_s);
        out.beacon.push(beacon as u32);
        out.travel_time_s.push(fix.0 / f.nominal_speed_m_s);
        out.direction.push(fix.1);
    }
    (out, wrong)
}

fn fix_noise(scenario: &Scenario) -> FixNoise {
    let f = &scenario.fixes;
    FixNoise {
        range_m: f.range_sigma_m,
        range_relative: f.range_sigma_ppm * 1e-6,
        angle_rad: f.angle_sigma_deg.to_radians(),
        model: f.angle_model,
    }
}

/// Launch direction in the level frame and one-way time of the ray to a place seen from the transducer.
fn ray(scenario: &Scenario, reality: &Reality, way_m: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let horizontal_m = math::hypot(way_m.x, way_m.y);
    let found = water::arrival(
        &reality.water,
        scenario.transducer.depth_m,
        horizontal_m,
        -way_m.z,
    );
    let (sine, cosine) = math::sin_cos(found.angle_rad);
    let outward = if horizontal_m > 0.0 {
        Vector3::new(way_m.x, way_m.y, 0.0) / horizontal_m
    } else {
        Vector3::zeros()
    };
    (outward * sine - Vector3::z() * cosine, found.time_s)
}

/// The unit direction whose components along two axes differ from the exact ones by `offsets`, on the same side.
fn moved(exact: &Vector3<f64>, axes: &[Vector3<f64>; 2], offsets: [f64; 2]) -> Vector3<f64> {
    let third = axes[0].cross(&axes[1]);
    let (a, b) = (
        exact.dot(&axes[0]) + offsets[0],
        exact.dot(&axes[1]) + offsets[1],
    );
    let c = (1.0 - a * a - b * b)
        .max(0.0)
        .sqrt()
        .copysign(exact.dot(&third));
    (axes[0] * a + axes[1] * b + third * c).normalize()
}

/// Excess of a range (m) and a turn of the direction (rad).
struct GrossError {
    range_m: f64,
    turn_rad: Vector3<f64>,
}

fn gross_error(scenario: &Scenario, draws: &mut Draws) -> Option<GrossError> {
    let d = &scenario.disturbance;
    let chance = draws.uniform();
    let mut sided = |most: f64| (2.0 * draws.uniform() - 1.0) * most;
    let angle = d.gross_angle_deg.to_radians();
    let turn_rad = Vector3::new(sided(angle), sided(angle), sided(angle));
    let range_m = sided(d.gross_range_m).abs();
    (chance < d.gross_fraction * draws.factor()).then_some(GrossError { range_m, turn_rad })
}

fn spoiled((range_m, direction): &(f64, Vector3<f64>), error: &GrossError) -> (f64, Vector3<f64>) {
    (
        range_m + error.range_m,
        rotation::exp(&error.turn_rad) * direction,
    )
}

fn campaign(
    scenario: &Scenario,
    reality: &Reality,
    attitude: Trajectory,
    fixes: Fixes,
) -> UsblCampaign {
    let covariance = |sigma: [f64; 3]| Matrix3::from_diagonal(&Vector3::from(sigma.map(|s| s * s)));
    let (water, a, c) = (&scenario.sound_speed, &scenario.attitude, &scenario.control);
    let points = reality.beacons.iter().zip(&reality.surveyed);
    let beacon =
        |((name, role, _), surveyed): (&(String, Role, Vector3<f64>), &Vector3<f64>)| Beacon {
            point: ControlPoint {
                name: name.clone(),
                position_m: *surveyed,
                covariance_m2: covariance(scenario.beacons.sigma_m),
            },
            role: *role,
        };
    let middle = reality.water.speed_m_s.iter().sum::<f64>() / reality.water.speed_m_s.len() as f64;
    UsblCampaign {
        transducer: ControlPoint {
            name: "transducer".to_owned(),
            position_m: Vector3::zeros(),
            covariance_m2: covariance(scenario.transducer.sigma_m),
        },
        beacons: points.map(beacon).collect(),
        fixes,
        attitude,
        attitude_noise: AttitudeNoise {
            roll_pitch_rad: a.roll_pitch_sigma_deg.to_radians(),
            heading_rad: a.heading_sigma_deg.to_radians(),
            correlation_time_s: a.attitude_correlation_time_s,
        },
        nominal: reality.nominal,
        sound_speed: SoundSpeed::Profile(reality.water.clone()),
        sound_speed_relative: water.sigma_m_s / middle,
        transducer_depth_m: scenario.transducer.depth_m,
        datum: DatumSigma {
            tilt_rad: c.tilt_sigma_deg.to_radians(),
            azimuth_rad: c.azimuth_sigma_deg.to_radians(),
        },
    }
}
