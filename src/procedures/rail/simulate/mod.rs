//! A rail calibration in memory: profiles cast against the rail while the table turns, with every error source switchable.
//!
//! Rays start at the profiler and end where they hit the extruded rail; the mapping equation of the calibration is not used.

mod cast;
pub mod scenario;
pub mod sources;
pub mod truth;

pub use scenario::RailScenario;
pub use sources::{RailSource, RailSources};
pub use truth::{RailReality, RailTruth};

use nalgebra::{Matrix3, Vector2, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use super::observed::{AttitudeNoise, ProfilePoints, Profiler, RailCampaign, Stand, TableRecord};
use super::profile::RailProfile;
use crate::geometry::rotation;
use crate::math;
use crate::observe::AttitudeRecord;
use crate::simulate::switches::Draws;
use cast::Body;
use scenario::{Angles, ProfilerSection};
use sources::happens;

/// The scenario of `boresight demo rail`.
pub const DEMO: &str = include_str!("../../../../models/scenarios/rail.toml");

/// Time at which the table rests for the first time, seconds.
const START_S: f64 = 100.0;
/// Time that the table takes from one position to the next, seconds.
const TURNING_S: f64 = 5.0;

/// A simulated calibration.
#[derive(Clone, Debug)]
pub struct SimulatedRail {
    /// What was observed.
    pub campaign: RailCampaign,
    /// The answer.
    pub truth: RailTruth,
    /// Everything that was drawn once.
    pub reality: RailReality,
}

/// A scenario that cannot be simulated; every fault at once.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("rail scenario: {}", faults.join("; "))]
pub struct RailScenarioError {
    /// One sentence each: key, found, expected.
    pub faults: Vec<String>,
}

/// Simulates the scenario on a rail; the same seed gives the same campaign on any number of threads.
///
/// # Errors
/// [`RailScenarioError`] with every fault of the scenario.
pub fn simulate(
    scenario: &RailScenario,
    rail: &RailProfile,
    seed: u64,
) -> Result<SimulatedRail, RailScenarioError> {
    let faults = scenario.faults();
    if !faults.is_empty() {
        return Err(RailScenarioError { faults });
    }
    let profilers: Vec<Profiler> = scenario.profiler.iter().map(profiler).collect();
    let reality = RailReality::draw(scenario, rail, &profilers, seed);
    let table = table(scenario);
    let truth = RailTruth::of(&reality, &profilers);
    let campaign = RailCampaign {
        points: points(scenario, rail, &reality, &table, seed),
        attitude: attitude(scenario, &reality, &table, seed),
        attitude_noise: AttitudeNoise {
            roll_pitch_rad: scenario.attitude.roll_pitch_sigma_deg.to_radians(),
            heading_rad: scenario.attitude.heading_sigma_deg.to_radians(),
        },
        stand: stand(scenario),
        profilers,
        table,
    };
    Ok(SimulatedRail {
        campaign,
        truth,
        reality,
    })
}

fn attitude_of(angles: &Angles) -> Matrix3<f64> {
    let [roll, pitch, heading] = [angles.roll, angles.pitch, angles.heading].map(f64::to_radians);
    rotation::from_attitude(roll, pitch, heading)
}

fn profiler(section: &ProfilerSection) -> Profiler {
    Profiler {
        name: section.name.clone(),
        nominal: crate::observe::Mounting {
            rotation: attitude_of(&section.mounting_deg),
            lever_arm_m: Vector3::from(section.lever_arm_m),
        },
        lateral_sigma_m: section.lateral_sigma_m,
        vertical_sigma_m: section.vertical_sigma_m,
        along_sigma_m: section.along_sigma_m,
    }
}

/// What the survey knows of the stand.
#[must_use]
pub fn stand(scenario: &RailScenario) -> Stand {
    let (t, r) = (&scenario.table, &scenario.rail);
    let o = &r.orientation_deg;
    Stand {
        table_sigma_rad: t.angle_sigma_deg.to_radians(),
        level_sigma_rad: t.level_sigma_deg.to_radians(),
        zero_sigma_rad: t.zero_sigma_deg.to_radians(),
        seating_sigma_rad: t.seating_sigma_deg.to_radians(),
        pivot_body_m: Vector3::from(t.pivot_body_m),
        pivot_body_sigma_m: t.pivot_body_sigma_m,
        pivot_rail_m: Vector2::from(t.pivot_rail_m),
        pivot_rail_sigma_m: t.pivot_rail_sigma_m,
        axes_gap_sigma_m: t.axes_gap_sigma_m,
        rail_attitude_rad: [o.roll, o.pitch, o.heading].map(f64::to_radians),
        rail_attitude_sigma_rad: Vector3::from(r.orientation_sigma_deg).map(f64::to_radians),
        profile_sigma_m: r.profile_sigma_m,
    }
}

/// What the table's record says: the turns that were asked for.
fn table(scenario: &RailScenario) -> TableRecord {
    let mut record = TableRecord::default();
    for (k, (heading, pitch)) in scenario.positions_deg().into_iter().enumerate() {
        let from = START_S + k as f64 * (scenario.table.rest_s + TURNING_S);
        record.from_s.push(from);
        record.to_s.push(from + scenario.table.rest_s);
        record.heading_rad.push(heading.to_radians());
        record.pitch_rad.push(pitch.to_radians());
    }
    record
}

/// True attitudes at a position.
struct Attitudes {
    /// The table turned about its vertical axis alone.
    upright: Matrix3<f64>,
    /// The table turned about both of its axes.
    table: Matrix3<f64>,
    /// The body as it sits on it.
    body: Matrix3<f64>,
}

fn attitudes(reality: &RailReality, table: &TableRecord, position: usize) -> Attitudes {
    let error = reality.table_error_rad[position];
    let up = Vector3::z() * -(table.heading_rad[position] + error[0]);
    let lateral = Vector3::x() * (table.pitch_rad[position] + error[1]);
    let upright =
        rotation::exp(&reality.level_rad) * reality.rail_heading_zero * rotation::exp(&up);
    let table = upright * rotation::exp(&lateral);
    Attitudes {
        upright,
        table,
        body: table * rotation::exp(&reality.seating_rad),
    }
}

fn attitude(
    scenario: &RailScenario,
    reality: &RailReality,
    table: &TableRecord,
    seed: u64,
) -> AttitudeRecord {
    let mut tilt = Draws::new(seed, RailSource::RollPitch, &scenario.sources);
    let mut turn = Draws::new(seed, RailSource::Heading, &scenario.sources);
    let (tilt_sigma, turn_sigma) = (
        scenario.attitude.roll_pitch_sigma_deg.to_radians(),
        scenario.attitude.heading_sigma_deg.to_radians(),
    );
    let mut record = AttitudeRecord::default();
    let count = (scenario.table.rest_s * scenario.attitude.rate_hz)
        .floor()
        .max(1.0) as usize;
    for position in 0..table.len() {
        let (roll, pitch, heading) =
            rotation::to_attitude(&attitudes(reality, table, position).body);
        for k in 0..count {
            let rest = table.to_s[position] - table.from_s[position];
            let part = (k as f64 + 0.5) / count as f64;
            record.time_s.push(table.from_s[position] + part * rest);
            record.roll_rad.push(roll + tilt.normal(tilt_sigma));
            record.pitch_rad.push(pitch + tilt.normal(tilt_sigma));
            record.heading_rad.push(heading + turn.normal(turn_sigma));
        }
    }
    record
}

/// One profile of one profiler: its number, its time, and where the body is.
struct Shot {
    position: usize,
    profiler: usize,
    time_s: f64,
}

fn points(
    scenario: &RailScenario,
    rail: &RailProfile,
    reality: &RailReality,
    table: &TableRecord,
    seed: u64,
) -> ProfilePoints {
    let body = Body::new(&rail.elements, &reality.profile_m);
    let mut shots = vec![];
    for position in 0..table.len() {
        for (profiler, section) in scenario.profiler.iter().enumerate() {
            for k in 0..section.profiles {
                let part = (f64::from(k) + 0.5) / f64::from(section.profiles);
                let time_s = table.from_s[position] + part * scenario.table.rest_s;
                shots.push(Shot {
                    position,
                    profiler,
                    time_s,
                });
            }
        }
    }
    shots.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let numbered: Vec<_> = shots.iter().enumerate().collect();
    let profiles: Vec<Vec<Vector2<f64>>> = numbered
        .into_par_iter()
        .map(|(row, shot)| profile(scenario, reality, table, &body, shot, (seed, row as u64)))
        .collect();
    let mut all = ProfilePoints::default();
    for (shot, profile) in shots.iter().zip(profiles) {
        for p in profile {
            all.time_s.push(shot.time_s);
            all.profiler.push(shot.profiler as u32);
            all.y_m.push(p.x);
            all.z_m.push(p.y);
        }
    }
    all
}

/// Casts the rays of one profile, in the profiler's light plane.
fn profile(
    scenario: &RailScenario,
    reality: &RailReality,
    table: &TableRecord,
    body: &Body,
    shot: &Shot,
    (seed, row): (u64, u64),
) -> Vec<Vector2<f64>> {
    let section = &scenario.profiler[shot.profiler];
    let mounting = &reality.mountings[shot.profiler];
    let turned = attitudes(reality, table, shot.position);
    let rail_from_body = reality.rail_rotation.transpose() * turned.body;
    let arm = rail_from_body * (mounting.lever_arm_m - reality.pivot_body_m);
    // the lateral axis turns with the vertical one; a turn about it takes along what lies before it
    let carried = (turned.upright - turned.table).column(1) * reality.axes_gap_m;
    let arm = arm + reality.rail_rotation.transpose() * carried;
    let origin = arm + Vector3::new(reality.pivot_rail_m.x, 0.0, reality.pivot_rail_m.y);
    let rail_from_profiler = rail_from_body * mounting.rotation;
    let mut draws = [
        RailSource::Lateral,
        RailSource::Vertical,
        RailSource::Dust,
        RailSource::Occlusion,
    ]
    .map(|source| Draws::new(seed, source, &scenario.sources));
    draws.iter_mut().for_each(|d| d.seek(row));
    let [lateral, vertical, dust, occlusion] = &mut draws;
    let d = &scenario.disturbance;
    let hidden = hidden(occlusion, d.occlusion_fraction, d.occlusion_width);
    let mut found = vec![];
    for k in 0..section.rays {
        let part = (f64::from(k) + 0.5) / f64::from(section.rays);
        let angle = (part - 0.5) * section.field_deg.to_radians();
        let direction = Vector3::new(math::sin(angle), 0.0, -math::cos(angle));
        let noise = Vector2::new(
            lateral.normal(section.lateral_sigma_m),
            vertical.normal(section.vertical_sigma_m),
        );
        let (dusty, depth) = (
            happens(dust, d.dust_fraction),
            dust.uniform() * d.dust_depth_m,
        );
        let Some(range) = body.hit(&origin, &(rail_from_profiler * direction)) else {
            continue;
        };
        if part >= hidden.0 && part < hidden.1 {
            continue;
        }
        let range = if dusty { range - depth } else { range };
        found.push(Vector2::new(direction.x, direction.z) * range + noise);
    }
    found
}

/// The run of rays (parts of the fan) that something hides in this profile.
fn hidden(draws: &mut Draws, fraction: f64, width: f64) -> (f64, f64) {
    let (happens, place) = (happens(draws, fraction), draws.uniform());
    if !happens {
        return (0.0, 0.0);
    }
    let from = place * (1.0 - width);
    (from, from + width)
}
