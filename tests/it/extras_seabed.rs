//! Unknowns of the caller's own in a seabed calibration: found where they are in the data, row by row of the file, with sigmas that hold;
//! what the model has anyway comes out of them as it does without; refused where nothing tells of them.

use std::path::Path;
use std::sync::Arc;

use boresight::calibrate::seam::{Finished, InputError, Settings};
use boresight::calibrate_with;
use boresight::observe::{Acts, Extra};
use boresight::procedures::seabed::joint::overlap;
use boresight::procedures::seabed::model::{Adjusted, Locator, Values};
use boresight::procedures::seabed::parameters::HEAVE_SCALE;
use boresight::procedures::seabed::scene::Scene;
use boresight::procedures::seabed::simulate::{self, simulate};
use boresight::procedures::seabed::states::States;
use boresight::procedures::seabed::survey::{load, parse_scenario, write};
use boresight::procedures::seabed::{Joint, JointError, JointSettings, joint};
use boresight::watch::Unwatched;
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::common::{change_column, extra, simulated};

const THIN: &str = include_str!("../../models/scenarios/seabed-thin.toml");
const DUAL: &str = include_str!("../../models/scenarios/seabed-dual.toml");

/// A simulated survey in memory: scene, settings, and the true turn of its mounting.
struct Survey {
    scene: Scene,
    config: JointSettings,
    rotation: nalgebra::Matrix3<f64>,
}

fn survey(seed: u64) -> Survey {
    let scenario = parse_scenario(Path::new("thin.toml"), THIN).expect("a scenario");
    let survey = simulate(&scenario, seed, simulate::Acts::ALL);
    let file = write::survey_file(&scenario, &survey);
    let scene = write::scene(&file, &scenario, &survey);
    Survey {
        scene,
        config: file.joint(1),
        rotation: survey.truth.rotations()[0],
    }
}

/// How many rows the file has: the simulator sounds on lines only.
fn rows(scene: &Scene) -> usize {
    scene.soundings.len()
}

/// One number of each row of the file, of its sounding.
fn column(scene: &Scene, of: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut all = vec![f64::NAN; rows(scene)];
    for (k, sounding) in scene.soundings.iter().enumerate() {
        all[sounding.row as usize] = of(k);
    }
    all
}

fn with(scene: &Scene, extras: Vec<Extra>) -> Scene {
    let extras: Arc<[Extra]> = extras.into();
    scene.with_extras(&extras, rows(scene)).expect("extras")
}

fn solved(scene: &Scene, config: &JointSettings) -> Joint {
    joint(scene, config).expect("a solution")
}

/// What is put in: ranges of the starboard side that are too short, metres; beams that turn outward with the time, radians; heights on
/// the second line that grow along it, metres.
const PUT_IN: [f64; 3] = [0.06, 0.004, 0.08];

fn unknowns(scene: &Scene) -> Vec<Extra> {
    let sounding = |k: usize| &scene.soundings[k];
    let part = |k: usize| {
        let line = &scene.lines[usize::from(sounding(k).line)];
        2.0 * (sounding(k).time_s - line.start_s) / (line.end_s - line.start_s) - 1.0
    };
    let starboard = |k: usize| match sounding(k).across_rad > 0.0 {
        true => 1.0,
        false => f64::NAN,
    };
    let outward = |k: usize| part(k) * sounding(k).across_rad.signum();
    let second = |k: usize| match sounding(k).line {
        1 => part(k),
        _ => 0.0,
    };
    vec![
        extra("starboard", Acts::Range, column(scene, starboard)),
        extra("widening", Acts::Across, column(scene, outward)),
        extra("squat", Acts::Up, column(scene, second)),
    ]
}

/// Takes the effects out of what was measured, so that the unknowns that put them back are [`PUT_IN`]. The water has 1500 m/s. What is
/// too high is brought down by the positions, which hold for a whole line.
fn spoilt(scene: &Scene) -> Scene {
    let own = unknowns(scene);
    let mut spoilt = scene.clone();
    for sounding in &mut spoilt.soundings {
        let by = |which: usize| own[which].at(sounding.row as usize).unwrap_or(0.0);
        sounding.one_way_s -= PUT_IN[0] * by(0) / 1500.0;
        sounding.across_rad -= PUT_IN[1] * by(1);
    }
    let second = &scene.lines[1];
    let record = &scene.trajectory;
    let lowered = record.times_s().iter().zip(record.positions_m());
    let lowered = lowered.map(|(t, p)| {
        let part = 2.0 * (t - second.start_s) / (second.end_s - second.start_s) - 1.0;
        let on = (second.start_s..=second.end_s).contains(t);
        p - Vector3::z() * if on { PUT_IN[2] * part } else { 0.0 }
    });
    let positions = lowered.collect();
    let attitudes = record.attitudes().to_vec();
    spoilt.trajectory = boresight::observe::Trajectory::new(
        record.times_s().to_vec(),
        positions,
        attitudes,
        None,
        f64::INFINITY,
    );
    spoilt
}

