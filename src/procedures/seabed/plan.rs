//! Which line to sail next: a pattern of lines that the depth gives, each foreseen together with those that are sailed.
//!
//! Lines tell nothing alone; what a line is worth hangs on the lines that it meets. So every candidate is simulated with all lines before
//! it, free of errors but the sonar's noise, and the adjustment's covariance taken at the truth ([`foresee`]).

use std::path::Path;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::foresight::foresee;
use super::joint::reported;
use super::parameters::{Kind, Parameter};
use super::survey::scenario::Course;
use super::survey::{SeabedScenario, parse_scenario};
use super::trials::SeabedTrials;
use crate::calibrate::planning::{PlanAsk, Planner};
use crate::calibrate::seam::InputError;
use crate::calibrate::tried::Tried;
use crate::calibrate::vary::{Point, at, points};
use crate::formats::digest::sha256_of;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::frames;
use crate::math;
use crate::results::{
    BudgetParameter, Figures, PLAN_FORMAT_VERSION, PlanCandidate, PlanCriterion, PlanResult,
    PlanStep, PlanVariation, PlanVariations, PlannedPass, Software,
};

/// What is wanted where nobody says otherwise: degrees and seconds.
const fn usual(kind: Kind) -> f64 {
    match kind {
        Kind::Pitch => 0.05,
        Kind::Roll => 0.02,
        Kind::Yaw => 0.1,
        _ => 0.002,
    }
}
/// Most lines that are added, whatever `--most` allows: a patch test has few.
const MOST: usize = 8;
/// Beside the first track by so much of the half swath: the outer beams reach under the neighbour's boat.
const BESIDE: f64 = 0.95;
/// A sigma that is not determined counts as so many times the wanted one.
const NOTHING: f64 = 1e4;

/// What a plan cannot be asked of a seabed survey.
#[derive(Debug, thiserror::Error)]
enum Refused {
    #[error(
        "--wanted: found \"{0}\", expected one of pitch, roll, yaw (degrees), latency (milliseconds)"
    )]
    Wanted(String),
    #[error(
        "--crab: found a crab angle, expected none: lines of a seabed survey are sailed along their course"
    )]
    Crab,
}

/// A plan about to be made.
struct SeabedPlan {
    scenario: SeabedScenario,
    ask: PlanAsk,
    /// What may be reported, and how well it is wanted.
    sought: Vec<Parameter>,
    wanted: Vec<f64>,
    points: Vec<(Point, SeabedScenario)>,
}

/// The plan of a scenario.
///
/// # Errors
/// [`InputError`]: what is wrong with the file or with what is asked.
pub fn planner(file: &Path, text: &str, ask: &PlanAsk) -> Result<Box<dyn Planner>, InputError> {
    let scenario = parse_scenario(file, text)?;
    if !ask.crabs_deg.is_empty() {
        return Err(InputError::unworkable(Refused::Crab));
    }
    let all = scenario.parameters();
    let sought: Vec<Parameter> = reported(&all).map(|k| all[k]).collect();
    let mut wanted: Vec<f64> = sought.iter().map(|p| usual(p.kind)).collect();
    for (name, value) in &ask.wanted {
        let is_meant = |p: &Parameter| p.base() == name || p.name() == *name;
        if !sought.iter().any(is_meant) {
            return Err(InputError::unworkable(Refused::Wanted(name.clone())));
        }
        for (sigma, parameter) in wanted.iter_mut().zip(&sought) {
            if is_meant(parameter) {
                let unit = if parameter.kind.is_angle() { 1.0 } else { 1e-3 };
                *sigma = value * unit;
            }
        }
    }
    let with_scenario = |point: Point| {
        let there = at(&scenario, &point, &[], SeabedScenario::faults);
        there.map(|there| (point, there))
    };
    let points: Result<Vec<_>, _> = points(&ask.vary).into_iter().map(with_scenario).collect();
    Ok(Box::new(SeabedPlan {
        points: points.map_err(InputError::unworkable)?,
        scenario,
        ask: ask.clone(),
        sought,
        wanted,
    }))
}

/// Standard deviations in degrees and seconds; nothing where the verdict would refuse. `Err` where the lines do not meet.
type Foreseen = Result<Figures, String>;

fn figures(scenario: &SeabedScenario) -> Foreseen {
    let found = foresee(scenario, scenario.seed).map_err(|e| e.to_string())?;
    let one = |k: usize| {
        let sigma = found.joint.sigma(k);
        let is_angle = found.joint.parameters[k].kind.is_angle();
        let shown = if is_angle { sigma.to_degrees() } else { sigma };
        found.judged.determined[k].then_some(shown)
    };
    Ok(found.joint.reported().map(one).collect())
}

