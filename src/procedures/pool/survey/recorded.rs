//! A pool survey of recorder files: soundings, and where the survey file does not name them navigation, sound speed and nominal mountings,
//! from the files. The clock of the survey is the trajectory's; the soundings, which are UTC, are put on it.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::file::{CoordinatesName, SurveyFile};
use super::load::{Contents, Paths, checked_laser, one_head, parse_target, with_settings};
use super::observations::{shift, trajectory_problem};
use super::rules;
use crate::formats::recorder::Profile;
use crate::formats::{LaserRecords, TrajectoryRecords, read_sound_speed};
use crate::observe::SoundSpeedProfile;
use crate::recorders::navigation::{Wanted, at_reference};
use crate::recorders::{Heights, Observed};
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{keep, read_text};
use crate::survey::recorded::clock::{Clock, Named, agreeing, meeting};
use crate::survey::recorded::files::{losses, read_all};
use crate::survey::recorded::mounted::{OfFile, Placed, installation, mounting};
use crate::survey::recorded::navigation;

/// The survey file, a nominal mounting that the installation record is to supply zero for now.
pub(super) fn draft(
    path: &Path,
    document: &Document<'_>,
    text: &str,
    folder: &Path,
    names: &[String],
) -> Result<SurveyFile, SurveyError> {
    none_of(rules::recorder_problems(document, folder, names))?;
    let unreadable = |words: &str| {
        let found = format!("\"{}\"", words.replace('\n', " "));
        Problem::new(path, "whole file", found, "values of the right kind")
    };
    let mut root: toml::Table = toml::from_str(text).map_err(|e| unreadable(e.message()))?;
    if let Some(section) = root
        .get_mut("multibeam")
        .and_then(toml::Value::as_table_mut)
    {
        let zero = |key: &str| (key.to_owned(), toml::Value::Float(0.0));
        let angles = ["roll", "pitch", "heading"].map(zero);
        let entry = section.entry("lever_arm_m");
        entry.or_insert_with(|| vec![toml::Value::Float(0.0); 3].into());
        let entry = section.entry("mounting_deg");
        entry.or_insert_with(|| toml::Value::Table(angles.into_iter().collect()));
    }
    let file: Result<SurveyFile, toml::de::Error> = root.try_into();
    let file = file.map_err(|e| unreadable(e.message()))?;
    Ok(with_settings(path, file))
}

/// Reads everything, and puts the nominal mounting into the survey file.
pub(super) fn read_contents(
    path: &Path,
    document: &Document<'_>,
    file: &mut SurveyFile,
    paths: &Paths,
) -> Result<Contents, SurveyError> {
    let mut problems = vec![];
    let target = read_text(&paths.target).and_then(|text| parse_target(&paths.target, &text));
    let target = keep(&mut problems, target);
    let laser = keep(&mut problems, checked_laser(file, &paths.lidar));
    let observed = keep(&mut problems, read_all(&paths.recorders));
    let (Some((model, target)), Some(mut laser), Some(mut observed)) = (target, laser, observed)
    else {
        return Err(SurveyError { problems });
    };
    let mut notes = losses(&observed);
    if observed.repeated_pings > 0 {
        let count = observed.repeated_pings;
        notes.push(format!("{count} pings came twice and were counted once"));
    }
    let head = chosen_head(file, &observed, paths, &mut notes)?;
    none_of(mounted(
        path,
        document,
        (file, head),
        &observed,
        &mut notes,
    )?)?;
    let (mut trajectory, behind_s) = trajectory(file, paths, &observed, &mut notes)?;
    on_clock(
        (file, &paths.lidar),
        &mut laser,
        behind_s,
        &observed,
        &mut notes,
    )?;
    let profile = profile(file, paths, &observed, &mut notes)?;
    let mut soundings = observed.take_heads(&[head]);
    for time_s in &mut soundings.time_s {
        *time_s -= behind_s;
    }
    notes.append(&mut trajectory.notes);
    trajectory.notes = notes;
    Ok(Contents {
        model,
        target,
        trajectory,
        laser,
        soundings,
        streamed: None,
        profile,
    })
}

/// The head that is calibrated; says how many soundings of others are left out.
fn chosen_head(
    file: &SurveyFile,
    observed: &Observed,
    paths: &Paths,
    notes: &mut Vec<String>,
) -> Result<u32, Problem> {
    let there = observed.heads();
    if there.is_empty() {
        let valid = "beams that the sounder holds valid";
        return Err(Problem::new(&paths.multibeam, "soundings", "none", valid));
    }
    let head = one_head(&paths.multibeam, "soundings", &there, file.multibeam.head)?;
    let of = &observed.soundings.head;
    let others = of.iter().filter(|other| **other != head).count();
    if others > 0 {
        notes.push(format!(
            "head {head} is calibrated; {others} soundings of other heads are left out"
        ));
    }
    Ok(head)
}

