//! `boresight budget`: a scenario to an error budget, by Monte Carlo and, where the procedure has derivatives, by propagation.

use std::path::{Path, PathBuf};

use super::Ending;
use super::args::{Budget, wanted_words};
use super::calibrate::folder_of;
use super::demo::demo_or;
use super::error::CliError;
use super::interrupt::Gentle;
use super::out::tried as writable;
use super::talk::Talk;
use crate::budget::experiment::{Ended, Experiment, Role};
use crate::budget::join::{Joined, TRIALS};
use crate::budget::summary::frame;
use crate::budget::{DEPTHS_M, budget, propagated_sweep};
use crate::calibrate::seam::Settings;
use crate::calibrate::tried::{Tried, name_of};
use crate::calibrate::vary::{Vary, points};
use crate::formats::error::read_text;
use crate::procedures;
use crate::report::wanted::goals;
use crate::report::{self, budget as pages};
use crate::results::{BudgetResult, JOINT};

/// Trials of all sources together when the user says nothing and nothing can be propagated.
const DEFAULT_TRIALS: u64 = 200;

/// Trials of each source alone when the user says nothing and nothing can be propagated.
const DEFAULT_SINGLE: u64 = 50;

/// Runs the command.
pub fn run(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    let scenario = demo_or(&args.scenario, "budget", args.out.as_deref(), talk)?;
    let args = &Budget {
        scenario,
        ..args.clone()
    };
    talk.step(&format!("reading {}", args.scenario.display()));
    let procedure = procedures::of_file(&args.scenario)?;
    if !procedures::is_survey(&args.scenario, &read_text(&args.scenario)?) {
        return of(&*procedures::scenario(&args.scenario)?.tried()?, args, talk);
    }
    let file = args.scenario.clone();
    if !args.vary.is_empty() {
        return Err(CliError::VaryOfSurvey { file });
    }
    if !procedure.uses().survey_budget {
        let procedure = procedure.name();
        return Err(CliError::NeedsScenario { file, procedure });
    }
    let survey = procedures::read(&file)?;
    let settings = Settings {
        seed: Some(args.seed),
        ..Settings::default()
    };
    match survey.observed(&settings)? {
        Some(observed) => of(&*observed, args, talk),
        None => Err(CliError::NoScanner { file }),
    }
}

/// The budget of whatever can be tried.
fn of(tried: &dyn Tried, args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    refuse_keys(&args.vary)?;
    let wanted = goals(&frame(tried), &args.wanted).map_err(|found| CliError::Wanted { found })?;
    let folder = folder(args, tried.scenario());
    let trials_folder = folder.join(TRIALS);
    let joined = (!args.join.is_empty()).then(|| joined(tried, args, talk));
    let joined = joined.transpose()?;
    let experiment = match &joined {
        Some(_) => None,
        None => experiment(tried, args)?,
    };
    let files = ["result.json", "budget.csv", "report.html"];
    writable(&folder, if args.only_trials { &[] } else { &files })?;
    if let Some(joined) = &joined {
        talk.step(&format!("writing {}", trials_folder.display()));
        joined.write(&trials_folder)?;
    } else if let Some(experiment) = &experiment
        && let Ended::Interrupted { done, of } = trials(experiment, &trials_folder, args, talk)?
    {
        talk.remark(&format!(
            "interrupted: {done} of {of} trials are kept in {}; continue with the same command and --resume",
            trials_folder.display()
        ));
        return Ok(Ending::Interrupted);
    }
    let experiment = experiment.or(joined.map(|joined| joined.experiment));
    if args.only_trials {
        return parted(experiment.as_ref(), &trials_folder, talk);
    }
    let done = experiment.as_ref().map(|e| (e, trials_folder.as_path()));
    let mut result = budget(tried, done, &args.depth, &|step| talk.step(step))?;
    if experiment.is_none() && !args.vary.is_empty() {
        talk.step("propagating at every value");
        result.sweep = Some(propagated_sweep(tried, points(&args.vary))?);
    }
    result.wanted = wanted;
    result.command = match &experiment {
        Some(experiment) if !args.join.is_empty() => command(&as_one_run(args, experiment)),
        _ => command(args),
    };
    written(&result, &folder, talk)
}

/// Ends a run that makes a part only.
fn parted(
    experiment: Option<&Experiment<'_>>,
    folder: &Path,
    talk: &Talk,
) -> Result<Ending, CliError> {
    let (first_seed, trials) = experiment.map_or((0, 0), |e| (e.first_seed, e.trials()));
    let text = format!("Trials  {}\n", folder.display());
    let json = serde_json::json!({
        "trials": folder.display().to_string(), "first_seed": first_seed, "count": trials,
    });
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

/// The parts, checked; as many trials as the user says, if he does.
fn joined<'t>(tried: &'t dyn Tried, args: &Budget, talk: &Talk) -> Result<Joined<'t>, CliError> {
    talk.step(&format!("reading {} parts", args.join.len()));
    let joined = Joined::of(tried, &points(&args.vary), &args.join)?;
    let found = as_one_run(args, &joined.experiment);
    let counts = [
        ("--trials", args.trials, found.trials),
        ("--single", args.single, found.single),
    ];
    for (option, said, found) in counts {
        if said.is_some() && said != found {
            return Err(CliError::OtherCount {
                option,
                said: said.unwrap_or(0),
                found: found.unwrap_or(0),
                first_seed: joined.experiment.first_seed,
            });
        }
    }
    Ok(joined)
}