/// The track of a line with its directions.
struct Track {
    from: Vector2<f64>,
    to: Vector2<f64>,
    along: Vector2<f64>,
    right: Vector2<f64>,
}

impl Track {
    fn of(course: &Course) -> Self {
        let [from, to] = [course.from_m, course.to_m].map(Vector2::from);
        let along = (to - from).normalize();
        let right = Vector2::new(along.y, -along.x);
        Self {
            from,
            to,
            along,
            right,
        }
    }
}

impl SeabedPlan {
    /// Lines that are added at most.
    fn most(&self) -> usize {
        self.ask.most.min(MOST)
    }

    /// Lines that count as sailed: those of the scenario, or its first alone.
    fn sailed(&self) -> &[Course] {
        let all = &self.scenario.line;
        if self.ask.keep_passes {
            all
        } else {
            &all[..all.len().min(1)]
        }
    }

    fn with(&self, lines: Vec<Course>) -> SeabedScenario {
        SeabedScenario {
            line: lines,
            ..self.scenario.clone()
        }
    }

    /// The lines to choose from: back and forth on the first track, beside it on either side, across its middle; each at every speed.
    fn candidates(&self) -> Vec<Course> {
        let Some(first) = self.scenario.line.first() else {
            return vec![];
        };
        let half = self.scenario.multibeam.half_swath_deg.min(65.0) - 2.0;
        let reach_m = self.scenario.bed.depth_m * math::tan(half.to_radians());
        let own = [(BESIDE * reach_m).round().max(1.0)];
        let beside_m: &[f64] = match self.ask.distances_m.as_slice() {
            [] => &own,
            given => given,
        };
        let mut all = vec![];
        for speed in self.speeds() {
            let mut add = |words: &str, [from, to]: [Vector2<f64>; 2]| {
                all.push(Course {
                    name: format!("{words}, {speed} m/s"),
                    from_m: from.into(),
                    to_m: to.into(),
                    speed_m_s: speed,
                });
            };
            let Track {
                from, to, right, ..
            } = Track::of(first);
            add("again on the track", [from, to]);
            add("back on the track", [to, from]);
            for distance in beside_m {
                let off = right * *distance;
                add(
                    &format!("out {distance} m to starboard"),
                    [from + off, to + off],
                );
                add(
                    &format!("back {distance} m to starboard"),
                    [to + off, from + off],
                );
            }
            let (middle, half_m) = ((from + to) / 2.0, 0.5 * (to - from).norm());
            add("across", [middle - right * half_m, middle + right * half_m]);
        }
        all
    }

