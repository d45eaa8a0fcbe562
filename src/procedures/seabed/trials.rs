//! A seabed scenario's trials.

use nalgebra::DMatrix;

use super::foresight::propagated;
use super::joint::{Joint, reported};
use super::model::Values;
use super::run::{SeabedInput, calibrate};
use super::simulate::{Acts, SeabedTruth, simulate};
use super::survey::{SeabedScenario, write};
use crate::adjust::Unit;
use crate::calibrate::choices::Method;
use crate::calibrate::tried::{
    Acting, Propagated, Reason, Said, SoughtParameter, Trial, Tried, TriedPath, faultless,
};
use crate::calibrate::vary::{Point, VaryError, at};
use crate::geometry::rotation;
use crate::results::SourceDescription;

/// A seabed scenario on trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeabedTrials {
    /// What is simulated, and how it is calibrated.
    pub scenario: SeabedScenario,
}

/// A source: key, title, its size in the scenario in words, and the scenario with nothing else.
struct Source {
    key: &'static str,
    title: &'static str,
    size: String,
    acts: Acts,
}

impl Source {
    /// One of a size, if it has any.
    fn of(
        sizes: &[f64],
        key: &'static str,
        title: &'static str,
        words: String,
        acts: Acts,
    ) -> Option<Self> {
        sizes.iter().any(|size| *size != 0.0).then_some(Self {
            key,
            title,
            size: words,
            acts,
        })
    }
}

/// White noise and drift of the INS.
fn of_the_ins(scenario: &SeabedScenario) -> [Option<Source>; 2] {
    let (t, none) = (&scenario.trajectory, Acts::NONE);
    [
        Source::of(
            &[
                t.position_sigma_m,
                t.roll_pitch_sigma_deg,
                t.heading_sigma_deg,
            ],
            "ins_white",
            "white noise of the INS",
            format!(
                "{} m, {} deg, per record",
                t.position_sigma_m, t.roll_pitch_sigma_deg
            ),
            Acts { white: 1.0, ..none },
        ),
        Source::of(
            &[
                t.position_drift_sigma_m,
                t.height_drift_sigma_m,
                t.roll_pitch_drift_sigma_deg,
                t.heading_drift_sigma_deg,
            ],
            "ins_drift",
            "drift of the INS",
            format!(
                "{} m, {} deg, over {} s",
                t.height_drift_sigma_m, t.roll_pitch_drift_sigma_deg, t.drift_correlation_time_s
            ),
            Acts { drift: 1.0, ..none },
        ),
    ]
}

/// Noise, gross errors and the arm of the sounder.
fn of_the_sounder(scenario: &SeabedScenario) -> [Option<Source>; 3] {
    let (m, none) = (&scenario.multibeam, Acts::NONE);
    let arm_m = m.lever_arm_sigma_m;
    let gross = scenario.errors.gross;
    [
        Source::of(
            &[m.range_sigma_m, m.angle_sigma_deg],
            "sonar",
            "noise of range and angle",
            format!(
                "{} m, {} deg, per sounding",
                m.range_sigma_m, m.angle_sigma_deg
            ),
            Acts { sonar: 1.0, ..none },
        ),
        Source::of(
            &[gross],
            "gross",
            "gross errors",
            format!("{gross} of the soundings"),
            Acts { gross: 1.0, ..none },
        ),
        Source::of(
            &arm_m,
            "lever_arm",
            "error of the lever arm",
            format!(
                "{} m, once per axis",
                arm_m.iter().copied().fold(0.0, f64::max)
            ),
            Acts { arm: 1.0, ..none },
        ),
    ]
}

/// Heave, height and sound speed.
fn of_the_water(scenario: &SeabedScenario) -> [Option<Source>; 3] {
    let (e, none) = (&scenario.errors, Acts::NONE);
    [
        Source::of(
            &[e.heave_scale, e.heave_lag_s],
            "heave",
            "scale and lag of the heave channel",
            format!("{} of the heave, {} s", e.heave_scale, e.heave_lag_s),
            Acts { heave: 1.0, ..none },
        ),
        Source::of(
            &[e.line_height_m],
            "line_height",
            "heights of the lines",
            format!("{} m, once per line", e.line_height_m),
            Acts {
                heights: 1.0,
                ..none
            },
        ),
        Source::of(
            &[e.profile],
            "profile",
            "error of the sound-speed profile",
            format!("{} of the speed at 20 m", e.profile),
            Acts { water: 1.0, ..none },
        ),
    ]
}

/// The sources that act in a scenario.
fn acting(scenario: &SeabedScenario) -> Vec<Source> {
    let all = (of_the_ins(scenario).into_iter())
        .chain(of_the_sounder(scenario))
        .chain(of_the_water(scenario));
    all.flatten().collect()
}

