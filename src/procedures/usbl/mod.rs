//! Ultra-short baseline against several beacons: the rotation between transducer and attitude sensor (`docs/usbl.md`).
//!
//! | file | what |
//! |---|---|
//! | [`config`] | the sections of the survey file |
//! | [`observed`] | what the instruments say |
//! | [`formats`](mod@formats) | the files that only this procedure reads |
//! | [`scene`] | a campaign with water and attitude ready |
//! | [`reference`](mod@reference) | the patent's path |
//! | [`conditions`] | the conditions of the joint path and their derivatives |
//! | [`start`] | a start that gross errors do not move |
//! | [`joint`] | the joint path |
//! | [`judge`] | what speaks against a solution |
//! | [`verify`](mod@verify) | the patent's verification: predicted against surveyed beacons |
//! | [`procedure`] | the calibration behind the seam |
//! | [`trials`] | a scenario on trial, for the error budget |
//! | [`verdict`] | what cannot be determined, in words |
//! | [`summary`] | the outcome as `result.json` |

pub mod conditions;
pub mod config;
pub mod formats;
pub mod joint;
pub mod judge;
pub mod observed;
pub mod procedure;
pub mod reference;
pub mod scene;
pub mod simulate;
pub mod start;
pub mod summary;
pub mod survey;
pub mod trials;
pub mod verdict;
pub mod verify;

pub use config::{JointConfig, ReferenceConfig};
pub use joint::JointOutcome;
pub use observed::UsblCampaign;
pub use reference::{PrintedAngles, ReferenceError, ReferenceOutcome};
pub use scene::{Scene, UsblError};
pub use verdict::{Layout, Refusal};

use crate::calibrate::choices::Method;
use crate::results::Finding;
use verify::{BeaconResiduals, Calibrated, verify};

/// What a calibration is made from, and how.
#[derive(Clone, Debug)]
pub struct UsblInput<'a> {
    /// What was observed.
    pub campaign: &'a UsblCampaign,
    /// Which paths run.
    pub method: Method,
    /// The reference path.
    pub reference: ReferenceConfig,
    /// The joint path.
    pub joint: JointConfig,
}

/// What came of it.
#[derive(Debug)]
pub struct UsblOutcome<'a> {
    /// The campaign, ready to be calculated with.
    pub scene: Scene<'a>,
    /// The reference path, where it was asked for.
    pub reference: Option<Result<ReferenceOutcome, ReferenceError>>,
    /// The joint path, where it was asked for and came to an end.
    pub joint: Option<JointOutcome>,
    /// Why there is no usable result; the joint path decides where it was asked for.
    pub refusal: Option<Refusal>,
    /// Verification of the reference path.
    pub reference_residuals: Vec<BeaconResiduals>,
    /// Verification of the joint path.
    pub joint_residuals: Vec<BeaconResiduals>,
}

/// Calibrates in memory.
///
/// # Errors
/// [`UsblError`] for input that no calibration can work with; a calibration without a usable result is an outcome.
pub fn calibrate<'a>(input: &UsblInput<'a>) -> Result<UsblOutcome<'a>, UsblError> {
    let scene = Scene::new(input.campaign)?;
    let reference =
        (input.method != Method::Joint).then(|| reference::run(&scene, &input.reference));
    let (joint, refusal) = if input.method == Method::Reference {
        let failed = reference.as_ref().and_then(|r| r.as_ref().err());
        (None, failed.map(Refusal::of_reference))
    } else {
        let (mut joint, refused) = solved_jointly(&scene, &input.joint);
        let explained = match (&refused, &mut joint) {
            (Some(refusal), _) if refusal.is_of_layout() => None,
            (Some(_), joint) => judge::named(input, &scene, joint.as_ref())
                .or_else(|| undecided(input, joint.as_mut()?)),
            (None, Some(joint)) => undecided(input, joint),
            (None, None) => None,
        };
        let explained = explained.map(|finding| Refusal::DoesNotFit(Box::new(finding)));
        (joint, explained.or(refused))
    };
    let determined = refusal.as_ref().is_none_or(|r| !r.is_of_layout());
    let found = reference
        .as_ref()
        .and_then(|r| r.as_ref().ok())
        .filter(|_| determined);
    let reference_residuals = found.map_or_else(Vec::new, |r| {
        verify(&scene, &Calibrated::reference(&r.rotation), None)
    });
    let usable = joint.as_ref().filter(|_| refusal.is_none());
    let joint_residuals =
        usable.map_or_else(Vec::new, |j| verify(&scene, &Calibrated::joint(j), Some(j)));
    Ok(UsblOutcome {
        reference_residuals,
        joint_residuals,
        scene,
        reference,
        joint,
        refusal,
    })
}

/// The sign or order of the attitude that fits clearly better than what is given; those that the survey cannot tell join the findings.
fn undecided(input: &UsblInput, joint: &mut JointOutcome) -> Option<Finding> {
    let found = judge::preferred(input, joint);
    joint.doubted.hear(found)
}

/// The discrete mistake that explains why a survey does not fit, where it does not.
#[must_use]
pub fn suspected(input: &UsblInput, scene: &Scene) -> Option<Finding> {
    let (joint, refused) = solved_jointly(scene, &input.joint);
    refused
        .filter(|refusal| !refusal.is_of_layout())
        .and_then(|_| judge::named(input, scene, joint.as_ref()))
}

fn solved_jointly(scene: &Scene, config: &JointConfig) -> (Option<JointOutcome>, Option<Refusal>) {
    match joint::run(scene, config) {
        Ok(Some(joint)) => {
            let refusal = Refusal::of_joint(&joint, scene, config);
            (Some(joint), refusal)
        }
        Ok(None) => (None, Some(Refusal::NoBeacon)),
        Err(error) => (None, Some(Refusal::failed(&error))),
    }
}
