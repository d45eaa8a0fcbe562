//! The keys of a seabed survey file, with their limits.

use crate::survey::schema::{Key, Kind, Limits, optional, required};

const fn limits(min: f64, max: f64, expected: &'static str) -> Limits {
    Limits { min, max, expected }
}

const SIGMA_M: Limits = limits(1e-6, 10.0, "metres from 1e-6 to 10");
const SIGMA_M_OR_NONE: Limits = limits(0.0, 10.0, "metres from 0 to 10");
const SIGMA_DEG: Limits = limits(1e-6, 10.0, "degrees from 1e-6 to 10");
const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 10.0, "degrees from 0 to 10");
const SECONDS: Limits = limits(1e-3, 1e6, "seconds from 0.001 to 1e6");
const TURN: Limits = limits(-360.0, 360.0, "degrees from -360 to 360");
const PLACE: Limits = limits(-500.0, 500.0, "metres from -500 to 500");
const PART: Limits = limits(0.0, 0.1, "a number from 0 to 0.1");
const COUNT: Limits = limits(1.0, 100_000.0, "1 to 100000");
const TIME: Limits = limits(-1e12, 1e12, "seconds");

const ANGLES: &[Key] = &[
    required("roll", Kind::Number(TURN)),
    required("pitch", Kind::Number(TURN)),
    required("heading", Kind::Number(TURN)),
];

const ORIGIN: &[Key] = &[
    required(
        "latitude_deg",
        Kind::Number(limits(-90.0, 90.0, "degrees from -90 to 90")),
    ),
    required("longitude_deg", Kind::Number(TURN)),
    required(
        "height_m",
        Kind::Number(limits(-1e4, 1e4, "metres from -10000 to 10000")),
    ),
];

const SITE: &[Key] = &[
    optional("ellipsoid", Kind::OneOf(&["WGS84", "CGCS2000"])),
    required("origin", Kind::Table(ORIGIN)),
    optional(
        "water_level_m",
        Kind::Number(limits(-1e3, 1e3, "metres from -1000 to 1000")),
    ),
    optional("line_height_sigma_m", Kind::Number(SIGMA_M)),
];

const TRAJECTORY: &[Key] = &[
    required("path", Kind::Text),
    required("position_sigma_m", Kind::Number(SIGMA_M)),
    required("position_drift_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
    required("height_drift_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
    required("drift_correlation_time_s", Kind::Number(SECONDS)),
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional(
        "roll_pitch_drift_sigma_deg",
        Kind::Number(SIGMA_DEG_OR_NONE),
    ),
    optional("roll_pitch_correlation_time_s", Kind::Number(SECONDS)),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("heading_drift_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("heading_correlation_time_s", Kind::Number(SECONDS)),
    optional("max_gap_s", Kind::Number(SECONDS)),
];

const SOUND_SPEED: &[Key] = &[
    required("profile", Kind::Text),
    optional("profile_sigma", Kind::Number(PART)),
];

const MULTIBEAM: &[Key] = &[
    required("path", Kind::Text),
    required("lever_arm_m", Kind::Triple(PLACE)),
    optional("lever_arm_sigma_m", Kind::Triple(SIGMA_M_OR_NONE)),
    required("mounting_deg", Kind::Table(ANGLES)),
    required("range_sigma_m", Kind::Number(SIGMA_M)),
    required("angle_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional(
        "angle_sigma_growth",
        Kind::Number(limits(0.0, 100.0, "a number from 0 to 100")),
    ),
    optional(
        "max_angle_deg",
        Kind::Number(limits(5.0, 90.0, "degrees from 5 to 90")),
    ),
];

const SEABED: &[Key] = &[
    optional("latency", Kind::Flag),
    optional("range_scale", Kind::Flag),
    optional("range_scale_sigma", Kind::Number(PART)),
    optional(
        "heave_scale_sigma",
        Kind::Number(limits(0.0, 1.0, "a number from 0 to 1")),
    ),
    optional(
        "heave_lag_sigma_s",
        Kind::Number(limits(0.0, 1.0, "seconds from 0 to 1")),
    ),
    optional(
        "tile_m",
        Kind::Number(limits(1.0, 100.0, "metres from 1 to 100")),
    ),
    optional(
        "soundings_per_tile",
        Kind::Count(limits(16.0, 256.0, "16 to 256")),
    ),
    optional("max_tiles", Kind::Count(COUNT)),
    optional("max_passes", Kind::Count(limits(6.0, 100.0, "6 to 100"))),
    optional(
        "reject_sigmas",
        Kind::Number(limits(
            4.0,
            1000.0,
            "sigmas from 4 (a narrower limit falsifies the uncertainty) to 1000",
        )),
    ),
    optional("max_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("max_relief_sigma_deg", Kind::Number(SIGMA_DEG)),
];

const REFERENCE: &[Key] = &[
    optional(
        "order",
        Kind::OneOf(&[
            "latency-pitch-yaw-roll",
            "latency-pitch-roll-yaw",
            "latency-roll-pitch-yaw",
            "roll-latency-pitch-yaw",
            "roll-yaw-latency-pitch",
        ]),
    ),
    optional("rounds", Kind::Count(limits(1.0, 10.0, "1 to 10"))),
];

const LINE: &[Key] = &[
    required("name", Kind::Text),
    required("start_s", Kind::Number(TIME)),
    required("end_s", Kind::Number(TIME)),
];

/// A seabed survey file.
pub(super) const SURVEY: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(&["seabed"])),
    required("site", Kind::Table(SITE)),
    required("trajectory", Kind::Table(TRAJECTORY)),
    required("sound_speed", Kind::Table(SOUND_SPEED)),
    required("multibeam", Kind::Table(MULTIBEAM)),
    optional("seabed", Kind::Table(SEABED)),
    optional("reference", Kind::Table(REFERENCE)),
    required("line", Kind::Tables(LINE)),
];
