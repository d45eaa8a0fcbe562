//! Soundings: every ping's beams cast from the true pose at its epoch, then recorded with the multibeam's errors.

use super::fan::{Candidate, Fan, SensorPose, Slack};
use super::motion::Motion;
use super::reality::Reality;
use super::refraction::{self, Path};
use super::scenario::{Disturbance, Recorded, Scenario};
use super::scene::{Hit, Ray, Scene, Surface};
use super::sources::Source;
use super::spoil::{Spoiler, Taken};
use super::switches::Draws;
use crate::observe::{NO_FACE, SonarNoise, SoundingRange, Soundings};

/// Echoes nearer than this are not recorded, metres.
pub(super) const BLANKING_M: f64 = 0.3;

/// What the multibeam records, and the face that each sounding struck.
pub(super) fn sound(
    scenario: &Scenario,
    reality: &Reality,
    motion: &Motion,
    scene: &Scene,
    seed: u64,
) -> (Soundings, Vec<u16>) {
    let mut sonar = Sonar::new(scenario, reality, scene, seed);
    let mut ping = 0;
    for leg in motion.legs() {
        for k in 0_u32.. {
            let epoch_s = leg.begin_s + f64::from(k) / scenario.multibeam.ping_rate_hz;
            if epoch_s >= leg.end_s - 1e-9 {
                break;
            }
            let body = motion.pose(leg, epoch_s);
            sonar.ping(ping, epoch_s, &SensorPose::new(&body, &reality.sonar));
            ping += 1;
        }
    }
    sonar.finish()
}

struct Sonar<'a> {
    scenario: &'a Scenario,
    reality: &'a Reality,
    scene: &'a Scene,
    fan: Fan,
    slack: Slack,
    speed_m_s: f64,
    candidates: Vec<Candidate>,
    range: Draws,
    across: Draws,
    along: Draws,
    jitter: Draws,
    spoiler: Spoiler,
    out: Soundings,
    measured_m: Vec<f64>,
    struck: Vec<u16>,
}

impl<'a> Sonar<'a> {
    fn new(scenario: &'a Scenario, reality: &'a Reality, scene: &'a Scene, seed: u64) -> Self {
        let m = &scenario.multibeam;
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let quarter = std::f64::consts::FRAC_PI_2;
        let bend = reality.water.as_ref().map_or(0.0, |w| {
            refraction::largest_bend_m(w, m.max_range_m, scenario.deepest_m())
        });
        let d = &scenario.disturbance;
        Self {
            fan: Fan::new(
                m.from_deg.to_radians() - quarter,
                m.to_deg.to_radians() - quarter,
                m.beams,
            ),
            slack: Slack {
                moved_m: bend,
                ..Slack::default()
            },
            speed_m_s: known_speed(scenario),
            candidates: vec![],
            range: draws(Source::SonarRange),
            across: draws(Source::SonarAngle),
            along: draws(Source::SonarAlongAngle),
            jitter: draws(Source::LatencyJitter),
            spoiler: Spoiler::new(scenario, d.sonar_clutter_fraction, gross(d), seed, 0),
            out: empty(scenario),
            measured_m: vec![],
            struck: vec![],
            scenario,
            reality,
            scene,
        }
    }

    fn ping(&mut self, ping: u32, epoch_s: f64, pose: &SensorPose) {
        for draws in [
            &mut self.range,
            &mut self.across,
            &mut self.along,
            &mut self.jitter,
        ] {
            draws.seek(u64::from(ping));
        }
        self.spoiler.seek(u64::from(ping));
        let jitter_s = self.jitter.normal(self.scenario.truth.latency_jitter_s);
        let stamp_s = epoch_s + self.reality.latency_s + jitter_s;
        let mut candidates = std::mem::take(&mut self.candidates);
        self.fan
            .candidates(self.scene, pose, epoch_s, &self.slack, &mut candidates);
        for beam in 0..self.fan.len() {
            self.beam(ping, beam, epoch_s, stamp_s, pose, &candidates);
        }
        self.candidates = candidates;
    }

