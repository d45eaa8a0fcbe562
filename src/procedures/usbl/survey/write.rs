//! A simulated USBL survey as files: survey file, observations, and the truth.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::super::formats::control_csv::{
    self, ControlCoordinates, ControlRecords, ControlRole, ControlRow, SigmaAxes,
};
use super::super::formats::fixes_csv::{self, DirectionKind, FixRecords, RangeKind};
use super::super::observed::{ControlPoint, Role};
use super::file::{
    AttitudeSection, ControlSection, FixesSection, TransducerSection, UsblFile, UsblProcedure,
    WaterSection,
};
use super::scenario::{Calibration, UsblScenarioFile};
use crate::formats::Invalid;
use crate::formats::attitude_csv;
use crate::formats::whole::{write_json, write_toml};
use crate::formats::{FormatError, sound_speed_csv};
use crate::geometry::ellipsoid::ecef_from_level;
use crate::geometry::{Geodetic, Point};
use crate::observe::{AttitudeRecord, SoundSpeed};
use crate::procedures::usbl::simulate::scenario::{Coordinates, Recorded};
use crate::procedures::usbl::simulate::{Scenario, Simulated};
use crate::simulate::scenario::Angles;
use crate::survey::sections::{MountingAngles, OutsideRule};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

const CONTROL_FILE: &str = "control.csv";
const FIXES_FILE: &str = "fixes.csv";
const ATTITUDE_FILE: &str = "attitude.csv";
const PROFILE_FILE: &str = "sound-speed.csv";

/// Writes everything that a calibration of this survey reads, and `truth.json`, into a folder that exists.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write_survey(
    folder: &Path,
    file: &UsblScenarioFile,
    calibration: &Calibration,
    survey: &Simulated,
) -> Result<(), FormatError> {
    let scenario = &file.scenario;
    control_csv::write(&folder.join(CONTROL_FILE), &control(scenario, survey))?;
    fixes_csv::write(&folder.join(FIXES_FILE), &fixes(scenario, survey))?;
    let times_s = survey.campaign.attitude.times_s().to_vec();
    let attitude = AttitudeRecord::from_angles(times_s, &survey.attitude_rad);
    let path = folder.join(ATTITUDE_FILE);
    attitude_csv::write(&path, &attitude, &attitude_csv::VESSEL)?;
    if let SoundSpeed::Profile(profile) = &survey.campaign.sound_speed {
        sound_speed_csv::write(&folder.join(PROFILE_FILE), profile)?;
    }
    write_toml(
        &folder.join(SURVEY_FILE),
        &survey_file(scenario, calibration),
    )?;
    write_json(&folder.join(TRUTH_FILE), &survey.truth)
}

fn survey_file(scenario: &Scenario, calibration: &Calibration) -> UsblFile {
    let (f, a) = (&scenario.fixes, &scenario.attitude);
    let Angles {
        roll,
        pitch,
        heading,
    } = scenario.transducer.mounting_deg;
    UsblFile {
        name: scenario.name.clone(),
        procedure: UsblProcedure::Usbl,
        control: ControlSection {
            path: CONTROL_FILE.to_owned(),
            ellipsoid: scenario.transducer.ellipsoid,
            tilt_sigma_deg: scenario.control.tilt_sigma_deg,
            azimuth_sigma_deg: scenario.control.azimuth_sigma_deg,
        },
        fixes: FixesSection {
            path: FIXES_FILE.to_owned(),
            range_sigma_m: f.range_sigma_m,
            range_sigma_ppm: f.range_sigma_ppm,
            angle_sigma_deg: f.angle_sigma_deg,
            angle_model: f.angle_model,
            nominal_speed_m_s: Some(f.nominal_speed_m_s),
            turnaround_s: 0.0,
            time_offset_s: 0.0,
            invalid: Invalid::Error,
        },
        attitude: AttitudeSection {
            path: ATTITUDE_FILE.to_owned(),
            roll_pitch_sigma_deg: a.roll_pitch_sigma_deg,
            heading_sigma_deg: a.heading_sigma_deg,
            attitude_correlation_time_s: a.attitude_correlation_time_s,
            max_gap_s: 2.5 / a.rate_hz,
            outside: OutsideRule::Error,
            time_offset_s: 0.0,
        },
        transducer: TransducerSection {
            mounting_deg: MountingAngles {
                roll,
                pitch,
                heading,
            },
            depth_m: Some(scenario.transducer.depth_m),
        },
        sound_speed: WaterSection {
            speed_m_s: None,
            profile: Some(PROFILE_FILE.to_owned()),
            sigma_m_s: scenario.sound_speed.sigma_m_s,
        },
        reference: calibration.reference,
        joint: calibration.joint.clone(),
        verdict: calibration.verdict.clone(),
    }
}

