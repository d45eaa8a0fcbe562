//! Soundings: every ping's beams cast from the true pose at its epoch, then recorded with the multibeam's errors.

use super::arrays::{Shot, TwoArrays};
use super::fan::{Candidate, Fan, SensorPose, Slack};
use super::motion::{BodyPose, Motion};
use super::reality::Reality;
use super::refraction::{self, Path};
use super::scenario::{Disturbance, Recorded, Scenario};
use super::scene::{Hit, Ray, Scene, Surface};
use super::sources::Source;
use super::spoil::{Spoiler, Taken};
use super::switches::Draws;
use crate::observe::{NO_FACE, SonarNoise, SoundingArrays, SoundingRange, Soundings};

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
    let arrays = TwoArrays::new(scenario, reality);
    let mut ping = 0;
    for leg in motion.legs() {
        for k in 0_u32.. {
            let epoch_s = leg.begin_s + f64::from(k) / scenario.multibeam.ping_rate_hz;
            if epoch_s >= leg.end_s - 1e-9 {
                break;
            }
            match &arrays {
                None => {
                    let body = motion.pose(leg, epoch_s);
                    sonar.ping(ping, epoch_s, &SensorPose::new(&body, &reality.sonar));
                }
                Some(arrays) => {
                    sonar.ping_of_arrays(ping, epoch_s, arrays, |t| motion.pose(leg, t));
                }
            }
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

    /// Goes to the beginning of a ping in every random stream.
    fn seek(&mut self, ping: u32) {
        for draws in [
            &mut self.range,
            &mut self.across,
            &mut self.along,
            &mut self.jitter,
        ] {
            draws.seek(u64::from(ping));
        }
        self.spoiler.seek(u64::from(ping));
    }

    /// Stamp minus epoch of a ping, seconds.
    fn late_s(&mut self) -> f64 {
        self.reality.latency_s + self.jitter.normal(self.scenario.truth.latency_jitter_s)
    }

    fn ping(&mut self, ping: u32, epoch_s: f64, pose: &SensorPose) {
        self.seek(ping);
        let stamp_s = epoch_s + self.late_s();
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
        let (noise_m, across, along) = self.noise();
        let m = &self.scenario.multibeam;
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

    /// Errors of one beam: range (metres), across and along angle (radians).
    fn noise(&mut self) -> (f64, f64, f64) {
        let m = &self.scenario.multibeam;
        (
            self.range.normal(m.range_sigma_m),
            self.across.normal(m.angle_sigma_deg.to_radians()),
            self.along.normal(m.along_angle_sigma_deg.to_radians()),
        )
    }

    /// One ping of two arrays, whose stamps are of milliseconds as recorders write them; each sounding has the time of its transmission.
    fn ping_of_arrays(
        &mut self,
        ping: u32,
        epoch_s: f64,
        arrays: &TwoArrays,
        body: impl Fn(f64) -> BodyPose,
    ) {
        self.seek(ping);
        let late_s = self.late_s();
        let stamp_s = (1e3 * (epoch_s + late_s)).round() / 1e3;
        for beam in 0..self.fan.len() {
            let (noise_m, across, along) = self.noise();
            let across_rad = self.fan.angle_rad(beam) + std::f64::consts::FRAC_PI_2;
            let (tilt_rad, delay_s) = arrays.sector_of(beam, self.fan.len());
            let shot = Shot {
                sent_s: stamp_s - late_s + delay_s,
                // what is recorded is the tilt as it was steered
                tilt_rad: tilt_rad - along,
                across_rad,
            };
            let heard = arrays.heard(self.scene, &shot, &body).filter(|heard| {
                let level_m = self.scenario.target.water_level_m;
                heard.point_m.z < level_m
            });
            let scale = 1.0 + self.reality.range_scale;
            let hit = heard.as_ref().map(|h| (h.half_way_m / scale, h.cosine));
            let most_m = self.scenario.multibeam.max_range_m;
            let Some(Taken { range_m, own }) = self.spoiler.spoil(hit, most_m) else {
                continue;
            };
            let Some(angle_rad) = heard.as_ref().map(|heard| heard.angle_rad) else {
                continue;
            };
            if range_m < BLANKING_M || range_m > most_m {
                continue;
            }
            let surface = heard.filter(|_| own).map(|heard| heard.surface);
            self.struck.push(surface.map_or(NO_FACE, Surface::face));
            self.measured_m.push(range_m + noise_m);
            self.out.time_s.push(stamp_s + delay_s);
            self.out.ping.push(ping);
            self.out.beam.push(beam as u32);
            let across = across * self.growth(across_rad);
            self.out.across_rad.push(angle_rad + across);
            self.out.along_rad.push(tilt_rad);
        }
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
        let nominal = &self.reality.nominal_sonar;
        let mountings = self.scenario.multibeam.array_mountings();
        self.out.arrays = mountings.map(|mountings| SoundingArrays {
            mountings,
            nominal: *nominal,
            head_speed_m_s: vec![speed as f32; self.out.time_s.len()],
        });
        let records = match mountings {
            Some(_) => Recorded::TravelTime,
            None => self.scenario.multibeam.records,
        };
        self.out.range = match records {
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
        arrays: None,
        file: None,
    }
}