/// The arguments of the one run whose trials these are.
fn as_one_run(args: &Budget, experiment: &Experiment<'_>) -> Budget {
    let of = |role: fn(&Role) -> bool| {
        let cell = experiment.cells.iter().find(|cell| role(&cell.role));
        cell.map(|cell| cell.trials)
    };
    Budget {
        seed: experiment.first_seed,
        trials: of(|role| *role == Role::Together),
        single: of(|role| matches!(role, Role::Alone(_))),
        ..args.clone()
    }
}

/// More keys than a picture has axes, or one key twice.
pub(super) fn refuse_keys(vary: &[Vary]) -> Result<(), CliError> {
    if let [first, second] = vary
        && first.key == second.key
    {
        let key = first.key.clone();
        return Err(CliError::KeyTwice { key });
    }
    match vary.len() {
        0..=2 => Ok(()),
        found => Err(CliError::TooManyKeys { found }),
    }
}

/// The trials that were asked for, every scenario checked; without derivatives there are trials even where nobody asks.
fn experiment<'t>(tried: &'t dyn Tried, args: &Budget) -> Result<Option<Experiment<'t>>, CliError> {
    if !tried.has_truth() && args.trials.is_some() {
        let file = args.scenario.clone();
        return Err(CliError::NoTrials { file });
    }
    let by_default = !tried.has_derivatives();
    let Some(trials) = args.trials.or(by_default.then_some(DEFAULT_TRIALS)) else {
        return Ok(None);
    };
    let nothing_said = if args.trials.is_none() {
        DEFAULT_SINGLE
    } else {
        0
    };
    let single = args.single.unwrap_or(nothing_said);
    let experiment =
        Experiment::new(tried, args.seed, trials, single).with_sweep(points(&args.vary), trials)?;
    experiment
        .check()
        .map_err(|fault| CliError::Untriable { fault })?;
    Ok(Some(experiment))
}

/// The command that makes the result again, without its folder, threads and interruptions; the scenario by its name, so that another
/// place of the same file gives the same bytes.
fn command(args: &Budget) -> String {
    let mut words = vec![format!("boresight budget {}", name_of(&args.scenario))];
    words.extend(args.trials.map(|n| format!("--trials {n}")));
    words.extend(args.single.map(|n| format!("--single {n}")));
    if args.seed != 1 {
        words.push(format!("--seed {}", args.seed));
    }
    words.extend(args.vary.iter().map(|v| format!("--vary '{}'", v.text())));
    words.extend(wanted_words(&args.wanted));
    if args.depth != DEPTHS_M {
        let depths: Vec<String> = args.depth.iter().map(ToString::to_string).collect();
        words.push(format!("--depth {}", depths.join(",")));
    }
    words.join(" ")
}

fn folder(args: &Budget, name: &str) -> PathBuf {
    let default = || folder_of(&format!("{name}-budget"));
    args.out.clone().unwrap_or_else(default)
}

/// Runs what is missing, until it is done or Ctrl-C comes.
fn trials(
    experiment: &Experiment<'_>,
    folder: &Path,
    args: &Budget,
    talk: &Talk,
) -> Result<Ended, CliError> {
    let gentle = Gentle::begin();
    let done = experiment.prepare(folder, args.resume)?;
    let (before, total) = (done.iter().sum(), experiment.trials());
    talk.step(&format!(
        "{total} trials, {before} of them done before, into {}",
        folder.display()
    ));
    let bar = talk.trials(before, total);
    let ended = experiment.run(folder, &done, gentle.stop(), &|done| {
        bar.set_position(done);
        if done.is_multiple_of((total / 10).max(1)) {
            talk.step(&format!("{done} of {total} trials"));
        }
    });
    bar.finish_and_clear();
    Ok(ended?)
}

fn written(result: &BudgetResult, folder: &Path, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let files = report::write_budget(folder, result)?;
    let mut text = pages::summary(result);
    text.push_str(&format!(
        "\nReport  {}\nResult  {}\nTable   {}\n",
        files.page.display(),
        files.json.display(),
        files.table.display()
    ));
    if let Some(sweep) = &files.sweep {
        text.push_str(&format!("Sweep   {}\n", sweep.display()));
    }
    if result.trials > 0 {
        text.push_str(&format!("Trials  {}\n", folder.join(TRIALS).display()));
    }
    let json = pages::to_bytes(result)?;
    talk.result(&text, &json)?;
    let joint = result.paths.iter().find(|p| p.path == JOINT);
    let usable = joint.is_some_and(|p| match &p.together {
        Some(trials) => trials.usable > 0,
        None => p.predicted.is_some(),
    });
    Ok(if usable {
        Ending::Usable
    } else {
        Ending::Unusable
    })
}
