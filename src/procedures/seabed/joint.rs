//! The joint path: soundings of overlapping lines on an unknown seabed, in one adjustment.
//!
//! 1. screen each line against its own surface;
//! 2. the field's parameters from single lines, which a misalignment cannot enter;
//! 3. coarse passes, angles and latency only, the noise inflated at first;
//! 4. fine passes with everything, tiles drawn anew once, the field estimated again;
//! 5. covariance, the scatter of the tiles beside it, and what relief and motion give alone.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::config::JointSettings;
use super::doubts::{Doubts, System};
use super::field::{Field, Points};
use super::model::{Locator, Values};
use super::normal::{
    Block, Normal, Part, Placed, Solved, Sought, block, prior_information, sandwich_variances,
};
use super::parameters::{self, Kind, Parameter};
use super::reml::{Bounds, restricted_likelihood};
use super::scene::{Scene, Sounding};
use super::screen::Screen;
use super::shared::shared_noise;
use super::shares::Shares;
use super::states::States;
use super::tiles::{Candidate, Cut, Tile, depth_scale};
use crate::calibrate::verdict::Doubted;
use crate::calibrate::verdict::bounds::Share;
use crate::observe::Mounting;
use crate::watch::{Stopped, Unwatched, Watch};

/// Why there is no joint solution at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JointError {
    /// Stopped by whoever watches.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The profile cannot be used.
    #[error("the sound-speed profile cannot be used")]
    Profile,
    /// No tile has soundings of two lines.
    #[error(
        "no piece of seabed was sounded by two lines: {usable} of {all} soundings lie on a surface"
    )]
    NoOverlap {
        /// Soundings that passed the screen.
        usable: usize,
        /// All.
        all: usize,
    },
    /// The observations tell nothing of an unknown of the caller's own.
    #[error(
        "extra {name}: found an effect that no sounding tells of, expected one on soundings that lines have in common, other than that of every other unknown"
    )]
    Extra {
        /// Its name.
        name: String,
    },
    /// The normal matrix is not positive definite.
    #[error("the normal equations of pass {pass} are singular")]
    Singular {
        /// Which pass.
        pass: usize,
    },
}

/// One pass, for the report.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Pass {
    /// `coarse` or `fine`.
    pub phase: &'static str,
    /// Tiles that took part.
    pub tiles: usize,
    /// Soundings that took part.
    pub soundings: usize,
    /// Soundings dropped by their residual.
    pub dropped: usize,
    /// Largest step of a parameter, in its sigma.
    pub step_sigmas: f64,
    /// Sum of squares over degrees of freedom.
    pub omega_over_freedom: f64,
}

/// The joint solution.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The parameters, in the order of all that follows.
    pub parameters: Vec<Parameter>,
    /// Values found.
    pub values: Values,
    /// Which parameters were sought.
    pub sought: Vec<bool>,
    /// Distance of every parameter from its nominal value.
    pub off: Vec<f64>,
    /// Standard deviation of what is known of each beforehand, where there is such.
    pub priors: Vec<Option<f64>>,
    /// Covariance of the parameters.
    pub covariance: Vec<Vec<f64>>,
    /// What each source has in it.
    pub shares: Shares,
    /// Standard deviations from the scatter of the tiles.
    pub sandwich_sigma: Vec<f64>,
    /// Factor by which the model's sigma was widened to the tiles' scatter, 1 where it was not.
    pub inflation: Vec<f64>,
    /// Standard deviations from the relief alone.
    pub relief_sigma: Option<Vec<f64>>,
    /// Standard deviations from the boat's motion alone.
    pub motion_sigma: Option<Vec<f64>>,
    /// The field.
    pub field: Field,
    /// Keys of the noise that was assumed.
    pub assumed: Vec<&'static str>,
    /// Whether the last steps were small.
    pub converged: bool,
    /// Every pass.
    pub passes: Vec<Pass>,
    /// Sum of squares over degrees of freedom.
    pub omega_over_freedom: f64,
    /// Degrees of freedom.
    pub freedom: f64,
    /// Side of a tile, metres.
    pub tile_m: f64,
    /// The last tiles.
    pub tiles: Vec<Tile>,
    /// Which soundings were kept by screen and residuals.
    pub alive: Vec<bool>,
    /// Soundings dropped by the screen.
    pub screened: usize,
    /// Soundings dropped by their residuals.
    pub rejected: usize,
    /// The states' layout.
    pub states: States,
    /// What the score tests say; nothing of a survey that is only foreseen, or fitted to be compared.
    pub doubted: Doubted,
}

