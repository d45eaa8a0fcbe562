//! A USBL survey file and every file that it names, composed into a campaign.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Vector3};

use super::super::formats::control_csv::{
    ControlCoordinates, ControlRecords, ControlRole, ControlRow, SigmaAxes,
};
use super::super::formats::fixes_csv::{FixRecords, RangeKind};
use super::super::formats::{read_control, read_fixes};
use super::super::observed::{Beacon, ControlPoint, Fixes, Role, UsblCampaign};
use super::file::UsblFile;
use crate::formats::attitude_csv;
use crate::formats::digest::Stamps;
use crate::formats::week;
use crate::formats::{read_attitude, read_sound_speed};
use crate::geometry::ellipsoid::ecef_from_level;
use crate::geometry::{Ellipsoid, Geodetic, Point, rotation};
use crate::observe::{AttitudeRecord, SoundSpeed, SoundSpeedProfile, Trajectory};
use crate::results::InputFile;
use crate::survey::decimals;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{digests, keep, missing_files, read_text, typed};
use crate::survey::schema;
use crate::survey::sections::OutsideRule;

/// Control farther from the transducer than this is a slip, metres.
const FAR_M: f64 = 12_000.0;

/// A survey that can be calibrated.
#[derive(Clone, Debug)]
pub struct LoadedUsbl {
    /// The survey file.
    pub file: UsblFile,
    /// What was observed.
    pub campaign: UsblCampaign,
    /// Every file that was read, the survey file first.
    pub inputs: Vec<InputFile>,
    /// Fixes that were read.
    pub fixes_read: usize,
    /// Fixes dropped because they have no attitude.
    pub fixes_dropped: usize,
    /// What a report should repeat about the reading.
    pub notes: Vec<String>,
}

/// Reads a USBL survey file and its files.
///
/// # Errors
/// [`SurveyError`] with every fault that can be told at once.
pub fn load(path: &Path) -> Result<LoadedUsbl, SurveyError> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut stamps = Stamps::begin(path);
    let file = parse(path, &read_text(path)?, Some(&folder))?;
    stamps.add(named(&file).iter().map(|name| folder.join(name)));
    let contents = read(&file, &folder)?;
    let inputs = digests(path, &folder, &named(&file))?;
    stamps.unchanged()?;
    compose(file, contents, inputs, &folder)
}

/// The files that a survey file names, as it names them.
fn named(file: &UsblFile) -> Vec<&str> {
    let profile = file.sound_speed.profile.as_ref();
    let named = [&file.control.path, &file.fixes.path, &file.attitude.path];
    named
        .into_iter()
        .chain(profile)
        .map(String::as_str)
        .collect()
}

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[
    ["control", "path"],
    ["fixes", "path"],
    ["attitude", "path"],
    ["sound_speed", "profile"],
];

/// Checks and parses the text of a survey file; `path` names it in messages. With a folder, also that the paths in it lead to files.
///
/// # Errors
/// [`SurveyError`] with every unknown key and impossible value.
pub fn parse(path: &Path, text: &str, folder: Option<&Path>) -> Result<UsblFile, SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    let mut problems = schema::check(&document, UsblFile::KEYS);
    let has = |keys: &[&str]| document.get(keys).is_some();
    if has(&["sound_speed", "speed_m_s"]) && has(&["sound_speed", "profile"]) {
        let path = ["sound_speed", "profile"];
        problems.push(document.problem(&path, "both speed_m_s and profile", "one of them"));
    }
    if has(&["sound_speed", "profile"]) && !has(&["transducer", "depth_m"]) {
        let expected =
            "the transducer's depth below the water level in metres, which a profile needs";
        problems.push(document.problem(&["transducer", "depth_m"], "nothing", expected));
    }
    problems.extend(
        folder
            .iter()
            .flat_map(|folder| missing_files(&document, folder, FILES)),
    );
    none_of(problems)?;
    let mut file: UsblFile = typed(path, text)?;
    file.joint.verdict = file.verdict.clone();
    Ok(file)
}

struct Contents {
    control: ControlRecords,
    fixes: FixRecords,
    attitude: AttitudeRecord,
    profile: Option<SoundSpeedProfile>,
}

