//! The error sources of a simulated survey, each with its own random stream and its own switch.

use crate::math;
use serde::{Deserialize, Serialize};

use super::switches::{Factors, Sourced};

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

impl Sourced for Source {
    fn all() -> &'static [Self] {
        &Self::ALL
    }

    fn stream(self) -> u64 {
        self as u64
    }
}

/// Factors of the pool's error sources.
pub type Sources = Factors<Source>;

/// A stationary first-order Gauss-Markov process, discretised exactly: `x' = x exp(-dt/tau) + sigma sqrt(1 - exp(-2 dt/tau)) w`.
pub(crate) struct GaussMarkov {
    sigma: f64,
    correlation_time_s: f64,
    state: Option<(f64, f64)>,
}

impl GaussMarkov {
    /// With this standard deviation and correlation time (seconds; 0: white noise).
    pub(crate) fn new(sigma: f64, correlation_time_s: f64) -> Self {
        Self {
            sigma,
            correlation_time_s,
            state: None,
        }
    }

    /// The value at a time not before the last one; `normal` draws an error with a standard deviation.
    pub(crate) fn at(&mut self, time_s: f64, normal: impl FnOnce(f64) -> f64) -> f64 {
        let fresh = normal(self.sigma);
        let value = match self.state {
            None => fresh,
            Some((before_s, value)) => {
                let keep = math::exp(-(time_s - before_s) / self.correlation_time_s);
                value * keep + fresh * (1.0 - keep * keep).sqrt()
            }
        };
        self.state = Some((time_s, value));
        value
    }
}
