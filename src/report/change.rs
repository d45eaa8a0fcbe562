//! A comparison of two calibrations for the terminal; no line is wider than 80 columns.

use super::format::probability;
use super::text::wrapped;
use crate::results::Change;
use crate::ruled::Ruled;
use crate::units::with_sigma;

/// The bytes for `--json`.
///
/// # Errors
/// None for a [`Change`] made by this program; `serde_json` does not promise it.
pub fn to_bytes(change: &Change) -> serde_json::Result<Vec<u8>> {
    super::json::lines(change)
}

/// The answer, the parameters, the test of all together, the notes. Ends with a newline.
#[must_use]
pub fn summary(change: &Change) -> String {
    let answer = match change.changed {
        true => "The mounting has changed.",
        false => "No change of the mounting beyond what both uncertainties explain.",
    };
    let mut table =
        Ruled::new(["parameter", "after - before ± 1 sigma", "sigmas", ""]).numbers(1..3);
    for p in &change.parameters {
        table.row([
            format!("{}, {}", p.name, p.unit),
            with_sigma(p.change, p.sigma),
            format!("{:.1}", p.in_sigmas),
            if p.changed { "changed" } else { "" }.to_owned(),
        ]);
    }
    let test = wrapped(&format!(
        "All together: chi-square {:.1} on {} degrees of freedom, {}; error probability of the comparison {} %.",
        change.chi_square,
        change.degrees_of_freedom,
        probability(change.p_value),
        100.0 * change.significance
    ));
    let notes = change
        .notes
        .iter()
        .map(|note| wrapped(&format!("Note: {note}.")));
    let parts = [answer.to_owned(), table.to_string(), test]
        .into_iter()
        .chain(notes);
    parts
        .map(|p| p.trim_end().to_owned())
        .collect::<Vec<_>>()
        .join("\n\n")
        + "\n"
}
