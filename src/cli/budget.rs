//! `boresight budget`: a scenario to an error budget, by propagation and by Monte Carlo.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use super::Ending;
use super::args::Budget;
use super::calibrate::folder_of;
use super::error::CliError;
use super::named_budget;
use super::talk::Talk;
use crate::budget::analytic::{
    Analytic, AnalyticError, analytic_with, of_survey as of_survey_with,
};
use crate::budget::experiment::{Ended, Experiment};
use crate::budget::trial::Configuration;
use crate::budget::{predicted, soundings, summary, sweep};
use crate::calibrate::seam::Settings;
use crate::procedures;
use crate::procedures::pool::procedure::input;
use crate::procedures::pool::survey::claims::claims;
use crate::procedures::pool::survey::{self as survey, scenario};
use crate::report::{self, budget as pages};
use crate::results::{BudgetPath, BudgetResult};
use crate::simulate::{Scenario, SimulateError};
use crate::target::Target;

/// Subfolder of the ledgers.
const TRIALS: &str = "trials";

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Runs the command.
pub fn run(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.scenario.display()));
    let procedure = procedures::of_file(&args.scenario)?;
    if std::fs::read_to_string(&args.scenario).is_ok_and(|text| crate::survey::is_survey(&text)) {
        return if procedure.uses().survey_budget {
            of_survey(args, talk)
        } else {
            let (file, procedure) = (args.scenario.clone(), procedure.name());
            Err(CliError::NeedsScenario { file, procedure })
        };
    }
    match procedures::scenario(&args.scenario)?.tried()? {
        Some(tried) => named_budget::run(&*tried, args, talk),
        None => of_scenario(args, talk),
    }
}

/// The budget of a scenario whose sources can be propagated as well as tried.
fn of_scenario(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    let file = scenario::read(&args.scenario)?;
    let calibration = file.calibration(&args.scenario)?;
    let configuration = Configuration {
        sequential: calibration.sequential,
        joint: calibration.joint,
        ..Configuration::default()
    };
    let experiment = experiment(args, &file.scenario, &configuration)?;
    let folder = folder(args, &file.scenario.name);
    let mut result = summary::frame(&file.scenario, &configuration);
    if let Some(experiment) = &experiment {
        let trials_folder = folder.join(TRIALS);
        if let Ended::Interrupted { done, of } = trials(experiment, &trials_folder, args, talk)? {
            talk.remark(&format!(
                "stopped: {done} of {of} trials are kept in {}; the same command with --resume goes on",
                trials_folder.display()
            ));
            return Ok(Ending::Interrupted);
        }
        talk.step("summing up");
        summary::fill(&mut result, experiment, &trials_folder)?;
    }
    let analytic = propagated(&mut result, &file.scenario, &configuration, talk)?;
    let found = match &experiment {
        Some(experiment) => soundings::of_trials(experiment, &folder.join(TRIALS))?,
        None => vec![],
    };
    let found = match &analytic {
        Some(analytic) => soundings::or_propagated(found, analytic),
        None => found,
    };
    let found = soundings::or_predicted(found, &file.scenario, &configuration.joint);
    result.swath = Some(soundings::section(&file.scenario, &found, &args.depth));
    result.command = command(args);
    written(&result, &folder, talk)
}

/// The budget of a survey as it was observed: by propagation only, as nobody knows its truth.
fn of_survey(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    if args.trials.is_some() {
        let file = args.scenario.clone();
        return Err(CliError::NoTrials { file });
    }
    let survey = survey::load(&args.scenario)?;
    let Some(claims) = claims(&survey) else {
        let file = args.scenario.clone();
        return Err(CliError::NoScanner { file });
    };
    let configuration = Configuration {
        sequential: survey.file.sequential.clone(),
        joint: survey.file.joint.clone(),
        ..Configuration::default()
    };
    let mut result = summary::frame(&claims, &configuration);
    result.notes = survey.notes.clone();
    result.notes.push(SURVEY_NOTE.to_owned());
    talk.step("calibrating, and propagating every source through both paths");
    let settings = Settings {
        seed: Some(args.seed),
        ..Settings::default()
    };
    let found = match of_survey_with(&claims, &input(&survey, &settings)) {
        Ok(analytic) => {
            predicted::add(&mut result, &claims, &analytic);
            soundings::or_propagated(vec![], &analytic)
        }
        Err(error) => {
            result.notes.push(format!("no analytic budget: {error}"));
            vec![]
        }
    };
    result.swath = Some(soundings::section(&claims, &found, &args.depth));
    result.command = command(args);
    written(&result, &folder(args, &claims.name), talk)
}

