//! Faults of a scenario: every one at once, by key, found and expected.

use super::motion::Oscillation;
use super::scenario::{Disturbance, Ins, Lidar, Multibeam, Pass, Recorded, Scenario, Water};
use super::sources::Source;
use crate::target::Target;

impl Scenario {
    /// Everything that is impossible in this scenario; empty when it can be simulated.
    #[must_use]
    pub fn check(&self) -> Vec<String> {
        let mut faults = Faults::default();
        self.check_target(&mut faults);
        self.trajectory.check(&mut faults);
        self.lidar.check(&mut faults);
        self.multibeam.check(&mut faults);
        self.disturbance.check(&mut faults);
        self.check_water(&mut faults);
        self.check_truth(&mut faults);
        self.check_motion(&mut faults);
        self.check_passes(&mut faults);
        self.check_sources(&mut faults);
        faults.0
    }

    fn check_target(&self, faults: &mut Faults) {
        let t = &self.target;
        if let Err(error) = Target::from_model(&t.model) {
            let of_model = |fault| format!("target.model.{fault}");
            faults.0.extend(error.faults.into_iter().map(of_model));
        }
        faults.range(
            "target.origin.latitude_deg",
            t.origin.latitude_deg,
            -89.9,
            89.9,
        );
        faults.range(
            "target.origin.longitude_deg",
            t.origin.longitude_deg,
            -360.0,
            360.0,
        );
        faults.range(
            "target.origin.height_m",
            t.origin.height_m,
            -12_000.0,
            9000.0,
        );
        faults.range("target.azimuth_deg", t.azimuth_deg, -360.0, 360.0);
        faults.range("target.water_level_m", t.water_level_m, -1000.0, 1000.0);
        faults.range("target.prior_turn_deg", t.prior_turn_deg, -180.0, 180.0);
        faults.range(
            "target.prior_turn_sigma_deg",
            t.prior_turn_sigma_deg,
            0.0,
            90.0,
        );
        faults.range(
            "target.prior_offset_sigma_m",
            t.prior_offset_sigma_m,
            0.0,
            1000.0,
        );
        faults.range("target.roughness_sigma_m", t.roughness_sigma_m, 0.0, 1.0);
        faults.ranges("target.prior_offset_m", &t.prior_offset_m, -1000.0, 1000.0);
        if let Some(floor) = self.basin.floor_m {
            faults.range("basin.floor_m", floor, -1000.0, t.water_level_m);
        }
        for (k, wall) in self.basin.wall.iter().enumerate() {
            let length = wall.normal.iter().map(|c| c * c).sum::<f64>().sqrt();
            faults.range(
                &format!("basin.wall[{k}].normal (length)"),
                length,
                1e-6,
                1e6,
            );
            faults.ranges(
                &format!("basin.wall[{k}].point_m"),
                &wall.point_m,
                -1e6,
                1e6,
            );
        }
    }

    fn check_water(&self, faults: &mut Faults) {
        let travel_time = self.multibeam.records == Recorded::TravelTime;
        match &self.sound_speed {
            Some(water) => {
                water.check(faults);
                self.check_true_speeds(water, faults);
            }
            None if travel_time => faults.0.push(
                "[sound_speed] not found, expected one because multibeam.records = \"travel_time\""
                    .to_owned(),
            ),
            None => {}
        }
        let one = self
            .sound_speed
            .as_ref()
            .is_some_and(|w| w.speed_m_s.is_some());
        if self.multibeam.arrays.is_some() && !one {
            faults.0.push(
                "[sound_speed] speed_m_s not found, expected one because multibeam.arrays (or a recorder's file as multibeam.path) is simulated in water of one speed"
                    .to_owned(),
            );
        }
    }

    /// Deepest place that a ray of the multibeam can come to, metres below the water level: from its deepest stand straight down.
    #[must_use]
    pub(super) fn deepest_m(&self) -> f64 {
        let (height, m) = (&self.motion.height, &self.multibeam);
        let swing: f64 = height.wave.iter().map(|w| w.amplitude.abs()).sum();
        let length = |arm: &[f64; 3]| arm.iter().map(|x| x * x).sum::<f64>().sqrt();
        let arm = length(&m.lever_arm_m) + length(&self.truth.lever_arm_correction_m);
        let lowest_m = height.mean - swing - arm;
        (self.target.water_level_m - lowest_m).max(0.0) + m.max_range_m
    }

