//! The faces that one sensor can see, with their planes as currently known, behind a k-d tree of samples.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Vector3;

use crate::math;
use crate::target::{Outline, Role, Target};

/// Spacing of the samples in the k-d tree, metres.
const SPACING_M: f64 = 0.25;
/// Faces closer to each other than this are compared when a point is tied, metres.
const NEIGHBOUR_M: f64 = 0.6;

/// A point further than this from every sample of a face belongs to none, metres.
const REACH_M: f64 = 0.5;

/// A point on a face's plane counts as "outside its outline" up to this distance from it, metres; beyond it belongs to no face.
const EDGE_M: f64 = 0.1;

/// Which side of the water level a sensor looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Water {
    /// The laser scanner: faces above the level.
    Above,
    /// The echo sounder: faces below it.
    Below,
}

/// How the noise of a point acts along the normal of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation along the normal, metres.
    pub sigma_m: f64,
    /// `C n / (n . C n)`, `C` the covariance of the point: where noise takes the point that takes it off the plane by one unit.
    pub off_plane: Vector3<f64>,
}

impl Spread {
    /// The same noise in every direction.
    #[must_use]
    pub fn round(sigma_m: f64, normal: &Vector3<f64>) -> Self {
        Self {
            sigma_m,
            off_plane: *normal,
        }
    }

    /// Of a covariance, by its product with the normal, square metres.
    #[must_use]
    pub fn of_product(product_m2: &Vector3<f64>, normal: &Vector3<f64>) -> Self {
        let variance_m2 = product_m2.dot(normal);
        Self {
            sigma_m: variance_m2.sqrt(),
            off_plane: product_m2 / variance_m2,
        }
    }

    /// Where the point is by all that is known of it once it lies on the plane that it misses by `misfit_m`. What noise is left in that
    /// place has nothing in common with the misfit, so that a choice by it leaves the misfits as they are.
    fn on_plane(&self, point: &Vector3<f64>, misfit_m: f64) -> Vector3<f64> {
        point - self.off_plane * misfit_m
    }
}

/// Limits of a tie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// Largest misfit along the normal, in its standard deviation.
    pub sigmas: f64,
    /// No standard deviation along any normal is larger than this, metres: it spares looking at planes far away.
    pub largest_sigma_m: f64,
    /// A point must lie inside the outline by this much, metres; a second face is as good if the point is not outside it by more.
    pub margin_m: f64,
}

/// What became of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It lies on this face (index in [`Target::faces`]).
    Tie(u16),
    /// No face is within the gate.
    NoFace,
    /// Within the gate of a face's plane, but outside (or too close to the edge of) its outline.
    OutsideOutline,
    /// Two faces are as good.
    Ambiguous,
    /// The face is an obstacle that is no tie.
    Obstacle,
}

/// What a rough point is drawn to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attraction {
    /// The face (index in [`Target::faces`]).
    pub face: u16,
    /// Its outward normal.
    pub normal: Vector3<f64>,
    /// Signed distance of the point to its plane, metres.
    pub signed_m: f64,
    /// Distance of the point to the face itself, metres.
    pub away_m: f64,
}

/// One visible face.
#[derive(Clone, Debug)]
struct Patch {
    face: usize,
    normal: Vector3<f64>,
    distance_m: f64,
    outline: Outline,
    tie: bool,
    /// Middle of the outline and the largest distance of a corner from it, metres.
    centre_m: Vector3<f64>,
    radius_m: f64,
    /// Patches that come close, this one first.
    neighbours: Vec<u16>,
}

impl Patch {
    /// Squared distance from the middle in the outline's plane, square metres.
    #[inline]
    fn beside_m2(&self, point: &Vector3<f64>) -> f64 {
        let from_middle = point - self.centre_m;
        from_middle.norm_squared() - from_middle.dot(&self.outline.normal).powi(2)
    }
}