impl Joint {
    /// Standard deviation of a parameter.
    #[must_use]
    pub fn sigma(&self, parameter: usize) -> f64 {
        self.covariance[parameter][parameter].max(0.0).sqrt()
    }

    /// Places of the parameters that may be reported as determined.
    pub fn reported(&self) -> impl Iterator<Item = usize> {
        reported(&self.parameters)
    }

    /// By how much a head's mounting is turned from the nominal one, radians.
    #[must_use]
    pub fn turn_rad(&self, head: usize) -> f64 {
        Vector3::from(parameters::own(head).0.map(|k| self.off[k])).norm()
    }

    /// The soundings of the common tiles that the last pass kept; nothing of a survey that is only foreseen, for it has none.
    #[must_use]
    pub fn kept(&self) -> Option<Share> {
        let used = self.passes.last()?.soundings;
        Some(Share {
            name: "soundings of the common tiles".to_owned(),
            candidates: used + self.rejected,
            used,
        })
    }

    /// By how much a line's heights are to be lifted, metres.
    #[must_use]
    pub fn line_height_m(&self, line: usize) -> f64 {
        self.values.states[self.states.height_of(line)]
    }
}

/// Places of the parameters that may be reported as determined.
pub(super) fn reported(parameters: &[Parameter]) -> impl Iterator<Item = usize> {
    let places = parameters.iter().enumerate();
    places.filter_map(|(k, p)| p.kind.is_reported().then_some(k))
}

/// A solve under way.
struct Work<'a> {
    scene: &'a Scene,
    config: &'a JointSettings,
    states: States,
    values: Values,
    alive: Vec<bool>,
    field: Field,
    scale: f64,
    passes: Vec<Pass>,
    rejected: usize,
    watch: &'a dyn Watch,
}

/// What a pass found.
struct Passed {
    blocks: Vec<Block>,
    solved: Solved,
    normal: Normal,
}

/// Where a solve ended.
struct Ended {
    tiles: Vec<Tile>,
    converged: bool,
    screened: usize,
    /// Whether the sigmas from the motion alone are wanted.
    motion: bool,
}

/// Calibrates jointly.
///
/// # Errors
/// [`JointError`] where nothing can be solved; a solution that must not be used is the verdict's matter.
pub fn joint(scene: &Scene, config: &JointSettings) -> Result<Joint, JointError> {
    joint_watched(scene, config, &Unwatched)
}

/// As [`joint`], watched.
///
/// # Errors
/// As [`joint`]; [`JointError::Stopped`].
pub fn joint_watched(
    scene: &Scene,
    config: &JointSettings,
    watch: &dyn Watch,
) -> Result<Joint, JointError> {
    let (work, ended) = Work::solved(scene, config, watch)?;
    let system = work.doubted(&ended.tiles)?;
    let mut found = work.finish(ended)?;
    found.doubted = system.map_or_else(Doubted::default, |system| system.tested(scene, &found));
    Ok(found)
}

/// As [`joint`], without score tests: for fits that are only compared with each other.
///
/// # Errors
/// As [`joint`].
pub fn fitted(scene: &Scene, config: &JointSettings) -> Result<Joint, JointError> {
    let (work, ended) = Work::solved(scene, config, &Unwatched)?;
    work.finish(ended)
}

