//! Every scenario, target and sensor of `models/` is read, simulated and written.

use std::path::{Path, PathBuf};

use boresight::formats::Invalid;
use boresight::procedures;
use boresight::procedures::pool::survey::{load, scenario, write_survey};
use boresight::procedures::seabed::simulate::{Acts, Shot};
use boresight::procedures::seabed::survey::parse_scenario;
use boresight::procedures::{rail::survey as rail, usbl::survey as usbl};
use boresight::simulate::{self, Sources, simulate};
use boresight::target::{Target, TargetModel};

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(folder);
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut files: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    files.sort();
    files
}

/// Scenarios of one procedure.
fn scenarios(procedure: &str) -> Vec<PathBuf> {
    let mut files = files("scenarios");
    let named = |path: &PathBuf| procedures::of_file(path).unwrap_or_else(|e| panic!("{e}"));
    files.retain(|path| named(path).name() == procedure);
    files
}

#[test]
fn every_scenario_has_observations_of_both_sensors() {
    let files = scenarios("pool");
    assert!(files.len() >= 10);
    for path in files {
        let file = scenario::read(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            Some(file.scenario.name.as_str()),
            path.file_stem().and_then(|s| s.to_str())
        );
        let mut thin = file.scenario;
        thin.multibeam.beams = 20;
        thin.lidar.points_per_line = 40;
        let survey = simulate(&thin, 1).expect("a survey");
        assert!(survey.campaign.soundings.len() > 1000, "{}", path.display());
        assert!(survey.campaign.laser.len() > 300, "{}", path.display());
    }
}

#[test]
fn every_seabed_scenario_has_soundings_on_every_line() {
    let files = scenarios("seabed");
    assert!(files.len() >= 3);
    for path in files {
        let text = std::fs::read_to_string(&path).expect("a file");
        let mut thin = parse_scenario(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            Some(thin.name.as_str()),
            path.file_stem().and_then(|s| s.to_str())
        );
        thin.multibeam.ping_rate_hz = 0.5;
        let survey = procedures::seabed::simulate::simulate(&thin, 1, Acts::ALL);
        for line in &survey.lines {
            let on = |shot: &&Shot| (line.start_s..=line.end_s).contains(&shot.time_s);
            let count = survey.shots.iter().filter(on).count();
            assert!(
                count > 500,
                "{}: {} on {}",
                path.display(),
                count,
                line.name
            );
        }
    }
}

#[test]
fn every_usbl_scenario_has_fixes_of_every_beacon() {
    let files = scenarios("usbl");
    assert!(files.len() >= 2);
    for path in files {
        let file = usbl::scenario::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let survey = procedures::usbl::simulate::simulate(&file.scenario, 1).expect("a survey");
        let campaign = &survey.campaign;
        let expected = campaign.beacons.len() * file.scenario.fixes.per_beacon as usize;
        assert_eq!(campaign.fixes.beacon.len(), expected, "{}", path.display());
    }
}

#[test]
fn every_rail_scenario_has_points_of_every_profiler() {
    let files = scenarios("rail");
    assert!(files.len() >= 2);
    for path in files {
        let file = rail::read_scenario(&path).unwrap_or_else(|e| panic!("{e}"));
        let survey =
            procedures::rail::simulate::simulate(&file.scenario, &file.rail, 1).expect("a survey");
        let campaign = &survey.campaign;
        for profiler in 0..campaign.profilers.len() {
            let mine = campaign.points.profiler.iter();
            let count = mine.filter(|p| **p as usize == profiler).count();
            assert!(count > 1000, "{}: {profiler}: {count}", path.display());
        }
    }
}

#[test]
fn every_target_can_be_built() {
    for path in files("targets") {
        let text = std::fs::read_to_string(&path).expect("readable");
        let model: TargetModel =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(Target::from_model(&model).is_ok(), "{}", path.display());
    }
}

#[test]
fn every_sensor_file_names_the_source_of_its_figures() {
    for path in files("sensors") {
        let text = std::fs::read_to_string(&path).expect("readable");
        let table: toml::Table =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(
            table.len() > 3 && text.matches('#').count() > 3,
            "{}",
            path.display()
        );
    }
}

/// What is written is what was simulated, to the resolution of the files.
#[test]
fn a_written_survey_reads_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/scenarios/single-pass-thin.toml");
    let mut file = scenario::read(&path).expect("a scenario");
    file.scenario.sources = Sources::default();
    let survey = simulate(&file.scenario, 3).expect("a survey");
    write_survey(folder.path(), &file, &survey).expect("written");
    let campaign = &survey.campaign;
    let soundings =
        boresight::formats::read_soundings(&folder.path().join("multibeam.csv"), Invalid::Error)
            .expect("soundings");
    assert_eq!(soundings.ping, campaign.soundings.ping);
    let off = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    assert!(off(&soundings.across_rad, &campaign.soundings.across_rad) < 1e-8);
    let trajectory =
        boresight::formats::read_trajectory(&folder.path().join("trajectory.csv"), Invalid::Error)
            .expect("records");
    assert!(off(&trajectory.height_m, &campaign.trajectory.height_m) < 1e-6);
    let laser = boresight::formats::read_laser(&folder.path().join("lidar.laz"), Invalid::Error)
        .expect("returns");
    assert_eq!(laser.len(), campaign.laser.len());
    assert!(off(&laser.x_m, &campaign.laser.x_m) < 1e-4);
    let text = std::fs::read_to_string(folder.path().join("truth.json")).expect("the truth");
    let truth: simulate::Truth = serde_json::from_str(&text).expect("the truth");
    assert_eq!(truth, survey.truth);
    let survey_file =
        std::fs::read_to_string(folder.path().join("survey.toml")).expect("the survey file");
    let table: toml::Table = toml::from_str(&survey_file).expect("TOML");
    assert_eq!(table["procedure"].as_str(), Some("pool"));
    assert_eq!(
        table["target"]["azimuth_deg"].as_float(),
        Some(survey.prior.azimuth_rad.to_degrees())
    );
}

/// The survey reader takes what the simulator writes, from CSV and from SBET trajectories.
#[test]
fn a_written_survey_is_a_survey() {
    for name in ["single-pass-thin", "three-pass"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("models/scenarios/{name}.toml"));
        let file = scenario::read(&path).expect("a scenario");
        let survey = simulate(&file.scenario, 3).expect("a survey");
        write_survey(folder.path(), &file, &survey).expect("written");
        let loaded = load(&folder.path().join("survey.toml")).unwrap_or_else(|e| panic!("{e}"));
        let (read, made) = (&loaded.campaign, &survey.campaign);
        assert_eq!(read.soundings.len(), made.soundings.len());
        assert_eq!(read.laser.len(), made.laser.len());
        assert_eq!(read.trajectory.time_s.len(), made.trajectory.time_s.len());
        assert_eq!(read.sonar, made.sonar);
        assert_eq!(read.soundings.noise, made.soundings.noise);
    }
}