/// The faces that one sensor can see.
#[derive(Debug)]
pub struct Patches {
    patches: Vec<Patch>,
    /// Patch of each face; `u16::MAX` where it has none.
    of_face: Vec<u16>,
    owner: Vec<u16>,
    tree: Option<ImmutableKdTree<f64, 3>>,
    water: Water,
    level_m: f64,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Patches {
    /// The faces of `target` on this side of the water level (metres, target frame) that look at any of `origins` (sensor positions).
    #[must_use]
    pub fn new(target: &Target, water: Water, level_m: f64, origins: &[Vector3<f64>]) -> Self {
        let mut samples: Vec<[f64; 3]> = vec![];
        let (mut patches, mut owner): (Vec<Patch>, Vec<u16>) = (vec![], vec![]);
        for (face, f) in target.faces.iter().enumerate() {
            let visible =
                |o: &Vector3<f64>| (o - f.outline.vertices_m[0]).dot(&f.outline.normal) > 0.02;
            if !origins.iter().any(visible) {
                continue;
            }
            let points = f.outline.samples_m(SPACING_M);
            let wet = |z: f64| on_side(water, level_m, z);
            let before = samples.len();
            samples.extend(points.iter().filter(|p| wet(p.z)).map(|p| [p.x, p.y, p.z]));
            if samples.len() == before {
                continue;
            }
            owner.resize(samples.len(), patches.len() as u16);
            let (centre_m, radius_m) = ball(&f.outline.vertices_m);
            patches.push(Patch {
                face,
                normal: f.outline.normal,
                distance_m: f.outline.normal.dot(&f.outline.vertices_m[0]),
                outline: f.outline.clone(),
                tie: f.role != Role::Obstacle,
                centre_m,
                radius_m,
                neighbours: vec![],
            });
        }
        let bound = |pick: fn(f64, f64) -> f64, start: f64| {
            samples.iter().fold(Vector3::repeat(start), |b, s| {
                b.zip_map(&Vector3::from(*s), pick)
            })
        };
        let (low, high) = (
            bound(f64::min, f64::INFINITY),
            bound(f64::max, f64::NEG_INFINITY),
        );
        link_neighbours(&mut patches, &samples, &owner);
        let mut of_face = vec![u16::MAX; target.faces.len()];
        for (k, patch) in patches.iter().enumerate() {
            of_face[patch.face] = k as u16;
        }
        let tree = ImmutableKdTree::new_from_slice(&samples)
            .ok()
            .filter(|_| !samples.is_empty());
        Self {
            patches,
            of_face,
            owner,
            tree,
            water,
            level_m,
            low,
            high,
        }
    }

    /// Whether no face is visible.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Indices (in [`Target::faces`]) of the visible faces that may be tied.
    pub fn faces(&self) -> impl Iterator<Item = usize> + '_ {
        self.patches.iter().filter(|p| p.tie).map(|p| p.face)
    }

    /// Replaces the plane of a face by `normal . X = distance`, with the normal along the face's outward side.
    pub fn set_plane(&mut self, face: usize, normal: Vector3<f64>, distance_m: f64) {
        if let Some(patch) = self.patches.iter_mut().find(|p| p.face == face) {
            let sign = patch.outline.normal.dot(&normal).signum();
            patch.normal = normal * sign;
            patch.distance_m = distance_m * sign;
        }
    }

    /// Whether a point is within `reach_m` of the box around all samples: a cheap first sieve.
    #[must_use]
    pub fn near_box(&self, point: &Vector3<f64>, reach_m: f64) -> bool {
        (0..3).all(|i| point[i] >= self.low[i] - reach_m && point[i] <= self.high[i] + reach_m)
    }

    /// The patch of the nearest sample and its distance in metres.
    fn nearest(&self, point: &Vector3<f64>) -> Option<(u16, f64)> {
        let tree = self.tree.as_ref()?;
        let found = tree
            .query(&[point.x, point.y, point.z])
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        let owner = *self.owner.get(found.item as usize)?;
        Some((owner, found.distance.sqrt()))
    }

    /// The face that a rough point is closest to; `None` beyond `reach_m` or for a face seen from behind.
    #[must_use]
    pub fn attract(
        &self,
        point: &Vector3<f64>,
        ray: &Vector3<f64>,
        reach_m: f64,
    ) -> Option<Attraction> {
        if !self.near_box(point, reach_m) {
            return None;
        }
        let (owner, near_m) = self.nearest(point)?;
        if near_m > reach_m + SPACING_M {
            return None;
        }
        let mut best: Option<Attraction> = None;
        for &n in &self.patches[owner as usize].neighbours {
            let patch = &self.patches[n as usize];
            let signed_m = patch.normal.dot(point) - patch.distance_m;
            let nearest_m = best.map_or(reach_m, |b| b.away_m);
            if signed_m.abs() > nearest_m || patch.normal.dot(ray) >= 0.0 {
                continue;
            }
            let outside_m = (-patch.outline.inside_within_m(point, nearest_m)).max(0.0);
            let away_m = math::hypot(signed_m, outside_m);
            if away_m <= reach_m && best.is_none_or(|b| away_m < b.away_m) {
                best = Some(Attraction {
                    face: patch.face as u16,
                    normal: patch.normal,
                    signed_m,
                    away_m,
                });
            }
        }
        best
    }