/// What would be found of a survey whose values and field are known: covariances and sigmas, nothing is solved for.
///
/// # Errors
/// As [`joint`].
pub fn foreseen(
    scene: &Scene,
    config: &JointSettings,
    mountings: Vec<Mounting>,
    latency_s: f64,
    field: Field,
) -> Result<Joint, JointError> {
    let mut work = Work::new(scene, config, &Unwatched);
    work.values.mountings = mountings;
    work.values.latency_s = latency_s;
    work.field = field;
    let screened = work.screen()?;
    let cut = work.cut(config.seabed.tile_m, 2, config.seabed.max_tiles, 0);
    let tiles = work.overlap(cut.tiles(&work.candidates(usize::MAX)?))?;
    work.finish(Ended {
        tiles,
        converged: true,
        screened,
        motion: false,
    })
}

/// The seabed of a survey, before anything is solved.
#[derive(Clone, Debug)]
pub struct Relief {
    /// Its relief, as single lines have it.
    pub field: Field,
    /// Soundings on it at the nominal mounting, evenly drawn, metres.
    pub points_m: Vec<Vector3<f64>>,
}

/// Reads the relief from single lines, which a misalignment cannot enter.
///
/// # Errors
/// [`JointError`] where the profile cannot be used.
pub fn relief(scene: &Scene, config: &JointSettings) -> Result<Relief, JointError> {
    let mut work = Work::new(scene, config, &Unwatched);
    work.screen()?;
    work.field_of_single_lines()?;
    let candidates = work.candidates(COARSE_SOUNDINGS)?;
    Ok(Relief {
        field: work.field,
        points_m: candidates.iter().map(|c| c.point_m).collect(),
    })
}

/// Where lines meet, before anything is solved.
#[derive(Clone, Debug)]
pub struct Overlap {
    /// Which soundings passed the screen.
    pub alive: Vec<bool>,
    /// Tiles that at least two lines sounded, at the nominal mounting.
    pub tiles: Vec<Tile>,
}

/// Screens a survey and looks where its lines meet.
///
/// # Errors
/// [`JointError`] where they do not.
pub fn overlap(scene: &Scene, config: &JointSettings) -> Result<Overlap, JointError> {
    let mut work = Work::new(scene, config, &Unwatched);
    work.screen()?;
    let cut = work.cut(config.seabed.tile_m, 2, config.seabed.max_tiles, 0);
    let tiles = work.overlap(cut.tiles(&work.candidates(COARSE_SOUNDINGS)?))?;
    Ok(Overlap {
        alive: work.alive,
        tiles,
    })
}

/// Soundings of which the coarse phase and the field's tiles are drawn at most.
const COARSE_SOUNDINGS: usize = 300_000;
/// Tiles that the field's parameters are estimated from.
const FIELD_TILES: usize = 48;
/// How often they are cleaned of gross errors and the parameters estimated again.
const FIELD_ROUNDS: usize = 4;
/// Passes of the coarse phase.
const COARSE_PASSES: usize = 5;
/// Before this fine pass the tiles are drawn anew.
const REDRAW: usize = 3;
/// Before these fine passes the field is estimated again, of what the residuals have left: gross errors that were still there at the
/// time before make its noise too large.
const FIELD_AGAIN: [usize; 2] = [REDRAW, REDRAW + 2];
/// A scatter of the tiles' scores so many times the model's sigma is no chance: with 20 tiles the ratio is known to a sixth.
pub(super) const SCATTER: f64 = 1.3;
/// A step below this, in sigmas, is the end.
const SMALL_STEP: f64 = 0.03;
/// How well common warps of a tile are known, coarse and fine passes. The ground is no ruler: waves across the track are rougher along it than the field,
/// which has no direction, and what a prior of a metre holds of a stretch went into the range scale and, on oblique waves, into yaw. Far off it steadies the steps.
pub(super) const WARP_SIGMA_M: [f64; 2] = [1.0, 10.0];
/// A step that is more than this of the one before does not end by itself.
const SHRINKS: f64 = 0.7;
/// The least share of a step that is taken.
const LEAST_SHARE: f64 = 0.125;