    fn speeds(&self) -> Vec<f64> {
        let own = self.scenario.line.iter().map(|line| line.speed_m_s);
        let mut all: Vec<f64> = match self.ask.speeds_m_s.as_slice() {
            [] => own.collect(),
            given => given.to_vec(),
        };
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// How good these figures are, less is better; what is not determined counts as hopeless.
    fn worth(&self, found: &Foreseen) -> f64 {
        let Ok(found) = found else {
            return f64::INFINITY;
        };
        let ratios = found
            .iter()
            .zip(&self.wanted)
            .map(|(sigma, wanted)| sigma.map_or(NOTHING, |sigma| sigma / wanted));
        match self.ask.criterion {
            PlanCriterion::A => ratios.map(|r| r * r).sum(),
            PlanCriterion::D => ratios.map(|r| 2.0 * math::ln(r)).sum(),
        }
    }

    fn reached(&self, found: &Foreseen) -> bool {
        let all = found.iter().flatten().zip(&self.wanted);
        found.is_ok()
            && all
                .into_iter()
                .all(|(sigma, wanted)| sigma.is_some_and(|sigma| sigma <= *wanted))
    }

    /// Every candidate behind these lines.
    fn each_next(
        &self,
        lines: &[Course],
        candidates: &[Course],
        progress: &(dyn Fn() + Sync),
    ) -> Vec<Foreseen> {
        let next = |candidate: &Course| {
            let all = lines.iter().cloned().chain([named(candidate, lines)]);
            let found = figures(&self.with(all.collect()));
            progress();
            found
        };
        candidates.par_iter().map(next).collect()
    }

    fn pass(&self, course: &Course) -> PlannedPass {
        let Track {
            from, along, right, ..
        } = Track::of(&self.scenario.line[0]);
        let ends = [course.from_m, course.to_m].map(Vector2::from);
        PlannedPass {
            name: course.name.clone(),
            distance_m: (ends[0] - from).dot(&right),
            from_m: (ends[0] - from).dot(&along),
            to_m: (ends[1] - from).dot(&along),
            speed_m_s: course.speed_m_s,
            crab_deg: 0.0,
            begin_deg: Some(self.on_earth(&ends[0])),
            end_deg: Some(self.on_earth(&ends[1])),
        }
    }

    /// Latitude and longitude, degrees.
    fn on_earth(&self, place: &Vector2<f64>) -> [f64; 2] {
        let site = &self.scenario.site;
        let pose = TargetPose {
            ellipsoid: site.ellipsoid,
            origin: site.origin.geodetic(),
            azimuth_rad: 0.0,
        };
        let point = frames::Point::<frames::Target>::new(Vector3::new(place.x, place.y, 0.0));
        let found = pose
            .ellipsoid
            .to_geodetic(&(pose.ecef_from_target() * point));
        [found.latitude_rad, found.longitude_rad].map(f64::to_degrees)
    }

    fn variations(&self, progress: &(dyn Fn() + Sync)) -> Option<PlanVariations> {
        let (first, _) = self.points.first()?;
        let variation = |(point, scenario): &(Point, SeabedScenario)| {
            let found = figures(scenario);
            progress();
            PlanVariation {
                values: point.0.iter().map(|(_, value)| value.plain()).collect(),
                standard_deviation: found.as_ref().ok().cloned(),
                refusal: found.err().unwrap_or_default(),
            }
        };
        Some(PlanVariations {
            keys: first.0.iter().map(|(key, _)| key.clone()).collect(),
            points: self.points.par_iter().map(variation).collect(),
        })
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "each line is predicted together with all lines before it, on one bed of the scenario's relief; another bed changes the figures by \
             several per cent"
                .to_owned(),
            "only what the survey states of its own errors is counted; ripples and boulders of the scenario are on the bed, but not in the model of it"
                .to_owned(),
        ];
        if !self.ask.keep_passes {
            notes.push("from scratch: the scenario's first line counts as sailed, as one line alone determines nothing".to_owned());
        }
        notes
    }
}

/// A candidate under a name that no other line has.
fn named(candidate: &Course, lines: &[Course]) -> Course {
    let name = format!("{} ({})", candidate.name, lines.len() + 1);
    Course {
        name,
        ..candidate.clone()
    }
}

/// The lines chosen, greedily.
struct Chosen {
    steps: Vec<PlanStep>,
    reached: bool,
}

impl SeabedPlan {
    fn chosen(
        &self,
        candidates: &[Course],
        first: &[Foreseen],
        (start, sailed): (&Foreseen, &[Course]),
        progress: &(dyn Fn() + Sync),
    ) -> Chosen {
        let mut chosen = Chosen {
            steps: vec![],
            reached: self.reached(start),
        };
        let (mut lines, mut next) = (sailed.to_vec(), first.to_vec());
        while !chosen.reached && chosen.steps.len() < self.most() {
            let better =
                |a: &usize, b: &usize| self.worth(&next[*a]).total_cmp(&self.worth(&next[*b]));
            let best = (0..next.len()).min_by(better);
            let Some((k, Ok(found))) = best.map(|k| (k, &next[k])) else {
                break;
            };
            chosen.steps.push(PlanStep {
                candidate: k as u64,
                name: candidates[k].name.clone(),
                standard_deviation: found.clone(),
            });
            chosen.reached = self.reached(&next[k]);
            lines.push(named(&candidates[k], &lines));
            if !chosen.reached && chosen.steps.len() < self.most() {
                next = self.each_next(&lines, candidates, progress);
            }
        }
        chosen
    }
}

impl Planner for SeabedPlan {
    fn name(&self) -> &str {
        &self.scenario.name
    }

    fn surveys(&self) -> usize {
        1 + self.candidates().len() * (1 + self.most() / 2) + self.points.len()
    }

