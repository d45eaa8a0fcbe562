//! A USBL scenario's trials.

use nalgebra::Matrix3;

use crate::adjust::Unit;
use crate::calibrate::choices::Method;
use crate::calibrate::tried::{
    Acting, Reason, Said, SoughtParameter, Trial, Tried, TriedPath, faultless, word,
};
use crate::calibrate::vary::{Point, VaryError, at};
use crate::geometry::rotation;
use crate::procedures::usbl::joint::{JointOutcome, sought};
use crate::procedures::usbl::simulate::{Scenario, Source, Sources, Truth, simulate_with};
use crate::procedures::usbl::{JointConfig, ReferenceConfig, UsblInput, UsblOutcome, calibrate};
use crate::results::SourceDescription;

/// A USBL scenario and how it is calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct UsblTrials {
    /// What is simulated.
    pub scenario: Scenario,
    /// The reference path.
    pub reference: ReferenceConfig,
    /// The joint path.
    pub joint: JointConfig,
}

impl UsblTrials {
    /// The sources that act, with their sizes in words.
    fn acting(&self) -> Vec<(Source, String)> {
        let acts = |source: &Source| self.scenario.sources.factor(*source) > 0.0;
        let all = Source::ALL.into_iter().filter(acts);
        all.filter_map(|source| Some((source, size(&self.scenario, source)?)))
            .collect()
    }

    fn sources_of(&self, acting: Acting) -> Sources {
        acting.factors(&self.scenario.sources, |place| self.acting()[place].0)
    }
}

/// How large a source is in a scenario and what shares one draw; `None` when it is nothing.
fn size(scenario: &Scenario, source: Source) -> Option<String> {
    let (fixes, control) = (&scenario.fixes, &scenario.control);
    let largest = |sigmas: &[f64; 3]| sigmas.iter().copied().fold(0.0, f64::max);
    let (value, words) = match source {
        Source::BeaconSurvey => (
            largest(&scenario.beacons.sigma_m),
            "m, once per beacon and axis",
        ),
        Source::TransducerSurvey => (largest(&scenario.transducer.sigma_m), "m, once per axis"),
        Source::Range => (
            fixes.range_sigma_m.max(fixes.range_sigma_ppm * 1e-6),
            "m (or of the range), per fix",
        ),
        Source::Angle => (fixes.angle_sigma_deg, "deg at broadside, per fix and angle"),
        Source::RollPitch => (scenario.attitude.roll_pitch_sigma_deg, "deg, per record"),
        Source::Heading => (scenario.attitude.heading_sigma_deg, "deg, per record"),
        Source::SoundSpeed => (scenario.sound_speed.sigma_m_s, "m/s, once"),
        Source::Datum => (
            control.tilt_sigma_deg.max(control.azimuth_sigma_deg),
            "deg, once per axis",
        ),
        Source::GrossErrors => (scenario.disturbance.gross_fraction, "of the fixes, uniform"),
    };
    (value > 0.0).then(|| format!("up to {value} {words}"))
}

impl Tried for UsblTrials {
    fn procedure(&self) -> &'static str {
        "usbl"
    }

    fn scenario(&self) -> &str {
        &self.scenario.name
    }

    fn content(&self) -> Vec<u8> {
        let unseeded = Scenario {
            seed: 0,
            ..self.scenario.clone()
        };
        serde_json::to_vec(&unseeded).unwrap_or_default()
    }

    fn check(&self) -> Result<(), String> {
        faultless(&self.scenario.check())
    }

    fn configuration(&self) -> serde_json::Value {
        serde_json::json!({ "reference": self.reference, "joint": self.joint })
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        let parameter = |(name, unit): (&str, Unit)| SoughtParameter {
            name: name.to_owned(),
            unit,
        };
        sought().into_iter().map(parameter).collect()
    }

    fn paths(&self) -> Vec<TriedPath> {
        let path = |name| TriedPath {
            name,
            variant: String::new(),
        };
        ["joint", "reference"].map(path).into()
    }

    fn sources(&self) -> Vec<SourceDescription> {
        let named = |(source, description): (Source, String)| SourceDescription {
            source: word(&source),
            title: source.describe().to_owned(),
            description,
            ..SourceDescription::default()
        };
        self.acting().into_iter().map(named).collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> Trial {
        let failed = |reason: Reason| Trial {
            seed,
            paths: vec![Err(reason.clone()), Err(reason)],
        };
        let survey = match simulate_with(&self.scenario, &self.sources_of(acting), seed) {
            Ok(survey) => survey,
            Err(error) => return failed(Reason::new("not_simulated", &error)),
        };
        let input = UsblInput {
            campaign: &survey.campaign,
            method: Method::Both,
            reference: self.reference,
            joint: self.joint.clone(),
        };
        match calibrate(&input) {
            Ok(outcome) => Trial {
                seed,
                paths: vec![
                    of_joint(&outcome, &survey.truth),
                    of_reference(&outcome, &survey.truth),
                ],
            },
            Err(error) => failed(Reason::new("not_run", &error)),
        }
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        Ok(Box::new(Self {
            scenario: at(&self.scenario, point, &[], Scenario::check)?,
            ..self.clone()
        }))
    }
}

fn turn(found: &Matrix3<f64>, truth: &Truth) -> [f64; 3] {
    rotation::log(&(found * truth.rotation().transpose())).into()
}

fn of_joint(outcome: &UsblOutcome, truth: &Truth) -> Result<Said, Reason> {
    if let Some(refusal) = &outcome.refusal {
        return Err(Reason::of_words(refusal));
    }
    let missing = || Reason::new("not_run", &"the path did not run");
    let found: &JointOutcome = outcome.joint.as_ref().ok_or_else(missing)?;
    let mut error = turn(&found.rotation, truth).to_vec();
    error.extend((found.transducer_m - truth.transducer()).iter());
    error.push(found.scale - truth.range_scale);
    let judged = found.judgement.as_ref();
    Ok(Said {
        error,
        covariance: Some(found.covariance.clone()),
        variance_factor: judged.map(|j| j.quality.global.variance_factor),
    })
}

/// The reference path takes the transducer as surveyed and ranges as they are.
fn of_reference(outcome: &UsblOutcome, truth: &Truth) -> Result<Said, Reason> {
    match &outcome.reference {
        Some(Ok(found)) => {
            let mut error = turn(&found.rotation, truth).to_vec();
            error.extend((-truth.transducer()).iter());
            error.push(-truth.range_scale);
            Ok(Said {
                error,
                covariance: None,
                variance_factor: None,
            })
        }
        Some(Err(reason)) => Err(Reason::of_words(reason)),
        None => Err(Reason::new("not_run", &"the path did not run")),
    }
}
