//! A transmit and a receive array: cast from where the sound is sent, heard where the boat is by then. Rays are straight.

use nalgebra::Vector3;

use super::fan::SensorPose;
use super::motion::BodyPose;
use super::reality::Reality;
use super::scenario::Scenario;
use super::scene::{Scene, Surface};
use super::sectors::Sectors;
use crate::math;
use crate::observe::ArrayMountings;

/// The arrays as they truly are.
pub(super) struct TwoArrays {
    mountings: ArrayMountings,
    sectors: Sectors,
    speed_m_s: f64,
}

/// A beam as it is sent.
pub(super) struct Shot {
    /// When, seconds.
    pub(super) sent_s: f64,
    /// Tilt of the transmitted cone, radians.
    pub(super) tilt_rad: f64,
    /// Where on that cone the beam looks, radians from the transmit array's downward axis to starboard.
    pub(super) across_rad: f64,
}

/// What is heard of it.
pub(super) struct Heard {
    /// Angle against the receive array, radians.
    pub(super) angle_rad: f64,
    /// Half the way of the sound, metres.
    pub(super) half_way_m: f64,
    /// Where it struck, metres.
    pub(super) point_m: Vector3<f64>,
    /// Cosine at which it struck.
    pub(super) cosine: f64,
    /// What it struck.
    pub(super) surface: Surface,
}

impl TwoArrays {
    /// Where the scenario has two arrays.
    pub(super) fn new(scenario: &Scenario, reality: &Reality) -> Option<Self> {
        let m = &scenario.multibeam;
        let water = scenario.sound_speed.as_ref()?;
        Some(Self {
            mountings: m
                .array_mountings()?
                .moved(&reality.nominal_sonar, &reality.sonar),
            sectors: m.arrays?.sectors(),
            speed_m_s: water.speed_m_s? * (1.0 + reality.range_scale),
        })
    }

    /// Tilt (radians) and delay (seconds) of the sector that a beam of so many lies in.
    pub(super) fn sector_of(&self, beam: usize, beams: usize) -> (f64, f64) {
        let part = beam as f64 / (beams - 1).max(1) as f64;
        self.sectors.sector(self.sectors.of_beam(part))
    }

    /// `None` where the sound meets nothing; `body` is the true pose at a time.
    pub(super) fn heard(
        &self,
        scene: &Scene,
        shot: &Shot,
        body: impl Fn(f64) -> BodyPose,
    ) -> Option<Heard> {
        let sender = SensorPose::new(&body(shot.sent_s), &self.mountings.transmitter);
        let (sine, cosine) = math::sin_cos(shot.tilt_rad);
        let (across, down) = math::sin_cos(shot.across_rad);
        let ray = sender.ray(&Vector3::new(cosine * across, sine, -cosine * down));
        let hit = scene.nearest_of_all(&ray, shot.sent_s)?;
        let point_m = ray.origin_m + ray.direction * hit.range_m;
        let (mut length_m, mut arrival) = (2.0 * hit.range_m, Vector3::zeros());
        // the boat makes a part in a thousand of the sound's way: each round gains three digits
        for _ in 0..4 {
            let time_s = shot.sent_s + length_m / self.speed_m_s;
            let listener = SensorPose::new(&body(time_s), &self.mountings.receiver);
            let back = point_m - listener.origin_m;
            length_m = hit.range_m + back.norm();
            arrival = listener.rotation.tr_mul(&back.normalize());
        }
        Some(Heard {
            angle_rad: math::asin(arrival.x),
            half_way_m: 0.5 * length_m,
            point_m,
            cosine: hit.cosine,
            surface: hit.surface,
        })
    }
}
