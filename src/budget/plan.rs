//! Planning without data: what candidate passes would tell, which of them to sail next, and how many are needed.
//!
//! Each candidate is simulated free of errors and linearised once: its information on everything that passes share (mounting,
//! scanner mounting, planes, face offsets), with its own trajectory errors eliminated. Passes have a pause between them that is
//! long compared with what is exchanged here, so their information adds; the priors count once. Greedy choice: for the
//! determinant (D-optimal) or the sum of variances in units of what is wanted (A-optimal) of the six parameters' covariance
//! (Pukelsheim, *Optimal Design of Experiments*, 2006, ch. 6; Nemhauser, Wolsey & Fisher 1978 for the greedy choice).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix6};

use super::passes::{PassError, information_of};
use crate::calibrate::pool::joint::Information;
use crate::simulate::Scenario;
use crate::simulate::scenario::Pass;

/// What "well known" means where nobody says: nobody expects a mounting to be wrong by more, radians and metres.
const VAGUE: (f64, f64) = (0.35, 3.0);

/// What the next pass should make smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// The determinant of the covariance: the volume of the error ellipsoid.
    D,
    /// The sum of the variances, each in units of the wanted standard deviation.
    A,
}

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
    pub criterion: Criterion,
    /// Standard deviations wanted: pitch, roll, yaw (rad), lx, ly, lz (m).
    pub wanted: [f64; 6],
    /// Passes that are added at the most.
    pub most: usize,
}

/// A candidate pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What tells it from the others.
    pub name: String,
    /// The pass.
    pub pass: Pass,
    /// Soundings and laser returns that would be tied.
    pub ties: (usize, usize),
    /// Standard deviations if this pass were sailed next.
    pub next: [f64; 6],
}

/// One step of the greedy choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Index of the candidate.
    pub candidate: usize,
    /// Standard deviations with it and all before.
    pub sigmas: [f64; 6],
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Passes already sailed.
    pub sailed: usize,
    /// Standard deviations with those; `None` where nothing is sailed.
    pub start: Option<[f64; 6]>,
    /// Candidates in the order of the request.
    pub candidates: Vec<Candidate>,
    /// The passes to sail, in order; ends when everything wanted is reached.
    pub steps: Vec<Step>,
    /// Passes to add until everything wanted is reached; `None` where the most that was allowed does not do.
    pub needed: Option<usize>,
    /// Standard deviations that no number of these passes would go below: every candidate sailed ten thousand times.
    pub floor: [f64; 6],
}

