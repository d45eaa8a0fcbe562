//! The keys of a rail survey file, of a rail model file, and of a rail scenario file, with their limits.

use crate::survey::schema::{Key, Kind, Limits, optional, required};

const fn limits(min: f64, max: f64, expected: &'static str) -> Limits {
    Limits { min, max, expected }
}

const SIGMA_M: Limits = limits(1e-9, 1.0, "metres from 1e-9 to 1");
const SIGMA_M_OR_NONE: Limits = limits(0.0, 0.01, "metres from 0 to 0.01");
const SIGMA_DEG: Limits = limits(1e-9, 10.0, "degrees from 1e-9 to 10");
const TURN: Limits = limits(-360.0, 360.0, "degrees from -360 to 360");
const PLACE: Limits = limits(-10.0, 10.0, "metres from -10 to 10");
const MILLIMETRES: Limits = limits(-10_000.0, 10_000.0, "millimetres from -10000 to 10000");
const POSITIVE: Limits = limits(1e-6, 1e6, "a number from 1e-6 to 1e6");
const COUNT: Limits = limits(1.0, 100_000.0, "1 to 100000");
const PART: Limits = limits(0.0, 1.0, "a number from 0 to 1");

const ANGLES: &[Key] = &[
    required("roll", Kind::Number(TURN)),
    required("pitch", Kind::Number(TURN)),
    required("heading", Kind::Number(TURN)),
];

const RAIL: &[Key] = &[
    required("model", Kind::Text),
    optional("orientation_deg", Kind::Table(ANGLES)),
    required("orientation_sigma_deg", Kind::Triple(SIGMA_DEG)),
    optional("profile_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
];

const PROFILES: &[Key] = &[required("path", Kind::Text)];

const ATTITUDE: &[Key] = &[
    required("path", Kind::Text),
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG)),
];

const TABLE: &[Key] = &[
    required("path", Kind::Text),
    required("angle_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("level_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("zero_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("seating_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("pivot_body_m", Kind::Triple(PLACE)),
    required("pivot_body_sigma_m", Kind::Number(SIGMA_M)),
    required("pivot_rail_m", Kind::Pair(PLACE)),
    required("pivot_rail_sigma_m", Kind::Number(SIGMA_M)),
];

const PROFILER: &[Key] = &[
    required("name", Kind::Text),
    required("lever_arm_m", Kind::Triple(PLACE)),
    required("mounting_deg", Kind::Table(ANGLES)),
    required("lateral_sigma_m", Kind::Number(SIGMA_M)),
    required("vertical_sigma_m", Kind::Number(SIGMA_M)),
    required("along_sigma_m", Kind::Number(SIGMA_M)),
];

const REFERENCE: &[Key] = &[
    optional(
        "spacing_m",
        Kind::Number(limits(1e-6, 0.01, "metres from 1e-6 to 0.01")),
    ),
    optional("max_steps", Kind::Count(COUNT)),
    optional(
        "region_m",
        Kind::Number(limits(1e-6, 0.1, "metres from 1e-6 to 0.1")),
    ),
    optional(
        "axis_tolerance_deg",
        Kind::Number(limits(1e-6, 10.0, "degrees from 1e-6 to 10")),
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
    optional(
        "gate_sigma",
        Kind::Number(limits(
            4.0,
            1000.0,
            "sigmas from 4 (a narrower gate falsifies the uncertainty) to 1000",
        )),
    ),
    optional("max_rounds", Kind::Count(limits(3.0, 1000.0, "3 to 1000"))),
    optional(
        "max_sigma_deg",
        Kind::Number(limits(1e-9, 180.0, "degrees from 1e-9 to 180")),
    ),
    optional(
        "max_sigma_m",
        Kind::Number(limits(1e-9, 10.0, "metres from 1e-9 to 10")),
    ),
    optional(
        "least_turn_deg",
        Kind::Number(limits(0.0, 90.0, "degrees from 0 to 90")),
    ),
];

const NAMES: &[&str] = &["rail"];

/// A rail survey file.
pub(super) const SURVEY: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(NAMES)),
    required("rail", Kind::Table(RAIL)),
    required("profiles", Kind::Table(PROFILES)),
    required("attitude", Kind::Table(ATTITUDE)),
    required("table", Kind::Table(TABLE)),
    required("profiler", Kind::Tables(PROFILER)),
    optional("reference", Kind::Table(REFERENCE)),
    optional("joint", Kind::Table(JOINT)),
];

const ELEMENT: &[Key] = &[
    required("name", Kind::Text),
    required("to_mm", Kind::Pair(MILLIMETRES)),
    optional("radius_mm", Kind::Number(MILLIMETRES)),
];

/// A rail model file.
pub(super) const MODEL: &[Key] = &[
    required("name", Kind::Text),
    optional("symmetric", Kind::Flag),
    required("line_region", Kind::Text),
    required("arc_region", Kind::Text),
    required("start_mm", Kind::Pair(MILLIMETRES)),
    required("element", Kind::Tables(ELEMENT)),
];

const SIMULATED_ATTITUDE: &[Key] = &[
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG)),
    required("rate_hz", Kind::Number(POSITIVE)),
];

