//! From the path of a seabed survey file to everything in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;

use super::super::scene::{DriftSigmas, Line, Scene, Sounding, Tide, Water, wave_heave_m};
use super::casts;
use super::file::SeabedSurveyFile;
use super::heads;
use super::{recorded, tide};
use crate::calibrate::cloud::Beam;
use crate::formats::{
    SoundingRecords, TrajectoryRecords, read_soundings, read_trajectory, sound_speed_csv,
};
use crate::geometry::ellipsoid::TargetPose;
use crate::georef::local_trajectory;
use crate::observe::{
    GeodeticTrajectory, Outside, SoundSpeedProfile, SoundingRange, TideCurve, TrajectoryNoise,
};
use crate::recorders::navigation::at_reference;
use crate::results::InputFile;
use crate::survey::decimals;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{digests, keep, missing_files, read_text, typed};
use crate::survey::recorded::files::recorder_files;
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
    /// What was done on reading and what to look at, in words.
    pub notes: Vec<String>,
    /// The recorder files; none where the soundings are a CSV.
    pub recorders: Vec<PathBuf>,
}

/// The profile that all lines have.
const PROFILE: [&str; 2] = ["sound_speed", "profile"];

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[["trajectory", "path"], PROFILE, ["multibeam", "path"]];

/// Keys that say something of recorder files only.
const OF_RECORDERS: &[[&str; 2]] = &[
    ["trajectory", "accuracies"],
    ["trajectory", "time"],
    ["trajectory", "week"],
    ["trajectory", "leap_seconds"],
];

/// A survey does not reach farther from its origin, metres.
const FAR_M: f64 = 50e3;

/// Reads a seabed survey file and every file that it names.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong: first with the survey file itself, then with the files.
pub fn load(path: &Path) -> Result<LoadedSeabed, SurveyError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = read_text(path)?;
    let document = Document::parse(path, &text).map_err(|problems| SurveyError { problems })?;
    match recorder_files(&document, folder)? {
        Some(names) => of_recorders(path, &text, folder, names),
        None => of_columns(path, &text, folder),
    }
}

/// A survey whose soundings are a CSV.
fn of_columns(path: &Path, text: &str, folder: &Path) -> Result<LoadedSeabed, SurveyError> {
    let mut file = parse_survey(path, text, Some(folder))?;
    let one = |name: &Option<String>| name.clone().unwrap_or_default();
    let [trajectory, soundings] =
        [&file.trajectory.path, &file.multibeam.path].map(|name| folder.join(one(name)));
    let mut problems = vec![];
    let records = read_trajectory(&trajectory, file.trajectory.invalid).map_err(SurveyError::from);
    let records = keep(&mut problems, records);
    let water = keep(&mut problems, waters(&file, folder));
    let observed = read_soundings(&soundings, file.multibeam.invalid).map_err(SurveyError::from);
    let observed = keep(&mut problems, observed);
    let tide = keep(&mut problems, tide::read(&file, folder));
    let read = (records, water, observed, tide);
    let (Some(mut records), Some(water), Some(mut observed), Some(tide)) = read else {
        return Err(SurveyError { problems });
    };
    let mut notes = std::mem::take(&mut records.notes);
    notes.append(&mut observed.notes);
    notes.extend(heads::of_columns(path, &soundings, &mut file, &observed)?);
    let casts = file.cast.iter().map(|cast| cast.path.clone());
    let named: Vec<String> = std::iter::once(one(&file.trajectory.path))
        .chain(file.sound_speed.profile.clone())
        .chain(casts)
        .chain(file.tide.as_ref().map(|tide| tide.path.clone()))
        .chain([one(&file.multibeam.path)])
        .collect();
    let inputs = digests(
        path,
        folder,
        &named.iter().map(String::as_str).collect::<Vec<_>>(),
    )?;
    let read = observed.time_s.len();
    notes.extend(coarse(&file, &records));
    let arm_m = Vector3::from(file.trajectory.lever_arm_m);
    let records = at_reference(records, &arm_m, file.site.ellipsoid);
    let (profiles, said) = water;
    notes.extend(said);
    let mut scene = scene(&file, records, &profiles, tide, &observed);
    one_each(&mut scene, &profiles);
    none_of(clock_problems(&scene, &observed, &soundings))?;
    none_of(Vec::from_iter(far_from_the_site(&scene, &trajectory)))?;
    notes.extend(tide::noted(&file, folder, &scene)?);
    notes.extend(uncovered(&scene));
    Ok(LoadedSeabed {
        file,
        scene,
        read,
        inputs,
        notes,
        recorders: vec![],
    })
}

