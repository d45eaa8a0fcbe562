//! What rays can hit: the faces as they truly stand, endless planes, and boxes at rest or moving.

use nalgebra::{Vector2, Vector3};

use super::scenario::{BodyModel, PlaneModel, Scenario};
use super::sources::Source;
use crate::observe::NO_FACE;
use crate::target::{Outline, Target};

/// A ray from a sensor: origin and unit direction in the target frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, metres.
    pub origin_m: Vector3<f64>,
    /// Unit direction.
    pub direction: Vector3<f64>,
}

/// What a ray hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// A face of the target, by its index in the design.
    Face(usize),
    /// The floor.
    Floor,
    /// An endless plane other than the floor.
    Plane(usize),
    /// A solid body.
    Body(usize),
}

impl Surface {
    /// Index of the face, or [`NO_FACE`].
    pub(super) fn face(self) -> u16 {
        match self {
            Self::Face(k) => u16::try_from(k).unwrap_or(NO_FACE),
            _ => NO_FACE,
        }
    }
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, metres.
    pub range_m: f64,
    /// Cosine between ray and normal, in absolute value; 1 for bodies.
    pub cosine: f64,
    /// What was hit.
    pub surface: Surface,
}

/// Nearer than this nothing is hit, metres.
pub(super) const BLANKING_M: f64 = 1e-3;
/// Farther than this nothing is hit, metres.
const FARTHEST_M: f64 = 1e6;

/// A plane polygon.
#[derive(Clone, Debug)]
pub struct Facet {
    /// Corners, target frame, metres.
    pub corners_m: Vec<Vector3<f64>>,
    /// Unit normal.
    pub normal: Vector3<f64>,
    offset_m: f64,
    along: Vector3<f64>,
    across: Vector3<f64>,
    flat: Vec<Vector2<f64>>,
    /// Centre of a sphere that holds the polygon.
    pub centre_m: Vector3<f64>,
    /// Radius of that sphere, metres.
    pub radius_m: f64,
}

impl Facet {
    /// The polygon of an outline after a shift (metres).
    #[must_use]
    pub fn new(outline: &Outline, shift_m: &Vector3<f64>) -> Self {
        let corners_m: Vec<_> = outline.vertices_m.iter().map(|v| v + shift_m).collect();
        let (normal, along, across) = (outline.normal, outline.along, outline.across);
        let centre_m = corners_m.iter().sum::<Vector3<f64>>() / corners_m.len() as f64;
        let far = |r: f64, v: &Vector3<f64>| r.max((v - centre_m).norm());
        let flat = |v: &Vector3<f64>| {
            Vector2::new((v - centre_m).dot(&along), (v - centre_m).dot(&across))
        };
        Self {
            offset_m: corners_m[0].dot(&normal),
            flat: corners_m.iter().map(flat).collect(),
            radius_m: corners_m.iter().fold(0.0, far),
            corners_m,
            normal,
            along,
            across,
            centre_m,
        }
    }

    /// Distance and cosine where the ray crosses the polygon, if that is nearer than `limit_m`.
    #[must_use]
    pub fn cross(&self, ray: &Ray, limit_m: f64) -> Option<(f64, f64)> {
        let slope = self.normal.dot(&ray.direction);
        let range_m = (self.offset_m - self.normal.dot(&ray.origin_m)) / slope;
        if !(range_m > BLANKING_M && range_m < limit_m) {
            return None;
        }
        let p = ray.origin_m + ray.direction * range_m - self.centre_m;
        let foot = Vector2::new(p.dot(&self.along), p.dot(&self.across));
        self.holds(&foot).then_some((range_m, slope.abs()))
    }

    /// Whether a point of the plane is inside the polygon (crossings of a ray along the first in-plane axis).
    fn holds(&self, p: &Vector2<f64>) -> bool {
        let mut inside = false;
        let mut a = &self.flat[self.flat.len() - 1];
        for b in &self.flat {
            if (a.y > p.y) != (b.y > p.y)
                && (p.x - a.x) * (b.y - a.y).abs()
                    < (b.x - a.x) * (p.y - a.y) * (b.y - a.y).signum()
            {
                inside = !inside;
            }
            a = b;
        }
        inside
    }
}

/// A box along the target's axes.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    half_m: Vector3<f64>,
    centre_m: Vector3<f64>,
    velocity_m_s: Vector3<f64>,
    time_s: f64,
}

impl Solid {
    fn new(model: &BodyModel, start_s: f64) -> Self {
        Self {
            half_m: Vector3::from(model.size_m) * 0.5,
            centre_m: Vector3::from(model.centre_m),
            velocity_m_s: Vector3::from(model.velocity_m_s),
            time_s: start_s + model.time_s,
        }
    }

