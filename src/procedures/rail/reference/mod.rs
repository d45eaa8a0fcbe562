//! The reference path, as patent CN114162169A has it; what its lost formula images leave open is settled in `docs/rail.md`.
//!
//! Each profiler by itself. Coarse: closest points at the position nearest to level. Fine (claims 1 and 4): the angle between the fitted and
//! the standard 1:20 line and the vector between the fitted and the standard centre of the R20 arc, repeated; roll mounting = turn of the
//! profile minus the INS' roll (claim 5). Then the table turns: the fine transform is computed anew at each position, and the Hausdorff
//! distance (claim 6) of the 1:20 points finds the heading, that of the R20 points the pitch: the mounting is minus the INS' angle at the
//! minimum (claims 7 to 9). The offsets are those that, with all three angles, leave the level profile's mean point where the fine fit put it.

mod fitter;

use thiserror::Error;

use super::config::RailReferenceConfig;
use super::icp::{Cloud, Rigid};
use super::scene::RailScene;
use crate::geometry::rotation;
use crate::observe::Mounting;
use crate::units::wrap_angle;
use fitter::{Axis, Fitter, LEAST_STEPS};

/// Why the reference path has no result for a profiler.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReferenceError {
    /// No points at the position nearest to level.
    #[error("profiler {profiler}: no points at the position nearest to level")]
    NoProfile {
        /// Its name.
        profiler: String,
    },
    /// Too few points of a region, or points that no figure fits.
    #[error("profiler {profiler}: {region}: {what}")]
    Region {
        /// Its name.
        profiler: String,
        /// The region's name.
        region: String,
        /// What is wrong.
        what: String,
    },
    /// The table did not turn about an axis.
    #[error(
        "profiler {profiler}: {found} usable positions turn about {axis} alone, expected at least {LEAST_STEPS}"
    )]
    NoSweep {
        /// Its name.
        profiler: String,
        /// `the vertical` or `the lateral axis`.
        axis: &'static str,
        /// Positions found.
        found: usize,
    },
}

/// One position of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepStep {
    /// Angle of the INS against the rail, radians: heading or pitch.
    pub turn_rad: f64,
    /// Hausdorff distance, metres.
    pub distance_m: f64,
}

/// What the reference path found for one profiler.
#[derive(Clone, Debug, PartialEq)]
pub struct RailReference {
    /// The mounting.
    pub mounting: Mounting,
    /// Turn of the profile by the coarse and by the fine fit, radians.
    pub roll_rad: (f64, f64),
    /// Transform of the profile at the position nearest to level.
    pub fine: Rigid,
    /// Hausdorff distance of the 1:20 points over the turns about the vertical.
    pub heading: Vec<SweepStep>,
    /// Hausdorff distance of the R20 points over the turns about the lateral axis.
    pub pitch: Vec<SweepStep>,
    /// RMS distance of the level profile from the standard profile before and after compensation, metres.
    pub rms_m: (f64, f64),
}

/// The standard profile's points; `None` for a profile without elements.
#[must_use]
pub fn cloud(scene: &RailScene, config: &RailReferenceConfig) -> Option<Cloud> {
    Cloud::new(scene.rail, config.spacing_m)
}

/// The mounting after the coarse fit alone: roll and offset from it, heading and pitch as nominal.
///
/// # Errors
/// [`ReferenceError::NoProfile`].
pub fn coarse(
    scene: &RailScene,
    config: &RailReferenceConfig,
    cloud: &Cloud,
    profiler: usize,
) -> Result<Mounting, ReferenceError> {
    let fitter = Fitter {
        scene,
        config,
        cloud,
        profiler,
    };
    let level = scene.level_position();
    let transform = fitter.coarse(level)?;
    let nominal = &scene.campaign.profilers[profiler].nominal;
    let (roll, pitch, heading) = nominal.angles();
    let turn = transform.roll_rad - fitter.nominal_transform(level).roll_rad;
    let rotation = rotation::from_attitude(roll + turn, pitch, heading);
    Ok(fitter.placed(level, &transform, rotation))
}

/// Runs the reference path for one profiler.
///
/// # Errors
/// [`ReferenceError`].
pub fn reference(
    scene: &RailScene,
    config: &RailReferenceConfig,
    cloud: &Cloud,
    profiler: usize,
) -> Result<RailReference, ReferenceError> {
    let fitter = Fitter {
        scene,
        config,
        cloud,
        profiler,
    };
    let (level, coarse, fine) = fitter.level()?;
    let rail = scene.campaign.stand.rail_attitude_rad;
    let (ins_roll, _, _) = rotation::to_attitude(&scene.attitude(level));
    let heading = fitter.sweep(level, fine, Axis::Heading)?;
    let pitch = fitter.sweep(level, fine, Axis::Pitch)?;
    let roll_rad = wrap_angle(fine.roll_rad - (ins_roll - rail[0]));
    let mount = rotation::from_attitude(roll_rad, -minimum(&pitch), -minimum(&heading));
    let mounting = fitter.placed(level, &fine, mount);
    let rms_m = fitter.compensated(level, fine, &mounting);
    Ok(RailReference {
        mounting,
        roll_rad: (coarse.roll_rad, fine.roll_rad),
        fine,
        heading,
        pitch,
        rms_m,
    })
}

/// The turn of the smallest distance; of equal ones the first.
fn minimum(sweep: &[SweepStep]) -> f64 {
    let best = sweep
        .iter()
        .min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    best.map_or(f64::NAN, |s| s.turn_rad)
}
