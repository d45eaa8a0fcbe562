//! The chi-square distribution, by the incomplete gamma function (DLMF 8.7.1 and 8.9.2).

use crate::math;

/// A chi-square distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Half the degrees of freedom.
    shape: f64,
}

/// Terms after which a sum is taken as it is: many more than any shape below 1e9 needs.
const MOST_TERMS: u32 = 1_000_000;

/// Steps of the search for a quantile: bisection alone would reach the last bit.
const MOST_STEPS: u32 = 200;

impl ChiSquare {
    /// With these degrees of freedom; `None` unless they are a positive number.
    #[must_use]
    pub fn new(degrees: f64) -> Option<Self> {
        let shape = 0.5 * degrees;
        (degrees > 0.0 && degrees.is_finite()).then_some(Self { shape })
    }

    /// Probability of no more than `x`.
    #[must_use]
    pub fn below(&self, x: f64) -> f64 {
        self.both(x).0
    }

    /// Probability of more than `x`, with all its digits where it is small.
    #[must_use]
    pub fn above(&self, x: f64) -> f64 {
        self.both(x).1
    }

    fn both(&self, x: f64) -> (f64, f64) {
        let (a, half) = (self.shape, 0.5 * x);
        if x.is_nan() {
            return (f64::NAN, f64::NAN);
        }
        if half <= 0.0 {
            return (0.0, 1.0);
        }
        if half == f64::INFINITY {
            return (1.0, 0.0);
        }
        if half < a + 1.0 {
            let below = (self.term(half) * series(a, half)).min(1.0);
            (below, 1.0 - below)
        } else {
            let above = (self.term(half) * fraction(a, half)).min(1.0);
            (1.0 - above, above)
        }
    }

    /// `x^a e^-x / Gamma(a)`. For large `a` by Stirling's series, as the logarithms of the factors would cancel.
    fn term(&self, x: f64) -> f64 {
        let a = self.shape;
        if a < 10.0 {
            return math::exp(a * math::ln(x) - x - math::ln_gamma(a));
        }
        let away = (x - a) / a;
        let rest = 1.0 / (12.0 * a) - 1.0 / (360.0 * a.powi(3)) + 1.0 / (1260.0 * a.powi(5))
            - 1.0 / (1680.0 * a.powi(7));
        (a / std::f64::consts::TAU).sqrt() * math::exp(a * (math::ln_1p(away) - away) - rest)
    }

    /// The value that is exceeded with probability `1 - probability`; 0 at 0, infinite at 1, not a number outside.
    #[must_use]
    pub fn quantile(&self, probability: f64) -> f64 {
        if !(0.0..=1.0).contains(&probability) {
            return f64::NAN;
        }
        if probability == 0.0 || probability == 1.0 {
            return if probability == 0.0 {
                0.0
            } else {
                f64::INFINITY
            };
        }
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut x = self.first_guess(probability);
        for _ in 0..MOST_STEPS {
            let (below, above) = self.both(x);
            // the smaller of the two has all its digits
            let off = match probability < 0.5 {
                true => below - probability,
                false => (1.0 - probability) - above,
            };
            if off < 0.0 {
                low = x;
            } else {
                high = x;
            }
            let density = self.term(0.5 * x) / x;
            let mut next = x - off / density;
            if !(next > low && next < high) {
                next = match high.is_finite() {
                    true => 0.5 * (low + high),
                    false => 2.0 * x,
                };
            }
            if (next - x).abs() <= 1e-15 * x || next == x {
                return next;
            }
            x = next;
        }
        x
    }

    /// Wilson and Hilferty's, *PNAS* 17 (1931); the power law near 0 where that is not positive.
    fn first_guess(&self, probability: f64) -> f64 {
        let degrees = 2.0 * self.shape;
        let spread = 2.0 / (9.0 * degrees);
        let root = 1.0 - spread + super::normal::quantile(probability) * spread.sqrt();
        if root > 0.1 {
            return degrees * root.powi(3);
        }
        let a = self.shape;
        let power = (math::ln(probability * a) + math::ln_gamma(a)) / a;
        (2.0 * math::exp(power)).max(f64::MIN_POSITIVE)
    }
}

