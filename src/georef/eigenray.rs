//! The ray between two given points: at which direction it leaves, how long it takes, and how both change with the points.
//!
//! Found by shooting: the ray is traced, the miss turned into a better aim, and again. In water the bend is a small part of the
//! way, so each shot is a hundred times better than the one before.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::rays::{Layers, RayError};
use crate::math;
use crate::observe::SoundSpeed;

/// Shots at the most; five are usual.
const MOST_SHOTS: usize = 60;
/// Steps of the central differences of the end point: angle (rad) and, relative to the way, depth.
const STEP: f64 = 1e-4;

/// Water without an upper or lower end as far as its speed goes: constant, or layers with a constant gradient.
#[derive(Clone, Debug, PartialEq)]
pub enum Medium {
    /// The same speed everywhere, metres per second: rays are straight.
    Straight(f64),
    /// A profile: rays are arcs.
    Layers(Layers),
}

/// The ray from one point to another, in a frame east, north, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenray {
    /// Unit vector in which the ray leaves the first point.
    pub direction: Vector3<f64>,
    /// One-way travel time, seconds.
    pub time_s: f64,
    /// Derivatives of the direction by the position of the second point (1 / m).
    pub direction_by_end: Matrix3<f64>,
    /// Derivatives of the time by the position of the second point (s / m).
    pub time_by_end: Vector3<f64>,
    /// Derivatives of the direction by the position of the first point (1 / m).
    pub direction_by_start: Matrix3<f64>,
    /// Derivatives of the time by the position of the first point (s / m).
    pub time_by_start: Vector3<f64>,
}

impl Medium {
    /// From a speed or a profile.
    ///
    /// # Errors
    /// [`RayError::Profile`] when it cannot be used.
    pub fn new(speed: &SoundSpeed) -> Result<Self, RayError> {
        match speed {
            SoundSpeed::Profile(profile) => Layers::new(profile).map(Self::Layers),
            SoundSpeed::Constant(c) if *c > 0.0 && c.is_finite() => Ok(Self::Straight(*c)),
            SoundSpeed::Constant(c) => Err(RayError::Profile {
                row: 0,
                found: format!("speed {c} m/s"),
                expected: "a positive speed",
            }),
        }
    }

    /// Speed at a depth, metres per second.
    #[must_use]
    pub fn speed_m_s(&self, depth_m: f64) -> f64 {
        match self {
            Self::Straight(c) => *c,
            Self::Layers(layers) => layers.speed_m_s(depth_m),
        }
    }

    /// Where a ray that leaves `depth_m` (metres below the water level) in a unit `direction` is after `time_s`, seen from its
    /// beginning, metres.
    ///
    /// # Errors
    /// [`RayError`] when the ray leaves the water or the time is not positive.
    pub fn end(
        &self,
        depth_m: f64,
        direction: &Vector3<f64>,
        time_s: f64,
    ) -> Result<Vector3<f64>, RayError> {
        let layers = match self {
            Self::Straight(c) => return Ok(direction * (c * time_s)),
            Self::Layers(layers) => layers,
        };
        let sine = math::hypot(direction.x, direction.y);
        let end = layers.trace(depth_m, (sine, -direction.z), time_s)?;
        let stretch = if sine > 0.0 {
            end.horizontal_m / sine
        } else {
            0.0
        };
        Ok(Vector3::new(
            direction.x * stretch,
            direction.y * stretch,
            -end.descent_m,
        ))
    }

    /// The ray from a point at `depth_m` to the point `offset_m` away from it (east, north, up).
    ///
    /// # Errors
    /// [`RayError`] when no ray gets there without touching the surface, or the two points are one.
    pub fn eigenray(&self, depth_m: f64, offset_m: &Vector3<f64>) -> Result<Eigenray, RayError> {
        if !(offset_m.norm() > 0.0) {
            return Err(RayError::Direction);
        }
        match self {
            Self::Straight(c) => Ok(straight(offset_m, *c)),
            Self::Layers(layers) => bent(layers, depth_m, offset_m),
        }
    }
}

fn straight(offset_m: &Vector3<f64>, speed_m_s: f64) -> Eigenray {
    let range_m = offset_m.norm();
    let direction = offset_m / range_m;
    let by_end = (Matrix3::identity() - direction * direction.transpose()) / range_m;
    Eigenray {
        direction,
        time_s: range_m / speed_m_s,
        direction_by_end: by_end,
        time_by_end: direction / speed_m_s,
        direction_by_start: -by_end,
        time_by_start: -direction / speed_m_s,
    }
}

