//! Columns with too few decimals: what rounding alone does beside the noise that is stated.
//!
//! A column that was rounded to steps of `s` errs by `s / sqrt(12)`, and on a boat that turns slowly by the same for many records: noise that no
//! survey file states, and that no test tells from a fault of the sensor. The steps themselves are exact, and are looked for.

use crate::formats::TrajectoryRecords;
use crate::math;
use crate::units::{degrees, to_figures};

/// Metres of a degree of a meridian or of the equator, near enough for rounding.
const DEGREE_M: f64 = 111_200.0;
/// Less than this is never said, metres and degrees: nobody states less.
const LEAST: f64 = 1e-4;
/// Decimals beyond which nothing of interest is rounded.
const DECIMALS: i32 = 9;
/// A multiple of a step may be off by this part of the step, and by this part of the sigma: values went through radians and back.
const SLACK: (f64, f64) = (1e-4, 0.05);

/// Figures that leave out the last bits.
const CLEAN: usize = 7;

/// A column as the survey's file has it.
struct Column<'a> {
    name: &'a str,
    values: &'a [f64],
    /// Its values' unit in the file's.
    in_file: f64,
    /// The file's unit in that of the sigma.
    in_sigma: f64,
}

/// All columns of a trajectory against the white noise of its positions, of roll and pitch, and of the heading.
pub(crate) fn of_trajectory(
    records: &TrajectoryRecords,
    position_m: f64,
    angles_rad: [f64; 2],
) -> Vec<String> {
    let mut said = of_places(records.places(), position_m);
    said.extend(of_attitude(records.angles(), angles_rad));
    said
}

/// Positions of a trajectory, radians and metres, against their white noise.
fn of_places([latitude_rad, longitude_rad, height_m]: [&[f64]; 3], sigma_m: f64) -> Vec<String> {
    let geodetic = |name, values, in_sigma| Column {
        name,
        values,
        in_file: degrees(1.0),
        in_sigma,
    };
    let parallel = latitude_rad.first().map_or(1.0, |angle| math::cos(*angle));
    let height = Column {
        name: "height_m",
        values: height_m,
        in_file: 1.0,
        in_sigma: 1.0,
    };
    let all = [
        geodetic("latitude_deg", latitude_rad, DEGREE_M),
        geodetic("longitude_deg", longitude_rad, parallel * DEGREE_M),
        height,
    ];
    let said = |column: Column<'_>| column.coarse("position_sigma_m", sigma_m, "m");
    all.into_iter().filter_map(said).collect()
}

/// Roll, pitch and heading, radians, against the white noise of the first two and of the last.
pub(crate) fn of_attitude(
    [roll, pitch, heading]: [&[f64]; 3],
    [roll_pitch_rad, heading_rad]: [f64; 2],
) -> Vec<String> {
    let column = |name, values| Column {
        name,
        values,
        in_file: degrees(1.0),
        in_sigma: 1.0,
    };
    let level = [column("roll_deg", roll), column("pitch_deg", pitch)];
    let level = level
        .into_iter()
        .filter_map(|c| c.coarse("roll_pitch_sigma_deg", degrees(roll_pitch_rad), "deg"));
    let heading = column("heading_deg", heading);
    let heading = heading.coarse("heading_sigma_deg", degrees(heading_rad), "deg");
    level.chain(heading).collect()
}

impl Column<'_> {
    /// What to say where the rounding is larger than the sigma.
    fn coarse(&self, key: &str, sigma: f64, unit: &str) -> Option<String> {
        let (name, step) = (self.name, self.step(sigma)?);
        let rounding = step * self.in_sigma / 12.0_f64.sqrt();
        Some(format!(
            "{name} comes in steps of {step}: rounding alone errs by {} {unit}, more than {key} = {}; write more decimals",
            to_figures(rounding, 2),
            to_figures(sigma, CLEAN)
        ))
    }

    /// The step that all values are multiples of, where it is too large beside the sigma.
    fn step(&self, sigma: f64) -> Option<f64> {
        let first = self.values.first()?;
        if self.values.iter().all(|value| value == first) {
            return None;
        }
        let errs = |step: f64| step * self.in_sigma / 12.0_f64.sqrt() > sigma.max(LEAST);
        let steps = (0..=DECIMALS).map(|decimals| 0.1_f64.powi(decimals));
        let mut large = steps.take_while(|step| errs(*step));
        large
            .find(|step| self.is_of_steps(*step, sigma.max(LEAST)))
            .map(|step| to_figures(step, CLEAN))
    }

    fn is_of_steps(&self, step: f64, sigma: f64) -> bool {
        let slack = SLACK.0.min(SLACK.1 * sigma / (step * self.in_sigma));
        let off = |value: &f64| {
            let steps = value * self.in_file / step;
            (steps - steps.round()).abs()
        };
        self.values.iter().all(|value| off(value) < slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::radians;

    /// A column of a boat in waves, in steps.
    fn waves(about: f64, size: f64, step: f64) -> Vec<f64> {
        let all = (0..500).map(|k| about + size * math::sin(0.05 * f64::from(k)));
        all.map(|v| (v / step).round() * step).collect()
    }

    fn angles(step: f64) -> Vec<f64> {
        waves(3.0, 2.0, step).into_iter().map(radians).collect()
    }

    #[test]
    fn a_column_that_is_rounded_beyond_its_noise_is_named() {
        let place = |step: f64| -> Vec<f64> {
            let values = waves(36.0, 1e-4, step).into_iter();
            values.map(radians).collect()
        };
        // a survey at a whole degree is no rounded one
        let (fine, coarse) = (place(1e-9), place(1e-6));
        let near: Vec<f64> = waves(36.0, 1e-7, 1e-12).into_iter().map(radians).collect();
        assert_eq!(
            of_places([&near, &fine, &near], 0.002),
            Vec::<String>::new()
        );
        let height = waves(12.0, 0.2, 0.1);
        let said = of_places([&coarse, &fine, &height], 0.002);
        assert_eq!(said.len(), 2, "{said:?}");
        assert_eq!(
            said[0],
            "latitude_deg comes in steps of 0.000001: rounding alone errs by 0.032 m, more than position_sigma_m = 0.002; write more decimals"
        );
        assert!(
            said[1].starts_with("height_m comes in steps of 0.1: rounding alone errs by 0.029 m"),
            "{said:?}"
        );
    }

    #[test]
    fn fine_or_constant_columns_and_those_of_a_noisy_sensor_are_not() {
        let (fine, tenth, none) = (angles(1e-4), angles(0.1), vec![0.0; 500]);
        let sigmas = [0.003, 0.05].map(radians);
        assert_eq!(
            of_attitude([&fine, &none, &tenth], sigmas),
            Vec::<String>::new()
        );
        let said = of_attitude([&tenth, &fine, &tenth], [0.003, 0.005].map(radians));
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[1].contains("heading_deg comes in steps of 0.1")
                && said[1].contains("heading_sigma_deg = 0.005"),
            "{said:?}"
        );
    }
}