    /// The patch of a face that the point was tied to before.
    fn owner_of(&self, face: Option<u16>) -> Option<u16> {
        let patch = *self.of_face.get(usize::from(face?))?;
        (patch != u16::MAX).then_some(patch)
    }

    /// Ties a point, or says why not. `hint` is a face that it probably lies on: no search is needed if it does. `ray` is the
    /// direction from the sensor; `spread(normal)` how the point's noise acts along a normal. Whether the point lies inside a face, and on
    /// which side of the water, is asked of its place on the plane (`Spread::on_plane`): by the measured place, a face seen obliquely would
    /// keep those points at its edge whose noise turns them inwards, and with them a misfit that is not zero on average.
    #[must_use]
    pub fn assign(
        &self,
        point: &Vector3<f64>,
        ray: &Vector3<f64>,
        gate: &Gate,
        hint: Option<u16>,
        spread: impl Fn(&Vector3<f64>) -> Spread,
    ) -> Verdict {
        if !self.near_box(point, REACH_M) {
            return Verdict::NoFace;
        }
        if let (Some(face), Some(owner)) = (hint, self.owner_of(hint)) {
            let verdict = self.among(owner, point, ray, gate, &spread);
            if verdict == Verdict::Tie(face) {
                return verdict;
            }
        }
        match self.nearest(point) {
            Some((owner, near_m)) if near_m <= REACH_M => {
                self.among(owner, point, ray, gate, &spread)
            }
            _ => Verdict::NoFace,
        }
    }

    /// Ties a point to one of the patches around `owner`.
    fn among(
        &self,
        owner: u16,
        point: &Vector3<f64>,
        ray: &Vector3<f64>,
        gate: &Gate,
        spread: &impl Fn(&Vector3<f64>) -> Spread,
    ) -> Verdict {
        let widest_m = (gate.sigmas * gate.largest_sigma_m).min(REACH_M);
        let edge_m = gate.margin_m.max(EDGE_M);
        let (mut chosen, mut rivals, mut edge) = (None, 0, false);
        for &n in &self.patches[owner as usize].neighbours {
            let patch = &self.patches[n as usize];
            if patch.beside_m2(point) > (patch.radius_m + edge_m).powi(2) {
                continue;
            }
            let misfit_m = patch.normal.dot(point) - patch.distance_m;
            if misfit_m.abs() > widest_m || patch.normal.dot(ray) >= 0.0 {
                continue;
            }
            let spread = spread(&patch.normal);
            let place_m = spread.on_plane(point, misfit_m);
            if misfit_m.abs() > gate.sigmas * spread.sigma_m
                || !on_side(self.water, self.level_m, place_m.z)
            {
                continue;
            }
            let inside_m = patch.outline.inside_within_m(&place_m, edge_m);
            edge |= inside_m >= -EDGE_M;
            if inside_m >= -gate.margin_m {
                rivals += 1;
                if inside_m >= gate.margin_m {
                    chosen = Some(patch);
                }
            }
        }
        match chosen {
            Some(_) if rivals > 1 => Verdict::Ambiguous,
            Some(patch) if patch.tie => Verdict::Tie(patch.face as u16),
            Some(_) => Verdict::Obstacle,
            None if edge => Verdict::OutsideOutline,
            None => Verdict::NoFace,
        }
    }
}

/// A ball around some corners: their mean and the largest distance from it, metres.
fn ball(corners_m: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
    let centre = corners_m.iter().sum::<Vector3<f64>>() / corners_m.len().max(1) as f64;
    let away = |corner: &Vector3<f64>| (corner - centre).norm();
    (centre, corners_m.iter().map(away).fold(0.0, f64::max))
}

fn on_side(water: Water, level_m: f64, z: f64) -> bool {
    match water {
        Water::Above => z > level_m,
        Water::Below => z < level_m,
    }
}

