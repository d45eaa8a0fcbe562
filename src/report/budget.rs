//! An error budget for the terminal, as JSON and as tidy CSV tables.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::format::{finer, three_digits as digits, two_digits};
use super::text::wrapped;
use super::wanted::answer;
use super::{ReportError, html, json};
use crate::files::land;
use crate::results::{
    BudgetParameter, BudgetResult, Figures, Interval, JOINT, Origin, PathBudget, PathStatistics,
    RefusalCount, SourceShare, Sweep, SweepPoint,
};
use crate::ruled::Ruled;

/// Sources that the terminal shows of each path.
const SHOWN: usize = 5;

/// Usable trials below which a share of the variance by trials is chance more than anything else.
pub(super) const TELLING: u64 = 50;

/// Where the files are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenBudget {
    /// `result.json`.
    pub json: PathBuf,
    /// `budget.csv`.
    pub table: PathBuf,
    /// `sweep.csv`, where there is a sweep.
    pub sweep: Option<PathBuf>,
    /// `report.html`.
    pub page: PathBuf,
}

/// Writes `result.json`, `budget.csv`, `report.html` and `sweep.csv` into `folder`, together or not at all.
///
/// # Errors
/// [`ReportError`]; all texts are made before the first is written.
pub fn write_budget(folder: &Path, result: &BudgetResult) -> Result<WrittenBudget, ReportError> {
    let bytes = to_bytes(result)?;
    let page = html::budget(result)?;
    let sweep = result.sweep.as_ref();
    let written = WrittenBudget {
        json: folder.join("result.json"),
        table: folder.join("budget.csv"),
        sweep: sweep.map(|_| folder.join("sweep.csv")),
        page: folder.join("report.html"),
    };
    let table = table(result);
    let sweep = sweep.map(|sweep| sweep_table(&result.parameters, sweep));
    let mut files: Vec<(&str, &[u8])> = vec![
        ("result.json", &bytes),
        ("budget.csv", table.as_bytes()),
        ("report.html", page.as_bytes()),
    ];
    files.extend(sweep.as_ref().map(|text| ("sweep.csv", text.as_bytes())));
    land(folder, &files)?;
    Ok(written)
}

/// The bytes of `result.json`; the same result gives the same bytes.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &BudgetResult) -> serde_json::Result<Vec<u8>> {
    json::lines(result)
}

/// Reads `result.json`.
///
/// # Errors
/// The line and column where the text is no budget.
pub fn from_slice(bytes: &[u8]) -> serde_json::Result<BudgetResult> {
    serde_json::from_slice(bytes)
}

/// Columns behind the first ones of both tables.
const FIGURES: &str = "parameter,unit,trials,usable,bias,bias_standard_error,standard_deviation,\
    standard_deviation_lower,standard_deviation_upper,rms";

/// One row per path, source, origin and parameter: `budget.csv`. A field that is not known is empty.
#[must_use]
pub fn table(result: &BudgetResult) -> String {
    let mut text = format!("path,source,origin,{FIGURES},share\n");
    for path in &result.paths {
        let (name, parameters) = (&path.path, &result.parameters);
        if let Some(together) = &path.together {
            let rows = Rows::of_statistics(together);
            let first = format!("{name},together,monte_carlo");
            rows.write(&mut text, parameters, &first, |_| ",1".to_owned());
        }
        for share in path.predicted.iter().chain(&path.shares) {
            let origin = serde_name(&share.origin);
            let first = format!("{name},{},{origin}", share.source);
            Rows::of_share(share).write(&mut text, parameters, &first, |i| {
                format!(",{}", number(nth(share.share.as_ref(), i)))
            });
        }
    }
    text
}

/// One row per point, path and parameter: `sweep.csv`; the first columns are the varied keys.
#[must_use]
pub fn sweep_table(parameters: &[BudgetParameter], sweep: &Sweep) -> String {
    let keys: Vec<String> = sweep.keys.iter().map(|k| quoted(k)).collect();
    let mut text = format!(
        "{},path,{FIGURES},reported_sigma,pull_mean,pull_rms,nees\n",
        keys.join(",")
    );
    for point in &sweep.points {
        let values: Vec<String> = point
            .values
            .iter()
            .map(|v| quoted(&v.to_string()))
            .collect();
        for statistics in &point.paths {
            let first = format!("{},{}", values.join(","), statistics.path);
            let reported = statistics.reported.as_ref();
            let sigma = reported.and_then(|r| r.standard_deviation.as_ref());
            let nees = reported.and_then(|r| r.nees).map(|n| n.mean);
            Rows::of_statistics(statistics).write(&mut text, parameters, &first, |i| {
                format!(
                    ",{},{},{},{}",
                    number(nth(sigma, i)),
                    number(reported.map(|r| r.pull_mean[i])),
                    number(reported.map(|r| r.pull_rms[i])),
                    number(nees)
                )
            });
        }
    }
    text
}