/// Lower incomplete gamma function over its first factor, by its power series.
fn series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum) = (1.0 / a, 1.0 / a);
    for k in 1..MOST_TERMS {
        term *= x / (a + f64::from(k));
        sum += term;
        if term <= 1e-17 * sum {
            break;
        }
    }
    sum
}

/// Upper incomplete gamma function over its first factor, by its continued fraction (Lentz's way).
fn fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut h = d;
    for k in 1..MOST_TERMS {
        let k = f64::from(k);
        let an = -k * (k - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / if d.abs() < TINY { TINY } else { d };
        c = b + an / c;
        c = if c.abs() < TINY { TINY } else { c };
        h *= c * d;
        if (c * d - 1.0).abs() <= 2e-16 {
            break;
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn two_degrees_are_the_exponential_distribution() {
        let chi = ChiSquare::new(2.0).expect("degrees");
        for x in [1e-8, 0.3, 1.0, 2.0, 7.5, 40.0, 300.0] {
            let above = math::exp(-0.5 * x);
            assert!((chi.above(x) / above - 1.0).abs() < 1e-13, "{x}");
            assert!(
                (chi.below(x) / -math::exp_m1(-0.5 * x) - 1.0).abs() < 1e-13,
                "{x}"
            );
        }
        for p in [1e-12, 1e-3, 0.25, 0.5, 0.975] {
            let x = -2.0 * math::ln_1p(-p);
            assert!((chi.quantile(p) / x - 1.0).abs() < 1e-13, "{p}");
        }
    }

    /// Another implementation, whose own digits are some 12 where the shape is large, and 4 of the quantile of one degree near 0
    /// (there `pi p^2 / 2` is the answer).
    #[test]
    fn as_another_library_says() {
        for degrees in [1.0, 3.0, 6.0, 19.0, 20.5, 144.0, 1000.0, 60_000.0] {
            let (own, other) = (
                ChiSquare::new(degrees).expect("degrees"),
                ChiSquared::new(degrees).expect("degrees"),
            );
            for factor in [0.1, 0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 1.6, 4.0] {
                let x = factor * degrees;
                let near = |a: f64, b: f64| (a - b).abs() < 1e-11 + 1e-9 * b.abs();
                assert!(near(own.below(x), other.cdf(x)), "{degrees} {x}");
                assert!(near(own.above(x), other.sf(x)), "{degrees} {x}");
            }
            for p in [5e-5, 0.0005, 0.025, 0.3, 0.5, 0.9, 0.999, 1.0 - 1e-9] {
                let (x, expected) = (own.quantile(p), other.inverse_cdf(p));
                let expected = match (degrees, p) {
                    (1.0, p) if p < 1e-3 => 0.5 * std::f64::consts::PI * p * p,
                    _ => expected,
                };
                assert!(
                    (x / expected - 1.0).abs() < 1e-6,
                    "{degrees} {p} {x} {expected}"
                );
                let again = if p < 0.5 {
                    own.below(x) - p
                } else {
                    (1.0 - p) - own.above(x)
                };
                assert!(
                    again.abs() < 1e-10 * p.min(1.0 - p),
                    "{degrees} {p} {again}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_distribution_or_probability_is_refused() {
        assert!(ChiSquare::new(0.0).is_none() && ChiSquare::new(f64::NAN).is_none());
        let chi = ChiSquare::new(3.0).expect("degrees");
        assert_eq!((chi.below(-1.0), chi.above(-1.0)), (0.0, 1.0));
        assert_eq!((chi.quantile(0.0), chi.quantile(1.0)), (0.0, f64::INFINITY));
        assert!(chi.quantile(1.5).is_nan() && chi.below(f64::NAN).is_nan());
    }
}