    /// The speeds that the unknown gradient makes of the known ones, as far down as a ray comes.
    fn check_true_speeds(&self, water: &Water, faults: &mut Faults) {
        let deepest_m = self.deepest_m();
        let factor = self.sources.factor(Source::SoundSpeedGradient);
        let (given, random) = (
            water.gradient_error_1_s * factor,
            SIGMAS * water.gradient_sigma_1_s * factor,
        );
        let known = |&[depth, speed]: &[f64; 2]| (depth.min(deepest_m), speed);
        let last = water.speed_m_s.map(|speed| (deepest_m, speed));
        for (depth_m, speed) in water.profile.iter().map(known).chain(last) {
            let key = format!("sound_speed: true speed at {depth_m:.1} m of depth");
            let speeds = [given - random, given + random].map(|g| speed + g * depth_m);
            faults.ranges(&key, &speeds, 1000.0, 2000.0);
        }
    }

    fn check_truth(&self, faults: &mut Faults) {
        let t = &self.truth;
        let angles = [
            t.correction_deg.pitch,
            t.correction_deg.roll,
            t.correction_deg.yaw,
        ];
        faults.ranges("truth.correction_deg", &angles, -180.0, 180.0);
        faults.ranges(
            "truth.lever_arm_correction_m",
            &t.lever_arm_correction_m,
            -100.0,
            100.0,
        );
        faults.range("truth.latency_s", t.latency_s, -5.0, 5.0);
        faults.range("truth.latency_sigma_s", t.latency_sigma_s, 0.0, 1.0);
        faults.range("truth.latency_jitter_s", t.latency_jitter_s, 0.0, 0.1);
        faults.range("truth.range_scale", t.range_scale, -0.2, 0.2);
        faults.range("truth.range_scale_sigma", t.range_scale_sigma, 0.0, 0.05);
    }

    fn check_motion(&self, faults: &mut Faults) {
        let m = &self.motion;
        let all = [
            ("sway", &m.sway, 50.0),
            ("surge", &m.surge, 50.0),
            ("height", &m.height, 1000.0),
            ("roll", &m.roll, 60.0),
            ("pitch", &m.pitch, 60.0),
            ("heading", &m.heading, 180.0),
        ];
        for (name, oscillation, limit) in all {
            oscillation.check(name, limit, faults);
        }
    }

    fn check_passes(&self, faults: &mut Faults) {
        if self.pass.is_empty() {
            faults
                .0
                .push("no [[pass]] found, expected at least one".to_owned());
        }
        for (k, pass) in self.pass.iter().enumerate() {
            pass.check(k, self.shortest_gap_s(), faults);
        }
        self.check_counts(faults);
    }

    /// How much would be simulated; each count with the key that mends it best.
    fn check_counts(&self, faults: &mut Faults) {
        let seconds = |p: &Pass| (p.to_m - p.from_m).abs() / p.speed_m_s;
        let total_s: f64 = self.pass.iter().map(seconds).sum();
        let (l, m) = (&self.lidar, &self.multibeam);
        let returns = total_s * l.line_rate_hz * f64::from(l.points_per_line);
        let soundings = total_s * m.ping_rate_hz * f64::from(m.beams);
        faults.most("pass", "passes", self.pass.len() as f64, 1000.0);
        faults.most(
            "trajectory.rate_hz",
            "trajectory records",
            total_s * self.trajectory.rate_hz,
            5e6,
        );
        faults.most("lidar.line_rate_hz", "laser returns", returns, 2e7);
        faults.most("multibeam.ping_rate_hz", "soundings", soundings, 2e7);
        let m = &self.motion;
        let waves = [&m.sway, &m.surge, &m.height, &m.roll, &m.pitch, &m.heading];
        let waves: usize = waves.iter().map(|o| o.wave.len()).sum();
        faults.most("motion", "waves", waves as f64, 1000.0);
        let bodies = self.disturbance.body.len() + self.basin.wall.len();
        faults.most(
            "disturbance.body",
            "bodies and walls",
            bodies as f64,
            1000.0,
        );
        let knots = self.sound_speed.as_ref().map_or(0, |w| w.profile.len());
        faults.most("sound_speed.profile", "depths", knots as f64, 10_000.0);
    }

    /// Gaps between passes must be longer than what is interpolated, plus what is recorded before and after.
    fn shortest_gap_s(&self) -> f64 {
        let t = &self.truth;
        let margin_s = 5.0 / self.trajectory.rate_hz
            + t.latency_s.abs()
            + 8.0 * (t.latency_sigma_s + t.latency_jitter_s);
        self.trajectory.max_gap_s + 2.0 * margin_s
    }

    fn check_sources(&self, faults: &mut Faults) {
        for (source, factor) in self.sources.iter() {
            let limit = match source {
                Source::GrossErrors | Source::Clutter | Source::Multipath => 1.0,
                _ => 1e3,
            };
            faults.range(&format!("sources.{source:?}"), factor, 0.0, limit);
        }
    }
}

