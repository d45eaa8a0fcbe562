//! A simulated rail calibration as files: survey file, rail model, observations, and the truth.

use std::path::Path;

use serde::Serialize;

use super::super::formats::rail_csv;
use super::file::{AttitudeSection, ProfilerSection, ProfilesSection, RailSection, TableSection};
use super::scenario::RailScenarioFile;
use crate::formats::whole::{write_json, write_toml};
use crate::formats::{FormatError, attitude_csv};
use crate::procedures::rail::simulate::SimulatedRail;
use crate::procedures::rail::simulate::scenario::{Angles, RailScenario};
use crate::survey::sections::MountingAngles;
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

const MODEL: &str = "rail.toml";
const PROFILES: &str = "profiles.csv";
const ATTITUDE: &str = "attitude.csv";
const TABLE: &str = "table.csv";

/// Writes everything that a calibration of this survey reads, and `truth.json`, into a folder that exists.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write_rail(
    folder: &Path,
    file: &RailScenarioFile,
    survey: &SimulatedRail,
) -> Result<(), FormatError> {
    let campaign = &survey.campaign;
    rail_csv::write_profiles(&folder.join(PROFILES), &campaign.points)?;
    attitude_csv::write(&folder.join(ATTITUDE), &campaign.attitude, &rail_csv::BEAM)?;
    rail_csv::write_table(&folder.join(TABLE), &campaign.table)?;
    write_toml(&folder.join(MODEL), &file.model)?;
    write_toml(&folder.join(SURVEY_FILE), &SurveyToml::new(file))?;
    write_json(&folder.join(TRUTH_FILE), &survey.truth)
}

/// Mirror of a survey file, in the order in which it is written.
#[derive(Serialize)]
struct SurveyToml<'a> {
    name: &'a str,
    procedure: &'static str,
    rail: RailSection,
    profiles: ProfilesSection,
    attitude: AttitudeSection,
    table: TableSection,
    profiler: Vec<ProfilerSection>,
    #[serde(flatten)]
    calibration: &'a toml::Table,
}

fn angles(a: &Angles) -> MountingAngles {
    MountingAngles {
        roll: a.roll,
        pitch: a.pitch,
        heading: a.heading,
    }
}

impl<'a> SurveyToml<'a> {
    fn new(file: &'a RailScenarioFile) -> Self {
        let s = &file.scenario;
        Self {
            name: &s.name,
            procedure: "rail",
            rail: RailSection {
                model: MODEL.to_owned(),
                orientation_deg: angles(&s.rail.orientation_deg),
                orientation_sigma_deg: s.rail.orientation_sigma_deg,
                profile_sigma_m: s.rail.profile_sigma_m,
            },
            profiles: ProfilesSection {
                path: PROFILES.to_owned(),
            },
            attitude: AttitudeSection {
                path: ATTITUDE.to_owned(),
                roll_pitch_sigma_deg: s.attitude.roll_pitch_sigma_deg,
                heading_sigma_deg: s.attitude.heading_sigma_deg,
            },
            table: table(s),
            profiler: profilers(s),
            calibration: &file.calibration,
        }
    }
}

fn table(s: &RailScenario) -> TableSection {
    let t = &s.table;
    TableSection {
        path: TABLE.to_owned(),
        angle_sigma_deg: t.angle_sigma_deg,
        level_sigma_deg: t.level_sigma_deg,
        zero_sigma_deg: t.zero_sigma_deg,
        seating_sigma_deg: t.seating_sigma_deg,
        pivot_body_m: t.pivot_body_m,
        pivot_body_sigma_m: t.pivot_body_sigma_m,
        pivot_rail_m: t.pivot_rail_m,
        pivot_rail_sigma_m: t.pivot_rail_sigma_m,
        axes_gap_sigma_m: t.axes_gap_sigma_m,
    }
}

fn profilers(s: &RailScenario) -> Vec<ProfilerSection> {
    let one = |p: &crate::procedures::rail::simulate::scenario::ProfilerSection| ProfilerSection {
        name: p.name.clone(),
        lever_arm_m: p.lever_arm_m,
        mounting_deg: angles(&p.mounting_deg),
        lateral_sigma_m: p.lateral_sigma_m,
        vertical_sigma_m: p.vertical_sigma_m,
        along_sigma_m: p.along_sigma_m,
    };
    s.profiler.iter().map(one).collect()
}
