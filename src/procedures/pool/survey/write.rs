//! A simulated survey as files: survey file, target file, observations, and the truth.

use std::path::Path;

use serde::Serialize;

use super::scenario::{ScenarioFile, recorder};
use crate::formats::{
    FormatError, las, laser_csv,
    registry::extension,
    sbet, sound_speed_csv, soundings_csv, trajectory_csv,
    whole::{write_json, write_toml},
};
use crate::geometry::Ellipsoid;
use crate::observe::SoundSpeed;
use crate::simulate::Simulated;
use crate::simulate::scenario::{Angles, Origin, Scenario};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Name of the target file.
const TARGET_FILE: &str = "target.toml";
/// Name of the sound-speed file.
const PROFILE_FILE: &str = "sound-speed.csv";

/// Writes everything that a calibration of this survey reads, and `truth.json`, into a folder that exists.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`, or for an unknown extension of a file's name.
pub fn write_survey(
    folder: &Path,
    file: &ScenarioFile,
    survey: &Simulated,
) -> Result<(), FormatError> {
    let campaign = &survey.campaign;
    write_trajectory(&folder.join(&file.trajectory), survey)?;
    let lidar = folder.join(&file.lidar);
    if extension(&lidar) == "csv" {
        laser_csv::write(&lidar, &campaign.laser)?;
    } else {
        las::write(&lidar, &campaign.laser)?;
    }
    let soundings = folder.join(&file.multibeam);
    match recorder(&file.multibeam) {
        Some(format) => super::export::write(&soundings, format, survey)?,
        None => soundings_csv::write(&soundings, &campaign.soundings)?,
    }
    if let Some(SoundSpeed::Profile(profile)) = &campaign.sound_speed {
        sound_speed_csv::write(&folder.join(PROFILE_FILE), profile)?;
    }
    write_toml(&folder.join(TARGET_FILE), &file.scenario.target.model)?;
    write_toml(&folder.join(SURVEY_FILE), &SurveyToml::new(file, survey))?;
    write_json(&folder.join(TRUTH_FILE), &survey.truth)
}

fn write_trajectory(path: &Path, survey: &Simulated) -> Result<(), FormatError> {
    let trajectory = &survey.campaign.trajectory;
    match extension(path).as_str() {
        "out" | "sbet" => sbet::write(path, trajectory, 0.0),
        _ => trajectory_csv::write(path, trajectory),
    }
}

/// Mirror of a survey file, in the order in which it is written.
#[derive(Serialize)]
struct SurveyToml<'a> {
    name: &'a str,
    procedure: &'static str,
    target: TargetToml,
    trajectory: TrajectoryToml<'a>,
    lidar: LidarToml<'a>,
    multibeam: MultibeamToml<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sound_speed: Option<SoundSpeedToml>,
    #[serde(flatten)]
    calibration: &'a toml::Table,
}

#[derive(Serialize)]
struct TargetToml {
    model: &'static str,
    ellipsoid: Ellipsoid,
    origin: Origin,
    azimuth_deg: f64,
    water_level_m: f64,
}

#[derive(Serialize)]
struct TrajectoryToml<'a> {
    path: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<&'static str>,
    position_sigma_m: f64,
    position_drift_sigma_m: f64,
    drift_correlation_time_s: f64,
    roll_pitch_sigma_deg: f64,
    heading_sigma_deg: f64,
    heading_drift_sigma_deg: f64,
    max_gap_s: f64,
}

#[derive(Serialize)]
struct LidarToml<'a> {
    path: &'a str,
    coordinates: &'static str,
    lever_arm_m: [f64; 3],
    mounting_deg: Angles,
    range_sigma_m: f64,
    angle_sigma_deg: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    mounting_sigma_deg: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lever_arm_sigma_m: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct MultibeamToml<'a> {
    path: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    lever_arm_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mounting_deg: Option<Angles>,
    #[serde(skip_serializing_if = "Option::is_none")]
    receiver_lever_arm_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    receiver_mounting_deg: Option<Angles>,
    range_sigma_m: f64,
    angle_sigma_deg: f64,
    along_angle_sigma_deg: f64,
}

