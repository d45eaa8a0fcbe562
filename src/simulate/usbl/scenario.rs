//! A USBL scenario: a survey file's figures, and what only a simulator needs.

use serde::{Deserialize, Serialize};

use super::sources::Sources;
use crate::geometry::Ellipsoid;
use crate::observe::usbl::AngleModel;
use crate::simulate::motion::Oscillation;
use crate::simulate::scenario::{Angles, Origin, Turn};

/// Everything that makes a simulated survey.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// `usbl`.
    #[serde(default)]
    pub procedure: Procedure,
    /// Name for reports.
    pub name: String,
    /// Seed where the command line gives none.
    #[serde(default = "one")]
    pub seed: u64,
    /// Where the transducer's centre truly is, and how well it is surveyed.
    pub transducer: Transducer,
    /// The beacons.
    pub beacons: Beacons,
    /// How control coordinates are written.
    #[serde(default)]
    pub control: Control,
    /// The fixes.
    pub fixes: FixPlan,
    /// The attitude sensor.
    pub attitude: Attitude,
    /// The water.
    pub sound_speed: Water,
    /// What the calibration should find.
    #[serde(default)]
    pub truth: TrueMounting,
    /// Motion of the attitude sensor's body, degrees.
    #[serde(default)]
    pub motion: Motion,
    /// Gross errors.
    #[serde(default)]
    pub disturbance: Disturbance,
    /// Factors on the error sources.
    #[serde(default)]
    pub sources: Sources,
}

/// The only procedure of such a scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Procedure {
    /// Ultra-short baseline.
    #[default]
    Usbl,
}

/// `[transducer]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transducer {
    /// Geodetic position.
    pub origin: Origin,
    /// Ellipsoid.
    #[serde(default)]
    pub ellipsoid: Ellipsoid,
    /// Depth below the water level, metres.
    pub depth_m: f64,
    /// Standard deviation of the survey, east, north, up, metres.
    pub sigma_m: [f64; 3],
    /// Nominal mounting on the attitude sensor.
    #[serde(default)]
    pub mounting_deg: Angles,
}

/// `[beacons]`: the patent's square with its centre, or a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beacons {
    /// Depth of the patent's beacons below the water level, metres; at least 6 in the patent.
    #[serde(default)]
    pub water_depth_m: f64,
    /// Centre to corner of the patent's square, metres, 3 to 5 in the patent; 0 for none.
    #[serde(default)]
    pub centre_to_corner_m: f64,
    /// Azimuth of its first corner, degrees.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Centre of the square, east and north of the transducer, metres.
    #[serde(default)]
    pub centre_m: [f64; 2],
    /// Standard deviation of the survey, east, north, up, metres.
    pub sigma_m: [f64; 3],
    /// Beacons beside the square.
    #[serde(default)]
    pub beacon: Vec<OneBeacon>,
}

/// A beacon of a layout of one's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OneBeacon {
    /// Name.
    pub name: String,
    /// True position from the transducer, east, north, up, metres.
    pub position_m: [f64; 3],
    /// Whether it only checks.
    #[serde(default)]
    pub check: bool,
}

/// `[control]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Control {
    /// How coordinates are written.
    #[serde(default)]
    pub coordinates: Coordinates,
    /// Deflection of the vertical and tilt of the control, about east and north each, degrees.
    #[serde(default)]
    pub tilt_sigma_deg: f64,
    /// Orientation of the control, degrees.
    #[serde(default)]
    pub azimuth_sigma_deg: f64,
}

/// Coordinates of control points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coordinates {
    /// Earth-centred, earth-fixed.
    #[default]
    Geocentric,
    /// Latitude, longitude, ellipsoidal height.
    Geodetic,
    /// East, north, up.
    Local,
}

/// `[fixes]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixPlan {
    /// Fixes of every beacon.
    pub per_beacon: u32,
    /// Fixes per second, the beacons in turn.
    pub rate_hz: f64,
    /// Range noise, metres.
    pub range_sigma_m: f64,
    /// Range noise, parts per million of the range.
    #[serde(default)]
    pub range_sigma_ppm: f64,
    /// Angle noise at broadside, degrees.
    pub angle_sigma_deg: f64,
    /// How it depends on the direction.
    #[serde(default)]
    pub angle_model: AngleModel,
    /// What is written.
    #[serde(default)]
    pub records: Recorded,
    /// Speed with which the device makes ranges of travel times, metres per second.
    pub nominal_speed_m_s: f64,
}

/// What a device writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Recorded {
    /// x, y, z in the transducer frame, with the nominal speed.
    #[default]
    Cartesian,
    /// Slant range with the nominal speed, bearing and depression.
    RangeAngles,
    /// Two-way travel time and the angles to the baselines.
    TimeAngles,
}

/// `[attitude]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attitude {
    /// Records per second.
    pub rate_hz: f64,
    /// White noise of roll and pitch, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// White noise of heading, degrees.
    pub heading_sigma_deg: f64,
}

/// `[sound_speed]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// The measured profile: depth (m) and speed (m/s) of each sample; one sample for a constant speed.
    pub profile: Vec<[f64; 2]>,
    /// Standard deviation of a constant error of the measured speed, metres per second.
    #[serde(default)]
    pub sigma_m_s: f64,
}

