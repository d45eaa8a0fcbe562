//! One face: a plane polygon with a role.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// What a face is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Role {
    /// Inclined faces of the column at -Y (patent P1).
    P1,
    /// The wall (patent P2).
    P2,
    /// Inclined faces of the column at +Y (patent P3).
    P3,
    /// Tops and undersides.
    #[serde(rename = "horizontal")]
    Horizontal,
    /// Any other plane: used by the joint path where the scanner sees it.
    #[serde(rename = "other")]
    Other,
    /// Known to be there, hides what is behind it, never used as a tie.
    #[serde(rename = "obstacle")]
    Obstacle,
}

/// A plane polygon, convex or not, with an in-plane basis.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Vertices, target frame, metres, counter-clockwise seen from the sensors.
    pub vertices_m: Vec<Vector3<f64>>,
    /// Outward unit normal.
    pub normal: Vector3<f64>,
    /// First in-plane unit vector.
    pub along: Vector3<f64>,
    /// Second in-plane unit vector, `normal x along`.
    pub across: Vector3<f64>,
    flat: Vec<Vector2<f64>>,
    /// Inward unit normal and offset of each edge, where the outline is convex: the distance inside an edge is `normal . p + offset`.
    edges: Vec<(Vector2<f64>, f64)>,
}

impl Outline {
    /// From at least three vertices that span a plane; `None` otherwise.
    #[must_use]
    pub fn new(vertices_m: Vec<Vector3<f64>>) -> Option<Self> {
        let origin = *vertices_m.first()?;
        let mut area = Vector3::zeros();
        for pair in vertices_m.windows(2) {
            area += (pair[0] - origin).cross(&(pair[1] - origin));
        }
        let normal = area.try_normalize(1e-9)?;
        let along = (vertices_m[1] - origin).try_normalize(1e-9)?;
        let along = (along - normal * along.dot(&normal)).try_normalize(1e-9)?;
        let across = normal.cross(&along);
        let flat = vertices_m
            .iter()
            .map(|v| Vector2::new((v - origin).dot(&along), (v - origin).dot(&across)))
            .collect::<Vec<_>>();
        Some(Self {
            edges: convex_edges(&flat),
            vertices_m,
            normal,
            along,
            across,
            flat,
        })
    }

    /// Largest distance of a vertex from the mean plane, metres.
    #[must_use]
    pub fn warp_m(&self) -> f64 {
        let origin = self.vertices_m[0];
        self.vertices_m
            .iter()
            .map(|v| (v - origin).dot(&self.normal).abs())
            .fold(0.0, f64::max)
    }

    /// Signed distance (metres) in the plane from the point's foot to the outline: positive inside.
    #[must_use]
    pub fn inside_m(&self, point: &Vector3<f64>) -> f64 {
        self.inside_within_m(point, f64::INFINITY)
    }

    /// The same as long as the point is not outside by more than `reach_m`; beyond that any value below `-reach_m`, found faster.
    #[must_use]
    pub fn inside_within_m(&self, point: &Vector3<f64>, reach_m: f64) -> f64 {
        let offset = point - self.vertices_m[0];
        let p = Vector2::new(offset.dot(&self.along), offset.dot(&self.across));
        self.inside_flat_m(&p, reach_m)
    }

    fn inside_flat_m(&self, p: &Vector2<f64>, reach_m: f64) -> f64 {
        if !self.edges.is_empty() {
            let within = |(normal, offset): &(Vector2<f64>, f64)| normal.dot(p) + offset;
            let least = self.edges.iter().map(within).fold(f64::INFINITY, f64::min);
            if least >= 0.0 || least < -reach_m {
                return least;
            }
        }
        self.by_edges_m(p)
    }

    /// The same for any outline and any place.
    fn by_edges_m(&self, p: &Vector2<f64>) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut inside = false;
        for (k, a) in self.flat.iter().enumerate() {
            let b = &self.flat[(k + 1) % self.flat.len()];
            let (edge, to) = (b - a, p - a);
            let t = (to.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            nearest = nearest.min((to - edge * t).norm_squared());
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        if inside {
            nearest.sqrt()
        } else {
            -nearest.sqrt()
        }
    }

    /// Area, square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let n = self.flat.len();
        0.5 * (0..n)
            .map(|k| self.flat[k].perp(&self.flat[(k + 1) % n]))
            .sum::<f64>()
    }