/// Six seeds: pulls of the three and of the angles, and what comes of the surveys without the unknowns.
#[test]
fn what_is_put_in_is_found_with_sigmas_that_hold() {
    let off = |found: &Joint, survey: &Survey| {
        let turn = found.values.mountings[0].rotation * survey.rotation.transpose();
        let turn = boresight::geometry::rotation::log(&turn);
        [0, 1, 2].map(|k| turn[k] / found.sigma(k))
    };
    let of = |seed: u64| {
        let mut survey = survey(seed);
        survey.scene = spoilt(&survey.scene);
        let without = solved(&survey.scene, &survey.config);
        let found = solved(
            &with(&survey.scene, unknowns(&survey.scene)),
            &survey.config,
        );
        assert!(found.converged);
        let first = found.parameters.len() - PUT_IN.len();
        let pull = |i: usize| (found.values.extras[i] - PUT_IN[i]) / found.sigma(first + i);
        let [pitch, roll, yaw] = off(&found, &survey);
        let found = [pull(0), pull(1), pull(2), pitch, roll, yaw];
        (found, off(&without, &survey), without.omega_over_freedom)
    };
    let all: Vec<_> = (1..=6u64).into_par_iter().map(of).collect();
    println!("{all:#?}");
    // chi-square on 6 lies beyond 22.5 once in a thousand
    for i in 0..6 {
        let square: f64 = all.iter().map(|(pulls, ..)| pulls[i].powi(2)).sum();
        assert!(square < 22.5, "pull {i}: {square} of 6");
    }
    for (_, without, _) in &all {
        assert!(without[1].abs() > 5.0, "{all:?}");
    }
}

/// The heave channel's scale as an own unknown: with the model's own one held, everything comes out as it does with that one.
#[test]
fn an_effect_that_the_model_has_comes_out_of_its_array_as_well() {
    let Survey { scene, config, .. } = survey(3);
    let due = solved(&scene, &config);
    let locator = Locator::new(&scene, &due.states, &due.values).expect("a profile");
    let heave = |k: usize| locator.locate(k).map_or(f64::NAN, |l| l.heave[0]);
    let mut own = extra("heave by hand", Acts::Up, column(&scene, heave));
    own.prior_sigma = Some(scene.priors.heave_scale);
    let mut held = with(&scene, vec![own]);
    held.priors.heave_scale = 0.0;
    let found = solved(&held, &config);
    let last = due.parameters.len();
    assert_eq!(found.parameters[last].name(), "heave by hand");
    assert!(!found.sought[HEAVE_SCALE] && found.sigma(HEAVE_SCALE) == 0.0);
    for k in 0..last {
        let place = if k == HEAVE_SCALE { last } else { k };
        let (off, sigma) = (found.off[place] - due.off[k], due.sigma(k));
        let ratio = found.sigma(place) / sigma;
        println!("{} {} {ratio}", due.parameters[k].name(), off / sigma);
        if due.sought[k] {
            assert!(off.abs() < 1e-3 * sigma, "{k}: {} sigmas", off / sigma);
            assert!((ratio - 1.0).abs() < 1e-3, "{k}: {ratio}");
        }
    }
    assert!(
        due.off[HEAVE_SCALE].abs() > 0.05 * due.sigma(HEAVE_SCALE),
        "nothing to find"
    );
}

/// One that nothing tells of is named: of soundings that are not used, or twice the same.
#[test]
fn one_that_nothing_tells_of_is_named() {
    let Survey { scene, config, .. } = survey(1);
    let fault = |extras: Vec<Extra>| {
        let error = joint(&with(&scene, extras), &config).expect_err("no solution");
        assert!(matches!(error, JointError::Extra { .. }), "{error}");
        error.to_string()
    };
    let screened = overlap(&scene, &config).expect("an overlap").alive;
    let unused = screened
        .iter()
        .position(|alive| !alive)
        .expect("gross errors");
    let only = |k: usize| if k == unused { 1.0 } else { f64::NAN };
    let words = fault(vec![extra("of one", Acts::Up, column(&scene, only))]);
    assert!(words.starts_with("extra of one: found an effect that no sounding tells of"));
    let side = |k: usize| scene.soundings[k].across_rad.signum();
    let side = column(&scene, side);
    let words = fault(vec![
        extra("a", Acts::Up, side.clone()),
        extra("b", Acts::Up, side),
    ]);
    assert!(
        words.starts_with("extra a: ") || words.starts_with("extra b: "),
        "{words}"
    );
}

