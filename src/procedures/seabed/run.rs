//! Both paths of a seabed calibration on one survey.

use super::alternatives;
use super::config::JointSettings;
use super::joint::{Joint, JointError, Overlap, joint, joint_watched, overlap};
use super::layout::Layout;
use super::reference::{Reference, ReferenceConfig, ReferenceError, features, patch_test};
use super::scene::Scene;
use super::states::States;
use super::tides;
use super::verdict::{Judgement, judge};
use crate::calibrate::choices::Method;
use crate::results::Finding;
use crate::watch::{Stopped, Unwatched, Watch};

/// A survey and how it is to be calibrated.
pub struct SeabedInput<'a> {
    /// The survey.
    pub scene: &'a Scene,
    /// Which paths run.
    pub method: Method,
    /// The joint path.
    pub joint: &'a JointSettings,
    /// The reference path.
    pub reference: &'a ReferenceConfig,
}

/// What both paths found.
pub struct SeabedOutcome {
    /// The reference path, where it ran.
    pub reference: Option<Result<Reference, ReferenceError>>,
    /// The joint path with its judgement, where it ran.
    pub joint: Option<Result<(Joint, Judgement), JointError>>,
    /// The discrete mistake that explains why the joint path does not fit.
    pub mistake: Option<Finding>,
    /// How the lines lie and meet; nothing where they do not.
    pub layout: Layout,
    /// Which soundings passed the screen and the tests of their residuals; empty where the lines do not meet.
    pub alive: Vec<bool>,
}

/// The reference path that the survey names.
fn by_reference(
    input: &SeabedInput<'_>,
    alive: &[bool],
    layout: &Layout,
) -> Result<Reference, ReferenceError> {
    let (scene, config) = (input.scene, input.reference);
    let states = States::new(&scene.lines, &scene.ins, &scene.drift);
    let widest_rad = input.joint.max_angle_deg.to_radians();
    // the paths of the books know one head: the first of several
    let first = scene.soundings.iter().map(|s| s.head == 0);
    let alive: Vec<bool> = alive.iter().zip(first).map(|(a, f)| *a && f).collect();
    if config.by_features() {
        let found = features(scene, &states, &alive, layout, config, widest_rad)?;
        return Ok(Reference::Features(found));
    }
    let found = patch_test(scene, &states, &alive, layout, config, widest_rad);
    Ok(Reference::Patch(found))
}

/// Calibrates.
#[must_use]
pub fn calibrate(input: &SeabedInput<'_>) -> SeabedOutcome {
    let scene = input.scene;
    let found = (input.method != Method::Reference).then(|| joint(scene, input.joint));
    with_joint(input, found, &Unwatched)
}

/// As [`calibrate`], watched.
///
/// # Errors
/// [`Stopped`].
pub fn calibrate_watched(
    input: &SeabedInput<'_>,
    watch: &dyn Watch,
) -> Result<SeabedOutcome, Stopped> {
    let joint = || joint_watched(input.scene, input.joint, watch);
    let found = (input.method != Method::Reference).then(joint);
    watch.go_on()?;
    let outcome = with_joint(input, found, watch);
    watch.go_on()?;
    Ok(outcome)
}

/// The mistake without which a survey fits that the joint path could not solve, or whose model does not fit.
fn explained(
    input: &SeabedInput<'_>,
    joint: Option<&Result<(Joint, Judgement), JointError>>,
    watch: &dyn Watch,
) -> Option<Finding> {
    let wrong = match joint? {
        Ok((_, judged)) => !judged.usable() && judged.is_of_the_model(),
        Err(error) => !matches!(error, JointError::Stopped(_) | JointError::Extra { .. }),
    };
    wrong
        .then(|| alternatives::named(input.scene, input.joint, watch))
        .flatten()
}

/// The reference path and the judgement beside the joint path.
fn with_joint(
    input: &SeabedInput<'_>,
    found: Option<Result<Joint, JointError>>,
    watch: &dyn Watch,
) -> SeabedOutcome {
    let scene = input.scene;
    let met = match &found {
        Some(Ok(found)) => Ok(Overlap {
            alive: found.alive.clone(),
            tiles: found.tiles.clone(),
        }),
        Some(Err(error)) => Err(error.clone()),
        None => overlap(scene, input.joint),
    };
    let layout = Layout::new(scene, met.as_ref().map_or(&[], |met| &met.tiles));
    let by_reference = (input.method != Method::Joint)
        .then(|| by_reference(input, &met.as_ref().map_err(Clone::clone)?.alive, &layout));
    let joint = found.map(|found| {
        let found = found?;
        let mut judged = judge(&found, &layout, input.joint);
        judged.notes.extend(tides::doubted(scene, &found));
        Ok((found, judged))
    });
    SeabedOutcome {
        reference: by_reference,
        mistake: explained(input, joint.as_ref(), watch),
        joint,
        layout,
        alive: met.map_or_else(|_| vec![], |met| met.alive),
    }
}
