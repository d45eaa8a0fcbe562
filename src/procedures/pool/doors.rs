//! The short door for columns in memory.

use super::summary::{self, Dropped};
use super::{JointConfig, PoolInput, SequentialConfig, calibrate};
use crate::calibrate::seam::{InputError, Settings, provenance};
use crate::geometry::ellipsoid::TargetPose;
use crate::observe::Campaign;
use crate::results::Calibration;
use crate::target::Target;
use crate::watch::Unwatched;

/// Calibrates a multibeam against a target in memory, from columns instead of files, by both paths as they are without configuration.
///
/// ```no_run
/// use boresight::prelude::*;
/// # let (time_s, place, attitude) = (vec![], vec![], vec![]);
/// # let (return_s, points_m, ping_s, across_rad, range_m) = (vec![], vec![], vec![], vec![], vec![]);
/// # let scenario = boresight::simulate::Scenario::from_toml(boresight::simulate::DEMO)?;
/// # let survey = boresight::simulate::simulate(&scenario, 1)?;
/// # let (target, pose) = (survey.target, survey.prior);
/// # let (scanner, sonar) = (survey.campaign.scanner, survey.campaign.sonar);
/// let trajectory = GeodeticTrajectory::from_arrays(time_s, &place, &attitude);
/// let laser = LaserScan::from_arrays(return_s, &points_m);
/// let soundings = Soundings::from_arrays(ping_s, across_rad, range_m);
/// let campaign = Campaign::new(trajectory, (scanner, laser), (sonar, soundings));
/// let found = boresight::calibrate_arrays(&campaign, &target, &pose)?;
/// println!("{:?}", found.solutions.joint.map(|joint| joint.parameters));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// `examples/arrays.rs` is a whole program.
///
/// # Errors
/// [`InputError`] when the observations cannot be worked with at all; a calibration without a usable result is no error.
pub fn calibrate_arrays(
    campaign: &Campaign,
    target: &Target,
    pose: &TargetPose,
) -> Result<Calibration, InputError> {
    let settings = Settings::default();
    let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
    let input = PoolInput {
        campaign,
        target,
        prior: pose,
        method: settings.method,
        sequential: &sequential,
        joint: &joint,
        seed: settings.seed(),
        extras: &[],
    };
    let outcome = calibrate(&input, &Unwatched).map_err(InputError::unworkable)?;
    let configuration = serde_json::json!({ "sequential": sequential, "joint": joint });
    let provenance = provenance(&configuration, &[], &settings)?;
    let dropped = Dropped::default();
    Ok(summary::result(&outcome, &input, dropped, &[], provenance)?)
}
