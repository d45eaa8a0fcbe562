//! The keys of a pool survey file and of a target file, with their limits.

use crate::survey::schema::{Key, Kind, Limits, optional, required};

const fn limits(min: f64, max: f64, expected: &'static str) -> Limits {
    Limits { min, max, expected }
}

const ABOVE: f64 = f64::MIN_POSITIVE;
const LATITUDE: Limits = limits(-90.0, 90.0, "degrees from -90 to 90");
const TURN: Limits = limits(-360.0, 360.0, "degrees from -360 to 360");
const HEIGHT: Limits = limits(-12_000.0, 12_000.0, "metres from -12000 to 12000");
const RANGE_SIGMA_M: Limits = limits(
    ABOVE,
    1.0,
    "metres above 0 and up to 1 (is it in millimetres?)",
);
const SIGMA_M: Limits = limits(ABOVE, 10.0, "metres above 0 and up to 10");
const SIGMA_M_OR_NONE: Limits = limits(0.0, 10.0, "metres from 0 to 10");
const SIGMA_DEG: Limits = limits(ABOVE, 10.0, "degrees above 0 and up to 10");
const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 10.0, "degrees from 0 to 10");
const LEVER_ARM: Limits = limits(
    -100.0,
    100.0,
    "metres from -100 to 100 (right, forward, up)",
);
const OFFSET_S: Limits = limits(-1e10, 1e10, "seconds within 1e10");
const DURATION: Limits = limits(ABOVE, 1e6, "seconds above 0 and up to 1000000");
const LENGTH: Limits = limits(ABOVE, 1000.0, "metres above 0 and up to 1000");
const COORDINATE: Limits = limits(-1000.0, 1000.0, "metres from -1000 to 1000");
const WIDTH: Limits = limits(0.5, 1000.0, "sigmas from 0.5 to 1000");
const GATE: Limits = limits(
    4.0,
    1000.0,
    "sigmas from 4 (a narrower gate falsifies the uncertainty) to 1000",
);

/// The six parameters of a mounting, as `hold` names them.
const PARAMETERS: &[&str] = &["pitch", "roll", "yaw", "lx", "ly", "lz"];

/// Procedures that are designed; only the first is built.
pub(crate) const PROCEDURES: &[&str] = &["pool", "usbl", "rail", "seabed"];

const ORIGIN: &[Key] = &[
    required("latitude_deg", Kind::Number(LATITUDE)),
    required("longitude_deg", Kind::Number(TURN)),
    required("height_m", Kind::Number(HEIGHT)),
];

const TARGET: &[Key] = &[
    required("model", Kind::Text),
    optional("ellipsoid", Kind::OneOf(&["WGS84", "CGCS2000"])),
    required("origin", Kind::Table(ORIGIN)),
    required("azimuth_deg", Kind::Number(TURN)),
    optional("water_level_m", Kind::Number(COORDINATE)),
];

