//! Which calibration a file is for.

use std::path::Path;

use toml::de::DeTable;

/// The procedures that are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Procedure {
    /// A multibeam against a target in a pool.
    Pool,
    /// An ultra-short baseline transducer against beacons.
    Usbl,
    /// Profilers on a measuring beam against a standard rail.
    Rail,
}

/// What the key `procedure` of a survey or scenario file names.
///
/// [`Procedure::Pool`] for everything else: a pool scenario has no such key, and the reader of pool files says what is wrong with a
/// file that cannot be read or names a procedure that is not built.
#[must_use]
pub fn procedure_of(file: &Path) -> Procedure {
    std::fs::read_to_string(file).map_or(Procedure::Pool, |text| procedure_in(&text))
}

/// As [`procedure_of`], for a text.
#[must_use]
pub fn procedure_in(text: &str) -> Procedure {
    let (root, _) = DeTable::parse_recoverable(text);
    match root
        .get_ref()
        .get("procedure")
        .and_then(|value| value.get_ref().as_str())
    {
        Some("usbl") => Procedure::Usbl,
        Some("rail") => Procedure::Rail,
        _ => Procedure::Pool,
    }
}

/// Keys that only a scenario has.
pub(crate) const OF_SCENARIO: [&str; 4] = ["seed", "pass", "motion", "truth"];

/// Whether a text is a survey file (what was measured) rather than a scenario: it names its procedure and no truth.
#[must_use]
pub fn is_survey(text: &str) -> bool {
    let (root, _) = DeTable::parse_recoverable(text);
    let has = |key: &&str| root.get_ref().contains_key(*key);
    has(&"procedure") && !OF_SCENARIO.iter().any(has)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_names_its_procedure_and_no_truth() {
        assert!(is_survey("procedure = \"pool\"\n[target]\n"));
        assert!(!is_survey("procedure = \"usbl\"\nseed = 1\n"));
        assert!(!is_survey("name = \"x\"\n"));
    }

    #[test]
    fn a_file_says_what_it_is_for_even_when_it_is_damaged() {
        let usbl = "name = \"x\"\nprocedure = \"usbl\"\n";
        assert_eq!(procedure_in(usbl), Procedure::Usbl);
        assert_eq!(procedure_in(&format!("{usbl}broken =\n")), Procedure::Usbl);
        assert_eq!(procedure_in("procedure = \"rail\""), Procedure::Rail);
        assert_eq!(procedure_in("procedure = \"seabed\""), Procedure::Pool);
        assert_eq!(procedure_in("[pass]\n"), Procedure::Pool);
        assert_eq!(procedure_of(Path::new("no such file")), Procedure::Pool);
    }
}
