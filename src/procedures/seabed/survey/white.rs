//! White noise of an INS that the survey file does not state, measured on the INS' own records.
//!
//! Four records at equal steps have the third difference `x[k+3] - 3 x[k+2] + 3 x[k+1] - x[k]`. White noise gives it 1 + 9 + 9 + 1 = 20
//! times its own variance; a swell of amplitude `a` and angular rate `w` at most `a (w d)^3`, 2e-5 deg of 2 deg in 5 s at a hundred records a
//! second. Motion, jumps and gross errors only add, so that what is measured is never less than the noise from record to record, and of slow records
//! far more. An INS whose output is smoothed errs by more than it shows here, but then by the same from record to record: that is its drift.

use super::file::TrajectorySection;
use super::filled::Given;
use crate::formats::TrajectoryRecords;
use crate::math;
use crate::units::{degrees, wrap_angle};

/// Standard deviation of a third difference over that of one record, squared.
const OF_FOUR: f64 = 20.0;
/// Fewer third differences tell nothing.
const ENOUGH: usize = 1000;
/// Steps that differ by more than this part of themselves are no equal steps.
const EQUAL: f64 = 0.1;
/// No less than this part of an ordinary installation's noise: records that are rounded or repeated show none.
const LEAST: f64 = 0.1;
/// Metres of a meridian's radian, near enough for noise.
const EARTH_M: f64 = 6.371e6;

/// Takes the noise that the records show for that of an ordinary installation where the survey file states none and they show less; says so.
pub(super) fn measured(
    section: &mut TrajectorySection,
    given: &mut Given,
    records: &TrajectoryRecords,
) -> Option<String> {
    let of = |x: &[f64], unit: f64| scatter(&records.time_s, x).map(|sigma| unit * sigma);
    let latitude_rad = *records.latitude_rad.get(records.len() / 2)?;
    let [east, north, up] = [
        of(&records.longitude_rad, EARTH_M * math::cos(latitude_rad)),
        of(&records.latitude_rad, EARTH_M),
        of(&records.height_m, 1.0),
    ];
    let [roll, pitch, heading] =
        [&records.roll_rad, &records.pitch_rad, &records.heading_rad].map(|x| of(x, degrees(1.0)));
    let larger = |a: Option<f64>, b: Option<f64>| Some(a?.max(b?));
    let each = [
        (
            "position_sigma_m",
            larger(larger(east, north), up),
            &mut section.position_sigma_m,
        ),
        (
            "roll_pitch_sigma_deg",
            larger(roll, pitch),
            &mut section.roll_pitch_sigma_deg,
        ),
        ("heading_sigma_deg", heading, &mut section.heading_sigma_deg),
    ];
    let taken = |(key, found, held): (&str, Option<f64>, &mut f64)| {
        let sigma = rounded(found?.max(LEAST * *held));
        (given.assumes(key) && sigma < *held).then(|| {
            *held = sigma;
            given.is_measured(key);
            format!("{key} = {sigma}")
        })
    };
    let words: Vec<String> = each.into_iter().filter_map(taken).collect();
    (!words.is_empty()).then(|| {
        format!(
            "not given in the survey file, measured from record to record of the trajectory: {}",
            words.join(", ")
        )
    })
}

/// Two figures.
fn rounded(sigma: f64) -> f64 {
    format!("{sigma:.1e}").parse().unwrap_or(sigma)
}

