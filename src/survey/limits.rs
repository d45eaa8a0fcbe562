//! Limits of values that sections of several procedures share.

use super::schema::Kind;
pub use super::schema::Limits;

/// Limits with their words.
#[must_use]
pub const fn limits(min: f64, max: f64, expected: &'static str) -> Limits {
    Limits { min, max, expected }
}

/// The least number above 0.
pub const ABOVE: f64 = f64::MIN_POSITIVE;
/// A latitude.
pub const LATITUDE: Limits = limits(-90.0, 90.0, "degrees from -90 to 90");
/// Any angle.
pub const TURN: Limits = limits(-360.0, 360.0, "degrees from -360 to 360");
/// An ellipsoidal height.
pub const HEIGHT: Limits = limits(-12_000.0, 12_000.0, "metres from -12000 to 12000");
/// A shift of stamps.
pub const OFFSET_S: Limits = limits(-1e10, 1e10, "seconds within 1e10");
/// A span of time.
pub const DURATION: Limits = limits(ABOVE, 1e6, "seconds above 0 and up to 1000000");
/// A robust kernel's width.
pub const WIDTH: Limits = limits(0.5, 1000.0, "sigmas from 0.5 to 1000");
/// A gate of the association.
pub const GATE: Limits = limits(
    4.0,
    1000.0,
    "sigmas from 4 (a narrower gate makes the standard deviations too small) to 1000",
);
/// A robust kernel's name.
pub const KERNEL: Kind =
    Kind::OneOf(&["least-squares", "huber", "cauchy", "tukey", "geman-mcclure"]);
/// An ellipsoid's name.
pub const ELLIPSOID: Kind = Kind::OneOf(&["WGS84", "CGCS2000"]);
/// What becomes of rows whose values cannot be.
pub const INVALID: Kind = Kind::OneOf(&["error", "drop"]);
/// What becomes of observations that the trajectory does not cover.
pub const OUTSIDE: Kind = Kind::OneOf(&["error", "drop"]);
/// A speed of sound.
pub const SPEED: Limits = crate::formats::sound_speed_csv::SPEED;
/// What the times of a file beside the sounder's are.
pub const TIMES: Kind = Kind::OneOf(&["utc", "gps", "gps-week", "utc-week", "gps-day", "utc-day"]);
/// A GPS week.
pub const WEEK: Kind = Kind::Count(limits(0.0, 10_000.0, "0 to 10000"));
/// GPS minus UTC.
pub const LEAP_S: Kind = Kind::Number(limits(0.0, 100.0, "seconds from 0 to 100"));
/// The number of a sounder's head.
pub const HEAD: Kind = Kind::Count(limits(0.0, 4.3e9, "0 to 4294967295"));
