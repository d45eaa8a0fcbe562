//! Soundings of a transmit and a receive array in the pool: sent at one pose, heard at another, seen as a beam of the mounting sought.

use nalgebra::{Matrix3, Vector3};

use super::scene::Scene;
use crate::geometry::rotation::skew;
use crate::georef::{ArrayAim, Beam};
use crate::math;
use crate::observe::{Mounting, PoseSample, SonarNoise, SoundingArrays};

/// A beam of two arrays under a mounting that stands for both.
struct Aimed {
    aim: ArrayAim,
    /// From half way between the arrays to the end of the ray, target frame, metres.
    chord_m: Vector3<f64>,
    /// From the mounting's lever arm to the end of the ray, in the body at transmission, metres.
    reach_m: Vector3<f64>,
}

impl Aimed {
    /// Of sounding `k`, sent at `pose`; `None` where the trajectory does not cover its reception, no direction has its two angles, or the
    /// ray does not end.
    fn new(
        scene: &Scene,
        arrays: &SoundingArrays,
        k: usize,
        pose: &PoseSample,
        mounting: &Mounting,
    ) -> Option<Self> {
        let soundings = &scene.campaign.soundings;
        let [across_rad, along_rad, two_way_s] = soundings.measured(k);
        let one_way_s = 0.5 * two_way_s;
        let heard_s = scene.trajectory.time_of(pose) + 2.0 * one_way_s;
        let heard = scene.trajectory.pose_at(heard_s).ok()?;
        let head_speed_m_s = f64::from(arrays.head_speed_m_s[k]);
        let aim = ArrayAim::new(
            &arrays.mountings.moved(&arrays.nominal, mounting),
            (along_rad, across_rad),
            (one_way_s, head_speed_m_s),
            [
                (pose.position_m, pose.rotation),
                (heard.position_m, heard.rotation),
            ],
        )?;
        let launch = (aim.direction, head_speed_m_s);
        let water = scene.water.as_ref()?;
        let way_s = one_way_s * aim.stretch();
        let chord_m = water.chord(aim.transducer_m.z, launch, way_s).ok()?;
        let end_m = aim.transducer_m + chord_m - pose.position_m;
        Some(Self {
            reach_m: pose.rotation.tr_mul(&end_m) - mounting.lever_arm_m,
            chord_m,
            aim,
        })
    }
}

impl Scene<'_> {
    /// Beam of sounding `k` of two arrays in the frame of the mounting sought, which stands for both: it ends where the sound struck.
    pub(super) fn array_beam(
        &self,
        arrays: &SoundingArrays,
        k: usize,
        pose: &PoseSample,
        mounting: &Mounting,
    ) -> Option<Beam> {
        let aimed = Aimed::new(self, arrays, k, pose, mounting)?;
        let u_m = mounting.rotation.tr_mul(&aimed.reach_m);
        Some(Beam::from_vector(&u_m))
    }

    /// What the derivative of sounding `k`'s point by a turn of the mounting in the body (columns: pitch, roll, yaw; metres per radian,
    /// target frame) has beyond that of a beam that turns as one piece about the lever arm: each array turns about its own place, and at
    /// its own moment. `None` where one head sends and hears.
    pub(super) fn turn_of_arrays(
        &self,
        k: usize,
        pose: &PoseSample,
        mounting: &Mounting,
    ) -> Option<Matrix3<f64>> {
        let arrays = self.campaign.soundings.arrays.as_ref()?;
        let aimed = Aimed::new(self, arrays, k, pose, mounting)?;
        let own = aimed.aim.by_turn()? * aimed.chord_m.norm();
        Some(own + pose.rotation * skew(&aimed.reach_m))
    }

    /// Noise of sounding `k`. The angle against the receive array stands on a cone: where the beam is tilted by `c`, the same error of the
    /// angle `a` turns it further, `d(across) / da = cos a / (cos^2 c - sin^2 a)^(1/2)`.
    #[must_use]
    pub fn sounding_noise(&self, k: usize) -> SonarNoise {
        let soundings = &self.campaign.soundings;
        if soundings.arrays.is_none() {
            return soundings.noise;
        }
        let [across_rad, along_rad, _] = soundings.measured(k);
        let (sine, cosine) = math::sin_cos(across_rad);
        let flat = math::cos(along_rad);
        let left = (flat * flat - sine * sine).max(1e-4 * cosine * cosine);
        let growth = cosine / left.max(1e-12).sqrt();
        SonarNoise {
            across_rad: soundings.noise.across_rad * growth,
            ..soundings.noise
        }
    }
}