/// Reads all files; the faults of all of them come together.
fn read(file: &UsblFile, folder: &Path) -> Result<Contents, SurveyError> {
    let mut problems: Vec<Problem> = vec![];
    let control = read_control(&folder.join(&file.control.path));
    let control = keep(&mut problems, control.map_err(SurveyError::from));
    let fixes = read_fixes(&folder.join(&file.fixes.path), file.fixes.invalid);
    let fixes = keep(&mut problems, fixes.map_err(SurveyError::from));
    let attitude = read_attitude(&folder.join(&file.attitude.path), &attitude_csv::VESSEL);
    let attitude = keep(&mut problems, attitude.map_err(SurveyError::from));
    let profile = file.sound_speed.profile.as_ref();
    let profile = profile
        .map(|name| read_sound_speed(&folder.join(name)))
        .transpose();
    let profile = keep(&mut problems, profile.map_err(SurveyError::from));
    match (control, fixes, attitude, profile) {
        (Some(control), Some(fixes), Some(attitude), Some(profile)) => Ok(Contents {
            control,
            fixes,
            attitude,
            profile,
        }),
        _ => Err(SurveyError { problems }),
    }
}

/// Puts everything together; here the files are judged by each other.
fn compose(
    file: UsblFile,
    contents: Contents,
    inputs: Vec<InputFile>,
    folder: &Path,
) -> Result<LoadedUsbl, SurveyError> {
    let mut problems = vec![];
    let paths = Paths {
        control: folder.join(&file.control.path),
        fixes: folder.join(&file.fixes.path),
    };
    let (transducer, beacons) = control(&file, &contents.control, &paths, &mut problems);
    let fixes_read = contents.fixes.time_s.len();
    let repeats = repeated(&contents.fixes);
    let attitude = attitude(&file, &contents.attitude);
    let speed = speeds(
        &file,
        &contents.fixes,
        &contents.profile,
        &paths,
        &mut problems,
    );
    let (fixes, dropped) = fixes(
        &file,
        &contents.fixes,
        &beacons,
        (&attitude, speed),
        &paths,
        &mut problems,
    );
    none_of(problems)?;
    let sound_speed = match (contents.profile, file.sound_speed.speed_m_s) {
        (Some(profile), _) => SoundSpeed::Profile(profile),
        (None, Some(constant)) => SoundSpeed::Constant(constant),
        (None, None) => SoundSpeed::Constant(speed),
    };
    let mount = &file.transducer.mounting_deg;
    let campaign = UsblCampaign {
        transducer,
        beacons,
        fixes,
        attitude,
        attitude_noise: file.attitude.noise(),
        nominal: mount.mounting([0.0; 3]).rotation,
        sound_speed_relative: file.sound_speed.sigma_m_s / speed,
        sound_speed,
        transducer_depth_m: file.transducer.depth_m.unwrap_or(1.0),
        datum: file.control.datum(),
    };
    let mut of_reading = contents.fixes.notes;
    let noise = file.attitude.noise();
    let sigmas = [noise.roll_pitch_rad, noise.heading_rad];
    of_reading.extend(decimals::of_attitude(contents.attitude.columns(), sigmas));
    of_reading.extend(notes(
        &file,
        &contents.attitude.time_s,
        (dropped, repeats, fixes_read),
    ));
    Ok(LoadedUsbl {
        notes: of_reading,
        file,
        campaign,
        inputs,
        fixes_read,
        fixes_dropped: dropped,
    })
}

/// Names of files for messages.
struct Paths {
    control: PathBuf,
    fixes: PathBuf,
}

/// Transducer and beacons in the level frame at the surveyed transducer.
fn control(
    file: &UsblFile,
    records: &ControlRecords,
    paths: &Paths,
    problems: &mut Vec<Problem>,
) -> (ControlPoint, Vec<Beacon>) {
    let level = LevelFrame::at(records, file.control.ellipsoid);
    let (mut transducer, mut beacons) = (None, vec![]);
    for row in &records.rows {
        let point = level.point(row);
        if point.position_m.norm() > FAR_M {
            let found = format!(
                "{} {:.0} m from the transducer",
                row.name,
                point.position_m.norm()
            );
            let expected = format!("beacons within {FAR_M} m of it, all in the same coordinates");
            problems.push(Problem::new(&paths.control, "whole file", found, expected));
        }
        match row.role {
            ControlRole::Transducer => transducer = Some(point),
            ControlRole::Common => beacons.push(Beacon {
                point,
                role: Role::Common,
            }),
            ControlRole::Check => beacons.push(Beacon {
                point,
                role: Role::Check,
            }),
        }
    }
    let nowhere = ControlPoint {
        name: String::new(),
        position_m: Vector3::zeros(),
        covariance_m2: Matrix3::zeros(),
    };
    (transducer.unwrap_or(nowhere), beacons)
}

/// The local level frame at the surveyed transducer.
struct LevelFrame {
    coordinates: ControlCoordinates,
    axes: SigmaAxes,
    ellipsoid: Ellipsoid,
    origin_m: Vector3<f64>,
    /// Turns geocentric differences into east, north, up; the identity for local coordinates.
    level_from_given: Matrix3<f64>,
}

