//! A seabed survey of recorder files: soundings, navigation, casts and nominal mountings from the files, the rest from the survey file.

use std::path::{Path, PathBuf};

use super::super::scene::DriftSigmas;
use super::external::{self, External};
use super::file::{LineSection, SeabedSurveyFile};
use super::filled::{self, Given};
use super::{heads, tide, white};
use crate::formats::recorder::{Installation, Profile, utc};
use crate::formats::{SoundingRecords, TrajectoryRecords, sound_speed_csv};
use crate::observe::{SoundSpeedProfile, TideCurve};
use crate::recorders::observed::ObservedFile;
use crate::recorders::{Heights, Navigation, Observed};
use crate::stats::Moments;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::recorded::files::{losses, read_all};
use crate::survey::recorded::mounted::{self, OfFile, installation};
use crate::survey::recorded::navigation;
use crate::units::degrees;

/// A survey of recorder files in memory.
pub(super) struct FromRecorders {
    /// The survey file with everything that the recorders supply.
    pub(super) file: SeabedSurveyFile,
    /// Soundings of the heads.
    pub(super) soundings: SoundingRecords,
    /// Poses of the reference point.
    pub(super) trajectory: TrajectoryRecords,
    /// Standard deviations of its drift over time, where a file states them.
    pub(super) drift: DriftSigmas,
    /// Keys of the noise that the survey file does not state.
    pub(super) assumed: Vec<&'static str>,
    /// Casts in order of time, with it; without a time where the survey file names the profile.
    pub(super) casts: Vec<(Option<f64>, SoundSpeedProfile)>,
    /// The tide over time, where the survey file names one.
    pub(super) tide: Option<TideCurve>,
    /// What was done and what to look at, in words.
    pub(super) notes: Vec<String>,
    /// The recorder files, in their order.
    pub(super) paths: Vec<PathBuf>,
    /// Every file that was read, as the survey file names it.
    pub(super) named: Vec<String>,
}

/// Reads a survey of recorder files.
pub(super) fn load(
    path: &Path,
    text: &str,
    folder: &Path,
    names: Vec<String>,
) -> Result<FromRecorders, SurveyError> {
    let (mut file, mut given) = filled::draft(path, text, folder, &names)?;
    let paths: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    let mut observed = read_all(&paths)?;
    let (chosen, said) = heads::of_recorders(path, &mut file, &observed)?;
    let mut notes = losses(&observed);
    notes.extend(said);
    let installation = installation(&observed)?;
    none_of(mountings(
        path,
        &mut file,
        &given,
        installation.as_ref(),
        &mut notes,
    ))?;
    let is_given = |key: &str| given.trajectory.iter().any(|own| own == key);
    let accuracies = external::accuracies(&mut file, folder, &observed, is_given)?;
    let (drift, said) = accuracies.unzip();
    notes.extend(said);
    let external = external::read(&file, folder, &observed)?;
    none_of(lines(path, &mut file, &given, &names, &observed))?;
    let navigation = match external {
        Some(External { records, notes }) => Navigation {
            records,
            notes,
            fixes: None,
        },
        None => navigation::own(
            first_of(&paths),
            &observed.recorded,
            &external::wanted(&file),
        )?,
    };
    notes.extend(navigation.notes);
    let shown = (&navigation.records, navigation.fixes.as_ref());
    let said = white::measured(&mut file.trajectory, &mut given, shown);
    notes.extend(said);
    let casts = casts(&file, folder, &observed, &paths)?;
    let mut named = names;
    named.extend(file.trajectory.path.clone());
    named.extend(file.trajectory.accuracies.clone());
    named.extend(file.sound_speed.profile.clone());
    named.extend(file.cast.iter().map(|cast| cast.path.clone()));
    named.extend(file.tide.as_ref().map(|tide| tide.path.clone()));
    let tide = tide::read(&file, folder)?;
    level(
        &mut file,
        &given,
        installation.as_ref(),
        (&navigation.records, tide.as_ref()),
        &mut notes,
    );
    filled::note_defaults(&given, &mut notes);
    if observed.repeated_pings > 0 {
        let count = observed.repeated_pings;
        notes.push(format!("{count} pings came twice and were counted once"));
    }
    Ok(FromRecorders {
        soundings: observed.take_heads(&chosen),
        file,
        trajectory: navigation.records,
        drift: drift.unwrap_or_default(),
        assumed: given.noise(),
        casts,
        tide,
        notes,
        paths,
        named,
    })
}

