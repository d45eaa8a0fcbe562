//! From the path of a survey file to everything in memory.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::file::{CoordinatesName, SurveyFile};
use super::observations::{
    laser_problem, no_room, of_head, place_laser, place_soundings, place_streamed, shift,
    to_geocentric, to_transmission, trajectory_problem,
};
use super::{recorded, rules};
use crate::formats::digest::Stamps;
use crate::formats::week;
use crate::formats::{
    FaultKind, LaserRecords, SoundingRecords, TrajectoryRecords, read_laser, read_laser_cloud,
    read_sound_speed, read_soundings_within, read_trajectory,
};
use crate::geometry::ellipsoid::TargetPose;
use crate::observe::{
    Campaign, GeodeticTrajectory, LaserCoordinates, LaserNoise, Room, SonarNoise, SoundSpeed,
    SoundSpeedProfile, SoundingFile, SoundingRange,
};
use crate::recorders::navigation::at_reference;
use crate::results::InputFile;
use crate::survey::decimals;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{digests, keep, read_text, typed};
use crate::survey::recorded::files::recorder_files;
use crate::target::{Target, TargetModel};

/// A survey in memory.
#[derive(Clone, Debug)]
pub struct LoadedSurvey {
    /// The survey file with every default filled in: the configuration as it takes effect.
    pub file: SurveyFile,
    /// The observations.
    pub campaign: Campaign,
    /// What the target file says.
    pub target_model: TargetModel,
    /// The target's faces.
    pub target: Target,
    /// Where the surveyor believes the target to stand.
    pub pose: TargetPose,
    /// Every file that was read, the survey file first, paths as they stand in the survey file.
    pub inputs: Vec<InputFile>,
    /// How much was read.
    pub counts: Counts,
    /// Sentences that a report should repeat.
    pub notes: Vec<String>,
    /// The recorder files; none where the soundings are a CSV.
    pub recorders: Vec<PathBuf>,
}

/// How much was read and how much of it dropped because the trajectory does not cover it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Records of the trajectory.
    pub trajectory: usize,
    /// Laser returns in use.
    pub laser: usize,
    /// Laser returns dropped.
    pub laser_dropped: usize,
    /// Soundings in use.
    pub soundings: usize,
    /// Soundings dropped.
    pub soundings_dropped: usize,
}

/// Reads a survey file and every file that it names.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong: first with the survey file itself, then with the files, then with
/// their times. Nothing is written.
pub fn load(path: &Path) -> Result<LoadedSurvey, SurveyError> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut stamps = Stamps::begin(path);
    let text = read_text(path)?;
    let document = Document::parse(path, &text).map_err(|problems| SurveyError { problems })?;
    let recorders = recorder_files(&document, &folder)?;
    let mut file = match &recorders {
        None => parse_survey(path, &text, Some(&folder))?,
        Some(names) => recorded::draft(path, &document, &text, &folder, names)?,
    };
    let paths = Paths::new(&file, &folder, recorders.as_deref());
    let named = named(&file, recorders.as_deref());
    stamps.add(named.iter().map(|name| folder.join(name)));
    let of_file = file.clone();
    let (contents, inputs) = rayon::join(
        || match &recorders {
            None => read_contents(&of_file, &paths),
            Some(_) => recorded::read_contents(path, &document, &mut file, &paths),
        },
        || {
            let named: Vec<&str> = named.iter().map(String::as_str).collect();
            digests(path, &folder, &named)
        },
    );
    let (contents, inputs) = (contents?, inputs?);
    stamps.unchanged()?;
    let survey = compose(file, &paths, contents, inputs)?;
    Ok(LoadedSurvey {
        recorders: paths.recorders,
        ..survey
    })
}

/// Reads and checks a survey file alone; with a folder, also that the paths in it lead to files.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong with it.
pub fn read_survey_file(path: &Path, folder: Option<&Path>) -> Result<SurveyFile, SurveyError> {
    let text = read_text(path)?;
    parse_survey(path, &text, folder)
}