/// Horizontal distance and descent (metres) at the angle from the downward vertical (signed) after a time.
fn shot(
    layers: &Layers,
    depth_m: f64,
    (angle_rad, time_s): (f64, f64),
) -> Result<Vector2<f64>, RayError> {
    let (sine, cosine) = math::sin_cos(angle_rad);
    let end = layers.trace(depth_m, (sine.abs(), cosine), time_s)?;
    Ok(Vector2::new(
        end.horizontal_m * sine.signum(),
        end.descent_m,
    ))
}

/// Angle and time of the ray to a horizontal distance and descent.
fn aim(layers: &Layers, depth_m: f64, goal: &Vector2<f64>) -> Result<(f64, f64), RayError> {
    let range_m = goal.norm();
    let middle_m_s = 0.5 * (layers.speed_m_s(depth_m) + layers.speed_m_s(depth_m + goal.y));
    let mut aimed = (math::atan2(goal.x, goal.y), range_m / middle_m_s);
    let mut before_m = f64::INFINITY;
    for _ in 0..MOST_SHOTS {
        let miss = goal - shot(layers, depth_m, aimed)?;
        // as near as rounding lets it come
        if miss.norm() <= 1e-13 * range_m || (miss.norm() >= before_m && miss.norm() < 1e-9) {
            return Ok(aimed);
        }
        before_m = miss.norm();
        let along = goal / range_m;
        let across = Vector2::new(along.y, -along.x);
        aimed.0 += miss.dot(&across) / range_m;
        aimed.1 *= 1.0 + miss.dot(&along) / range_m;
    }
    Err(RayError::Caught)
}

fn bent(layers: &Layers, depth_m: f64, offset_m: &Vector3<f64>) -> Result<Eigenray, RayError> {
    let horizontal_m = math::hypot(offset_m.x, offset_m.y);
    let goal = Vector2::new(horizontal_m, -offset_m.z);
    let (angle, time_s) = aim(layers, depth_m, &goal)?;
    let difference =
        |plus: Vector2<f64>, minus: Vector2<f64>, step: f64| (plus - minus) / (2.0 * step);
    let by_angle = difference(
        shot(layers, depth_m, (angle + STEP, time_s))?,
        shot(layers, depth_m, (angle - STEP, time_s))?,
        STEP,
    );
    let dt = STEP * time_s;
    let by_time = difference(
        shot(layers, depth_m, (angle, time_s + dt))?,
        shot(layers, depth_m, (angle, time_s - dt))?,
        dt,
    );
    let dz = (STEP * goal.norm()).min(0.5 * depth_m);
    let by_depth = if dz > 0.0 {
        difference(
            shot(layers, depth_m + dz, (angle, time_s))?,
            shot(layers, depth_m - dz, (angle, time_s))?,
            dz,
        )
    } else {
        Vector2::zeros()
    };
    let jacobian = Matrix2::from_columns(&[by_angle, by_time]);
    let inverse = jacobian.try_inverse().ok_or(RayError::Direction)?;
    Ok(in_space(
        offset_m,
        (angle, time_s),
        &inverse,
        &(-inverse * by_depth),
    ))
}

