//! White noise of an INS that the survey file does not state, measured on the INS' own records.
//!
//! Four records at equal steps have the third difference `x[k+3] - 3 x[k+2] + 3 x[k+1] - x[k]`. White noise gives it 1 + 9 + 9 + 1 = 20
//! times its own variance; a swell of amplitude `a` and angular rate `w` at a spacing `d` at most `a (w d)^3`, 4e-6 deg of 2 deg in 5 s at a hundred
//! records a second, 4e-3 at ten. Motion and jumps only add. What would hide noise is refused: columns that were interpolated or rounded have
//! third differences that are mostly nothing and seldom much, unlike those of noise, whose median tells the same sigma as their mean square.
//! Positions between which a recorder's own navigation was interpolated are looked at as they were recorded.
//!
//! An INS whose output is smoothed errs by more than it shows here, but then by the same from record to record, which is its drift. That it has no
//! white noise at all is not believed: at least a tenth of an ordinary installation's is taken.

use super::file::TrajectorySection;
use super::filled::Given;
use crate::formats::TrajectoryRecords;
use crate::math;
use crate::recorders::Fixes;
use crate::stats::robust::mad_sigma;
use crate::units::{degrees, to_figures, wrap_angle};

/// Standard deviation of a third difference over that of one record, squared.
const OF_FOUR: f64 = 20.0;
/// Fewer third differences tell nothing.
const ENOUGH: usize = 1000;
/// Steps that differ by more than this part of themselves are no equal steps.
const EQUAL: f64 = 0.1;
/// No less than this part of an ordinary installation's noise: records that are rounded or repeated show none.
const LEAST: f64 = 0.1;
/// The median's sigma of third differences is at least this part of their root mean square where they are noise and not the knots of an interpolation or
/// the steps of a rounding.
const NORMAL: f64 = 0.7;
/// Metres of a meridian's radian, near enough for noise.
const EARTH_M: f64 = 6.371e6;

/// Takes the noise that the records show for that of an ordinary installation where the survey file states none and they show less; says so.
pub(super) fn measured(
    section: &mut TrajectorySection,
    given: &mut Given,
    (records, fixes): (&TrajectoryRecords, Option<&Fixes>),
) -> Vec<String> {
    let (mut shown, mut least) = (vec![], vec![]);
    for (key, found) in found(records, fixes) {
        let held = match key {
            "position_sigma_m" => &mut section.position_sigma_m,
            "roll_pitch_sigma_deg" => &mut section.roll_pitch_sigma_deg,
            _ => &mut section.heading_sigma_deg,
        };
        let Some(found) = found.filter(|found| given.assumes(key) && found < held) else {
            continue;
        };
        let floor = LEAST * *held;
        *held = to_figures(found.max(floor), 2);
        let words = format!("{key} = {held}");
        match found < floor {
            true => least.push(words),
            false => shown.push(words),
        }
        given.take_out(key, found < floor);
    }
    let said = |how: &str, words: &[String]| {
        let each = words.join(", ");
        (!words.is_empty()).then(|| format!("not given in the survey file, {how}: {each}"))
    };
    let shown = said("measured from record to record of the trajectory", &shown);
    let least = said(
        "a tenth of an ordinary installation's, for the trajectory shows less from record to record",
        &least,
    );
    shown.into_iter().chain(least).collect()
}