/// Checks and parses the text of a survey file; `path` names it in messages.
///
/// # Errors
/// As [`read_survey_file`].
pub fn parse_survey(
    path: &Path,
    text: &str,
    folder: Option<&Path>,
) -> Result<SurveyFile, SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    none_of(rules::survey_problems(&document, folder))?;
    Ok(with_settings(path, typed(path, text)?))
}

/// The joint path's settings that stand in sections of their own.
pub(super) fn with_settings(path: &Path, mut file: SurveyFile) -> SurveyFile {
    file.joint.verdict = file.verdict.clone();
    if let Some(large) = &file.large {
        file.joint.large = large.engine(path);
    }
    file
}

/// Checks and parses the text of a target file; `path` names it in messages.
///
/// # Errors
/// [`SurveyError`] with every unknown key and every impossible dimension.
pub fn parse_target(path: &Path, text: &str) -> Result<(TargetModel, Target), SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    none_of(rules::target_problems(&document))?;
    let model: TargetModel = typed(path, text)?;
    let target = Target::from_model(&model).map_err(|error| SurveyError {
        problems: error
            .faults
            .iter()
            .map(|fault| dimension(path, fault))
            .collect(),
    })?;
    Ok((model, target))
}

/// An impossible dimension as a problem; most say themselves what was expected.
fn dimension(path: &Path, fault: &str) -> Problem {
    let (found, expected) = fault
        .split_once(", expected ")
        .unwrap_or((fault, "a target that can be built"));
    Problem::new(path, "dimensions", found, expected)
}

/// Where the files are, relative to the working directory.
pub(super) struct Paths {
    pub(super) target: PathBuf,
    /// The trajectory's; the first recorder file's where it is their own navigation.
    pub(super) trajectory: PathBuf,
    pub(super) lidar: PathBuf,
    /// The soundings'; the first of several.
    pub(super) multibeam: PathBuf,
    pub(super) profile: Option<PathBuf>,
    pub(super) recorders: Vec<PathBuf>,
}

impl Paths {
    fn new(file: &SurveyFile, folder: &Path, recorders: Option<&[String]>) -> Self {
        let profile = file.sound_speed.as_ref().and_then(|s| s.profile.as_ref());
        let recorders: Vec<PathBuf> = recorders
            .into_iter()
            .flatten()
            .map(|name| folder.join(name))
            .collect();
        let of = |name: &Option<String>| name.as_ref().map(|name| folder.join(name));
        let first = recorders.first().cloned();
        let multibeam = first.or(of(&file.multibeam.path)).unwrap_or_default();
        Self {
            target: folder.join(&file.target.model),
            trajectory: of(&file.trajectory.path).unwrap_or_else(|| multibeam.clone()),
            lidar: folder.join(&file.lidar.path),
            multibeam,
            profile: profile.map(|p| folder.join(p)),
            recorders,
        }
    }
}

/// What the files hold.
pub(super) struct Contents {
    pub(super) model: TargetModel,
    pub(super) target: Target,
    pub(super) trajectory: TrajectoryRecords,
    pub(super) laser: LaserRecords,
    pub(super) soundings: SoundingRecords,
    /// Where there was no room for the soundings: all of them, and their columns are empty.
    pub(super) streamed: Option<SoundingFile>,
    pub(super) profile: Option<SoundSpeedProfile>,
}

/// Reads the files beside each other, and checks each by itself; the faults of all of them come together.
fn read_contents(file: &SurveyFile, paths: &Paths) -> Result<Contents, SurveyError> {
    let ((target, trajectory), (laser, soundings)) = rayon::join(
        || {
            let target = read_text(&paths.target).and_then(|t| parse_target(&paths.target, &t));
            (target, checked_trajectory(file, &paths.trajectory))
        },
        || {
            rayon::join(
                || checked_laser(file, &paths.lidar),
                || checked_soundings(file, &paths.multibeam),
            )
        },
    );
    let profile = paths.profile.as_deref().map(read_sound_speed).transpose();
    let mut problems = vec![];
    let target = keep(&mut problems, target);
    let trajectory = keep(&mut problems, trajectory);
    let laser = keep(&mut problems, laser);
    let soundings = keep(&mut problems, soundings);
    let profile = keep(&mut problems, profile.map_err(SurveyError::from));
    match (target, trajectory, laser, soundings, profile) {
        (
            Some((model, target)),
            Some(trajectory),
            Some(laser),
            Some((soundings, streamed)),
            Some(profile),
        ) => Ok(Contents {
            model,
            target,
            trajectory,
            laser,
            soundings,
            streamed,
            profile,
        }),
        _ => Err(SurveyError { problems }),
    }
}

