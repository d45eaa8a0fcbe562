//! A pass whose mounting and target are known, as planning has it: what its observations would tell.

use super::config::{JointConfig, SequentialConfig};
use super::joint::{self, Information, JointStart};
use super::planes::{self, GroupPlanes};
use super::run::{CANDIDATE_M, Method, PoolError, PoolInput, Scanned};
use super::scene::Scene;
use super::ties::tie_soundings_first;
use crate::adjust::AdjustError;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::plane::Plane;
use crate::matching::{Patches, Water};
use crate::observe::{Campaign, Mounting};
use crate::target::Target;

/// An error-free pass with its truth.
#[derive(Clone, Copy, Debug)]
pub struct DesignedPass<'a> {
    /// What would be observed.
    pub campaign: &'a Campaign,
    /// The target, exactly as designed.
    pub target: &'a Target,
    /// Its true pose.
    pub pose: &'a TargetPose,
    /// The true mounting of the sonar.
    pub mounting: Mounting,
}

impl DesignedPass<'_> {
    /// Information on all parameters of the joint path, linearised at the truth: planes at their design position, so that several
    /// passes speak of the same parameters. The engine's refusal, such as too few observations, is the inner result.
    ///
    /// # Errors
    /// [`PoolError`] when the pass cannot be worked with.
    pub fn information(
        &self,
        config: &JointConfig,
    ) -> Result<Result<Information, AdjustError>, PoolError> {
        let sequential = SequentialConfig::default();
        let input = PoolInput {
            campaign: self.campaign,
            target: self.target,
            prior: self.pose,
            method: Method::Joint,
            sequential: &sequential,
            joint: config,
            seed: 0,
            extras: &[],
        };
        let scene = Scene::prepare(self.campaign, self.target, self.pose)?;
        let scanned = Scanned::by(&scene, &input);
        let design = self.on_design(&scanned.planes);
        let origins = scene.origins(&self.mounting);
        let level_m = self.campaign.water_level_m;
        let patches = Patches::new(self.target, Water::Below, level_m, &origins);
        let candidates = scene.soundings_near(&patches, &self.mounting, CANDIDATE_M);
        let soundings = tie_soundings_first(
            &scene,
            &patches,
            &candidates,
            &self.mounting,
            config.gate_sigma,
        );
        let start = JointStart {
            mounting: self.mounting,
            planes: &design,
            returns: &scanned.returns,
            candidates: &candidates,
            soundings: &soundings,
        };
        Ok(joint::information(&scene, &start, config))
    }

    /// The planes that the scanner saw, put where the design has them.
    fn on_design(&self, found: &[Option<planes::GroupPlane>]) -> GroupPlanes {
        let mut design = found.to_vec();
        for (plane, group) in design.iter_mut().zip(&self.target.groups) {
            if let Some(plane) = plane {
                plane.fit.plane = Plane {
                    normal: group.normal,
                    offset_m: 0.0,
                };
            }
        }
        design
    }
}
