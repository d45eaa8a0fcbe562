//! A simulated survey in memory as a scene, and on disk as a complete survey.

use std::io::Write;
use std::path::Path;

use nalgebra::Vector3;

use super::super::scene::{REFERENCE_DEPTH_M, Scene};
use super::super::simulate::{Shot, Simulated};
use super::file::{
    HeadSection, LineSection, MultibeamSection, SeabedSurveyFile, SoundSpeedSection, TideSection,
    TrajectorySection,
};
use super::load::scene_of;
use super::scenario::{START_S, SeabedScenario};
use crate::formats::records::ArrayColumns;
use crate::formats::{
    FormatError, Invalid, SoundingRecords, sound_speed_csv, soundings_csv, tide_csv,
    trajectory_csv, whole,
};
use crate::geometry::ellipsoid::{Geodetic, TargetPose, ecef_from_level};
use crate::geometry::{Point, Target, rotation};
use crate::observe::{
    GeodeticTrajectory, Outside, SoundSpeedProfile, SoundingRange, TideCurve, TrajectoryNoise,
};

/// A simulated survey as a scene, as if its survey file and all files beside it had been read.
#[must_use]
pub fn scene(file: &SeabedSurveyFile, scenario: &SeabedScenario, survey: &Simulated) -> Scene {
    scene_of(
        file,
        &trajectory(scenario, survey),
        &[profile(scenario, survey)],
        tide(scenario, survey, 0.0),
        &soundings(scenario, &survey.shots),
    )
}

/// The survey file of a scenario.
#[must_use]
pub fn survey_file(scenario: &SeabedScenario, survey: &Simulated) -> SeabedSurveyFile {
    let m = &scenario.multibeam;
    let two = scenario.two_arrays();
    let heads = scenario.heads();
    let several = heads.len() > 1;
    let receiver_arm_m = |k: usize| {
        let arrays = heads[k].arrays(survey.lever_arms_m[k]);
        arrays.receiver.lever_arm_m.into()
    };
    SeabedSurveyFile {
        name: scenario.name.clone(),
        procedure: "seabed".to_owned(),
        site: scenario.site.clone(),
        trajectory: TrajectorySection {
            path: Some("trajectory.csv".to_owned()),
            ..scenario.trajectory.clone()
        },
        sound_speed: SoundSpeedSection {
            profile: Some("sound_speed.csv".to_owned()),
            profile_sigma: scenario.profile_sigma,
            between: "interpolated".to_owned(),
        },
        tide: scenario.tide.map(|_| TideSection {
            path: TIDE.to_owned(),
            time_offset_s: 0.0,
        }),
        cast: vec![],
        multibeam: MultibeamSection {
            path: Some("multibeam.csv".to_owned()),
            paths: vec![],
            head: several.then_some(1),
            receiver_lever_arm_m: two.map(|_| receiver_arm_m(0)),
            receiver_mounting_deg: two.and_then(|two| two.receiver_mounting_deg),
            lever_arm_m: survey.lever_arms_m[0],
            lever_arm_sigma_m: m.lever_arm_sigma_m,
            mounting_deg: m.mounting_deg,
            range_sigma_m: m.range_sigma_m,
            angle_sigma_deg: m.angle_sigma_deg,
            angle_sigma_growth: m.angle_sigma_growth,
            max_angle_deg: (m.half_swath_deg - 2.0).clamp(5.0, 65.0),
            invalid: Invalid::Error,
        },
        seabed: scenario.seabed.clone(),
        reference: scenario.reference.clone(),
        verdict: scenario.verdict.clone(),
        head: (1..heads.len())
            .map(|k| HeadSection {
                number: k as u32 + 1,
                lever_arm_m: survey.lever_arms_m[k],
                lever_arm_sigma_m: heads[k].lever_arm_sigma_m,
                mounting_deg: heads[k].mounting_deg,
                receiver_lever_arm_m: two.map(|_| receiver_arm_m(k)),
                receiver_mounting_deg: heads[k].receiver_mounting_deg,
            })
            .collect(),
        line: survey
            .lines
            .iter()
            .map(|l| {
                let span_s = [l.start_s - 0.5, l.end_s + 0.5];
                LineSection::new(l.name.clone(), vec![], span_s)
            })
            .collect(),
    }
}

/// The tide's file.
pub const TIDE: &str = "tide.csv";

/// The tide as its file holds it, `later_s` added to its times: from some rows before the first line to some behind the last.
#[must_use]
pub fn tide(scenario: &SeabedScenario, survey: &Simulated, later_s: f64) -> Option<TideCurve> {
    let (tide, step_s) = scenario.one_period().zip(scenario.tide.map(|t| t.step_s))?;
    let lines = survey.lines.iter();
    let end_s = lines.map(|l| l.end_s).fold(START_S, f64::max);
    let around_s = TIDE_ROWS * step_s + TIDE_AROUND_S;
    let span_s = [START_S - around_s, end_s + around_s];
    let mut curve = TideCurve::of_one_period(tide, step_s, span_s);
    curve.time_s.iter_mut().for_each(|t| *t += later_s);
    Some(curve)
}

/// The file reaches so far beyond the lines: rows, and seconds.
const TIDE_ROWS: f64 = 2.0;
const TIDE_AROUND_S: f64 = 7200.0;