/// Soundings of one head: a pool survey calibrates one.
fn checked_soundings(
    file: &SurveyFile,
    path: &Path,
) -> Result<(SoundingRecords, Option<SoundingFile>), SurveyError> {
    let (mut records, streamed) = read_within(file, path)?;
    let there = records.heads();
    if streamed.is_some() {
        // the soundings of the wanted head alone are in the file
        records.head.clear();
    }
    let wanted = file.multibeam.head;
    if let (Some(head), true) = (wanted, there.is_empty()) {
        let found = format!("head = {head}, and no column head");
        let expected = "a column head with the number of each sounding's head";
        return Err(Problem::new(path, "columns", found, expected).into());
    }
    let receiver = &file.multibeam;
    let receiver =
        receiver.receiver_lever_arm_m.is_some() || receiver.receiver_mounting_deg.is_some();
    if receiver && records.arrays.is_none() {
        let found = "angles of one head, beside a receive array under [multibeam]";
        let expected = "rx_angle_deg and tx_tilt_deg, or no receive array";
        return Err(Problem::new(path, "columns", found, expected).into());
    }
    if there.len() < 2 && wanted.is_none() {
        return Ok((records, streamed));
    }
    let head = one_head(path, "column head", &there, wanted)?;
    match streamed {
        Some(streamed) => Ok((records, Some(streamed))),
        None => Ok((of_head(&records, head), None)),
    }
}

/// The head that is calibrated: the one that is asked for, or the only one.
pub(super) fn one_head(
    path: &Path,
    place: &str,
    there: &[u32],
    wanted: Option<u32>,
) -> Result<u32, Problem> {
    let listed: Vec<String> = there.iter().map(u32::to_string).collect();
    let listed = listed.join(", ");
    match (wanted, there) {
        (Some(head), _) if there.contains(&head) => Ok(head),
        (Some(head), _) => {
            let found = format!("head {head}; there are soundings of {listed}");
            let expected = "a head that has soundings, as [multibeam] head";
            Err(Problem::new(path, place, found, expected))
        }
        (None, [only]) => Ok(*only),
        (None, _) => {
            let found = format!("soundings of the heads {listed}");
            let expected = "[multibeam] head = one of them: a pool survey calibrates one head";
            Err(Problem::new(path, place, found, expected))
        }
    }
}

/// What soundings may take in memory.
fn room(file: &SurveyFile) -> Room {
    let large = file.large.clone().unwrap_or_default();
    large.room(&file.joint.large)
}

/// The soundings; what there is no room for is in a file.
fn read_within(
    file: &SurveyFile,
    path: &Path,
) -> Result<(SoundingRecords, Option<SoundingFile>), SurveyError> {
    let (invalid, head) = (file.multibeam.invalid, file.multibeam.head);
    let read = read_soundings_within(path, invalid, &room(file), head);
    read.map_err(|error| match error.kind {
        FaultKind::Unwritable => no_room(&error.file, &error.found).into(),
        _ => error.into(),
    })
}

fn checked_trajectory(file: &SurveyFile, path: &Path) -> Result<TrajectoryRecords, SurveyError> {
    let mut records = read_trajectory(path, file.trajectory.invalid)?;
    none_of(
        trajectory_problem(path, &records, file)
            .into_iter()
            .collect(),
    )?;
    shift(&mut records.time_s, file.trajectory.time_offset_s);
    Ok(at_reference(
        records,
        &Vector3::from(file.trajectory.lever_arm_m),
        file.target.ellipsoid,
    ))
}

