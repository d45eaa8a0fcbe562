//! Plane curves of straight lines and circular arcs: distance, normal, nearest point.
//!
//! Coordinates are (x, z): x right, z up. A curve is travelled with its outside on the left, so a bulge turns right.

use crate::math;
use nalgebra::Vector2;

/// One piece of a curve, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element {
    /// A straight line.
    Line {
        /// Where it begins.
        from: Vector2<f64>,
        /// Where it ends.
        to: Vector2<f64>,
    },
    /// A circular arc shorter than a half circle.
    Arc {
        /// Centre.
        centre: Vector2<f64>,
        /// Radius, metres.
        radius_m: f64,
        /// Whether the curve bulges to its outside (the centre lies inside).
        convex: bool,
        /// Where it begins.
        from: Vector2<f64>,
        /// Where it ends.
        to: Vector2<f64>,
    },
}

/// Signed distance from a curve and the outward normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// Distance along the normal, metres, positive outside.
    pub distance_m: f64,
    /// Unit normal towards the outside.
    pub normal: Vector2<f64>,
}

/// The nearest element of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its index.
    pub element: usize,
    /// Distance without sign, metres.
    pub distance_m: f64,
    /// Whether the foot lies within the element and not at one of its ends.
    pub inside: bool,
}

fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

impl Element {
    /// The arc of this radius (metres; positive where it bulges outside, negative where it is hollow) between two points, the
    /// shorter way; `None` when the points are further apart than the diameter or the same.
    #[must_use]
    pub fn arc(from: Vector2<f64>, to: Vector2<f64>, signed_radius_m: f64) -> Option<Self> {
        let chord = to - from;
        let (length, radius_m) = (chord.norm(), signed_radius_m.abs());
        if !(length > 0.0 && length < 2.0 * radius_m) {
            return None;
        }
        let left = Vector2::new(-chord.y, chord.x) / length;
        let height = (radius_m * radius_m - 0.25 * length * length).sqrt();
        let convex = signed_radius_m > 0.0;
        let side = if convex { -height } else { height };
        let centre = 0.5 * (from + to) + side * left;
        Some(Self::Arc {
            centre,
            radius_m,
            convex,
            from,
            to,
        })
    }

    /// Where it begins.
    #[must_use]
    pub fn from(&self) -> Vector2<f64> {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from,
        }
    }

    /// Where it ends.
    #[must_use]
    pub fn to(&self) -> Vector2<f64> {
        match self {
            Self::Line { to, .. } | Self::Arc { to, .. } => *to,
        }
    }

    /// Length, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc {
                radius_m, from, to, ..
            } => 2.0 * radius_m * math::asin(((to - from).norm() / (2.0 * radius_m)).min(1.0)),
        }
    }

    /// Signed distance and normal of the whole line or circle that it is a part of.
    #[must_use]
    pub fn extended(&self, p: &Vector2<f64>) -> Offset {
        match self {
            Self::Line { from, to } => {
                let along = (to - from).normalize();
                let normal = Vector2::new(-along.y, along.x);
                let distance_m = normal.dot(&(p - from));
                Offset { distance_m, normal }
            }
            Self::Arc {
                centre,
                radius_m,
                convex,
                ..
            } => {
                let arm = p - centre;
                let sign = if *convex { 1.0 } else { -1.0 };
                let length = arm.norm();
                Offset {
                    distance_m: sign * (length - radius_m),
                    normal: arm * (sign / length.max(f64::MIN_POSITIVE)),
                }
            }
        }
    }

    /// Whether the foot of a point lies between the ends.
    #[must_use]
    pub fn spans(&self, p: &Vector2<f64>) -> bool {
        match self {
            Self::Line { from, to } => {
                let along = to - from;
                let part = along.dot(&(p - from));
                part >= 0.0 && part <= along.norm_squared()
            }
            Self::Arc {
                centre,
                convex,
                from,
                to,
                ..
            } => {
                let sign = if *convex { -1.0 } else { 1.0 };
                let (first, last, arm) = (from - centre, to - centre, p - centre);
                sign * cross(&first, &arm) >= 0.0 && sign * cross(&arm, &last) >= 0.0
            }
        }
    }

    /// Nearest distance without sign, metres, and whether the foot lies between the ends.
    #[must_use]
    pub fn distance(&self, p: &Vector2<f64>) -> (f64, bool) {
        if self.spans(p) {
            return (self.extended(p).distance_m.abs(), true);
        }
        ((p - self.from()).norm().min((p - self.to()).norm()), false)
    }

    /// The point at a part (0 to 1) of the way.
    #[must_use]
    pub fn at(&self, part: f64) -> Vector2<f64> {
        match self {
            Self::Line { from, to } => from + part * (to - from),
            Self::Arc {
                centre,
                radius_m,
                convex,
                from,
                ..
            } => {
                let sign = if *convex { -1.0 } else { 1.0 };
                let angle = sign * part * self.length_m() / radius_m;
                let (s, c) = math::sin_cos(angle);
                let arm = from - centre;
                centre + Vector2::new(c * arm.x - s * arm.y, s * arm.x + c * arm.y)
            }
        }
    }

    /// Direction of travel at a part (0 to 1) of the way, unit length.
    #[must_use]
    pub fn tangent(&self, part: f64) -> Vector2<f64> {
        let normal = self.extended(&self.at(part)).normal;
        Vector2::new(normal.y, -normal.x)
    }

    /// Points at most `spacing_m` apart, both ends among them.
    #[must_use]
    pub fn samples(&self, spacing_m: f64) -> Vec<Vector2<f64>> {
        let steps = (self.length_m() / spacing_m).ceil().max(1.0) as usize;
        (0..=steps)
            .map(|i| self.at(i as f64 / steps as f64))
            .collect()
    }
}

