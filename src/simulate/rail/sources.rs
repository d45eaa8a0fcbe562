//! The error sources of a simulated rail calibration, each with its own random stream and its own switch.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use serde::{Deserialize, Serialize};

use crate::stats::stream;

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
}

impl RailSource {
    /// Every source, in the order of the streams, with its title and what shares one draw.
    pub const ALL: [(Self, &'static str, &'static str); 14] = [
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
            "a fraction of the points, uniform before the rail",
        ),
        (
            Self::Occlusion,
            "occlusion",
            "a fraction of the profiles lose a run of rays",
        ),
    ];
}

/// Factors by which the scenario's errors are scaled, source by source: 1 where nothing is said, 0 switches a source off.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RailSources(BTreeMap<RailSource, f64>);

impl RailSources {
    /// Nothing goes wrong: every factor 0.
    #[must_use]
    pub fn none() -> Self {
        Self(RailSource::ALL.into_iter().map(|s| (s.0, 0.0)).collect())
    }

    /// Only these sources act, as the scenario says.
    #[must_use]
    pub fn only(sources: &[RailSource]) -> Self {
        sources
            .iter()
            .fold(Self::none(), |all, &s| all.with(s, 1.0))
    }

    /// The same with one factor changed.
    #[must_use]
    pub fn with(mut self, source: RailSource, factor: f64) -> Self {
        self.0.insert(source, factor);
        self
    }

    /// The factor of a source.
    #[must_use]
    pub fn factor(&self, source: RailSource) -> f64 {
        self.0.get(&source).copied().unwrap_or(1.0)
    }

    /// Factors that cannot be, in words.
    pub(super) fn faults(&self) -> Vec<String> {
        let bad = self
            .0
            .iter()
            .filter(|(_, f)| !(f.is_finite() && **f >= 0.0));
        bad.map(|(s, f)| format!("sources.{s:?}: found {f}, expected a number from 0"))
            .collect()
    }
}

/// Words of the stream that each row may use.
const WORDS_PER_ROW: u128 = 1 << 18;

/// The random numbers of one source.
pub(super) struct Draws {
    generator: ChaCha8Rng,
    factor: f64,
}

impl Draws {
    pub(super) fn new(seed: u64, source: RailSource, sources: &RailSources) -> Self {
        Self {
            generator: stream(seed, source as u64),
            factor: sources.factor(source),
        }
    }

    /// Goes to the beginning of a row, so that a row's draws do not depend on the rows before.
    pub(super) fn seek(&mut self, row: u64) {
        self.generator.set_word_pos(u128::from(row) * WORDS_PER_ROW);
    }

    /// A normal error with this standard deviation, scaled by the source's factor.
    pub(super) fn normal(&mut self, sigma: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.generator);
        unit * sigma * self.factor
    }

    /// Whether something of this probability (scaled by the source's factor) happens.
    pub(super) fn happens(&mut self, probability: f64) -> bool {
        self.uniform() < probability * self.factor
    }

    /// A uniform number in [0, 1), not scaled.
    pub(super) fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.generator)
    }
}
