//! How things truly are in a simulated rail calibration, and the answer as `truth.json` gives it.

use nalgebra::{Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::super::observed::Profiler;
use super::super::profile::RailProfile;
use super::scenario::{Angles, RailScenario, Turn};
use super::sources::RailSource;
use crate::geometry::rotation;
use crate::observe::Mounting;
use crate::simulate::switches::Draws;

/// The true state of everything.
#[derive(Clone, Debug, PartialEq)]
pub struct RailReality {
    /// True mountings.
    pub mountings: Vec<Mounting>,
    /// Tilt of the table (x, y) and zero of its turn (z), radians, about the level axes.
    pub level_rad: Vector3<f64>,
    /// The turn from north to the rail's nominal heading, at which the table's zero stands.
    pub rail_heading_zero: Matrix3<f64>,
    /// Seat of the beam, radians, about the body's axes.
    pub seating_rad: Vector3<f64>,
    /// True minus recorded turns, radians: about the vertical, about the lateral axis.
    pub table_error_rad: Vec<[f64; 2]>,
    /// True centre of rotation in the body, metres.
    pub pivot_body_m: Vector3<f64>,
    /// The same in the rail's cross-section, metres.
    pub pivot_rail_m: Vector2<f64>,
    /// How far the table's lateral axis lies in front of its vertical one, metres.
    pub axes_gap_m: f64,
    /// True orientation of the rail, rail frame into level frame.
    pub rail_rotation: Matrix3<f64>,
    /// Each element off the standard profile, metres.
    pub profile_m: Vec<f64>,
}

fn attitude(a: &Angles) -> Matrix3<f64> {
    let [roll, pitch, heading] = [a.roll, a.pitch, a.heading].map(f64::to_radians);
    rotation::from_attitude(roll, pitch, heading)
}

impl RailReality {
    /// Draws everything that the scenario leaves to chance.
    pub(super) fn draw(
        scenario: &RailScenario,
        rail: &RailProfile,
        profilers: &[Profiler],
        seed: u64,
    ) -> Self {
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let three = |source, sigma: Vector3<f64>| {
            let mut d = draws(source);
            sigma.map(|s| d.normal(s))
        };
        let t = &scenario.table;
        let (level, zero, seat) = (
            t.level_sigma_deg.to_radians(),
            t.zero_sigma_deg.to_radians(),
            t.seating_sigma_deg.to_radians(),
        );
        let rail_error = three(
            RailSource::RailAttitude,
            Vector3::from(scenario.rail.orientation_sigma_deg).map(f64::to_radians),
        );
        let pivot_rail = three(RailSource::PivotRail, Vector3::repeat(t.pivot_rail_sigma_m));
        let mut table = draws(RailSource::Table);
        let mut profile = draws(RailSource::Profile);
        let sigma = t.angle_sigma_deg.to_radians();
        let heading = Vector3::z() * -scenario.rail.orientation_deg.heading.to_radians();
        Self {
            mountings: mountings(scenario, profilers, draws(RailSource::Along)),
            level_rad: three(RailSource::Level, Vector3::new(level, level, zero)),
            rail_heading_zero: rotation::exp(&heading),
            seating_rad: three(RailSource::Seating, Vector3::repeat(seat)),
            table_error_rad: scenario
                .positions_deg()
                .iter()
                .map(|_| [table.normal(sigma), table.normal(sigma)])
                .collect(),
            pivot_body_m: Vector3::from(t.pivot_body_m)
                + three(RailSource::PivotBody, Vector3::repeat(t.pivot_body_sigma_m)),
            pivot_rail_m: Vector2::from(t.pivot_rail_m) + pivot_rail.xy(),
            axes_gap_m: draws(RailSource::AxesGap).normal(t.axes_gap_sigma_m),
            rail_rotation: rotation::exp(&rail_error) * attitude(&scenario.rail.orientation_deg),
            profile_m: rail
                .elements
                .iter()
                .map(|_| profile.normal(scenario.rail.profile_sigma_m))
                .collect(),
        }
    }
}

fn mountings(scenario: &RailScenario, profilers: &[Profiler], mut along: Draws) -> Vec<Mounting> {
    let pairs = scenario.profiler.iter().zip(profilers);
    pairs
        .map(|(section, profiler)| {
            let c = &section.correction_deg;
            let turn = Vector3::new(c.pitch, c.roll, c.yaw).map(f64::to_radians);
            let mut arm = Vector3::from(section.lever_arm_correction_m);
            arm.y += along.normal(section.along_sigma_m);
            profiler.nominal.corrected(&turn, &arm)
        })
        .collect()
}

/// What a calibration should have found: `truth.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RailTruth {
    /// One entry per profiler.
    pub profilers: Vec<ProfilerTruth>,
}

/// The true mounting of one profiler.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfilerTruth {
    /// Its name.
    pub name: String,
    /// True rotation, profiler frame into body, row by row.
    pub rotation_matrix: [[f64; 3]; 3],
    /// True lever arm, metres.
    pub lever_arm_m: [f64; 3],
    /// `log(R R_nominal^T)`, degrees.
    pub correction_deg: Turn,
    /// True minus nominal lever arm, metres.
    pub lever_arm_correction_m: [f64; 3],
}

impl RailTruth {
    /// The answer to a reality.
    #[must_use]
    pub fn of(reality: &RailReality, profilers: &[Profiler]) -> Self {
        let pairs = reality.mountings.iter().zip(profilers);
        let profilers = pairs.map(|(mounting, profiler)| {
            let r = mounting.rotation;
            let turn = mounting
                .correction_from(&profiler.nominal)
                .map(f64::to_degrees);
            ProfilerTruth {
                name: profiler.name.clone(),
                rotation_matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)])),
                lever_arm_m: mounting.lever_arm_m.into(),
                correction_deg: Turn {
                    pitch: turn.x,
                    roll: turn.y,
                    yaw: turn.z,
                },
                lever_arm_correction_m: (mounting.lever_arm_m - profiler.nominal.lever_arm_m)
                    .into(),
            }
        });
        Self {
            profilers: profilers.collect(),
        }
    }
}

impl ProfilerTruth {
    /// The true mounting.
    #[must_use]
    pub fn mounting(&self) -> Mounting {
        Mounting {
            rotation: Matrix3::from_row_iterator(self.rotation_matrix.into_iter().flatten()),
            lever_arm_m: Vector3::from(self.lever_arm_m),
        }
    }
}