const SWEEP: Kind = Kind::Triple(limits(-90.0, 90.0, "degrees from -90 to 90"));

const SIMULATED_TABLE: &[Key] = &[
    TABLE[1],
    TABLE[2],
    TABLE[3],
    TABLE[4],
    TABLE[5],
    TABLE[6],
    TABLE[7],
    TABLE[8],
    required("heading_sweep_deg", SWEEP),
    required("pitch_sweep_deg", SWEEP),
    required("rest_s", Kind::Number(POSITIVE)),
];

const CORRECTION: &[Key] = &[
    required("pitch", Kind::Number(TURN)),
    required("roll", Kind::Number(TURN)),
    required("yaw", Kind::Number(TURN)),
];

const SIMULATED_PROFILER: &[Key] = &[
    PROFILER[0],
    PROFILER[1],
    PROFILER[2],
    PROFILER[3],
    PROFILER[4],
    PROFILER[5],
    required("field_deg", Kind::Number(POSITIVE)),
    required("rays", Kind::Count(COUNT)),
    optional("profiles", Kind::Count(COUNT)),
    optional("correction_deg", Kind::Table(CORRECTION)),
    optional("lever_arm_correction_m", Kind::Triple(PLACE)),
];

const DISTURBANCE: &[Key] = &[
    optional("dust_fraction", Kind::Number(PART)),
    optional("dust_depth_m", Kind::Number(PART)),
    optional("occlusion_fraction", Kind::Number(PART)),
    optional("occlusion_width", Kind::Number(PART)),
];

const FACTOR: Kind = Kind::Number(limits(0.0, 1e6, "a number from 0 to 1e6"));

const SOURCES: &[Key] = &[
    optional("lateral", FACTOR),
    optional("vertical", FACTOR),
    optional("roll_pitch", FACTOR),
    optional("heading", FACTOR),
    optional("table", FACTOR),
    optional("level", FACTOR),
    optional("seating", FACTOR),
    optional("pivot_body", FACTOR),
    optional("pivot_rail", FACTOR),
    optional("rail_attitude", FACTOR),
    optional("profile", FACTOR),
    optional("along", FACTOR),
    optional("dust", FACTOR),
    optional("occlusion", FACTOR),
];

/// A rail scenario file.
pub(super) const SCENARIO: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(NAMES)),
    optional("seed", Kind::Count(limits(0.0, 9.0e15, "0 to 9e15"))),
    required("rail", Kind::Table(RAIL)),
    required("attitude", Kind::Table(SIMULATED_ATTITUDE)),
    required("table", Kind::Table(SIMULATED_TABLE)),
    required("profiler", Kind::Tables(SIMULATED_PROFILER)),
    optional("disturbance", Kind::Table(DISTURBANCE)),
    optional("sources", Kind::Table(SOURCES)),
    optional("reference", Kind::Table(REFERENCE)),
    optional("joint", Kind::Table(JOINT)),
];
