//! Means over the standard normal distribution.

/// Means of some figures over the standard normal distribution cut at `reach`, by the midpoint rule in this number of steps.
#[must_use]
pub fn normal_means<const N: usize>(
    reach: f64,
    steps: u32,
    figures: impl Fn(f64) -> [f64; N],
) -> [f64; N] {
    let step = 2.0 * reach / f64::from(steps);
    let (mut mass, mut sums) = (0.0, [0.0; N]);
    for i in 0..steps {
        let z = -reach + step * (f64::from(i) + 0.5);
        let weight = (-0.5 * z * z).exp();
        mass += weight;
        for (sum, figure) in sums.iter_mut().zip(figures(z)) {
            *sum += weight * figure;
        }
    }
    sums.map(|sum| sum / mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn moments_of_the_normal_distribution() {
        let [first, second, fourth] = normal_means(10.0, 4000, |z| [z, z * z, z.powi(4)]);
        assert_abs_diff_eq!(first, 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(second, 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(fourth, 3.0, epsilon = 1e-12);
    }
}
