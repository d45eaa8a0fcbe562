//! From the key `procedure` of a file to the procedure.

use std::path::Path;

use toml::de::DeTable;

use super::ALL;
use crate::calibrate::seam::{InputError, Loaded, Procedure, ScenarioRun};
use crate::formats::{FORMATS, Format};
use crate::survey::document::Document;
use crate::survey::reading::read_text;
use crate::survey::schema::nearest;
use crate::survey::{Problem, SurveyError};

/// The key that names the procedure.
const KEY: &str = "procedure";

/// Names of all procedures, in the order of [`ALL`].
#[must_use]
pub fn names() -> Vec<&'static str> {
    ALL.iter().map(|procedure| procedure.name()).collect()
}

/// Every format that is read: those of the table, then each procedure's own.
pub fn formats() -> impl Iterator<Item = &'static Format> {
    let own = ALL.iter().flat_map(|procedure| procedure.formats());
    FORMATS.iter().chain(own)
}

/// Whether the text of a file is a survey (what was measured) rather than a scenario; `file` names it in messages.
#[must_use]
pub fn is_survey(file: &Path, text: &str) -> bool {
    // a scenario may lack every key that only scenarios have
    crate::survey::is_survey(text) && scenario_text(file, text).is_err()
}

/// The procedure of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static dyn Procedure> {
    ALL.iter()
        .copied()
        .find(|procedure| procedure.name() == name)
}

/// Reads a survey file, of whichever procedure it names.
///
/// # Errors
/// [`InputError`] with everything that is wrong; a file that names no procedure or an unknown one is refused.
pub fn read(survey: &Path) -> Result<Box<dyn Loaded>, InputError> {
    of_file(survey)?.read(survey)
}

/// Reads a scenario file, of whichever procedure it names.
///
/// # Errors
/// As [`read`].
pub fn scenario(file: &Path) -> Result<Box<dyn ScenarioRun>, InputError> {
    scenario_text(file, &read_text(file)?)
}

/// Reads the text of a scenario, of whichever procedure it names; `file` names it in messages, and files that it names are looked for
/// beside it.
///
/// # Errors
/// As [`read`].
pub fn scenario_text(file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError> {
    of_text(file, text)?.scenario(file, text)
}

/// The procedure that a survey or scenario file names.
///
/// # Errors
/// [`SurveyError`] with the list of procedures and the nearest one; never a guess.
pub fn of_file(file: &Path) -> Result<&'static dyn Procedure, SurveyError> {
    of_text(file, &read_text(file)?)
}

/// As [`of_file`], for a text; `file` names it in messages.
///
/// # Errors
/// As [`of_file`].
pub fn of_text(file: &Path, text: &str) -> Result<&'static dyn Procedure, SurveyError> {
    let (root, _) = DeTable::parse_recoverable(text);
    let value = root
        .get_ref()
        .get(KEY)
        .map(|value| value.get_ref().as_str());
    if let Some(found) = value.flatten().and_then(find) {
        return Ok(found);
    }
    let document = Document::parse(file, text).map_err(|problems| SurveyError { problems })?;
    Err(match value {
        None => document.problem(&[KEY], "nothing", expected(None)).into(),
        Some(None) => {
            let found = "a value that is not text";
            document.problem(&[KEY], found, expected(None)).into()
        }
        Some(Some(name)) => mistyped(&document, file, name),
    })
}

/// An unknown name, together with everything else that is wrong with the file as the nearest procedure reads it.
fn mistyped(document: &Document<'_>, file: &Path, name: &str) -> SurveyError {
    let near = nearest(name, names().into_iter());
    let found = format!("\"{name}\"");
    let mut problems = vec![document.problem(&[KEY], found, expected(near))];
    let read = near.and_then(find).map(|procedure| procedure.read(file));
    if let Some(Err(InputError::Survey(error))) = read {
        let other = |problem: &Problem| !problem.place.ends_with(KEY);
        problems.extend(error.problems.into_iter().filter(other));
    }
    SurveyError { problems }
}

/// What the key should hold.
fn expected(nearest: Option<&str>) -> String {
    let quoted: Vec<String> = names().iter().map(|name| format!("\"{name}\"")).collect();
    let list = quoted.join(", ");
    match nearest {
        Some(nearest) => format!("one of {list} (nearest: \"{nearest}\")"),
        None => format!("one of {list}, such as the line: {KEY} = {}", quoted[0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        match of_text(Path::new("x.toml"), text) {
            Ok(found) => panic!("read as {}", found.name()),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_file_says_what_it_is_for_even_when_it_is_damaged() {
        for procedure in ALL {
            let text = format!(
                "name = \"x\"\nprocedure = \"{}\"\nbroken =\n",
                procedure.name()
            );
            let found = of_text(Path::new("x.toml"), &text).expect("a procedure");
            assert_eq!(found.name(), procedure.name());
        }
    }

    #[test]
    fn a_missing_or_mistyped_procedure_is_never_read_as_a_pool() {
        let missing = refused("[pass]\n");
        assert!(
            missing.contains("procedure: found nothing")
                && missing.contains("procedure = \"pool\"")
        );
        let mistyped = refused("procedure = \"ubsl\"\n");
        assert!(mistyped.contains("found \"ubsl\"") && mistyped.contains("nearest: \"usbl\""));
        assert!(refused("procedure = 3\n").contains("not text"));
        assert!(refused("broken =\n").contains("TOML"));
    }

    #[test]
    fn a_built_in_scenario_is_no_survey_even_without_a_seed() {
        for procedure in ALL {
            let demo = procedure.demo();
            let lines = demo.lines().filter(|line| !line.starts_with("seed"));
            let text: String = lines.map(|line| format!("{line}\n")).collect();
            assert!(!is_survey(Path::new("x.toml"), &text), "{text}");
        }
        assert!(is_survey(
            Path::new("x.toml"),
            &format!("{KEY} = \"{}\"\n[target]\n", names()[0])
        ));
    }

    #[test]
    fn names_are_unique_and_found() {
        for name in names() {
            assert_eq!(find(name).map(Procedure::name), Some(name));
        }
        let mut sorted = names();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), ALL.len());
    }
}