    fn plan(&self, progress: &(dyn Fn() + Sync)) -> Result<PlanResult, InputError> {
        let (sailed, candidates) = (self.sailed(), self.candidates());
        let start = figures(&self.with(sailed.to_vec()));
        progress();
        let first = self.each_next(sailed, &candidates, progress);
        let chosen = self.chosen(&candidates, &first, (&start, sailed), progress);
        let tried = SeabedTrials {
            scenario: self.scenario.clone(),
        };
        let candidate = |(course, found): (&Course, &Foreseen)| PlanCandidate {
            pass: self.pass(course),
            soundings: 0,
            returns: 0,
            standard_deviation_if_next: found.as_ref().ok().cloned(),
            refusal: found.as_ref().err().cloned().unwrap_or_default(),
        };
        Ok(PlanResult {
            format_version: PLAN_FORMAT_VERSION,
            scenario: self.scenario.name.clone(),
            scenario_sha256: sha256_of(&tried.content()),
            software: Software::this(),
            command: String::new(),
            criterion: self.ask.criterion,
            parameters: self.sought.iter().map(parameter).collect(),
            wanted: self.wanted.iter().copied().map(Some).collect(),
            sailed: sailed.iter().map(|line| self.pass(line)).collect(),
            sailed_standard_deviation: start.ok(),
            passes_needed: chosen.reached.then_some(chosen.steps.len() as u64),
            chosen: chosen.steps,
            most: self.most() as u64,
            floor: None,
            unreachable: vec![],
            candidates: candidates.iter().zip(&first).map(candidate).collect(),
            faces_from_above_m: vec![],
            variations: self.variations(progress),
            notes: self.notes(),
        })
    }
}

fn parameter(parameter: &Parameter) -> BudgetParameter {
    let unit = match parameter.unit() {
        "rad" => "deg",
        unit => unit,
    };
    BudgetParameter {
        name: parameter.name(),
        unit: unit.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask() -> PlanAsk {
        PlanAsk {
            distances_m: vec![],
            speeds_m_s: vec![2.0],
            crabs_deg: vec![],
            both_directions: false,
            keep_passes: false,
            criterion: PlanCriterion::D,
            wanted: [
                ("pitch", 0.2),
                ("roll", 0.05),
                ("yaw", 0.4),
                ("latency", 5.0),
            ]
            .map(|(n, v)| (n.to_owned(), v))
            .to_vec(),
            most: 4,
            vary: vec![],
        }
    }

    /// From one line on: pitch wants a line back or across, yaw one beside or across; the plan ends with all three angles determined,
    /// and each line that it adds makes nothing worse than a fresh draw of the soundings does.
    #[test]
    fn a_plan_ends_where_everything_is_determined() {
        let text = include_str!("../../../models/scenarios/seabed-thin.toml");
        let text = &text.replace("max_tiles = 120", "max_tiles = 60");
        let found = planner(Path::new("seabed-thin.toml"), text, &ask()).expect("a plan");
        let result = found.plan(&|| ()).expect("planned");
        assert_eq!(result.sailed.len(), 1);
        assert!(result.sailed_standard_deviation.is_none());
        // swath of 60 deg in 10 m of water, less a twentieth
        let names: Vec<&str> = result
            .candidates
            .iter()
            .map(|c| c.pass.name.as_str())
            .collect();
        assert!(
            names.contains(&"back 16 m to starboard, 2 m/s"),
            "{names:?}"
        );
        assert_eq!(result.passes_needed, Some(result.chosen.len() as u64));
        let last = result.chosen.last().expect("a line");
        for (sigma, wanted) in last.standard_deviation.iter().zip(&result.wanted) {
            assert!(sigma.expect("determined") <= wanted.expect("wanted"));
        }
        // again on the track in the same direction: no angle
        let again = &result.candidates[0];
        let angles = again
            .standard_deviation_if_next
            .as_ref()
            .expect("they meet");
        assert_eq!(angles[..3], [None; 3]);
        let [begin, end] = [again.pass.begin_deg, again.pass.end_deg].map(|p| p.expect("a place"));
        // 150 m northwards at 31.4 degrees: 110 870 m to the degree
        assert!(
            ((end[0] - begin[0]) * 110_870.0 - 150.0).abs() < 0.5,
            "{begin:?} {end:?}"
        );
    }

    #[test]
    fn what_cannot_be_asked_is_refused_by_name() {
        let text = include_str!("../../../models/scenarios/seabed-thin.toml");
        let crab = PlanAsk {
            crabs_deg: vec![3.0],
            ..ask()
        };
        let wanted = PlanAsk {
            wanted: vec![("lz".to_owned(), 1.0)],
            ..ask()
        };
        for (ask, word) in [(crab, "--crab"), (wanted, "found \"lz\"")] {
            let found = planner(Path::new("seabed-thin.toml"), text, &ask);
            let said = found.err().expect("refused").to_string();
            assert!(said.contains(word), "{said}");
        }
    }
}
