//! The border between degrees and radians, and the formatting of a value with its standard deviation.
//!
//! Inside the program every angle is in radians and every length in metres; degrees exist only in files and reports.

use crate::math;

/// Degrees to radians.
#[must_use]
pub fn radians(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// Radians to degrees.
#[must_use]
pub fn degrees(radians: f64) -> f64 {
    radians.to_degrees()
}

/// A value rounded to so many figures.
#[must_use]
pub fn to_figures(value: f64, figures: usize) -> f64 {
    let decimals = figures.saturating_sub(1);
    format!("{value:.decimals$e}").parse().unwrap_or(value)
}

/// An angle wrapped into (-pi, pi], radians.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let wrapped = angle_rad.rem_euclid(turn);
    if wrapped > turn / 2.0 {
        wrapped - turn
    } else {
        wrapped
    }
}

/// `value ± sigma` with the standard deviation to two significant digits and the value to the same place.
///
/// ```
/// assert_eq!(boresight::units::with_sigma(0.600312, 0.00551), "0.6003 ± 0.0055");
/// assert_eq!(boresight::units::with_sigma(-12.0, 0.0), "-12");
/// ```
#[must_use]
pub fn with_sigma(value: f64, sigma: f64) -> String {
    if !(sigma > 0.0 && sigma.is_finite()) {
        return format!("{value}");
    }
    let decimals = (1.0 - math::log10(sigma).floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} ± {sigma:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_wrap_into_the_half_open_turn() {
        assert!((wrap_angle(radians(350.0)) - radians(-10.0)).abs() < 1e-15);
        assert!((wrap_angle(radians(-190.0)) - radians(170.0)).abs() < 1e-15);
        assert!((wrap_angle(std::f64::consts::PI) - std::f64::consts::PI).abs() < 1e-15);
    }

    #[test]
    fn sigma_decides_the_digits() {
        assert_eq!(with_sigma(1234.5678, 12.0), "1235 ± 12");
        assert_eq!(with_sigma(0.1, 0.00123), "0.1000 ± 0.0012");
    }
}
