//! `parameters.csv`: the values to enter first, then every parameter of every solution, before and after.

use super::card::card;
use crate::results::{Calibration, Parameter};
use std::fmt::Write;

const HEAD: &str =
    "solution,parameter,unit,before,after,correction,sigma,determined,usable,verdict\n";

/// The table with a header line. The first rows, of the solution `enter`, are the values to enter with the digits that their sigmas
/// leave; the others have all their digits. A value that is not there is an empty cell.
#[must_use]
pub fn parameters(result: &Calibration) -> String {
    let mut text = HEAD.to_owned();
    let verdict = result.verdict.state.words();
    enter(&mut text, result, verdict);
    for (name, solution) in result.solutions.named() {
        for parameter in &solution.parameters {
            line(&mut text, name, parameter, (solution.usable, verdict));
        }
    }
    text
}

/// The card's rows.
fn enter(text: &mut String, result: &Calibration, verdict: &str) {
    for row in card(result).iter().flat_map(|card| &card.rows) {
        let sigma = row.sigma.parse::<f64>().map_or("", |_| &row.sigma);
        let after = row.after.parse::<f64>().map_or("", |_| &row.after);
        let _ = writeln!(
            text,
            "enter,{name},{unit},{before},{after},,{sigma},{determined},true,{verdict}",
            name = quoted(&row.name),
            unit = row.unit,
            before = row.before,
            determined = !after.is_empty(),
        );
    }
}

fn line(text: &mut String, solution: &str, p: &Parameter, (usable, verdict): (bool, &str)) {
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let numbers = [p.nominal, p.value, p.correction, p.sigma].map(number);
    let _ = writeln!(
        text,
        "{solution},{name},{unit},{numbers},{determined},{usable},{verdict}",
        name = quoted(&p.name),
        unit = p.unit,
        numbers = numbers.join(","),
        determined = p.determined,
    );
}

/// RFC 4180: quoted where a separator, a quote or a line end stands in it.
pub(super) fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_separator_is_quoted() {
        assert_eq!(quoted("head \"1\", left"), "\"head \"\"1\"\", left\"");
        assert_eq!(quoted("roll"), "roll");
    }
}