impl Ins {
    fn check(&self, faults: &mut Faults) {
        faults.range("trajectory.rate_hz", self.rate_hz, 0.5, 10_000.0);
        faults.range(
            "trajectory.position_sigma_m",
            self.position_sigma_m,
            0.0,
            100.0,
        );
        faults.range(
            "trajectory.position_drift_sigma_m",
            self.position_drift_sigma_m,
            0.0,
            100.0,
        );
        faults.range(
            "trajectory.drift_correlation_time_s",
            self.drift_correlation_time_s,
            1e-3,
            1e7,
        );
        faults.range(
            "trajectory.roll_pitch_sigma_deg",
            self.roll_pitch_sigma_deg,
            0.0,
            10.0,
        );
        faults.range(
            "trajectory.heading_sigma_deg",
            self.heading_sigma_deg,
            0.0,
            10.0,
        );
        faults.range(
            "trajectory.heading_drift_sigma_deg",
            self.heading_drift_sigma_deg,
            0.0,
            10.0,
        );
        faults.range(
            "trajectory.max_gap_s",
            self.max_gap_s,
            2.0 / self.rate_hz,
            3600.0,
        );
    }
}

impl Lidar {
    fn check(&self, faults: &mut Faults) {
        faults.ranges("lidar.lever_arm_m", &self.lever_arm_m, -100.0, 100.0);
        faults.range("lidar.range_sigma_m", self.range_sigma_m, 0.0, 10.0);
        faults.range("lidar.angle_sigma_deg", self.angle_sigma_deg, 0.0, 10.0);
        faults.range("lidar.line_rate_hz", self.line_rate_hz, 0.01, 10_000.0);
        faults.range(
            "lidar.points_per_line",
            f64::from(self.points_per_line),
            2.0,
            30_000.0,
        );
        faults.range(
            "lidar.to_deg",
            self.to_deg,
            self.from_deg + 1e-3,
            self.from_deg + 360.0,
        );
        faults.range("lidar.duty", self.duty, 1e-3, 1.0);
        faults.range("lidar.max_range_m", self.max_range_m, 0.1, 10_000.0);
        faults.ranges(
            "lidar.mounting_sigma_deg",
            &self.mounting_sigma_deg,
            0.0,
            10.0,
        );
        faults.ranges(
            "lidar.lever_arm_sigma_m",
            &self.lever_arm_sigma_m,
            0.0,
            10.0,
        );
        faults.ranges(
            "lidar.lever_arm_error_m",
            &self.lever_arm_error_m,
            -100.0,
            100.0,
        );
    }
}

impl Multibeam {
    fn check(&self, faults: &mut Faults) {
        faults.ranges("multibeam.lever_arm_m", &self.lever_arm_m, -100.0, 100.0);
        faults.range("multibeam.range_sigma_m", self.range_sigma_m, 0.0, 10.0);
        faults.range("multibeam.angle_sigma_deg", self.angle_sigma_deg, 0.0, 10.0);
        faults.range(
            "multibeam.along_angle_sigma_deg",
            self.along_angle_sigma_deg,
            0.0,
            10.0,
        );
        faults.range(
            "multibeam.outer_beam_factor",
            self.outer_beam_factor,
            0.0,
            100.0,
        );
        faults.range("multibeam.ping_rate_hz", self.ping_rate_hz, 0.01, 10_000.0);
        faults.range("multibeam.beams", f64::from(self.beams), 2.0, 30_000.0);
        faults.range(
            "multibeam.to_deg",
            self.to_deg,
            self.from_deg + 1e-3,
            self.from_deg + 360.0,
        );
        faults.range("multibeam.max_range_m", self.max_range_m, 0.5, 10_000.0);
        if let Some(arrays) = &self.arrays {
            let sectors = f64::from(arrays.sectors);
            faults.range("multibeam.arrays.sectors", sectors, 1.0, 9.0);
            let tilt = arrays.sector_tilt_deg;
            faults.range("multibeam.arrays.sector_tilt_deg", tilt, -10.0, 10.0);
            let delay_s = arrays.sector_delay_s;
            faults.range("multibeam.arrays.sector_delay_s", delay_s, 0.0, 0.1);
            let offset_m = &arrays.receiver_offset_m;
            faults.ranges(
                "multibeam.arrays.receiver_offset_m",
                offset_m,
                -100.0,
                100.0,
            );
        }
    }
}