/// The water as the survey knows it: one speed from the surface down, with an error that grows from the transducer on.
#[must_use]
pub fn profile(scenario: &SeabedScenario, survey: &Simulated) -> SoundSpeedProfile {
    let deepest_m = 100.0 + 3.0 * scenario.bed.depth_m;
    let transducer_m = -scenario.multibeam.lever_arm_m[2].min(0.0);
    let depth_m = vec![0.0, transducer_m, deepest_m];
    let off = |depth: &f64| {
        1.0 + survey.profile_error * (depth - transducer_m).max(0.0) / REFERENCE_DEPTH_M
    };
    SoundSpeedProfile {
        speed_m_s: depth_m
            .iter()
            .map(|d| scenario.sound_speed_m_s * off(d))
            .collect(),
        depth_m,
    }
}

/// The trajectory as a file holds it: heights above the water where the scenario has such, else above the ellipsoid.
#[must_use]
pub fn trajectory(scenario: &SeabedScenario, survey: &Simulated) -> GeodeticTrajectory {
    let ellipsoid = scenario.site.ellipsoid;
    let frame = TargetPose {
        ellipsoid,
        origin: scenario.site.origin.geodetic(),
        azimuth_rad: 0.0,
    }
    .ecef_from_target();
    let t = &scenario.trajectory;
    let mut out = GeodeticTrajectory {
        ellipsoid,
        time_s: vec![],
        latitude_rad: vec![],
        longitude_rad: vec![],
        height_m: vec![],
        roll_rad: vec![],
        pitch_rad: vec![],
        heading_rad: vec![],
        velocity_m_s: None,
        noise: TrajectoryNoise {
            position_m: t.position_sigma_m,
            position_drift_m: t.position_drift_sigma_m,
            drift_correlation_time_s: t.drift_correlation_time_s,
            roll_pitch_rad: t.roll_pitch_sigma_deg.to_radians(),
            heading_rad: t.heading_sigma_deg.to_radians(),
            heading_drift_rad: t.heading_drift_sigma_deg.to_radians(),
        },
        max_gap_s: t.max_gap_s,
        outside: Outside::Drop,
    };
    let above_water = t.above_water();
    for record in &survey.records {
        let lacks_m = match above_water {
            true => scenario.tide_m(record.time_s),
            false => 0.0,
        };
        let place = record.position_m - Vector3::z() * lacks_m;
        let geodetic: Geodetic = ellipsoid.to_geodetic(&(frame * Point::<Target>::new(place)));
        let level = ecef_from_level(&geodetic).matrix;
        let body = level.tr_mul(&(frame.rotation.matrix * record.rotation));
        let (roll, pitch, heading) = rotation::to_attitude(&body);
        out.time_s.push(record.time_s);
        out.latitude_rad.push(geodetic.latitude_rad);
        out.longitude_rad.push(geodetic.longitude_rad);
        out.height_m.push(geodetic.height_m);
        out.roll_rad.push(roll);
        out.pitch_rad.push(pitch);
        out.heading_rad.push(heading);
    }
    out
}

/// The soundings as a file holds them.
#[must_use]
pub fn soundings(scenario: &SeabedScenario, shots: &[Shot]) -> SoundingRecords {
    let two = scenario.two_arrays().is_some();
    let column = |pick: fn(&Shot) -> f64| shots.iter().map(pick).collect::<Vec<f64>>();
    SoundingRecords {
        time_s: column(|s| s.time_s),
        ping: shots.iter().map(|s| s.ping).collect(),
        beam: shots.iter().map(|s| s.beam).collect(),
        across_rad: column(|s| s.across_rad),
        along_rad: column(|s| s.tilt_rad),
        range: SoundingRange::TwoWayTravelTime(column(|s| s.two_way_s)),
        arrays: two.then(|| ArrayColumns {
            delay_s: column(|s| s.delay_s),
            head_speed_m_s: vec![scenario.sound_speed_m_s; shots.len()],
        }),
        head: match scenario.head.is_empty() {
            true => vec![],
            false => shots.iter().map(|s| u32::from(s.head) + 1).collect(),
        },
        notes: vec![],
    }
}

/// Writes the survey into a folder, which exists.
///
/// # Errors
/// [`FormatError`] for a file that cannot be written.
pub fn write(
    folder: &Path,
    scenario: &SeabedScenario,
    survey: &Simulated,
) -> Result<(), FormatError> {
    if scenario.format != "csv" {
        super::export::write(folder, scenario, survey)?;
        return write_truth(folder, survey);
    }
    trajectory_csv::write(
        &folder.join("trajectory.csv"),
        &trajectory(scenario, survey),
    )?;
    soundings_csv::write_records(
        &folder.join("multibeam.csv"),
        soundings(scenario, &survey.shots),
    )?;
    sound_speed_csv::write(&folder.join("sound_speed.csv"), &profile(scenario, survey))?;
    write_tide(folder, scenario, survey, 0.0)?;
    whole::write_toml(&folder.join("survey.toml"), &survey_file(scenario, survey))?;
    write_truth(folder, survey)
}

/// Writes the tide, where there is one.
pub(super) fn write_tide(
    folder: &Path,
    scenario: &SeabedScenario,
    survey: &Simulated,
    later_s: f64,
) -> Result<(), FormatError> {
    let curve = tide(scenario, survey, later_s);
    curve.map_or(Ok(()), |curve| tide_csv::write(&folder.join(TIDE), &curve))
}

fn write_truth(folder: &Path, survey: &Simulated) -> Result<(), FormatError> {
    let path = folder.join("truth.json");
    let truth = serde_json::to_string_pretty(&survey.truth)
        .map_err(|e| FormatError::unwritable(&path, &e))?;
    whole::write_whole(&path, |out| writeln!(out, "{truth}"))
}