fn calibrated(survey: &Path, extras: Vec<Extra>) -> Result<Finished, InputError> {
    let settings = Settings {
        extras: extras.into(),
        ..Settings::default()
    };
    calibrate_with(survey, &settings, &Unwatched)
}

/// A survey file whose heads stand mixed in the soundings' file: an effect on the rows of one head is found, and named in the result.
#[test]
fn derivatives_are_those_of_the_rows_of_the_file() {
    let folder = simulated(DUAL);
    let path = folder.path().join("survey/survey.toml");
    let csv = folder.path().join("survey/multibeam.csv");
    let text = std::fs::read_to_string(&csv).expect("a file");
    let mut lines = text.lines();
    let head = lines.next().expect("a header").split(',');
    let at = head.clone().position(|name| name == "head").expect("heads");
    let second: Vec<bool> = lines.map(|l| l.split(',').nth(at) == Some("2")).collect();
    let row = std::cell::Cell::new(0);
    const SHORT_M: f64 = 0.1;
    change_column(&csv, "two_way_travel_time_s", |_, time_s| {
        let k = row.replace(row.get() + 1);
        time_s
            - if second[k] {
                2.0 * SHORT_M / 1500.0
            } else {
                0.0
            }
    });
    assert_eq!(row.get(), second.len());
    let derivative: Vec<f64> = second.iter().map(|s| f64::from(u8::from(*s))).collect();
    let short = extra("short", Acts::Range, derivative.clone());
    let found = calibrated(&path, vec![short]).expect("a run").result;
    assert!(found.usable, "{:?}", found.reason);
    let joint = found.solutions.joint.as_ref().expect("joint");
    let named = joint.parameter("short").expect("named");
    let (value, sigma) = (named.value.expect("a value"), named.sigma.expect("a sigma"));
    println!("{value} {sigma}");
    assert!(
        (value - SHORT_M).abs() < 4.0 * sigma && sigma < 0.02,
        "{value} {sigma}"
    );
    assert_eq!((named.unit.as_str(), named.determined), ("m", true));
    assert_eq!(joint.covariance.as_ref().expect("a covariance").len(), 18);
    assert_eq!(joint.details["extra"][0], "short");
    let note = "the reference path knows no unknowns of your own: short";
    assert!(
        found.notes.iter().any(|n| n.starts_with(note)),
        "{:?}",
        found.notes
    );
    // without it, and with it on the other rows only by the order of the heads, the survey does not fit
    let without = calibrated(&path, vec![]).expect("a run").result;
    assert!(!without.usable);
    let refused = |extras| calibrated(&path, extras).expect_err("refused").to_string();
    let count = derivative.len();
    assert_eq!(
        refused(vec![extra("short", Acts::Range, vec![1.0; 3])]),
        format!("extra short: found 3 rows, expected {count} rows, one a sounding")
    );
    for name in ["head 2 roll", "latency", "range scale", "range_scale"] {
        let words = refused(vec![extra(name, Acts::Range, derivative.clone())]);
        assert!(words.contains("a name of its own"), "{words}");
    }
    let read = load(&path).expect("a survey");
    assert_eq!(read.read, count);
    assert!(read.scene.extras.is_empty());
}

/// The two-headed survey without noise, of one array a head or of two, with an unknown of each kind on every second row.
fn with_one_of_each(arrays: bool) -> Scene {
    let apart = "[multibeam]\narrays = { receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3, sector_tilt_deg = 1.5, sector_delay_s = 0.004 }";
    let further = "[[head]]\nreceiver_mounting_deg = { roll = -34.2, pitch = 0.1, heading = -0.6 }\nreceiver_offset_m = [0.0, 0.2, 0.0]";
    let text = match arrays {
        true => DUAL
            .replace("[multibeam]", apart)
            .replace("[[head]]", further),
        false => DUAL.to_owned(),
    };
    let scenario = parse_scenario(Path::new("dual.toml"), &text).expect("a scenario");
    let survey = simulate(&scenario, 3, simulate::Acts::NONE);
    let scene = write::scene(&write::survey_file(&scenario, &survey), &scenario, &survey);
    let every_second = |k: usize| match scene.soundings[k].row % 2 {
        0 => 1.5,
        _ => f64::NAN,
    };
    let all = [Acts::Up, Acts::Range, Acts::Across, Acts::Along];
    let own = |acts| extra(&format!("{acts:?}"), acts, column(&scene, every_second));
    with(&scene, all.map(own).to_vec())
}