/// The noise of each key that the records show, metres and degrees.
fn found(records: &TrajectoryRecords, fixes: Option<&Fixes>) -> [(&'static str, Option<f64>); 3] {
    let angle = |x: &[f64]| turned(&records.time_s, x).map(degrees);
    let roll_pitch = larger(angle(&records.roll_rad), angle(&records.pitch_rad));
    [
        ("position_sigma_m", position_m(records, fixes)),
        ("roll_pitch_sigma_deg", roll_pitch),
        ("heading_sigma_deg", angle(&records.heading_rad)),
    ]
}

/// The largest of the three components' noise, metres.
fn position_m(records: &TrajectoryRecords, fixes: Option<&Fixes>) -> Option<f64> {
    let own_height = || straight(&records.time_s, &records.height_m);
    let Some(fixes) = fixes else {
        let level = level_m(
            &records.time_s,
            &records.latitude_rad,
            &records.longitude_rad,
        );
        return larger(level, own_height());
    };
    let level = level_m(&fixes.time_s, &fixes.latitude_rad, &fixes.longitude_rad);
    let fixed = larger(level, straight(&fixes.time_s, &fixes.height_m));
    match fixes.with_heave {
        true => larger(fixed, own_height()),
        false => fixed,
    }
}

/// The larger noise of north and east, metres.
fn level_m(time_s: &[f64], latitude_rad: &[f64], longitude_rad: &[f64]) -> Option<f64> {
    let about = latitude_rad.get(latitude_rad.len() / 2)?;
    let east = turned(time_s, longitude_rad)? * math::cos(*about);
    larger(Some(east), straight(time_s, latitude_rad)).map(|noise| EARTH_M * noise)
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    Some(a?.max(b?))
}

fn straight(time_s: &[f64], x: &[f64]) -> Option<f64> {
    scatter(time_s, x, third)
}

/// The same of angles: a full circle is no noise.
fn turned(time_s: &[f64], x: &[f64]) -> Option<f64> {
    scatter(time_s, x, |x| wrap_angle(third(x)))
}

/// Third difference of four.
fn third(x: &[f64]) -> f64 {
    x[3] - x[0] + 3.0 * (x[1] - x[2])
}

/// Standard deviation of the white noise in a column; nothing of one that was interpolated or rounded, or is short.
fn scatter(time_s: &[f64], x: &[f64], third: impl Fn(&[f64]) -> f64) -> Option<f64> {
    let even = |t: &[f64]| {
        let [a, b, c] = [t[1] - t[0], t[2] - t[1], t[3] - t[2]];
        (a - b).abs() < EQUAL * b && (c - b).abs() < EQUAL * b
    };
    let fours = time_s.windows(4).zip(x.windows(4));
    let all = fours.filter(|(t, _)| even(t)).map(|(_, x)| third(x));
    let mut all: Vec<f64> = all.collect();
    let squares: f64 = all.iter().map(|d| d * d).sum();
    let rms = (squares / all.len() as f64).sqrt();
    let enough = all.len() >= ENOUGH && rms.is_finite();
    (enough && mad_sigma(&mut all)? >= NORMAL * rms).then(|| rms / OF_FOUR.sqrt())
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

    fn measured_of(records: &TrajectoryRecords, keys: &[usize]) -> ([f64; 3], Vec<String>) {
        measured_with(records, None, keys)
    }

    fn measured_with(
        records: &TrajectoryRecords,
        fixes: Option<&Fixes>,
        keys: &[usize],
    ) -> ([f64; 3], Vec<String>) {
        let mut section = section();
        let assumed = keys.iter().map(|k| ORDINARY[*k]).collect();
        let mut given = Given {
            assumed,
            ..Given::default()
        };
        let said = measured(&mut section, &mut given, (records, fixes));
        let sigmas = [
            section.position_sigma_m,
            section.roll_pitch_sigma_deg,
            section.heading_sigma_deg,
        ];
        assert_eq!(said.is_empty(), given.assumed.len() == keys.len());
        (sigmas, said)
    }

    #[test]
    fn records_show_their_noise_about_a_course_that_passes_north() {
        let (sigmas, said) = measured_of(&sailed(0.01, 20_000), &[0, 1, 2]);
        // 20 000 differences that are correlated over four know a sigma to 0.8 %, the largest of three to 2 %; two figures are kept
        assert!((sigmas[0] - 0.004).abs() < 1.5e-4, "{sigmas:?}");
        assert!((sigmas[1] - 0.002).abs() < 1.0e-4, "{sigmas:?}");
        let [said] = &said[..] else {
            panic!("{said:?}");
        };
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
        assert_eq!((slow, said), (ORDINARY.map(|(_, sigma)| sigma), vec![]));
        let (few, _) = measured_of(&sailed(0.01, 1002), &[0, 1, 2]);
        assert_eq!(few, ORDINARY.map(|(_, sigma)| sigma));
        let (stated, _) = measured_of(&sailed(0.01, 20_000), &[1]);
        assert_eq!(stated[0], 0.01);
    }

    /// Positions twenty times a second between which the recorder's own navigation is interpolated, and those positions.
    fn interpolated() -> (TrajectoryRecords, Fixes) {
        let mut records = sailed(0.01, 20_000);
        let fifth = |x: &[f64]| x.iter().step_by(5).copied().collect::<Vec<f64>>();
        let fixes = Fixes {
            time_s: fifth(&records.time_s),
            latitude_rad: fifth(&records.latitude_rad),
            longitude_rad: fifth(&records.longitude_rad),
            height_m: fifth(&records.height_m),
            with_heave: false,
        };
        let between = |x: &[f64]| -> Vec<f64> {
            let at = |k: usize| {
                let (a, part) = (k / 5, (k % 5) as f64 / 5.0);
                x[a] + part * (x[(a + 1).min(x.len() - 1)] - x[a])
            };
            (0..20_000).map(at).collect()
        };
        records.latitude_rad = between(&fixes.latitude_rad);
        records.longitude_rad = between(&fixes.longitude_rad);
        records.height_m = between(&fixes.height_m);
        (records, fixes)
    }

    #[test]
    fn positions_are_looked_at_before_they_were_interpolated_and_heave_beside_them() {
        let (mut records, mut fixes) = interpolated();
        let (unknown, _) = measured_of(&records, &[0]);
        assert_eq!(unknown[0], 0.01);
        // 4000 differences that are correlated over four know a sigma to 2 %, the largest of three to 4 %
        let (sigmas, said) = measured_with(&records, Some(&fixes), &[0]);
        assert!((sigmas[0] - 0.004).abs() < 3e-4, "{sigmas:?} {said:?}");
        // a heave of 8 mm, and one in centimetres, which does not tell
        let heave = sailed(0.01, 20_000).height_m;
        fixes.with_heave = true;
        records.height_m = heave.iter().map(|h| 2.0 * h).collect();
        let (sigmas, _) = measured_with(&records, Some(&fixes), &[0]);
        assert!((sigmas[0] - 0.008).abs() < 3e-4, "{sigmas:?}");
        records.height_m = heave.iter().map(|h| (h / 0.02).round() * 0.02).collect();
        let (sigmas, _) = measured_with(&records, Some(&fixes), &[0]);
        assert_eq!(sigmas[0], 0.01);
    }

    /// Positions once a second between which a recorder interpolates, heights in centimetres, an attitude that is smooth.
    #[test]
    fn what_was_interpolated_or_rounded_shows_no_noise_and_what_is_smooth_a_tenth() {
        let mut records = sailed(0.01, 20_000);
        let at_seconds = |x: &[f64]| -> Vec<f64> {
            let between = |k: usize| {
                let (a, part) = (k / 100 * 100, (k % 100) as f64 / 100.0);
                let b = (a + 100).min(x.len() - 1);
                x[a] + part * (x[b] - x[a])
            };
            (0..x.len()).map(between).collect()
        };
        records.latitude_rad = at_seconds(&records.latitude_rad);
        records.longitude_rad = at_seconds(&records.longitude_rad);
        let smooth = |t: &f64| radians(3.0 * math::sin(TAU * t / 5.0));
        records.roll_rad = records.time_s.iter().map(smooth).collect();
        records.pitch_rad.clone_from(&records.roll_rad);
        let (sigmas, said) = measured_of(&records, &[0, 1]);
        assert_eq!(sigmas, [0.01, 0.0005, 0.01], "{said:?}");
        assert!(
            said[0].contains("a tenth of an ordinary installation's"),
            "{said:?}"
        );
        let mut records = sailed(0.01, 20_000);
        let steps = |h: &f64| (h / 0.02).round() * 0.02;
        records.height_m = records.height_m.iter().map(steps).collect();
        let (sigmas, _) = measured_of(&records, &[0]);
        assert_eq!(sigmas[0], 0.01);
    }
}
