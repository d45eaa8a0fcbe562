//! Nominal mountings: what the survey file leaves out, the installation record of the files says.

use std::path::Path;

use crate::formats::recorder::{Array, Installation};
use crate::observe::Mounting;
use crate::recorders::Observed;
use crate::recorders::observed::ObservedFile;
use crate::survey::problem::{Problem, SurveyError};
use crate::survey::sections::MountingAngles;
use crate::units::degrees;

/// What the survey file gives of a head.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Placed {
    /// `lever_arm_m`.
    pub(crate) arm: bool,
    /// `mounting_deg`.
    pub(crate) mounting: bool,
}

/// Mounting angles as they stand in a survey file.
pub(crate) fn inline(angles: &MountingAngles) -> String {
    let MountingAngles {
        roll,
        pitch,
        heading,
    } = angles;
    format!("{{ roll = {roll}, pitch = {pitch}, heading = {heading} }}")
}

/// The installation record of all files.
///
/// # Errors
/// [`SurveyError`] where files of one survey are of different mountings, or two heads have one serial number.
pub(crate) fn installation(observed: &Observed) -> Result<Option<Installation>, SurveyError> {
    let with = |file: &&ObservedFile| file.installation.is_some();
    let mut files = observed.files.iter().filter(with);
    let Some(first) = files.next() else {
        return Ok(None);
    };
    let places = |record: &Option<Installation>| -> Vec<Array> {
        record
            .as_ref()
            .map(|r| r.arrays.clone())
            .unwrap_or_default()
    };
    for other in files {
        if places(&other.installation) != places(&first.installation) {
            let found = format!("arrays mounted differently from {}", first.path.display());
            let expected = "lines of one mounting";
            return Err(Problem::new(&other.path, "installation record", found, expected).into());
        }
    }
    let record = first.installation.clone();
    twice(&first.path, record.as_ref())?;
    Ok(record)
}

/// Refuses two heads under one serial number: which of them a sounding is of cannot be told.
fn twice(path: &Path, record: Option<&Installation>) -> Result<(), SurveyError> {
    let arrays = record.map(|r| r.arrays.as_slice()).unwrap_or_default();
    for (k, array) in arrays.iter().enumerate() {
        let same = |other: &&Array| other.head == array.head && other.role == array.role;
        if array.head != 0 && arrays[..k].iter().any(|other| same(&other)) {
            let found = format!("two heads with the serial number {}", array.head);
            let expected = "a serial number of its own for each head";
            return Err(Problem::new(path, "installation record", found, expected).into());
        }
    }
    Ok(())
}

/// A head in the survey file, and what the file itself gives of it.
pub(crate) struct OfFile<'f> {
    /// Its serial number, or its index.
    pub(crate) number: u32,
    /// Its number in words where there are several.
    pub(crate) words: String,
    /// Lever arm, and that of the receive array.
    pub(crate) arm: (&'f mut [f64; 3], &'f mut Option<[f64; 3]>),
    /// Mounting angles, and those of the receive array.
    pub(crate) angles: (&'f mut MountingAngles, &'f mut Option<MountingAngles>),
    /// What of it the survey file gives.
    pub(crate) given: Placed,
}

/// The nominal mounting of a head: the survey file's, else the installation record's; a difference between them is said.
pub(crate) fn mounting(
    path: &Path,
    head: OfFile<'_>,
    installation: Option<&Installation>,
    notes: &mut Vec<String>,
) -> Vec<Problem> {
    let OfFile {
        number,
        words,
        arm,
        angles,
        given,
    } = head;
    let arrays = installation.and_then(|record| {
        let mounting = |array: Option<&Array>| Some(array?.mounted.mounting);
        Some((
            mounting(record.transmitter(number))?,
            mounting(record.receiver(number))?,
        ))
    });
    let Some((transmitter, receiver)) = arrays else {
        let lacking = [("lever_arm_m", given.arm), ("mounting_deg", given.mounting)];
        let missing = lacking.iter().filter(|key| !key.1);
        let found = format!("no installation record that says how head {number} is mounted");
        let problem = |key: &(&str, bool)| {
            Problem::new(
                path,
                "[multibeam]",
                found.clone(),
                format!("{} in the survey file", key.0),
            )
        };
        return missing.map(problem).collect();
    };
    for (array, mounting) in [("transmit", &transmitter), ("receive", &receiver)] {
        notes.push(format!(
            "installation record, {words}{array} array: {}",
            in_words(mounting)
        ));
    }
    if given.arm {
        let key = format!("{words}lever_arm_m");
        note_difference(notes, &key, *arm.0, arm_of(&transmitter), 1e-4);
    } else {
        *arm.0 = arm_of(&transmitter);
        arm.1.get_or_insert(arm_of(&receiver));
    }
    if given.mounting {
        let own = [angles.0.roll, angles.0.pitch, angles.0.heading];
        let theirs = angles_of(&transmitter);
        let theirs = [theirs.roll, theirs.pitch, theirs.heading];
        note_difference(notes, &format!("{words}mounting_deg"), own, theirs, 1e-3);
    } else {
        *angles.0 = angles_of(&transmitter);
        angles.1.get_or_insert(angles_of(&receiver));
    }
    vec![]
}

fn note_difference(notes: &mut Vec<String>, key: &str, own: [f64; 3], theirs: [f64; 3], tell: f64) {
    if own.iter().zip(theirs).any(|(a, b)| (a - b).abs() > tell) {
        notes.push(format!(
            "{key} of the survey file, {own:?}, is used; the installation record says {theirs:?}"
        ));
    }
}

/// The lever arm (right, forward, up), metres.
pub(crate) fn arm_of(mounting: &Mounting) -> [f64; 3] {
    // free of the rounding noise of sums and minus zero
    mounting
        .lever_arm_m
        .map(|v| (1e6 * v).round() / 1e6 + 0.0)
        .into()
}

/// The angles, degrees.
pub(crate) fn angles_of(mounting: &Mounting) -> MountingAngles {
    let (roll, pitch, heading) = mounting.angles();
    let [roll, pitch, heading] =
        [roll, pitch, heading].map(|angle| (1e9 * degrees(angle)).round() / 1e9 + 0.0);
    MountingAngles {
        roll,
        pitch,
        heading,
    }
}

fn in_words(mounting: &Mounting) -> String {
    let ([right, forward, up], angles) = (arm_of(mounting), angles_of(mounting));
    let MountingAngles {
        roll,
        pitch,
        heading,
    } = angles;
    format!(
        "{right:.3} m right, {forward:.3} m forward, {up:.3} m up; roll {roll:.3}, pitch {pitch:.3}, heading {heading:.3} deg"
    )
}
