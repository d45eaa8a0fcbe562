//! Sections and values of a survey file that more than one procedure has.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::geometry::Geodetic;
use crate::observe::{Mounting, Outside};
use crate::units::radians;

/// A geodetic position in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Ellipsoidal height, metres.
    pub height_m: f64,
}

impl Origin {
    /// The position in radians and metres.
    #[must_use]
    pub fn geodetic(&self) -> Geodetic {
        Geodetic {
            latitude_rad: radians(self.latitude_deg),
            longitude_rad: radians(self.longitude_deg),
            height_m: self.height_m,
        }
    }
}

/// `outside = "error"` or `"drop"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutsideRule {
    /// An observation without position is an error.
    #[default]
    Error,
    /// It is dropped and counted.
    Drop,
}

impl From<OutsideRule> for Outside {
    fn from(rule: OutsideRule) -> Self {
        match rule {
            OutsideRule::Error => Self::Error,
            OutsideRule::Drop => Self::Drop,
        }
    }
}

/// Angles of a mounting in a file, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountingAngles {
    /// Roll, positive starboard down.
    pub roll: f64,
    /// Pitch, positive bow up.
    pub pitch: f64,
    /// Heading, clockwise.
    pub heading: f64,
}

impl MountingAngles {
    /// The mounting with these angles and a lever arm (metres).
    #[must_use]
    pub fn mounting(&self, lever_arm_m: [f64; 3]) -> Mounting {
        Mounting::from_angles(
            radians(self.roll),
            radians(self.pitch),
            radians(self.heading),
            Vector3::from(lever_arm_m),
        )
    }
}

/// A UTM zone: a number, negative in the south, or a text such as "50N".
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum UtmZone {
    /// 1 to 60, or -1 to -60.
    Number(i8),
    /// As "50N" or "33S".
    Name(String),
}

impl UtmZone {
    /// The zone that a text such as "50N" or "33S" names, negative in the south.
    #[must_use]
    pub fn parse(text: &str) -> Option<i8> {
        let (digits, sign) = match text.strip_suffix('S') {
            Some(digits) => (digits, -1),
            None => (text.strip_suffix('N')?, 1),
        };
        let zone: i8 = digits.parse().ok()?;
        (1..=60).contains(&zone).then_some(sign * zone)
    }

    /// The zone, negative in the south.
    #[must_use]
    pub fn number(&self) -> Option<i8> {
        match self {
            Self::Number(zone) => Some(*zone),
            Self::Name(text) => Self::parse(text),
        }
    }
}