    fn beam(
        &mut self,
        ping: u32,
        beam: usize,
        epoch_s: f64,
        stamp_s: f64,
        pose: &SensorPose,
        candidates: &[Candidate],
    ) {
        let m = &self.scenario.multibeam;
        let (noise_m, across, along) = (
            self.range.normal(m.range_sigma_m),
            self.across.normal(m.angle_sigma_deg.to_radians()),
            self.along.normal(m.along_angle_sigma_deg.to_radians()),
        );
        let across_rad = self.fan.angle_rad(beam) + std::f64::consts::FRAC_PI_2;
        let ray = pose.ray(self.fan.direction(beam));
        let echo = self.echo(&ray, epoch_s, beam, candidates);
        let hit = echo.map(|(range_m, cosine, _)| (range_m, cosine));
        let Some(Taken { range_m, own }) = self.spoiler.spoil(hit, m.max_range_m) else {
            return;
        };
        if range_m < BLANKING_M || range_m > m.max_range_m {
            return;
        }
        let surface = echo.filter(|_| own).map(|(.., surface)| surface);
        self.struck.push(surface.map_or(NO_FACE, Surface::face));
        self.measured_m.push(range_m + noise_m);
        self.out.time_s.push(stamp_s);
        self.out.ping.push(ping);
        self.out.beam.push(beam as u32);
        self.out
            .across_rad
            .push(across_rad + across * self.growth(across_rad));
        self.out.along_rad.push(along);
    }

    /// Measured range (metres, before noise) of the echo of a beam, the cosine at which it struck, and what.
    fn echo(
        &self,
        ray: &Ray,
        epoch_s: f64,
        beam: usize,
        candidates: &[Candidate],
    ) -> Option<(f64, f64, Surface)> {
        let level_m = self.scenario.target.water_level_m;
        let among = candidates
            .iter()
            .filter(|c| c.first <= beam && beam <= c.last)
            .map(|c| c.surface);
        if let Some(water) = &self.reality.water {
            let limit_m = self.scenario.multibeam.max_range_m;
            let cast = |ray: &Ray| self.scene.nearest(ray, epoch_s, among.clone());
            let Path {
                time_s,
                cosine,
                surface,
            } = refraction::trace(water, level_m, ray, limit_m, cast)?;
            return Some((time_s * self.speed_m_s, cosine, surface));
        }
        let Hit {
            range_m,
            cosine,
            surface,
        } = self.scene.nearest(ray, epoch_s, among)?;
        let under_water = ray.origin_m.z + range_m * ray.direction.z < level_m;
        under_water.then(|| (range_m / (1.0 + self.reality.range_scale), cosine, surface))
    }

    /// Factor of the angle noise at an across-track angle.
    fn growth(&self, across_rad: f64) -> f64 {
        let m = &self.scenario.multibeam;
        let edge = m.from_deg.abs().max(m.to_deg.abs()).to_radians();
        1.0 + (m.outer_beam_factor - 1.0) * (across_rad / edge).powi(2)
    }

    fn finish(mut self) -> (Soundings, Vec<u16>) {
        let speed = self.speed_m_s;
        self.out.range = match self.scenario.multibeam.records {
            Recorded::Range => SoundingRange::Metres(self.measured_m),
            Recorded::TravelTime => SoundingRange::TwoWayTravelTime(
                self.measured_m.iter().map(|r| 2.0 * r / speed).collect(),
            ),
        };
        (self.out, self.struck)
    }
}

fn gross(d: &Disturbance) -> (f64, f64) {
    (d.gross_fraction, d.gross_range_m)
}

/// The speed by which metres and seconds are exchanged: the one known, or the profile's first.
fn known_speed(scenario: &Scenario) -> f64 {
    let water = scenario.sound_speed.as_ref();
    let first = water.and_then(|w| w.speed_m_s.or(w.profile.first().map(|s| s[1])));
    first.unwrap_or(1500.0)
}

fn empty(scenario: &Scenario) -> Soundings {
    let m = &scenario.multibeam;
    Soundings {
        time_s: vec![],
        ping: vec![],
        beam: vec![],
        across_rad: vec![],
        along_rad: vec![],
        range: SoundingRange::Metres(vec![]),
        noise: SonarNoise {
            range_m: m.range_sigma_m,
            across_rad: m.angle_sigma_deg.to_radians(),
            along_rad: m.along_angle_sigma_deg.to_radians(),
        },
        file: None,
    }
}
