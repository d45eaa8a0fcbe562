//! Which line to sail next: a pattern of lines that the depth gives, each foreseen together with those that are sailed.
//!
//! Lines tell nothing alone; what a line is worth hangs on the lines that it meets. So every candidate is simulated with all lines before
//! it, free of errors but the sonar's noise, and the adjustment's covariance taken at the truth ([`foresee`]).

use std::path::Path;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::foresight::{Foresight, QUIET, foresee, foresee_on};
use super::joint::{JointError, reported};
use super::parameters::{Kind, Parameter};
use super::sailed;
use super::simulate::Ground;
use super::survey::scenario::Course;
use super::survey::{SeabedScenario, load, parse_scenario};
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
use crate::survey::{Problem, SurveyError, is_survey};

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
/// Candidates that are looked at together once there is a bound on what each can add.
const TOGETHER: usize = 4;
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
    /// What is to be said of reading the survey; `None` for a scenario.
    of_reading: Option<Vec<String>>,
}

/// The lines of a survey that was sailed, as a scenario, and what is to be said of reading it.
fn of_survey(file: &Path) -> Result<(SeabedScenario, Vec<String>), InputError> {
    let survey = load(file)?;
    let (scenario, mut notes) = sailed::as_scenario(&survey).map_err(|error| {
        let expected = "a survey of which the next line can be planned";
        SurveyError::from(Problem::new(
            file,
            "whole file",
            error.to_string(),
            expected,
        ))
    })?;
    notes.extend(survey.notes);
    Ok((scenario, notes))
}

/// The plan of a scenario, or of a survey that was sailed.
///
/// # Errors
/// [`InputError`]: what is wrong with the file or with what is asked.
pub fn planner(file: &Path, text: &str, ask: &PlanAsk) -> Result<Box<dyn Planner>, InputError> {
    let (scenario, of_reading) = if is_survey(text) {
        let (scenario, notes) = of_survey(file)?;
        (scenario, Some(notes))
    } else {
        (parse_scenario(file, text)?, None)
    };
    if !ask.crabs_deg.is_empty() {
        return Err(InputError::unworkable(Refused::Crab));
    }
    let all = scenario.parameters();
    let sought: Vec<Parameter> = reported(&all).map(|k| all[k].clone()).collect();
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
        of_reading,
    }))
}

/// Standard deviations in degrees and seconds; nothing where the verdict would refuse. `Err` where the lines do not meet.
type Foreseen = Result<Figures, String>;

fn figures(scenario: &SeabedScenario) -> Foreseen {
    told(foresee(scenario, scenario.seed))
}

