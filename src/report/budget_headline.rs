//! An error budget in a few sentences.

use super::format::{ROWS, in_order, shown_figures as shown, three_digits as digits};
use crate::results::{BudgetPath, BudgetResult, PathBudget};

/// How the paths compare, which source is largest, and whether the reported uncertainty is true; what is not in the result is left out.
#[must_use]
pub fn headline(result: &BudgetResult) -> String {
    let parts = [gain(result), largest(result), truth(result)];
    let text: Vec<String> = parts.into_iter().flatten().collect();
    match text.is_empty() {
        true => "No figures: neither trials nor analytic propagation.".to_owned(),
        false => text.join(" "),
    }
}

fn path(result: &BudgetResult, path: BudgetPath) -> Option<&PathBudget> {
    result.paths.iter().find(|p| p.path == path)
}

fn rms(path: Option<&PathBudget>) -> Option<[f64; 6]> {
    let rms = path?.together.as_ref()?.rms;
    rms.as_ref().map(shown)
}

/// The parameters in which the paths differ most: one angle and one length.
fn gain(result: &BudgetResult) -> Option<String> {
    let joint = rms(path(result, BudgetPath::Joint))?;
    let sequential = rms(path(result, BudgetPath::Sequential))?;
    let ratio = |i: &usize| sequential[*i] / joint[*i];
    let most = |of: std::ops::Range<usize>| of.max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let phrase = |i: usize| {
        let row = &ROWS[i];
        let (name, unit) = (row.name, row.unit);
        format!(
            "{} {unit} against {} {unit} in {name}",
            digits(joint[i]),
            digits(sequential[i])
        )
    };
    Some(format!(
        "RMS error of the joint path against the sequential one: {} and {}.",
        phrase(most(0..3)?),
        phrase(most(3..6)?)
    ))
}

/// The joint path's source with the largest share of anything.
fn largest(result: &BudgetResult) -> Option<String> {
    let apart = ["nothing", "remainder", "interaction"];
    let shares = path(result, BudgetPath::Joint)?.shares.iter();
    let sources = shares.filter(|s| !apart.contains(&s.source.as_str()));
    let of_all = sources.filter_map(|s| {
        let six = in_order(s.share.as_ref()?);
        let i = (0..6).max_by(|a, b| six[*a].total_cmp(&six[*b]))?;
        Some((s, i, six[i]))
    });
    let (share, i, part) = of_all.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let described = result.sources.iter().find(|d| d.source == share.source);
    let title = described.map_or(share.source.as_str(), |d| d.title.as_str());
    Some(format!(
        "The joint path's largest source: {title}, {:.0} % of the variance of {}.",
        100.0 * part,
        ROWS[i].name
    ))
}

fn truth(result: &BudgetResult) -> Option<String> {
    let joint = path(result, BudgetPath::Joint)?.together.as_ref()?;
    let nees = joint.reported.as_ref()?.nees?;
    let verdict = if nees.interval.contains(nees.mean) {
        "true within chance"
    } else if nees.mean > nees.interval.upper {
        "too small"
    } else {
        "too large"
    };
    Some(format!(
        "The uncertainty that it reports is {verdict} (NEES {:.2}, {:.2} to {:.2} when true).",
        nees.mean, nees.interval.lower, nees.interval.upper
    ))
}