/// Lists for each patch the patches whose samples come within reach, itself first.
fn link_neighbours(patches: &mut [Patch], samples: &[[f64; 3]], owner: &[u16]) {
    let of = |k: usize| {
        samples
            .iter()
            .zip(owner)
            .filter(move |(_, o)| **o as usize == k)
            .map(|(s, _)| Vector3::from(*s))
    };
    let boxes: Vec<(Vector3<f64>, Vector3<f64>)> = (0..patches.len())
        .map(|k| {
            let start = (
                Vector3::repeat(f64::INFINITY),
                Vector3::repeat(f64::NEG_INFINITY),
            );
            of(k).fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)))
        })
        .collect();
    for (k, patch) in patches.iter_mut().enumerate() {
        patch.neighbours.push(k as u16);
        for (other, (low, high)) in boxes.iter().enumerate() {
            let apart = (low - boxes[k].1)
                .sup(&(boxes[k].0 - high))
                .sup(&Vector3::zeros());
            if other != k && apart.norm() < NEIGHBOUR_M {
                patch.neighbours.push(other as u16);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::target::WallModel;

    fn below() -> Patches {
        Patches::new(
            &WallModel::of_tests(),
            Water::Below,
            0.0,
            &[Vector3::new(-5.0, 0.0, -0.8)],
        )
    }

    const GATE: Gate = Gate {
        sigmas: 5.0,
        largest_sigma_m: 0.01,
        margin_m: 0.05,
    };

    fn assign(patches: &Patches, x: f64, y: f64, z: f64) -> Verdict {
        let point = Vector3::new(x, y, z);
        patches.assign(
            &point,
            &(point - Vector3::new(-5.0, 0.0, -0.8)),
            &GATE,
            None,
            |normal| Spread::round(0.01, normal),
        )
    }

    #[test]
    fn points_are_tied_dropped_and_doubted_as_they_should() {
        let (target, patches) = (WallModel::of_tests(), below());
        let name = |v: Verdict| match v {
            Verdict::Tie(f) => target.faces[f as usize].name.clone(),
            other => format!("{other:?}"),
        };
        assert_eq!(name(assign(&patches, 0.02, 1.0, -1.5)), "wall");
        assert_eq!(name(assign(&patches, 0.2, 1.0, -1.5)), "NoFace");
        assert_eq!(name(assign(&patches, 0.0, 0.0, -2.98)), "OutsideOutline");
        // middle of the inclined face of the lowest block at +Y
        assert_eq!(
            name(assign(&patches, -0.75, 4.75, -1.8)),
            "+Y block 1 inclined"
        );
        // where the inclined face leaves the wall
        assert_eq!(name(assign(&patches, -0.02, 4.02, -1.8)), "OutsideOutline");
        // above the water
        assert_eq!(name(assign(&patches, 0.0, 0.0, 0.5)), "NoFace");
        // underside of the block at +Y: hidden from a sonar above it
        assert_eq!(name(assign(&patches, -0.5, 5.2, -2.1)), "NoFace");
        assert_eq!(name(assign(&patches, -0.3, 5.2, -1.5)), "+Y block 1 top");
    }

    #[test]
    fn noise_along_an_oblique_ray_moves_no_point_over_an_edge() {
        let patches = below();
        let sensor = Vector3::new(-5.0, 0.0, -0.8);
        let mut tied = [0, 0];
        for step in 0..80 {
            // across the lower edge of the wall, by a fifth of the distance that the noise takes a point down the wall
            let place = Vector3::new(0.0, 0.5, -2.9 - 0.001 * f64::from(step));
            let ray = (place - sensor).normalize();
            let verdicts = [-0.012, 0.012].map(|along_m| {
                patches.assign(&(place + ray * along_m), &ray, &GATE, None, |normal| {
                    Spread::of_product(&(ray * ray.dot(normal) * 1.44e-4), normal)
                })
            });
            assert_eq!(verdicts[0], verdicts[1], "at {place}");
            tied[usize::from(matches!(verdicts[0], Verdict::Tie(_)))] += 1;
        }
        assert!(tied.iter().all(|count| *count > 25), "{tied:?}");
    }

    #[test]
    fn the_noise_of_a_point_takes_it_off_a_plane_along_its_own_direction() {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let spread = Spread::of_product(&Vector3::new(0.6 * 4e-4, 0.0, 0.8 * 1e-4), &normal);
        assert!((spread.sigma_m - (0.36 * 4e-4 + 0.64 * 1e-4f64).sqrt()).abs() < 1e-15);
        assert!((spread.off_plane.dot(&normal) - 1.0).abs() < 1e-12);
        assert!((spread.off_plane.x / spread.off_plane.z - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_moved_plane_moves_its_ties() {
        let mut patches = below();
        let wall = WallModel::of_tests()
            .faces
            .iter()
            .position(|f| f.name == "wall")
            .expect("wall");
        patches.set_plane(wall, Vector3::x(), 0.3);
        assert_eq!(assign(&patches, 0.3, 1.0, -1.5), Verdict::Tie(wall as u16));
        assert_eq!(assign(&patches, 0.0, 1.0, -1.5), Verdict::NoFace);
    }
}