/// Where the effects are at work: metres, metres, radians, radians.
const AT_WORK: [f64; 4] = [0.1, 0.2, 0.01, 0.02];

/// Each column against differences of the places, on the rows where the unknown acts and on those where it does not.
#[test]
fn columns_are_differences_where_the_unknown_acts() {
    for arrays in [false, true] {
        let scene = with_one_of_each(arrays);
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        let mut values = Values::nominal(&scene, &states);
        values.extras = AT_WORK.to_vec();
        let locator = Locator::new(&scene, &states, &values).expect("a profile");
        let (mut on, mut off) = (0, 0);
        for (place, extra) in scene.extras.iter().enumerate() {
            let by = 1e-5;
            let moved = |by: f64| {
                let mut moved = values.clone();
                moved.extras[place] += by;
                moved
            };
            let (more, less) = (moved(by), moved(-by));
            let there = Locator::new(&scene, &states, &more).expect("a profile");
            let back = Locator::new(&scene, &states, &less).expect("a profile");
            for k in (40..scene.soundings.len()).step_by(1009) {
                let places = (locator.locate(k), there.locate(k), back.locate(k));
                let (Some(located), Some(after), Some(before)) = places else {
                    continue;
                };
                let found = (after.point_m - before.point_m) / (2.0 * by);
                let row = scene.soundings[k].row;
                let due = located.own_column(extra, row, &Adjusted::default());
                let name = &extra.name;
                if row % 2 == 1 {
                    assert!(found == Vector3::zeros() && due == found, "{name} {found}");
                    off += 1;
                    continue;
                }
                let left = (found - due).norm();
                // the directions of two arrays are as good as their distance, 0.3 m, over the range
                let near = if arrays { 0.02 } else { 2e-3 };
                assert!(left < near * due.norm(), "{arrays} {name}: {found} {due}");
                on += 1;
            }
        }
        assert!(on > 40 && off > 40, "{on} {off}");
    }
}

/// A column at an adjusted observation is that of a sounding that was observed so: what is left is of second order.
#[test]
fn columns_stand_at_the_adjusted_observation() {
    let mut scene = with_one_of_each(false);
    let states = States::new(&scene.lines, &scene.ins, &scene.drift);
    let mut values = Values::nominal(&scene, &states);
    values.extras = AT_WORK.to_vec();
    let adjusted = Adjusted {
        range_m: 0.02,
        across_rad: 2e-3,
    };
    let numbers: Vec<usize> = (40..scene.soundings.len()).step_by(1009).collect();
    let columns = |scene: &Scene, adjusted: &Adjusted| -> Vec<[Vector3<f64>; 4]> {
        let locator = Locator::new(scene, &states, &values).expect("a profile");
        let of = |k: &usize| {
            let located = locator.locate(*k)?;
            let row = scene.soundings[*k].row;
            Some([0, 1, 2, 3].map(|i| located.own_column(&scene.extras[i], row, adjusted)))
        };
        numbers.iter().filter_map(of).collect()
    };
    let found = columns(&scene, &adjusted);
    let raw = columns(&scene, &Adjusted::default());
    for k in &numbers {
        let sounding = &mut scene.soundings[*k];
        sounding.across_rad += adjusted.across_rad;
        sounding.one_way_s += adjusted.range_m / 1500.0;
    }
    let due = columns(&scene, &Adjusted::default());
    assert!(found.len() > 20 && found.len() == due.len());
    let mut moved = [0.0; 4];
    for ((found, due), raw) in found.iter().zip(&due).zip(&raw) {
        for i in 0..4 {
            let (left, by) = ((found[i] - due[i]).norm(), (raw[i] - due[i]).norm());
            // an across angle turns the beam about the sonar's axis: the sine of the along angle, 0.03, is left out
            let near = if i == 2 { 0.04 } else { 0.01 };
            assert!(left < near * by + 1e-5, "{i}: {left} of {by}");
            moved[i] = f64::max(moved[i], by);
        }
    }
    // a height moves the point upwards whatever was observed; the others turn with the beam, by 2 mrad
    assert!(
        moved[0] == 0.0 && moved[1] > 1e-3 && moved[2] > 0.02,
        "{moved:?}"
    );
}
