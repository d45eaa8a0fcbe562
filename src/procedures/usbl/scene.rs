//! A campaign ready to be calculated with: the water, the attitude at every fix.

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use super::observed::{Role, UsblCampaign};
use crate::georef::{Eigenray, Medium, RayError};
use crate::observe::{PoseSample, TrajectoryError};

/// Input that no calibration can work with.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UsblError {
    /// The sound speed cannot be used.
    #[error("sound speed: {0}")]
    Water(RayError),
    /// A fix has no attitude.
    #[error("fix {fix} of beacon {beacon}: {source}")]
    Attitude {
        /// Row of the fix, from 0.
        fix: usize,
        /// Name of its beacon.
        beacon: String,
        /// Why not.
        source: TrajectoryError,
    },
}

/// A campaign with what follows from it directly.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// What was observed.
    pub campaign: &'a UsblCampaign,
    /// The water.
    pub medium: Medium,
    /// Attitude at every fix: rotation from the body into the level frame.
    pub poses: Vec<PoseSample>,
    /// Rows of the fixes of common beacons, ascending in time.
    pub common: Vec<u32>,
}

impl<'a> Scene<'a> {
    /// Looks up the attitude of every fix.
    ///
    /// # Errors
    /// [`UsblError`].
    pub fn new(campaign: &'a UsblCampaign) -> Result<Self, UsblError> {
        let medium = Medium::new(&campaign.sound_speed).map_err(UsblError::Water)?;
        let fixes = &campaign.fixes;
        let pose = |fix: usize| {
            campaign
                .attitude
                .pose_at(fixes.time_s[fix])
                .map_err(|source| UsblError::Attitude {
                    fix,
                    beacon: campaign.beacons[fixes.beacon[fix] as usize]
                        .point
                        .name
                        .clone(),
                    source,
                })
        };
        let poses = (0..fixes.len()).map(pose).collect::<Result<_, _>>()?;
        let is_common =
            |fix: &u32| campaign.beacons[fixes.beacon[*fix as usize] as usize].role == Role::Common;
        Ok(Self {
            campaign,
            medium,
            poses,
            common: (0..fixes.len() as u32).filter(is_common).collect(),
        })
    }

    /// Depth of the transducer below the water level when its centre is at `position_m` (level frame), metres.
    #[must_use]
    pub fn depth_m(&self, position_m: &Vector3<f64>) -> f64 {
        self.campaign.transducer_depth_m - position_m.z
    }

    /// The ray from the transducer to a beacon, both in the level frame (metres).
    ///
    /// # Errors
    /// [`RayError`] when there is none.
    pub fn ray(
        &self,
        transducer_m: &Vector3<f64>,
        beacon_m: &Vector3<f64>,
    ) -> Result<Eigenray, RayError> {
        self.medium
            .eigenray(self.depth_m(transducer_m), &(beacon_m - transducer_m))
    }

    /// Where a fix puts its beacon, seen from the transducer, in the level frame (metres), when `level_from_transducer` is the
    /// transducer's attitude, its centre is at `transducer_m`, and true ranges are `scale` longer than measured ones.
    ///
    /// # Errors
    /// [`RayError`] when the ray leaves the water.
    pub fn point(
        &self,
        fix: usize,
        level_from_transducer: &Matrix3<f64>,
        transducer_m: &Vector3<f64>,
        scale: f64,
    ) -> Result<Vector3<f64>, RayError> {
        let fixes = &self.campaign.fixes;
        let direction = level_from_transducer * fixes.direction[fix];
        let time_s = fixes.travel_time_s[fix] * (1.0 + scale);
        self.medium
            .end(self.depth_m(transducer_m), &direction, time_s)
    }

    /// Beacons that enter the calibration and have a fix.
    #[must_use]
    pub fn common_beacons(&self) -> Vec<u32> {
        let fixes = &self.campaign.fixes;
        let mut seen = vec![false; self.campaign.beacons.len()];
        self.common
            .iter()
            .for_each(|fix| seen[fixes.beacon[*fix as usize] as usize] = true);
        (0..seen.len() as u32)
            .filter(|b| seen[*b as usize])
            .collect()
    }
}