    /// Centre (metres) at a time (seconds).
    #[must_use]
    pub fn centre_at(&self, time_s: f64) -> Vector3<f64> {
        self.centre_m + self.velocity_m_s * (time_s - self.time_s)
    }

    /// Radius of the sphere that holds it, metres.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.half_m.norm()
    }

    /// Its speed, metres per second.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.velocity_m_s.norm()
    }

    /// Distance where the ray enters the box (slab by slab), if that is nearer than `limit_m`; the cosine is taken as 1.
    #[must_use]
    pub fn enter(&self, ray: &Ray, time_s: f64, limit_m: f64) -> Option<(f64, f64)> {
        let o = ray.origin_m - self.centre_at(time_s);
        let (mut first, mut last) = (BLANKING_M, f64::INFINITY);
        for axis in 0..3 {
            let inverse = 1.0 / ray.direction[axis];
            let a = (-self.half_m[axis] - o[axis]) * inverse;
            let b = (self.half_m[axis] - o[axis]) * inverse;
            first = first.max(a.min(b));
            last = last.min(a.max(b));
        }
        (first < last && first < limit_m).then_some((first, 1.0))
    }
}

/// An endless plane.
#[derive(Clone, Copy, Debug)]
pub struct Endless {
    normal: Vector3<f64>,
    offset_m: f64,
}

impl Endless {
    fn new(model: &PlaneModel) -> Self {
        let normal = Vector3::from(model.normal).normalize();
        Self {
            normal,
            offset_m: normal.dot(&Vector3::from(model.point_m)),
        }
    }

    fn cross(&self, ray: &Ray, limit_m: f64) -> Option<(f64, f64)> {
        let slope = self.normal.dot(&ray.direction);
        let range_m = (self.offset_m - self.normal.dot(&ray.origin_m)) / slope;
        (range_m > BLANKING_M && range_m < limit_m).then_some((range_m, slope.abs()))
    }
}

/// Everything that a ray can hit.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The target's faces, in the order of the design.
    pub facets: Vec<Facet>,
    /// The floor, where there is one.
    pub floor: Option<Endless>,
    /// Endless planes other than the floor.
    pub planes: Vec<Endless>,
    /// Bodies.
    pub solids: Vec<Solid>,
}

impl Scene {
    /// The scenario's scene; `offsets_m[k]` is the true minus the design value of `target.offsets[k]`.
    #[must_use]
    pub fn new(scenario: &Scenario, target: &Target, offsets_m: &[f64], start_s: f64) -> Self {
        let facet = |face: &crate::target::Face| {
            let shift = target.groups[face.group].normal * offsets_m[face.offset];
            Facet::new(&face.outline, &shift)
        };
        let floor = |z| Endless {
            normal: Vector3::z(),
            offset_m: z,
        };
        let bodies = scenario.sources.factor(Source::Bodies) > 0.0;
        let solid = |b| Solid::new(b, start_s);
        let solids = scenario.disturbance.body.iter().map(solid).collect();
        Self {
            facets: target.faces.iter().map(facet).collect(),
            floor: scenario.basin.floor_m.map(floor),
            planes: scenario.basin.wall.iter().map(Endless::new).collect(),
            solids: if bodies { solids } else { vec![] },
        }
    }

    /// The scene as light sees it: the water hides the floor.
    #[must_use]
    pub fn without_floor(&self) -> Self {
        Self {
            floor: None,
            ..self.clone()
        }
    }

    /// The nearest hit among some facets and bodies and every endless plane.
    #[must_use]
    pub fn nearest(
        &self,
        ray: &Ray,
        time_s: f64,
        among: impl Iterator<Item = Surface>,
    ) -> Option<Hit> {
        let floor = self.floor.iter().map(|_| Surface::Floor);
        let endless = floor.chain((0..self.planes.len()).map(Surface::Plane));
        let mut best: Option<Hit> = None;
        let mut limit_m = FARTHEST_M;
        for surface in endless.chain(among) {
            let crossing = match surface {
                Surface::Face(k) => self.facets[k].cross(ray, limit_m),
                Surface::Floor => self.floor.and_then(|f| f.cross(ray, limit_m)),
                Surface::Plane(k) => self.planes[k].cross(ray, limit_m),
                Surface::Body(k) => self.solids[k].enter(ray, time_s, limit_m),
            };
            if let Some((range_m, cosine)) = crossing {
                limit_m = range_m;
                best = Some(Hit {
                    range_m,
                    cosine,
                    surface,
                });
            }
        }
        best
    }

    /// The nearest hit among everything.
    #[must_use]
    pub fn nearest_of_all(&self, ray: &Ray, time_s: f64) -> Option<Hit> {
        let facets = (0..self.facets.len()).map(Surface::Face);
        let bodies = (0..self.solids.len()).map(Surface::Body);
        self.nearest(ray, time_s, facets.chain(bodies))
    }
}
