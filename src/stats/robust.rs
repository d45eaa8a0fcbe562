//! Robust location and scale.

/// Normal-consistent factor of the median absolute deviation, `1 / Phi^-1(3/4)`.
pub const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// The median of `values` (reordered in place); `None` if there are none.
#[must_use]
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let (middle, odd) = (values.len() / 2, values.len() % 2 == 1);
    let (low, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    if odd {
        return Some(upper);
    }
    let lower = low.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (lower + upper))
}

/// Standard deviation estimated from the median absolute deviation about the median (reorders `values`).
#[must_use]
pub fn mad_sigma(values: &mut [f64]) -> Option<f64> {
    let centre = median(values)?;
    for value in values.iter_mut() {
        *value = (*value - centre).abs();
    }
    median(values).map(|deviation| MAD_TO_SIGMA * deviation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_odd_even_and_none() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&mut []), None);
    }

    #[test]
    fn mad_ignores_a_gross_error() {
        let mut values: Vec<f64> = (0..101).map(f64::from).collect();
        values[100] = 1e9;
        let sigma = mad_sigma(&mut values).expect("values");
        assert!((sigma / (25.0 * MAD_TO_SIGMA) - 1.0).abs() < 1e-12);
    }
}
