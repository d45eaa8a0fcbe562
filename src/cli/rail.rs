//! The commands for a rail calibration.

use std::fmt::Write;
use std::path::Path;

use comfy_table::CellAlignment;
use serde_json::json;

use super::Ending;
use super::args::{Budget, Calibrate, Check, Demo, Simulate};
use super::calibrate::{folder_of, place, provenance};
use super::error::CliError;
use super::named_budget;
use super::talk::Talk;
use crate::budget::named::rail::RailTrials;
use crate::calibrate::choices::Method;
use crate::observe::Mounting;
use crate::procedures::rail::simulate::truth::ProfilerTruth;
use crate::procedures::rail::simulate::{DEMO, RailTruth, SimulatedRail, simulate as simulated};
use crate::procedures::rail::survey::scenario::parse_scenario;
use crate::procedures::rail::survey::{
    LoadedRail, RailScenarioFile, load, read_scenario, write_rail,
};
use crate::procedures::rail::{self, RailInput, RailScene, summary, verdict};
use crate::report;
use crate::report::text::ruled_table;
use crate::results::{RailResult, RailSamples};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// `boresight calibrate`.
pub fn calibrate(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = load(&args.survey)?;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| folder_of(&survey.file.name));
    let (result, samples) = calibrated(&survey, args.method.into(), args.seed, None, talk)?;
    let place = write(&folder, &result, &samples, talk)?;
    let text = format!("{}\n{place}", report::rail::summary(&result));
    talk.result(&text, &report::rail::to_bytes(&result)?)?;
    Ok(ending(&result))
}

/// `boresight budget`.
pub fn budget(args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    named_budget::needs_scenario(&args.scenario, "rail")?;
    talk.step(&format!("reading {}", args.scenario.display()));
    let file = read_scenario(&args.scenario)?;
    let (reference, joint) = file.calibration(&args.scenario)?;
    let trials = RailTrials {
        scenario: file.scenario,
        rail: file.rail,
        reference,
        joint,
    };
    named_budget::run(&trials, args, talk)
}

fn ending(result: &RailResult) -> Ending {
    if result.usable {
        Ending::Usable
    } else {
        Ending::Unusable
    }
}

fn input(survey: &LoadedRail, method: Method) -> RailInput<'_> {
    RailInput {
        campaign: &survey.campaign,
        rail: &survey.rail,
        method,
        reference: &survey.file.reference,
        joint: &survey.file.joint,
    }
}

fn calibrated(
    survey: &LoadedRail,
    method: Method,
    seed: u64,
    truth: Option<&RailTruth>,
    talk: &Talk,
) -> Result<(RailResult, RailSamples), CliError> {
    talk.step("calibrating");
    let input = input(survey, method);
    let outcome = rail::calibrate(&input);
    talk.step("comparing and drawing");
    let result = summary::result(
        &outcome,
        &input,
        provenance(&survey.file, &survey.inputs, method, seed)?,
    );
    let truth: Option<Vec<Mounting>> =
        truth.map(|t| t.profilers.iter().map(ProfilerTruth::mounting).collect());
    let samples = summary::samples(&outcome, &survey.file.name, truth.as_deref());
    Ok((result, samples))
}

fn write(
    folder: &Path,
    result: &RailResult,
    samples: &RailSamples,
    talk: &Talk,
) -> Result<String, CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let written = report::write_rail(folder, result, samples)?;
    Ok(place(&written))
}

/// `boresight simulate`.
pub fn simulate(args: &Simulate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.scenario.display()));
    let file = read_scenario(&args.scenario)?;
    let seed = args.seed.unwrap_or(file.scenario.seed);
    let survey = written(&file, seed, &args.out, talk)?;
    let (points, positions) = (survey.campaign.points.len(), survey.campaign.table.len());
    let (place, truth) = (args.out.join(SURVEY_FILE), args.out.join(TRUTH_FILE));
    let json = json!({
        "scenario": file.scenario.name,
        "seed": seed,
        "survey": place,
        "truth": truth,
        "points": points,
        "positions": positions,
    });
    let text = format!(
        "Simulated {} with seed {seed}: {points} points at {positions} positions.\nSurvey  {}\nTruth   {}\n",
        file.scenario.name,
        place.display(),
        truth.display()
    );
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

fn written(
    file: &RailScenarioFile,
    seed: u64,
    folder: &Path,
    talk: &Talk,
) -> Result<SimulatedRail, CliError> {
    talk.step(&format!(
        "simulating {} with seed {seed}",
        file.scenario.name
    ));
    let survey = simulated(&file.scenario, &file.rail, seed)?;
    talk.step(&format!("writing {}", folder.display()));
    std::fs::create_dir_all(folder).map_err(|e| CliError::Folder {
        folder: folder.to_owned(),
        found: e.to_string(),
    })?;
    write_rail(folder, file, &survey)?;
    Ok(survey)
}