/// Standard deviation of the white noise in a column; a heading that passes north jumps by a full circle.
fn scatter(time_s: &[f64], x: &[f64]) -> Option<f64> {
    let even = |t: &[f64]| {
        let [a, b, c] = [t[1] - t[0], t[2] - t[1], t[3] - t[2]];
        (a - b).abs() < EQUAL * b && (c - b).abs() < EQUAL * b
    };
    let fours = time_s.windows(4).zip(x.windows(4));
    let third = |x: &[f64]| wrap_angle(x[3] - x[0] + 3.0 * (x[1] - x[2]));
    let all = fours.filter(|(t, _)| even(t)).map(|(_, x)| third(x));
    let (squares, count) = all.fold((0.0, 0_usize), |(s, n), d| (s + d * d, n + 1));
    let variance = squares / (OF_FOUR * count as f64);
    (count >= ENOUGH && variance.is_finite()).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use std::f64::consts::TAU;

    use super::*;
    use crate::stats::streams::stream;
    use crate::units::radians;

    const ORDINARY: [(&str, f64); 3] = [
        ("position_sigma_m", 0.01),
        ("roll_pitch_sigma_deg", 0.005),
        ("heading_sigma_deg", 0.01),
    ];

    fn section() -> TrajectorySection {
        let mut text = String::from("position_drift_sigma_m = 0\nheight_drift_sigma_m = 0\n");
        text += "drift_correlation_time_s = 120\n";
        for (key, value) in ORDINARY {
            text += &format!("{key} = {value}\n");
        }
        toml::from_str(&text).expect("a section")
    }

    /// A boat in waves that sails north: positions that scatter by 4 mm, roll and pitch by 0.002 deg, heading by 0.02 deg.
    fn sailed(step_s: f64, count: usize) -> TrajectoryRecords {
        let mut random = stream(7, 0);
        let mut noise = |sigma: f64| sigma * random.sample::<f64, _>(StandardNormal);
        let mut records = TrajectoryRecords::default();
        for k in 0..count {
            let t = step_s * k as f64;
            let wave = |size: f64| size * math::sin(TAU * t / 5.0);
            records.time_s.push(t);
            records
                .latitude_rad
                .push(0.5 + (2.0 * t + noise(0.004)) / EARTH_M);
            let east_m = EARTH_M * math::cos(0.5);
            records.longitude_rad.push(2.0 + noise(0.004) / east_m);
            records.height_m.push(wave(0.2) + noise(0.004));
            records.roll_rad.push(radians(wave(3.0) + noise(0.002)));
            records.pitch_rad.push(radians(wave(1.0) + noise(0.002)));
            let heading = wrap_angle(radians(wave(2.0) + noise(0.02)));
            records.heading_rad.push(heading.rem_euclid(TAU));
        }
        records
    }

    fn measured_of(records: &TrajectoryRecords, keys: &[usize]) -> ([f64; 3], Option<String>) {
        let mut section = section();
        let assumed = keys.iter().map(|k| ORDINARY[*k]).collect();
        let mut given = Given {
            assumed,
            ..Given::default()
        };
        let said = measured(&mut section, &mut given, records);
        let sigmas = [
            section.position_sigma_m,
            section.roll_pitch_sigma_deg,
            section.heading_sigma_deg,
        ];
        assert_eq!(said.is_none(), given.assumed.len() == keys.len());
        (sigmas, said)
    }

    #[test]
    fn records_show_their_noise_about_a_course_that_passes_north() {
        let (sigmas, said) = measured_of(&sailed(0.01, 20_000), &[0, 1, 2]);
        // 20 000 differences that are correlated over four know a sigma to 0.8 %, the largest of three to 2 %; two figures are kept
        assert!((sigmas[0] - 0.004).abs() < 1.5e-4, "{sigmas:?}");
        assert!((sigmas[1] - 0.002).abs() < 1.0e-4, "{sigmas:?}");
        let said = said.expect("a note");
        assert!(
            said.ends_with("position_sigma_m = 0.004, roll_pitch_sigma_deg = 0.002"),
            "{said}"
        );
        // 0.02 deg are more than an ordinary installation has
        assert_eq!(sigmas[2], 0.01);
    }

    #[test]
    fn a_wave_in_slow_records_is_no_noise_and_what_is_stated_stays() {
        let (slow, said) = measured_of(&sailed(1.0, 4000), &[0, 1, 2]);
        assert_eq!((slow, said), (ORDINARY.map(|(_, sigma)| sigma), None));
        let (few, _) = measured_of(&sailed(0.01, 1002), &[0, 1, 2]);
        assert_eq!(few, ORDINARY.map(|(_, sigma)| sigma));
        let (stated, _) = measured_of(&sailed(0.01, 20_000), &[1]);
        assert_eq!(stated[0], 0.01);
    }
}
