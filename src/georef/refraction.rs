//! Refraction: from a launch direction and a travel time to the straight beam that ends at the same point.

use nalgebra::Vector3;

use super::beam::Beam;
use super::equation::georeference;
use super::rays::{Layers, RayError};
use crate::math;
use crate::observe::{Mounting, PoseSample, SoundSpeed};

/// The water: its level and its sound speed, checked and ready for many rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    level_m: f64,
    speed: Speed,
}

#[derive(Clone, Debug, PartialEq)]
enum Speed {
    Constant(f64),
    Layers(Layers),
}

/// What the sonar says of one sounding: the direction of the beam at the transducer and the two-way travel time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Launch {
    /// Across-track angle at the transducer, radians, positive to starboard.
    pub across_rad: f64,
    /// Along-track angle at the transducer, radians, elevation out of the across plane, positive forward.
    pub along_rad: f64,
    /// Two-way travel time, seconds.
    pub two_way_s: f64,
}

impl Water {
    /// Water with its surface at `level_m` (height in the target frame, metres).
    ///
    /// # Errors
    /// [`RayError::Profile`] when the speed or the profile cannot be used.
    pub fn new(speed: &SoundSpeed, level_m: f64) -> Result<Self, RayError> {
        let speed = match speed {
            SoundSpeed::Profile(profile) => Speed::Layers(Layers::new(profile)?.open()),
            SoundSpeed::Constant(c) if *c > 0.0 && c.is_finite() => Speed::Constant(*c),
            SoundSpeed::Constant(c) => {
                return Err(RayError::Profile {
                    row: 0,
                    found: format!("speed {c} m/s"),
                    expected: "a positive speed",
                });
            }
        };
        Ok(Self { level_m, speed })
    }

    /// The straight beam in the sensor frame that ends where the bent ray ends.
    ///
    /// A constant speed keeps the angles, `range = c t / 2`. With a profile the launch direction is turned into the target frame
    /// by `pose` (body into target) and `mounting`, the ray is traced in its vertical plane, and the end is turned back:
    /// [`georeference`] with the returned beam gives the ray's end. The vertical is the target's Z axis, which leans by
    /// 1.6e-5 rad at 100 m from the origin. The beam depends on `mounting`: after a correction of the mounting by 1 degree the
    /// refraction must be computed anew.
    ///
    /// # Errors
    /// [`RayError`] when the transducer is not in the water (profiles only), or the time is not positive.
    pub fn refract(
        &self,
        launch: &Launch,
        pose: &PoseSample,
        mounting: &Mounting,
    ) -> Result<Beam, RayError> {
        match &self.speed {
            Speed::Constant(c) => straight(launch, *c),
            Speed::Layers(layers) => self.bent(layers, launch, pose, mounting),
        }
    }

    /// The straight line from a transducer to where the ray ends that leaves it in `direction` (unit vector, z up) for `one_way_s`
    /// seconds, metres; `height_m` is the transducer's in the target frame, `head_speed_m_s` what the beam former used, 0 for the water's.
    ///
    /// # Errors
    /// As [`Layers::chord`].
    pub fn chord(
        &self,
        height_m: f64,
        (direction, head_speed_m_s): (Vector3<f64>, f64),
        one_way_s: f64,
    ) -> Result<Vector3<f64>, RayError> {
        let depth_m = self.level_m - height_m;
        let or = |own_m_s: f64| {
            if head_speed_m_s > 0.0 {
                head_speed_m_s
            } else {
                own_m_s
            }
        };
        match &self.speed {
            Speed::Constant(c) => refracted(&direction, *c / or(*c), *c * one_way_s),
            Speed::Layers(layers) => {
                let head = or(layers.speed_m_s(depth_m.max(0.0)));
                layers.chord(depth_m, (direction, head), one_way_s)
            }
        }
    }

    fn bent(
        &self,
        layers: &Layers,
        launch: &Launch,
        pose: &PoseSample,
        mounting: &Mounting,
    ) -> Result<Beam, RayError> {
        let target_from_sensor = pose.rotation * mounting.rotation;
        let direction = target_from_sensor * straight_direction(launch);
        let depth_m = self.level_m - georeference(pose, mounting, &Vector3::zeros()).z;
        let sine = math::hypot(direction.x, direction.y);
        let end = layers.trace(depth_m, (sine, -direction.z), 0.5 * launch.two_way_s)?;
        let stretch = if sine > 0.0 {
            end.horizontal_m / sine
        } else {
            0.0
        };
        let chord = Vector3::new(direction.x * stretch, direction.y * stretch, -end.descent_m);
        Ok(Beam::from_vector(&target_from_sensor.tr_mul(&chord)))
    }
}

/// A straight ray of a length whose sine from the vertical is that of `direction` times `by`, in the same vertical plane.
fn refracted(direction: &Vector3<f64>, by: f64, length_m: f64) -> Result<Vector3<f64>, RayError> {
    let sine = math::hypot(direction.x, direction.y) * by;
    if !(sine < 1.0 && length_m.is_finite()) {
        return Err(RayError::Direction);
    }
    let cosine = (1.0 - sine * sine).sqrt().copysign(direction.z);
    Ok(Vector3::new(direction.x * by, direction.y * by, cosine) * length_m)
}

fn straight_direction(launch: &Launch) -> Vector3<f64> {
    Beam {
        range_m: 1.0,
        across_rad: launch.across_rad,
        along_rad: launch.along_rad,
    }
    .vector_m()
}

fn straight(launch: &Launch, speed_m_s: f64) -> Result<Beam, RayError> {
    let range_m = 0.5 * speed_m_s * launch.two_way_s;
    if !(range_m > 0.0 && range_m.is_finite()) {
        let two_way_s = launch.two_way_s;
        return Err(RayError::TravelTime { two_way_s });
    }
    Ok(Beam {
        range_m,
        across_rad: launch.across_rad,
        along_rad: launch.along_rad,
    })
}
