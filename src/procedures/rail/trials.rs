//! A rail scenario's trials.

use super::profile::RailProfile;
use crate::adjust::Unit;
use crate::calibrate::tried::{
    Acting, Reason, Said, SoughtParameter, Trial, Tried, TriedPath, faultless, word,
};
use crate::calibrate::vary::{Point, VaryError, at};
use crate::procedures::rail::model::SOUGHT_NAMES;
use crate::procedures::rail::simulate::{RailScenario, RailScenarioError, RailSource, RailSources};
use crate::procedures::rail::trial::{RailTrial, trial_with};
use crate::procedures::rail::{RailJointConfig, RailReferenceConfig};
use crate::results::SourceDescription;

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
        acting.factors(&self.scenario.sources, |place| self.acting()[place].0)
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
        RailSource::AxesGap => (table.axes_gap_sigma_m, "m"),
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

    fn content(&self) -> Vec<u8> {
        let unseeded = RailScenario {
            seed: 0,
            ..self.scenario.clone()
        };
        let mut content = serde_json::to_vec(&unseeded).unwrap_or_default();
        content.extend(format!("{:?}", self.rail).into_bytes());
        content
    }

    fn check(&self) -> Result<(), String> {
        faultless(&self.scenario.faults())
    }

    fn configuration(&self) -> serde_json::Value {
        serde_json::json!({ "reference": self.reference, "joint": self.joint })
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        let profilers: Vec<&str> = self.scenario.profiler.iter().map(|p| &*p.name).collect();
        let parameter = |profiler: &str, (part, unit): (&str, Unit)| SoughtParameter {
            name: format!("{profiler} {part}"),
            unit,
        };
        let parts = SOUGHT_NAMES.into_iter().enumerate().map(|(i, name)| {
            let unit = if i < 3 { Unit::Radian } else { Unit::Metre };
            (name, unit)
        });
        let parts: Vec<_> = parts.collect();
        let own = |profiler| parts.iter().map(move |part| parameter(profiler, *part));
        let mut all: Vec<_> = profilers.iter().copied().flat_map(own).collect();
        all.extend(profilers.iter().map(|p| parameter(p, ("ly", Unit::Metre))));
        all
    }

    fn paths(&self) -> Vec<TriedPath> {
        let path = |name| TriedPath {
            name,
            variant: String::new(),
        };
        ["joint", "reference"].map(path).into()
    }

    fn sources(&self) -> Vec<SourceDescription> {
        let named = |(source, title, description): (RailSource, &str, String)| SourceDescription {
            source: word(&source),
            title: title.to_owned(),
            description,
            ..SourceDescription::default()
        };
        self.acting().into_iter().map(named).collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> Trial {
        match self.trial_with(&self.sources_of(acting), seed) {
            Ok(found) => judged(seed, found),
            Err(error) => {
                let reason = Reason::new("not_simulated", &error);
                Trial {
                    seed,
                    paths: vec![Err(reason.clone()), Err(reason)],
                }
            }
        }
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        Ok(Box::new(Self {
            scenario: at(&self.scenario, point, &[], RailScenario::faults)?,
            ..self.clone()
        }))
    }
}

fn judged(seed: u64, found: RailTrial) -> Trial {
    let reason = |refusal: Option<String>| {
        Reason::of_words(&refusal.unwrap_or_else(|| "no result".to_owned()))
    };
    let factor = found.variance_factor;
    let joint = found.joint.map(|(error, covariance)| Said {
        error,
        covariance: Some(covariance),
        variance_factor: factor,
    });
    let reference = found.reference.map(|error| Said {
        error,
        covariance: None,
        variance_factor: None,
    });
    let paths = vec![
        joint.ok_or_else(|| reason(found.refusal)),
        reference.ok_or_else(|| reason(found.reference_refusal)),
    ];
    Trial { seed, paths }
}
