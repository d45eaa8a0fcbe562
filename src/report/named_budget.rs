//! An error budget of named parameters for the terminal, as JSON, as a tidy CSV table and as a page.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::{ReportError, html, json};
use crate::results::{NamedBudget, NamedFigures, NamedPath, NamedShare, write_whole};
use crate::ruled::Ruled;

/// Where the files are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenNamedBudget {
    /// `result.json`.
    pub json: PathBuf,
    /// `budget.csv`.
    pub table: PathBuf,
    /// `report.html`.
    pub page: PathBuf,
}

/// Writes `result.json`, `budget.csv` and `report.html` into `folder`, each whole or not at all.
///
/// # Errors
/// [`ReportError`]; all texts are made before the first is written.
pub fn write_named_budget(
    folder: &Path,
    result: &NamedBudget,
) -> Result<WrittenNamedBudget, ReportError> {
    let bytes = to_bytes(result)?;
    let page = html::named_budget(result)?;
    let written = WrittenNamedBudget {
        json: folder.join("result.json"),
        table: folder.join("budget.csv"),
        page: folder.join("report.html"),
    };
    write_whole(&written.json, &bytes)?;
    write_whole(&written.table, table(result).as_bytes())?;
    write_whole(&written.page, page.as_bytes())?;
    Ok(written)
}

/// The bytes of `result.json`; the same result gives the same bytes.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &NamedBudget) -> serde_json::Result<Vec<u8>> {
    json::lines(result)
}

/// What the budget says first: the largest source of the parameter that is known worst by its share, and whether reported
/// uncertainty is true.
#[must_use]
pub fn headline(result: &NamedBudget) -> String {
    let largest = result
        .paths
        .first()
        .and_then(|joint| largest(result, joint));
    let first = largest.unwrap_or_else(|| "No source was tried alone (--single).".to_owned());
    let honest = result.paths.first().and_then(|path| path.honesty.as_ref());
    let second = honest.and_then(|h| h.nees.as_ref()).map_or_else(
        || "The reported uncertainty was not judged.".to_owned(),
        |n| {
            let inside = n.mean >= n.interval.lower && n.mean <= n.interval.upper;
            let truth = if inside { "is true" } else { "is not true" };
            format!(
                "The reported uncertainty {truth} within chance (NEES {:.2}, {:.2} to {:.2} when true).",
                n.mean, n.interval.lower, n.interval.upper
            )
        },
    );
    format!("{first} {second}")
}

fn largest(result: &NamedBudget, path: &NamedPath) -> Option<String> {
    let sources = path.shares.iter().filter(|s| s.source != "nothing");
    let parts = sources.flat_map(|s| {
        let share = s.share.iter().flatten().enumerate();
        share.map(move |(i, part)| (s, i, *part))
    });
    let (share, place, part) = parts.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let title = result.sources.iter().find(|s| s.source == share.source);
    Some(format!(
        "The largest share of any source: {} makes {:.0} % of the variance of {}.",
        title.map_or(share.source.as_str(), |s| &s.title),
        100.0 * part,
        result.parameters[place].name
    ))
}

/// The summary for the terminal; ends with a newline.
#[must_use]
pub fn summary(result: &NamedBudget) -> String {
    let mut text = format!(
        "Error budget of {}\n\n{}\n",
        result.scenario,
        headline(result)
    );
    for path in &result.paths {
        let title = if path.path == "joint" {
            "Joint path"
        } else {
            "Reference path"
        };
        let Some(together) = &path.together else {
            let _ = writeln!(text, "\n{title}: no usable trial");
            continue;
        };
        let _ = writeln!(
            text,
            "\n{title}, {} of {} trials usable\n{}",
            together.usable,
            together.trials,
            figures(result, path, together)
        );
        if path.shares.len() > 1 {
            let _ = writeln!(text, "{}", shares(result, path));
        }
    }
    for refusal in &result.refusals {
        let (path, count) = (&refusal.path, refusal.count);
        let _ = writeln!(
            text,
            "\n{path} path: {count} trials without result: {}",
            refusal.reason
        );
    }
    for note in &result.notes {
        let _ = writeln!(text, "\nNote: {note}.");
    }
    text
}

