//! `boresight plan`: a scenario without data to the passes that should be sailed next.

use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use super::Ending;
use super::args::{CriterionName, Plan, wanted_words};
use super::budget::refuse_keys;
use super::calibrate::folder_of;
use super::demo::demo_or;
use super::error::CliError;
use super::out::tried;
use super::talk::Talk;
use crate::calibrate::planning::PlanAsk;
use crate::calibrate::tried::name_of;
use crate::procedures;
use crate::report::{self, plan as pages};
use crate::results::PlanCriterion;
use crate::survey::reading::read_text;

/// Runs the command.
pub fn run(args: &Plan, talk: &Talk) -> Result<Ending, CliError> {
    refuse_keys(&args.vary)?;
    let file = demo_or(&args.scenario, "plan", args.out.as_deref(), talk)?;
    talk.step(&format!("reading {}", file.display()));
    let text = read_text(&file)?;
    let procedure = procedures::of_text(&file, &text)?;
    let Some(planner) = procedure.planner(&file, &text, &ask(args))? else {
        let procedure = procedure.name();
        return Err(CliError::NoPlan { file, procedure });
    };
    let folder = args.out.clone();
    let folder = folder.unwrap_or_else(|| folder_of(&format!("{}-plan", planner.name())));
    tried(&folder, &pages::PLAN_FILES)?;
    let total = planner.surveys();
    talk.step(&format!("{total} surveys without data"));
    let bar = talk.bar("planning", total as u64);
    let done = AtomicU64::new(0);
    let mut result = planner.plan(&|| bar.set_position(done.fetch_add(1, SeqCst) + 1))?;
    bar.finish_and_clear();
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

fn ask(args: &Plan) -> PlanAsk {
    PlanAsk {
        distances_m: args.distance.clone(),
        speeds_m_s: args.speed.clone(),
        crabs_deg: args.crab.clone(),
        both_directions: args.both_directions,
        keep_passes: !args.from_scratch,
        criterion: match args.criterion {
            CriterionName::D => PlanCriterion::D,
            CriterionName::A => PlanCriterion::A,
        },
        wanted: args.wanted.clone(),
        most: usize::from(args.most),
        vary: args.vary.clone(),
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
    words.extend(wanted_words(&args.wanted));
    words.push(format!("--most {}", args.most));
    words.extend(args.vary.iter().map(|v| format!("--vary '{}'", v.text())));
    words.join(" ")
}