/// Errors of what may be reported: pitch, roll, yaw (radians) of the first head, latency (seconds), the angles of further heads.
fn errors(values: &Values, truth: &SeabedTruth) -> Vec<f64> {
    let rotations = truth.rotations();
    let heads = values.mountings.iter().zip(&rotations);
    let turns = heads.map(|(found, due)| rotation::log(&(found.rotation * due.transpose())));
    let late_s = values.latency_s - truth.latency_s;
    let mut all: Vec<f64> = turns.flat_map(<[f64; 3]>::from).collect();
    all.insert(3, late_s);
    all
}

/// Covariance of what may be reported.
fn covariance(joint: &Joint) -> DMatrix<f64> {
    let places: Vec<usize> = joint.reported().collect();
    let size = places.len();
    DMatrix::from_fn(size, size, |i, j| joint.covariance[places[i]][places[j]])
}

impl SeabedTrials {
    fn acts(&self, which: Acting) -> Acts {
        match which {
            Acting::All | Acting::AllWithTrueTies => Acts::ALL,
            Acting::None => Acts::NONE,
            Acting::Only(place) => acting(&self.scenario)[place].acts,
        }
    }
}

impl Tried for SeabedTrials {
    fn procedure(&self) -> &'static str {
        "seabed"
    }

    fn scenario(&self) -> &str {
        &self.scenario.name
    }

    fn content(&self) -> Vec<u8> {
        let unseeded = SeabedScenario {
            seed: 0,
            ..self.scenario.clone()
        };
        serde_json::to_vec(&unseeded).unwrap_or_default()
    }

    fn configuration(&self) -> serde_json::Value {
        serde_json::json!({ "reference": self.scenario.reference, "joint": self.scenario.seabed })
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        let all = self.scenario.parameters();
        let one = |k: usize| SoughtParameter {
            name: all[k].name(),
            unit: match all[k].kind.is_angle() {
                true => Unit::Radian,
                false => Unit::Second,
            },
        };
        reported(&all).map(one).collect()
    }

    fn paths(&self) -> Vec<TriedPath> {
        let path = |name, variant: &str| TriedPath {
            name,
            variant: variant.to_owned(),
        };
        vec![
            path("joint", ""),
            path("reference", self.scenario.reference.variant()),
        ]
    }

    fn check(&self) -> Result<(), String> {
        faultless(&self.scenario.faults())
    }

    fn sources(&self) -> Vec<SourceDescription> {
        let one = |source: Source| SourceDescription {
            source: source.key.to_owned(),
            title: source.title.to_owned(),
            description: source.size,
            ..SourceDescription::default()
        };
        acting(&self.scenario).into_iter().map(one).collect()
    }

    fn trial(&self, seed: u64, which: Acting) -> Trial {
        let survey = simulate(&self.scenario, seed, self.acts(which));
        let file = write::survey_file(&self.scenario, &survey);
        let scene = write::scene(&file, &self.scenario, &survey);
        let several = scene.heads.len() > 1;
        let found = calibrate(&SeabedInput {
            scene: &scene,
            method: match several {
                true => Method::Joint,
                false => Method::Both,
            },
            joint: &file.joint(seed),
            reference: &file.reference,
        });
        let joint = match found.joint {
            Some(Ok((joint, judged))) if judged.usable() => Ok(Said {
                error: errors(&joint.values, &survey.truth),
                covariance: Some(covariance(&joint)),
                variance_factor: Some(joint.omega_over_freedom),
            }),
            Some(Ok((_, judged))) => Err(Reason::of_words(&judged.words())),
            Some(Err(error)) => Err(Reason::of_words(&error)),
            None => Err(Reason::of_words(&"not run")),
        };
        let reference = match found.reference {
            Some(Ok(found)) if found.found()[..4].iter().all(|found| *found) => Ok(Said {
                error: errors(found.values(), &survey.truth),
                covariance: None,
                variance_factor: None,
            }),
            Some(Ok(_)) => Err(Reason::of_words(&"no pair of lines for every parameter")),
            Some(Err(error)) => Err(Reason::of_words(&error)),
            None if several => Err(Reason::of_words(&"knows one head of several")),
            None => Err(Reason::of_words(&"not run")),
        };
        Trial {
            seed,
            paths: vec![joint, reference],
        }
    }

    fn has_derivatives(&self) -> bool {
        true
    }

    fn propagated(&self) -> Option<Result<Propagated, String>> {
        let acting = acting(&self.scenario);
        let keys = acting.iter().map(|source| source.key);
        Some(propagated(&self.scenario, self.scenario.seed, keys))
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        Ok(Box::new(Self {
            scenario: at(&self.scenario, point, &[], SeabedScenario::faults)?,
        }))
    }
}