/// A parameter's figure; `None` where there is none.
fn nth(figures: Option<&Figures>, i: usize) -> Option<f64> {
    figures.and_then(|figures| figures[i])
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

fn serde_name(value: &impl Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

/// What both tables show.
struct Rows<'a> {
    trials: u64,
    usable: u64,
    bias: Option<&'a Figures>,
    error: Option<&'a Figures>,
    deviation: Option<&'a Figures>,
    interval: Option<Interval>,
    rms: Option<&'a Figures>,
}

impl<'a> Rows<'a> {
    fn of_statistics(s: &'a PathStatistics) -> Self {
        Self {
            trials: s.trials,
            usable: s.usable,
            bias: s.bias.as_ref(),
            error: s.bias_standard_error.as_ref(),
            deviation: s.standard_deviation.as_ref(),
            interval: s.standard_deviation_interval,
            rms: s.rms.as_ref(),
        }
    }

    fn of_share(s: &'a SourceShare) -> Self {
        Self {
            trials: s.trials,
            usable: s.usable,
            bias: s.bias.as_ref(),
            error: s.bias_standard_error.as_ref(),
            deviation: s.standard_deviation.as_ref(),
            interval: s.standard_deviation_interval,
            rms: None,
        }
    }

    /// One row for each parameter, `first` before its figures and `last` behind them.
    fn write(
        &self,
        text: &mut String,
        parameters: &[BudgetParameter],
        first: &str,
        last: impl Fn(usize) -> String,
    ) {
        for (i, parameter) in parameters.iter().enumerate() {
            let of = |figures| number(nth(figures, i));
            let end = |factor: Option<f64>| {
                number(factor.and_then(|factor| Some(nth(self.deviation, i)? * factor)))
            };
            let _ = writeln!(
                text,
                "{first},{},{},{},{},{},{},{},{},{},{}{}",
                quoted(&parameter.name),
                parameter.unit,
                self.trials,
                self.usable,
                of(self.bias),
                of(self.error),
                of(self.deviation),
                end(self.interval.map(|i| i.lower)),
                end(self.interval.map(|i| i.upper)),
                of(self.rms),
                last(i)
            );
        }
    }
}

/// The summary for the terminal. Ends with a newline.
#[must_use]
pub fn summary(result: &BudgetResult) -> String {
    let mut text = format!("Error budget of {}\n", result.scenario);
    if let Some(answer) = answer(result) {
        let _ = writeln!(text, "\n{}", wrapped(&answer));
    }
    if let Some(sweep) = &result.sweep {
        text.push_str(&sweep_text(result, sweep));
    }
    for path in &result.paths {
        text.push_str(&path_text(result, path));
    }
    for refusal in &result.refusals {
        let path = &refusal.path;
        let seeds: Vec<String> = refusal.seeds.iter().map(u64::to_string).collect();
        let more = if refusal.count > refusal.seeds.len() as u64 {
            ", ..."
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "\n{path}: {} of {} trials not usable (seed {}{more}): {}",
            refusal.count,
            result.trials,
            seeds.join(", "),
            refusal.example
        );
    }
    for note in &result.notes {
        let _ = writeln!(text, "\nNote: {note}.");
    }
    text
}

/// Name and shown unit of each parameter.
fn heads(result: &BudgetResult) -> impl Iterator<Item = String> {
    let head = |p: &BudgetParameter| match finer(&p.unit).0 {
        "1" | "" => p.name.clone(),
        unit => format!("{}, {unit}", p.name),
    };
    result.parameters.iter().map(head)
}

/// A parameter's figure in the unit shown.
fn cell(result: &BudgetResult, figures: Option<&Figures>, i: usize) -> String {
    let factor = finer(&result.parameters[i].unit).1;
    let shown = nth(figures, i).map(|value| digits(value * factor));
    shown.unwrap_or_else(|| "-".to_owned())
}

fn title(path: &PathBudget) -> String {
    let variant = match path.variant.as_str() {
        "" => String::new(),
        variant => format!(" ({variant})"),
    };
    let name = if path.path == JOINT {
        "Joint"
    } else {
        "Reference"
    };
    format!("{name} path{variant}")
}

fn path_text(result: &BudgetResult, path: &PathBudget) -> String {
    let mut text = String::new();
    if let Some(s) = &path.together {
        let _ = writeln!(
            text,
            "\n{}: {} of {} trials usable, seeds {} to {}",
            title(path),
            s.usable,
            s.trials,
            result.first_seed,
            result.first_seed + s.trials.saturating_sub(1)
        );
        text.push_str(&statistics_table(result, s));
        text.push_str(&honesty(s));
    }
    text.push_str(&predicted_text(result, path));
    text.push_str(&top_sources(result, path));
    text
}

/// What propagation says, and where the trials contradict it.
fn predicted_text(result: &BudgetResult, path: &PathBudget) -> String {
    let Some(predicted) = &path.predicted else {
        return String::new();
    };
    let mut text = format!("\n{}, by propagation\n", title(path));
    let mut table = Ruled::new([
        "parameter",
        "bias",
        "sigma",
        "Cramer-Rao bound",
        "efficiency",
    ]);
    for (i, head) in heads(result).enumerate() {
        let efficiency = nth(path.efficiency.as_ref(), i);
        table.row([
            head,
            cell(result, predicted.bias.as_ref(), i),
            cell(result, predicted.standard_deviation.as_ref(), i),
            cell(result, path.bound.as_ref(), i),
            efficiency.map_or_else(|| "-".to_owned(), |e| efficient(path, e)),
        ]);
    }
    let _ = writeln!(text, "{table}");
    if let Some(first) = path.agreement.first() {
        let all: usize = path.agreement.iter().map(|a| a.variance_ratio.len()).sum();
        let outside: usize = path.agreement.iter().map(|a| a.outside.len()).sum();
        let _ = writeln!(
            text,
            "variance by trials / predicted variance: {} of {all} ratios within chance ({} comparisons at once)",
            all - outside,
            first.comparisons
        );
    }
    for pair in path.agreement.iter().filter(|a| !a.outside.is_empty()) {
        let ratios: Vec<String> = pair
            .outside
            .iter()
            .filter_map(|name| Some(format!("{name} {:.2}", pair.variance_ratio.get(name)?)))
            .collect();
        let _ = writeln!(
            text,
            "  {} ({:.2} to {:.2} by chance): {}; {}",
            pair.source,
            pair.interval.lower,
            pair.interval.upper,
            ratios.join(", "),
            pair.note
        );
    }
    text
}

/// "0.98", or "0.95 to 1" where it is counted over trials: the interval of their variance, and no path does better than the bound.
fn efficient(path: &PathBudget, efficiency: f64) -> String {
    let counted = path.together.as_ref().filter(|t| t.usable >= TELLING);
    match counted.and_then(|t| t.standard_deviation_interval) {
        Some(ends) => {
            let end = |factor: f64| (efficiency / (factor * factor)).min(1.0);
            format!("{:.2} to {:.2}", end(ends.upper), end(ends.lower))
        }
        None => format!("{:.2}", efficiency.min(1.0)),
    }
}

fn statistics_table(result: &BudgetResult, s: &PathStatistics) -> String {
    let reported = s.reported.as_ref();
    let sigma = reported.and_then(|r| r.standard_deviation.as_ref());
    let mut header = vec!["parameter", "bias", "±", "sigma by trials", "RMS"];
    if reported.is_some() {
        header.extend(["reported", "pull RMS"]);
    }
    let mut table = Ruled::new(header);
    for (i, head) in heads(result).enumerate() {
        let mut line = vec![
            head,
            cell(result, s.bias.as_ref(), i),
            cell(result, s.bias_standard_error.as_ref(), i),
            with_interval(result, s, i),
            cell(result, s.rms.as_ref(), i),
        ];
        if let Some(reported) = reported {
            line.push(cell(result, sigma, i));
            line.push(format!("{:.2}", reported.pull_rms[i]));
        }
        table.row(line);
    }
    format!("{table}\n")
}

/// "0.0562 (0.035 to 0.14)": the standard deviation of the trials with its interval.
fn with_interval(result: &BudgetResult, s: &PathStatistics, i: usize) -> String {
    let shown = cell(result, s.standard_deviation.as_ref(), i);
    let Some((sigma, ends)) =
        nth(s.standard_deviation.as_ref(), i).zip(s.standard_deviation_interval)
    else {
        return shown;
    };
    let factor = sigma * finer(&result.parameters[i].unit).1;
    let end = |e: f64| two_digits(factor * e);
    format!("{shown} ({} to {})", end(ends.lower), end(ends.upper))
}

fn honesty(s: &PathStatistics) -> String {
    let Some(reported) = &s.reported else {
        return String::new();
    };
    let ends = reported.pull_rms_interval;
    let mut text = format!(
        "pull RMS of a true covariance: {:.3} to {:.3}",
        ends.lower, ends.upper
    );
    if let Some(nees) = &reported.nees {
        let _ = write!(
            text,
            "; NEES {:.2} ({:.2} to {:.2} when true)",
            nees.mean, nees.interval.lower, nees.interval.upper
        );
    }
    text.push('\n');
    text
}

/// The sources with the largest share of any parameter, then the remainder and the interaction.
fn top_sources(result: &BudgetResult, path: &PathBudget) -> String {
    let largest = |share: &SourceShare| {
        let parts = share.share.iter().flatten().flatten();
        parts.copied().fold(0.0, f64::max)
    };
    let counted = |s: &&SourceShare| s.origin == Origin::MonteCarlo && s.source != "nothing";
    let fewest = path.shares.iter().filter(counted).map(|s| s.usable).min();
    let analytic = path.shares.iter().any(|s| s.origin == Origin::Analytic);
    if fewest.is_some_and(|n| n < TELLING) && !analytic {
        return format!(
            "no shares of the variance: {} trials of each source alone are too few, {TELLING} are needed (--single {TELLING})\n",
            fewest.unwrap_or(0)
        );
    }
    let origin = if fewest.is_some_and(|n| n >= TELLING) {
        Origin::MonteCarlo
    } else {
        Origin::Analytic
    };
    let is_rest = |s: &&SourceShare| ["remainder", "interaction"].contains(&s.source.as_str());
    let is_source = |s: &&SourceShare| !is_rest(s) && s.origin == origin && s.share.is_some();
    let mut sources: Vec<&SourceShare> = path.shares.iter().filter(is_source).collect();
    sources.sort_by(|a, b| largest(b).total_cmp(&largest(a)));
    if sources.is_empty() {
        return String::new();
    }
    let left_out = sources.len().saturating_sub(SHOWN);
    sources.truncate(SHOWN);
    let rest = |s: &&SourceShare| is_rest(s) && s.origin == origin;
    sources.extend(path.shares.iter().filter(rest));
    let names = result.parameters.iter().map(|p| p.name.clone());
    let heading = match origin {
        Origin::MonteCarlo => "share of variance by trials, %",
        Origin::Analytic => "share of variance, %",
    };
    let mut table = Ruled::new([heading.to_owned()].into_iter().chain(names));
    for share in sources {
        let described = result.sources.iter().find(|s| s.source == share.source);
        let title = described.map_or(share.source.as_str(), |s| s.title.as_str());
        let percent = |i: usize| {
            let part = nth(share.share.as_ref(), i);
            part.map_or_else(|| "-".to_owned(), |part| format!("{:.0}", 100.0 * part))
        };
        let parts = (0..result.parameters.len()).map(percent);
        table.row([title.to_owned()].into_iter().chain(parts));
    }
    let mut text = format!("{table}\n");
    if let (Origin::MonteCarlo, Some(n)) = (origin, fewest) {
        let chance = 100.0 * (2.0 * (2.0 / (n.max(2) - 1) as f64)).sqrt();
        let _ = writeln!(
            text,
            "by chance alone a share varies by {chance:.0} % of itself (one sigma); the remainder by as much as all shares together"
        );
    }
    if left_out > 0 {
        let _ = writeln!(text, "and {left_out} smaller sources in budget.csv");
    }
    text
}

/// The answer to a sweep: what each value gives, by every path; the figures of the value that is best for each parameter.
fn sweep_text(result: &BudgetResult, sweep: &Sweep) -> String {
    let mut text = String::new();
    let words: Vec<String> = sweep.keys.iter().map(|key| in_words(key)).collect();
    for path in result.paths.iter().map(|p| &p.path) {
        let of_path = |point: &SweepPoint| point.paths.iter().any(|s| s.path == *path);
        if !sweep.points.iter().any(of_path) {
            continue;
        }
        let points: Vec<&SweepPoint> = sweep.points.iter().collect();
        let counted = points.iter().any(|p| p.paths.iter().any(|s| s.trials > 0));
        let usable = counted.then(|| "usable".to_owned());
        let heads = words.iter().cloned().chain(usable).chain(heads(result));
        let mut table = Ruled::new(heads).texts(words.len());
        for point in &points {
            let s = point.paths.iter().find(|s| s.path == *path);
            let values = point.values.iter().map(ToString::to_string);
            let of = |s: &PathStatistics| format!("{}/{}", s.usable, s.trials);
            let usable = counted.then(|| s.map_or("-".to_owned(), of));
            let all = 0..result.parameters.len();
            let rms = all.map(|i| cell(result, s.and_then(|s| s.rms.as_ref()), i));
            table.row(values.chain(usable).chain(rms));
        }
        let _ = writeln!(text, "\n{}", heading(sweep, path));
        if path == JOINT {
            text.push_str(&best_values(result, &points, &words));
        }
        let _ = writeln!(text, "{table}");
    }
    for (point, refusal) in nothing_propagated(sweep) {
        let values: Vec<String> = point.values.iter().map(ToString::to_string).collect();
        let said = format!(
            "No figures at {}: {}.",
            values.join(" and "),
            refusal.example
        );
        let _ = writeln!(text, "\n{}", wrapped(&said));
    }
    text
}

/// Points of which propagation has no figures, with the reason.
fn nothing_propagated(sweep: &Sweep) -> impl Iterator<Item = (&SweepPoint, &RefusalCount)> {
    let without = sweep.points.iter().filter(|point| point.paths.is_empty());
    without.flat_map(|point| point.refusals.iter().map(move |refusal| (point, refusal)))
}

/// One sigma of a standard deviation of so many trials, of two at least, in percent of it.
pub(super) fn good_to_percent(trials: u64) -> f64 {
    100.0 / (2.0 * (trials.max(2) - 1) as f64).sqrt()
}

fn heading(sweep: &Sweep, path: &str) -> String {
    let path = match path.strip_suffix("_projected") {
        Some(name) => format!("{name} path (projected)"),
        None => format!("{path} path"),
    };
    if sweep.trials == 0 {
        return format!("RMS error by propagation, {path}");
    }
    let one = good_to_percent(sweep.trials);
    format!(
        "RMS error, {path}: {} trials at each value under the same seeds, each figure good to {one:.0} %",
        sweep.trials
    )
}

/// "Smallest error: yaw 0.05 deg at multibeam tilt 40 deg, ..."; nothing of a single value.
fn best_values(result: &BudgetResult, points: &[&SweepPoint], words: &[String]) -> String {
    if points.len() < 2 {
        return String::new();
    }
    let rms = |point: &SweepPoint, i: usize| {
        let s = point.paths.iter().find(|s| s.path == JOINT)?;
        nth(s.rms.as_ref(), i).filter(|v| v.is_finite())
    };
    let mut by_value: Vec<(String, Vec<&str>)> = vec![];
    for (i, parameter) in result.parameters.iter().enumerate() {
        let known = points.iter().filter_map(|p| Some((*p, rms(p, i)?)));
        let Some((best, _)) = known.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        let value = best.values.iter().map(ToString::to_string);
        let value: Vec<String> = value.collect();
        let value = value.join(" and ");
        match by_value.iter_mut().find(|(v, _)| *v == value) {
            Some((_, names)) => names.push(&parameter.name),
            None => by_value.push((value, vec![&parameter.name])),
        }
    }
    let parts: Vec<String> = by_value
        .iter()
        .map(|(value, names)| format!("{} at {value}", names.join(", ")))
        .collect();
    format!(
        "Smallest error of {} (by {})\n",
        parts.join("; of "),
        words.join(" and ")
    )
}

/// A scenario's key as one would say it: `trajectory.position_drift_sigma_m` is "trajectory position drift sigma, m".
pub(super) fn in_words(key: &str) -> String {
    let units = [
        ("_m_s", "m/s"),
        ("_deg", "deg"),
        ("_hz", "Hz"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let unit = units.iter().find(|(end, _)| key.ends_with(end));
    let bare = unit.map_or(key, |(end, _)| key.trim_end_matches(end));
    let parts: Vec<String> = bare
        .split('.')
        .map(|part| match part {
            "*" => "of all".to_owned(),
            part => match part.parse::<usize>() {
                Ok(place) => (place + 1).to_string(),
                Err(_) => part.replace('_', " "),
            },
        })
        .collect();
    match unit {
        Some((_, unit)) => format!("{}, {unit}", parts.join(" ")),
        None => parts.join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_are_quoted() {
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("pass.*.x"), "pass.*.x");
    }

    #[test]
    fn keys_are_said_in_words() {
        let said = in_words("trajectory.position_drift_sigma_m");
        assert_eq!(said, "trajectory position drift sigma, m");
        assert_eq!(in_words("pass.0.speed_m_s"), "pass 1 speed, m/s");
        assert_eq!(in_words("sources.gross_errors"), "sources gross errors");
    }
}
