//! What a simulated rail calibration is like: a scenario file's keys.

use serde::{Deserialize, Serialize};

use super::sources::{RailSources, faults};

/// A rail scenario. Angles in degrees and lengths in metres, as the names say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailScenario {
    /// Name for reports.
    pub name: String,
    /// Always `rail`.
    pub procedure: String,
    /// Seed where the command names none.
    #[serde(default = "one")]
    pub seed: u64,
    /// The rail.
    pub rail: RailSection,
    /// The INS.
    pub attitude: AttitudeSection,
    /// The table.
    pub table: TableSection,
    /// The profilers.
    pub profiler: Vec<ProfilerSection>,
    /// Dust and occlusions.
    #[serde(default)]
    pub disturbance: Disturbance,
    /// Factors of the error sources.
    #[serde(default)]
    pub sources: RailSources,
}

fn one() -> u64 {
    1
}

/// `[rail]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailSection {
    /// `chn60`, `uic60`, or the path of a model file.
    pub model: String,
    /// Orientation in the level frame, degrees.
    #[serde(default)]
    pub orientation_deg: Angles,
    /// Its uncertainty about the level axes x, y, z, degrees.
    pub orientation_sigma_deg: [f64; 3],
    /// How far each element lies off the standard profile, metres, one sigma.
    #[serde(default)]
    pub profile_sigma_m: f64,
}

/// Roll, pitch, heading, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Angles {
    /// Positive right side down.
    pub roll: f64,
    /// Positive front up.
    pub pitch: f64,
    /// Clockwise.
    pub heading: f64,
}

/// `[attitude]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeSection {
    /// White noise of roll and pitch per record, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// White noise of heading per record, degrees.
    pub heading_sigma_deg: f64,
    /// Records per second.
    pub rate_hz: f64,
}

/// `[table]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSection {
    /// Each angle, per position, degrees, one sigma.
    pub angle_sigma_deg: f64,
    /// Tilt of the vertical axis, degrees, one sigma.
    pub level_sigma_deg: f64,
    /// Zero of the turn about the vertical, degrees, one sigma.
    pub zero_sigma_deg: f64,
    /// Seat of the beam about each axis, degrees, one sigma.
    pub seating_sigma_deg: f64,
    /// Centre of rotation in the body, metres.
    pub pivot_body_m: [f64; 3],
    /// Its uncertainty, metres, one sigma.
    pub pivot_body_sigma_m: f64,
    /// Centre of rotation in the rail's cross-section (x, z), metres.
    pub pivot_rail_m: [f64; 2],
    /// Its uncertainty, metres, one sigma.
    pub pivot_rail_sigma_m: f64,
    /// How far the lateral axis lies before or behind the vertical one, metres, one sigma; 0: they meet.
    #[serde(default)]
    pub axes_gap_sigma_m: f64,
    /// Turns about the vertical at level pitch, degrees: first, last, step.
    pub heading_sweep_deg: [f64; 3],
    /// Turns about the lateral axis at zero heading, degrees: first, last, step.
    pub pitch_sweep_deg: [f64; 3],
    /// Rest at each position, seconds.
    pub rest_s: f64,
}

/// `[[profiler]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfilerSection {
    /// Name for reports.
    pub name: String,
    /// Nominal lever arm in the body (right, forward, up), metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal mounting angles, degrees.
    pub mounting_deg: Angles,
    /// Noise of the lateral coordinate, metres, one sigma.
    pub lateral_sigma_m: f64,
    /// Noise of the other coordinate, metres, one sigma.
    pub vertical_sigma_m: f64,
    /// Uncertainty of the lever arm along the rail, metres, one sigma.
    pub along_sigma_m: f64,
    /// Width of the fan of rays, degrees, about the profiler's downward axis.
    pub field_deg: f64,
    /// Rays of a profile.
    pub rays: u32,
    /// Profiles at each position.
    #[serde(default = "one_profile")]
    pub profiles: u32,
    /// True minus nominal mounting, `log(R R_nominal^T)` about the body's axes, degrees.
    #[serde(default)]
    pub correction_deg: Turn,
    /// True minus nominal lever arm, metres.
    #[serde(default)]
    pub lever_arm_correction_m: [f64; 3],
}

