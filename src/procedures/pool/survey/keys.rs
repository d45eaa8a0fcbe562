//! The keys of a pool survey file and of a target file, with their limits.

use crate::survey::limits::{ABOVE, Limits, limits};
use crate::survey::schema::{Key, Kind, optional, required};

pub(crate) const RANGE_SIGMA_M: Limits = limits(
    ABOVE,
    1.0,
    "metres above 0 and up to 1 (is it in millimetres?)",
);
pub(crate) const SIGMA_M: Limits = limits(ABOVE, 10.0, "metres above 0 and up to 10");
pub(crate) const SIGMA_M_OR_NONE: Limits = limits(0.0, 10.0, "metres from 0 to 10");
pub(crate) const SIGMA_DEG: Limits = limits(ABOVE, 10.0, "degrees above 0 and up to 10");
pub(crate) const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 10.0, "degrees from 0 to 10");
pub(crate) const LEVER_ARM: Limits = limits(
    -100.0,
    100.0,
    "metres from -100 to 100 (right, forward, up)",
);
pub(crate) const LENGTH: Limits = limits(ABOVE, 1000.0, "metres above 0 and up to 1000");
pub(crate) const COORDINATE: Limits = limits(-1000.0, 1000.0, "metres from -1000 to 1000");

/// What the times of laser returns are.
pub(crate) const LASER_TIMES: Kind = Kind::OneOf(&[
    "utc",
    "gps",
    "gps-week",
    "utc-week",
    "gps-day",
    "utc-day",
    "gps-adjusted",
]);

/// The six parameters of a mounting, as `hold` names them.
pub(crate) const PARAMETERS: &[&str] = &["pitch", "roll", "yaw", "lx", "ly", "lz"];

const TARGET_KIND: Key = required("kind", Kind::OneOf(&["pool-wall", "faces"]))
    .about("A wall with two columns of blocks, or any faces.");

/// A target file with `kind = "pool-wall"`.
pub(crate) const WALL: &[Key] = &[
    TARGET_KIND,
    required("wall_length_m", Kind::Number(LENGTH))
        .about("Free wall between the two columns of blocks, metres."),
    required("wall_height_m", Kind::Number(LENGTH))
        .about("Height of the wall, metres; the target's origin is half way up its front face."),
    required("block_leg_m", Kind::Number(LENGTH))
        .about("Legs of a block's right triangle in plan, metres."),
    required("block_height_m", Kind::Number(LENGTH))
        .about("Height of a block, metres; the next stands two heights above."),
    required("first_block_minus_y_m", Kind::Number(COORDINATE))
        .about("Underside of the lowest block of the column at -Y, metres from the origin."),
    required("first_block_plus_y_m", Kind::Number(COORDINATE))
        .about("Underside of the lowest block of the column at +Y, metres from the origin."),
    optional("coplanarity_sigma_m", Kind::Number(SIGMA_M_OR_NONE))
        .about("How far an inclined face lies off its column's plane, metres, one sigma; 0."),
    optional("height_sigma_m", Kind::Number(SIGMA_M_OR_NONE))
        .about("How far a horizontal face lies off its design height, metres, one sigma; 0."),
];

const FACES_KIND: Key = required("kind", Kind::OneOf(&["faces", "pool-wall"]));

const FACE: &[Key] = &[
    required("name", Kind::Text),
    required(
        "role",
        Kind::OneOf(&["P1", "P2", "P3", "horizontal", "other", "obstacle"]),
    )
    .about("What the face stands for: P1, P3 the inclined ones, P2 the wall."),
    required("vertices_m", Kind::Triples(COORDINATE)).about(
        "Corners [x, y, z] in the target frame, metres, counter-clockwise seen from the sensors.",
    ),
    optional("plane", Kind::Text).about("Faces of one name share a plane exactly."),
    optional("offset_sigma_m", Kind::Number(SIGMA_M_OR_NONE))
        .about("How far the face lies off its design plane, metres, one sigma; 0."),
];

/// A target file with `kind = "faces"`.
pub(crate) const FACES: &[Key] = &[
    FACES_KIND,
    required("face", Kind::Tables(FACE)).about("The faces."),
];

/// A target file of no known kind.
pub(crate) const NO_KIND: &[Key] = &[TARGET_KIND];
