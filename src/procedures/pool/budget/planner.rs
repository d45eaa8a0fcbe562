//! A pool's plan behind the seam: what was asked for, in the pool's own terms.

use std::path::Path;

use super::plan::{PlanRequest, candidates};
use super::planned::{BEST_PUBLISHED, NAMES, planned};
use super::sailed::as_scenario;
use super::trials::ALIASES;
use crate::calibrate::planning::{PlanAsk, Planner};
use crate::calibrate::seam::InputError;
use crate::calibrate::vary::{Point, at, points};
use crate::procedures::pool::JointConfig;
use crate::procedures::pool::survey::{load, scenario};
use crate::results::PlanResult;
use crate::simulate::Scenario;
use crate::survey::{Problem, SurveyError, is_survey};

/// What is said of a survey's passes.
const AS_SAILED: &str = "The passes were read from the survey's trajectory and its motion taken as sines of the observed size and period: a \
    prediction, not the survey's own result";

/// A name or figure that `wanted` cannot hold.
#[derive(Debug, thiserror::Error)]
#[error("--wanted: found \"{found}\", expected one of {}", NAMES.join(", "))]
struct NotWanted {
    found: String,
}

/// A plan about to be made.
struct PoolPlan {
    scenario: Scenario,
    config: JointConfig,
    request: PlanRequest,
    points: Vec<(Point, Scenario)>,
    /// What is to be said of reading the survey; `None` for a scenario.
    of_reading: Option<Vec<String>>,
}

/// The plan of a scenario or survey file.
///
/// # Errors
/// [`InputError`]: what is wrong with the file, a key of `vary` or a name of `wanted`.
pub fn planner(file: &Path, text: &str, ask: &PlanAsk) -> Result<Box<dyn Planner>, InputError> {
    let (scenario, config, of_reading) = if is_survey(text) {
        of_survey(file)?
    } else {
        let read = scenario::beside(file, text)?;
        let joint = read.calibration(file)?.joint;
        (read.scenario, joint, None)
    };
    let with_scenario = |point: Point| {
        let there = at(&scenario, &point, &ALIASES, Scenario::check);
        there.map(|there| (point, there))
    };
    let points: Result<Vec<_>, _> = points(&ask.vary).into_iter().map(with_scenario).collect();
    let points = points.map_err(InputError::unworkable)?;
    Ok(Box::new(PoolPlan {
        request: request(ask)?.widened(&scenario),
        scenario,
        config,
        points,
        of_reading,
    }))
}

/// Passes, what is held of their errors, and what is to be said of reading them.
type Sailed = (Scenario, JointConfig, Option<Vec<String>>);

/// The passes of a survey as sailed.
fn of_survey(file: &Path) -> Result<Sailed, InputError> {
    let survey = load(file)?;
    match as_scenario(&survey) {
        Some(scenario) => Ok((scenario, survey.file.joint, Some(survey.notes))),
        None => Err(SurveyError::from(Problem::new(
            file,
            "whole file",
            "no pass along the wall, or laser points that are georeferenced already",
            "a survey with passes and [lidar] coordinates = \"sensor\"",
        ))
        .into()),
    }
}

fn request(ask: &PlanAsk) -> Result<PlanRequest, InputError> {
    let (angle, arm) = (BEST_PUBLISHED.0.to_radians(), BEST_PUBLISHED.1);
    let mut wanted = [angle, angle, angle, arm, arm, arm];
    for (name, value) in &ask.wanted {
        let place = NAMES.iter().position(|n| n == name);
        let i = place.ok_or_else(|| {
            let found = name.clone();
            InputError::unworkable(NotWanted { found })
        })?;
        wanted[i] = if i < 3 {
            value.to_radians()
        } else {
            value * 1e-3
        };
    }
    Ok(PlanRequest {
        distances_m: ask.distances_m.clone(),
        speeds_m_s: ask.speeds_m_s.clone(),
        crabs_deg: ask.crabs_deg.clone(),
        both_directions: ask.both_directions,
        keep_passes: ask.keep_passes,
        criterion: ask.criterion,
        wanted,
        most: ask.most,
    })
}

impl Planner for PoolPlan {
    fn name(&self) -> &str {
        &self.scenario.name
    }

    fn surveys(&self) -> usize {
        let sailed = self
            .scenario
            .pass
            .iter()
            .filter(|_| self.request.keep_passes);
        sailed.count() + candidates(&self.scenario, &self.request).len() + self.points.len()
    }

    fn plan(&self, progress: &(dyn Fn() + Sync)) -> Result<PlanResult, InputError> {
        let (scenario, request) = (&self.scenario, &self.request);
        let mut result = planned(scenario, request, &self.points, &self.config, progress)
            .map_err(InputError::unworkable)?;
        if let Some(notes) = &self.of_reading {
            let first = std::iter::once(AS_SAILED.to_owned());
            let read = notes.iter().map(|note| format!("{note}."));
            result.notes.splice(0..0, first.chain(read));
        }
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::PlanCriterion;

    #[test]
    fn what_is_wanted_is_in_degrees_and_millimetres() {
        let ask = |wanted: &[(&str, f64)]| PlanAsk {
            distances_m: vec![],
            speeds_m_s: vec![],
            crabs_deg: vec![],
            both_directions: false,
            keep_passes: true,
            criterion: PlanCriterion::D,
            wanted: wanted.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect(),
            most: 30,
            vary: vec![],
        };
        let best = request(&ask(&[])).expect("the best published").wanted;
        let found = request(&ask(&[("pitch", 0.01), ("lz", 3.0)]))
            .expect("two")
            .wanted;
        assert_eq!(found[0], 0.01f64.to_radians());
        assert_eq!(found[5], 0.003);
        assert_eq!(found[1..5], best[1..5]);
        let said = request(&ask(&[("heading", 1.0)]))
            .expect_err("no such")
            .to_string();
        assert!(
            said.contains("found \"heading\", expected one of pitch"),
            "{said}"
        );
    }
}