/// Every head of the survey file.
fn of_file<'f>(file: &'f mut SeabedSurveyFile, given: &Given) -> Vec<OfFile<'f>> {
    let several = !file.head.is_empty();
    let words = |number: u32| match several {
        true => format!("head {number}, "),
        false => String::new(),
    };
    let m = &mut file.multibeam;
    let number = m.head.unwrap_or(0);
    let first = OfFile {
        number,
        words: words(number),
        arm: (&mut m.lever_arm_m, &mut m.receiver_lever_arm_m),
        angles: (&mut m.mounting_deg, &mut m.receiver_mounting_deg),
        given: given.first,
    };
    let further = file.head.iter_mut().enumerate().map(|(k, head)| OfFile {
        number: head.number,
        words: words(head.number),
        arm: (&mut head.lever_arm_m, &mut head.receiver_lever_arm_m),
        angles: (&mut head.mounting_deg, &mut head.receiver_mounting_deg),
        given: given.further.get(k).copied().unwrap_or_default(),
    });
    std::iter::once(first).chain(further).collect()
}

/// Nominal mountings of every head: the survey file's, else the installation record's; a difference between them is said.
fn mountings(
    path: &Path,
    file: &mut SeabedSurveyFile,
    given: &Given,
    installation: Option<&Installation>,
    notes: &mut Vec<String>,
) -> Vec<Problem> {
    let heads = of_file(file, given);
    let of_head = |head: OfFile<'_>| mounted::mounting(path, head, installation, notes);
    heads.into_iter().flat_map(of_head).collect()
}

/// The lines: one of each file, unless the survey file says otherwise.
fn lines(
    path: &Path,
    file: &mut SeabedSurveyFile,
    given: &Given,
    names: &[String],
    observed: &Observed,
) -> Vec<Problem> {
    if !given.lines {
        let line = |(name, of): (&String, &ObservedFile)| {
            let (start_s, end_s) = of.span_s?;
            let stem = Path::new(name).file_stem().unwrap_or_default();
            let stem = stem.to_string_lossy().into_owned();
            Some(LineSection::new(stem, vec![name.clone()], [start_s, end_s]))
        };
        let each = names.iter().zip(&observed.files);
        file.line = each.filter_map(line).collect();
        own_names(&mut file.line);
        return vec![];
    }
    let mut problems = vec![];
    for line in file.line.iter_mut().filter(|line| !line.files.is_empty()) {
        (line.start_s, line.end_s) = (f64::INFINITY, f64::NEG_INFINITY);
        for wanted in &line.files {
            let is = |name: &&String| {
                *name == wanted || Path::new(name).file_name() == Path::new(wanted).file_name()
            };
            let at = names.iter().position(|name| is(&name));
            match at.and_then(|k| observed.files[k].span_s) {
                Some((first_s, last_s)) => {
                    line.start_s = line.start_s.min(first_s);
                    line.end_s = line.end_s.max(last_s);
                }
                None => {
                    let found = format!("\"{wanted}\" of line \"{}\"", line.name);
                    problems.push(Problem::new(
                        path,
                        "[[line]] files",
                        found,
                        "files of [multibeam]",
                    ));
                }
            }
        }
    }
    problems
}

/// Files of one name in several folders get a number.
fn own_names(lines: &mut [LineSection]) {
    for k in 1..lines.len() {
        let name = lines[k].name.clone();
        if lines[..k].iter().any(|line| line.name == name) {
            lines[k].name = format!("{name} ({})", k + 1);
        }
    }
}

/// The first file, which messages name.
fn first_of(paths: &[PathBuf]) -> &Path {
    paths.first().map_or(Path::new(""), PathBuf::as_path)
}

