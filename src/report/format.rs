//! Numbers and names as readers expect them.

use crate::math;
use crate::results::Status;

/// Two significant digits.
pub fn two_digits(value: f64) -> String {
    significant(value, 2.0)
}

/// Three significant digits.
pub fn three_digits(value: f64) -> String {
    significant(value, 3.0)
}

fn significant(value: f64, digits: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let decimals = (digits - 1.0 - math::log10(value.abs()).floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// The unit that a figure of a parameter is shown in, and the factor to it.
pub fn finer(unit: &str) -> (&str, f64) {
    match unit {
        "m" => ("mm", 1e3),
        "s" => ("ms", 1e3),
        "1" => ("ppm", 1e6),
        unit => (unit, 1.0),
    }
}

/// A value where no sigma says how many digits count.
pub fn shown(value: f64, unit: &str) -> String {
    match unit {
        "1" => format!("{value:.6}"),
        _ => format!("{value:.4}"),
    }
}

/// 114763 as `114 763`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A probability, never shown as an exact zero.
pub fn probability(p: f64) -> String {
    match p {
        p if p < 1e-300 => "p < 1e-300".into(),
        p if p < 1e-3 => format!("p = {p:.0e}"),
        p => format!("p = {p:.3}"),
    }
}

/// How a path ended, in words.
pub fn status(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::Stalled => "stalled",
        Status::RankDeficient => "rank deficient",
        Status::OutOfIterations => "out of iterations",
        Status::Refused => "refused",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped_by_thousands() {
        assert_eq!(
            [0, 999, 1000, 114763, 10000000].map(grouped),
            ["0", "999", "1 000", "114 763", "10 000 000"]
        );
    }

    #[test]
    fn three_digits_count() {
        assert_eq!(
            [0.0123456, 123.456, 0.0, -1.0].map(three_digits),
            ["0.0123", "123", "0", "-1.00"]
        );
    }

    #[test]
    fn a_probability_is_never_an_exact_zero() {
        assert_eq!(
            [0.0, 7.2e-8, 0.0444].map(probability),
            ["p < 1e-300", "p = 7e-8", "p = 0.044"]
        );
    }
}