impl LevelFrame {
    fn at(records: &ControlRecords, ellipsoid: Ellipsoid) -> Self {
        let mut frame = Self {
            coordinates: records.coordinates,
            axes: records.axes,
            ellipsoid,
            origin_m: Vector3::zeros(),
            level_from_given: Matrix3::identity(),
        };
        let transducer = records
            .rows
            .iter()
            .find(|row| row.role == ControlRole::Transducer);
        if let Some(row) = transducer {
            frame.origin_m = frame.given(row);
            if frame.coordinates != ControlCoordinates::Local {
                let geodetic = ellipsoid.to_geodetic(&Point::new(frame.origin_m));
                frame.level_from_given = ecef_from_level(&geodetic).matrix.transpose();
            }
        }
        frame
    }

    /// Geocentric or local coordinates of a row, metres.
    fn given(&self, row: &ControlRow) -> Vector3<f64> {
        let [a, b, c] = row.coordinates;
        if self.coordinates != ControlCoordinates::Geodetic {
            return Vector3::new(a, b, c);
        }
        let geodetic = Geodetic {
            latitude_rad: a,
            longitude_rad: b,
            height_m: c,
        };
        self.ellipsoid.to_geocentric(&geodetic).coordinates
    }

    fn point(&self, row: &ControlRow) -> ControlPoint {
        let turn = self.level_from_given;
        let own = Matrix3::from_diagonal(&Vector3::from(row.sigma_m.map(|s| s * s)));
        ControlPoint {
            name: row.name.clone(),
            position_m: turn * (self.given(row) - self.origin_m),
            covariance_m2: match self.axes {
                SigmaAxes::Level => own,
                SigmaAxes::Geocentric => turn * own * turn.transpose(),
            },
        }
    }
}

fn attitude(file: &UsblFile, record: &AttitudeRecord) -> Trajectory {
    let offset_s = file.attitude.time_offset_s;
    let times = record.time_s.iter().map(|t| t + offset_s).collect();
    let turn = |[roll, pitch, heading]: [f64; 3]| rotation::from_attitude(roll, pitch, heading);
    let matrices: Vec<_> = record.angles_rad().map(turn).collect();
    let zero = vec![Vector3::zeros(); matrices.len()];
    Trajectory::new(times, zero, matrices, None, file.attitude.max_gap_s)
}

/// The speed that turns ranges into travel times and back, m/s.
fn speeds(
    file: &UsblFile,
    fixes: &FixRecords,
    profile: &Option<SoundSpeedProfile>,
    paths: &Paths,
    problems: &mut Vec<Problem>,
) -> f64 {
    let water = &file.sound_speed;
    let middle = profile
        .as_ref()
        .map(|p| p.speed_m_s.iter().sum::<f64>() / p.speed_m_s.len() as f64);
    let measured = middle.or(water.speed_m_s);
    match (file.fixes.nominal_speed_m_s, measured, fixes.range_kind) {
        (Some(nominal), _, _) => nominal,
        (None, Some(measured), RangeKind::OneWay | RangeKind::TwoWay) => measured,
        (None, None, RangeKind::OneWay | RangeKind::TwoWay) => {
            problems.push(Problem::new(
                &paths.fixes,
                "columns of travel times",
                "no sound speed in the survey file",
                "[sound_speed] with speed_m_s or profile",
            ));
            1500.0
        }
        (None, _, RangeKind::Metres) => {
            problems.push(Problem::new(
                &paths.fixes,
                "columns of ranges or coordinates",
                "no [fixes] nominal_speed_m_s in the survey file",
                "the sound speed with which the device made ranges of travel times",
            ));
            1500.0
        }
    }
}

