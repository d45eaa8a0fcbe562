//! The card "Enter these values": what goes into the other program, before and after.

use super::format::shown;
use crate::results::{Calibration, MountingAngles, MountingResult, Parameter};
use crate::units::with_sigma;
use serde::Serialize;

/// The values to enter, of the deciding solution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// Name of the solution in the file, such as `joint`.
    pub solution: &'static str,
    /// The values; with several mountings each line begins with its name.
    pub rows: Vec<CardRow>,
}

/// One value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CardRow {
    /// The record it belongs to, as the mounting or array is named among the conventions; empty for what belongs to none.
    #[serde(skip)]
    pub record: String,
    /// What it is, such as `roll`.
    pub name: String,
    /// Its unit; empty for a ratio.
    pub unit: String,
    /// What a positive value means; may be empty.
    pub positive: String,
    /// The value entered so far, as text.
    pub before: String,
    /// The value to enter, with the digits that its sigma leaves.
    pub after: String,
    /// One sigma, empty where there is none.
    pub sigma: String,
}

/// The card of a result; `None` when there is nothing to enter.
#[must_use]
pub fn card(result: &Calibration) -> Option<Card> {
    let solution = result.deciding().filter(|s| result.usable && s.usable)?;
    let several = solution.mountings.len() > 1;
    let of_mountings = solution.mountings.iter().flat_map(|m| records(m, several));
    let others = solution
        .parameters
        .iter()
        .filter(|p| !of_a_mounting(p, &solution.mountings))
        .filter(|p| p.determined || p.note.is_empty());
    Some(Card {
        solution: result.solutions.deciding_name()?,
        rows: of_mountings.chain(others.map(other)).collect(),
    })
}

/// Whether a parameter is one of a mounting's six, which the card gives as angles and lever arm.
fn of_a_mounting(parameter: &Parameter, mountings: &[MountingResult]) -> bool {
    let own = ["pitch", "roll", "yaw", "lx", "ly", "lz"];
    let name = parameter.name.as_str();
    own.contains(&name)
        || mountings.iter().any(|m| {
            name.strip_prefix(m.name.as_str())
                .is_some_and(|rest| own.contains(&rest.trim_start()))
        })
}

/// The records that a mounting is in other programs: its own, or one of each array.
fn records(m: &MountingResult, several: bool) -> Vec<CardRow> {
    let prefix = if several {
        format!("{} ", m.name)
    } else {
        String::new()
    };
    if m.arrays.is_empty() {
        return rows(m, (&prefix, &m.name));
    }
    let array = |a: &MountingResult| {
        let record = format!("{}, {}", m.name, a.name);
        rows(a, (&format!("{prefix}{} ", a.name), &record))
    };
    m.arrays.iter().flat_map(array).collect()
}

fn rows(m: &MountingResult, (prefix, record): (&str, &str)) -> Vec<CardRow> {
    let title = |name: &str| format!("{prefix}{name}");
    let angle = |name: &str, positive: &str, of: fn(&MountingAngles) -> f64| {
        let sigma = m.mounting_sigma_deg.as_ref().map(of);
        row(
            title(name),
            ("deg", positive),
            of(&m.nominal_mounting_deg),
            of(&m.mounting_deg),
            sigma,
        )
    };
    let mut all = vec![
        angle("roll", "starboard down", |a| a.roll),
        angle("pitch", "bow up", |a| a.pitch),
        angle("heading", "clockwise", |a| a.heading),
    ];
    if let (Some(before), Some(after)) = (m.nominal_lever_arm_m, m.lever_arm_m) {
        let named = [("x", "to the right"), ("y", "forward"), ("z", "up")]
            .into_iter()
            .enumerate();
        all.extend(named.map(|(i, (name, positive))| {
            let sigma = m.lever_arm_sigma_m.map(|s| s[i]);
            row(title(name), ("m", positive), before[i], after[i], sigma)
        }));
    }
    for row in &mut all {
        record.clone_into(&mut row.record);
    }
    all
}

fn row(
    name: String,
    (unit, positive): (&str, &str),
    before: f64,
    after: f64,
    sigma: Option<f64>,
) -> CardRow {
    let (after, sigma) = rounded(after, sigma, unit);
    CardRow {
        record: String::new(),
        name,
        unit: unit.to_owned(),
        positive: positive.to_owned(),
        before: shown(before, unit),
        after,
        sigma,
    }
}

/// A value and its sigma to the digits that the sigma leaves.
fn rounded(value: f64, sigma: Option<f64>, unit: &str) -> (String, String) {
    match sigma.filter(|s| *s > 0.0) {
        None if sigma == Some(0.0) => (shown(value, unit), "held".to_owned()),
        None => (shown(value, unit), String::new()),
        Some(sigma) => {
            let both = with_sigma(value, sigma);
            let (value, sigma) = both.split_once(" ± ").unwrap_or((&both, ""));
            (value.to_owned(), sigma.to_owned())
        }
    }
}

fn other(p: &Parameter) -> CardRow {
    let unit = if p.unit == "1" { "" } else { &p.unit };
    let (after, sigma) = match p.value {
        Some(value) => rounded(value, p.sigma, &p.unit),
        None => ("not determined".to_owned(), String::new()),
    };
    CardRow {
        record: String::new(),
        name: p.name.clone(),
        unit: unit.to_owned(),
        positive: p.positive.clone(),
        before: p.nominal.map_or_else(String::new, |n| shown(n, &p.unit)),
        after,
        sigma: if sigma.is_empty() {
            p.note.clone()
        } else {
            sigma
        },
    }
}
