//! The plan as `plan.json`, with scenario values that cannot be mixed in one survey compared beside it.

use nalgebra::{Matrix6, Vector3};
use rayon::prelude::*;

use super::fusion::sigmas;
use super::passes::{PassError, predicted};
use super::plan::{Candidate, Plan, PlanRequest, name, plan};
use super::trials::content;
use crate::calibrate::vary::Point;
use crate::formats::digest::sha256_of;
use crate::geometry::frames;
use crate::procedures::pool::JointConfig;
use crate::results::{
    BudgetParameter, Figures, PLAN_FORMAT_VERSION, PlanCandidate, PlanResult, PlanStep,
    PlanVariation, PlanVariations, PlannedPass, Software,
};
use crate::simulate::Scenario;
use crate::simulate::scenario::Pass;
use crate::target::{Role, Target};

/// The best figures published for such a calibration: 0.015 degrees and 1.2 mm ; what is wanted where nobody says otherwise.
pub const BEST_PUBLISHED: (f64, f64) = (0.015, 0.0012);

/// Names of the six parameters in order.
pub const NAMES: [&str; 6] = ["pitch", "roll", "yaw", "lx", "ly", "lz"];

/// Plans and compares. `points` are the values of `--vary`, each with its scenario; `progress` is told of each pass or point done.
///
/// # Errors
/// As [`plan`].
pub fn planned(
    scenario: &Scenario,
    request: &PlanRequest,
    points: &[(Point, Scenario)],
    config: &JointConfig,
    progress: &(dyn Fn() + Sync),
) -> Result<PlanResult, PassError> {
    let free = JointConfig {
        hold: vec![],
        ..config.clone()
    };
    let found = plan(scenario, request, &free, progress)?;
    let sailed = scenario.pass.iter().filter(|_| request.keep_passes);
    Ok(PlanResult {
        format_version: PLAN_FORMAT_VERSION,
        scenario: scenario.name.clone(),
        scenario_sha256: sha256_of(&content(scenario)),
        software: Software::this(),
        command: String::new(),
        criterion: request.criterion,
        parameters: parameters(),
        wanted: shown(request.wanted),
        sailed: sailed.map(|p| pass(p, scenario)).collect(),
        sailed_standard_deviation: found.start.as_ref().and_then(figures),
        chosen: steps(&found),
        most: request.most as u64,
        passes_needed: found.needed.map(|n| n as u64),
        floor: Some(shown(found.floor)),
        unreachable: unreachable(&found, request),
        candidates: found
            .candidates
            .iter()
            .map(|c| candidate(c, scenario))
            .collect(),
        faces_from_above_m: from_above(scenario),
        variations: variations(points, &free, progress),
        notes: notes(scenario, points, config),
    })
}

/// In degrees and metres; `None` unless all are known.
fn figures(covariance: &Matrix6<f64>) -> Option<Figures> {
    let found = shown(sigmas(covariance));
    found.iter().all(Option::is_some).then_some(found)
}

/// From radians and metres to degrees and metres.
fn shown(six: [f64; 6]) -> Figures {
    let shown = |(i, v): (usize, f64)| if i < 3 { v.to_degrees() } else { v };
    let values = six.into_iter().enumerate().map(shown);
    values.map(|v| v.is_finite().then_some(v)).collect()
}

/// The mounting's six.
fn parameters() -> Vec<BudgetParameter> {
    let parameter = |(i, name): (usize, &&str)| BudgetParameter {
        name: (*name).to_owned(),
        unit: if i < 3 { "deg" } else { "m" }.to_owned(),
    };
    NAMES.iter().enumerate().map(parameter).collect()
}

fn pass(pass: &Pass, scenario: &Scenario) -> PlannedPass {
    let there = |y: f64| Some(on_earth(scenario, pass.distance_m, y));
    PlannedPass {
        name: name(pass),
        distance_m: pass.distance_m,
        from_m: pass.from_m,
        to_m: pass.to_m,
        speed_m_s: pass.speed_m_s,
        crab_deg: pass.crab_deg,
        begin_deg: there(pass.from_m),
        end_deg: there(pass.to_m),
    }
}

