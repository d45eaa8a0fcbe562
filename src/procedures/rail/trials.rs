//! A rail scenario's trials.

use super::simulate::{RailScenario, RailScenarioError, RailSource, RailSources};
use super::trial::{RailTrial, trial_with};
use super::{RailJointConfig, RailReferenceConfig};
use crate::calibrate::tried::{Acting, JointSaid, NamedTrial, Tried, word};
use crate::results::{NamedParameter, NamedSource};
use crate::target::RailProfile;

/// A rail scenario and how it is calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct RailTrials {
    /// What is simulated.
    pub scenario: RailScenario,
    /// The standard profile.
    pub rail: RailProfile,
    /// The reference path.
    pub reference: RailReferenceConfig,
    /// The joint path.
    pub joint: RailJointConfig,
}

impl RailTrials {
    /// The sources that act, with their sizes in words.
    fn acting(&self) -> Vec<(RailSource, &'static str, String)> {
        let acts = |source: &RailSource| self.scenario.sources.factor(*source) > 0.0;
        let all = RailSource::ALL.into_iter().filter(|(s, ..)| acts(s));
        all.filter_map(|(source, title, shared)| {
            let size = size(&self.scenario, source)?;
            Some((source, title, format!("{shared}; {size}")))
        })
        .collect()
    }

    fn trial_with(&self, sources: &RailSources, seed: u64) -> Result<RailTrial, RailScenarioError> {
        let paths = (&self.reference, &self.joint);
        trial_with(&self.scenario, &self.rail, sources, paths, seed)
    }

    fn sources_of(&self, acting: Acting) -> RailSources {
        let own = &self.scenario.sources;
        match acting {
            Acting::All => own.clone(),
            Acting::None => RailSources::none(),
            Acting::Only(place) => {
                let source = self.acting()[place].0;
                RailSources::none().with(source, own.factor(source))
            }
        }
    }
}

/// How large a source is in a scenario, in words; `None` when it is nothing.
fn size(scenario: &RailScenario, source: RailSource) -> Option<String> {
    let (table, rail) = (&scenario.table, &scenario.rail);
    let of = |pick: &dyn Fn(usize) -> f64| {
        let count = scenario.profiler.len();
        (0..count).map(pick).fold(0.0, f64::max)
    };
    let p = &scenario.profiler;
    let (value, unit) = match source {
        RailSource::Lateral => (of(&|i| p[i].lateral_sigma_m), "m"),
        RailSource::Vertical => (of(&|i| p[i].vertical_sigma_m), "m"),
        RailSource::RollPitch => (scenario.attitude.roll_pitch_sigma_deg, "deg"),
        RailSource::Heading => (scenario.attitude.heading_sigma_deg, "deg"),
        RailSource::Table => (table.angle_sigma_deg, "deg"),
        RailSource::Level => (table.level_sigma_deg.max(table.zero_sigma_deg), "deg"),
        RailSource::Seating => (table.seating_sigma_deg, "deg"),
        RailSource::PivotBody => (table.pivot_body_sigma_m, "m"),
        RailSource::PivotRail => (table.pivot_rail_sigma_m, "m"),
        RailSource::RailAttitude => (
            rail.orientation_sigma_deg
                .iter()
                .copied()
                .fold(0.0, f64::max),
            "deg",
        ),
        RailSource::Profile => (rail.profile_sigma_m, "m"),
        RailSource::Along => (of(&|i| p[i].along_sigma_m), "m"),
        RailSource::Dust => (scenario.disturbance.dust_fraction, "of the points"),
        RailSource::Occlusion => (scenario.disturbance.occlusion_fraction, "of the profiles"),
    };
    let largest = if unit.starts_with("of") { "" } else { "up to " };
    (value > 0.0).then(|| format!("{largest}{value} {unit}"))
}

impl Tried for RailTrials {
    fn procedure(&self) -> &'static str {
        "rail"
    }

    fn scenario(&self) -> &str {
        &self.scenario.name
    }

    fn parameters(&self) -> Vec<NamedParameter> {
        let perfect = self.trial_with(&RailSources::none(), 1);
        let Ok(found) = perfect else { return vec![] };
        let names = found.names.into_iter().zip(found.units);
        names
            .map(|(name, unit)| NamedParameter {
                name,
                unit: if unit == "rad" { "deg" } else { unit }.to_owned(),
            })
            .collect()
    }

    fn sources(&self) -> Vec<NamedSource> {
        let named = |(source, title, description): (RailSource, &str, String)| NamedSource {
            source: word(&source),
            title: title.to_owned(),
            description,
        };
        self.acting().into_iter().map(named).collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> NamedTrial {
        match self.trial_with(&self.sources_of(acting), seed) {
            Ok(found) => named(&found),
            Err(error) => NamedTrial {
                joint: Err(error.to_string()),
                reference: Err(error.to_string()),
            },
        }
    }
}

/// In degrees and metres.
fn named(found: &RailTrial) -> NamedTrial {
    let scale = |i: usize| match found.units[i] {
        "rad" => 1.0_f64.to_degrees(),
        _ => 1.0,
    };
    let errors = |values: &Vec<f64>| {
        let each = values.iter().enumerate();
        each.map(|(i, v)| v * scale(i)).collect::<Vec<f64>>()
    };
    let reason = || {
        found
            .refusal
            .clone()
            .unwrap_or_else(|| "no result".to_owned())
    };
    NamedTrial {
        joint: found
            .joint
            .as_ref()
            .map(|(values, covariance)| JointSaid {
                error: errors(values),
                covariance: covariance.map_with_location(|i, j, v| v * scale(i) * scale(j)),
                variance_factor: found.variance_factor,
            })
            .ok_or_else(reason),
        reference: found.reference.as_ref().map(errors).ok_or_else(|| {
            found
                .reference_refusal
                .clone()
                .unwrap_or_else(|| "no result".to_owned())
        }),
    }
}
