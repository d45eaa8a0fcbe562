//! A USBL calibration as the procedure-neutral budget tries it.

use nalgebra::{DMatrix, Matrix3};

use super::named::{Acting, JointSaid, NamedTrial, Tried};
use crate::adjust::Unit;
use crate::calibrate::pool::Method;
use crate::calibrate::quality::readable;
use crate::calibrate::usbl::joint::{JointOutcome, SOUGHT, sought};
use crate::calibrate::usbl::{JointConfig, ReferenceConfig, UsblInput, UsblOutcome, calibrate};
use crate::geometry::rotation;
use crate::results::{NamedParameter, NamedSource};
use crate::simulate::usbl::{Scenario, Source, Sources, Truth, simulate_with};

/// A scenario with how its surveys are calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct UsblTried {
    /// The scenario.
    pub scenario: Scenario,
    /// The reference path.
    pub reference: ReferenceConfig,
    /// The joint path.
    pub joint: JointConfig,
}

impl UsblTried {
    /// Sources with a size above zero in the scenario, with that size in words.
    fn acting(&self) -> Vec<(Source, String)> {
        let all = Source::ALL.into_iter();
        all.filter_map(|source| Some((source, self.size(source)?)))
            .collect()
    }

    /// The size of a source in words; `None` where it is zero or switched off.
    fn size(&self, source: Source) -> Option<String> {
        let s = &self.scenario;
        let three = |sigma: [f64; 3], what: &str| {
            let [e, n, u] = sigma.map(|m| 1e3 * m);
            (e + n + u > 0.0).then(|| format!("normal, {e} {n} {u} mm east, north, up, {what}"))
        };
        let one = |sigma: f64, words: String| (sigma > 0.0).then_some(words);
        let (f, a, c) = (&s.fixes, &s.attitude, &s.control);
        let found = match source {
            Source::BeaconSurvey => three(s.beacons.sigma_m, "once per beacon"),
            Source::TransducerSurvey => three(s.transducer.sigma_m, "once"),
            Source::Range => one(
                f.range_sigma_m + f.range_sigma_ppm,
                format!(
                    "normal, {} m and {} ppm, per fix",
                    f.range_sigma_m, f.range_sigma_ppm
                ),
            ),
            Source::Angle => one(
                f.angle_sigma_deg,
                format!(
                    "normal, {} deg at broadside, per fix and axis",
                    f.angle_sigma_deg
                ),
            ),
            Source::RollPitch => one(
                a.roll_pitch_sigma_deg,
                format!("normal, {} deg, per record", a.roll_pitch_sigma_deg),
            ),
            Source::Heading => one(
                a.heading_sigma_deg,
                format!("normal, {} deg, per record", a.heading_sigma_deg),
            ),
            Source::SoundSpeed => one(
                s.sound_speed.sigma_m_s,
                format!("normal, {} m/s, once", s.sound_speed.sigma_m_s),
            ),
            Source::Datum => one(
                c.tilt_sigma_deg + c.azimuth_sigma_deg,
                format!(
                    "normal, {} deg of tilt and {} deg of azimuth, once",
                    c.tilt_sigma_deg, c.azimuth_sigma_deg
                ),
            ),
            Source::GrossErrors => one(
                s.disturbance.gross_fraction,
                format!("{} of the fixes, uniform", s.disturbance.gross_fraction),
            ),
        };
        found.filter(|_| s.sources.factor(source) > 0.0)
    }

    /// The switches of a set of trials.
    fn switches(&self, acting: Acting) -> Sources {
        match acting {
            Acting::All => self.scenario.sources.clone(),
            Acting::None => Sources::none(),
            Acting::Only(place) => self
                .acting()
                .get(place)
                .map_or_else(Sources::none, |(s, _)| {
                    Sources::none().with(*s, self.scenario.sources.factor(*s))
                }),
        }
    }
}

impl Tried for UsblTried {
    fn procedure(&self) -> &'static str {
        "usbl"
    }

    fn scenario(&self) -> &str {
        &self.scenario.name
    }

    fn parameters(&self) -> Vec<NamedParameter> {
        sought()
            .into_iter()
            .map(|(name, unit)| NamedParameter {
                name: name.to_owned(),
                unit: readable(0.0, unit).1.to_owned(),
            })
            .collect()
    }

    fn sources(&self) -> Vec<NamedSource> {
        let name = |source| {
            let value = serde_json::to_value(source).ok();
            value
                .and_then(|v| Some(v.as_str()?.to_owned()))
                .unwrap_or_default()
        };
        self.acting()
            .into_iter()
            .map(|(source, size)| NamedSource {
                source: name(source),
                title: source.describe().to_owned(),
                description: size,
            })
            .collect()
    }

    fn trial(&self, seed: u64, acting: Acting) -> NamedTrial {
        let failed = |why: String| NamedTrial {
            joint: Err(why.clone()),
            reference: Err(why),
        };
        let survey = match simulate_with(&self.scenario, &self.switches(acting), seed) {
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
                joint: joint(&outcome, &survey.truth),
                reference: reference(&outcome, &survey.truth),
            },
            Err(error) => failed(error.to_string()),
        }
    }
}

/// Turn (rad, body) from the true mounting to an estimate.
fn turn(found: &Matrix3<f64>, truth: &Truth) -> [f64; 3] {
    rotation::log(&(found * truth.rotation().transpose())).into()
}

/// Errors of the joint path in the order of [`sought`], SI and radians.
#[must_use]
pub fn errors(joint: &JointOutcome, truth: &Truth) -> [f64; SOUGHT] {
    let [a, b, c] = turn(&joint.rotation, truth);
    let place = joint.transducer_m - truth.transducer();
    [
        a,
        b,
        c,
        place.x,
        place.y,
        place.z,
        joint.scale - truth.range_scale,
    ]
}

/// Factor from SI and radians to the unit shown.
fn factors() -> [f64; SOUGHT] {
    sought().map(|(_, unit): (&str, Unit)| readable(1.0, unit).0)
}

fn joint(outcome: &UsblOutcome, truth: &Truth) -> Result<JointSaid, String> {
    if let Some(refusal) = &outcome.refusal {
        return Err(refusal.to_string());
    }
    let found = outcome.joint.as_ref().ok_or("the joint path did not run")?;
    let shown = factors();
    let errors = errors(found, truth);
    Ok(JointSaid {
        error: (0..SOUGHT).map(|i| errors[i] * shown[i]).collect(),
        covariance: DMatrix::from_fn(SOUGHT, SOUGHT, |i, j| {
            found.covariance[(i, j)] * shown[i] * shown[j]
        }),
        variance_factor: found
            .judgement
            .as_ref()
            .map(|j| j.quality.global.variance_factor),
    })
}

fn reference(outcome: &UsblOutcome, truth: &Truth) -> Result<Vec<f64>, String> {
    let found = outcome
        .reference
        .as_ref()
        .ok_or("the reference path did not run")?;
    let found = found.as_ref().map_err(ToString::to_string)?;
    let mut errors: Vec<f64> = turn(&found.rotation, truth)
        .iter()
        .map(|e| e.to_degrees())
        .collect();
    errors.resize(SOUGHT, f64::NAN);
    Ok(errors)
}