#[derive(Serialize)]
struct SoundSpeedToml {
    #[serde(skip_serializing_if = "Option::is_none")]
    speed_m_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    profile: Option<&'static str>,
}

impl<'a> SurveyToml<'a> {
    fn new(file: &'a ScenarioFile, survey: &Simulated) -> Self {
        let s = &file.scenario;
        Self {
            name: &s.name,
            procedure: "pool",
            target: target(s, survey),
            trajectory: trajectory(file),
            lidar: lidar(file, survey),
            multibeam: multibeam(file),
            // a recorder's file has a cast
            sound_speed: match recorder(&file.multibeam) {
                Some(_) => None,
                None => survey.campaign.sound_speed.as_ref().map(sound_speed),
            },
            calibration: &file.calibration,
        }
    }
}

fn target(scenario: &Scenario, survey: &Simulated) -> TargetToml {
    let (pose, origin) = (&survey.prior, &survey.prior.origin);
    TargetToml {
        model: TARGET_FILE,
        ellipsoid: pose.ellipsoid,
        origin: Origin {
            latitude_deg: origin.latitude_rad.to_degrees(),
            longitude_deg: origin.longitude_rad.to_degrees(),
            height_m: origin.height_m,
        },
        azimuth_deg: pose.azimuth_rad.to_degrees(),
        water_level_m: scenario.target.water_level_m,
    }
}

fn trajectory(file: &ScenarioFile) -> TrajectoryToml<'_> {
    let ins = &file.scenario.trajectory;
    TrajectoryToml {
        path: &file.trajectory,
        time: recorder(&file.multibeam).map(|_| "utc-day"),
        position_sigma_m: ins.position_sigma_m,
        position_drift_sigma_m: ins.position_drift_sigma_m,
        drift_correlation_time_s: ins.drift_correlation_time_s,
        roll_pitch_sigma_deg: ins.roll_pitch_sigma_deg,
        heading_sigma_deg: ins.heading_sigma_deg,
        heading_drift_sigma_deg: ins.heading_drift_sigma_deg,
        max_gap_s: ins.max_gap_s,
    }
}

fn lidar<'a>(file: &'a ScenarioFile, survey: &Simulated) -> LidarToml<'a> {
    let lidar = &file.scenario.lidar;
    let said = survey.campaign.scanner_sigma.is_some();
    LidarToml {
        path: &file.lidar,
        coordinates: "sensor",
        lever_arm_m: lidar.lever_arm_m,
        mounting_deg: lidar.mounting_deg,
        range_sigma_m: lidar.range_sigma_m,
        angle_sigma_deg: lidar.angle_sigma_deg,
        mounting_sigma_deg: said.then_some(lidar.mounting_sigma_deg),
        lever_arm_sigma_m: said.then_some(lidar.lever_arm_sigma_m),
    }
}

fn multibeam(file: &ScenarioFile) -> MultibeamToml<'_> {
    let sonar = &file.scenario.multibeam;
    // a recorder's file has an installation record
    let said = recorder(&file.multibeam).is_none();
    let arrays = sonar.array_mountings().filter(|_| said);
    MultibeamToml {
        path: &file.multibeam,
        lever_arm_m: said.then_some(sonar.lever_arm_m),
        mounting_deg: said.then_some(sonar.mounting_deg),
        receiver_lever_arm_m: arrays.map(|arrays| arrays.receiver.lever_arm_m.into()),
        receiver_mounting_deg: sonar
            .arrays
            .filter(|_| said)
            .and_then(|arrays| arrays.receiver_mounting_deg),
        range_sigma_m: sonar.range_sigma_m,
        angle_sigma_deg: sonar.angle_sigma_deg,
        along_angle_sigma_deg: sonar.along_angle_sigma_deg,
    }
}

fn sound_speed(speed: &SoundSpeed) -> SoundSpeedToml {
    match speed {
        SoundSpeed::Constant(speed) => SoundSpeedToml {
            speed_m_s: Some(*speed),
            profile: None,
        },
        SoundSpeed::Profile(_) => SoundSpeedToml {
            speed_m_s: None,
            profile: Some(PROFILE_FILE),
        },
    }
}