pub(super) fn checked_laser(file: &SurveyFile, path: &Path) -> Result<LaserRecords, SurveyError> {
    let mut records = match file.lidar.coordinates {
        CoordinatesName::Sensor => read_laser(path, file.lidar.invalid)?,
        // points that are georeferenced need no time
        _ => read_laser_cloud(path, file.lidar.invalid)?,
    };
    let problem = laser_problem(path, &records, file.lidar.coordinates);
    none_of(problem.into_iter().collect())?;
    if let Some(zone) = file.lidar.zone() {
        to_geocentric(path, &mut records, file.target.ellipsoid, zone)?;
    }
    Ok(records)
}

/// The files that a survey file names, as it names them.
fn named(file: &SurveyFile, recorders: Option<&[String]>) -> Vec<String> {
    let profile = file.sound_speed.as_ref().and_then(|s| s.profile.as_ref());
    let before = [
        Some(&file.target.model),
        file.trajectory.path.as_ref(),
        Some(&file.lidar.path),
    ];
    let own = file.multibeam.path.as_ref().filter(|_| recorders.is_none());
    let soundings = recorders.into_iter().flatten().chain(own);
    let before = before.into_iter().flatten();
    before.chain(soundings).chain(profile).cloned().collect()
}

/// The sound speed that the soundings need, or why there is none.
fn sound_speed(
    file: &SurveyFile,
    paths: &Paths,
    range: &SoundingRange,
    profile: Option<SoundSpeedProfile>,
) -> Result<Option<SoundSpeed>, Problem> {
    let constant = file.sound_speed.as_ref().and_then(|s| s.speed_m_s);
    let speed = constant
        .map(SoundSpeed::Constant)
        .or(profile.map(SoundSpeed::Profile));
    match (range, &speed) {
        (SoundingRange::TwoWayTravelTime(_), None) => Err(Problem::new(
            &paths.multibeam,
            "column two_way_travel_time_s",
            "travel times",
            "a section [sound_speed] with speed_m_s or profile in the survey file, or a column range_m",
        )),
        _ => Ok(speed),
    }
}

/// Puts everything together; the clocks are judged here.
fn compose(
    file: SurveyFile,
    paths: &Paths,
    contents: Contents,
    inputs: Vec<InputFile>,
) -> Result<LoadedSurvey, SurveyError> {
    let Contents {
        model,
        target,
        mut trajectory,
        mut laser,
        mut soundings,
        streamed,
        profile,
    } = contents;
    let mut on_reading = std::mem::take(&mut trajectory.notes);
    on_reading.append(&mut laser.notes);
    on_reading.append(&mut soundings.notes);
    let section = &file.trajectory;
    let noise = section.noise();
    let angles_rad = [noise.roll_pitch_rad, noise.heading_rad];
    let coarse = decimals::of_trajectory(&trajectory, noise.position_m, angles_rad);
    on_reading.extend(coarse);
    let trajectory = trajectory.into_trajectory(
        file.target.ellipsoid,
        noise,
        section.max_gap_s,
        section.outside.into(),
    );
    shift(&mut laser.time_s, file.lidar.time_offset_s);
    to_transmission(&mut soundings);
    shift(&mut soundings.time_s, file.multibeam.time_offset_s);
    let streamed = streamed.map(|s| s.shifted(file.multibeam.time_offset_s));
    let mut problems = vec![];
    let speed = sound_speed(&file, paths, &soundings.range, profile);
    let speed = keep(&mut problems, speed.map_err(SurveyError::from)).flatten();
    let observed = Observed {
        trajectory,
        laser,
        laser_noise: file.lidar.noise(),
        soundings,
        streamed,
        sonar_noise: file.multibeam.noise(),
        sound_speed: speed,
    };
    let names = [paths.lidar.as_path(), &paths.multibeam];
    let (campaign, counts) = placed(&file, names, observed, problems)?;
    Ok(LoadedSurvey {
        pose: file.target.pose(),
        notes: on_reading
            .into_iter()
            .chain(notes(&counts, &campaign))
            .collect(),
        file,
        campaign,
        target_model: model,
        target,
        inputs,
        counts,
        recorders: vec![],
    })
}

