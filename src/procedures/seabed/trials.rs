//! A seabed scenario's trials.

use nalgebra::{DMatrix, Matrix3};

use super::run::{SeabedInput, calibrate};
use super::simulate::{Acts, SeabedScenario, SeabedTruth, simulate, write};
use super::survey::load::scene_of;
use crate::adjust::Unit;
use crate::calibrate::choices::Method;
use crate::calibrate::tried::{Acting, Reason, Said, SoughtParameter, Trial, Tried, TriedPath};
use crate::calibrate::vary::{Point, VaryError, at};
use crate::formats::SoundingRecords;
use crate::geometry::rotation;
use crate::results::SourceDescription;

/// A seabed scenario on trial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeabedTrials {
    /// What is simulated, and how it is calibrated.
    pub scenario: SeabedScenario,
}

/// Key and title of each source.
const SOURCES: [(&str, &str); 5] = [
    ("ins_white", "white noise of the INS"),
    ("ins_drift", "drift of the INS"),
    ("sonar", "noise of range and angle"),
    ("gross", "gross errors"),
    ("heave", "scale of the heave channel"),
];

fn acts(acting: Acting) -> Acts {
    let none = Acts::NONE;
    match acting {
        Acting::All | Acting::AllWithTrueTies => Acts::ALL,
        Acting::None => none,
        Acting::Only(0) => Acts { white: 1.0, ..none },
        Acting::Only(1) => Acts { drift: 1.0, ..none },
        Acting::Only(2) => Acts { sonar: 1.0, ..none },
        Acting::Only(3) => Acts { gross: 1.0, ..none },
        Acting::Only(_) => Acts { heave: 1.0, ..none },
    }
}

/// Errors of pitch, roll, yaw (radians) and latency (seconds).
fn errors(values: &super::model::Values, truth: &SeabedTruth) -> Vec<f64> {
    let true_rotation = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(values.mounting.rotation * true_rotation.transpose()));
    vec![turn.x, turn.y, turn.z, values.latency_s - truth.latency_s]
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
            path("reference", &self.scenario.reference.order),
        ]
    }

    fn sources(&self) -> Vec<SourceDescription> {
        let one = |(source, title): (&str, &str)| SourceDescription {
            source: source.to_owned(),
            title: title.to_owned(),
            description: "as the scenario says".to_owned(),
            ..SourceDescription::default()
        };
        SOURCES.into_iter().map(one).collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> Trial {
        let survey = simulate(&self.scenario, seed, acts(acting));
        let file = write::survey_file(&self.scenario, &survey);
        let observed = write::soundings(&self.scenario, &survey.shots);
        let records = SoundingRecords {
            time_s: observed.time_s,
            ping: observed.ping,
            beam: observed.beam,
            across_rad: observed.across_rad,
            along_rad: observed.along_rad,
            range: observed.range,
        };
        let trajectory = write::trajectory(&self.scenario, &survey);
        let scene = scene_of(
            &file,
            &trajectory,
            &write::profile(&self.scenario),
            &records,
        );
        let found = calibrate(&SeabedInput {
            scene: &scene,
            method: Method::Both,
            joint: &file.config(seed),
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
            Some(Ok(patch)) if patch.found.iter().all(|found| *found) => Ok(Said {
                error: errors(&patch.values, &survey.truth),
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

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        Ok(Box::new(Self {
            scenario: at(&self.scenario, point, &[], |_| vec![])?,
        }))
    }
}
