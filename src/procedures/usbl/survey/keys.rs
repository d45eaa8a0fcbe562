//! The keys of a USBL survey file, with their limits.

use crate::survey::schema::{Key, Kind, Limits, optional, required};

const fn limits(min: f64, max: f64, expected: &'static str) -> Limits {
    Limits { min, max, expected }
}

const ABOVE: f64 = f64::MIN_POSITIVE;
const TURN: Limits = limits(-360.0, 360.0, "degrees from -360 to 360");
const SIGMA_M: Limits = limits(ABOVE, 100.0, "metres above 0 and up to 100");
const SIGMA_DEG: Limits = limits(ABOVE, 30.0, "degrees above 0 and up to 30");
const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 30.0, "degrees from 0 to 30");
const DURATION: Limits = limits(ABOVE, 1e6, "seconds above 0 and up to 1000000");
const OFFSET_S: Limits = limits(-1e10, 1e10, "seconds within 1e10");

const CONTROL: &[Key] = &[
    required("path", Kind::Text),
    optional("ellipsoid", Kind::OneOf(&["WGS84", "CGCS2000"])),
    optional("tilt_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("azimuth_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
];

const FIXES: &[Key] = &[
    required("path", Kind::Text),
    required("range_sigma_m", Kind::Number(SIGMA_M)),
    optional(
        "range_sigma_ppm",
        Kind::Number(limits(0.0, 1e5, "parts per million from 0 to 100000")),
    ),
    required("angle_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional(
        "angle_model",
        Kind::OneOf(&["direction-cosine", "isotropic"]),
    ),
    optional(
        "nominal_speed_m_s",
        Kind::Number(crate::formats::sound_speed_csv::SPEED),
    ),
    optional(
        "turnaround_s",
        Kind::Number(limits(0.0, 10.0, "seconds from 0 to 10")),
    ),
    optional("time_offset_s", Kind::Number(OFFSET_S)),
];

const ATTITUDE: &[Key] = &[
    required("path", Kind::Text),
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("max_gap_s", Kind::Number(DURATION)),
    optional("outside", Kind::OneOf(&["error", "drop"])),
    optional("time_offset_s", Kind::Number(OFFSET_S)),
];

const MOUNTING: &[Key] = &[
    required("roll", Kind::Number(TURN)),
    required("pitch", Kind::Number(TURN)),
    required("heading", Kind::Number(TURN)),
];

const TRANSDUCER: &[Key] = &[
    optional("mounting_deg", Kind::Table(MOUNTING)),
    optional(
        "depth_m",
        Kind::Number(limits(ABOVE, 11_000.0, "metres above 0 and up to 11000")),
    ),
];

const SOUND_SPEED: &[Key] = &[
    optional(
        "speed_m_s",
        Kind::Number(crate::formats::sound_speed_csv::SPEED),
    ),
    optional("profile", Kind::Text),
    optional(
        "sigma_m_s",
        Kind::Number(limits(0.0, 100.0, "metres per second from 0 to 100")),
    ),
];

const REFERENCE: &[Key] = &[
    optional(
        "max_iterations",
        Kind::Count(limits(1.0, 10_000.0, "1 to 10000")),
    ),
    optional(
        "max_sigma_deg",
        Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180")),
    ),
];

const JOINT: &[Key] = &[
    optional(
        "kernel",
        Kind::OneOf(&["least-squares", "huber", "cauchy", "tukey", "geman-mcclure"]),
    ),
    optional(
        "kernel_width_sigma",
        Kind::Number(limits(0.5, 1000.0, "sigmas from 0.5 to 1000")),
    ),
    optional("transducer", Kind::Flag),
    optional("beacons", Kind::Flag),
    optional("range_scale", Kind::Flag),
    optional("attitude_noise", Kind::Flag),
    optional(
        "gate_sigma",
        Kind::Number(limits(
            4.0,
            1000.0,
            "sigmas from 4 (a narrower gate falsifies the uncertainty) to 1000",
        )),
    ),
    optional(
        "max_sigma_deg",
        Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180")),
    ),
    optional(
        "max_sigma_m",
        Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000")),
    ),
];

/// A USBL survey file.
pub(super) const SURVEY: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(&["usbl"])),
    required("control", Kind::Table(CONTROL)),
    required("fixes", Kind::Table(FIXES)),
    required("attitude", Kind::Table(ATTITUDE)),
    optional("transducer", Kind::Table(TRANSDUCER)),
    optional("sound_speed", Kind::Table(SOUND_SPEED)),
    optional("reference", Kind::Table(REFERENCE)),
    optional("joint", Kind::Table(JOINT)),
];

/// The sections that a scenario hands on to the survey file.
pub(super) const CALIBRATION: &[Key] = &[
    optional("reference", Kind::Table(REFERENCE)),
    optional("joint", Kind::Table(JOINT)),
];