/// Plans. `progress` is told what is being done.
///
/// # Errors
/// [`PassError`] when a candidate cannot be simulated or is not seen by both sensors.
pub fn plan(
    scenario: &Scenario,
    request: &PlanRequest,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Plan, PassError> {
    let mut sailed = Sum::default();
    if request.keep_passes {
        for (k, pass) in scenario.pass.iter().enumerate() {
            progress(&format!("pass {} of the scenario", k + 1));
            sailed.add(&information_of(scenario, pass)?);
        }
    }
    let passes = candidates(scenario, request);
    let mut offered = vec![];
    for (name, pass) in &passes {
        progress(&format!("candidate {name}"));
        offered.push(information_of(scenario, pass)?);
    }
    let describe = |((name, pass), information): ((String, Pass), &Information)| Candidate {
        name,
        pass,
        ties: (information.soundings, information.returns),
        next: sigmas(&sailed.with(information).covariance()),
    };
    let described = passes.into_iter().zip(&offered).map(describe).collect();
    let steps = greedy(&sailed, &offered, request);
    let reached = |s: &[f64; 6]| s.iter().zip(&request.wanted).all(|(s, w)| s <= w);
    let start = (sailed.passes > 0).then(|| sigmas(&sailed.covariance()));
    let needed = match &start {
        Some(start) if reached(start) => Some(0),
        _ => steps.iter().position(|s| reached(&s.sigmas)).map(|k| k + 1),
    };
    let mut all = sailed.clone();
    offered.iter().for_each(|o| all.add_times(o, 1e4));
    Ok(Plan {
        sailed: sailed.passes,
        start,
        candidates: described,
        steps,
        needed,
        floor: sigmas(&all.covariance()),
    })
}

/// Every combination that is asked for, along the course of the scenario's first pass.
fn candidates(scenario: &Scenario, request: &PlanRequest) -> Vec<(String, Pass)> {
    let Some(model) = scenario.pass.first() else {
        return vec![];
    };
    let or_own = |values: &[f64], own: fn(&Pass) -> f64| {
        let mut all: Vec<f64> = values.to_vec();
        if all.is_empty() {
            all = scenario.pass.iter().map(own).collect();
        }
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let distances = or_own(&request.distances_m, |p| p.distance_m);
    let speeds = or_own(&request.speeds_m_s, |p| p.speed_m_s);
    let crabs = or_own(&request.crabs_deg, |p| p.crab_deg);
    let mut all = vec![];
    for &distance_m in &distances {
        for &speed_m_s in &speeds {
            for &crab_deg in &crabs {
                for back in [false, true] {
                    if back && !request.both_directions {
                        continue;
                    }
                    let (from_m, to_m) = match back {
                        false => (model.from_m, model.to_m),
                        true => (model.to_m, model.from_m),
                    };
                    let way = if to_m > from_m { "+Y" } else { "-Y" };
                    let crab = match crab_deg {
                        0.0 => String::new(),
                        _ => format!(", crab {crab_deg} deg"),
                    };
                    all.push((
                        format!("{distance_m} m, {speed_m_s} m/s, {way}{crab}"),
                        Pass {
                            distance_m,
                            from_m,
                            to_m,
                            speed_m_s,
                            crab_deg,
                            gap_s: model.gap_s,
                        },
                    ));
                }
            }
        }
    }
    all
}

/// Adds the best candidate again and again until everything wanted is reached.
fn greedy(sailed: &Sum, offered: &[Information], request: &PlanRequest) -> Vec<Step> {
    let mut here = sailed.clone();
    let mut steps: Vec<Step> = vec![];
    while steps.len() < request.most {
        let trial = |(k, information)| (k, here.with(information).covariance());
        let best = offered
            .iter()
            .enumerate()
            .map(trial)
            .map(|(k, covariance)| (k, worth(&covariance, request), covariance))
            .fold(
                None,
                |best: Option<(usize, f64, Matrix6<f64>)>, one| match best {
                    Some(best) if best.1 <= one.1 => Some(best),
                    _ => Some(one),
                },
            );
        let Some((candidate, _, covariance)) = best else {
            break;
        };
        here.add(&offered[candidate]);
        let sigmas = sigmas(&covariance);
        let reached = sigmas.iter().zip(&request.wanted).all(|(s, w)| s <= w);
        steps.push(Step { candidate, sigmas });
        if reached {
            break;
        }
    }
    steps
}

/// What the criterion makes smallest, parameters in units of what is wanted.
fn worth(covariance: &Matrix6<f64>, request: &PlanRequest) -> f64 {
    let w = &request.wanted;
    let scaled = Matrix6::from_fn(|i, j| covariance[(i, j)] / (w[i] * w[j]));
    match request.criterion {
        Criterion::A => scaled.trace(),
        Criterion::D => scaled.cholesky().map_or(f64::INFINITY, |c| {
            c.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum()
        }),
    }
}

fn sigmas(covariance: &Matrix6<f64>) -> [f64; 6] {
    std::array::from_fn(|i| covariance[(i, i)].sqrt())
}

/// Information of several passes, over the union of their parameters by name.
#[derive(Clone, Debug, Default)]
struct Sum {
    columns: Vec<String>,
    observed: DMatrix<f64>,
    /// Priors by name of a column pair.
    prior: BTreeMap<(usize, usize), f64>,
    passes: usize,
}

impl Sum {
    fn with(&self, information: &Information) -> Self {
        let mut sum = self.clone();
        sum.add(information);
        sum
    }

    fn add(&mut self, information: &Information) {
        self.add_times(information, 1.0);
    }

    fn add_times(&mut self, information: &Information, times: f64) {
        let places: Vec<usize> = information
            .columns
            .iter()
            .map(|name| self.column(name))
            .collect();
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                self.observed[(a, b)] += times * information.observed[(i, j)];
                if information.prior[(i, j)] != 0.0 {
                    self.prior.insert((a, b), information.prior[(i, j)]);
                }
            }
        }
        self.passes += 1;
    }

    fn column(&mut self, name: &str) -> usize {
        if let Some(known) = self.columns.iter().position(|c| c == name) {
            return known;
        }
        self.columns.push(name.to_owned());
        let n = self.columns.len();
        self.observed = std::mem::take(&mut self.observed).resize(n, n, 0.0);
        n - 1
    }

    /// Covariance of the six, everything else eliminated; a vague prior keeps it finite where nothing is determined.
    fn covariance(&self) -> Matrix6<f64> {
        let mut whole = self.observed.clone();
        for (&place, value) in &self.prior {
            whole[place] += value;
        }
        for i in 0..6.min(whole.nrows()) {
            let sigma = if i < 3 { VAGUE.0 } else { VAGUE.1 };
            whole[(i, i)] += sigma.powi(-2);
        }
        let unknown = Matrix6::from_diagonal_element(f64::INFINITY);
        // columns scaled to unit length, so that rounding does not decide
        let scale: Vec<f64> = whole
            .diagonal()
            .iter()
            .map(|d| if *d > 0.0 { d.sqrt() } else { 1.0 })
            .collect();
        let scaled = DMatrix::from_fn(whole.nrows(), whole.ncols(), |i, j| {
            let own = f64::from(u8::from(i == j)) * 1e-14;
            whole[(i, j)] / (scale[i] * scale[j]) + own
        });
        let Some(inverse) = scaled.cholesky().map(|c| c.inverse()) else {
            return unknown;
        };
        if inverse.nrows() < 6 {
            return unknown;
        }
        Matrix6::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j]))
    }
}