/// The nominal mountings of both arrays: the survey file's, else the installation record's.
fn mounted(
    path: &Path,
    document: &Document<'_>,
    (file, head): (&mut SurveyFile, u32),
    observed: &Observed,
    notes: &mut Vec<String>,
) -> Result<Vec<Problem>, SurveyError> {
    let given = |key: &str| document.get(&["multibeam", key]).is_some();
    let section = &mut file.multibeam;
    section.head = Some(head);
    let of_file = OfFile {
        number: head,
        words: String::new(),
        arm: (&mut section.lever_arm_m, &mut section.receiver_lever_arm_m),
        angles: (
            &mut section.mounting_deg,
            &mut section.receiver_mounting_deg,
        ),
        given: Placed {
            arm: given("lever_arm_m"),
            mounting: given("mounting_deg"),
        },
    };
    let record = installation(observed)?;
    Ok(mounting(path, of_file, record.as_ref(), notes))
}

/// The trajectory on its own clock, and what is added to its times to make them UTC, seconds.
fn trajectory(
    file: &SurveyFile,
    paths: &Paths,
    observed: &Observed,
    notes: &mut Vec<String>,
) -> Result<(TrajectoryRecords, f64), SurveyError> {
    let section = &file.trajectory;
    let wanted = Wanted {
        heights: Heights::Ellipsoid,
        max_gap_s: section.max_gap_s,
        ellipsoid: file.target.ellipsoid,
        heave_serves: false,
    };
    let path = &paths.trajectory;
    if section.path.is_none() {
        let made = navigation::own(path, &observed.recorded, &wanted)?;
        notes.push("the trajectory is the recorder's own navigation; times are UTC".to_owned());
        notes.extend(made.notes);
        checked(path, &made.records, file)?;
        return Ok((made.records, 0.0));
    }
    let (mut records, scale, said) = navigation::of_file(path, &wanted, section.invalid)?;
    notes.extend(said);
    checked(path, &records, file)?;
    shift(&mut records.time_s, section.time_offset_s);
    let named = Named {
        section: "trajectory",
        keys: "time, week and leap_seconds",
        of: "trajectory",
        time: section.time.as_deref(),
        week: section.week,
        leap_seconds: section.leap_seconds,
    };
    let clock = meeting(&named, path, scale, &records.time_s, observed)?;
    agreeing(path, (&records, clock.shift_s), &observed.recorded)?;
    notes.push(format!(
        "{}; the soundings are put on that clock",
        clock.words
    ));
    let arm_m = Vector3::from(section.lever_arm_m);
    let records = at_reference(records, &arm_m, file.target.ellipsoid);
    Ok((records, clock.shift_s))
}

fn checked(path: &Path, records: &TrajectoryRecords, file: &SurveyFile) -> Result<(), SurveyError> {
    let problem = trajectory_problem(path, records, file);
    none_of(problem.into_iter().collect())
}

/// Puts laser returns whose times the survey file names on the trajectory's clock, which is `behind_s` behind UTC.
fn on_clock(
    (file, path): (&SurveyFile, &Path),
    laser: &mut LaserRecords,
    behind_s: f64,
    observed: &Observed,
    notes: &mut Vec<String>,
) -> Result<(), SurveyError> {
    let section = &file.lidar;
    if section.time.is_none() || section.coordinates != CoordinatesName::Sensor {
        return Ok(());
    }
    let named = Named {
        section: "lidar",
        keys: "time (and leap_seconds under [trajectory])",
        of: "laser returns",
        time: section.time.as_deref(),
        week: None,
        leap_seconds: file.trajectory.leap_seconds,
    };
    let Clock { shift_s, words } = meeting(&named, path, None, &laser.time_s, observed)?;
    notes.push(words);
    let by_s = shift_s - behind_s;
    laser.time_s.iter_mut().for_each(|time_s| *time_s += by_s);
    Ok(())
}

/// The profile that the survey file names, else the last of the recorders' casts before the first ping; none where the survey file gives
/// one speed.
fn profile(
    file: &SurveyFile,
    paths: &Paths,
    observed: &Observed,
    notes: &mut Vec<String>,
) -> Result<Option<SoundSpeedProfile>, SurveyError> {
    if file.sound_speed.is_some() {
        let own: Option<&PathBuf> = paths.profile.as_ref();
        return Ok(own.map(|path| read_sound_speed(path)).transpose()?);
    }
    let all = observed.recorded.casts();
    let first_s = observed.first_s().unwrap_or(0.0);
    let before = |cast: &&&Profile| cast.time_s <= first_s;
    let Some(cast) = all.iter().rfind(before).or(all.first()) else {
        let expected =
            "speed_m_s, or profile (a CSV with depth_m, sound_speed_m_s) under [sound_speed]";
        let found = "no sound-speed profile";
        return Err(Problem::new(&paths.multibeam, "sound speed", found, expected).into());
    };
    notes.push(match all.len() {
        1 => "sound speed: the cast in the files".to_owned(),
        n => format!("sound speed: the last of {n} casts in the files before the first ping"),
    });
    Ok(Some(SoundSpeedProfile {
        depth_m: cast.depth_m.clone(),
        speed_m_s: cast.speed_m_s.clone(),
    }))
}
