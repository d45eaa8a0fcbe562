//! An error budget in a few sentences.

use super::budget::TELLING;
use super::format::{finer, three_digits as digits};
use super::wanted::answer;
use crate::results::{BudgetResult, JOINT, Origin, PathBudget, SourceShare};

/// Rows of a path that are no source of errors.
const APART: [&str; 3] = ["nothing", "remainder", "interaction"];

/// How the paths compare, which source is largest, and whether the reported uncertainty is true; what is not in the result is left out.
#[must_use]
pub fn headline(result: &BudgetResult) -> String {
    let parts = [answer(result), gain(result), largest(result), truth(result)];
    let text: Vec<String> = parts.into_iter().flatten().collect();
    match text.is_empty() {
        true => "No figures: there were no trials and no propagation.".to_owned(),
        false => text.join(" "),
    }
}

fn joint(result: &BudgetResult) -> Option<&PathBudget> {
    result.paths.iter().find(|p| p.path == JOINT)
}

/// Root mean square errors in the units shown; NaN where there is none.
fn rms(result: &BudgetResult, path: &PathBudget) -> Option<Vec<f64>> {
    let rms = path.together.as_ref()?.rms.as_ref()?.iter();
    let shown = rms.zip(&result.parameters);
    Some(
        shown
            .map(|(v, p)| v.unwrap_or(f64::NAN) * finer(&p.unit).1)
            .collect(),
    )
}

/// The parameters in which joint and reference path differ most: one of each unit that is an angle or a length.
fn gain(result: &BudgetResult) -> Option<String> {
    let own = rms(result, joint(result)?)?;
    let reference = result.paths.iter().find(|p| p.path != JOINT)?;
    let theirs = rms(result, reference)?;
    let ratio = |i: &usize| theirs[*i] / own[*i];
    let most = |unit: &str| {
        let all = 0..result.parameters.len();
        let of_unit = all.filter(|i| result.parameters[*i].unit == unit && ratio(i).is_finite());
        of_unit.max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
    };
    let phrase = |i: usize| {
        let (name, unit) = (
            &result.parameters[i].name,
            finer(&result.parameters[i].unit).0,
        );
        format!(
            "{} {unit} against {} {unit} in {name}",
            digits(own[i]),
            digits(theirs[i])
        )
    };
    let phrases: Vec<String> = [most("deg"), most("m")]
        .into_iter()
        .flatten()
        .map(phrase)
        .collect();
    (!phrases.is_empty()).then(|| {
        format!(
            "RMS error of the joint path against the reference path: {}.",
            phrases.join(" and ")
        )
    })
}

/// The joint path's source with the largest share of anything.
fn largest(result: &BudgetResult) -> Option<String> {
    let shares = joint(result)?.shares.iter();
    let telling = |s: &&SourceShare| s.origin == Origin::Analytic || s.usable >= TELLING;
    let sources = shares
        .filter(|s| !APART.contains(&s.source.as_str()))
        .filter(telling);
    let parts = sources.flat_map(|s| {
        let parts = s.share.iter().flatten().enumerate();
        parts.filter_map(move |(i, part)| Some((s, i, (*part)?)))
    });
    let (share, i, part) = parts.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let described = result.sources.iter().find(|d| d.source == share.source);
    let title = described.map_or(share.source.as_str(), |d| d.title.as_str());
    Some(format!(
        "The joint path's largest source: {title}, {:.0} % of the variance of {}.",
        100.0 * part,
        result.parameters[i].name
    ))
}

fn truth(result: &BudgetResult) -> Option<String> {
    let together = joint(result)?.together.as_ref()?;
    let nees = together.reported.as_ref()?.nees?;
    let verdict = if nees.interval.contains(nees.mean) {
        "right within chance"
    } else if nees.mean > nees.interval.upper {
        "too small"
    } else {
        "too large"
    };
    Some(format!(
        "The sigmas that it reports are {verdict} (NEES {:.2}, {:.2} to {:.2} when right).",
        nees.mean, nees.interval.lower, nees.interval.upper
    ))
}
