//! Planning without data: what candidate passes would tell, which of them to sail next, and how many are needed.
//!
//! Each candidate is simulated free of errors and linearised once: its information on everything that passes share (mounting,
//! scanner mounting, planes, face offsets), with its own trajectory errors eliminated. Information of passes adds where the pauses
//! between them are long against the correlation time of the trajectory's drift; the priors count once. Greedy choice: for the
//! determinant (D-optimal) or the sum of variances in units of what is wanted (A-optimal) of the six parameters' covariance
//! (Pukelsheim, *Optimal Design of Experiments*, 2006, ch. 6; Nemhauser, Wolsey & Fisher 1978 for the greedy choice).

use nalgebra::Matrix6;

use super::fusion::{Fusion, sigmas};
use super::passes::{PassError, Timed, information_of_all, own_passes};
use crate::math;
use crate::procedures::pool::JointConfig;
use crate::procedures::pool::joint::Information;
use crate::results::PlanCriterion;
use crate::simulate::Scenario;
use crate::simulate::scenario::Pass;

/// How often every candidate is sailed for what no number of passes goes below.
const ENDLESS: f64 = 1e6;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRequest {
    /// Distances of candidate passes, metres; none: those of the scenario's passes.
    pub distances_m: Vec<f64>,
    /// Speeds, metres per second; none: those of the scenario's passes.
    pub speeds_m_s: Vec<f64>,
    /// Heading minus course, degrees; none: those of the scenario's passes.
    pub crabs_deg: Vec<f64>,
    /// Whether each candidate is also sailed the other way.
    pub both_directions: bool,
    /// Whether the scenario's own passes are already sailed.
    pub keep_passes: bool,
    /// What is made smallest.
    pub criterion: PlanCriterion,
    /// Standard deviations wanted: pitch, roll, yaw (rad), lx, ly, lz (m).
    pub wanted: [f64; 6],
    /// Passes that are added at the most.
    pub most: usize,
}

impl PlanRequest {
    /// The same with candidates of other distances, speeds, headings and ways where none of them is asked for: half the nearest distance
    /// of the scenario's passes to twice the farthest, their speeds and half of them, 10 deg more and less of heading, both ways.
    #[must_use]
    pub fn widened(mut self, scenario: &Scenario) -> Self {
        let lists = [&self.distances_m, &self.speeds_m_s, &self.crabs_deg];
        if self.both_directions || lists.iter().any(|list| !list.is_empty()) {
            return self;
        }
        let passes = scenario.pass.iter();
        let ends = passes.clone().map(|p| p.distance_m);
        let near = ends.clone().fold(f64::INFINITY, f64::min) / 2.0;
        let far = ends.fold(0.0, f64::max) * 2.0;
        let step = |k: i32| near * math::powf(far / near, f64::from(k) / 4.0);
        self.distances_m = (0..5).map(|k| (2.0 * step(k)).round() / 2.0).collect();
        self.speeds_m_s = passes
            .clone()
            .flat_map(|p| [p.speed_m_s, p.speed_m_s / 2.0])
            .collect();
        self.crabs_deg = passes
            .flat_map(|p| [p.crab_deg - TURN_DEG, p.crab_deg, p.crab_deg + TURN_DEG])
            .filter(|crab| crab.abs() < 90.0)
            .collect();
        self.both_directions = true;
        self
    }
}

/// Headings more and less than those of the scenario that are tried, degrees.
const TURN_DEG: f64 = 10.0;

/// A candidate pass.
#[derive(Debug)]
pub struct Candidate {
    /// What tells it from the others.
    pub name: String,
    /// The pass.
    pub pass: Pass,
    /// What it would tell, or why nothing.
    pub information: Result<Information, PassError>,
    /// Covariance (rad, m) if this pass were sailed next.
    pub next: Option<Matrix6<f64>>,
}

/// One step of the greedy choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Index of the candidate.
    pub candidate: usize,
    /// Covariance (rad, m) with it and all before.
    pub covariance: Matrix6<f64>,
}

/// The answer.
#[derive(Debug)]
pub struct Plan {
    /// Covariance (rad, m) of the passes already sailed; `None` where nothing is sailed.
    pub start: Option<Matrix6<f64>>,
    /// Candidates in the order of the request.
    pub candidates: Vec<Candidate>,
    /// The passes to sail, in order; ends when everything wanted is reached.
    pub steps: Vec<Step>,
    /// Passes to add until everything wanted is reached; `None` where the most that was allowed does not do.
    pub needed: Option<usize>,
    /// Standard deviations that no number of these passes would go below; those of the start where no candidate tells anything.
    pub floor: [f64; 6],
}

/// Plans. `progress` is told how many of how many passes are looked at.
///
/// # Errors
/// [`PassError`] when a pass that is sailed already tells nothing, or a candidate cannot be simulated. A candidate that a sensor does
/// not see the target from is offered with its refusal and never chosen.
pub fn plan(
    scenario: &Scenario,
    request: &PlanRequest,
    config: &JointConfig,
    progress: &(dyn Fn() + Sync),
) -> Result<Plan, PassError> {
    let mut sailed = Fusion::default();
    if request.keep_passes {
        for information in information_of_all(scenario, &own_passes(scenario), config, progress) {
            sailed.add(&information?);
        }
    }
    let candidates = described(scenario, request, config, progress, &sailed)?;
    let steps = greedy(&sailed, &candidates, request);
    let start = (sailed.passes > 0).then(|| sailed.covariance());
    let needed = match &start {
        Some(start) if reached(start, request) => Some(0),
        _ => steps
            .iter()
            .position(|s| reached(&s.covariance, request))
            .map(|k| k + 1),
    };
    let mut endless = sailed.clone();
    offered(&candidates).for_each(|(_, information)| endless.add_times(information, ENDLESS));
    Ok(Plan {
        start,
        candidates,
        steps,
        needed,
        floor: sigmas(&endless.covariance()),
    })
}