/// The water: one profile, or one of each line and what it is made of.
fn waters(
    file: &SeabedSurveyFile,
    folder: &Path,
) -> Result<(Vec<SoundSpeedProfile>, Vec<String>), SurveyError> {
    if file.cast.is_empty() {
        let path = folder.join(file.sound_speed.profile.as_deref().unwrap_or_default());
        return Ok((vec![sound_speed_csv::read(&path)?], vec![]));
    }
    Ok(of_each_line(file, &casts::read(file, folder)?))
}

/// The water of each line between casts that the survey file names, and what it is made of.
fn of_each_line(
    file: &SeabedSurveyFile,
    casts: &[(f64, SoundSpeedProfile)],
) -> (Vec<SoundSpeedProfile>, Vec<String>) {
    let interpolated = file.sound_speed.between == "interpolated";
    casts::of_lines(casts, &file.lines(), interpolated)
}

/// Gives each line its own of as many profiles.
fn one_each(scene: &mut Scene, profiles: &[SoundSpeedProfile]) {
    for (k, line) in scene.lines.iter_mut().enumerate() {
        line.cast = k.min(profiles.len() - 1);
    }
}

/// Gives each line the last cast before it; says which where there are several.
fn last_before(scene: &mut Scene, casts: &[(Option<f64>, SoundSpeedProfile)]) -> Option<String> {
    for line in &mut scene.lines {
        line.cast = recorded::cast_of(casts, line.start_s);
    }
    let of = |line: &Line| format!("{} cast {}", line.name, line.cast + 1);
    let each: Vec<String> = scene.lines.iter().map(of).collect();
    let count = casts.len();
    (count > 1).then(|| {
        format!(
            "{count} sound-speed casts, of each line the last before it: {}",
            each.join(", ")
        )
    })
}

/// Columns of the trajectory whose rounding errs by more than is stated.
fn coarse(file: &SeabedSurveyFile, records: &TrajectoryRecords) -> Vec<String> {
    let ins = file.ins();
    let angles_rad = [ins.roll_pitch_rad, ins.heading_rad];
    decimals::of_trajectory(records, ins.position_m, angles_rad)
}

/// A survey of recorder files.
fn of_recorders(
    path: &Path,
    text: &str,
    folder: &Path,
    names: Vec<String>,
) -> Result<LoadedSeabed, SurveyError> {
    let mut from = recorded::load(path, text, folder, names)?;
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    none_of(line_problems(&document, &from.file))?;
    let named: Vec<&str> = from.named.iter().map(String::as_str).collect();
    let inputs = digests(path, folder, &named)?;
    let by_name = !from.file.cast.is_empty();
    let profiles = if by_name {
        let timed = |(time_s, profile): &(Option<f64>, SoundSpeedProfile)| {
            Some(((*time_s)?, profile.clone()))
        };
        let casts: Vec<_> = from.casts.iter().filter_map(timed).collect();
        let (profiles, said) = of_each_line(&from.file, &casts);
        from.notes.extend(said);
        profiles
    } else {
        from.casts.iter().map(|cast| cast.1.clone()).collect()
    };
    from.notes.extend(coarse(&from.file, &from.trajectory));
    let tide = from.tide.take();
    let mut scene = scene(
        &from.file,
        from.trajectory,
        &profiles,
        tide,
        &from.soundings,
    );
    scene.drift = from.drift;
    scene.assumed = from.assumed;
    if by_name {
        one_each(&mut scene, &profiles);
    } else {
        from.notes.extend(last_before(&mut scene, &from.casts));
    }
    let first = from.paths.first().cloned().unwrap_or_default();
    none_of(clock_problems(&scene, &from.soundings, &first))?;
    from.notes.extend(tide::noted(&from.file, folder, &scene)?);
    from.notes.extend(uncovered(&scene));
    Ok(LoadedSeabed {
        read: from.soundings.time_s.len(),
        file: from.file,
        scene,
        inputs,
        notes: from.notes,
        recorders: from.paths,
    })
}

