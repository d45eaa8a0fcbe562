//! From the path of a seabed survey file to everything in memory.

use std::path::Path;

use super::super::scene::{Line, Scene, Sounding, Water, wave_heave_m};
use super::file::SeabedSurveyFile;
use crate::formats::{
    SoundingRecords, TrajectoryRecords, read_soundings, read_trajectory, sound_speed_csv,
};
use crate::geometry::ellipsoid::TargetPose;
use crate::georef::local_trajectory;
use crate::observe::{
    GeodeticTrajectory, Outside, SoundSpeedProfile, SoundingRange, TrajectoryNoise,
};
use crate::results::InputFile;
use crate::stats::median;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{digests, keep, missing_files, read_text, typed};
use crate::survey::schema;

/// A seabed survey in memory.
#[derive(Clone, Debug)]
pub struct LoadedSeabed {
    /// The survey file with every default filled in.
    pub file: SeabedSurveyFile,
    /// The survey, ready to be calibrated.
    pub scene: Scene,
    /// Soundings read, those off every line included.
    pub read: usize,
    /// Every file that was read, the survey file first.
    pub inputs: Vec<InputFile>,
}

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[
    ["trajectory", "path"],
    ["sound_speed", "profile"],
    ["multibeam", "path"],
];

/// Reads a seabed survey file and every file that it names.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong: first with the survey file itself, then with the files.
pub fn load(path: &Path) -> Result<LoadedSeabed, SurveyError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = parse_survey(path, &read_text(path)?, Some(folder))?;
    let named = [
        &file.trajectory.path,
        &file.sound_speed.profile,
        &file.multibeam.path,
    ];
    let [trajectory, profile, soundings] = named.map(|name| folder.join(name));
    let mut problems = vec![];
    let records = read_trajectory(&trajectory).map_err(SurveyError::from);
    let records = keep(&mut problems, records);
    let cast = sound_speed_csv::read(&profile).map_err(SurveyError::from);
    let cast = keep(&mut problems, cast);
    let observed = read_soundings(&soundings).map_err(SurveyError::from);
    let observed = keep(&mut problems, observed);
    let (Some(records), Some(cast), Some(observed)) = (records, cast, observed) else {
        return Err(SurveyError { problems });
    };
    let inputs = digests(path, folder, &named.map(String::as_str))?;
    let read = observed.time_s.len();
    let scene = scene(&file, records, &cast, &observed);
    none_of(clock_problems(&scene, &observed, &soundings))?;
    Ok(LoadedSeabed {
        file,
        scene,
        read,
        inputs,
    })
}

/// Checks and parses the text of a seabed survey file; with a folder, also that the paths in it lead to files.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong with it.
pub fn parse_survey(
    path: &Path,
    text: &str,
    folder: Option<&Path>,
) -> Result<SeabedSurveyFile, SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    let mut problems = schema::check(&document, SeabedSurveyFile::KEYS);
    let missing = folder.map(|folder| missing_files(&document, folder, FILES));
    problems.extend(missing.into_iter().flatten());
    none_of(problems)?;
    let file: SeabedSurveyFile = typed(path, text)?;
    none_of(line_problems(&document, &file))?;
    Ok(file)
}

/// Lines that end before they begin, or overlap in time.
fn line_problems(document: &Document<'_>, file: &SeabedSurveyFile) -> Vec<Problem> {
    let mut problems = vec![];
    for (k, line) in file.line.iter().enumerate() {
        if !(line.end_s > line.start_s) {
            let found = format!(
                "line \"{}\" from {} to {} s",
                line.name, line.start_s, line.end_s
            );
            problems.push(document.problem(&["line"], found, "an end after the start"));
        }
        for other in &file.line[..k] {
            if line.name == other.name {
                let found = format!("two lines named \"{}\"", line.name);
                problems.push(document.problem(&["line"], found, "a name of its own for each"));
            }
            if line.start_s < other.end_s && other.start_s < line.end_s {
                let found = format!("lines \"{}\" and \"{}\" overlap", other.name, line.name);
                let expected = "lines one after the other: a sounding belongs to one";
                problems.push(document.problem(&["line"], found, expected));
            }
        }
    }
    problems
}

/// Clocks that never meet: a line without soundings, or soundings without a trajectory.
fn clock_problems(scene: &Scene, observed: &SoundingRecords, soundings: &Path) -> Vec<Problem> {
    let range = format!(
        "{} to {} s",
        observed.time_s.first().unwrap_or(&f64::NAN),
        observed.time_s.last().unwrap_or(&f64::NAN)
    );
    let empty = |k: &usize| !scene.soundings.iter().any(|s| usize::from(s.line) == *k);
    let mut problems: Vec<Problem> = (0..scene.lines.len())
        .filter(empty)
        .map(|k| {
            let line = &scene.lines[k];
            let expected = format!(
                "soundings on line \"{}\" ({} to {} s)",
                line.name, line.start_s, line.end_s
            );
            Problem::new(soundings, "column time_s", range.clone(), expected)
        })
        .collect();
    let times = scene.trajectory.times_s();
    let inside = |s: &Sounding| scene.trajectory.record_before(s.time_s).is_ok();
    if problems.is_empty() && !scene.soundings.iter().any(inside) {
        let (first, last) = (times.first(), times.last());
        let expected = format!(
            "soundings within the trajectory ({} to {} s)",
            first.unwrap_or(&f64::NAN),
            last.unwrap_or(&f64::NAN)
        );
        problems.push(Problem::new(soundings, "column time_s", range, expected));
    }
    problems
}

