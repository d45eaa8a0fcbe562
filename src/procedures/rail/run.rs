//! Both paths in memory.

use rayon::prelude::*;

use super::alternatives;
use super::config::{RailJointConfig, RailReferenceConfig};
use super::icp::Cloud;
use super::joint::{RailJoint, joint};
use super::observed::{Profiler, RailCampaign};
use super::profile::RailProfile;
use super::reference::{RailReference, ReferenceError, cloud, coarse, reference};
use super::scene::RailScene;
use super::verdict::{self, RailRefusal};
use crate::adjust::AdjustError;
use crate::calibrate::choices::Method;
use crate::calibrate::verdict::accepted;
use crate::observe::Mounting;
use crate::results::Finding;

/// What a rail calibration gets.
#[derive(Clone, Copy, Debug)]
pub struct RailInput<'a> {
    /// The observations.
    pub campaign: &'a RailCampaign,
    /// The standard profile.
    pub rail: &'a RailProfile,
    /// Which paths run.
    pub method: Method,
    /// The reference path.
    pub reference: &'a RailReferenceConfig,
    /// The joint path.
    pub joint: &'a RailJointConfig,
}

/// What a rail calibration found.
#[derive(Debug)]
pub struct RailOutcome<'a> {
    /// What both paths worked on.
    pub scene: RailScene<'a>,
    /// The reference path profiler by profiler; `None` when it did not run.
    pub reference: Option<Result<Vec<RailReference>, ReferenceError>>,
    /// The joint path; `None` when it did not run.
    pub joint: Option<Result<RailJoint, AdjustError>>,
    /// Why the deciding path (the joint one where it ran) has no usable result.
    pub refusal: Option<RailRefusal>,
}

/// Start of the joint path: the coarse fit of each profiler, or its nominal mounting where it has no profile.
///
/// # Errors
/// [`ReferenceError::NoProfile`] for a standard profile without points.
pub fn start(
    scene: &RailScene,
    config: &RailReferenceConfig,
) -> Result<Vec<Mounting>, ReferenceError> {
    let profiler = "every".to_owned();
    let points = cloud(scene, config).ok_or(ReferenceError::NoProfile { profiler })?;
    Ok(start_from(scene, config, Some(&points)))
}

fn start_from(
    scene: &RailScene,
    config: &RailReferenceConfig,
    points: Option<&Cloud>,
) -> Vec<Mounting> {
    let profilers = scene.campaign.profilers.iter().enumerate();
    let one = |(p, profiler): (usize, &Profiler)| {
        let found = points.and_then(|c| coarse(scene, config, c, p).ok());
        found.unwrap_or(profiler.nominal)
    };
    profilers.map(one).collect()
}

/// The discrete mistake that explains a misfit or is preferred to a fit; one that the survey cannot tell joins the findings.
fn mistaken(input: &RailInput, joint: &mut RailJoint, refused: bool) -> Option<Finding> {
    if refused || alternatives::is_thin(joint) {
        return alternatives::named(input, joint);
    }
    let found = alternatives::preferred(input, joint);
    joint.doubted.hear(accepted(found, &input.joint.verdict))
}

/// Calibrates by the paths asked for. Never fails: a path without a result says why.
#[must_use]
pub fn calibrate<'a>(input: &RailInput<'a>) -> RailOutcome<'a> {
    let scene = RailScene::new(input.campaign, input.rail);
    let all = 0..input.campaign.profilers.len();
    let points = cloud(&scene, input.reference);
    let by_reference = (input.method != Method::Joint).then(|| {
        let empty = ReferenceError::NoProfile {
            profiler: "every".to_owned(),
        };
        let points = points.as_ref().ok_or(empty)?;
        let each: Vec<_> = all
            .clone()
            .into_par_iter()
            .map(|p| reference(&scene, input.reference, points, p))
            .collect();
        each.into_iter().collect()
    });
    let mut by_joint = (input.method != Method::Reference).then(|| {
        let start = start_from(&scene, input.reference, points.as_ref());
        joint(&scene, input.joint, &start)
    });
    let refused = match (&by_joint, &by_reference) {
        (Some(joint), _) => verdict::after(&scene, input.joint, joint),
        (None, Some(Err(error))) => Some(RailRefusal::NotSolved {
            how: error.to_string(),
        }),
        _ => None,
    };
    let mistake = match &mut by_joint {
        Some(Ok(joint)) => mistaken(input, joint, refused.is_some()),
        _ => None,
    };
    let refusal = mistake
        .map(|finding| RailRefusal::DoesNotFit(Box::new(finding)))
        .or(refused);
    RailOutcome {
        reference: by_reference,
        joint: by_joint,
        refusal,
        scene,
    }
}