fn figures(result: &NamedBudget, path: &NamedPath, together: &NamedFigures) -> Ruled {
    let mut table = Ruled::new([
        "parameter",
        "bias",
        "standard deviation",
        "reported",
        "pull mean",
        "pull RMS",
    ]);
    let nth =
        |list: Option<&Vec<f64>>, i: usize| list.map_or_else(String::new, |list| short(list[i]));
    for (i, parameter) in result.parameters.iter().enumerate() {
        let honesty = path.honesty.as_ref();
        table.row([
            format!("{}, {}", parameter.name, parameter.unit),
            short(together.bias[i]),
            nth(together.standard_deviation.as_ref(), i),
            nth(honesty.map(|h| &h.reported), i),
            honesty.map_or_else(String::new, |h| format!("{:+.3}", h.pull_mean[i])),
            honesty.map_or_else(String::new, |h| format!("{:.3}", h.pull_rms[i])),
        ]);
    }
    table
}

fn shares(result: &NamedBudget, path: &NamedPath) -> Ruled {
    let names = result.parameters.iter().map(|p| p.name.as_str());
    let mut table = Ruled::new(["share of variance, %"].into_iter().chain(names));
    for share in &path.shares {
        let Some(parts) = share.share.as_ref().filter(|_| share.source != "nothing") else {
            continue;
        };
        let title = result.sources.iter().find(|s| s.source == share.source);
        let title = title.map_or(share.source.clone(), |s| s.title.clone());
        let cells = parts.iter().map(|part| format!("{:.1}", 100.0 * part));
        table.row([title].into_iter().chain(cells));
    }
    table
}

/// Three digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e4).contains(&size) => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.2e}"),
    }
}

/// One row per path, source and parameter: `budget.csv`. A field that is not known is empty.
#[must_use]
pub fn table(result: &NamedBudget) -> String {
    let mut text = "path,source,parameter,unit,trials,usable,bias,bias_standard_error,standard_deviation,share\n".to_owned();
    for path in &result.paths {
        let one = vec![1.0; result.parameters.len()];
        if let Some(together) = &path.together {
            rows(&mut text, result, path, "together", together, Some(&one));
        }
        for NamedShare {
            source,
            figures,
            share,
        } in &path.shares
        {
            if let Some(figures) = figures {
                rows(&mut text, result, path, source, figures, share.as_ref());
            }
        }
    }
    text
}

fn rows(
    text: &mut String,
    result: &NamedBudget,
    path: &NamedPath,
    source: &str,
    figures: &NamedFigures,
    share: Option<&Vec<f64>>,
) {
    let nth = |list: Option<&Vec<f64>>, i: usize| {
        list.map(|list| list[i])
            .filter(|v| v.is_finite())
            .map_or_else(String::new, |v| v.to_string())
    };
    for (i, parameter) in result.parameters.iter().enumerate() {
        let _ = writeln!(
            text,
            "{},{source},\"{}\",{},{},{},{},{},{},{}",
            path.path,
            parameter.name.replace('"', "\"\""),
            parameter.unit,
            figures.trials,
            figures.usable,
            nth(Some(&figures.bias), i),
            nth(figures.bias_standard_error.as_ref(), i),
            nth(figures.standard_deviation.as_ref(), i),
            nth(share, i),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_whatever_the_size() {
        let shown = [0.0, 1.2345, -0.012345, 123.456, 1.2345e-5, 99999.0].map(short);
        assert_eq!(
            shown,
            ["0", "1.23", "-0.0123", "123", "1.23e-5", "1.00e5"].map(str::to_owned)
        );
    }
}
