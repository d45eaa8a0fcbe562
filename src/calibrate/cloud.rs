//! The points of a survey under a calibration, for whoever writes them.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::seam::InputError;
use crate::geometry::Ellipsoid;
use crate::geometry::ellipsoid::Geodetic;
use crate::geometry::frames::{Ecef, Point};
use crate::observe::Mounting;
use crate::results::{Calibration, InputFile, MountingResult, Solution};

/// Points georeferenced at a time.
pub const CHUNK: usize = 65_536;

/// All points of a survey, in order of time within each of its parts.
pub struct Cloud<'s> {
    /// The ellipsoid of the coordinates.
    pub ellipsoid: Ellipsoid,
    /// About the middle of the points.
    pub middle: Geodetic,
    /// Whether the times are adjusted standard GPS time and not seconds of the week.
    pub standard_time: bool,
    /// How many observations there are; those without a position are left out of the chunks.
    pub total: usize,
    /// What the points come from, such as a sensor or a line; [`Placed::source`] counts them from 1.
    pub sources: Vec<String>,
    /// The points, at most [`CHUNK`] at a time; an error where observations that were kept in a file cannot be read from it again.
    pub chunks: Box<dyn Iterator<Item = Result<Vec<Placed>, InputError>> + 's>,
}

/// A georeferenced point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Its stamp, seconds.
    pub time_s: f64,
    /// Where it is.
    pub position: Point<Ecef>,
    /// What it comes from, counted from 1.
    pub source: u16,
    /// Number of the observation in the file that it was read from, counted from 0.
    pub row: u32,
    /// Whether a sonar measured it.
    pub sounding: bool,
    /// Whether it lies on the surface about it; a gross error does not, and has no place in a gridded surface.
    pub on_surface: bool,
    /// What a beam says of itself; `None` where it says nothing.
    pub beam: Option<Beam>,
}

/// Ping and beam of a sounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Beam {
    /// Ping number.
    pub ping: u32,
    /// Beam number within the ping.
    pub beam: u32,
}

/// What a calibration changes of a sounding sensor: mounting, latency (seconds), range scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Mounting of the sensor.
    pub mounting: Mounting,
    /// Stamp minus measurement epoch, seconds.
    pub latency_s: f64,
    /// True range = measured x (1 + scale).
    pub range_scale: f64,
}

impl SensorModel {
    /// A mounting without latency and scale.
    #[must_use]
    pub fn plain(mounting: Mounting) -> Self {
        Self {
            mounting,
            latency_s: 0.0,
            range_scale: 0.0,
        }
    }

    /// Of a solution of a result: its first mounting, with the latency and the range scale that it determined; `None` of a solution
    /// without them.
    #[must_use]
    pub fn of(solution: &Solution) -> Option<Self> {
        let value = |name: &str| {
            let found = solution.parameter(name).filter(|p| p.determined);
            found.and_then(|p| p.value).unwrap_or(0.0)
        };
        let (_, mounting) = named(solution.mountings.first()?)?;
        Some(Self {
            mounting,
            latency_s: value("latency"),
            range_scale: value("range_scale"),
        })
    }
}

/// A mounting of a result with its name; `None` without a lever arm.
fn named(found: &MountingResult) -> Option<(String, Mounting)> {
    let rotation = found.rotation_matrix.into_iter().flatten();
    let mounting = Mounting {
        rotation: Matrix3::from_row_iterator(rotation),
        lever_arm_m: Vector3::from(found.lever_arm_m?),
    };
    Some((found.name.clone(), mounting))
}

/// What a calibration changes of a whole survey: the sensor, the heave channel, the heights of the lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// The sensor; the first of several heads.
    pub sensor: SensorModel,
    /// The mountings of all heads by the names that the result gives them; nothing where only the sensor is known.
    pub heads: Vec<(String, Mounting)>,
    /// True heave over measured heave, minus 1.
    pub heave_scale: f64,
    /// The heave channel is late by this, seconds.
    pub heave_lag_s: f64,
    /// What the height of each line was off by, by the line's name, metres.
    pub line_heights_m: BTreeMap<String, f64>,
}

impl Calibrated {
    /// Of one solution of a result; heave and heights of lines are those of the joint path. `None` of a solution without a mounting.
    #[must_use]
    pub fn of(result: &Calibration, solution: &Solution) -> Option<Self> {
        let value = |name: &str| {
            let found = solution.parameter(name).and_then(|p| p.value);
            found.unwrap_or(0.0)
        };
        let joint = result.solutions.joint.as_ref() == Some(solution);
        let lines = result.details["joint"]["lines"].as_array();
        let lines = lines.filter(|_| joint).into_iter().flatten();
        let height = |line: &serde_json::Value| {
            let name = line["name"].as_str()?.to_owned();
            Some((name, line["height_m"].as_f64()?))
        };
        Some(Self {
            sensor: SensorModel::of(solution)?,
            heads: solution.mountings.iter().filter_map(named).collect(),
            heave_scale: value("heave scale"),
            heave_lag_s: value("heave lag"),
            line_heights_m: lines.filter_map(height).collect(),
        })
    }

    /// Takes away heights of lines that are not of this very survey, whatever its own lines are called; whether there were such.
    pub fn without_heights_of_others(
        &mut self,
        result: &Calibration,
        inputs: &[InputFile],
    ) -> bool {
        let then = &result.provenance.inputs;
        let known = |input: &InputFile| then.iter().any(|i| i.sha256 == input.sha256);
        if inputs.iter().all(known) || self.line_heights_m.is_empty() {
            return false;
        }
        self.line_heights_m.clear();
        true
    }
}

impl From<SensorModel> for Calibrated {
    /// The sensor alone.
    fn from(sensor: SensorModel) -> Self {
        Self {
            sensor,
            heads: vec![],
            heave_scale: 0.0,
            heave_lag_s: 0.0,
            line_heights_m: BTreeMap::new(),
        }
    }
}
