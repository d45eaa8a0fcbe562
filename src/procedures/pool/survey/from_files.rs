//! A survey file made from recorder files: what must be said, and what the files say, commented out.

use std::path::PathBuf;

use super::load::one_head;
use crate::formats::recorder::{Array, Installation};
use crate::survey::problem::SurveyError;
use crate::survey::recorded::files::{lacking, losses, read_all};
use crate::survey::recorded::mounted::{angles_of, arm_of, inline, installation};

/// A survey file of these recorder files. What is wrong or missing stands in it as a comment.
#[must_use]
pub fn template(files: &[PathBuf]) -> String {
    let quoted: Vec<String> = files
        .iter()
        .map(|file| format!("{:?}", file.to_string_lossy()))
        .collect();
    let (of_sonar, notes) = match said(files) {
        Ok(said) => said,
        Err(error) => (String::new(), lacking(&error)),
    };
    let paths = quoted.join(", ");
    format!("{HEAD}\n[multibeam]\npaths = [{paths}]\n{SIGMAS}{of_sonar}\n{REST}{notes}")
}

const HEAD: &str = "# Pool survey of recorder files. A line that begins with \"#\" and a key shows what the files say or what holds
# without it; without the mark it decides. Fill in the target, the scanner and the sigmas of your instruments.
name = \"pool\"
procedure = \"pool\"

[target]
model = \"target.toml\"           # boresight template target
origin = { latitude_deg = 0.0, longitude_deg = 0.0, height_m = 0.0 }   # believed, to half a metre
azimuth_deg = 0.0               # of the +Y axis, to two degrees
water_level_m = 0.0

[lidar]
path = \"lidar.laz\"
lever_arm_m = [0.0, 0.0, 0.0]
mounting_deg = { roll = 0.0, pitch = 0.0, heading = 0.0 }
range_sigma_m = 0.005
angle_sigma_deg = 0.002
#time = \"gps-week\"             # of the returns; without it as the trajectory's
";

const SIGMAS: &str = "range_sigma_m = 0.01\nangle_sigma_deg = 0.06\n";

const REST: &str = "[trajectory]
path = \"sbet.out\"              # without it the recorder's own navigation
time = \"gps-week\"              # of an SBET: gps-week or utc-week; the recorder's times are UTC
position_sigma_m = 0.002
position_drift_sigma_m = 0.01
roll_pitch_sigma_deg = 0.003
heading_sigma_deg = 0.005

#[sound_speed]
#profile = \"svp.csv\"          # instead of the casts in the files

# On reading:
";

/// What the files say of the sounder, as keys, and what was noted.
fn said(files: &[PathBuf]) -> Result<(String, String), SurveyError> {
    let observed = read_all(files)?;
    let record = installation(&observed)?;
    let (there, mut notes) = (observed.heads(), losses(&observed));
    let first = files.first().map(PathBuf::as_path);
    let head = one_head(first.unwrap_or("".as_ref()), "soundings", &there, None);
    let keys = match &head {
        Ok(head) => format!("#head = {head}\n{}", mounted(record.as_ref(), *head)),
        Err(problem) => {
            notes.push(format!("{}, expected {}", problem.found, problem.expected));
            let each = there.iter().map(|head| {
                let of = mounted(record.as_ref(), *head);
                format!("#head = {head}   # alone\n{of}")
            });
            each.collect()
        }
    };
    notes.push(format!(
        "{} soundings, {} casts of the sound speed",
        observed.soundings.time_s.len(),
        observed.recorded.casts().len()
    ));
    let lines: String = notes.iter().map(|note| format!("# - {note}\n")).collect();
    Ok((keys, lines))
}

/// Lever arms and angles of a head's two arrays as the installation record has them.
fn mounted(record: Option<&Installation>, head: u32) -> String {
    let keys = |prefix: &str, array: Option<&Array>| {
        let Some(array) = array else {
            return format!("#{prefix}lever_arm_m: no installation record says it\n");
        };
        let mounting = &array.mounted.mounting;
        format!(
            "#{prefix}lever_arm_m = {:?}\n#{prefix}mounting_deg = {}\n",
            arm_of(mounting),
            inline(&angles_of(mounting))
        )
    };
    let transmitter = keys("", record.and_then(|r| r.transmitter(head)));
    let receiver = keys("receiver_", record.and_then(|r| r.receiver(head)));
    format!("{transmitter}{receiver}")
}
