//! A USBL scenario: a survey file's figures, and what only a simulator needs.

use serde::{Deserialize, Serialize};

use super::super::observed::AngleModel;
use super::sources::Sources;
use crate::geometry::Ellipsoid;
use crate::math;
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
    /// Noise of roll and pitch, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// Noise of heading, degrees.
    pub heading_sigma_deg: f64,
    /// Correlation time of that noise where it wanders (Gauss-Markov), seconds; 0: it is white.
    #[serde(default)]
    pub attitude_correlation_time_s: f64,
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

/// What is wrong, in words.
#[derive(Default)]
struct Faults(Vec<String>);

impl Faults {
    fn range(&mut self, key: &str, found: f64, low: f64, high: f64) {
        if !(found >= low && found <= high) {
            self.0
                .push(format!("{key} = {found}, expected {low} to {high}"));
        }
    }

    fn sigmas(&mut self, key: &str, found: &[f64], high: f64) {
        for sigma in found {
            self.range(key, *sigma, 0.0, high);
        }
    }
}

impl Scenario {
    /// Everything that is impossible in this scenario; empty when it can be simulated.
    #[must_use]
    pub fn check(&self) -> Vec<String> {
        let mut faults = Faults::default();
        self.transducer.check(&mut faults);
        self.beacons.check(self.transducer.depth_m, &mut faults);
        let c = &self.control;
        let control = [c.tilt_sigma_deg, c.azimuth_sigma_deg];
        faults.sigmas("control (sigmas, degrees)", &control, 10.0);
        self.fixes.check(&mut faults);
        let a = &self.attitude;
        faults.range("attitude.rate_hz", a.rate_hz, 1e-3, 1e4);
        let attitude = [a.roll_pitch_sigma_deg, a.heading_sigma_deg];
        faults.sigmas("attitude (sigmas, degrees)", &attitude, 10.0);
        let correlation_s = a.attitude_correlation_time_s;
        faults.range(
            "attitude.attitude_correlation_time_s",
            correlation_s,
            0.0,
            1e6,
        );
        self.sound_speed.check(&mut faults);
        let d = &self.disturbance;
        faults.range("disturbance.gross_fraction", d.gross_fraction, 0.0, 1.0);
        faults.range("disturbance.gross_range_m", d.gross_range_m, 0.0, 1e4);
        faults.range("disturbance.gross_angle_deg", d.gross_angle_deg, 0.0, 180.0);
        self.motion.check(&mut faults);
        for (source, factor) in self.sources.iter() {
            faults.range(&format!("sources.{source:?}"), factor, 0.0, 1e6);
        }
        self.check_counts(&mut faults);
        faults.0
    }

    /// How much would be simulated.
    fn check_counts(&self, faults: &mut Faults) {
        let beacons = (self.beacons.beacon.len() + 5) as f64;
        let fixes = beacons * f64::from(self.fixes.per_beacon);
        faults.range("beacons.beacon (their number)", beacons - 5.0, 0.0, 1000.0);
        faults.range("fixes.per_beacon (fixes of all beacons)", fixes, 0.0, 2e6);
        let records = fixes / self.fixes.rate_hz * self.attitude.rate_hz;
        faults.range(
            "attitude.rate_hz (attitude records of all fixes)",
            records,
            0.0,
            2e7,
        );
        let knots = self.sound_speed.profile.len() as f64;
        faults.range("sound_speed.profile (depths)", knots, 0.0, 10_000.0);
    }
}

impl Transducer {
    fn check(&self, faults: &mut Faults) {
        let o = &self.origin;
        faults.range(
            "transducer.origin.latitude_deg",
            o.latitude_deg,
            -89.9,
            89.9,
        );
        faults.range(
            "transducer.origin.longitude_deg",
            o.longitude_deg,
            -360.0,
            360.0,
        );
        faults.range("transducer.origin.height_m", o.height_m, -12_000.0, 9000.0);
        faults.range("transducer.depth_m", self.depth_m, 1e-3, 11_000.0);
        faults.sigmas("transducer.sigma_m", &self.sigma_m, 10.0);
    }
}

impl Beacons {
    fn check(&self, depth_m: f64, faults: &mut Faults) {
        faults.sigmas("beacons.sigma_m", &self.sigma_m, 10.0);
        let side_m = self.centre_to_corner_m;
        faults.range("beacons.centre_to_corner_m", side_m, 0.0, 10_000.0);
        if side_m > 0.0 {
            let least_m = depth_m + 0.01;
            faults.range(
                "beacons.water_depth_m",
                self.water_depth_m,
                least_m,
                11_000.0,
            );
        }
        for (k, beacon) in self.beacon.iter().enumerate() {
            let key = format!("beacons.beacon[{k}].position_m");
            let [east, north, up] = beacon.position_m;
            faults.range(
                &format!("{key} (depth below the transducer)"),
                -up,
                -depth_m,
                11_000.0,
            );
            let range_m = math::hypot(math::hypot(east, north), up);
            faults.range(&format!("{key} (distance)"), range_m, 1e-3, 12_000.0);
        }
        if side_m == 0.0 && self.beacon.is_empty() {
            let fault = "beacons: found none, expected centre_to_corner_m or [[beacons.beacon]]";
            faults.0.push(fault.to_owned());
        }
    }
}

impl FixPlan {
    fn check(&self, faults: &mut Faults) {
        faults.range("fixes.per_beacon", f64::from(self.per_beacon), 1.0, 1e6);
        faults.range("fixes.rate_hz", self.rate_hz, 1e-6, 1e4);
        faults.range("fixes.range_sigma_m", self.range_sigma_m, 1e-6, 100.0);
        faults.range("fixes.range_sigma_ppm", self.range_sigma_ppm, 0.0, 1e5);
        faults.range("fixes.angle_sigma_deg", self.angle_sigma_deg, 1e-6, 30.0);
        faults.range(
            "fixes.nominal_speed_m_s",
            self.nominal_speed_m_s,
            1300.0,
            1700.0,
        );
    }
}

impl Water {
    fn check(&self, faults: &mut Faults) {
        let samples = self.profile.len() as f64;
        faults.range("sound_speed.profile (samples)", samples, 1.0, 1e6);
        let mut above = 0.0;
        for [depth, speed] in &self.profile {
            faults.range(
                "sound_speed.profile (depth, ascending)",
                *depth,
                above,
                12_000.0,
            );
            faults.range("sound_speed.profile (speed)", *speed, 1300.0, 1700.0);
            above = depth + 1e-9;
        }
        faults.range("sound_speed.sigma_m_s", self.sigma_m_s, 0.0, 50.0);
    }
}

impl Motion {
    fn check(&self, faults: &mut Faults) {
        for (name, model) in [
            ("roll", &self.roll),
            ("pitch", &self.pitch),
            ("heading", &self.heading),
        ] {
            faults.range(&format!("motion.{name}.mean"), model.mean, -360.0, 360.0);
            for wave in &model.wave {
                faults.range(
                    &format!("motion.{name}.wave.amplitude"),
                    wave.amplitude,
                    -90.0,
                    90.0,
                );
                faults.range(
                    &format!("motion.{name}.wave.period_s"),
                    wave.period_s,
                    1e-3,
                    1e6,
                );
            }
        }
    }
}