/// The casts, each once, in order of time.
fn casts(
    file: &SeabedSurveyFile,
    folder: &Path,
    observed: &Observed,
    paths: &[PathBuf],
) -> Result<Vec<(Option<f64>, SoundSpeedProfile)>, SurveyError> {
    if !file.cast.is_empty() {
        let casts = super::casts::read(file, folder)?;
        return Ok(casts.into_iter().map(|(t, c)| (Some(t), c)).collect());
    }
    if let Some(profile) = &file.sound_speed.profile {
        return Ok(vec![(None, sound_speed_csv::read(&folder.join(profile))?)]);
    }
    let all = observed.recorded.casts();
    if all.is_empty() {
        let of = first_of(paths);
        let expected = "a CSV with depth_m, sound_speed_m_s as [sound_speed] profile";
        return Err(Problem::new(of, "sound speed", "no sound-speed profile", expected).into());
    }
    let cast = |p: &Profile| {
        let profile = SoundSpeedProfile {
            depth_m: p.depth_m.clone(),
            speed_m_s: p.speed_m_s.clone(),
        };
        (Some(p.time_s), profile)
    };
    Ok(all.into_iter().map(cast).collect())
}

/// Which cast each line has: the last that was taken before its begin, the first where none was.
pub(super) fn cast_of(casts: &[(Option<f64>, SoundSpeedProfile)], start_s: f64) -> usize {
    let before = |cast: &&(Option<f64>, SoundSpeedProfile)| cast.0.is_none_or(|t| t <= start_s);
    casts.iter().filter(before).count().saturating_sub(1)
}

/// Origin and water level where the survey file does not give them: the mean water line over the lines, less the tide, is height zero.
fn level(
    file: &mut SeabedSurveyFile,
    given: &Given,
    installation: Option<&Installation>,
    (records, tide): (&TrajectoryRecords, Option<&TideCurve>),
    notes: &mut Vec<String>,
) {
    // heights above the ellipsoid have the tide in them, those of the heave have not
    let above_water = file.trajectory.above_water();
    let tide_m = |line: &LineSection, t: f64| match above_water {
        true => 0.0,
        false => tide.map_or(line.tide_m, |curve| curve.at(t)),
    };
    let on_line = |t: f64| {
        let mut lines = file.line.iter();
        lines.find(|l| t >= l.start_s && t <= l.end_s)
    };
    let mut heights = Moments::new(1);
    for (time_s, height_m) in records.time_s.iter().zip(&records.height_m) {
        if let Some(line) = on_line(*time_s) {
            heights.add(&[height_m - tide_m(line, *time_s)]);
        }
    }
    let water_line_m = installation.and_then(|record| record.water_line_m);
    if water_line_m.is_none() {
        notes.push(
            "no water line in the files: the reference point is taken to lie at the water level"
                .to_owned(),
        );
    }
    let mean_m = heights.mean().map_or(0.0, |mean| mean[0]);
    let level_m = mean_m + water_line_m.unwrap_or(0.0);
    let origin = &mut file.site.origin;
    if !given.origin {
        let first = |column: &[f64]| column.first().map_or(0.0, |angle| degrees(*angle));
        let rounded = |angle: f64| (1e4 * angle).round() / 1e4;
        origin.latitude_deg = rounded(first(&records.latitude_rad));
        origin.longitude_deg = rounded(first(&records.longitude_rad));
        origin.height_m = (1e3 * level_m).round() / 1e3;
    }
    if !given.level {
        file.site.water_level_m = (1e3 * (level_m - origin.height_m)).round() / 1e3;
    }
    if above_water {
        let tide = match tide {
            Some(_) => "the tide lifts them, the heights of the lines take up the rest",
            None => "the heights of the lines take up the tide",
        };
        notes.push(format!(
            "heights are the heave above the water level: {tide}"
        ));
    }
    for line in &file.line {
        let (begin, end) = (utc::written(line.start_s), utc::written(line.end_s));
        notes.push(format!("line \"{}\": {begin} to {end} UTC", line.name));
    }
}

/// Where the survey file wants the heights from.
pub(super) fn heights(file: &SeabedSurveyFile) -> Heights {
    if file.trajectory.above_water() {
        Heights::Heave
    } else {
        Heights::Ellipsoid
    }
}