/// The nearest of some elements to a point; `None` when there are none.
#[must_use]
pub fn nearest(elements: &[Element], p: &Vector2<f64>) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for (element, piece) in elements.iter().enumerate() {
        let (distance_m, inside) = piece.distance(p);
        if best.is_none_or(|b| distance_m < b.distance_m) {
            best = Some(Nearest {
                element,
                distance_m,
                inside,
            });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn quarter(convex: bool) -> Element {
        let (a, b) = (Vector2::new(0.0, 1.0), Vector2::new(1.0, 0.0));
        Element::arc(a, b, if convex { 1.0 } else { -1.0 }).expect("an arc")
    }

    /// The same two points with the bulge on either side: unit circles about (0, 0) and (1, 1).
    #[test]
    fn a_bulge_and_a_hollow_have_their_centres_on_either_side() {
        for (convex, centre) in [
            (true, Vector2::new(0.0, 0.0)),
            (false, Vector2::new(1.0, 1.0)),
        ] {
            let Element::Arc { centre: found, .. } = quarter(convex) else {
                panic!("an arc")
            };
            assert!((found - centre).norm() < 1e-15, "{convex}: {found}");
            assert_abs_diff_eq!(
                quarter(convex).length_m(),
                std::f64::consts::FRAC_PI_2,
                epsilon = 1e-12
            );
        }
        let outside = quarter(true).extended(&Vector2::new(3.0, 4.0));
        assert_abs_diff_eq!(outside.distance_m, 4.0);
        let inside = quarter(false).extended(&Vector2::new(0.9, 0.9));
        assert!(inside.distance_m > 0.0 && inside.normal.x > 0.0);
    }

    #[test]
    fn travel_keeps_the_outside_on_the_left() {
        for convex in [true, false] {
            let arc = quarter(convex);
            assert!((arc.at(0.0) - arc.from()).norm() < 1e-15);
            assert!((arc.at(1.0) - arc.to()).norm() < 1e-12);
            let ahead = arc.at(0.5 + 1e-6) - arc.at(0.5 - 1e-6);
            assert!(ahead.normalize().dot(&arc.tangent(0.5)) > 1.0 - 1e-9);
        }
    }

    proptest! {
        /// The analytic distance is the smallest distance to dense samples, to the samples' spacing.
        #[test]
        fn distances_agree_with_dense_samples(x in -2.0..2.0f64, z in -2.0..2.0f64, convex: bool) {
            let line = Element::Line { from: Vector2::new(-1.0, 0.2), to: Vector2::new(0.0, 1.0) };
            let elements = [line, quarter(convex)];
            let p = Vector2::new(x, z);
            let found = nearest(&elements, &p).expect("elements");
            let dense = elements.iter().flat_map(|e| e.samples(1e-3)).map(|s| (s - p).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(found.distance_m <= dense + 1e-12);
            prop_assert!(found.distance_m >= dense - 5e-4);
        }
    }
}