    /// A grid of points on the face with about this spacing (metres), at least one.
    #[must_use]
    pub fn samples_m(&self, spacing_m: f64) -> Vec<Vector3<f64>> {
        let low = self
            .flat
            .iter()
            .copied()
            .reduce(|a, b| a.inf(&b))
            .unwrap_or_default();
        let high = self
            .flat
            .iter()
            .copied()
            .reduce(|a, b| a.sup(&b))
            .unwrap_or_default();
        let count = |span: f64| (span / spacing_m).ceil().max(1.0) as usize;
        let (nx, ny) = (count(high.x - low.x), count(high.y - low.y));
        let at = |q: Vector2<f64>| self.vertices_m[0] + self.along * q.x + self.across * q.y;
        let cell = Vector2::new((high.x - low.x) / nx as f64, (high.y - low.y) / ny as f64);
        let mut points: Vec<_> = (0..nx * ny)
            .map(|k| {
                low + Vector2::new((k % nx) as f64 + 0.5, (k / nx) as f64 + 0.5)
                    .component_mul(&cell)
            })
            .filter(|q| self.inside_flat_m(q, 0.0) >= 0.0)
            .map(at)
            .collect();
        if points.is_empty() {
            points
                .push(self.vertices_m.iter().sum::<Vector3<f64>>() / self.vertices_m.len() as f64);
        }
        points
    }
}

/// Inward normals and offsets of the edges of a convex polygon; nothing for any other.
fn convex_edges(flat: &[Vector2<f64>]) -> Vec<(Vector2<f64>, f64)> {
    let n = flat.len();
    let edge = |k: usize| {
        let (a, b) = (flat[k % n], flat[(k + 1) % n]);
        let along = (b - a).try_normalize(1e-9)?;
        let inward = Vector2::new(-along.y, along.x);
        Some((inward, -inward.dot(&a)))
    };
    let edges: Option<Vec<_>> = (0..n).map(edge).collect();
    let convex = |edges: &Vec<(Vector2<f64>, f64)>| {
        edges
            .iter()
            .all(|(normal, offset)| flat.iter().all(|p| normal.dot(p) + offset > -1e-9))
    };
    edges.filter(convex).unwrap_or_default()
}

/// One face of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Name for reports, unique in the target.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// Its polygon at design position.
    pub outline: Outline,
    /// Index of its plane in [`super::Target::groups`].
    pub group: usize,
    /// +1 when the face looks along its group's normal, -1 when against it.
    pub facing: f64,
    /// Index of its offset in [`super::Target::offsets`].
    pub offset: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ell() -> Outline {
        let corners = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        Outline::new(
            corners
                .iter()
                .map(|c| Vector3::new(c[0], c[1], 5.0))
                .collect(),
        )
        .expect("plane")
    }

    #[test]
    fn a_reentrant_outline_knows_its_inside() {
        let outline = ell();
        assert!((outline.inside_m(&Vector3::new(0.5, 2.0, 9.0)) - 0.5).abs() < 1e-12);
        assert!((outline.inside_m(&Vector3::new(1.5, 2.0, 5.0)) + 0.5).abs() < 1e-12);
        assert!((outline.area_m2() - 4.0).abs() < 1e-12);
        assert!((outline.normal - Vector3::z()).norm() < 1e-12);
        assert!(
            outline
                .samples_m(0.1)
                .iter()
                .all(|p| outline.inside_m(p) >= 0.0)
        );
    }

    #[test]
    fn a_convex_outline_is_as_far_as_its_edges() {
        let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
        let outline = Outline::new(vec![corner(0.0, 0.0), corner(3.0, 0.0), corner(0.0, 3.0)])
            .expect("a triangle");
        assert_eq!(outline.edges.len(), 3);
        for k in 0..400 {
            let p = Vector2::new(f64::from(k % 20) * 0.3 - 1.5, f64::from(k / 20) * 0.3 - 1.5);
            let exact = outline.by_edges_m(&p);
            let found = outline.inside_m(&corner(p.x, p.y));
            assert!((found - exact).abs() < 1e-12, "{p}: {found}, {exact}");
            let near = outline.inside_within_m(&corner(p.x, p.y), 0.4);
            assert!((near - exact).abs() < 1e-12 || (near < -0.4 && exact < -0.4));
        }
        assert!(ell().edges.is_empty());
    }

    #[test]
    fn a_line_is_no_face() {
        assert!(Outline::new(vec![Vector3::zeros(), Vector3::x(), Vector3::x() * 2.0]).is_none());
    }
}
