//! The reference path: angles, then offsets, as the patent does it (CN105425246B steps 3 and 4; `docs/reference-path.md`).
//!
//! The scanner's planes are the truth, the multibeam's are compared with them in the target frame, and every correction
//! is carried over into the body with the mean attitude of the soundings it came from. `docs/reference-path.md` maps the
//! patent's paragraphs to these files and shows where the patent contradicts itself.
//!
//! [`run`] knows nothing of files or association: it asks a closure for the soundings on each face under a mounting.

mod angles;
mod ends;
mod error;
mod input;
mod offsets;
mod outcome;

pub use angles::{Normals, angle_vector_rad, body_correction};
pub use error::SequentialError;
pub use input::{
    FaceSoundings, HorizontalReturns, HorizontalSoundings, RoleSoundings, ScannerPlanes,
};
pub use offsets::{Axis, OffsetStep, offset_m};
pub use outcome::{End, Outcome, Pass};

use super::config::SequentialConfig;
use crate::observe::Mounting;
use ends::History;

/// The angle iteration has converged when all three updates are below this, radians (0.0001 deg).
const UPDATE_TOLERANCE_RAD: f64 = 1.745e-6;
/// The repeated path is stable when a round turns the mounting by less than this, radians (0.001 deg) ...
const STABLE_RAD: f64 = 1.745e-5;
/// ... and moves the lever arm by less than this, metres.
const STABLE_M: f64 = 1e-4;
/// Most rounds of the repeated path.
const MAX_ROUNDS: u32 = 20;

/// Soundings on each face, georeferenced in the target frame with the given mounting. The number counts the calls from 0,
/// so that the gates of the association may narrow.
pub type Observe<'a> = dyn FnMut(&Mounting, u32) -> RoleSoundings + 'a;

/// Runs the reference path from the nominal mounting.
///
/// # Errors
/// [`SequentialError`] naming the plane that has too few soundings, spans no plane, or was sounded on contrary headings.
pub fn run(
    nominal: &Mounting,
    scanner: &ScannerPlanes,
    config: &SequentialConfig,
    observe: &mut Observe<'_>,
) -> Result<Outcome, SequentialError> {
    let mut path = Path {
        nominal,
        scanner,
        config,
        observe,
        calls: 0,
        passes: vec![],
        offsets: vec![],
    };
    let mut mounting = *nominal;
    let mut rounds = 0;
    loop {
        let before = mounting;
        let (aligned, end) = path.align(mounting)?;
        mounting = path.shift(aligned)?;
        rounds += 1;
        if !config.repeated || is_stable(&before, &mounting) {
            return Ok(path.outcome(mounting, end, rounds));
        }
        if rounds == MAX_ROUNDS {
            return Ok(path.outcome(mounting, End::OutOfRounds { rounds }, rounds));
        }
    }
}

fn is_stable(before: &Mounting, after: &Mounting) -> bool {
    after.correction_from(before).norm() < STABLE_RAD
        && (after.lever_arm_m - before.lever_arm_m).norm() < STABLE_M
}

/// What stays the same along the path, and its record.
struct Path<'a, 'o> {
    nominal: &'a Mounting,
    scanner: &'a ScannerPlanes,
    config: &'a SequentialConfig,
    observe: &'a mut Observe<'o>,
    calls: u32,
    passes: Vec<Pass>,
    offsets: Vec<OffsetStep>,
}

impl Path<'_, '_> {
    fn observe(&mut self, mounting: &Mounting) -> RoleSoundings {
        self.calls += 1;
        (self.observe)(mounting, self.calls - 1)
    }

    /// Step 3: turns the mounting until the normals agree, or as far as they come (\[0036\]).
    fn align(&mut self, start: Mounting) -> Result<(Mounting, End), SequentialError> {
        let mut history = History::default();
        let mut mounting = start;
        loop {
            let soundings = self.observe(&mounting);
            let normals = Normals::of_soundings(&soundings, self.scanner)?;
            let truth = Normals::of_scanner(self.scanner);
            let turn_t = normals.correction_rad(&truth, self.config.variant);
            let angle_rad = normals.angles_rad(&truth);
            history.push(mounting, angle_rad, self.record(&mounting, angle_rad));
            if let Some(end) = history.end(&turn_t, self.config) {
                return Ok((history.kept(&end).unwrap_or(mounting), end));
            }
            let body = soundings.upright().mean_attitude("P1 to P3")?;
            mounting.rotation = body_correction(&body.tr_mul(&turn_t)) * mounting.rotation;
        }
    }

    /// Step 4: offsets along X, Z, Y in this order, the soundings georeferenced anew before each (\[0038\]-\[0041\]).
    fn shift(&mut self, start: Mounting) -> Result<Mounting, SequentialError> {
        let mut mounting = start;
        for axis in [Axis::X, Axis::Z, Axis::Y] {
            let soundings = self.observe(&mounting);
            let step = OffsetStep::find(axis, self.scanner, &soundings)?;
            mounting.lever_arm_m += step.body_m;
            self.offsets.push(step);
        }
        Ok(mounting)
    }

    /// Records a pass and gives its number.
    fn record(&mut self, mounting: &Mounting, angle_rad: [f64; 4]) -> u32 {
        let number = self.passes.len() as u32;
        self.passes.push(Pass {
            number,
            angle_rad,
            correction_rad: mounting.correction_from(self.nominal),
        });
        number
    }

    fn outcome(self, mounting: Mounting, end: End, rounds: u32) -> Outcome {
        Outcome {
            variant: self.config.variant,
            repeated: self.config.repeated,
            end,
            nominal: *self.nominal,
            mounting,
            passes: self.passes,
            offsets: self.offsets,
            rounds,
        }
    }
}
