//! A survey file made from recorder files: what must be said, and what the files say, commented out.

use std::path::{Path, PathBuf};

use super::file::TrajectorySection;
use super::recorded::{self, FromRecorders};
use crate::survey::recorded::files::lacking;
use crate::survey::recorded::mounted::inline;
use crate::survey::sections::MountingAngles;

/// A survey file of these recorder files, one line of each. What is wrong or missing stands in it as a comment.
#[must_use]
pub fn template(files: &[PathBuf]) -> String {
    let names: Vec<String> = files
        .iter()
        .map(|f| f.to_string_lossy().into_owned())
        .collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
    let head = format!(
        "name = \"patch test\"\nprocedure = \"seabed\"\n\n[multibeam]\npaths = [{}]\nrange_sigma_m = 0.02\nangle_sigma_deg = 0.05\n",
        quoted.join(", ")
    );
    let found = recorded::load(Path::new("survey.toml"), &head, Path::new(""), names);
    let (of_sonar, of_ins, of_rest) = match &found {
        Ok(found) => (sonar(found), ins(&found.file.trajectory), rest(found)),
        Err(error) => {
            let lines = lacking(error);
            let words = format!("\n# It cannot be calibrated as it stands:\n{lines}");
            (String::new(), ORDINARY.to_owned(), words)
        }
    };
    let title = "# Survey of recorder files, one line of each. A line that begins with \"#\" and a key shows what the files say or what holds\n# without it; without the mark it decides.\n# The sigmas are those of an ordinary installation, and those of the INS what its records show where that is less: put in yours.\n";
    let others = "#path = \"sbet.out\"           # a post-processed trajectory instead of the recorder's own navigation\n#time = \"gps-week\"           # of an SBET: gps-week or utc-week\n#accuracies = \"smrmsg.out\"   # its accuracies, for the drift sigmas\n#heights = \"ellipsoid\"       # or \"heave\", where no height above the ellipsoid is recorded\n";
    format!("{title}{head}{of_sonar}\n[trajectory]\n{of_ins}{others}{of_rest}")
}

/// White noise of an ordinary INS, where nothing could be read.
const ORDINARY: &str =
    "#position_sigma_m = 0.01\n#roll_pitch_sigma_deg = 0.005\n#heading_sigma_deg = 0.01\n";

/// White noise of the INS that holds without a word of it.
fn ins(t: &TrajectorySection) -> String {
    format!(
        "#position_sigma_m = {}\n#roll_pitch_sigma_deg = {}\n#heading_sigma_deg = {}\n",
        t.position_sigma_m, t.roll_pitch_sigma_deg, t.heading_sigma_deg
    )
}

/// Mountings as the installation record has them.
fn sonar(found: &FromRecorders) -> String {
    let m = &found.file.multibeam;
    let several = !found.file.head.is_empty();
    let alone = if several {
        "   # alone; without it all heads together"
    } else {
        ""
    };
    let head = m
        .head
        .map_or(String::new(), |head| format!("#head = {head}{alone}\n"));
    let first = mounted(
        (&m.lever_arm_m, &m.mounting_deg),
        (&m.receiver_lever_arm_m, &m.receiver_mounting_deg),
    );
    let further = found.file.head.iter().map(|h| {
        let own = mounted(
            (&h.lever_arm_m, &h.mounting_deg),
            (&h.receiver_lever_arm_m, &h.receiver_mounting_deg),
        );
        format!("\n#[[head]]\n#number = {}\n{own}", h.number)
    });
    let further: String = further.collect();
    format!("{head}{first}{further}")
}

/// Lever arms and angles of a head's two arrays.
fn mounted(
    (arm_m, angles): (&[f64; 3], &MountingAngles),
    receiver: (&Option<[f64; 3]>, &Option<MountingAngles>),
) -> String {
    let arm = |a: &[f64; 3]| format!("{a:?}");
    let mut text = format!(
        "#lever_arm_m = {}   # right, forward, up of the reference point\n#mounting_deg = {}\n",
        arm(arm_m),
        inline(angles)
    );
    if let (Some(receiver_arm), Some(receiver)) = receiver {
        text.push_str(&format!(
            "#receiver_lever_arm_m = {}\n#receiver_mounting_deg = {}\n",
            arm(receiver_arm),
            inline(receiver)
        ));
    }
    text
}

/// The frame, the profile, and what was noted on reading.
fn rest(found: &FromRecorders) -> String {
    let origin = &found.file.site.origin;
    let casts = found.casts.len();
    let mut text = format!(
        "\n#[site]\n#origin = {{ latitude_deg = {}, longitude_deg = {}, height_m = {} }}\n#water_level_m = {}\n\n#[sound_speed]\n#profile = \"svp.csv\"   # instead of the {casts} in the files\n\n#[tide]\n#path = \"tide.csv\"   # time_s (UTC, or dates) and height_m over water_level_m\n\n# On reading:\n",
        origin.latitude_deg, origin.longitude_deg, origin.height_m, found.file.site.water_level_m
    );
    for note in &found.notes {
        text.push_str(&format!("# - {note}\n"));
    }
    text
}
