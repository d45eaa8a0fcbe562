//! `boresight plan`: a scenario without data to the passes that should be sailed next.

use std::path::Path;
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use super::Ending;
use super::args::{CriterionName, Plan};
use super::calibrate::folder_of;
use super::demo::demo_or;
use super::error::CliError;
use super::out::tried;
use super::talk::Talk;
use crate::calibrate::tried::name_of;
use crate::calibrate::vary::{Point, Vary, VaryError, at, points};
use crate::formats::error::read_text;
use crate::procedures;
use crate::procedures::pool::JointConfig;
use crate::procedures::pool::budget::plan::{PlanRequest, candidates};
use crate::procedures::pool::budget::planned::{BEST_PUBLISHED, NAMES, planned};
use crate::procedures::pool::budget::sailed::as_scenario;
use crate::procedures::pool::budget::trials::ALIASES;
use crate::procedures::pool::survey::{load, scenario};
use crate::report::{self, plan as pages};
use crate::results::PlanCriterion;
use crate::simulate::Scenario;
use crate::survey::is_survey;

/// Standard deviations wanted: pitch, roll, yaw (rad), lx, ly, lz (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted(pub [f64; 6]);

impl Default for Wanted {
    fn default() -> Self {
        let (angle, arm) = (BEST_PUBLISHED.0.to_radians(), BEST_PUBLISHED.1);
        Self([angle, angle, angle, arm, arm, arm])
    }
}

impl FromStr for Wanted {
    type Err = String;

    /// `pitch=0.01,lx=1`: degrees and millimetres; the others by default.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut wanted = Self::default();
        for part in text.split(',') {
            let (name, value) = part.split_once('=').ok_or("expected NAME=VALUE,...")?;
            let names = NAMES.join(", ");
            let place = NAMES.iter().position(|n| *n == name.trim());
            let i = place.ok_or(format!("found \"{name}\", expected one of {names}"))?;
            let value: f64 = value.trim().parse().unwrap_or(f64::NAN);
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{name}: expected a number above 0"));
            }
            wanted.0[i] = if i < 3 {
                value.to_radians()
            } else {
                value * 1e-3
            };
        }
        Ok(wanted)
    }
}

/// Runs the command.
pub fn run(args: &Plan, talk: &Talk) -> Result<Ending, CliError> {
    let folder = args.out.clone();
    let (scenario, config, sailed_for_real) = read(&args.scenario, folder.as_deref(), talk)?;
    if args.vary.len() > 2 {
        let found = args.vary.len();
        return Err(CliError::TooManyKeys { found });
    }
    let points = swept(&scenario, &args.vary)?;
    let request = request(args).widened(&scenario);
    let sailed = if request.keep_passes {
        scenario.pass.len()
    } else {
        0
    };
    let folder = folder.unwrap_or_else(|| folder_of(&format!("{}-plan", scenario.name)));
    tried(&folder, &pages::PLAN_FILES)?;
    let total = sailed + candidates(&scenario, &request).len() + points.len();
    talk.step(&format!("{total} surveys without data"));
    let bar = talk.bar("planning", total as u64);
    let done = AtomicU64::new(0);
    let progress = || bar.set_position(done.fetch_add(1, SeqCst) + 1);
    let mut result = planned(&scenario, &request, &points, &config, &progress)?;
    bar.finish_and_clear();
    if sailed_for_real {
        result.notes.insert(0, AS_SAILED.to_owned());
    }
    result.command = command(args);
    talk.step(&format!("writing {}", folder.display()));
    let files = report::write_plan(&folder, &result)?;
    let courses = files.courses.iter();
    let courses: String = courses
        .map(|file| format!("Courses {}\n", file.display()))
        .collect();
    let text = format!(
        "{}\nPlan    {}\nTable   {}\nPage    {}\n{courses}",
        pages::summary(&result),
        files.json.display(),
        files.table.display(),
        files.page.display()
    );
    talk.result(&text, &pages::to_bytes(&result)?)?;
    Ok(Ending::Usable)
}

/// What is said of a survey's passes.
const AS_SAILED: &str = "The passes were read from the survey's trajectory and its motion taken as sines of the observed size and period: a \
    prediction, not the survey's own result";

