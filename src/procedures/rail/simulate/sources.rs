//! The error sources of a simulated rail calibration, each with its own random stream and its own switch.

use serde::{Deserialize, Serialize};

use crate::simulate::switches::{Draws, Factors, Sourced};

/// What can be wrong. The discriminant is the source's random stream: never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RailSource {
    /// Noise of the profilers' lateral coordinate.
    Lateral = 101,
    /// Noise of the profilers' other coordinate.
    Vertical = 102,
    /// White roll and pitch noise of the INS per record.
    RollPitch = 103,
    /// White heading noise of the INS per record.
    Heading = 104,
    /// The table's angles, per position.
    Table = 105,
    /// Tilt and zero of the table, once.
    Level = 106,
    /// Seat of the beam on the table, once.
    Seating = 107,
    /// The table's centre of rotation in the body, once.
    PivotBody = 108,
    /// The same in the rail's cross-section, once.
    PivotRail = 109,
    /// Orientation of the rail against the INS' level and north, once.
    RailAttitude = 110,
    /// Each element of the rail off its standard profile, once.
    Profile = 111,
    /// Lever arms along the rail off their nominal values, once.
    Along = 112,
    /// Returns from dust before the rail.
    Dust = 113,
    /// Runs of rays that something hides from the rail.
    Occlusion = 114,
    /// Gap between the table's two axes, once.
    AxesGap = 115,
}

impl RailSource {
    /// Every source, in the order of the streams, with its title and what shares one draw.
    pub const ALL: [(Self, &'static str, &'static str); 15] = [
        (Self::Lateral, "profiler, lateral", "normal, per point"),
        (Self::Vertical, "profiler, vertical", "normal, per point"),
        (Self::RollPitch, "INS roll and pitch", "normal, per record"),
        (Self::Heading, "INS heading", "normal, per record"),
        (Self::Table, "table angles", "normal, per position and axis"),
        (Self::Level, "table level and zero", "normal, once per axis"),
        (Self::Seating, "seat of the beam", "normal, once per axis"),
        (
            Self::PivotBody,
            "centre of rotation in the body",
            "normal, once per axis",
        ),
        (
            Self::PivotRail,
            "centre of rotation at the rail",
            "normal, once per axis",
        ),
        (
            Self::RailAttitude,
            "orientation of the rail",
            "normal, once per axis",
        ),
        (
            Self::Profile,
            "rail off its profile",
            "normal, once per element",
        ),
        (
            Self::Along,
            "lever arm along the rail",
            "normal, once per profiler",
        ),
        (
            Self::Dust,
            "dust",
            "a fraction of the points, uniform in front of the rail",
        ),
        (
            Self::Occlusion,
            "occlusion",
            "a fraction of the profiles lose a run of rays",
        ),
        (
            Self::AxesGap,
            "gap between the table's axes",
            "normal, once",
        ),
    ];
}

/// Every source without its words.
static EVERY: [RailSource; 15] = {
    let mut every = [RailSource::Lateral; 15];
    let mut k = 0;
    while k < every.len() {
        every[k] = RailSource::ALL[k].0;
        k += 1;
    }
    every
};

impl Sourced for RailSource {
    fn all() -> &'static [Self] {
        &EVERY
    }

    fn stream(self) -> u64 {
        self as u64
    }
}

/// Factors of the rail's error sources.
pub type RailSources = Factors<RailSource>;

/// Factors that cannot be, in words.
pub(super) fn faults(sources: &RailSources) -> Vec<String> {
    let bad = sources
        .iter()
        .filter(|(_, f)| !(f.is_finite() && *f >= 0.0));
    bad.map(|(s, f)| format!("sources.{s:?}: found {f}, expected a number from 0"))
        .collect()
}

/// Whether something of this probability, scaled by the source's factor, happens; draws one number either way.
pub(super) fn happens(draws: &mut Draws, probability: f64) -> bool {
    draws.uniform() < probability * draws.factor()
}