/// Latitude and longitude of a place before the wall, degrees.
fn on_earth(scenario: &Scenario, distance_m: f64, y: f64) -> [f64; 2] {
    let pose = scenario.target.pose();
    let place = frames::Point::<frames::Target>::new(Vector3::new(-distance_m, y, 0.0));
    let found = pose
        .ellipsoid
        .to_geodetic(&(pose.ecef_from_target() * place));
    [found.latitude_rad, found.longitude_rad].map(f64::to_degrees)
}

fn candidate(candidate: &Candidate, scenario: &Scenario) -> PlanCandidate {
    let told = candidate.information.as_ref();
    PlanCandidate {
        pass: pass(&candidate.pass, scenario),
        soundings: told.map_or(0, |i| i.soundings as u64),
        returns: told.map_or(0, |i| i.returns as u64),
        standard_deviation_if_next: candidate.next.as_ref().and_then(figures),
        refusal: told.err().map_or_else(String::new, ToString::to_string),
    }
}

fn steps(plan: &Plan) -> Vec<PlanStep> {
    let step = |s: &super::plan::Step| {
        Some(PlanStep {
            candidate: s.candidate as u64,
            name: plan.candidates[s.candidate].name.clone(),
            standard_deviation: figures(&s.covariance)?,
        })
    };
    plan.steps.iter().filter_map(step).collect()
}

/// Parameters whose floor lies above what is wanted.
fn unreachable(plan: &Plan, request: &PlanRequest) -> Vec<String> {
    let over = |i: &usize| plan.floor[*i] > request.wanted[*i];
    (0..6).filter(over).map(|i| NAMES[i].to_owned()).collect()
}

/// Outlines of the faces from above: (Y, X).
fn from_above(scenario: &Scenario) -> Vec<Vec<[f64; 2]>> {
    let Ok(target) = Target::from_model(&scenario.target.model) else {
        return vec![];
    };
    let seen = target.faces.iter().filter(|f| f.role != Role::Obstacle);
    let outline = |f: &crate::target::Face| {
        let vertices = f.outline.vertices_m.iter();
        vertices.map(|v| [v.y, v.x]).collect()
    };
    seen.map(outline).collect()
}

fn variations(
    points: &[(Point, Scenario)],
    config: &JointConfig,
    progress: &(dyn Fn() + Sync),
) -> Option<PlanVariations> {
    let (first, _) = points.first()?;
    let variation = |(point, scenario): &(Point, Scenario)| {
        let found = predicted(scenario, config);
        progress();
        PlanVariation {
            values: point.0.iter().map(|(_, value)| value.plain()).collect(),
            standard_deviation: found.as_ref().ok().and_then(figures),
            refusal: found.err().map_or_else(String::new, |e| e.to_string()),
        }
    };
    Some(PlanVariations {
        keys: first.0.iter().map(|(key, _)| key.clone()).collect(),
        points: points.par_iter().map(variation).collect(),
    })
}

fn notes(scenario: &Scenario, points: &[(Point, Scenario)], config: &JointConfig) -> Vec<String> {
    let mut notes = vec![
        format!(
            "The information of the passes is added up, which holds where the pauses between them are long compared with the drift's correlation time of {} s",
            scenario.trajectory.drift_correlation_time_s
        ),
        "Each candidate is sailed with the boat's motion at the start of the scenario; another phase of the waves changes its figures by several per cent"
            .to_owned(),
        "Only what the survey states of its own errors is counted: errors that it does not know of (latency, sound speed where it is \
         held, a scanner mounting without a stated uncertainty) come on top"
            .to_owned(),
    ];
    if !config.hold.is_empty() {
        notes.push(format!(
            "Held by the scenario, but planned as free: {}",
            config.hold.join(", ")
        ));
    }
    if !points.is_empty() {
        notes.push(
            "Scenario values are compared, not combined: each row is a survey of the scenario's own passes at that value"
                .to_owned(),
        );
    }
    notes
}
