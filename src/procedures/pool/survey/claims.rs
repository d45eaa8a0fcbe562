//! A survey in a scenario's words: what its file claims of every instrument, so that an error budget can be made of it.

use super::file::CoordinatesName;
use super::load::LoadedSurvey;
use crate::simulate::scenario::{
    Angles, Basin, Corrections, Disturbance, Ins, Lidar, Multibeam, Origin, Recorded, Scenario,
    TargetScene, Turn,
};
use crate::simulate::{Sources, motion::MotionModel};
use crate::survey::sections::MountingAngles;

/// The survey's claims; `None` where the laser points are georeferenced already, so that it does not say what the scanner's
/// noise is. There are no passes in it: what was observed is in the survey.
#[must_use]
pub fn claims(survey: &LoadedSurvey) -> Option<Scenario> {
    if survey.file.lidar.coordinates != CoordinatesName::Sensor {
        return None;
    }
    Some(Scenario {
        name: survey.file.name.clone(),
        seed: 1,
        target: target(survey),
        basin: Basin::default(),
        trajectory: ins(survey),
        lidar: lidar(survey),
        multibeam: multibeam(survey),
        sound_speed: None,
        truth: Corrections::default(),
        motion: MotionModel::default(),
        pass: vec![],
        disturbance: Disturbance::default(),
        sources: Sources::default(),
    })
}

fn target(survey: &LoadedSurvey) -> TargetScene {
    let said = &survey.file.target;
    TargetScene {
        model: survey.target_model.clone(),
        ellipsoid: said.ellipsoid,
        origin: Origin {
            latitude_deg: said.origin.latitude_deg,
            longitude_deg: said.origin.longitude_deg,
            height_m: said.origin.height_m,
        },
        azimuth_deg: said.azimuth_deg,
        water_level_m: said.water_level_m,
        prior_offset_m: [0.0; 3],
        prior_turn_deg: 0.0,
        prior_offset_sigma_m: 0.0,
        prior_turn_sigma_deg: 0.0,
        roughness_sigma_m: 0.0,
    }
}

fn ins(survey: &LoadedSurvey) -> Ins {
    let (said, time_s) = (&survey.file.trajectory, &survey.campaign.trajectory.time_s);
    let span_s = time_s.last().copied().unwrap_or(0.0) - time_s.first().copied().unwrap_or(0.0);
    Ins {
        rate_hz: time_s.len() as f64 / span_s.max(1e-3),
        position_sigma_m: said.position_sigma_m,
        position_drift_sigma_m: said.position_drift_sigma_m,
        drift_correlation_time_s: said.drift_correlation_time_s,
        roll_pitch_sigma_deg: said.roll_pitch_sigma_deg,
        heading_sigma_deg: said.heading_sigma_deg,
        heading_drift_sigma_deg: said.heading_drift_sigma_deg,
        velocity: survey.campaign.trajectory.velocity_m_s.is_some(),
        max_gap_s: said.max_gap_s,
    }
}

fn lidar(survey: &LoadedSurvey) -> Lidar {
    let said = &survey.file.lidar;
    Lidar {
        lever_arm_m: said.lever_arm_m,
        mounting_deg: angles(&said.mounting_deg),
        range_sigma_m: said.range_sigma_m,
        angle_sigma_deg: said.angle_sigma_deg,
        line_rate_hz: 1.0,
        points_per_line: 1,
        from_deg: -90.0,
        to_deg: 90.0,
        duty: 1.0,
        max_range_m: 1e3,
        mounting_sigma_deg: said.mounting_sigma_deg.unwrap_or_default(),
        lever_arm_sigma_m: said.lever_arm_sigma_m.unwrap_or_default(),
        mounting_error_deg: Turn::default(),
        lever_arm_error_m: [0.0; 3],
    }
}

fn multibeam(survey: &LoadedSurvey) -> Multibeam {
    let (said, observed) = (&survey.file.multibeam, &survey.campaign.soundings);
    let across_rad = || (0..observed.len()).map(|k| observed.measured(k)[0]);
    let most = |pick: fn(f64, f64) -> f64| across_rad().fold(0.0, pick).to_degrees();
    Multibeam {
        lever_arm_m: said.lever_arm_m,
        mounting_deg: angles(&said.mounting_deg),
        range_sigma_m: said.range_sigma_m,
        angle_sigma_deg: said.angle_sigma_deg,
        along_angle_sigma_deg: said.along_angle_sigma_deg,
        outer_beam_factor: 1.0,
        ping_rate_hz: 1.0,
        beams: 1,
        from_deg: most(f64::min),
        to_deg: most(f64::max),
        max_range_m: 1e3,
        records: Recorded::default(),
        arrays: None,
    }
}

fn angles(said: &MountingAngles) -> Angles {
    Angles {
        roll: said.roll,
        pitch: said.pitch,
        heading: said.heading,
    }
}
