//! The values to enter in other forms: a table for a paper, the card as CSV, and text cards in the senses of other programs.

use std::fmt::Write;

use super::card::{Card, card};
use super::text::wrapped;
use crate::results::{Calibration, Convention, ConventionField};
use crate::ruled::Ruled;

/// A form that a calibration can be handed on in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Export {
    /// A LaTeX table.
    Latex,
    /// The values to enter and nothing else, as CSV.
    Csv,
    /// A text card for a CARIS vessel file.
    Hvf,
    /// A text card for QPS Qinsy and Qimera.
    Qimera,
    /// A text card for Kongsberg SIS.
    Sis,
    /// A text card for an Applanix POS MV.
    Applanix,
    /// A text card for NovAtel's SPAN and Inertial Explorer.
    Novatel,
}

impl Export {
    /// Every form.
    pub const ALL: [Self; 7] = [
        Self::Latex,
        Self::Csv,
        Self::Hvf,
        Self::Qimera,
        Self::Sis,
        Self::Applanix,
        Self::Novatel,
    ];

    /// The file that it is written to.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Latex => "table.tex",
            Self::Csv => "card.csv",
            Self::Hvf => "card-hvf.txt",
            Self::Qimera => "card-qimera.txt",
            Self::Sis => "card-sis.txt",
            Self::Applanix => "card-applanix.txt",
            Self::Novatel => "card-novatel.txt",
        }
    }

    /// What the name of the program begins with among the result's conventions; `None` for a form of our own.
    fn software(self) -> Option<&'static str> {
        match self {
            Self::Latex | Self::Csv => None,
            Self::Hvf => Some("Teledyne CARIS"),
            Self::Qimera => Some("QPS"),
            Self::Sis => Some("Kongsberg"),
            Self::Applanix => Some("Applanix"),
            Self::Novatel => Some("NovAtel"),
        }
    }

    /// The text of the file; of a result that is not usable it says that there is nothing to enter, and why.
    #[must_use]
    pub fn text(self, result: &Calibration, title: &str) -> String {
        let Some(values) = card(result) else {
            return nothing(self, result, title);
        };
        match (self, self.software()) {
            (Self::Latex, _) => latex(&values, title),
            (_, Some(software)) => other(result, title, software, &values),
            _ => csv(&values),
        }
    }
}

/// Nothing to enter.
fn nothing(form: Export, result: &Calibration, title: &str) -> String {
    let why = result.reason.as_deref().unwrap_or("no solution is usable");
    let text = format!("{title}: nothing to enter, no usable result: {why}");
    match form {
        Export::Latex => format!("% {}\n", text.replace('\n', " ")),
        Export::Csv => format!("{CSV_HEAD}\n"),
        _ => wrapped(&text) + "\n",
    }
}

const CSV_HEAD: &str = "name,unit,before,after,sigma,positive";

fn csv(card: &Card) -> String {
    let mut text = format!("{CSV_HEAD}\n");
    for row in &card.rows {
        let cells = [&row.name, &row.unit, &row.before, &row.after, &row.sigma];
        let cells: Vec<String> = cells.iter().map(|c| super::csv::quoted(c)).collect();
        let positive = super::csv::quoted(&row.positive);
        let _ = writeln!(text, "{},{positive}", cells.join(","));
    }
    text
}

/// A table with rules of the package booktabs.
fn latex(card: &Card, title: &str) -> String {
    let mut text = format!(
        "% {}\n% needs \\usepackage{{booktabs}}\n\\begin{{tabular}}{{llrrr}}\n\\toprule\n\
         parameter & unit & before & after & $\\sigma$ \\\\\n\\midrule\n",
        title.replace(['\n', '\r'], " ")
    );
    for row in &card.rows {
        let unit = match row.unit.as_str() {
            "deg" => "\\textdegree".to_owned(),
            unit => escaped(unit),
        };
        let cells = [&row.before, &row.after, &row.sigma].map(|c| figure(c));
        let name = escaped(&row.name);
        let _ = writeln!(text, "{name} & {unit} & {} \\\\", cells.join(" & "));
    }
    text + "\\bottomrule\n\\end{tabular}\n"
}

/// A number with a real minus sign; words as they are.
fn figure(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(_) => format!("${cell}$"),
        Err(_) => escaped(cell),
    }
}

