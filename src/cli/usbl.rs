//! The commands for a USBL calibration.

use std::fmt::Write;
use std::path::Path;

use comfy_table::CellAlignment;
use nalgebra::{Matrix3, Vector3};
use serde_json::json;

use super::Ending;
use super::args::{Budget, Calibrate, Check, Demo, Simulate};
use super::calibrate::{folder_of, notes, place, provenance};
use super::error::CliError;
use super::named_budget;
use super::talk::Talk;
use crate::budget::named::usbl::UsblTrials;
use crate::calibrate::choices::Method;
use crate::geometry::rotation;
use crate::observe::usbl::Role;
use crate::procedures::usbl::simulate::{DEMO, Simulated, Truth, simulate as simulated};
use crate::procedures::usbl::survey::{LoadedUsbl, UsblScenarioFile, load, scenario, write_survey};
use crate::procedures::usbl::{self, Layout, Scene, UsblInput, summary};
use crate::report;
use crate::report::text::ruled_table;
use crate::results::{Angles, UsblResult, UsblSamples, UsblTruth};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// `boresight calibrate`.
pub fn calibrate(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = load(&args.survey)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| folder_of(&survey.file.name));
    let finished = calibrated(&survey, args.method.into(), args.seed, None, talk)?;
    let place = write(&folder, &finished, talk)?;
    let text = format!(
        "{}{}\n{place}",
        report::usbl::summary(&finished.result),
        notes(&finished.result.notes)
    );
    talk.result(&text, &report::usbl::to_bytes(&finished.result)?)?;
    Ok(finished.ending())
}

/// A calibration that came to its end, with or without a usable result.
struct Finished {
    result: UsblResult,
    samples: UsblSamples,
}

impl Finished {
    fn ending(&self) -> Ending {
        if self.result.usable {
            Ending::Usable
        } else {
            Ending::Unusable
        }
    }
}

fn calibrated(
    survey: &LoadedUsbl,
    method: Method,
    seed: u64,
    truth: Option<UsblTruth>,
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
    Ok(Finished {
        result: summary::result(&outcome, &input, read, &survey.notes, provenance),
        samples: summary::samples(&outcome, &survey.file.name, truth),
    })
}

fn write(folder: &Path, finished: &Finished, talk: &Talk) -> Result<String, CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let written = report::write_usbl(folder, &finished.result, &finished.samples)?;
    Ok(place(&written))
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
    let truth = for_report(&survey.truth);
    let finished = calibrated(&loaded, Method::Both, args.seed, Some(truth), talk)?;
    let place = write(&args.out, &finished, talk)?;
    let text = format!(
        "{}{}\n{}\nSurvey  {}\n{place}",
        report::usbl::summary(&finished.result),
        notes(&finished.result.notes),
        against(&finished.result, &survey.truth),
        folder.join(SURVEY_FILE).display(),
    );
    talk.result(&text, &report::usbl::to_bytes(&finished.result)?)?;
    Ok(finished.ending())
}

fn for_report(truth: &Truth) -> UsblTruth {
    let c = truth.correction_deg;
    UsblTruth {
        rotation_matrix: truth.rotation_matrix,
        correction_deg: Angles {
            pitch: c.pitch,
            roll: c.roll,
            yaw: c.yaw,
        },
        transducer_m: truth.transducer_m,
        range_scale: truth.range_scale,
    }
}

/// One line of [`against`]: name, errors of both paths, sigma of the joint one.
type Row = (String, Option<f64>, Option<f64>, Option<f64>);

/// A table of each path's errors, the joint one's also in its own standard deviations.
fn against(result: &UsblResult, truth: &Truth) -> String {
    let mut table = ruled_table();
    table.set_header([
        "error against the truth",
        "reference",
        "joint",
        "joint, in sigmas",
    ]);
    for (name, old, new, sigma) in errors(result, truth) {
        let number = |v: Option<f64>| v.map_or_else(String::new, |v| format!("{v:+.4}"));
        let sigmas = new.zip(sigma);
        let sigmas = sigmas.map_or_else(String::new, |(e, s)| format!("{:+.1}", e / s));
        table.add_row([name, number(old), number(new), sigmas]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n", table.trim_fmt())
}

fn errors(result: &UsblResult, truth: &Truth) -> Vec<Row> {
    let turn = |rows: Option<[[f64; 3]; 3]>| -> Option<Vector3<f64>> {
        let found = Matrix3::from_row_iterator(rows?.into_iter().flatten());
        Some(rotation::log(&(found * truth.rotation().transpose())).map(f64::to_degrees))
    };
    let solutions = &result.solutions;
    let reference = solutions
        .reference
        .as_ref()
        .and_then(|r| turn(r.rotation_matrix));
    let joint = solutions.joint.as_ref().filter(|j| j.usable);
    let found = joint.and_then(|j| turn(j.rotation_matrix));
    let sigma = |i: usize| joint.and_then(|j| j.parameters.get(i)?.standard_deviation);
    let mut rows: Vec<Row> = vec![];
    for (i, name) in ["pitch, deg", "roll, deg", "yaw, deg"]
        .into_iter()
        .enumerate()
    {
        rows.push((
            name.to_owned(),
            reference.map(|t| t[i]),
            found.map(|t| t[i]),
            sigma(i),
        ));
    }
    for (i, axis) in ["east", "north", "up"].into_iter().enumerate() {
        let place = joint.and_then(|j| j.transducer_m);
        let error = place.map(|p| 1e3 * (p[i] - truth.transducer_m[i]));
        let sigma = sigma(3 + i).map(|s| 1e3 * s);
        rows.push((format!("transducer {axis}, mm"), None, error, sigma));
    }
    let scale = joint.and_then(|j| j.range_scale);
    let error = scale.map(|s| 1e6 * (s - truth.range_scale));
    let sigma = sigma(6).map(|s| 1e6 * s);
    rows.push(("range scale, 1e-6".to_owned(), None, error, sigma));
    rows
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