/// Lines of which part has no position or attitude, in words.
fn uncovered(scene: &Scene) -> Vec<String> {
    let mut counts = vec![(0usize, 0usize); scene.lines.len()];
    for sounding in &scene.soundings {
        let count = &mut counts[usize::from(sounding.line)];
        count.0 += 1;
        count.1 += usize::from(scene.trajectory.pose_at(sounding.time_s).is_err());
    }
    let lines = scene
        .lines
        .iter()
        .zip(counts)
        .filter(|(_, (_, lost))| *lost > 0);
    let words = |(line, (all, lost)): (&Line, (usize, usize))| {
        format!(
            "line \"{}\": {lost} of {all} soundings have no position or attitude and are not used",
            line.name
        )
    };
    lines.map(words).collect()
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
    let missing =
        folder.map(|folder| missing_files(&document, folder, &[FILES, &[tide::PATH]].concat()));
    problems.extend(missing.into_iter().flatten());
    let by_casts = |key: &[&str; 2]| *key == PROFILE && document.get(&["cast"]).is_some();
    if document.get(&PROFILE).is_some() && by_casts(&PROFILE) {
        let expected = "one of the two: a profile for all lines, or casts";
        problems.push(document.problem(&PROFILE, "a profile and [[cast]]", expected));
    }
    let absent = FILES
        .iter()
        .filter(|key| document.get(*key).is_none() && !by_casts(key));
    problems.extend(absent.map(|key| {
        document.problem(
            key,
            "nothing",
            "a file, or recorder files as paths under [multibeam]",
        )
    }));
    if document.string(&["trajectory", "heights"]) == Some("heave") {
        let expected = "heights above the ellipsoid: a CSV holds no others";
        problems.push(document.problem(&["trajectory", "heights"], "\"heave\"", expected));
    }
    for key in OF_RECORDERS
        .iter()
        .filter(|key| document.get(*key).is_some())
    {
        let expected = "this key with recorder files only; a CSV has the clock of its trajectory";
        problems.push(document.problem(key, "soundings of a CSV", expected));
    }
    none_of(problems)?;
    let file: SeabedSurveyFile = typed(path, text)?;
    none_of(line_problems(&document, &file))?;
    Ok(file)
}