/// The scenario of a file and how it is calibrated; of a survey, its passes as sailed, and `true`.
fn read(
    file: &Path,
    out: Option<&Path>,
    talk: &Talk,
) -> Result<(Scenario, JointConfig, bool), CliError> {
    let file = &demo_or(file, "plan", out, talk)?;
    talk.step(&format!("reading {}", file.display()));
    let procedure = procedures::of_file(file)?;
    if procedure.name() != PLANNED {
        let (file, procedure) = (file.clone(), procedure.name());
        return Err(CliError::NoPlan { file, procedure });
    }
    if read_text(file).is_ok_and(|text| is_survey(&text)) {
        let survey = load(file)?;
        let scenario = as_scenario(&survey);
        let scenario = scenario.ok_or_else(|| CliError::NoPasses { file: file.clone() })?;
        return Ok((scenario, survey.file.joint, true));
    }
    let read = scenario::read(file)?;
    let joint = read.calibration(file)?.joint;
    Ok((read.scenario, joint, false))
}

/// The procedure that has plans.
const PLANNED: &str = "pool";

/// The values of `--vary`, each with its scenario.
fn swept(scenario: &Scenario, vary: &[Vary]) -> Result<Vec<(Point, Scenario)>, VaryError> {
    let with_scenario = |point: Point| {
        let scenario = at(scenario, &point, &ALIASES, Scenario::check)?;
        Ok((point, scenario))
    };
    points(vary).into_iter().map(with_scenario).collect()
}

fn request(args: &Plan) -> PlanRequest {
    PlanRequest {
        distances_m: args.distance.clone(),
        speeds_m_s: args.speed.clone(),
        crabs_deg: args.crab.clone(),
        both_directions: args.both_directions,
        keep_passes: !args.from_scratch,
        criterion: match args.criterion {
            CriterionName::D => PlanCriterion::D,
            CriterionName::A => PlanCriterion::A,
        },
        wanted: args.wanted.unwrap_or_default().0,
        most: usize::from(args.most),
    }
}

/// The command that makes the plan again, without its folder.
fn command(args: &Plan) -> String {
    let mut words = vec![format!("boresight plan {}", name_of(&args.scenario))];
    let list = |values: &[f64]| {
        let all: Vec<String> = values.iter().map(ToString::to_string).collect();
        all.join(",")
    };
    let lists = [
        ("distance", &args.distance),
        ("speed", &args.speed),
        ("crab", &args.crab),
    ];
    for (name, values) in lists.into_iter().filter(|(_, v)| !v.is_empty()) {
        words.push(format!("--{name} {}", list(values)));
    }
    for (name, given) in [
        ("both-directions", args.both_directions),
        ("from-scratch", args.from_scratch),
    ] {
        words.extend(given.then(|| format!("--{name}")));
    }
    if args.criterion == CriterionName::A {
        words.push("--criterion a".to_owned());
    }
    if let Some(Wanted(six)) = args.wanted {
        let unit = |i: usize| {
            if i < 3 {
                six[i].to_degrees()
            } else {
                six[i] * 1e3
            }
        };
        let tidy = |v: f64| format!("{v:.9e}").parse().unwrap_or(v);
        let all: Vec<String> = (0..6)
            .map(|i| format!("{}={}", NAMES[i], tidy(unit(i))))
            .collect();
        words.push(format!("--wanted {}", all.join(",")));
    }
    words.push(format!("--most {}", args.most));
    words.extend(args.vary.iter().map(|v| format!("--vary '{}'", v.text())));
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wanted_is_read_in_degrees_and_millimetres() {
        let wanted: Wanted = "pitch=0.01, lz=3".parse().expect("two values");
        let best = Wanted::default().0;
        assert_eq!(wanted.0[0], 0.01f64.to_radians());
        assert_eq!(wanted.0[5], 0.003);
        assert_eq!(wanted.0[1..5], best[1..5]);
        for (text, part) in [
            ("pitch", "NAME=VALUE"),
            ("heading=1", "expected one of pitch"),
            ("roll=-1", "above 0"),
            ("roll=x", "above 0"),
        ] {
            let error = text.parse::<Wanted>().expect_err(text);
            assert!(error.contains(part), "{error}");
        }
    }
}
