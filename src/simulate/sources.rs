//! The error sources of a simulated survey, each with its own random stream and its own switch.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use serde::{Deserialize, Serialize};

use crate::stats::stream;

/// What can be wrong with a survey. The discriminant is the source's random stream: never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// White INS position noise per record.
    PositionWhite = 1,
    /// Gauss-Markov INS position drift.
    PositionDrift = 2,
    /// White roll and pitch noise per record.
    RollPitch = 3,
    /// White heading noise per record.
    Heading = 4,
    /// Slow (Gauss-Markov) heading error.
    HeadingDrift = 5,
    /// Unknown constant delay of the multibeam's stamps.
    Latency = 6,
    /// Jitter of the multibeam's stamps, per ping.
    LatencyJitter = 7,
    /// Range noise of the scanner.
    LaserRange = 8,
    /// Angle noise of the scanner, in its plane.
    LaserAngle = 9,
    /// Residual boresight error of the scanner.
    LaserBoresight = 10,
    /// Residual lever-arm error of the scanner.
    LaserLeverArm = 11,
    /// Range noise of the multibeam.
    SonarRange = 12,
    /// Across-track angle noise of the multibeam.
    SonarAngle = 13,
    /// Along-track angle noise of the multibeam.
    SonarAlongAngle = 14,
    /// Constant sound-speed error, as a scale of the ranges.
    SoundSpeed = 15,
    /// Sound-speed gradient that the survey does not know of.
    SoundSpeedGradient = 16,
    /// The target's faces off their design positions.
    TargetOffsets = 17,
    /// Roughness of the target's faces.
    TargetFlatness = 18,
    /// The prior pose of the target.
    TargetPose = 19,
    /// Gross range errors of soundings.
    GrossErrors = 20,
    /// Echoes and returns from nothing: fish, bubbles, spray.
    Clutter = 21,
    /// Late returns after a reflection, both sensors.
    Multipath = 22,
    /// Solid things that stand or pass between boat and target.
    Bodies = 23,
}

impl Source {
    /// Every source, in the order of the streams.
    pub const ALL: [Self; 23] = [
        Self::PositionWhite,
        Self::PositionDrift,
        Self::RollPitch,
        Self::Heading,
        Self::HeadingDrift,
        Self::Latency,
        Self::LatencyJitter,
        Self::LaserRange,
        Self::LaserAngle,
        Self::LaserBoresight,
        Self::LaserLeverArm,
        Self::SonarRange,
        Self::SonarAngle,
        Self::SonarAlongAngle,
        Self::SoundSpeed,
        Self::SoundSpeedGradient,
        Self::TargetOffsets,
        Self::TargetFlatness,
        Self::TargetPose,
        Self::GrossErrors,
        Self::Clutter,
        Self::Multipath,
        Self::Bodies,
    ];
}

/// Factors by which the scenario's errors are scaled, source by source: 1 where nothing is said, 0 switches a source off.
///
/// Only what really happens is scaled; the standard deviations that the survey claims stay as they are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Sources(BTreeMap<Source, f64>);

impl Sources {
    /// Nothing goes wrong: every factor 0.
    #[must_use]
    pub fn none() -> Self {
        Self(
            Source::ALL
                .into_iter()
                .map(|source| (source, 0.0))
                .collect(),
        )
    }

    /// Only these sources act, as the scenario says.
    #[must_use]
    pub fn only(sources: &[Source]) -> Self {
        sources
            .iter()
            .fold(Self::none(), |all, &s| all.with(s, 1.0))
    }

    /// The same with one factor changed.
    #[must_use]
    pub fn with(mut self, source: Source, factor: f64) -> Self {
        self.0.insert(source, factor);
        self
    }

    /// The factor of a source.
    #[must_use]
    pub fn factor(&self, source: Source) -> f64 {
        self.0.get(&source).copied().unwrap_or(1.0)
    }

    /// What was said, source by source.
    pub fn iter(&self) -> impl Iterator<Item = (Source, f64)> {
        self.0.iter().map(|(&source, &factor)| (source, factor))
    }
}

/// Words of the stream that each row (ping, scan line) may use; rows start at fixed places, so that a row's draws
/// do not depend on how many the rows before it took.
const WORDS_PER_ROW: u128 = 1 << 18;

/// The random numbers of one source.
pub(super) struct Draws {
    generator: ChaCha8Rng,
    factor: f64,
}

impl Draws {
    /// The stream of `source` under `seed`, scaled by the source's factor.
    pub(super) fn new(seed: u64, source: Source, sources: &Sources) -> Self {
        Self {
            generator: stream(seed, source as u64),
            factor: sources.factor(source),
        }
    }

    /// Goes to the beginning of a row.
    pub(super) fn seek(&mut self, row: u64) {
        self.generator.set_word_pos(u128::from(row) * WORDS_PER_ROW);
    }

    /// The source's factor.
    pub(super) fn factor(&self) -> f64 {
        self.factor
    }

    /// A normal error with this standard deviation, scaled by the source's factor.
    pub(super) fn normal(&mut self, sigma: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.generator);
        unit * sigma * self.factor
    }

    /// A uniform number in [0, 1), not scaled.
    pub(super) fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.generator)
    }
}

/// A stationary first-order Gauss-Markov process, discretised exactly: `x' = x exp(-dt/tau) + sigma sqrt(1 - exp(-2 dt/tau)) w`.
pub(super) struct GaussMarkov {
    sigma: f64,
    correlation_time_s: f64,
    state: Option<(f64, f64)>,
}

impl GaussMarkov {
    /// With this standard deviation and correlation time (seconds).
    pub(super) fn new(sigma: f64, correlation_time_s: f64) -> Self {
        Self {
            sigma,
            correlation_time_s,
            state: None,
        }
    }

    /// The value at a time not before the last one.
    pub(super) fn at(&mut self, time_s: f64, draws: &mut Draws) -> f64 {
        let fresh = draws.normal(self.sigma);
        let value = match self.state {
            None => fresh,
            Some((before_s, value)) => {
                let keep = (-(time_s - before_s) / self.correlation_time_s).exp();
                value * keep + fresh * (1.0 - keep * keep).sqrt()
            }
        };
        self.state = Some((time_s, value));
        value
    }
}
