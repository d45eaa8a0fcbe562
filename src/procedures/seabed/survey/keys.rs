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
    required("roll", Kind::Number(TURN)).about("Starboard down."),
    required("pitch", Kind::Number(TURN)).about("Bow up."),
    required("heading", Kind::Number(TURN)).about("Clockwise."),
];

const ORIGIN: &[Key] = &[
    required(
        "latitude_deg",
        Kind::Number(limits(-90.0, 90.0, "degrees from -90 to 90")),
    )
    .about("Latitude, degrees."),
    required("longitude_deg", Kind::Number(TURN)).about("Longitude, degrees."),
    required(
        "height_m",
        Kind::Number(limits(-1e4, 1e4, "metres from -10000 to 10000")),
    )
    .about("Ellipsoidal height, metres."),
];

const SITE: &[Key] = &[
    optional("ellipsoid", Kind::OneOf(&["WGS84", "CGCS2000"]))
        .about("Ellipsoid of the trajectory's positions; WGS84."),
    required("origin", Kind::Table(ORIGIN)).about("Origin of the local frame: east, north, up."),
    optional(
        "water_level_m",
        Kind::Number(limits(-1e3, 1e3, "metres from -1000 to 1000")),
    )
    .about("Height of the water level in that frame, metres; 0."),
    optional("line_height_sigma_m", Kind::Number(SIGMA_M))
        .about("Tide or datum: one offset of each line, metres, one sigma; 0.03."),
];

const TRAJECTORY: &[Key] = &[
    required("path", Kind::Text).about("The file, relative to the survey file."),
    required("position_sigma_m", Kind::Number(SIGMA_M))
        .about("White noise of the position per record and axis, metres."),
    required("position_drift_sigma_m", Kind::Number(SIGMA_M_OR_NONE))
        .about("Drift of east and north, metres."),
    required("height_drift_sigma_m", Kind::Number(SIGMA_M_OR_NONE))
        .about("Drift of the height, metres."),
    required("drift_correlation_time_s", Kind::Number(SECONDS))
        .about("Correlation time of both, seconds."),
    required("roll_pitch_sigma_deg", Kind::Number(SIGMA_DEG))
        .about("White noise of roll and pitch per record, degrees."),
    optional(
        "roll_pitch_drift_sigma_deg",
        Kind::Number(SIGMA_DEG_OR_NONE),
    )
    .about("Drift of roll and pitch, degrees; none."),
    optional("roll_pitch_correlation_time_s", Kind::Number(SECONDS))
        .about("Its correlation time, seconds; 120."),
    required("heading_sigma_deg", Kind::Number(SIGMA_DEG))
        .about("White noise of the heading per record, degrees."),
    optional("heading_drift_sigma_deg", Kind::Number(SIGMA_DEG_OR_NONE))
        .about("Drift of the heading, degrees; none."),
    optional("heading_correlation_time_s", Kind::Number(SECONDS))
        .about("Its correlation time, seconds; 120."),
    optional("max_gap_s", Kind::Number(SECONDS))
        .about("Longest interval that is interpolated, seconds; 1."),
];

const SOUND_SPEED: &[Key] = &[
    required("profile", Kind::Text).about("Sound-speed profile, CSV."),
    optional("profile_sigma", Kind::Number(PART)).about(
        "Relative error of the profile at 20 m below the transducer, one sigma; 0 holds it.",
    ),
];

