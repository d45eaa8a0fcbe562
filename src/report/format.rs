//! Numbers and names as readers expect them.

use crate::results::{Angles, SixSigmas, SixValues, Status};

/// One of the six parameters, with what is shown of it.
pub struct Row {
    /// Name as in the covariance.
    pub name: &'static str,
    /// Meaning of a positive value, body frame.
    pub sense: &'static str,
    /// Unit shown.
    pub unit: &'static str,
}

/// The six parameters in the covariance's order; lever arms are shown in millimetres.
pub const ROWS: [Row; 6] = [
    Row {
        name: "pitch",
        sense: "bow up",
        unit: "deg",
    },
    Row {
        name: "roll",
        sense: "starboard down",
        unit: "deg",
    },
    Row {
        name: "yaw",
        sense: "counter-clockwise",
        unit: "deg",
    },
    Row {
        name: "lx",
        sense: "to the right",
        unit: "mm",
    },
    Row {
        name: "ly",
        sense: "forward",
        unit: "mm",
    },
    Row {
        name: "lz",
        sense: "up",
        unit: "mm",
    },
];

/// Angles and lever arm in the rows' units.
pub fn shown(angles_deg: Angles, lever_m: [f64; 3]) -> [f64; 6] {
    let [x, y, z] = lever_m.map(millimetres);
    [angles_deg.pitch, angles_deg.roll, angles_deg.yaw, x, y, z]
}

/// Standard deviations in the rows' units.
pub fn shown_sigmas(s: &SixSigmas) -> [f64; 6] {
    [
        s.pitch_deg,
        s.roll_deg,
        s.yaw_deg,
        millimetres(s.lx_m),
        millimetres(s.ly_m),
        millimetres(s.lz_m),
    ]
}

/// Three significant digits.
pub fn three_digits(value: f64) -> String {
    significant(value, 3.0)
}

/// Four significant digits.
pub fn four_digits(value: f64) -> String {
    significant(value, 4.0)
}

fn significant(value: f64, digits: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let decimals = (digits - 1.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
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

/// In the rows' order.
pub fn in_order(v: &SixValues) -> [f64; 6] {
    [v.pitch, v.roll, v.yaw, v.lx, v.ly, v.lz]
}

/// Metres to millimetres.
pub fn millimetres(metres: f64) -> f64 {
    metres * 1e3
}

/// A value in a row's unit where no sigma says how many digits count.
pub fn plain(value: f64, unit: &str) -> String {
    if unit == "deg" {
        format!("{value:.4}")
    } else {
        format!("{value:.1}")
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
    fn four_digits_count() {
        assert_eq!(
            [0.0123456, 123.456, -1.0, 0.0].map(four_digits),
            ["0.01235", "123.5", "-1.000", "0"]
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