impl<'a> Work<'a> {
    /// Solves for everything.
    fn solved(
        scene: &'a Scene,
        config: &'a JointSettings,
        watch: &'a dyn Watch,
    ) -> Result<(Self, Ended), JointError> {
        let mut work = Self::new(scene, config, watch);
        let screened = work.screen()?;
        work.field_of_single_lines()?;
        work.coarse()?;
        let (tiles, converged) = work.fine()?;
        let ended = Ended {
            tiles,
            converged,
            screened,
            motion: true,
        };
        Ok((work, ended))
    }

    fn new(scene: &'a Scene, config: &'a JointSettings, watch: &'a dyn Watch) -> Self {
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        Self {
            scene,
            config,
            values: Values::nominal(scene, &states),
            states,
            alive: vec![true; scene.soundings.len()],
            field: Field {
                sigma_m: 0.06,
                length_m: 4.0,
                noise_factor: 1.0,
            },
            scale: depth_scale(scene.typical_depth_m()),
            passes: vec![],
            rejected: 0,
            watch,
        }
    }

    fn locator(&self) -> Result<Locator<'_>, JointError> {
        self.watch.go_on()?;
        Locator::new(self.scene, &self.states, &self.values).ok_or(JointError::Profile)
    }

    /// Every so-manieth living sounding on the seabed.
    fn candidates(&self, most: usize) -> Result<Vec<Candidate>, JointError> {
        let locator = self.locator()?;
        let stride = self.scene.soundings.len().div_ceil(most).max(1);
        let one = |k: usize| {
            Some(Candidate {
                sounding: k as u32,
                strip: self.scene.strip(&self.scene.soundings[k]),
                point_m: locator.locate(k)?.point_m,
            })
        };
        let all = (0..self.scene.soundings.len()).into_par_iter();
        Ok(all
            .filter(|k| k % stride == 0 && self.alive[*k])
            .filter_map(one)
            .collect())
    }

    /// Drops what does not lie on its line's own surface, and counts it.
    fn screen(&mut self) -> Result<usize, JointError> {
        let screen = Screen::for_depth(self.scene.typical_depth_m());
        let widest = self.config.max_angle_deg.to_radians();
        let locator = self.locator()?;
        let points: Vec<_> = (0..self.scene.soundings.len())
            .into_par_iter()
            .map(|k| {
                let inside = self.scene.aside_rad(k).abs() <= widest;
                inside.then(|| locator.locate(k).map(|l| l.point_m))?
            })
            .collect();
        let mut alive = vec![];
        let mut begin = 0;
        let one = |a: &Sounding, b: &Sounding| self.scene.strip(a) == self.scene.strip(b);
        for strip in self.scene.soundings.chunk_by(one) {
            let end = begin + strip.len();
            let seed = self.config.seed ^ (u64::from(self.scene.strip(&strip[0])) << 16);
            alive.extend(screen.keep(&points[begin..end], seed));
            begin = end;
        }
        self.alive = alive;
        Ok(self.alive.iter().filter(|kept| !**kept).count())
    }

    fn cut(&self, side_m: f64, strips: usize, tiles: usize, seed: u64) -> Cut {
        Cut {
            side_m: side_m * self.scale,
            most: self.config.seabed.soundings_per_tile,
            fewest: 6,
            strips,
            tiles,
            least_m: 0.12 * self.scale,
            seed: self.config.seed.wrapping_add(seed),
        }
    }

    /// Estimates the field from tiles of single lines.
    fn field_of_single_lines(&mut self) -> Result<(), JointError> {
        let candidates = self.candidates(COARSE_SOUNDINGS)?;
        let strips = self.scene.lines.len() * self.scene.heads.len();
        let mut tiles = vec![];
        for strip in 0..strips {
            let own: Vec<Candidate> = candidates
                .iter()
                .filter(|c| c.strip as usize == strip)
                .copied()
                .collect();
            let cut = Cut {
                fewest: 20,
                ..self.cut(
                    self.config.seabed.tile_m,
                    1,
                    FIELD_TILES.div_ceil(strips),
                    11,
                )
            };
            tiles.extend(cut.tiles(&own));
        }
        self.estimate_field(&tiles)
    }

    fn estimate_field(&mut self, tiles: &[Tile]) -> Result<(), JointError> {
        let stride = tiles.len().div_ceil(FIELD_TILES).max(1);
        let chosen: Vec<&Tile> = tiles.iter().step_by(stride).collect();
        let locator = Locator::new(self.scene, &self.states, &self.values);
        let locator = locator.ok_or(JointError::Profile)?;
        let placed = |tile: &&Tile| Placed::new(self.scene, &locator, tile, &self.alive).points;
        let mut points: Vec<Points> = chosen.par_iter().map(placed).collect();
        for _ in 0..FIELD_ROUNDS {
            self.watch.go_on()?;
            let before: usize = points.iter().map(|p| p.at_m.len()).sum();
            points.retain(|p| p.at_m.len() >= 12);
            let start = self.field;
            if let Some(field) = restricted_likelihood(&points, &start, &Bounds::default()) {
                self.field = field;
            }
            // gross errors make the noise look large and hide behind it: they are judged by the noise that is claimed
            let strict = Field {
                noise_factor: self.field.noise_factor.min(1.0),
                ..self.field
            };
            let limit = self.config.seabed.reject_sigmas;
            let cleaned = points
                .into_par_iter()
                .map(|p| p.without_gross(&strict, limit));
            points = cleaned.collect();
            if points.iter().map(|p| p.at_m.len()).sum::<usize>() == before {
                break;
            }
        }
        Ok(())
    }

    fn overlap(&self, tiles: Vec<Tile>) -> Result<Vec<Tile>, JointError> {
        if tiles.is_empty() {
            return Err(JointError::NoOverlap {
                usable: self.alive.iter().filter(|kept| **kept).count(),
                all: self.alive.len(),
            });
        }
        Ok(tiles)
    }

    /// Angles and latency on wide tiles, with noise inflated at first so that a start far off still finds its way.
    fn coarse(&mut self) -> Result<(), JointError> {
        for pass in 0..COARSE_PASSES {
            let cut = self.cut(
                10.0,
                2,
                self.config.seabed.max_tiles.min(300),
                20 + pass as u64,
            );
            let tiles = self.overlap(cut.tiles(&self.candidates(COARSE_SOUNDINGS)?))?;
            let mut sought = self.sought(false);
            sought.inflation = (100.0 * 0.25f64.powi(pass as i32)).max(1.0);
            let passed = self.pass(&tiles, &sought, pass)?;
            self.note("coarse", &tiles, &passed, &sought, 0);
            self.values = self.values.stepped(&passed.solved.step);
        }
        // heights of lines begin the fine phase at nothing, as the states do
        self.values.states.fill(0.0);
        Ok(())
    }

    /// Everything, until the steps are small.
    fn fine(&mut self) -> Result<(Vec<Tile>, bool), JointError> {
        let mut tiles = vec![];
        let sought = self.sought(true);
        // weights follow the unknowns, so that on smooth ground whole steps can go to and fro between two places
        let mut share = 1.0f64;
        for pass in 0..self.config.seabed.max_passes {
            self.watch.counted(pass, self.config.seabed.max_passes);
            if pass == 0 || pass == REDRAW {
                let cut = self.cut(
                    self.config.seabed.tile_m,
                    2,
                    self.config.seabed.max_tiles,
                    pass as u64,
                );
                tiles = self.overlap(cut.tiles(&self.candidates(usize::MAX)?))?;
            }
            if FIELD_AGAIN.contains(&pass) {
                self.estimate_field(&tiles)?;
            }
            let passed = self.pass(&tiles, &sought, COARSE_PASSES + pass)?;
            let tests = pass > 0 && pass != REDRAW;
            let dropped = if tests { self.reject(&passed) } else { 0 };
            let step_sigmas = self.note("fine", &tiles, &passed, &sought, dropped);
            let settled = pass > FIELD_AGAIN[1] && dropped == 0;
            if settled && !self.shrinks() {
                share = (0.5 * share).max(LEAST_SHARE);
            }
            let step: Vec<f64> = passed.solved.step.iter().map(|s| share * s).collect();
            self.values = self.values.stepped(&step);
            if settled && step_sigmas < SMALL_STEP {
                return Ok((tiles, true));
            }
        }
        Ok((tiles, false))
    }

    fn sought(&self, fine: bool) -> Sought {
        let seabed = &self.config.seabed;
        let is_sought = |p: &Parameter| match p.kind {
            Kind::Pitch | Kind::Roll | Kind::Yaw => true,
            Kind::Latency => seabed.latency,
            Kind::RangeScale if !seabed.range_scale => false,
            Kind::Own => fine,
            _ => fine && self.scene.prior_sigma(p) > 0.0,
        };
        Sought {
            parameters: self.scene.parameters().iter().map(is_sought).collect(),
            states: fine,
            inflation: 1.0,
            warp_m: 4.0 * self.scale,
            warp_sigma_m: WARP_SIGMA_M[usize::from(fine)],
            doubts: None,
        }
    }

    fn blocks(
        &self,
        tiles: &[Tile],
        sought: &Sought,
        part: Part,
    ) -> Result<Vec<Block>, JointError> {
        let locator = self.locator()?;
        let one = |tile: &Tile| {
            self.watch.go_on().ok()?;
            let placed = Placed::new(self.scene, &locator, tile, &self.alive);
            block(&locator, &placed, &self.field, sought, part)
        };
        let blocks = tiles.par_iter().filter_map(one).collect();
        self.watch.go_on()?;
        Ok(blocks)
    }

    fn normal(&self, blocks: &[Block], sought: &Sought) -> Normal {
        let off = self.values.from_nominal(self.scene);
        Normal::new(
            self.scene,
            &self.states,
            blocks,
            sought,
            &off,
            &self.values.states,
        )
    }

    fn pass(&self, tiles: &[Tile], sought: &Sought, pass: usize) -> Result<Passed, JointError> {
        let blocks = self.blocks(tiles, sought, Part::All)?;
        let normal = self.normal(&blocks, sought);
        let Some(solved) = normal.solve() else {
            return Err(self.singular(tiles, sought, pass)?);
        };
        let mut own = sought.own(self.scene);
        if let Some(k) = own.find(|k| normal.is_taken_up(*k, &solved)) {
            return Err(self.untold(k));
        }
        Ok(Passed {
            blocks,
            solved,
            normal,
        })
    }

    fn untold(&self, parameter: usize) -> JointError {
        let name = self.scene.parameters()[parameter].name();
        JointError::Extra { name }
    }

    /// Why normal equations are singular: an unknown of the caller's own, if they are not without it.
    fn singular(
        &self,
        tiles: &[Tile],
        sought: &Sought,
        pass: usize,
    ) -> Result<JointError, JointError> {
        for k in sought.own(self.scene) {
            let mut without = sought.clone();
            without.parameters[k] = false;
            let blocks = self.blocks(tiles, &without, Part::All)?;
            if self.normal(&blocks, &without).solve().is_some() {
                return Ok(self.untold(k));
            }
        }
        Ok(JointError::Singular { pass })
    }

    /// Writes a pass down and gives its largest step in sigmas.
    fn note(
        &mut self,
        phase: &'static str,
        tiles: &[Tile],
        passed: &Passed,
        sought: &Sought,
        dropped: usize,
    ) -> f64 {
        let steps = (0..sought.parameters.len())
            .filter(|k| sought.parameters[*k])
            .map(|k| (passed.solved.step[k] / passed.solved.sigma(k).max(f64::MIN_POSITIVE)).abs());
        let step_sigmas = steps.fold(0.0, f64::max);
        self.passes.push(Pass {
            phase,
            tiles: tiles.len(),
            soundings: passed.blocks.iter().map(|b| b.standardised.len()).sum(),
            dropped,
            step_sigmas,
            omega_over_freedom: passed.normal.omega / passed.normal.freedom,
        });
        step_sigmas
    }

    /// Whether the last step is smaller than the one before.
    fn shrinks(&self) -> bool {
        match &self.passes[..] {
            [.., before, last] => last.step_sigmas <= SHRINKS * before.step_sigmas,
            _ => true,
        }
    }

    /// Drops the soundings whose residuals are too large.
    fn reject(&mut self, passed: &Passed) -> usize {
        let all = passed.blocks.iter().flat_map(|b| &b.standardised);
        let bad: Vec<u32> = all
            .filter(|(_, w)| w.abs() > self.config.seabed.reject_sigmas)
            .map(|(k, _)| *k)
            .collect();
        for k in &bad {
            self.alive[*k as usize] = false;
        }
        self.rejected += bad.len();
        bad.len()
    }

    /// Standard deviations when only a part of the derivatives counts.
    fn part_sigma(
        &self,
        tiles: &[Tile],
        sought: &Sought,
        part: Part,
    ) -> Result<Option<Vec<f64>>, JointError> {
        let blocks = self.blocks(tiles, sought, part)?;
        let solved = self.normal(&blocks, sought).solve();
        let count = sought.parameters.len();
        Ok(solved.map(|s| (0..count).map(|k| s.sigma(k)).collect()))
    }

    /// What the score tests of what the model has not need of the solution.
    fn doubted(&self, tiles: &[Tile]) -> Result<Option<System>, JointError> {
        let doubts = Doubts::of(self.scene);
        let sought = Sought {
            doubts: Some(doubts.clone()),
            ..self.sought(true)
        };
        let normal = self.normal(&self.blocks(tiles, &sought, Part::All)?, &sought);
        Ok(System::of(doubts, normal))
    }

    fn finish(self, ended: Ended) -> Result<Joint, JointError> {
        let Ended {
            tiles,
            converged,
            screened,
            motion,
        } = ended;
        let sought = self.sought(true);
        let passed = self.pass(
            &tiles,
            &sought,
            COARSE_PASSES + self.config.seabed.max_passes,
        )?;
        let sandwich = sandwich_variances(self.scene, &self.states, &passed.blocks, &passed.solved);
        let shared = shared_noise(
            &self.locator()?,
            &tiles,
            &self.alive,
            (&self.field, &sought),
            &passed.solved,
        );
        let sandwich_sigma: Vec<f64> = sandwich.iter().map(|v| v.max(0.0).sqrt()).collect();
        let modelled = |a: usize, b: usize| passed.solved.covariance(a, b) + shared.extra[(a, b)];
        let count = sought.parameters.len();
        let widened = |k: usize| {
            let ratio = sandwich_sigma[k] / modelled(k, k).sqrt().max(f64::MIN_POSITIVE);
            if sought.parameters[k] && ratio > SCATTER {
                ratio
            } else {
                1.0
            }
        };
        let inflation: Vec<f64> = (0..count).map(widened).collect();
        let covariance = |a: usize, b: usize| {
            let held = !sought.parameters[a] || !sought.parameters[b];
            if held {
                0.0
            } else {
                modelled(a, b) * inflation[a] * inflation[b]
            }
        };
        let prior = prior_information(self.scene);
        Ok(Joint {
            shares: Shares::new(&self.states, &prior, &passed.solved, &shared),
            off: self.values.from_nominal(self.scene),
            priors: prior
                .iter()
                .map(|information| (*information > 0.0).then(|| information.sqrt().recip()))
                .collect(),
            parameters: self.scene.parameters(),
            covariance: (0..count)
                .map(|a| (0..count).map(|b| covariance(a, b)).collect())
                .collect(),
            sandwich_sigma,
            inflation,
            sought: sought.parameters.clone(),
            relief_sigma: self.part_sigma(&tiles, &sought, Part::Relief)?,
            motion_sigma: match motion {
                true => self.part_sigma(&tiles, &sought, Part::Motion)?,
                false => None,
            },
            field: self.field,
            assumed: self.scene.assumed.clone(),
            converged,
            omega_over_freedom: passed.normal.omega / passed.normal.freedom,
            freedom: passed.normal.freedom,
            passes: self.passes,
            tile_m: self.config.seabed.tile_m * self.scale,
            tiles,
            alive: self.alive,
            screened,
            rejected: self.rejected,
            values: self.values,
            states: self.states,
            doubted: Doubted::default(),
        })
    }
}