const TRAJECTORY: &[Key] = &[
    required("path", Kind::Text),
    required("position_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
    optional("position_drift_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
    optional("drift_correlation_time_s", Kind::Number(DURATION)),
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("heading_drift_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("max_gap_s", Kind::Number(DURATION)),
    optional("outside", Kind::OneOf(&["error", "drop"])),
    optional("time_offset_s", Kind::Number(OFFSET_S)),
];

const MOUNTING: &[Key] = &[
    required("roll", Kind::Number(TURN)),
    required("pitch", Kind::Number(TURN)),
    required("heading", Kind::Number(TURN)),
];

const LIDAR: &[Key] = &[
    required("path", Kind::Text),
    optional(
        "coordinates",
        Kind::OneOf(&["sensor", "target", "geocentric", "utm"]),
    ),
    optional("utm_zone", Kind::UtmZone),
    optional("lever_arm_m", Kind::Triple(LEVER_ARM)),
    optional("mounting_deg", Kind::Table(MOUNTING)),
    optional("range_sigma_m", Kind::Number(RANGE_SIGMA_M)),
    optional("angle_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("point_sigma_m", Kind::Number(SIGMA_M)),
    optional("mounting_sigma_deg", Kind::Triple(SIGMA_DEG)),
    optional("lever_arm_sigma_m", Kind::Triple(SIGMA_M)),
    optional("time_offset_s", Kind::Number(OFFSET_S)),
];

const MULTIBEAM: &[Key] = &[
    required("path", Kind::Text),
    required("lever_arm_m", Kind::Triple(LEVER_ARM)),
    required("mounting_deg", Kind::Table(MOUNTING)),
    required("range_sigma_m", Kind::Number(RANGE_SIGMA_M)),
    required("angle_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("along_angle_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE)),
    optional("time_offset_s", Kind::Number(OFFSET_S)),
];

const SOUND_SPEED: &[Key] = &[
    optional(
        "speed_m_s",
        Kind::Number(crate::formats::sound_speed_csv::SPEED),
    ),
    optional("profile", Kind::Text),
];

const SEQUENTIAL: &[Key] = &[
    optional("variant", Kind::OneOf(&["literal", "projected"])),
    optional("repeated", Kind::Flag),
    optional(
        "threshold_deg",
        Kind::Number(limits(1e-9, 10.0, "degrees from 1e-9 to 10")),
    ),
    optional(
        "max_passes",
        Kind::Count(limits(1.0, 10_000.0, "1 to 10000")),
    ),
];

const PRIOR: &[Key] = &[
    optional("pitch_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("roll_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("yaw_sigma_deg", Kind::Number(SIGMA_DEG)),
    optional("lx_sigma_m", Kind::Number(SIGMA_M)),
    optional("ly_sigma_m", Kind::Number(SIGMA_M)),
    optional("lz_sigma_m", Kind::Number(SIGMA_M)),
];

const JOINT: &[Key] = &[
    optional("planes", Kind::OneOf(&["adjusted", "fixed"])),
    optional("drift", Kind::OneOf(&["on", "off"])),
    optional(
        "kernel",
        Kind::OneOf(&["least-squares", "huber", "cauchy", "tukey", "geman-mcclure"]),
    ),
    optional("kernel_width_sigma", Kind::Number(WIDTH)),
    optional("gate_sigma", Kind::Number(GATE)),
    optional("latency", Kind::Flag),
    optional("range_scale", Kind::Flag),
    optional("variance_components", Kind::Flag),
    optional("hold", Kind::Words(PARAMETERS)),
    optional("prior", Kind::Table(PRIOR)),
    optional(
        "max_sigma_deg",
        Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180")),
    ),
    optional(
        "max_sigma_m",
        Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000")),
    ),
    optional("simple", Kind::Flag),
];

const VARIANCE: Limits = limits(ABOVE, 1e6, "a factor above 0 and up to 1000000");
const SHARE: Limits = limits(0.0, 1.0, "a share from 0 to 1");

const VERDICT: &[Key] = &[
    optional(
        "accept",
        Kind::Words(crate::calibrate::verdict::config::CODES),
    ),
    optional("least_variance_factor", Kind::Number(VARIANCE)),
    optional("most_variance_factor", Kind::Number(VARIANCE)),
    optional(
        "max_correction_deg",
        Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180")),
    ),
    optional(
        "max_correction_m",
        Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000")),
    ),
    optional("max_prior_sigmas", Kind::Number(WIDTH)),
    optional("least_share", Kind::Number(SHARE)),
    optional("good_share", Kind::Number(SHARE)),
];

/// What a scenario file says of the calibration.
pub(crate) const CALIBRATION: &[Key] = &[
    optional("sequential", Kind::Table(SEQUENTIAL)),
    optional("joint", Kind::Table(JOINT)),
    optional("verdict", Kind::Table(VERDICT)),
];

/// A pool survey file.
pub(crate) const SURVEY: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(PROCEDURES)),
    required("target", Kind::Table(TARGET)),
    required("trajectory", Kind::Table(TRAJECTORY)),
    required("lidar", Kind::Table(LIDAR)),
    required("multibeam", Kind::Table(MULTIBEAM)),
    optional("sound_speed", Kind::Table(SOUND_SPEED)),
    optional("sequential", Kind::Table(SEQUENTIAL)),
    optional("joint", Kind::Table(JOINT)),
    optional("verdict", Kind::Table(VERDICT)),
];

const TARGET_KIND: Key = required("kind", Kind::OneOf(&["pool-wall", "faces"]));

/// A target file with `kind = "pool-wall"`.
pub(crate) const WALL: &[Key] = &[
    TARGET_KIND,
    required("wall_length_m", Kind::Number(LENGTH)),
    required("wall_height_m", Kind::Number(LENGTH)),
    required("block_leg_m", Kind::Number(LENGTH)),
    required("block_height_m", Kind::Number(LENGTH)),
    required("first_block_minus_y_m", Kind::Number(COORDINATE)),
    required("first_block_plus_y_m", Kind::Number(COORDINATE)),
    optional("coplanarity_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
    optional("height_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
];

const FACE: &[Key] = &[
    required("name", Kind::Text),
    required(
        "role",
        Kind::OneOf(&["P1", "P2", "P3", "horizontal", "other", "obstacle"]),
    ),
    required("vertices_m", Kind::Triples(COORDINATE)),
    optional("plane", Kind::Text),
    optional("offset_sigma_m", Kind::Number(SIGMA_M_OR_NONE)),
];

/// A target file with `kind = "faces"`.
pub(crate) const FACES: &[Key] = &[TARGET_KIND, required("face", Kind::Tables(FACE))];

/// A target file of no known kind.
pub(crate) const NO_KIND: &[Key] = &[TARGET_KIND];