fn told(found: Result<Foresight, JointError>) -> Foreseen {
    let found = found.map_err(|e| e.to_string())?;
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
            [] if self.of_reading.is_some() => sailed::speeds_m_s(&self.scenario.line),
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

    /// Candidates behind these lines, most promising first, until none of the others can be better: a line adds less the more are sailed, so
    /// that what it added before bounds what it adds now. `added` is what each added to the lines before, and is brought up to date.
    fn each_next(
        &self,
        (lines, now): (&[Course], &Foreseen),
        candidates: &[Course],
        added: &mut [f64],
        progress: &(dyn Fn() + Sync),
    ) -> Vec<Option<Foreseen>> {
        let (sailed, seed) = (self.with(lines.to_vec()), self.scenario.seed);
        // the lines before are the same for every candidate
        let mut ground = Ground::under(&sailed, candidates, seed);
        ground.remember(&sailed, seed, QUIET);
        let next = |k: &usize| {
            let all = lines.iter().cloned().chain([named(&candidates[*k], lines)]);
            let found = told(foresee_on(&ground, &self.with(all.collect()), seed));
            progress();
            found
        };
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by(|a, b| added[*b].total_cmp(&added[*a]));
        let mut all = vec![None; candidates.len()];
        let (here, mut best) = (self.worth(now), f64::INFINITY);
        // nothing bounds them at first
        let unbounded = added.iter().all(|a| a.is_infinite());
        let at_once = if unbounded { order.len() } else { TOGETHER };
        for together in order.chunks(at_once.max(1)) {
            if here - added[together[0]] >= best {
                break;
            }
            let found: Vec<Foreseen> = together.par_iter().map(next).collect();
            for (k, found) in together.iter().zip(found) {
                let worth = self.worth(&found);
                best = best.min(worth);
                // beside what is not determined yet, a line may add more later than now
                if is_whole(now) {
                    added[*k] = here - worth;
                }
                all[*k] = Some(found);
            }
        }
        all
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
        if let Some(read) = &self.of_reading {
            notes.splice(0..0, read.iter().cloned());
        }
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

/// Whether everything is determined.
fn is_whole(found: &Foreseen) -> bool {
    let all = |figures: &Figures| figures.iter().all(Option::is_some);
    found.as_ref().is_ok_and(all)
}

impl SeabedPlan {
    fn chosen(
        &self,
        candidates: &[Course],
        (first, mut added): (&[Option<Foreseen>], Vec<f64>),
        (start, sailed): (&Foreseen, &[Course]),
        progress: &(dyn Fn() + Sync),
    ) -> Chosen {
        let mut chosen = Chosen {
            steps: vec![],
            reached: self.reached(start),
        };
        let (mut lines, mut next) = (sailed.to_vec(), first.to_vec());
        while !chosen.reached && chosen.steps.len() < self.most() {
            let looked_at = next.iter().enumerate();
            let looked_at = looked_at.filter_map(|(k, found)| Some((k, found.as_ref()?)));
            let best = looked_at.min_by(|a, b| self.worth(a.1).total_cmp(&self.worth(b.1)));
            let Some((k, Ok(found))) = best else {
                break;
            };
            let now: Foreseen = Ok(found.clone());
            chosen.steps.push(PlanStep {
                candidate: k as u64,
                name: candidates[k].name.clone(),
                standard_deviation: found.clone(),
            });
            chosen.reached = self.reached(&now);
            lines.push(named(&candidates[k], &lines));
            if !chosen.reached && chosen.steps.len() < self.most() {
                next = self.each_next((&lines, &now), candidates, &mut added, progress);
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
        1 + self.candidates().len() + TOGETHER * self.most() + self.points.len()
    }

    fn plan(&self, progress: &(dyn Fn() + Sync)) -> Result<PlanResult, InputError> {
        let (sailed, candidates) = (self.sailed(), self.candidates());
        let start = figures(&self.with(sailed.to_vec()));
        progress();
        let mut added = vec![f64::INFINITY; candidates.len()];
        let first = self.each_next((sailed, &start), &candidates, &mut added, progress);
        let chosen = self.chosen(&candidates, (&first, added), (&start, sailed), progress);
        let first: Vec<Foreseen> = first.into_iter().flatten().collect();
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

    /// A survey that lacks the line back and the one beside it: read as sailed, and the lines that are proposed lie beside its own on earth.
    #[test]
    fn a_survey_that_was_sailed_gets_the_line_that_it_lacks() {
        let text = include_str!("../../../models/scenarios/seabed-thin.toml");
        let text = text.replace("max_tiles = 120", "max_tiles = 60");
        let mut scenario =
            parse_scenario(Path::new("seabed-thin.toml"), &text).expect("a scenario");
        scenario.line.truncate(1);
        let folder = tempfile::tempdir().expect("a folder");
        let sailed = crate::procedures::seabed::simulate::simulate(
            &scenario,
            1,
            crate::procedures::seabed::simulate::Acts::ALL,
        );
        crate::procedures::seabed::survey::write::write(folder.path(), &scenario, &sailed)
            .expect("written");
        let file = folder.path().join("survey.toml");
        let text = std::fs::read_to_string(&file).expect("a survey");
        let ask = PlanAsk {
            keep_passes: true,
            ..ask()
        };
        let result = planner(&file, &text, &ask)
            .expect("a plan")
            .plan(&|| ())
            .expect("planned");
        assert!(
            result.sailed_standard_deviation.is_none(),
            "one line determines nothing"
        );
        assert_eq!(result.passes_needed, Some(result.chosen.len() as u64));
        let names: Vec<&str> = result
            .candidates
            .iter()
            .map(|c| c.pass.name.as_str())
            .collect();
        // 13 m of water under the first line, where the scenario has 10 at its origin
        assert!(
            names.contains(&"back 21 m to starboard, 2 m/s"),
            "{names:?}"
        );
        let place =
            |pass: &PlannedPass| [pass.begin_deg, pass.end_deg].map(|p| p.expect("a place"));
        let own = place(&result.sailed[0]);
        // from 31.4 N, 121.8 E northwards for as long as soundings were taken
        assert!(
            (own[0][0] - 31.4).abs() < 1e-5 && (own[0][1] - 121.8).abs() < 1e-6,
            "{own:?}"
        );
        let way_m = (own[1][0] - own[0][0]) * 110_870.0;
        assert!((way_m - 149.0).abs() < 1.0, "{way_m}");
        let back = place(&result.candidates[1].pass);
        assert!((back[0][0] - own[1][0]).abs() < 1e-7 && (back[1][0] - own[0][0]).abs() < 1e-7);
        assert!(
            result.notes[0].contains("1 lines as sailed"),
            "{:?}",
            result.notes
        );
    }

    /// Looking only at candidates that may be better finds what looking at all of them finds.
    #[test]
    fn candidates_that_cannot_be_better_are_not_looked_at() {
        let text = include_str!("../../../models/scenarios/seabed-thin.toml");
        let text = &text.replace("max_tiles = 120", "max_tiles = 80");
        let looked = std::sync::atomic::AtomicUsize::new(0);
        let ask = PlanAsk {
            keep_passes: true,
            wanted: vec![("pitch".to_owned(), 1e-6)],
            most: 2,
            ..ask()
        };
        let found = planner(Path::new("seabed-thin.toml"), text, &ask).expect("a plan");
        let result = found
            .plan(&|| {
                looked.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
            })
            .expect("planned");
        assert_eq!(result.chosen.len(), 2);
        assert!(
            result
                .candidates
                .iter()
                .all(|c| c.standard_deviation_if_next.is_some())
        );
        let (all, looked) = (result.candidates.len(), looked.into_inner());
        assert!(looked > all && looked < 1 + 2 * all, "{looked} of {all}");
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
