//! The keys of a rail survey file, of a rail model file, and of a rail scenario file, with their limits.

use super::file::{ProfilerSection, RailSection, TableSection};
use crate::calibrate::large::LargeConfig;
use crate::calibrate::verdict::VerdictConfig;
use crate::procedures::rail::{RailJointConfig, RailReferenceConfig};
use crate::survey::limits::{Limits, TURN, limits};
use crate::survey::schema::{Key, Kind, optional, required};

pub(crate) const SIGMA_M: Limits = limits(1e-9, 1.0, "metres from 1e-9 to 1");
pub(crate) const SIGMA_M_OR_NONE: Limits = limits(0.0, 0.01, "metres from 0 to 0.01");
pub(crate) const SIGMA_DEG: Limits = limits(1e-9, 10.0, "degrees from 1e-9 to 10");
pub(crate) const PLACE: Limits = limits(-10.0, 10.0, "metres from -10 to 10");
pub(crate) const MILLIMETRES: Limits =
    limits(-10_000.0, 10_000.0, "millimetres from -10000 to 10000");
pub(crate) const POSITIVE: Limits = limits(1e-6, 1e6, "a number from 1e-6 to 1e6");
pub(crate) const COUNT: Limits = limits(1.0, 100_000.0, "1 to 100000");
pub(crate) const PART: Limits = limits(0.0, 1.0, "a number from 0 to 1");

pub(crate) const NAMES: &[&str] = &["rail"];

const ELEMENT: &[Key] = &[
    required("name", Kind::Text),
    required("to_mm", Kind::Pair(MILLIMETRES)),
    optional("radius_mm", Kind::Number(MILLIMETRES)),
];

/// A rail model file.
pub(crate) const MODEL: &[Key] = &[
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
    TableSection::KEYS[1],
    TableSection::KEYS[2],
    TableSection::KEYS[3],
    TableSection::KEYS[4],
    TableSection::KEYS[5],
    TableSection::KEYS[6],
    TableSection::KEYS[7],
    TableSection::KEYS[8],
    TableSection::KEYS[9],
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
    ProfilerSection::KEYS[0],
    ProfilerSection::KEYS[1],
    ProfilerSection::KEYS[2],
    ProfilerSection::KEYS[3],
    ProfilerSection::KEYS[4],
    ProfilerSection::KEYS[5],
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
    optional("axes_gap", FACTOR),
];

/// A rail scenario file.
pub(super) const SCENARIO: &[Key] = &[
    required("name", Kind::Text),
    required("procedure", Kind::OneOf(NAMES)),
    optional("seed", Kind::Count(limits(0.0, 9.0e15, "0 to 9e15"))),
    required("rail", Kind::Table(RailSection::KEYS)),
    required("attitude", Kind::Table(SIMULATED_ATTITUDE)),
    required("table", Kind::Table(SIMULATED_TABLE)),
    required("profiler", Kind::Tables(SIMULATED_PROFILER)),
    optional("disturbance", Kind::Table(DISTURBANCE)),
    optional("sources", Kind::Table(SOURCES)),
    optional("reference", Kind::Table(RailReferenceConfig::KEYS)),
    optional("joint", Kind::Table(RailJointConfig::KEYS)),
    optional("verdict", Kind::Table(VerdictConfig::KEYS)),
    optional("large", Kind::Table(LargeConfig::KEYS)),
];
