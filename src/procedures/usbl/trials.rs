//! A USBL scenario's trials.

use nalgebra::Matrix3;

use super::joint::{JointOutcome, sought};
use super::simulate::{Scenario, Source, Sources, Truth, simulate_with};
use super::{JointConfig, ReferenceConfig, UsblInput, UsblOutcome, calibrate};
use crate::calibrate::choices::Method;
use crate::calibrate::quality::readable;
use crate::calibrate::tried::{Acting, JointSaid, NamedTrial, Tried, word};
use crate::geometry::rotation;
use crate::results::{NamedParameter, NamedSource};

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
        let own = &self.scenario.sources;
        match acting {
            Acting::All => own.clone(),
            Acting::None => Sources::none(),
            Acting::Only(place) => {
                let source = self.acting()[place].0;
                Sources::none().with(source, own.factor(source))
            }
        }
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

    fn parameters(&self) -> Vec<NamedParameter> {
        let parameter = |(name, unit): (&str, crate::adjust::Unit)| NamedParameter {
            name: name.to_owned(),
            unit: readable(0.0, unit).1.to_owned(),
        };
        sought().into_iter().map(parameter).collect()
    }

    fn sources(&self) -> Vec<NamedSource> {
        let named = |(source, description): (Source, String)| NamedSource {
            source: word(&source),
            title: source.describe().to_owned(),
            description,
        };
        self.acting().into_iter().map(named).collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> NamedTrial {
        let failed = |reason: String| NamedTrial {
            joint: Err(reason.clone()),
            reference: Err(reason),
        };
        let survey = match simulate_with(&self.scenario, &self.sources_of(acting), seed) {
            Ok(survey) => survey,
            Err(error) => return failed(error.to_string()),
        };
        let input = UsblInput {
            campaign: &survey.campaign,
            method: Method::Both,
            reference: self.reference,
            joint: self.joint,
        };
        match calibrate(&input) {
            Ok(outcome) => NamedTrial {
                joint: of_joint(&outcome, &survey.truth),
                reference: of_reference(&outcome, &survey.truth),
            },
            Err(error) => failed(error.to_string()),
        }
    }
}

fn turn(found: &Matrix3<f64>, truth: &Truth) -> [f64; 3] {
    rotation::log(&(found * truth.rotation().transpose())).into()
}

/// Values in SI to the units of the parameters.
fn shown(values: &[f64]) -> Vec<f64> {
    let pairs = values.iter().zip(sought());
    pairs.map(|(v, (_, unit))| readable(*v, unit).0).collect()
}

fn of_joint(outcome: &UsblOutcome, truth: &Truth) -> Result<JointSaid, String> {
    if let Some(refusal) = &outcome.refusal {
        return Err(refusal.to_string());
    }
    let found: &JointOutcome = outcome.joint.as_ref().ok_or("the path did not run")?;
    let mut error = turn(&found.rotation, truth).to_vec();
    error.extend((found.transducer_m - truth.transducer()).iter());
    error.push(found.scale - truth.range_scale);
    let scale = shown(&vec![1.0; error.len()]);
    let covariance = found
        .covariance
        .map_with_location(|i, j, v| v * scale[i] * scale[j]);
    Ok(JointSaid {
        error: shown(&error),
        covariance,
        variance_factor: found
            .judgement
            .as_ref()
            .map(|j| j.quality.global.variance_factor),
    })
}

/// The reference path takes the transducer as surveyed and ranges as they are.
fn of_reference(outcome: &UsblOutcome, truth: &Truth) -> Result<Vec<f64>, String> {
    match &outcome.reference {
        Some(Ok(found)) => {
            let mut error = turn(&found.rotation, truth).to_vec();
            error.extend((-truth.transducer()).iter());
            error.push(-truth.range_scale);
            Ok(shown(&error))
        }
        Some(Err(reason)) => Err(reason.to_string()),
        None => Err("the path did not run".to_owned()),
    }
}
