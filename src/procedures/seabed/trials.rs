//! A seabed scenario's trials.

use nalgebra::{DMatrix, Matrix3};

use super::foresight::propagated;
use super::run::{SeabedInput, calibrate};
use super::simulate::{Acts, SeabedTruth, simulate};
use super::survey::load::scene_of;
use super::survey::{SeabedScenario, write};
use crate::adjust::Unit;
use crate::calibrate::choices::Method;
use crate::calibrate::tried::{
    Acting, Propagated, Reason, Said, SoughtParameter, Trial, Tried, TriedPath,
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

/// The sources that act in a scenario.
fn acting(scenario: &SeabedScenario) -> Vec<Source> {
    let none = Acts::NONE;
    let (t, m, e) = (&scenario.trajectory, &scenario.multibeam, &scenario.errors);
    let largest = |all: &[f64]| all.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let row = |key, title, value: f64, words: String, acts| {
        (value != 0.0).then_some(Source {
            key,
            title,
            size: words,
            acts,
        })
    };
    let white = largest(&[
        t.position_sigma_m,
        t.roll_pitch_sigma_deg,
        t.heading_sigma_deg,
    ]);
    let drift = largest(&[
        t.position_drift_sigma_m,
        t.height_drift_sigma_m,
        t.roll_pitch_drift_sigma_deg,
        t.heading_drift_sigma_deg,
    ]);
    let all = [
        row(
            "ins_white",
            "white noise of the INS",
            white,
            format!(
                "{} m, {} deg, per record",
                t.position_sigma_m, t.roll_pitch_sigma_deg
            ),
            Acts { white: 1.0, ..none },
        ),
        row(
            "ins_drift",
            "drift of the INS",
            drift,
            format!(
                "{} m, {} deg, over {} s",
                t.height_drift_sigma_m, t.roll_pitch_drift_sigma_deg, t.drift_correlation_time_s
            ),
            Acts { drift: 1.0, ..none },
        ),
        row(
            "sonar",
            "noise of range and angle",
            largest(&[m.range_sigma_m, m.angle_sigma_deg]),
            format!(
                "{} m, {} deg, per sounding",
                m.range_sigma_m, m.angle_sigma_deg
            ),
            Acts { sonar: 1.0, ..none },
        ),
        row(
            "gross",
            "gross errors",
            e.gross,
            format!("{} of the soundings", e.gross),
            Acts { gross: 1.0, ..none },
        ),
        row(
            "heave",
            "scale and lag of the heave channel",
            largest(&[e.heave_scale, e.heave_lag_s]),
            format!("{} of the heave, {} s", e.heave_scale, e.heave_lag_s),
            Acts { heave: 1.0, ..none },
        ),
        row(
            "line_height",
            "heights of the lines",
            e.line_height_m,
            format!("{} m, once per line", e.line_height_m),
            Acts {
                heights: 1.0,
                ..none
            },
        ),
        row(
            "profile",
            "error of the sound-speed profile",
            e.profile,
            format!("{} of the speed at 20 m", e.profile),
            Acts { water: 1.0, ..none },
        ),
        row(
            "lever_arm",
            "error of the lever arm",
            largest(&m.lever_arm_sigma_m),
            format!("{} m, once per axis", largest(&m.lever_arm_sigma_m)),
            Acts { arm: 1.0, ..none },
        ),
    ];
    all.into_iter().flatten().collect()
}

/// Errors of pitch, roll, yaw (radians) and latency (seconds).
fn errors(values: &super::model::Values, truth: &SeabedTruth) -> Vec<f64> {
    let true_rotation = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(values.mounting.rotation * true_rotation.transpose()));
    vec![turn.x, turn.y, turn.z, values.latency_s - truth.latency_s]
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
        let one = |(name, unit): (&str, Unit)| SoughtParameter {
            name: name.to_owned(),
            unit,
        };
        let angles = ["pitch", "roll", "yaw"].map(|name| (name, Unit::Radian));
        let all = angles.into_iter().chain([("latency", Unit::Second)]);
        all.map(one).collect()
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
        match self.scenario.faults() {
            faults if faults.is_empty() => Ok(()),
            faults => Err(format!("scenario: {}", faults.join("; "))),
        }
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
        let records = write::soundings(&self.scenario, &survey.shots);
        let trajectory = write::trajectory(&self.scenario, &survey);
        let scene = scene_of(
            &file,
            &trajectory,
            &[write::profile(&self.scenario, &survey)],
            &records,
        );
        let found = calibrate(&SeabedInput {
            scene: &scene,
            method: Method::Both,
            joint: &file.joint(seed),
            reference: &file.reference,
        });
        let joint = match found.joint {
            Some(Ok((joint, judged))) if judged.usable() => Ok(Said {
                error: errors(&joint.values, &survey.truth),
                covariance: Some(DMatrix::from_fn(4, 4, |i, j| joint.covariance[i][j])),
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
