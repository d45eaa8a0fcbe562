//! The recorder files that a survey file names, read together.

use std::path::{Path, PathBuf};

use crate::formats::recorder::table;
use crate::recorders::Observed;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};

/// The recorder files that a survey file names, as it names them; nothing where its soundings are no recorder's.
pub(crate) fn recorder_files(
    document: &Document<'_>,
    folder: &Path,
) -> Result<Option<Vec<String>>, SurveyError> {
    let several = document.get(&["multibeam", "paths"]);
    let several = several.and_then(|value| value.get_ref().as_array());
    let listed: Vec<String> = several
        .into_iter()
        .flat_map(|list| list.iter())
        .filter_map(|item| Some(item.get_ref().as_str()?.to_owned()))
        .collect();
    let single = document.string(&["multibeam", "path"]);
    match (single, listed.is_empty()) {
        (Some(_), false) => Err(document
            .problem(
                &["multibeam", "paths"],
                "both path and paths",
                "one of them",
            )
            .into()),
        (None, false) => Ok(Some(listed)),
        (Some(name), true) if folder.join(name).is_dir() => in_folder(document, folder, name),
        (Some(name), true) if table::is_recorder(&folder.join(name)) => {
            Ok(Some(vec![name.to_owned()]))
        }
        _ => Ok(None),
    }
}

/// The recorder files of a folder by name.
fn in_folder(
    document: &Document<'_>,
    folder: &Path,
    name: &str,
) -> Result<Option<Vec<String>>, SurveyError> {
    let key = ["multibeam", "path"];
    let unreadable = |error: std::io::Error| {
        document.problem(&key, format!("\"{name}\": {error}"), "a readable folder")
    };
    let mut found = vec![];
    for entry in std::fs::read_dir(folder.join(name)).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.is_file() && table::is_recorder(&path) {
            let own = path.file_name().unwrap_or_default().to_string_lossy();
            found.push(format!("{}/{own}", name.trim_end_matches('/')));
        }
    }
    found.sort();
    if found.is_empty() {
        let what = format!("\"{name}\", a folder without a recorder's file");
        return Err(document
            .problem(&key, what, "a folder of recorder files")
            .into());
    }
    Ok(Some(found))
}

/// Reads all files of a survey.
///
/// # Errors
/// [`SurveyError`] with every file that cannot be read or has no soundings of its own.
pub(crate) fn read_all(paths: &[PathBuf]) -> Result<Observed, SurveyError> {
    let (mut observed, mut problems) = (Observed::default(), vec![]);
    for path in paths {
        if let Err(error) = observed.read(path) {
            problems.push(Problem::from(error));
        }
    }
    let unfit = observed.files.iter().filter_map(|file| {
        let refusal = file.summary.refusal.clone();
        let none = if observed.repeated_pings > 0 {
            "no pings of its own, all are in another file too"
        } else {
            "no pings in the file"
        };
        let reason = refusal.or_else(|| file.span_s.is_none().then(|| none.to_owned()))?;
        let expected =
            "soundings with angles and travel times (navigation belongs under [trajectory] path)";
        Some(Problem::new(&file.path, "whole file", reason, expected))
    });
    problems.extend(unfit);
    none_of(problems)?;
    Ok(observed)
}

/// What was lost or odd in the files, and notes of their readers.
pub(crate) fn losses(observed: &Observed) -> Vec<String> {
    let mut notes: Vec<String> = vec![];
    for file in &observed.files {
        let name = file.path.file_name().unwrap_or_default().to_string_lossy();
        for (what, count) in file.summary.losses.lines() {
            notes.push(format!("{name}: {count} {what}"));
        }
        for said in file.summary.notes.iter().chain(&file.summary.applied) {
            if !notes.contains(said) {
                notes.push(said.clone());
            }
        }
    }
    notes
}

/// Recorder files that are not there.
pub(crate) fn missing_recorders(
    document: &Document<'_>,
    folder: &Path,
    names: &[String],
) -> Vec<Problem> {
    let missing = |name: &&String| !folder.join(name).is_file();
    let problem = |name: &String| {
        let found = format!("\"{name}\", no such file");
        let expected = "a readable file, its path relative to the survey file";
        document.problem(&["multibeam", "paths"], found, expected)
    };
    names.iter().filter(missing).map(problem).collect()
}

/// What is wrong with recorder files, as comments of a survey file that is made from them.
pub(crate) fn lacking(error: &SurveyError) -> String {
    let line = |problem: &Problem| {
        let file = problem.file.display();
        format!(
            "# - {file}: found {}, expected {}\n",
            problem.found, problem.expected
        )
    };
    error.problems.iter().map(line).collect()
}