/// `boresight demo rail`.
pub fn demo(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let folder = args.out.join("survey");
    let name = Path::new("rail.toml");
    let file = parse_scenario(name, DEMO, Path::new(""))?;
    let simulated = written(&file, args.seed, &folder, talk)?;
    talk.step("reading the survey");
    let survey = load(&folder.join(SURVEY_FILE))?;
    let (result, samples) = calibrated(
        &survey,
        Method::Both,
        args.seed,
        Some(&simulated.truth),
        talk,
    )?;
    let place = write(&args.out, &result, &samples, talk)?;
    let text = format!(
        "{}\n{}\nSurvey  {}\n{place}",
        report::rail::summary(&result),
        against(&result, &samples),
        folder.join(SURVEY_FILE).display()
    );
    talk.result(&text, &report::rail::to_bytes(&result)?)?;
    Ok(ending(&result))
}

/// Each path's errors against the truth.
fn against(result: &RailResult, samples: &RailSamples) -> String {
    let (Some(truth), Some(joint)) = (&samples.truth, &result.solutions.joint) else {
        return String::new();
    };
    let mut table = ruled_table();
    table.set_header([
        "error against the truth",
        "patent's path",
        "joint",
        "joint, in sigmas",
    ]);
    for (k, p) in joint.parameters.iter().enumerate() {
        let (scale, unit) = if p.unit == "m" {
            (1e3, "mm")
        } else {
            (1.0, p.unit.as_str())
        };
        let error = |errors: &[f64]| errors.get(k).map(|e| e * scale);
        let shown = |e: Option<f64>| e.map_or(String::new(), |e| format!("{e:+.4}"));
        let (before, now) = (error(&truth.reference_errors), error(&truth.joint_errors));
        let sigmas = now
            .zip(p.standard_deviation)
            .map(|(e, s)| format!("{:+.1}", e / (s * scale)));
        table.add_row([
            format!("{}, {unit}", p.name),
            shown(before),
            shown(now),
            sigmas.unwrap_or_default(),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n", table.trim_fmt())
}

/// `boresight check`.
pub fn check(args: &Check, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = load(&args.survey)?;
    talk.step("looking at the geometry");
    let scene = RailScene::new(&survey.campaign, &survey.rail);
    let preview = verdict::preview(&scene, &survey.file.joint, &survey.file.reference);
    let mut text = format!(
        "Survey \"{}\" is readable and consistent.\n\n",
        survey.file.name
    );
    let _ = writeln!(
        text,
        "{} points, {} attitude records, {} positions of the table; {} points while it turned",
        survey.campaign.points.len(),
        survey.campaign.attitude.time_s.len(),
        scene.positions.len(),
        scene.turning
    );
    let (heading, pitch) = scene.turned_rad();
    let _ = writeln!(
        text,
        "table turned by {:.2} deg about the vertical, {:.2} deg about the lateral axis\n",
        heading.to_degrees(),
        pitch.to_degrees()
    );
    let _ = writeln!(text, "{}\n", seen(&preview, &survey));
    for words in &preview.words {
        let _ = writeln!(text, "{words}");
    }
    let json = json!({
        "survey": survey.file.name,
        "points": survey.campaign.points.len(),
        "positions": scene.positions.len(),
        "turned_deg": [heading.to_degrees(), pitch.to_degrees()],
        "expected_sigma": preview.expected,
        "undetermined": preview.words,
    });
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(if preview.words.is_empty() {
        Ending::Usable
    } else {
        Ending::Unusable
    })
}

/// Points near the rail and expected standard deviations, profiler by profiler.
fn seen(preview: &verdict::Preview, survey: &LoadedRail) -> String {
    let mut table = ruled_table();
    table.set_header([
        "profiler",
        "points",
        "on the rail",
        "pitch, deg",
        "roll, deg",
        "yaw, deg",
        "lx, mm",
        "lz, mm",
    ]);
    for (k, profiler) in survey.file.profiler.iter().enumerate() {
        let points = survey
            .campaign
            .points
            .profiler
            .iter()
            .filter(|p| **p as usize == k)
            .count();
        let mut row = vec![
            profiler.name.clone(),
            points.to_string(),
            preview.near[k].to_string(),
        ];
        row.extend(
            preview
                .expected
                .iter()
                .skip(5 * k)
                .take(5)
                .map(|s| s.map_or_else(|| "-".to_owned(), |s| format!("{s:.4}"))),
        );
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}