fn escaped(words: &str) -> String {
    let mut text = String::new();
    for letter in words.chars() {
        match letter {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                text.push('\\');
                text.push(letter);
            }
            '\\' => text.push_str("\\textbackslash{}"),
            '~' => text.push_str("\\textasciitilde{}"),
            '^' => text.push_str("\\textasciicircum{}"),
            letter => text.push(letter),
        }
    }
    text
}

/// A card in another program's sense.
fn other(result: &Calibration, title: &str, software: &str, values: &Card) -> String {
    let entries = || {
        let all = result.conventions.iter();
        all.filter(|c| c.software.starts_with(software))
    };
    let mut parts = vec![format!(
        "{title}: values to enter, {} solution",
        values.solution.replace('_', " ")
    )];
    if let Some(found) = result.verdict.findings.first() {
        let seen = found.seen.trim_end_matches('.');
        parts.push(wrapped(&format!("Check before entering: {seen}.")));
    }
    if entries().next().is_none() {
        parts.push(wrapped(
            "This result has no lever arm: there is no record of a sonar head to enter.",
        ));
    }
    parts.extend(entries().map(|entry| conventional(entry, values)));
    if entries().any(left_out) {
        parts.push(on_board());
    }
    parts.join("\n\n") + "\n"
}

fn left_out(entry: &Convention) -> bool {
    entry.angles_deg.iter().any(|f| f.value.is_none())
}

fn conventional(entry: &Convention, values: &Card) -> String {
    let mut table = Ruled::new(["field", "enter", "positive"]).numbers(1..2);
    let fields = entry.angles_deg.iter().map(|f| (f, "deg"));
    for (field, unit) in fields.chain(entry.lever_arm_m.iter().map(|f| (f, "m"))) {
        table.row([
            format!("{}, {unit}", field.name),
            value(field),
            field.positive.clone(),
        ]);
    }
    let sigmas: Vec<String> = values
        .rows
        .iter()
        .filter(|row| row.record.is_empty() || row.record == entry.mounting)
        .filter(|row| !row.sigma.is_empty())
        .map(|row| {
            let number = row.sigma.parse::<f64>().is_ok();
            let unit = if number { row.unit.as_str() } else { "" };
            format!("{} {} {unit}", row.name, row.sigma)
                .trim_end()
                .to_owned()
        })
        .collect();
    let lines = [
        wrapped(&format!("{}: {}", entry.software, entry.mounting)),
        wrapped(&entry.axes),
        table.to_string(),
        wrapped(&format!(
            "One sigma, in boresight's names: {}.",
            sigmas.join(", ")
        )),
        wrapped(&entry.remark),
        wrapped(
            "Lever arms run from the INS centre; another reference point needs its own offset.",
        ),
        wrapped(&format!("Source: {}.", entry.sources.join("; "))),
    ];
    lines.join("\n")
}

fn value(field: &ConventionField) -> String {
    field
        .value
        .map_or_else(|| "left out".to_owned(), |v| format!("{v:.4}"))
}

/// How to find a sign with one line over any flat bottom.
fn on_board() -> String {
    let sentences = [
        "To find a sign on board, take one line over flat bottom and enter 1 deg in one field, the others unchanged; the soundings tell \
         what the program means by +1:",
        "roll: starboard soundings get deeper and port ones shallower if positive is starboard down (as in the report); else enter the \
         other sign",
        "pitch: the soundings under the boat move forward if positive is bow up (as in the report)",
        "heading: the outer starboard soundings move aft if positive is clockwise (as in the report)",
        "offsets: all soundings move to where positive points",
        "Then enter the report's values with these signs. Of a tilted head check the order of rotations too: enter roll and heading \
         together and compare a sounding with one from `boresight apply`.",
    ];
    sentences.map(wrapped).join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latex_signs_are_escaped() {
        assert_eq!(escaped("range_scale, 5 %"), "range\\_scale, 5 \\%");
        assert_eq!(figure("-1.20"), "$-1.20$");
        assert_eq!(figure("held"), "held");
    }

    #[test]
    fn every_form_has_a_file_of_its_own() {
        let mut names = Export::ALL.map(Export::file_name).to_vec();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Export::ALL.len());
    }
}
