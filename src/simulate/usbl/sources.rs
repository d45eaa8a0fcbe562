//! The error sources of a simulated USBL survey, each with its own random stream and its own switch.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use serde::{Deserialize, Serialize};

use crate::stats::stream;

/// What can be wrong with a survey. The discriminant is the source's random stream: never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Survey of the beacons.
    BeaconSurvey = 101,
    /// Survey of the transducer.
    TransducerSurvey = 102,
    /// Range noise of the fixes.
    Range = 103,
    /// Angle noise of the fixes.
    Angle = 104,
    /// White roll and pitch noise of the attitude sensor.
    RollPitch = 105,
    /// White heading noise of the attitude sensor.
    Heading = 106,
    /// Constant error of the sound speed.
    SoundSpeed = 107,
    /// Constant turn between control and attitude sensor: deflection of the vertical, orientation of the control.
    Datum = 108,
    /// Gross fixes.
    GrossErrors = 109,
}

impl Source {
    /// Every source, in the order of the streams.
    pub const ALL: [Self; 9] = [
        Self::BeaconSurvey,
        Self::TransducerSurvey,
        Self::Range,
        Self::Angle,
        Self::RollPitch,
        Self::Heading,
        Self::SoundSpeed,
        Self::Datum,
        Self::GrossErrors,
    ];

    /// In words, for tables.
    #[must_use]
    pub fn describe(self) -> &'static str {
        match self {
            Self::BeaconSurvey => "survey of the beacons",
            Self::TransducerSurvey => "survey of the transducer",
            Self::Range => "range noise of the fixes",
            Self::Angle => "angle noise of the fixes",
            Self::RollPitch => "roll and pitch noise of the attitude sensor",
            Self::Heading => "heading noise of the attitude sensor",
            Self::SoundSpeed => "constant error of the sound speed",
            Self::Datum => "deflection of the vertical and orientation of the control",
            Self::GrossErrors => "gross fixes",
        }
    }
}

/// Factors by which the scenario's errors are scaled, source by source: 1 where nothing is said, 0 switches a source off. The
/// standard deviations that the survey claims stay as they are.
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
}

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