/// Whether everything wanted is reached.
fn reached(covariance: &Matrix6<f64>, request: &PlanRequest) -> bool {
    let found = sigmas(covariance);
    found.iter().zip(&request.wanted).all(|(s, w)| s <= w)
}

/// Candidates that tell something, with their index.
fn offered(candidates: &[Candidate]) -> impl Iterator<Item = (usize, &Information)> {
    let with_index = candidates.iter().enumerate();
    with_index.filter_map(|(k, c)| Some((k, c.information.as_ref().ok()?)))
}

fn described(
    scenario: &Scenario,
    request: &PlanRequest,
    config: &JointConfig,
    progress: &(dyn Fn() + Sync),
    sailed: &Fusion,
) -> Result<Vec<Candidate>, PassError> {
    let passes = candidates(scenario, request);
    let timed: Vec<Timed> = passes.iter().cloned().map(from_the_begin).collect();
    let all = information_of_all(scenario, &timed, config, progress);
    let describe = |(pass, information): (Pass, _)| match information {
        Err(impossible @ PassError::Simulate(_)) => Err(impossible),
        information => Ok(Candidate {
            name: name(&pass),
            next: information
                .as_ref()
                .ok()
                .map(|i| sailed.with(i).covariance()),
            pass,
            information,
        }),
    };
    passes.into_iter().zip(all).map(describe).collect()
}

/// Nobody knows when a candidate will be sailed: it has the motion of the scenario's begin.
fn from_the_begin(pass: Pass) -> Timed {
    Timed { pass, begin_s: 0.0 }
}

/// What tells a pass from others: "6 m, 0.5 m/s, +Y".
#[must_use]
pub fn name(pass: &Pass) -> String {
    let way = if pass.to_m > pass.from_m { "+Y" } else { "-Y" };
    let crab = match pass.crab_deg {
        0.0 => String::new(),
        crab => format!(", crab {crab} deg"),
    };
    format!("{} m, {} m/s, {way}{crab}", pass.distance_m, pass.speed_m_s)
}

/// Every combination that is asked for, along the course of the scenario's first pass.
#[must_use]
pub fn candidates(scenario: &Scenario, request: &PlanRequest) -> Vec<Pass> {
    let or_own = |values: &[f64], own: fn(&Pass) -> f64| {
        let own = scenario.pass.iter().map(own);
        let mut all: Vec<f64> = match values {
            [] => own.collect(),
            values => values.to_vec(),
        };
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let Some(model) = scenario.pass.first() else {
        return vec![];
    };
    let mut all = vec![];
    for distance_m in or_own(&request.distances_m, |p| p.distance_m) {
        for &speed_m_s in &or_own(&request.speeds_m_s, |p| p.speed_m_s) {
            for &crab_deg in &or_own(&request.crabs_deg, |p| p.crab_deg) {
                let there = Pass {
                    distance_m,
                    speed_m_s,
                    crab_deg,
                    ..model.clone()
                };
                let back = request.both_directions.then(|| Pass {
                    from_m: there.to_m,
                    to_m: there.from_m,
                    ..there.clone()
                });
                all.push(there);
                all.extend(back);
            }
        }
    }
    all
}

/// Adds the best candidate again and again until everything wanted is reached, of equals the first; where one pass is enough, the one
/// that is sailed quickest.
fn greedy(sailed: &Fusion, candidates: &[Candidate], request: &PlanRequest) -> Vec<Step> {
    let mut here = sailed.clone();
    let mut steps: Vec<Step> = vec![];
    if sailed.passes > 0 && reached(&sailed.covariance(), request) {
        return steps;
    }
    while steps.len() < request.most
        && !steps
            .last()
            .is_some_and(|s| reached(&s.covariance, request))
    {
        let with = |(k, information)| (k, information, here.with(information).covariance());
        let all: Vec<_> = offered(candidates).map(with).collect();
        let duration_s = |k: usize| {
            let pass = &candidates[k].pass;
            (pass.to_m - pass.from_m).abs() / pass.speed_m_s
        };
        let worth = |c: &Matrix6<f64>| worth(c, request);
        let better = |a: f64, b: f64, c: f64, d: f64| a.total_cmp(&b).then(c.total_cmp(&d));
        let enough = all.iter().filter(|(_, _, c)| reached(c, request));
        let quickest = enough
            .min_by(|a, b| better(duration_s(a.0), duration_s(b.0), worth(&a.2), worth(&b.2)));
        let best = quickest.or_else(|| {
            all.iter()
                .min_by(|a, b| worth(&a.2).total_cmp(&worth(&b.2)))
        });
        let Some(&(candidate, information, covariance)) = best else {
            break;
        };
        here.add(information);
        steps.push(Step {
            candidate,
            covariance,
        });
    }
    steps
}

/// What the criterion makes smallest, parameters in units of what is wanted: of D the logarithm of the determinant, of A the trace.
#[must_use]
pub fn worth(covariance: &Matrix6<f64>, request: &PlanRequest) -> f64 {
    let w = &request.wanted;
    let scaled = Matrix6::from_fn(|i, j| covariance[(i, j)] / (w[i] * w[j]));
    match request.criterion {
        PlanCriterion::A => scaled.trace(),
        PlanCriterion::D => scaled.cholesky().map_or(f64::INFINITY, |c| {
            c.l_dirty()
                .diagonal()
                .iter()
                .map(|d| 2.0 * math::ln(*d))
                .sum()
        }),
    }
}
