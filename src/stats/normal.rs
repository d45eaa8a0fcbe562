//! The standard normal distribution: means over it, its probabilities, draws from it.

use std::sync::LazyLock;

use rand::distr::{Distribution, Open01, StandardUniform};
use rand::{Rng, RngExt};

use crate::math;

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
        let weight = math::exp(-0.5 * z * z);
        mass += weight;
        for (sum, figure) in sums.iter_mut().zip(figures(z)) {
            *sum += weight * figure;
        }
    }
    sums.map(|sum| sum / mass)
}

/// Probability of more than `x`, with all its digits where it is small.
#[must_use]
pub fn above(x: f64) -> f64 {
    0.5 * math::erfc(x * std::f64::consts::FRAC_1_SQRT_2)
}

/// The value that is exceeded with probability `1 - probability`; infinite at 0 and 1, not a number outside. Wichura's algorithm
/// AS 241 (*Applied Statistics* 37, 1988), to about 1e-16 of itself.
#[must_use]
pub fn quantile(probability: f64) -> f64 {
    let q = probability - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        return q * ratio(&MIDDLE, r);
    }
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    let tail = if q < 0.0 {
        probability
    } else {
        1.0 - probability
    };
    if tail == 0.0 {
        return f64::INFINITY.copysign(q);
    }
    let r = (-math::ln(tail)).sqrt();
    let found = match r <= 5.0 {
        true => ratio(&NEAR, r - 1.6),
        false => ratio(&FAR, r - 5.0),
    };
    found.copysign(q)
}

/// Numerator and denominator, ascending powers.
type Ratio = [[f64; 8]; 2];

fn ratio([above, below]: &Ratio, x: f64) -> f64 {
    let value = |c: &[f64; 8]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    value(above) / value(below)
}

#[rustfmt::skip]
#[expect(clippy::excessive_precision, reason = "digits as printed")]
const MIDDLE: Ratio = [
    [3.387_132_872_796_366_608, 133.141_667_891_784_377_45, 1_971.590_950_306_551_442_7, 13_731.693_765_509_461_125,
     45_921.953_931_549_871_457, 67_265.770_927_008_700_853, 33_430.575_583_588_128_105, 2_509.080_928_730_122_672_7],
    [1.0, 42.313_330_701_600_911_252, 687.187_007_492_057_908_3, 5_394.196_021_424_751_107_7,
     21_213.794_301_586_595_867, 39_307.895_800_092_710_61, 28_729.085_735_721_942_674, 5_226.495_278_852_854_561],
];
#[rustfmt::skip]
#[expect(clippy::excessive_precision, reason = "digits as printed")]
const NEAR: Ratio = [
    [1.423_437_110_749_683_577_34, 4.630_337_846_156_545_295_9, 5.769_497_221_460_691_405_5, 3.647_848_324_763_204_605_04,
     1.270_458_252_452_368_382_58, 0.241_780_725_177_450_611_77, 0.022_723_844_989_269_184_583_3, 7.745_450_142_783_414_076_4e-4],
    [1.0, 2.053_191_626_637_758_821_87, 1.676_384_830_183_803_849_4, 0.689_767_334_985_100_004_55,
     0.148_103_976_427_480_074_59, 0.015_198_666_563_616_457_196_6, 5.475_938_084_995_344_946e-4, 1.050_750_071_644_416_843_24e-9],
];
#[rustfmt::skip]
#[expect(clippy::excessive_precision, reason = "digits as printed")]
const FAR: Ratio = [
    [6.657_904_643_501_103_777_2, 5.463_784_911_164_114_369_9, 1.784_826_539_917_291_335_8, 0.296_560_571_828_504_891_23,
     0.026_532_189_526_576_123_093, 1.242_660_947_388_078_438_6e-3, 2.711_555_568_743_487_578_15e-5, 2.010_334_399_292_288_132_65e-7],
    [1.0, 0.599_832_206_555_887_937_69, 0.136_929_880_922_735_805_31, 0.014_875_361_290_850_615_025,
     7.868_691_311_456_132_591e-4, 1.846_318_317_510_054_681_8e-5, 1.421_511_758_316_445_888_7e-7, 2.044_263_103_389_939_785_64e-15],
];

