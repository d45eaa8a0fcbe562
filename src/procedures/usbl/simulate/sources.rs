//! The error sources of a simulated USBL survey, each with its own random stream and its own switch.

use serde::{Deserialize, Serialize};

use crate::simulate::switches::{Factors, Sourced};

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
    /// Roll and pitch noise of the attitude sensor.
    RollPitch = 105,
    /// Heading noise of the attitude sensor.
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

/// Factors on the sources.
pub type Sources = Factors<Source>;

impl Sourced for Source {
    fn all() -> &'static [Self] {
        &Self::ALL
    }

    fn stream(self) -> u64 {
        self as u64
    }
}
