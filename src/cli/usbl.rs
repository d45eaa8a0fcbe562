//! The commands for a USBL calibration.

use std::fmt::Write;
use std::path::Path;

use serde_json::json;

use super::Ending;
use super::args::{Budget, Calibrate, Check, Demo, Simulate};
use super::calibrate::{Finished, folder_of, notes, provenance};
use super::error::CliError;
use super::named_budget;
use super::talk::Talk;
use crate::budget::named::usbl::UsblTrials;
use crate::calibrate::choices::Method;
use crate::observe::usbl::Role;
use crate::procedures::usbl::simulate::{DEMO, Simulated, Truth, simulate as simulated};
use crate::procedures::usbl::survey::{LoadedUsbl, UsblScenarioFile, load, scenario, write_survey};
use crate::procedures::usbl::{self, Layout, Scene, UsblInput, summary};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// `boresight calibrate`.
pub fn calibrate(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = load(&args.survey)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| folder_of(&survey.file.name));
    calibrated(&survey, args.method.into(), args.seed, None, talk)?.told(&folder, talk)
}

fn calibrated(
    survey: &LoadedUsbl,
    method: Method,
    seed: u64,
    truth: Option<&Truth>,
    talk: &Talk,
) -> Result<Finished, CliError> {
    let input = UsblInput {
        campaign: &survey.campaign,
        method,
        reference: survey.file.reference,
        joint: survey.file.joint,
    };
    talk.step("calibrating");
    let outcome = usbl::calibrate(&input)?;
    talk.step("comparing and drawing");
    let read = (survey.fixes_read, survey.fixes_dropped);
    let provenance = provenance(&survey.file, &survey.inputs, method, seed)?;
    let result = summary::result(&outcome, &input, read, &survey.notes, provenance)?;
    let page = summary::page(&outcome, &result, &survey.file.name, truth)?;
    Ok(Finished { result, page })
}

/// `boresight simulate`.
pub fn simulate(args: &Simulate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.scenario.display()));
    let file = scenario::read(&args.scenario)?;
    let seed = args.seed.unwrap_or(file.scenario.seed);
    let survey = written(&args.scenario, &file, seed, &args.out, talk)?;
    let (beacons, fixes) = (survey.campaign.beacons.len(), survey.campaign.fixes.len());
    let json = json!({
        "scenario": file.scenario.name,
        "seed": seed,
        "survey": args.out.join(SURVEY_FILE),
        "truth": args.out.join(TRUTH_FILE),
        "beacons": beacons,
        "fixes": fixes,
        "attitude_records": survey.attitude_rad.len(),
    });
    let text = format!(
        "Simulated {} with seed {seed}: {beacons} beacons, {fixes} fixes, {} attitude records.\nSurvey  {}\nTruth   {}\n",
        file.scenario.name,
        survey.attitude_rad.len(),
        args.out.join(SURVEY_FILE).display(),
        args.out.join(TRUTH_FILE).display(),
    );
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

fn written(
    name: &Path,
    file: &UsblScenarioFile,
    seed: u64,
    folder: &Path,
    talk: &Talk,
) -> Result<Simulated, CliError> {
    let calibration = file.calibration(name)?;
    talk.step(&format!(
        "simulating {} with seed {seed}",
        file.scenario.name
    ));
    let survey = simulated(&file.scenario, seed)?;
    talk.step(&format!("writing {}", folder.display()));
    std::fs::create_dir_all(folder).map_err(|e| CliError::Folder {
        folder: folder.to_owned(),
        found: e.to_string(),
    })?;
    write_survey(folder, file, &calibration, &survey)?;
    Ok(survey)
}

/// `boresight budget`.
pub fn budget(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    named_budget::needs_scenario(&args.scenario, "usbl")?;
    talk.step(&format!("reading {}", args.scenario.display()));
    let file = scenario::read(&args.scenario)?;
    let calibration = file.calibration(&args.scenario)?;
    let trials = UsblTrials {
        scenario: file.scenario,
        reference: calibration.reference,
        joint: calibration.joint,
    };
    named_budget::run(&trials, args, talk)
}

/// `boresight demo usbl`: simulate, write the survey, read it again, calibrate, report, compare with the truth.
pub fn demo(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let folder = args.out.join("survey");
    let name = Path::new("usbl.toml");
    let file = scenario::from_text(name, DEMO)?;
    let survey = written(name, &file, args.seed, &folder, talk)?;
    talk.step("reading the survey");
    let loaded = load(&folder.join(SURVEY_FILE))?;
    let truth = Some(&survey.truth);
    let finished = calibrated(&loaded, Method::Both, args.seed, truth, talk)?;
    finished.told_of(Some(&folder.join(SURVEY_FILE)), &args.out, talk)
}

/// `boresight check`: what was read, and what the layout can and cannot determine; nothing is solved.
pub fn check(args: &Check, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = load(&args.survey)?;
    let scene = Scene::new(&survey.campaign)?;
    let layout = Layout::of(&scene);
    let words = layout.in_words();
    let determined = layout.beacons > 1 && layout.sight_rad > SIGHT_RAD;
    let mut text = read_in_words(&survey, scene.common.len());
    let verdict = if determined {
        "Pitch, roll and yaw of the mounting can be determined."
    } else {
        "The mounting cannot be determined."
    };
    let _ = writeln!(text, "{verdict}");
    if !words.is_empty() {
        let _ = writeln!(text, "Layout: {words}.");
    }
    text.push_str(notes(&survey.notes).trim_start());
    let json = json!({
        "survey": survey.file.name,
        "procedure": "usbl",
        "fixes": { "read": survey.fixes_read, "common": scene.common.len(), "dropped": survey.fixes_dropped },
        "attitude_records": survey.campaign.attitude.len(),
        "beacons": beacons(&survey),
        "mounting_determined": determined,
        "layout": words,
        "notes": survey.notes,
    });
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

/// Lines of sight that span less than this determine no rotation about them, radians.
const SIGHT_RAD: f64 = 1e-3;

/// Name, role, place and number of fixes of every beacon.
fn beacons(survey: &LoadedUsbl) -> Vec<serde_json::Value> {
    let campaign = &survey.campaign;
    let numbered = campaign.beacons.iter().enumerate();
    numbered
        .map(|(k, beacon)| {
            let place: [f64; 3] = beacon.point.position_m.into();
            json!({
                "name": beacon.point.name,
                "role": role(beacon.role),
                "position_m": place,
                "fixes": campaign.fixes.of_beacon(k as u32),
            })
        })
        .collect()
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Common => "common",
        Role::Check => "check",
    }
}

fn read_in_words(survey: &LoadedUsbl, common: usize) -> String {
    let campaign = &survey.campaign;
    let mut text = format!(
        "{}: USBL survey, {} fixes read, {common} of common beacons, {} dropped; {} attitude records\n",
        survey.file.name,
        survey.fixes_read,
        survey.fixes_dropped,
        campaign.attitude.len()
    );
    for (k, beacon) in campaign.beacons.iter().enumerate() {
        let [east, north, up]: [f64; 3] = beacon.point.position_m.into();
        let _ = writeln!(
            text,
            "  {} ({}): {east:.3} east, {north:.3} north, {up:.3} up of the transducer, {} fixes",
            beacon.point.name,
            role(beacon.role),
            campaign.fixes.of_beacon(k as u32)
        );
    }
    text
}