/// Draws a number of the standard normal distribution: the ziggurat of Marsaglia and Tsang as Doornik has it ("An improved ziggurat
/// method to generate normal random samples", 2005), with the same use of the generator's words as the crate `rand_distr`.
pub fn draw<R: Rng + ?Sized>(random: &mut R) -> f64 {
    let layers = &*LAYERS;
    loop {
        let bits = random.next_u64();
        let layer = (bits & 0xff) as usize;
        // a number of [2, 4) from the upper bits
        let u = f64::from_bits(bits >> 12 | 0x4000_0000_0000_0000) - 3.0;
        let x = u * layers.x[layer];
        if x.abs() < layers.x[layer + 1] {
            return x;
        }
        if layer == 0 {
            return beyond(random, u < 0.0);
        }
        let (low, high) = (layers.density[layer], layers.density[layer + 1]);
        let share: f64 = StandardUniform.sample(random);
        if high + (low - high) * share < math::exp(-x * x / 2.0) {
            return x;
        }
    }
}

/// A draw from the tail.
fn beyond<R: Rng + ?Sized>(random: &mut R, negative: bool) -> f64 {
    loop {
        let [a, b]: [f64; 2] = [random.sample(Open01), random.sample(Open01)];
        let (x, y) = (math::ln(a) / LAST, math::ln(b));
        if -2.0 * y >= x * x {
            return if negative { x - LAST } else { LAST - x };
        }
    }
}

/// Where the tail begins, and the area of each of the 256 layers.
const LAST: f64 = 3.654_152_885_361_009;
const AREA: f64 = 0.004_928_673_233_99;

/// The ziggurat's layers from the tail up to the middle.
struct Layers {
    x: [f64; 257],
    density: [f64; 257],
}

static LAYERS: LazyLock<Layers> = LazyLock::new(|| {
    let density = |x: f64| math::exp(-0.5 * x * x);
    let mut x = [0.0; 257];
    (x[0], x[1]) = (AREA / density(LAST), LAST);
    for i in 2..256 {
        x[i] = (-2.0 * math::ln(AREA / x[i - 1] + density(x[i - 1]))).sqrt();
    }
    Layers {
        density: x.map(density),
        x,
    }
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::stream;
    use approx::assert_abs_diff_eq;
    use rand_distr::StandardNormal;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn moments_of_the_normal_distribution() {
        let [first, second, fourth] = normal_means(10.0, 4000, |z| [z, z * z, z.powi(4)]);
        assert_abs_diff_eq!(first, 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(second, 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(fourth, 3.0, epsilon = 1e-12);
    }

    #[test]
    fn quantiles_and_probabilities_belong_together() {
        for p in [1e-300, 1e-30, 1e-12, 1e-4, 0.02, 0.074, 0.076, 0.3, 0.5] {
            let x = quantile(p);
            assert!(
                (above(-x) / p - 1.0).abs() < 1e-12 * (1.0 + x * x),
                "{p}: {x}"
            );
        }
        assert_abs_diff_eq!(quantile(0.975), -quantile(0.025), epsilon = 1e-14);
        assert_abs_diff_eq!(quantile(0.975), 1.959_963_984_540_054, epsilon = 1e-14);
        assert_eq!(quantile(0.0), f64::NEG_INFINITY);
        assert_eq!(quantile(1.0), f64::INFINITY);
        assert!(quantile(1.1).is_nan() && quantile(f64::NAN).is_nan());
        for x in [-6.0, -1.0, 0.0, 0.7, 3.0, 9.0] {
            let other = Normal::standard().sf(x);
            assert!((above(x) / other - 1.0).abs() < 1e-9, "{x}");
        }
    }

    /// The same words give the same draws, the tails included, but for the last bits.
    #[test]
    fn draws_are_those_of_rand_distr() {
        let (mut own, mut other) = (stream(7, 3), stream(7, 3));
        let (mut tails, mut largest) = (0, 0.0_f64);
        for _ in 0..300_000 {
            let (found, expected): (f64, f64) = (draw(&mut own), StandardNormal.sample(&mut other));
            largest = largest.max((found - expected).abs());
            tails += usize::from(found.abs() > LAST);
        }
        assert!(tails > 30 && largest < 1e-11, "{tails} {largest}");
    }
}