impl Water {
    fn check(&self, faults: &mut Faults) {
        if self.speed_m_s.is_some() != self.profile.is_empty() {
            faults
                .0
                .push("sound_speed: expected either speed_m_s or profile".to_owned());
        }
        if let Some(speed) = self.speed_m_s {
            faults.range("sound_speed.speed_m_s", speed, 1300.0, 1700.0);
        }
        for (k, [depth, speed]) in self.profile.iter().enumerate() {
            let least = if k == 0 {
                0.0
            } else {
                self.profile[k - 1][0] + 1e-6
            };
            faults.range(
                &format!("sound_speed.profile[{k}] depth"),
                *depth,
                least,
                12_000.0,
            );
            faults.range(
                &format!("sound_speed.profile[{k}] speed"),
                *speed,
                1300.0,
                1700.0,
            );
        }
        faults.range(
            "sound_speed.gradient_error_1_s",
            self.gradient_error_1_s,
            -10.0,
            10.0,
        );
        faults.range(
            "sound_speed.gradient_sigma_1_s",
            self.gradient_sigma_1_s,
            0.0,
            10.0,
        );
    }
}

impl Disturbance {
    fn check(&self, faults: &mut Faults) {
        faults.range("disturbance.gross_fraction", self.gross_fraction, 0.0, 1.0);
        faults.range("disturbance.gross_range_m", self.gross_range_m, 0.0, 1e4);
        faults.range(
            "disturbance.sonar_clutter_fraction",
            self.sonar_clutter_fraction,
            0.0,
            1.0,
        );
        faults.range(
            "disturbance.laser_clutter_fraction",
            self.laser_clutter_fraction,
            0.0,
            1.0,
        );
        faults.range(
            "disturbance.multipath_fraction",
            self.multipath_fraction,
            0.0,
            1.0,
        );
        faults.range(
            "disturbance.multipath_delay_m",
            self.multipath_delay_m,
            0.0,
            1e4,
        );
        for (k, body) in self.body.iter().enumerate() {
            faults.ranges(
                &format!("disturbance.body[{k}].size_m"),
                &body.size_m,
                1e-3,
                1e4,
            );
            faults.ranges(
                &format!("disturbance.body[{k}].centre_m"),
                &body.centre_m,
                -1e5,
                1e5,
            );
            faults.ranges(
                &format!("disturbance.body[{k}].velocity_m_s"),
                &body.velocity_m_s,
                -100.0,
                100.0,
            );
        }
    }
}

impl Pass {
    fn check(&self, k: usize, shortest_gap_s: f64, faults: &mut Faults) {
        let key = |name: &str| format!("pass[{k}].{name}");
        faults.range(&key("distance_m"), self.distance_m, -1e4, 1e4);
        faults.range(&key("from_m"), self.from_m, -1e5, 1e5);
        faults.range(&key("to_m"), self.to_m, -1e5, 1e5);
        faults.range(&key("speed_m_s"), self.speed_m_s, 1e-3, 100.0);
        faults.range(&key("crab_deg"), self.crab_deg, -180.0, 180.0);
        let seconds = (self.to_m - self.from_m).abs() / self.speed_m_s;
        faults.range(&key("duration (way / speed) in s"), seconds, 0.1, 1e5);
        if k > 0 {
            faults.range(&key("gap_s"), self.gap_s, shortest_gap_s, 1e6);
        }
    }
}

impl Oscillation {
    fn check(&self, name: &str, limit: f64, faults: &mut Faults) {
        faults.range(&format!("motion.{name}.mean"), self.mean, -limit, limit);
        for (k, wave) in self.wave.iter().enumerate() {
            let key = |part: &str| format!("motion.{name}.wave[{k}].{part}");
            faults.range(&key("amplitude"), wave.amplitude, -limit, limit);
            faults.range(&key("period_s"), wave.period_s, 0.05, 1e6);
            faults.range(&key("phase_deg"), wave.phase_deg, -360.0, 360.0);
        }
    }
}

/// Random errors are judged up to this many sigmas.
const SIGMAS: f64 = 6.0;

/// What was found wrong so far.
#[derive(Default)]
struct Faults(Vec<String>);

impl Faults {
    fn range(&mut self, key: &str, found: f64, low: f64, high: f64) {
        if !(found >= low && found <= high) {
            self.0
                .push(format!("{key} = {found}, expected {low} to {high}"));
        }
    }

    /// A count that the scenario's keys make, and the most of it that is simulated.
    fn most(&mut self, key: &str, what: &str, found: f64, most: f64) {
        if found > most {
            self.0.push(format!(
                "{key}: found {found:.0} {what}, expected at most {most:.0}"
            ));
        }
    }

    fn ranges(&mut self, key: &str, found: &[f64], low: f64, high: f64) {
        if found.iter().any(|x| !(*x >= low && *x <= high)) {
            self.0.push(format!(
                "{key} = {found:?}, expected each from {low} to {high}"
            ));
        }
    }
}
