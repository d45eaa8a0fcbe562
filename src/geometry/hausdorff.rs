//! Hausdorff distance of point sets: `H = max(h(A, B), h(B, A))`, `h(A, B) = max over a of min over b of |a - b|` (patent
//! CN114162169A, claim 6).

use nalgebra::Vector2;

/// Directed distance `h(A, B)`, metres, exact; infinite when B is empty and A is not, zero when A is empty.
///
/// Points of B must be sorted by `y`, which bounds the search.
#[must_use]
fn directed(a: &[Vector2<f64>], b_sorted: &[Vector2<f64>]) -> f64 {
    a.iter()
        .map(|p| nearest_square(p, b_sorted))
        .fold(0.0, f64::max)
        .sqrt()
}

/// Smallest squared distance, searched outwards from the point's place in the order of `y`.
fn nearest_square(p: &Vector2<f64>, sorted: &[Vector2<f64>]) -> f64 {
    let place = sorted.partition_point(|q| q.y < p.y);
    let mut best = f64::INFINITY;
    for q in &sorted[place..] {
        if (q.y - p.y).powi(2) >= best {
            break;
        }
        best = best.min((q - p).norm_squared());
    }
    for q in sorted[..place].iter().rev() {
        if (q.y - p.y).powi(2) >= best {
            break;
        }
        best = best.min((q - p).norm_squared());
    }
    best
}

/// The Hausdorff distance of two point sets, metres; infinite when exactly one is empty.
#[must_use]
pub fn distance_m(a: &[Vector2<f64>], b: &[Vector2<f64>]) -> f64 {
    let sorted = |points: &[Vector2<f64>]| {
        let mut all = points.to_vec();
        all.sort_by(|p, q| p.y.total_cmp(&q.y));
        all
    };
    let (a, b) = (sorted(a), sorted(b));
    directed(&a, &b).max(directed(&b, &a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(a: &[Vector2<f64>], b: &[Vector2<f64>]) -> f64 {
        let one = |a: &[Vector2<f64>], b: &[Vector2<f64>]| {
            let near = |p: &Vector2<f64>| {
                b.iter()
                    .map(|q| (p - q).norm())
                    .fold(f64::INFINITY, f64::min)
            };
            a.iter().map(near).fold(0.0, f64::max)
        };
        one(a, b).max(one(b, a))
    }

    fn set() -> impl Strategy<Value = Vec<Vector2<f64>>> {
        prop::collection::vec(
            (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y)| Vector2::new(x, y)),
            1..40,
        )
    }

    proptest! {
        #[test]
        fn it_is_the_distance_by_definition(a in set(), b in set()) {
            prop_assert!((distance_m(&a, &b) - brute(&a, &b)).abs() < 1e-15);
            prop_assert_eq!(distance_m(&a, &a), 0.0);
        }
    }

    /// A point far from the other set counts although the other way is near.
    #[test]
    fn both_directions_count() {
        let near = [Vector2::new(0.0, 0.0)];
        let far = [Vector2::new(0.0, 0.0), Vector2::new(3.0, 4.0)];
        assert_eq!(distance_m(&near, &far), 5.0);
        assert_eq!(distance_m(&far, &near), 5.0);
        assert!(distance_m(&near, &[]).is_infinite());
    }
}
