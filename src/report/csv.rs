//! `parameters.csv`: every parameter of every solution, before and after.

use crate::results::{Calibration, Parameter};
use std::fmt::Write;

const HEAD: &str = "solution,parameter,unit,before,after,correction,sigma,determined,usable\n";

/// The table with a header line, numbers with all their digits; a value that is not there is an empty cell.
#[must_use]
pub fn parameters(result: &Calibration) -> String {
    let mut text = HEAD.to_owned();
    for (name, solution) in result.solutions.named() {
        for parameter in &solution.parameters {
            line(&mut text, name, parameter, solution.usable);
        }
    }
    text
}

fn line(text: &mut String, solution: &str, p: &Parameter, usable: bool) {
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let numbers = [p.nominal, p.value, p.correction, p.sigma].map(number);
    let _ = writeln!(
        text,
        "{solution},{name},{unit},{numbers},{determined},{usable}",
        name = quoted(&p.name),
        unit = p.unit,
        numbers = numbers.join(","),
        determined = p.determined,
    );
}

/// RFC 4180: quoted where a separator, a quote or a line end stands in it.
fn quoted(name: &str) -> String {
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