const MULTIBEAM: &[Key] = &[
    required("path", Kind::Text).about("The file, relative to the survey file."),
    required("lever_arm_m", Kind::Triple(PLACE))
        .about("Lever arm in the body: right, forward, up, metres."),
    optional("lever_arm_sigma_m", Kind::Triple(SIGMA_M_OR_NONE))
        .about("Its standard deviations, metres; 0.005, 0.005, 0.01."),
    required("mounting_deg", Kind::Table(ANGLES)).about("Nominal mounting angles, degrees."),
    required("range_sigma_m", Kind::Number(SIGMA_M)).about("Range noise, metres, one sigma."),
    required("angle_sigma_deg", Kind::Number(SIGMA_DEG))
        .about("Across-track angle noise at the middle of the swath, degrees, one sigma."),
    optional(
        "angle_sigma_growth",
        Kind::Number(limits(0.0, 100.0, "a number from 0 to 100")),
    )
    .about("Growth outwards: sigma (1 + growth (|a| / 60 deg)^3); 0."),
    optional(
        "max_angle_deg",
        Kind::Number(limits(5.0, 90.0, "degrees from 5 to 90")),
    )
    .about("Soundings further out are not used, degrees; 65."),
];

const SEABED: &[Key] = &[
    optional("latency", Kind::Flag).about("Whether a latency of the soundings is sought; true."),
    optional("range_scale", Kind::Flag)
        .about("Whether a range scale is sought within its prior; true."),
    optional("range_scale_sigma", Kind::Number(PART)).about("Prior of the range scale; 0.005."),
    optional(
        "heave_scale_sigma",
        Kind::Number(limits(0.0, 1.0, "a number from 0 to 1")),
    )
    .about("Prior of the heave channel's scale; 0.05, 0 holds it."),
    optional(
        "heave_lag_sigma_s",
        Kind::Number(limits(0.0, 1.0, "seconds from 0 to 1")),
    )
    .about("Prior of the heave channel's lag, seconds; 0.02, 0 holds it."),
    optional(
        "tile_m",
        Kind::Number(limits(1.0, 100.0, "metres from 1 to 100")),
    )
    .about("Side of a tile in 15 m of water, metres; 7."),
    optional(
        "soundings_per_tile",
        Kind::Count(limits(16.0, 256.0, "16 to 256")),
    )
    .about("Most soundings of a tile; 60."),
    optional("max_tiles", Kind::Count(COUNT)).about("Most tiles; 600."),
    optional("max_passes", Kind::Count(limits(6.0, 100.0, "6 to 100")))
        .about("Most passes of the fine phase; 10."),
    optional(
        "reject_sigmas",
        Kind::Number(limits(
            4.0,
            1000.0,
            "sigmas from 4 (a narrower limit falsifies the uncertainty) to 1000",
        )),
    )
    .about("Soundings with a larger standardised residual are dropped; 4.5."),
    optional("max_sigma_deg", Kind::Number(SIGMA_DEG))
        .about("Largest sigma of a determined angle, degrees; 1."),
    optional("max_relief_sigma_deg", Kind::Number(SIGMA_DEG))
        .about("Largest sigma of pitch and yaw from the relief alone, degrees; 0.3."),
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
    )
    .about("Order of the patch test; latency-pitch-yaw-roll (IHO)."),
    optional("rounds", Kind::Count(limits(1.0, 10.0, "1 to 10")))
        .about("How often the order is gone through; 1."),
];

const LINE: &[Key] = &[
    required("name", Kind::Text).about("Name for reports."),
    required("start_s", Kind::Number(TIME)).about("Begin, seconds on the trajectory's clock."),
    required("end_s", Kind::Number(TIME)).about("End, seconds."),
];

/// A seabed survey file.
pub const SURVEY: &[Key] = &[
    required("name", Kind::Text).about("Name for reports."),
    required("procedure", Kind::OneOf(&["seabed"])).about("What the file is for."),
    required("site", Kind::Table(SITE)).about("The frame of the computation."),
    required("trajectory", Kind::Table(TRAJECTORY)).about("The INS."),
    required("sound_speed", Kind::Table(SOUND_SPEED)).about("The water."),
    required("multibeam", Kind::Table(MULTIBEAM)).about("The sonar."),
    optional("seabed", Kind::Table(SEABED)).about("The joint path."),
    optional("reference", Kind::Table(REFERENCE)).about("The reference path."),
    required("line", Kind::Tables(LINE)).about("One line; as many as were sailed."),
];