/// `[truth]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueMounting {
    /// True mounting minus nominal, about the body axes.
    #[serde(default)]
    pub correction_deg: Turn,
}

/// `[motion]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Roll, positive starboard down, degrees.
    #[serde(default)]
    pub roll: Oscillation,
    /// Pitch, positive bow up, degrees.
    #[serde(default)]
    pub pitch: Oscillation,
    /// Heading, degrees.
    #[serde(default)]
    pub heading: Oscillation,
}

/// `[disturbance]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// Share of the fixes that are grossly wrong.
    #[serde(default)]
    pub gross_fraction: f64,
    /// Largest excess of their range, metres: echoes come late, never early.
    #[serde(default)]
    pub gross_range_m: f64,
    /// Largest error of their angles, degrees.
    #[serde(default)]
    pub gross_angle_deg: f64,
}

fn one() -> u64 {
    1
}

impl Scenario {
    /// Everything that is impossible in this scenario; empty when it can be simulated.
    #[must_use]
    pub fn check(&self) -> Vec<String> {
        let mut faults = vec![];
        let mut range = |key: &str, found: f64, low: f64, high: f64| {
            if !(found >= low && found <= high) {
                faults.push(format!("{key} = {found}, expected {low} to {high}"));
            }
        };
        let origin = &self.transducer.origin;
        range(
            "transducer.origin.latitude_deg",
            origin.latitude_deg,
            -89.9,
            89.9,
        );
        range(
            "transducer.origin.longitude_deg",
            origin.longitude_deg,
            -360.0,
            360.0,
        );
        range(
            "transducer.origin.height_m",
            origin.height_m,
            -12_000.0,
            9000.0,
        );
        range(
            "transducer.depth_m",
            self.transducer.depth_m,
            1e-3,
            11_000.0,
        );
        for sigma in self.transducer.sigma_m {
            range("transducer.sigma_m", sigma, 0.0, 10.0);
        }
        for sigma in self.beacons.sigma_m {
            range("beacons.sigma_m", sigma, 0.0, 10.0);
        }
        range(
            "beacons.centre_to_corner_m",
            self.beacons.centre_to_corner_m,
            0.0,
            10_000.0,
        );
        if self.beacons.centre_to_corner_m > 0.0 {
            let least = self.transducer.depth_m + 0.01;
            range(
                "beacons.water_depth_m",
                self.beacons.water_depth_m,
                least,
                11_000.0,
            );
        }
        for (k, beacon) in self.beacons.beacon.iter().enumerate() {
            let below = -beacon.position_m[2];
            range(
                &format!("beacons.beacon[{k}].position_m (depth below the transducer)"),
                below,
                -self.transducer.depth_m,
                11_000.0,
            );
        }
        range(
            "control.tilt_sigma_deg",
            self.control.tilt_sigma_deg,
            0.0,
            10.0,
        );
        range(
            "control.azimuth_sigma_deg",
            self.control.azimuth_sigma_deg,
            0.0,
            10.0,
        );
        let f = &self.fixes;
        range("fixes.per_beacon", f64::from(f.per_beacon), 1.0, 1e6);
        range("fixes.rate_hz", f.rate_hz, 1e-6, 1e4);
        range("fixes.range_sigma_m", f.range_sigma_m, 1e-6, 100.0);
        range("fixes.range_sigma_ppm", f.range_sigma_ppm, 0.0, 1e5);
        range("fixes.angle_sigma_deg", f.angle_sigma_deg, 1e-6, 30.0);
        range(
            "fixes.nominal_speed_m_s",
            f.nominal_speed_m_s,
            1300.0,
            1700.0,
        );
        let a = &self.attitude;
        range("attitude.rate_hz", a.rate_hz, 1e-3, 1e4);
        range(
            "attitude.roll_pitch_sigma_deg",
            a.roll_pitch_sigma_deg,
            0.0,
            10.0,
        );
        range("attitude.heading_sigma_deg", a.heading_sigma_deg, 0.0, 10.0);
        range(
            "sound_speed.profile (samples)",
            self.sound_speed.profile.len() as f64,
            1.0,
            1e6,
        );
        let mut above = -1e-9;
        for [depth, speed] in &self.sound_speed.profile {
            range(
                "sound_speed.profile (depth, ascending)",
                *depth,
                above,
                12_000.0,
            );
            range("sound_speed.profile (speed)", *speed, 1300.0, 1700.0);
            above = depth + 1e-9;
        }
        range(
            "sound_speed.sigma_m_s",
            self.sound_speed.sigma_m_s,
            0.0,
            50.0,
        );
        let d = &self.disturbance;
        range("disturbance.gross_fraction", d.gross_fraction, 0.0, 1.0);
        range("disturbance.gross_range_m", d.gross_range_m, 0.0, 1e4);
        range("disturbance.gross_angle_deg", d.gross_angle_deg, 0.0, 180.0);
        if self.beacons.centre_to_corner_m == 0.0 && self.beacons.beacon.is_empty() {
            faults.push(
                "beacons: found none, expected centre_to_corner_m or [[beacons.beacon]]".to_owned(),
            );
        }
        faults
    }
}
