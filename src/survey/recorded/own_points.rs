//! The check of recorder files against the sounder's own points, in words and for programs.

use std::path::PathBuf;

use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::recorders::own_solution::of_file;
use crate::recorders::{Agreement, Choice};
use crate::ruled::Ruled;
use crate::survey::problem::SurveyError;

/// Our georeferencing with the installation values against the sounder's own points, file by file.
pub(crate) struct Against(Vec<(String, Option<Agreement>)>);

/// A mean or root mean square beyond this part of the depth below the sounder says that a sign, an arm or an angle is read otherwise
/// than the sounder has it.
const AGREES: f64 = 0.02;

impl Against {
    /// Compares every file.
    ///
    /// # Errors
    /// [`SurveyError`] naming a file that cannot be read.
    pub(crate) fn files(paths: &[PathBuf]) -> Result<Self, SurveyError> {
        let one = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let found = of_file(path, Choice::default())?;
            Ok::<_, SurveyError>((name.into_owned(), found))
        };
        let all: Result<Vec<_>, SurveyError> = paths.iter().map(one).collect();
        Ok(Self(all?))
    }

    /// In words.
    pub(crate) fn text(&self) -> String {
        let compared = self.0.iter().filter(|file| file.1.is_some());
        if compared.count() == 0 {
            return "\nThe files hold no solution of the sounder's own to compare with, or not what\ncomparing needs (installation record, attitude, sound-speed profile).\n".to_owned();
        }
        let head = ["file", "beams", "mean, cm", "rms, cm"];
        let mut table = Ruled::new(head);
        for (name, found) in &self.0 {
            let Some(found) = found else {
                table.row([name.clone(), "0".to_owned(), String::new(), String::new()]);
                continue;
            };
            let three = |v: &Vector3<f64>| {
                let [x, y, z]: [f64; 3] = (v * 100.0).into();
                format!("{x:.1} {y:.1} {z:.1}")
            };
            let (mean, rms) = (three(&found.mean_m), three(&found.rms_m));
            table.row([name.clone(), found.beams.to_string(), mean, rms]);
        }
        let apart = if self.apart() {
            "They do not agree: a sign, an arm, an angle or the sound speed is not as the\nsounder has it. Check that before you use the calibration.\n"
        } else {
            ""
        };
        format!(
            "\nOur points by the installation values minus the sounder's own (right,\nforward, up):\n{table}\n{apart}"
        )
    }

    /// Whether a file's points lie apart by more than the sounder's depth allows.
    fn apart(&self) -> bool {
        let worst = |found: &Agreement| found.rms_m.amax() > AGREES * found.depth_m.max(5.0);
        self.0.iter().filter_map(|file| file.1.as_ref()).any(worst)
    }

    /// For programs.
    pub(crate) fn json(&self) -> Value {
        let one = |(name, found): &(String, Option<Agreement>)| match found {
            Some(found) => json!({
                "file": name,
                "pings": found.pings,
                "beams": found.beams,
                "left_out": found.left_out,
                "mean_m": <[f64; 3]>::from(found.mean_m),
                "rms_m": <[f64; 3]>::from(found.rms_m),
            }),
            None => json!({ "file": name, "beams": 0 }),
        };
        json!({ "files": self.0.iter().map(one).collect::<Vec<_>>(), "apart": self.apart() })
    }
}
