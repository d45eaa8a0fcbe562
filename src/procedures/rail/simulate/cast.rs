//! Rays against a rail: exact hits of lines and arcs. The estimator's distances are not used here, so that the two check each other.

use nalgebra::{Vector2, Vector3};

use crate::geometry::curve::Element;

/// A rail whose elements lie off their design along their normals.
pub(super) struct Body {
    pieces: Vec<Piece>,
}

enum Piece {
    Straight {
        from: Vector2<f64>,
        to: Vector2<f64>,
    },
    Round {
        centre: Vector2<f64>,
        radius: f64,
        /// Direction to the middle of the arc and the cosine of half its opening.
        middle: Vector2<f64>,
        cosine: f64,
    },
}

impl Body {
    /// The rail with each element moved outwards by its offset, metres.
    pub(super) fn new(elements: &[Element], offsets_m: &[f64]) -> Self {
        let pieces = elements.iter().zip(offsets_m);
        Self {
            pieces: pieces.map(|(e, o)| piece(e, *o)).collect(),
        }
    }

    /// Distance along a ray in the rail frame to the nearest hit, metres. The rail is endless along y, so that only x and z count.
    pub(super) fn hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let (o, d) = (
            Vector2::new(origin.x, origin.z),
            Vector2::new(direction.x, direction.z),
        );
        let hits = self.pieces.iter().filter_map(|piece| piece.hit(&o, &d));
        hits.min_by(f64::total_cmp)
    }
}

fn piece(element: &Element, offset: f64) -> Piece {
    match *element {
        Element::Line { from, to } => {
            let d = (to - from).normalize();
            let shift = Vector2::new(-d.y, d.x) * offset;
            Piece::Straight {
                from: from + shift,
                to: to + shift,
            }
        }
        Element::Arc {
            centre,
            radius_m,
            convex,
            from,
            to,
        } => {
            let middle = (0.5 * (from + to) - centre).normalize();
            let sign = if convex { 1.0 } else { -1.0 };
            Piece::Round {
                centre,
                radius: radius_m + sign * offset,
                cosine: middle.dot(&(from - centre)) / radius_m,
                middle,
            }
        }
    }
}

impl Piece {
    fn hit(&self, o: &Vector2<f64>, d: &Vector2<f64>) -> Option<f64> {
        match self {
            Self::Straight { from, to } => {
                let along = to - from;
                let determinant = d.x * along.y - d.y * along.x;
                let w = from - o;
                let t = (w.x * along.y - w.y * along.x) / determinant;
                let part = (w.x * d.y - w.y * d.x) / determinant;
                (t > 0.0 && (0.0..=1.0).contains(&part)).then_some(t)
            }
            Self::Round {
                centre,
                radius,
                middle,
                cosine,
            } => {
                let w = o - centre;
                let (a, b, c) = (
                    d.norm_squared(),
                    w.dot(d),
                    w.norm_squared() - radius * radius,
                );
                let root = (b * b - a * c).sqrt();
                let on = |t: &f64| *t > 0.0 && middle.dot(&((w + *t * d) / *radius)) >= *cosine;
                [(-b - root) / a, (-b + root) / a].into_iter().find(on)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::profile::RailProfile;
    use super::*;
    use crate::math;

    /// Every hit lies on the standard profile, and no other part of the rail lies before it.
    #[test]
    fn hits_lie_on_the_profile() {
        let rail = RailProfile::built_in("chn60").expect("a rail");
        let body = Body::new(&rail.elements, &vec![0.0; rail.elements.len()]);
        let origin = Vector3::new(0.25, 0.4, 0.12);
        let mut seen = vec![0; rail.elements.len()];
        for k in 0..2000 {
            let angle = -1.5 + f64::from(k) * 8e-4;
            let direction = Vector3::new(math::sin(angle), 0.1, -math::cos(angle)).normalize();
            let Some(range) = body.hit(&origin, &direction) else {
                continue;
            };
            let place = |t: f64| {
                let p = origin + t * direction;
                rail.nearest(&Vector2::new(p.x, p.z)).expect("near")
            };
            let found = place(range);
            assert!(found.distance_m < 1e-12, "{angle}: {}", found.distance_m);
            seen[found.element] += 1;
            assert!((1..50).all(|i| place(range * f64::from(i) / 51.0).distance_m > 1e-6));
        }
        assert!(seen.iter().filter(|n| **n > 0).count() >= 8, "{seen:?}");
    }
}
