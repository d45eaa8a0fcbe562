//! Whether a file is a survey or a scenario.

use toml::de::DeTable;

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
        assert!(is_survey("procedure = \"x\"\n[target]\n"));
        assert!(!is_survey("procedure = \"x\"\nseed = 1\n"));
        assert!(!is_survey("name = \"x\"\n"));
    }
}