/// Observations whose stamps are on the trajectory's clock, not yet judged by it.
pub(super) struct Observed {
    pub(super) trajectory: GeodeticTrajectory,
    pub(super) laser: LaserRecords,
    pub(super) laser_noise: LaserNoise,
    pub(super) soundings: SoundingRecords,
    /// As in what was read.
    pub(super) streamed: Option<SoundingFile>,
    pub(super) sonar_noise: SonarNoise,
    pub(super) sound_speed: Option<SoundSpeed>,
}

/// The observations that the trajectory covers, as a campaign; `names` are those of the returns and of the soundings for messages,
/// `problems` what is wrong already.
pub(super) fn placed(
    file: &SurveyFile,
    names: [&Path; 2],
    mut observed: Observed,
    mut problems: Vec<Problem>,
) -> Result<(Campaign, Counts), SurveyError> {
    let (frame, trajectory) = (file.lidar.frame(), &observed.trajectory);
    let laser_dropped = if frame == LaserCoordinates::Sensor {
        place_laser(names[0], &mut observed.laser, trajectory)
    } else {
        Ok(0)
    };
    let laser_dropped = keep(&mut problems, laser_dropped.map_err(SurveyError::from));
    let dropped = match &mut observed.streamed {
        None => place_soundings(names[1], &mut observed.soundings, trajectory),
        Some(streamed) => place_streamed(names[1], streamed, trajectory, &room(file)),
    };
    let dropped = keep(&mut problems, dropped.map_err(SurveyError::from));
    none_of(problems)?;
    let section = &file.multibeam;
    let columns = observed.soundings.arrays.take();
    let mut soundings = observed.soundings.into_soundings(observed.sonar_noise);
    soundings.arrays = columns.map(|columns| section.of_arrays(&columns.head_speed_m_s));
    soundings.file = observed.streamed;
    let soundings = soundings.within(&room(file));
    let soundings = soundings.map_err(|e| no_room(Path::new(&e.folder), &e.refused()))?;
    let counts = Counts {
        trajectory: observed.trajectory.time_s.len(),
        laser: observed.laser.len(),
        laser_dropped: laser_dropped.unwrap_or(0),
        soundings: soundings.len(),
        soundings_dropped: dropped.unwrap_or(0),
    };
    let arrays = soundings.arrays.as_ref();
    let campaign = Campaign {
        trajectory: observed.trajectory,
        laser: observed.laser.into_scan(frame, observed.laser_noise),
        scanner: file.lidar.mounting_deg.mounting(file.lidar.lever_arm_m),
        scanner_sigma: file.lidar.mounting_sigma(),
        sonar: arrays.map_or_else(
            || section.mounting_deg.mounting(section.lever_arm_m),
            |arrays| arrays.nominal,
        ),
        soundings,
        sound_speed: observed.sound_speed,
        water_level_m: file.target.water_level_m,
    };
    Ok((campaign, counts))
}

/// What a report should repeat about the reading.
pub(super) fn notes(counts: &Counts, campaign: &Campaign) -> Vec<String> {
    let mut notes = Vec::from_iter(week::passed("trajectory", &campaign.trajectory.time_s));
    let dropped = [
        ("laser returns", counts.laser_dropped, counts.laser),
        ("soundings", counts.soundings_dropped, counts.soundings),
    ];
    for (what, dropped, kept) in dropped.iter().filter(|(_, dropped, _)| *dropped > 0) {
        notes.push(format!(
            "{dropped} of {} {what} were dropped: the trajectory does not cover them",
            dropped + kept
        ));
    }
    if campaign.sound_speed.is_some()
        && matches!(campaign.soundings.range, SoundingRange::Metres(_))
    {
        notes.push("the sound speed was not used: the soundings are ranges in metres".to_owned());
    }
    notes
}