/// Lines that end before they begin, overlap in time, or have a tide of their own beside a curve.
fn line_problems(document: &Document<'_>, file: &SeabedSurveyFile) -> Vec<Problem> {
    let mut problems: Vec<Problem> = tide::twice(file, document).into_iter().collect();
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

/// A trajectory that lies nowhere near the origin of the survey file: another site, or a sign of a longitude.
fn far_from_the_site(scene: &Scene, trajectory: &Path) -> Option<Problem> {
    let places = scene.trajectory.positions_m();
    let away_m = places.get(places.len() / 2)?.norm();
    (away_m > FAR_M).then(|| {
        let found = format!("positions {:.0} km from [site] origin", 1e-3 * away_m);
        let expected = format!(
            "within {:.0} km of it (latitude, longitude and their signs)",
            1e-3 * FAR_M
        );
        let columns = "columns latitude_deg, longitude_deg";
        Problem::new(trajectory, columns, found, expected)
    })
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
    casts: &[SoundSpeedProfile],
    tide: Option<TideCurve>,
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
    scene_of(file, &geodetic, casts, tide, observed)
}

/// The survey in memory from its observations.
#[must_use]
pub fn scene_of(
    file: &SeabedSurveyFile,
    geodetic: &GeodeticTrajectory,
    casts: &[SoundSpeedProfile],
    tide: Option<TideCurve>,
    observed: &SoundingRecords,
) -> Scene {
    let gap_s = file.trajectory.max_gap_s;
    let pose = TargetPose {
        ellipsoid: file.site.ellipsoid,
        origin: file.site.origin.geodetic(),
        azimuth_rad: 0.0,
    };
    let trajectory = local_trajectory(geodetic, &pose).trajectory;
    let lines = file.lines();
    let soundings = soundings((&lines, &file.head_numbers()), observed, casts);
    let tide = Tide {
        curve: tide,
        lifts: file.trajectory.above_water(),
    };
    let mut scene = Scene {
        heave_m: wave_heave_m(&trajectory, gap_s),
        ins: file.ins(),
        drift: DriftSigmas::default(),
        water: water((file.site.water_level_m, tide), casts, &soundings),
        lines,
        soundings,
        sonar: file.sonar(),
        assumed: vec![],
        heads: file.heads(observed.arrays.is_some()),
        priors: file.priors(),
        extras: Arc::default(),
        trajectory,
    };
    scene.water.transducer_m = scene.transducer_depth_m();
    scene
}

/// The soundings of each line, line after line, head after head. Measured ranges become times of the profile's shallowest speed.
fn soundings(
    (lines, heads): (&[Line], &[u32]),
    observed: &SoundingRecords,
    casts: &[SoundSpeedProfile],
) -> Vec<Sounding> {
    let speed_m_s = casts.first().and_then(|cast| cast.speed_m_s.first());
    let speed_m_s = speed_m_s.copied().unwrap_or(1500.0);
    let arrays = observed.arrays.as_ref();
    let delay_s = |k: usize| arrays.map_or(0.0, |a| a.delay_s[k]);
    let one_way_s = |k: usize| match &observed.range {
        SoundingRange::TwoWayTravelTime(time_s) => 0.5 * time_s[k],
        SoundingRange::Metres(range_m) => range_m[k] / speed_m_s,
    };
    let times = &observed.time_s;
    let mut all = vec![];
    for (number, line) in lines.iter().enumerate() {
        let first = times.partition_point(|t| *t < line.start_s);
        let last = times.partition_point(|t| *t <= line.end_s);
        let sounding = |head: usize, k: usize| Sounding {
            line: number as u16,
            head: head as u8,
            time_s: times[k] + delay_s(k),
            across_rad: observed.across_rad[k],
            along_rad: observed.along_rad[k],
            one_way_s: one_way_s(k),
            head_speed_m_s: arrays.map_or(0.0, |a| a.head_speed_m_s[k]) as f32,
            row: k as u32,
            beam: Beam {
                ping: observed.ping[k],
                beam: observed.beam[k],
            },
        };
        let on_line = || first..last.max(first);
        if observed.head.is_empty() {
            all.extend(on_line().map(|k| sounding(0, k)));
            continue;
        }
        for (head, number) in heads.iter().enumerate() {
            let own = on_line().filter(|k| observed.head[*k] == *number);
            all.extend(own.map(|k| sounding(head, k)));
        }
    }
    all
}

/// The casts, made to reach below the deepest sounding so that their error grows all the way down.
fn water(
    (level_m, tide): (f64, Tide),
    casts: &[SoundSpeedProfile],
    soundings: &[Sounding],
) -> Water {
    let longest_s = soundings.iter().map(|s| s.one_way_s).fold(0.0, f64::max);
    let reach_m = 2000.0 * longest_s + 100.0;
    Water {
        level_m,
        tide,
        casts: casts.iter().map(|cast| reaching(cast, reach_m)).collect(),
        transducer_m: 0.0,
    }
}

fn reaching(cast: &SoundSpeedProfile, reach_m: f64) -> SoundSpeedProfile {
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
    SoundSpeedProfile { depth_m, speed_m_s }
}