fn one_profile() -> u32 {
    1
}

/// A small rotation about the body's axes, degrees, right-handed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// About x.
    pub pitch: f64,
    /// About y.
    pub roll: f64,
    /// About z.
    pub yaw: f64,
}

/// `[disturbance]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Disturbance {
    /// Part of the rays that hit dust.
    pub dust_fraction: f64,
    /// Dust lies up to so far before the rail, metres.
    pub dust_depth_m: f64,
    /// Part of the profiles in which something hides a run of rays.
    pub occlusion_fraction: f64,
    /// Part of the rays that it hides.
    pub occlusion_width: f64,
}

impl RailScenario {
    /// Parses a scenario; what only a calibration needs (`[reference]`, `[joint]`) must have been taken out.
    ///
    /// # Errors
    /// Those of the TOML reader.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        let mut table: toml::Table = toml::from_str(text)?;
        table.remove("reference");
        table.remove("joint");
        table.try_into()
    }

    /// Turns of the table in order, degrees: (about the vertical, about the lateral axis).
    #[must_use]
    pub fn positions_deg(&self) -> Vec<(f64, f64)> {
        let heading = steps(self.table.heading_sweep_deg)
            .into_iter()
            .map(|h| (h, 0.0));
        let pitch = steps(self.table.pitch_sweep_deg)
            .into_iter()
            .map(|p| (0.0, p));
        heading.chain(pitch).collect()
    }

    /// What is impossible, in words; empty when nothing is.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let ranges = self.stand_ranges().into_iter().chain(self.sweep_ranges());
        let ranges = ranges.chain(self.profiler_ranges());
        let mut faults = faults(&self.sources);
        faults.extend(ranges.filter_map(|range| range.fault()));
        if self.profiler.is_empty() {
            faults.push("profiler: found none, expected at least one [[profiler]]".to_owned());
        }
        if self.procedure != "rail" {
            let found = &self.procedure;
            faults.push(format!("procedure: found \"{found}\", expected \"rail\""));
        }
        if faults.is_empty() {
            faults.extend(self.counts().into_iter().filter_map(|r| r.fault()));
        }
        faults
    }

    /// How much would be simulated.
    fn counts(&self) -> Vec<Range> {
        let t = &self.table;
        let sweeps = [t.heading_sweep_deg, t.pitch_sweep_deg];
        let positions: f64 = sweeps
            .map(|[from, to, step]| (to - from) / step + 1.0)
            .iter()
            .sum();
        let rays = |p: &ProfilerSection| f64::from(p.rays) * f64::from(p.profiles);
        let points = positions * self.profiler.iter().map(rays).sum::<f64>();
        let records = positions * t.rest_s * self.attitude.rate_hz;
        let (p, s) = ("table.heading_sweep_deg", "profiler");
        vec![
            range(
                &format!("{p} (positions of the table)"),
                positions.round(),
                1.0,
                1e5,
            ),
            range(
                &format!("{s} (their number)"),
                self.profiler.len() as f64,
                1.0,
                100.0,
            ),
            range(
                &format!("{s} (points of all profiles)"),
                points.round(),
                1.0,
                2e7,
            ),
            range(
                "attitude.rate_hz (attitude records)",
                records.round(),
                0.0,
                2e7,
            ),
        ]
    }

    fn stand_ranges(&self) -> Vec<Range> {
        let (a, r, t) = (&self.attitude, &self.rail, &self.table);
        let mut all = vec![
            range(
                "attitude.roll_pitch_sigma_deg",
                a.roll_pitch_sigma_deg,
                LEAST,
                10.0,
            ),
            range(
                "attitude.heading_sigma_deg",
                a.heading_sigma_deg,
                LEAST,
                10.0,
            ),
            range("attitude.rate_hz", a.rate_hz, 0.01, 1e4),
            range("rail.profile_sigma_m", r.profile_sigma_m, 0.0, 0.01),
            range("table.angle_sigma_deg", t.angle_sigma_deg, LEAST, 10.0),
            range("table.level_sigma_deg", t.level_sigma_deg, LEAST, 10.0),
            range("table.zero_sigma_deg", t.zero_sigma_deg, LEAST, 10.0),
            range("table.seating_sigma_deg", t.seating_sigma_deg, LEAST, 10.0),
            range("table.pivot_body_sigma_m", t.pivot_body_sigma_m, LEAST, 1.0),
            range("table.pivot_rail_sigma_m", t.pivot_rail_sigma_m, LEAST, 1.0),
            range("table.axes_gap_sigma_m", t.axes_gap_sigma_m, 0.0, 1.0),
            range("table.rest_s", t.rest_s, 1e-3, 1e5),
        ];
        let sigmas = r.orientation_sigma_deg.iter();
        all.extend(sigmas.map(|s| range("rail.orientation_sigma_deg", *s, LEAST, 10.0)));
        let places = t.pivot_body_m.iter().chain(&t.pivot_rail_m);
        all.extend(places.map(|p| range("table.pivot", *p, -10.0, 10.0)));
        let o = &r.orientation_deg;
        let angles = [o.roll, o.pitch, o.heading];
        all.extend(angles.map(|v| range("rail.orientation_deg", v, -360.0, 360.0)));
        all
    }

    fn sweep_ranges(&self) -> Vec<Range> {
        let (t, d) = (&self.table, &self.disturbance);
        let mut all = vec![
            range("disturbance.dust_fraction", d.dust_fraction, 0.0, 1.0),
            range("disturbance.dust_depth_m", d.dust_depth_m, 0.0, 1.0),
            range(
                "disturbance.occlusion_fraction",
                d.occlusion_fraction,
                0.0,
                1.0,
            ),
            range("disturbance.occlusion_width", d.occlusion_width, 0.0, 1.0),
        ];
        let sweeps = [
            ("table.heading_sweep_deg", t.heading_sweep_deg),
            ("table.pitch_sweep_deg", t.pitch_sweep_deg),
        ];
        for (key, [from, to, step]) in sweeps {
            all.push(range(key, from, -45.0, 45.0));
            all.push(range(key, to, from, 45.0));
            all.push(range(key, step, 1e-3, 90.0));
        }
        all
    }

    fn profiler_ranges(&self) -> Vec<Range> {
        let one = |(k, p): (usize, &ProfilerSection)| {
            let key = |name: &str| format!("profiler {} ({}): {name}", k + 1, p.name);
            let (m, c) = (&p.mounting_deg, &p.correction_deg);
            let angles = [m.roll, m.pitch, m.heading, c.pitch, c.roll, c.yaw];
            let places = p.lever_arm_m.into_iter().chain(p.lever_arm_correction_m);
            let mut all = vec![
                range(&key("lateral_sigma_m"), p.lateral_sigma_m, LEAST, 0.1),
                range(&key("vertical_sigma_m"), p.vertical_sigma_m, LEAST, 0.1),
                range(&key("along_sigma_m"), p.along_sigma_m, LEAST, 1.0),
                range(&key("field_deg"), p.field_deg, 0.1, 170.0),
                range(&key("rays"), f64::from(p.rays), 2.0, 1e5),
                range(&key("profiles"), f64::from(p.profiles), 1.0, 1e5),
            ];
            all.extend(angles.map(|a| range(&key("angle"), a, -360.0, 360.0)));
            all.extend(places.map(|m| range(&key("lever arm"), m, -10.0, 10.0)));
            all
        };
        self.profiler.iter().enumerate().flat_map(one).collect()
    }
}

/// Smallest standard deviation, in any unit.
const LEAST: f64 = 1e-12;

/// A value and where it must lie.
struct Range {
    key: String,
    value: f64,
    low: f64,
    high: f64,
}

fn range(key: &str, value: f64, low: f64, high: f64) -> Range {
    let key = key.to_owned();
    Range {
        key,
        value,
        low,
        high,
    }
}

impl Range {
    fn fault(&self) -> Option<String> {
        let (value, low, high) = (self.value, self.low, self.high);
        let inside = value >= low && value <= high;
        (!inside).then(|| format!("{}: found {value}, expected {low} to {high}", self.key))
    }
}

/// First, first + step, ... up to last.
fn steps([from, to, step]: [f64; 3]) -> Vec<f64> {
    let count = ((to - from) / step + 1e-9).floor().max(0.0) as usize;
    (0..=count).map(|k| from + k as f64 * step).collect()
}
