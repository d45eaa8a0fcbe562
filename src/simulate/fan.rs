//! A fan of rays in a sensor's x-z plane, and which surfaces each of its rays may hit.
//!
//! A ray's angle counts from the sensor's x axis towards z. A multibeam's across-track angle is this angle plus 90 deg.

use nalgebra::{Matrix3, Vector3};

use super::motion::BodyPose;
use super::scene::{Ray, Scene, Surface};
use crate::math;
use crate::observe::Mounting;

/// Evenly spaced rays.
#[derive(Clone, Debug)]
pub struct Fan {
    first_rad: f64,
    step_rad: f64,
    directions: Vec<Vector3<f64>>,
}

/// Where a sensor is and how it looks, in the target frame.
#[derive(Clone, Copy, Debug)]
pub struct SensorPose {
    /// Sensor origin, metres.
    pub origin_m: Vector3<f64>,
    /// Sensor into target frame.
    pub rotation: Matrix3<f64>,
}

impl SensorPose {
    /// The pose of a sensor on a body.
    #[must_use]
    pub fn new(body: &BodyPose, mounting: &Mounting) -> Self {
        Self {
            origin_m: body.position_m + body.rotation * mounting.lever_arm_m,
            rotation: body.rotation * mounting.rotation,
        }
    }

    /// The ray along a direction of the sensor frame.
    #[must_use]
    pub fn ray(&self, direction: &Vector3<f64>) -> Ray {
        Ray {
            origin_m: self.origin_m,
            direction: self.rotation * direction,
        }
    }
}

/// How far a sensor can have moved and turned from the pose at which its candidates were found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slack {
    /// Displacement, metres.
    pub moved_m: f64,
    /// Turn, radians.
    pub turned_rad: f64,
    /// Time, seconds.
    pub time_s: f64,
}

/// A surface and the rays (first, last) that may hit it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The surface.
    pub surface: Surface,
    /// First ray.
    pub first: usize,
    /// Last ray.
    pub last: usize,
}

impl Fan {
    /// `count` rays from the first to the last angle, radians.
    #[must_use]
    pub fn new(first_rad: f64, last_rad: f64, count: u32) -> Self {
        let step_rad = (last_rad - first_rad) / f64::from(count.max(2) - 1);
        let direction = |k: u32| {
            let (sin, cos) = math::sin_cos(first_rad + step_rad * f64::from(k));
            Vector3::new(cos, 0.0, sin)
        };
        Self {
            first_rad,
            step_rad,
            directions: (0..count).map(direction).collect(),
        }
    }

    /// Number of rays.
    #[must_use]
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Whether there is no ray.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// Angle of ray `k`, radians.
    #[must_use]
    pub fn angle_rad(&self, k: usize) -> f64 {
        self.first_rad + self.step_rad * k as f64
    }

    /// Direction of ray `k` in the sensor frame.
    #[must_use]
    pub fn direction(&self, k: usize) -> &Vector3<f64> {
        &self.directions[k]
    }

    /// The facets and bodies that rays of this fan can hit while the sensor is within `slack` of `pose`.
    pub fn candidates(
        &self,
        scene: &Scene,
        pose: &SensorPose,
        time_s: f64,
        slack: &Slack,
        found: &mut Vec<Candidate>,
    ) {
        found.clear();
        for (k, facet) in scene.facets.iter().enumerate() {
            let ball = Ball::new(pose, &facet.centre_m, facet.radius_m, slack);
            if ball.is_beside() {
                continue;
            }
            let height = facet.normal.dot(&(pose.origin_m - facet.centre_m)).abs();
            let interval = self.interval(pose, facet.corners_m.iter(), &ball, height);
            found.extend(interval.map(|(first, last)| Candidate {
                surface: Surface::Face(k),
                first,
                last,
            }));
        }
        for (k, solid) in scene.solids.iter().enumerate() {
            let moved = Slack {
                moved_m: slack.moved_m + solid.speed_m_s() * slack.time_s,
                ..*slack
            };
            let ball = Ball::new(pose, &solid.centre_at(time_s), solid.radius_m(), &moved);
            if !ball.is_beside() {
                found.push(Candidate {
                    surface: Surface::Body(k),
                    first: 0,
                    last: self.len() - 1,
                });
            }
        }
    }

    /// The rays that pass the part of a polygon near the fan's plane.
    fn interval<'a>(
        &self,
        pose: &SensorPose,
        corners: impl Iterator<Item = &'a Vector3<f64>>,
        ball: &Ball,
        height_m: f64,
    ) -> Option<(usize, usize)> {
        let middle = self.angle_rad(0) + 0.5 * self.step_rad * (self.len() - 1) as f64;
        let (sin, cos) = math::sin_cos(middle);
        let sensor: Vec<Vector3<f64>> = corners
            .map(|c| pose.rotation.tr_mul(&(c - pose.origin_m)))
            .collect();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        near_plane(&sensor, ball.margin_m, |p| {
            let angle = math::atan2(cos * p.z - sin * p.x, cos * p.x + sin * p.z);
            low = low.min(angle);
            high = high.max(angle);
        });
        if low > high {
            return None;
        }
        let nearest = height_m.max(ball.distance_m - ball.radius_m);
        if nearest <= 2.0 * ball.margin_m || high - low > std::f64::consts::PI {
            return Some((0, self.len() - 1));
        }
        let widen = math::asin(ball.margin_m / nearest) + 1e-9;
        self.rays_between(middle + low - widen, middle + high + widen)
    }

    fn rays_between(&self, low_rad: f64, high_rad: f64) -> Option<(usize, usize)> {
        let place = |angle: f64| (angle - self.first_rad) / self.step_rad;
        let (a, b) = (place(low_rad), place(high_rad));
        let last = (self.len() - 1) as f64;
        let (first, end) = (a.min(b).ceil().max(0.0), a.max(b).floor().min(last));
        (first <= end).then_some((first as usize, end as usize))
    }
}

/// A sphere seen from a sensor, with the distance by which things can be off at its range.
struct Ball {
    radius_m: f64,
    distance_m: f64,
    aside_m: f64,
    margin_m: f64,
}

impl Ball {
    fn new(pose: &SensorPose, centre_m: &Vector3<f64>, radius_m: f64, slack: &Slack) -> Self {
        let offset = centre_m - pose.origin_m;
        let distance_m = offset.norm();
        let reach_m = distance_m + radius_m;
        Self {
            radius_m,
            distance_m,
            aside_m: pose.rotation.column(1).dot(&offset).abs(),
            margin_m: 1e-6 + 1.01 * (slack.moved_m + slack.turned_rad * reach_m),
        }
    }

    fn is_beside(&self) -> bool {
        self.aside_m > self.radius_m + self.margin_m
    }
}

/// Visits the corners of a polygon's part with |y| <= margin.
fn near_plane(polygon: &[Vector3<f64>], margin_m: f64, mut visit: impl FnMut(Vector3<f64>)) {
    let mut a = polygon[polygon.len() - 1];
    for &b in polygon {
        if b.y.abs() <= margin_m {
            visit(b);
        }
        for side in [-margin_m, margin_m] {
            if (a.y < side) != (b.y < side) {
                visit(a + (b - a) * ((side - a.y) / (b.y - a.y)));
            }
        }
        a = b;
    }
}