/// The surveyed points in the coordinates of the scenario. The scenario's origin is the surveyed transducer.
fn control(scenario: &Scenario, survey: &Simulated) -> ControlRecords {
    let campaign = &survey.campaign;
    let place = Place::new(scenario);
    let mut rows = vec![place.row(&campaign.transducer, ControlRole::Transducer)];
    rows.extend(campaign.beacons.iter().map(|beacon| {
        let role = match beacon.role {
            Role::Common => ControlRole::Common,
            Role::Check => ControlRole::Check,
        };
        place.row(&beacon.point, role)
    }));
    ControlRecords {
        coordinates: match scenario.control.coordinates {
            Coordinates::Geocentric => ControlCoordinates::Geocentric,
            Coordinates::Geodetic => ControlCoordinates::Geodetic,
            Coordinates::Local => ControlCoordinates::Local,
        },
        axes: SigmaAxes::Level,
        rows,
    }
}

struct Place<'a> {
    scenario: &'a Scenario,
    origin_m: Vector3<f64>,
    ecef_from_level: Matrix3<f64>,
}

impl<'a> Place<'a> {
    fn new(scenario: &'a Scenario) -> Self {
        let origin = &scenario.transducer.origin;
        let geodetic = Geodetic {
            latitude_rad: origin.latitude_deg.to_radians(),
            longitude_rad: origin.longitude_deg.to_radians(),
            height_m: origin.height_m,
        };
        Self {
            scenario,
            origin_m: scenario
                .transducer
                .ellipsoid
                .to_geocentric(&geodetic)
                .coordinates,
            ecef_from_level: ecef_from_level(&geodetic).matrix,
        }
    }

    fn row(&self, point: &ControlPoint, role: ControlRole) -> ControlRow {
        let ecef = self.origin_m + self.ecef_from_level * point.position_m;
        let coordinates = match self.scenario.control.coordinates {
            Coordinates::Local => point.position_m,
            Coordinates::Geocentric => ecef,
            Coordinates::Geodetic => {
                let g = self
                    .scenario
                    .transducer
                    .ellipsoid
                    .to_geodetic(&Point::new(ecef));
                Vector3::new(g.latitude_rad, g.longitude_rad, g.height_m)
            }
        };
        ControlRow {
            name: point.name.clone(),
            role,
            coordinates: coordinates.into(),
            sigma_m: [0, 1, 2].map(|i| point.covariance_m2[(i, i)].sqrt()),
        }
    }
}

fn fixes(scenario: &Scenario, survey: &Simulated) -> FixRecords {
    let (campaign, fixes) = (&survey.campaign, &survey.campaign.fixes);
    let (range_kind, direction_kind) = match scenario.fixes.records {
        Recorded::Cartesian => (RangeKind::Metres, DirectionKind::Cartesian),
        Recorded::RangeAngles => (RangeKind::Metres, DirectionKind::BearingDepression),
        Recorded::TimeAngles => (RangeKind::TwoWay, DirectionKind::Baselines),
    };
    let per_second = match range_kind {
        RangeKind::Metres => fixes.speed_m_s,
        RangeKind::OneWay => 1.0,
        RangeKind::TwoWay => 2.0,
    };
    let name = |b: &u32| campaign.beacons[*b as usize].point.name.clone();
    FixRecords {
        time_s: fixes.time_s.clone(),
        beacon: fixes.beacon.iter().map(name).collect(),
        range_kind,
        direction_kind,
        range: fixes.travel_time_s.iter().map(|t| t * per_second).collect(),
        direction: fixes.direction.clone(),
        line: vec![],
        notes: vec![],
    }
}
