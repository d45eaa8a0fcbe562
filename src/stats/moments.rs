//! Streaming mean and variance of several figures at once.

/// Count, means and sums of squares; Welford's recurrence about the mean (*Technometrics* 4, 1962).
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    count: u64,
    mean: Vec<f64>,
    about_mean: Vec<f64>,
    about_zero: Vec<f64>,
}

impl Moments {
    /// Of nothing yet, for sets of `figures` figures.
    #[must_use]
    pub fn new(figures: usize) -> Self {
        let zero = vec![0.0; figures];
        Self {
            count: 0,
            mean: zero.clone(),
            about_mean: zero.clone(),
            about_zero: zero,
        }
    }

    /// Adds one set of figures.
    pub fn add(&mut self, figures: &[f64]) {
        self.count += 1;
        for (i, x) in figures.iter().enumerate().take(self.mean.len()) {
            let off = x - self.mean[i];
            self.mean[i] += off / self.count as f64;
            self.about_mean[i] += off * (x - self.mean[i]);
            self.about_zero[i] += x * x;
        }
    }

    /// How many were added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Means; `None` of nothing.
    #[must_use]
    pub fn mean(&self) -> Option<Vec<f64>> {
        (self.count > 0).then(|| self.mean.clone())
    }

    /// Unbiased variances about the means; `None` of fewer than two.
    #[must_use]
    pub fn variance(&self) -> Option<Vec<f64>> {
        let freedom = (self.count.checked_sub(1)?) as f64;
        let scaled = || self.about_mean.iter().map(|s| s / freedom).collect();
        (freedom > 0.0).then(scaled)
    }

    /// Root mean squares about zero; `None` of nothing.
    #[must_use]
    pub fn rms(&self) -> Option<Vec<f64>> {
        let n = self.count as f64;
        (n > 0.0).then(|| self.about_zero.iter().map(|s| (s / n).sqrt()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2, 4, 4, 4, 5, 5, 7, 9: mean 5, sum of squares about it 32, about zero 232.
    #[test]
    fn moments_against_hand_values() {
        let mut m = Moments::new(4);
        assert_eq!((m.mean(), m.variance(), m.rms()), (None, None, None));
        for x in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            m.add(&[x, -x, x + 1e9, 0.0]);
        }
        let near = |found: f64, expected: f64, tolerance: f64| {
            assert!((found - expected).abs() < tolerance, "{found} {expected}");
        };
        let (mean, variance) = (m.mean().expect("mean"), m.variance().expect("variance"));
        near(mean[0], 5.0, 1e-14);
        near(mean[1], -5.0, 1e-14);
        near(variance[0], 32.0 / 7.0, 1e-14);
        near(variance[2], 32.0 / 7.0, 1e-6);
        assert_eq!(variance[3], 0.0);
        near(m.rms().expect("rms")[0], 29.0_f64.sqrt(), 1e-14);
    }
}