/// What a reader of a survey's budget should know.
const SURVEY_NOTE: &str = "a survey's own budget: its observations, and the sigmas that its file claims; errors of which it says \
    nothing (latency, sound speed, gross errors) are not in it, and no truth is known, so there is no bias";

/// Adds the analytic budget, or why there is none.
fn propagated(
    result: &mut BudgetResult,
    scenario: &Scenario,
    configuration: &Configuration,
    talk: &Talk,
) -> Result<Option<Analytic>, CliError> {
    talk.step("propagating every source through both paths");
    match analytic_with(scenario, &configuration.sequential, &configuration.joint) {
        Ok(analytic) => {
            predicted::add(result, scenario, &analytic);
            return Ok(Some(analytic));
        }
        Err(AnalyticError::Simulate(error)) => return Err(error.into()),
        Err(error) => result.notes.push(format!("no analytic budget: {error}")),
    }
    Ok(None)
}

/// The trials that were asked for, every scenario checked.
fn experiment(
    args: &Budget,
    scenario: &Scenario,
    configuration: &Configuration,
) -> Result<Option<Experiment>, CliError> {
    let Some(trials) = args.trials else {
        return Ok(None);
    };
    if args.vary.len() > 2 {
        let found = args.vary.len();
        return Err(CliError::TooManyKeys { found });
    }
    let single = args.single.unwrap_or(0);
    let points = sweep::points(scenario, &args.vary)?;
    let experiment = Experiment::new(scenario, configuration.clone(), args.seed, trials, single)
        .with_sweep(points, trials);
    for cell in &experiment.cells {
        Target::from_model(&cell.scenario.target.model).map_err(SimulateError::from)?;
    }
    Ok(Some(experiment))
}

/// The command that makes the result again, without its folder, threads and interruptions.
fn command(args: &Budget) -> String {
    let mut words = vec![format!("boresight budget {}", args.scenario.display())];
    words.extend(args.trials.map(|n| format!("--trials {n}")));
    words.extend(args.single.map(|n| format!("--single {n}")));
    if args.seed != 1 {
        words.push(format!("--seed {}", args.seed));
    }
    words.extend(args.vary.iter().map(|v| format!("--vary '{}'", v.text())));
    if args.depth != soundings::DEPTHS_M {
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
    experiment: &Experiment,
    folder: &Path,
    args: &Budget,
    talk: &Talk,
) -> Result<Ended, CliError> {
    let stop = catch_ctrl_c()?;
    let done = experiment.prepare(folder, args.resume)?;
    let (before, total) = (done.iter().sum(), experiment.trials());
    talk.step(&format!(
        "{total} trials, {before} of them done before, into {}",
        folder.display()
    ));
    let bar = talk.trials(before, total);
    let ended = experiment.run(folder, &done, stop, &|done| {
        bar.set_position(done);
        if done.is_multiple_of((total / 10).max(1)) {
            talk.step(&format!("{done} of {total} trials"));
        }
    });
    bar.finish_and_clear();
    Ok(ended?)
}

/// The first Ctrl-C sets the flag and asks the run to stop, the second ends the program.
pub(super) fn catch_ctrl_c() -> Result<&'static AtomicBool, CliError> {
    STOP.store(false, SeqCst);
    let caught = ctrlc::set_handler(|| {
        if STOP.swap(true, SeqCst) {
            std::process::exit(130);
        }
    });
    match caught {
        // caught already: this is not the process's first budget
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(&STOP),
        Err(error) => Err(CliError::Signal {
            found: error.to_string(),
        }),
    }
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
    let joint = result.paths.iter().find(|p| p.path == BudgetPath::Joint);
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