/// The fixes that have a known beacon and an attitude, and how many have none.
fn fixes(
    file: &UsblFile,
    records: &FixRecords,
    beacons: &[Beacon],
    (attitude, speed_m_s): (&Trajectory, f64),
    paths: &Paths,
    problems: &mut Vec<Problem>,
) -> (Fixes, usize) {
    let mut out = Fixes {
        time_s: vec![],
        beacon: vec![],
        travel_time_s: vec![],
        direction: vec![],
        speed_m_s,
        noise: file.fixes.noise(),
    };
    let (mut unknown, mut outside): (Vec<usize>, Vec<(usize, String)>) = (vec![], vec![]);
    let mut seen = HashSet::new();
    for (k, name) in records.beacon.iter().enumerate() {
        if !seen.insert(exactly(records, k)) {
            continue;
        }
        let time_s = records.time_s[k] + file.fixes.time_offset_s;
        let Some(beacon) = beacons.iter().position(|b| b.point.name == *name) else {
            unknown.push(k);
            continue;
        };
        if let Err(why) = attitude.pose_at(time_s) {
            outside.push((k, why.to_string()));
            continue;
        }
        let travel_time_s = travel_time_s(file, records, k, speed_m_s);
        if !(travel_time_s > 0.0) {
            let found = format!("a travel time of {travel_time_s} s without the turnaround");
            let place = format!("line {}", records.line[k]);
            problems.push(Problem::new(&paths.fixes, place, found, "a time above 0"));
        }
        out.time_s.push(time_s);
        out.beacon.push(beacon as u32);
        out.travel_time_s.push(travel_time_s);
        out.direction.push(records.direction[k]);
    }
    problems.extend(unknown_beacons(records, &unknown, beacons, paths));
    if file.attitude.outside == OutsideRule::Error {
        problems.extend(without_attitude(records, &outside, paths));
    }
    (out, outside.len())
}

/// All that a row says, to the bit.
fn exactly(records: &FixRecords, k: usize) -> (&str, [u64; 5]) {
    let d = &records.direction[k];
    let values = [records.time_s[k], records.range[k], d.x, d.y, d.z];
    (&records.beacon[k], values.map(f64::to_bits))
}

/// Rows that repeat an earlier one: they carry the information of one.
fn repeated(records: &FixRecords) -> usize {
    let all = 0..records.time_s.len();
    let different: HashSet<_> = all.clone().map(|k| exactly(records, k)).collect();
    all.len() - different.len()
}

/// One-way travel time of a row, seconds.
fn travel_time_s(file: &UsblFile, records: &FixRecords, k: usize, speed_m_s: f64) -> f64 {
    match records.range_kind {
        RangeKind::Metres => records.range[k] / speed_m_s,
        RangeKind::OneWay => records.range[k],
        RangeKind::TwoWay => 0.5 * (records.range[k] - file.fixes.turnaround_s),
    }
}

/// One problem per name that the control file does not have, at the first line that has it.
fn unknown_beacons(
    records: &FixRecords,
    rows: &[usize],
    beacons: &[Beacon],
    paths: &Paths,
) -> Vec<Problem> {
    let mut first: BTreeMap<&str, (u64, usize)> = BTreeMap::new();
    for &k in rows {
        let held = first.entry(&records.beacon[k]);
        held.or_insert((records.line[k], 0)).1 += 1;
    }
    let known: Vec<_> = beacons.iter().map(|b| b.point.name.as_str()).collect();
    let expected = format!("a beacon of the control file: {}", known.join(", "));
    let problem = |(name, (line, count)): (&str, (u64, usize))| {
        let others = match count {
            1 => String::new(),
            n => format!(", and in {} more rows", n - 1),
        };
        let found = format!("beacon \"{name}\"{others}");
        let place = format!("line {line}, column beacon");
        Problem::new(&paths.fixes, place, found, &expected)
    };
    first.into_iter().map(problem).collect()
}

fn without_attitude(
    records: &FixRecords,
    outside: &[(usize, String)],
    paths: &Paths,
) -> Option<Problem> {
    let (k, why) = outside.first()?;
    let place = format!("line {}, column time_s", records.line[*k]);
    let found = format!("{} fixes without attitude, the first: {why}", outside.len());
    let expected = "an attitude at every fix ([attitude] outside = \"drop\" leaves such fixes out)";
    Some(Problem::new(&paths.fixes, place, found, expected))
}

fn notes(
    file: &UsblFile,
    attitude_s: &[f64],
    (dropped, repeats, read): (usize, usize, usize),
) -> Vec<String> {
    let mut notes = Vec::from_iter(week::passed("attitude record", attitude_s));
    if repeats > 0 {
        notes.push(format!(
            "{repeats} of {read} fixes are duplicates (same time, beacon and values); each was used once"
        ));
    }
    if dropped > 0 {
        notes.push(format!(
            "{dropped} of {read} fixes were dropped: the attitude record does not cover them"
        ));
    }
    if file.sound_speed.profile.is_none() {
        notes.push("no sound-speed profile: the rays are taken as straight".to_owned());
    }
    if file.control.tilt_sigma_deg == 0.0 {
        notes.push(
            "the deflection of the vertical (up to 0.008 deg) enters roll and pitch directly where the control is geocentric or \
             geodetic; [control] tilt_sigma_deg counts it"
                .to_owned(),
        );
    }
    notes
}
