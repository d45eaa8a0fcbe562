//! Which heads of a sounder a survey calibrates, and which number each has.

use std::path::Path;

use super::file::{HeadSection, SeabedSurveyFile};
use crate::formats::SoundingRecords;
use crate::recorders::Observed;
use crate::survey::problem::{Problem, SurveyError};
use crate::survey::sections::MountingAngles;

/// Most heads of a survey.
const MOST: usize = 8;

/// The heads of recorder files: those of the survey file; all where it names none, with mountings that the installation record is to
/// supply. Their numbers, the first one's first, and what is to be said.
pub(super) fn of_recorders(
    path: &Path,
    file: &mut SeabedSurveyFile,
    observed: &Observed,
) -> Result<(Vec<u32>, Vec<String>), SurveyError> {
    let there = observed.heads();
    if there.is_empty() {
        let valid = "beams that the sounder holds valid";
        return Err(Problem::new(path, "[multibeam] paths", "none", valid).into());
    }
    if file.multibeam.head.is_none() && file.head.is_empty() {
        file.head = there[1..].iter().map(|number| unplaced(*number)).collect();
    }
    let chosen = chosen(path, file, &there)?;
    let said = said(&chosen, &there, &observed.soundings.head);
    Ok((chosen, said))
}

/// A head of which nothing but its number is known yet.
fn unplaced(number: u32) -> HeadSection {
    let mounting_deg = MountingAngles {
        roll: 0.0,
        pitch: 0.0,
        heading: 0.0,
    };
    HeadSection {
        number,
        lever_arm_m: [0.0; 3],
        lever_arm_sigma_m: [0.005, 0.005, 0.01],
        mounting_deg,
        receiver_lever_arm_m: None,
        receiver_mounting_deg: None,
    }
}

/// The heads of a CSV: those of the survey file. What is of another head is left out, and said.
pub(super) fn of_columns(
    path: &Path,
    soundings: &Path,
    file: &mut SeabedSurveyFile,
    records: &SoundingRecords,
) -> Result<Vec<String>, SurveyError> {
    let there = records.heads();
    if there.is_empty() {
        if file.multibeam.head.is_some() || !file.head.is_empty() {
            let expected = "a column head with the number of each sounding's head";
            return Err(Problem::new(soundings, "column head", "nothing", expected).into());
        }
        return Ok(vec![]);
    }
    let chosen = chosen(path, file, &there)?;
    Ok(said(&chosen, &there, &records.head))
}

/// The numbers of the heads that the survey file wants, the first one's first.
fn chosen(
    path: &Path,
    file: &mut SeabedSurveyFile,
    there: &[u32],
) -> Result<Vec<u32>, SurveyError> {
    let listed: Vec<String> = there.iter().map(u32::to_string).collect();
    let listed = listed.join(", ");
    let further: Vec<u32> = file.head.iter().map(|head| head.number).collect();
    let others: Vec<u32> = there
        .iter()
        .copied()
        .filter(|n| !further.contains(n))
        .collect();
    let first = match (file.multibeam.head, others.as_slice()) {
        (Some(first), _) => first,
        (None, [only]) => *only,
        (None, _) => {
            let found = format!("soundings of the heads {listed}");
            let expected = "[[head]] with the number of each further one, or head = the one to be calibrated alone";
            return Err(Problem::new(path, "[multibeam] head", found, expected).into());
        }
    };
    let all: Vec<u32> = std::iter::once(first).chain(further).collect();
    for (k, number) in all.iter().enumerate() {
        let place = if k == 0 {
            "[multibeam] head"
        } else {
            "[[head]] number"
        };
        if !there.contains(number) {
            let found = format!("head {number}; the files have {listed}");
            return Err(Problem::new(path, place, found, "a head that is in the files").into());
        }
        if all[..k].contains(number) {
            let found = format!("head {number} twice");
            return Err(Problem::new(path, place, found, "a number of its own for each").into());
        }
    }
    if all.len() > MOST {
        let found = format!("{} heads", all.len());
        let expected = format!("at most {MOST}");
        return Err(Problem::new(path, "[[head]]", found, expected).into());
    }
    file.multibeam.head = Some(first);
    Ok(all)
}

/// How many soundings each head has where there are several, and which heads are left out, in words; `of` is the head of each sounding.
fn said(chosen: &[u32], there: &[u32], of: &[u32]) -> Vec<String> {
    let mut notes = vec![];
    let count = |head: u32| of.iter().filter(|h| **h == head).count();
    let each = |heads: &[u32]| -> String {
        let words = |head: &u32| format!("{} of head {head}", count(*head));
        heads.iter().map(words).collect::<Vec<_>>().join(", ")
    };
    if chosen.len() > 1 {
        notes.push(format!(
            "{} heads are calibrated together, each with its own mounting; soundings: {}",
            chosen.len(),
            each(chosen)
        ));
    }
    let others: Vec<u32> = there
        .iter()
        .copied()
        .filter(|n| !chosen.contains(n))
        .collect();
    if !others.is_empty() {
        let numbers: Vec<String> = chosen.iter().map(|n| format!("head {n}")).collect();
        let verb = if chosen.len() > 1 { "are" } else { "is" };
        notes.push(format!(
            "{} {verb} calibrated; soundings of the other heads are left out: {}; name each as [[head]] to calibrate them together",
            numbers.join(", "),
            each(&others)
        ));
    }
    notes
}