/// The ray in its vertical plane as a ray in space. `inverse`: angle and time by horizontal distance and descent; `by_depth`: by
/// the depth of both points.
fn in_space(
    offset_m: &Vector3<f64>,
    (angle, time_s): (f64, f64),
    inverse: &Matrix2<f64>,
    by_depth: &Vector2<f64>,
) -> Eigenray {
    let horizontal_m = math::hypot(offset_m.x, offset_m.y);
    let (outward, sideways) = if horizontal_m > 0.0 {
        let outward = Vector3::new(offset_m.x, offset_m.y, 0.0) / horizontal_m;
        (outward, Vector3::new(-outward.y, outward.x, 0.0))
    } else {
        (Vector3::x(), Vector3::y())
    };
    let (sine, cosine) = math::sin_cos(angle);
    let direction = outward * sine - Vector3::z() * cosine;
    let by_angle = outward * cosine + Vector3::z() * sine;
    // straight above the point the quotient is the derivative
    let turn = if horizontal_m > 1e-6 {
        sine / horizontal_m
    } else {
        inverse[(0, 0)]
    };
    let angle_by_end = outward * inverse[(0, 0)] - Vector3::z() * inverse[(0, 1)];
    let time_by_end = outward * inverse[(1, 0)] - Vector3::z() * inverse[(1, 1)];
    let direction_by_end =
        by_angle * angle_by_end.transpose() + sideways * sideways.transpose() * turn;
    Eigenray {
        direction,
        time_s,
        direction_by_end,
        time_by_end,
        direction_by_start: -direction_by_end - by_angle * Vector3::z().transpose() * by_depth.x,
        time_by_start: -time_by_end - Vector3::z() * by_depth.y,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::SoundSpeedProfile;

    fn linear(gradient_per_s: f64) -> Medium {
        let speed = |depth: f64| 1480.0 + gradient_per_s * depth;
        let depth_m = vec![0.0, 40.0];
        let profile = SoundSpeedProfile {
            speed_m_s: depth_m.iter().map(|d| speed(*d)).collect(),
            depth_m,
        };
        Medium::new(&SoundSpeed::Profile(profile)).expect("a profile")
    }

    /// Closed form for a linear profile (Poincare half-plane): `t = arcosh(1 + g^2 d^2 / (2 c1 c2)) / |g|`, and the circle through
    /// both points about the depth of zero speed gives the launch angle.
    #[test]
    fn a_linear_profile_gives_the_closed_form() {
        for gradient in [0.05, -0.05, 3.0, -4.0] {
            let medium = linear(gradient);
            let offset = Vector3::new(6.0, -8.0, -7.0);
            let ray = medium.eigenray(2.0, &offset).expect("a ray");
            let (c1, c2) = (1480.0 + gradient * 2.0, 1480.0 + gradient * 9.0);
            let squared = gradient * gradient * offset.norm_squared() / (2.0 * c1 * c2);
            let time = math::ln_1p(squared + (squared * (squared + 2.0)).sqrt()) / gradient.abs();
            assert!((ray.time_s / time - 1.0).abs() < 1e-12, "{gradient}");
            // centre of the circle at depth -1480/g, horizontally at x0
            let (z1, z2, h) = (2.0 + 1480.0 / gradient, 9.0 + 1480.0 / gradient, 10.0);
            let x0 = (h * h + (z2 - z1) * (z2 + z1)) / (2.0 * h);
            let tangent = (z1, x0); // at right angles to the radius (-x0, z1)
            let sign = if tangent.0 > 0.0 { 1.0 } else { -1.0 };
            let norm = sign * math::hypot(tangent.0, tangent.1);
            let level = math::hypot(ray.direction.x, ray.direction.y);
            assert!(
                (level - tangent.0 / norm).abs() < 1e-10,
                "{gradient}: {level}"
            );
            assert!(
                (ray.direction.z + tangent.1 / norm).abs() < 1e-10,
                "{gradient}"
            );
        }
    }

    #[test]
    fn a_constant_profile_gives_the_straight_ray() {
        let offset = Vector3::new(3.0, 4.0, -6.5);
        let bent = linear(0.0).eigenray(1.5, &offset).expect("a ray");
        let straight = Medium::Straight(1480.0)
            .eigenray(1.5, &offset)
            .expect("a ray");
        assert!((bent.direction - straight.direction).norm() < 1e-13);
        assert!((bent.time_s - straight.time_s).abs() < 1e-16);
        assert!((bent.direction_by_end - straight.direction_by_end).norm() < 1e-8);
        assert!((bent.time_by_start - straight.time_by_start).norm() < 1e-11);
    }

    #[test]
    fn the_ray_ends_where_it_was_aimed_and_its_derivatives_are_those_of_differences() {
        let medium = linear(-0.8);
        for offset in [Vector3::new(2.0, -3.0, -6.0), Vector3::new(0.0, 0.0, -6.0)] {
            let at = |start: &Vector3<f64>, end: &Vector3<f64>| {
                medium
                    .eigenray(2.0 - start.z, &(offset + end - start))
                    .expect("a ray")
            };
            let zero = Vector3::zeros();
            let ray = at(&zero, &zero);
            let end = medium.end(2.0, &ray.direction, ray.time_s).expect("an end");
            assert!((end - offset).norm() < 1e-11);
            for axis in 0..3 {
                let step = Vector3::ith(axis, 1e-4);
                let (plus, minus) = (at(&zero, &step), at(&zero, &-step));
                let by_end = (plus.direction - minus.direction) / 2e-4;
                assert!((by_end - ray.direction_by_end.column(axis)).norm() < 1e-7);
                let time = (plus.time_s - minus.time_s) / 2e-4;
                assert!((time - ray.time_by_end[axis]).abs() < 1e-10);
                let (plus, minus) = (at(&step, &zero), at(&-step, &zero));
                let by_start = (plus.direction - minus.direction) / 2e-4;
                assert!((by_start - ray.direction_by_start.column(axis)).norm() < 1e-7);
                let time = (plus.time_s - minus.time_s) / 2e-4;
                assert!((time - ray.time_by_start[axis]).abs() < 1e-10);
            }
        }
    }
}
