//! Laser returns: every shot cast from the true pose at its own moment, then recorded with the scanner's errors.

use super::fan::{Candidate, Fan, SensorPose, Slack};
use super::motion::{Leg, Motion};
use super::reality::Reality;
use super::scenario::Scenario;
use super::scene::{Hit, Scene, Surface};
use super::sources::Source;
use super::spoil::{Spoiler, Taken};
use super::switches::Draws;
use crate::math;
use crate::observe::{LaserCoordinates, LaserNoise, LaserScan, NO_FACE};

/// Rows of the spoiling streams that belong to the scanner begin here; the multibeam's are below.
const FIRST_ROW: u64 = 1 << 32;

/// What the scanner records, in its own frame, and the face that each return struck. `scene` must not hold the pool's floor: the light ends at the water.
pub(super) fn scan(
    scenario: &Scenario,
    reality: &Reality,
    motion: &Motion,
    scene: &Scene,
    seed: u64,
) -> (LaserScan, Vec<u16>) {
    let mut scanner = Scanner::new(scenario, reality, motion, scene, seed);
    let mut line = 0;
    for leg in motion.legs() {
        for k in 0_u32.. {
            let begin_s = leg.begin_s + f64::from(k) / scenario.lidar.line_rate_hz;
            if begin_s + scanner.shooting_s > leg.end_s {
                break;
            }
            scanner.line(line, begin_s, leg);
            line += 1;
        }
    }
    (scanner.out, scanner.struck)
}

struct Scanner<'a> {
    scenario: &'a Scenario,
    reality: &'a Reality,
    motion: &'a Motion,
    scene: &'a Scene,
    fan: Fan,
    shooting_s: f64,
    candidates: Vec<Candidate>,
    range: Draws,
    angle: Draws,
    spoiler: Spoiler,
    out: LaserScan,
    struck: Vec<u16>,
}

impl<'a> Scanner<'a> {
    fn new(
        scenario: &'a Scenario,
        reality: &'a Reality,
        motion: &'a Motion,
        scene: &'a Scene,
        seed: u64,
    ) -> Self {
        let lidar = &scenario.lidar;
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let clutter = scenario.disturbance.laser_clutter_fraction;
        Self {
            fan: Fan::new(
                lidar.from_deg.to_radians(),
                lidar.to_deg.to_radians(),
                lidar.points_per_line,
            ),
            shooting_s: lidar.duty / lidar.line_rate_hz,
            candidates: vec![],
            range: draws(Source::LaserRange),
            angle: draws(Source::LaserAngle),
            spoiler: Spoiler::new(scenario, clutter, (0.0, 0.0), seed, FIRST_ROW),
            out: empty(scenario),
            struck: vec![],
            scenario,
            reality,
            motion,
            scene,
        }
    }

    fn line(&mut self, line: u64, begin_s: f64, leg: &Leg) {
        let middle_s = begin_s + 0.5 * self.shooting_s;
        let slack = self.slack(leg);
        let mut candidates = std::mem::take(&mut self.candidates);
        let middle = self.pose(leg, middle_s);
        self.fan
            .candidates(self.scene, &middle, middle_s, &slack, &mut candidates);
        if !(candidates.is_empty() && self.scene.planes.is_empty()) {
            self.range.seek(line);
            self.angle.seek(line);
            self.spoiler.seek(line);
            for shot in 0..self.fan.len() {
                let part = shot as f64 / (self.fan.len() - 1) as f64;
                self.shot(leg, begin_s + part * self.shooting_s, shot, &candidates);
            }
        }
        self.candidates = candidates;
    }

    fn pose(&self, leg: &Leg, time_s: f64) -> SensorPose {
        SensorPose::new(&self.motion.pose(leg, time_s), &self.reality.scanner)
    }

    /// How far the scanner can move within half a line.
    fn slack(&self, leg: &Leg) -> Slack {
        let (speed_m_s, rate_rad_s) = self.motion.bounds(leg);
        let time_s = 0.5 * self.shooting_s;
        let arm_m = self.reality.scanner.lever_arm_m.norm();
        Slack {
            moved_m: (speed_m_s + rate_rad_s * arm_m) * time_s,
            turned_rad: rate_rad_s * time_s,
            time_s,
        }
    }

    fn shot(&mut self, leg: &Leg, time_s: f64, shot: usize, candidates: &[Candidate]) {
        let lidar = &self.scenario.lidar;
        let (range_noise, angle_noise) = (
            self.range.normal(lidar.range_sigma_m),
            self.angle.normal(lidar.angle_sigma_deg.to_radians()),
        );
        let echo = self.echo(leg, time_s, shot, candidates);
        // a shot into the open never returns: clutter only shows where something reflects
        let hit = echo.map(|(range_m, cosine, _)| (range_m, cosine));
        let taken = self.spoiler.spoil(hit, lidar.max_range_m);
        let (Some((.., surface)), Some(Taken { range_m, own })) = (echo, taken) else {
            return;
        };
        if range_m > lidar.max_range_m {
            return;
        }
        let (sin, cos) = math::sin_cos(self.fan.angle_rad(shot) + angle_noise);
        let range_m = range_m + range_noise;
        self.struck.push(if own { surface.face() } else { NO_FACE });
        self.out.time_s.push(time_s);
        self.out.x_m.push(range_m * cos);
        self.out.y_m.push(0.0);
        self.out.z_m.push(range_m * sin);
    }

    fn echo(
        &self,
        leg: &Leg,
        time_s: f64,
        shot: usize,
        candidates: &[Candidate],
    ) -> Option<(f64, f64, Surface)> {
        let mut among = candidates
            .iter()
            .filter(|c| c.first <= shot && shot <= c.last)
            .map(|c| c.surface)
            .peekable();
        if among.peek().is_none() && self.scene.planes.is_empty() {
            return None;
        }
        let ray = self.pose(leg, time_s).ray(self.fan.direction(shot));
        let Hit {
            range_m,
            cosine,
            surface,
        } = self.scene.nearest(&ray, time_s, among)?;
        let height_m = ray.origin_m.z + range_m * ray.direction.z;
        (height_m > self.scenario.target.water_level_m).then_some((range_m, cosine, surface))
    }
}

fn empty(scenario: &Scenario) -> LaserScan {
    LaserScan {
        time_s: vec![],
        x_m: vec![],
        y_m: vec![],
        z_m: vec![],
        coordinates: LaserCoordinates::Sensor,
        noise: LaserNoise {
            range_m: scenario.lidar.range_sigma_m,
            angle_rad: scenario.lidar.angle_sigma_deg.to_radians(),
            point_m: 0.0,
        },
    }
}