fn scene(
    file: &SeabedSurveyFile,
    records: TrajectoryRecords,
    cast: &SoundSpeedProfile,
    observed: &SoundingRecords,
) -> Scene {
    let ins = file.ins();
    let noise = TrajectoryNoise {
        position_m: ins.position_m,
        position_drift_m: ins.position_drift_m,
        drift_correlation_time_s: ins.position_correlation_s,
        roll_pitch_rad: ins.roll_pitch_rad,
        heading_rad: ins.heading_rad,
        heading_drift_rad: ins.heading_drift_rad,
    };
    let gap_s = file.trajectory.max_gap_s;
    let geodetic = records.into_trajectory(file.site.ellipsoid, noise, gap_s, Outside::Drop);
    scene_of(file, &geodetic, cast, observed)
}

/// The survey in memory from its observations.
#[must_use]
pub fn scene_of(
    file: &SeabedSurveyFile,
    geodetic: &GeodeticTrajectory,
    cast: &SoundSpeedProfile,
    observed: &SoundingRecords,
) -> Scene {
    let gap_s = file.trajectory.max_gap_s;
    let pose = TargetPose {
        ellipsoid: file.site.ellipsoid,
        origin: file.site.origin.geodetic(),
        azimuth_rad: 0.0,
    };
    let trajectory = local_trajectory(geodetic, &pose).trajectory;
    let nominal = file
        .multibeam
        .mounting_deg
        .mounting(file.multibeam.lever_arm_m);
    let lines = file.lines();
    let soundings = soundings(&lines, observed, cast);
    let level_m = file.site.water_level_m;
    let mut scene = Scene {
        heave_m: wave_heave_m(&trajectory, gap_s),
        ins: file.ins(),
        water: water(level_m, cast, &soundings),
        lines,
        soundings,
        sonar: file.sonar(),
        nominal,
        priors: file.priors(),
        trajectory,
    };
    scene.water.transducer_m = transducer_depth_m(&scene);
    scene
}

/// The soundings of each line, line after line. Measured ranges become times of the profile's shallowest speed.
fn soundings(
    lines: &[Line],
    observed: &SoundingRecords,
    cast: &SoundSpeedProfile,
) -> Vec<Sounding> {
    let speed_m_s = cast.speed_m_s.first().copied().unwrap_or(1500.0);
    let one_way_s = |k: usize| match &observed.range {
        SoundingRange::TwoWayTravelTime(time_s) => 0.5 * time_s[k],
        SoundingRange::Metres(range_m) => range_m[k] / speed_m_s,
    };
    let times = &observed.time_s;
    let mut all = vec![];
    for (number, line) in lines.iter().enumerate() {
        let first = times.partition_point(|t| *t < line.start_s);
        let last = times.partition_point(|t| *t <= line.end_s);
        all.extend((first..last.max(first)).map(|k| Sounding {
            line: number as u16,
            time_s: times[k],
            across_rad: observed.across_rad[k],
            along_rad: observed.along_rad[k],
            one_way_s: one_way_s(k),
            row: k as u32,
        }));
    }
    all
}

/// The profile, made to reach below the deepest sounding so that its error grows all the way down.
fn water(level_m: f64, cast: &SoundSpeedProfile, soundings: &[Sounding]) -> Water {
    let longest_s = soundings.iter().map(|s| s.one_way_s).fold(0.0, f64::max);
    let reach_m = 2000.0 * longest_s + 100.0;
    let (mut depth_m, mut speed_m_s) = (cast.depth_m.clone(), cast.speed_m_s.clone());
    if let (Some(&last_m), Some(&speed)) = (depth_m.last(), speed_m_s.last())
        && last_m < reach_m
    {
        depth_m.push(reach_m);
        speed_m_s.push(speed);
    }
    if let (Some(&first_m), Some(&speed)) = (depth_m.first(), speed_m_s.first())
        && first_m > 0.0
    {
        depth_m.insert(0, 0.0);
        speed_m_s.insert(0, speed);
    }
    Water {
        level_m,
        depth_m,
        speed_m_s,
        transducer_m: 0.0,
    }
}

/// Median depth of the transducer over the soundings, metres.
fn transducer_depth_m(scene: &Scene) -> f64 {
    let step = scene.soundings.len().div_ceil(2000).max(1);
    let depth = |s: &Sounding| {
        let pose = scene.trajectory.pose_at(s.time_s).ok()?;
        let transducer = pose.position_m + pose.rotation * scene.nominal.lever_arm_m;
        Some(scene.water.level_m - transducer.z)
    };
    let mut depths: Vec<f64> = scene
        .soundings
        .iter()
        .step_by(step)
        .filter_map(depth)
        .collect();
    median(&mut depths).unwrap_or(0.0).max(0.0)
}
