//! Quality figures of the joint path as they stand in a result ([`crate::adjust::assess`]).

use super::super::joint::{RailJoint, Suspect};
use super::super::scene::RailScene;
use super::super::trial::names;
use crate::adjust::{self, Unit};
use crate::calibrate::quality::{Judged, block_priors, group, named_prior, quality};
use crate::results::{Prior, Quality};

pub(super) fn judged(found: &RailJoint, scene: &RailScene) -> Option<Quality> {
    let profilers = &scene.campaign.profilers;
    let name = |g: &adjust::GroupQuality| match profilers.get(usize::from(g.group)) {
        Some(p) => (
            format!("points of {}", p.name),
            "for both coordinates together: they share each condition",
        ),
        None => (
            "INS attitude".to_owned(),
            "for roll, pitch and heading together",
        ),
    };
    let shown = found
        .quality
        .groups
        .iter()
        .map(|g| group(g, &name(g).0, name(g).1));
    quality(Judged {
        quality: &found.quality,
        observability: &found.observability,
        parameters: &found.solution.estimate.parameters,
        sought: &names(profilers),
        priors: priors(found, scene),
        groups: shown.collect(),
        observation: &|place| match found.worst[place] {
            Suspect::Point(row) => {
                let profiler =
                    &profilers[scene.campaign.points.profiler[row as usize] as usize].name;
                format!("point {row} of {profiler}")
            }
            Suspect::Attitude(position) => format!("INS at position {}", position + 1),
        },
        advice: &|_, _| "",
    })
}

fn priors(found: &RailJoint, scene: &RailScene) -> Vec<Prior> {
    let mut all = block_priors(&found.solution.estimate.parameters);
    let sigma = scene.campaign.stand.table_sigma_rad;
    all.push(named_prior(
        "table angle, per position and axis",
        sigma,
        Unit::Radian,
    ));
    all
}
