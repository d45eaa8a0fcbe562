//! Rough registration of points against faces: iteratively reweighted point-to-plane least squares whose kernel narrows
//! step by step (graduated non-convexity, Yang et al., *IEEE RA-L* 2020, with the Geman-McClure kernel).
//!
//! Used twice: the target's pose from the laser points (four parameters), the sounder's mounting from the soundings (six).

use nalgebra::{SMatrix, SVector, Vector3};

use super::patches::{Attraction, Patches};

/// One point as the parameters move it.
#[derive(Clone, Copy, Debug)]
pub struct Sight<const D: usize> {
    /// Position, frame of the patches, metres.
    pub point_m: Vector3<f64>,
    /// Direction from the sensor to the point (any length).
    pub ray: Vector3<f64>,
    /// d(point)/d(parameters).
    pub jacobian: SMatrix<f64, 3, D>,
}

/// Points that move with `D` parameters.
pub trait Movable<const D: usize> {
    /// Number of points.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Point `k` under the parameters.
    fn sight(&self, k: usize, parameters: &SVector<f64, D>) -> Sight<D>;
}

/// Where a registration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration<const D: usize> {
    /// The parameters.
    pub parameters: SVector<f64, D>,
    /// Soft number of points that fit at the last width, each counting from 0 to 1.
    pub score: f64,
}

/// Rounds of reweighting at each kernel width.
const ROUNDS: usize = 5;
/// A width is done when no parameter moves by more than this in its prior sigma.
const SETTLED: f64 = 2e-3;
/// Points that a score looks at, at the most.
const SCORED: usize = 1000;
/// Kernels of this width and wider, metres, only bring the parameters near.
const COARSE_M: f64 = 0.15;
/// Points that a step under such a kernel looks at, at the most.
const COARSE: usize = 700;

/// Registers `points` from `start`, narrowing the kernel through `widths_m` (metres, descending). `prior_sigma` keeps
/// directions that the points do not determine near the start.
#[must_use]
pub fn register<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    start: &SVector<f64, D>,
    prior_sigma: &SVector<f64, D>,
    widths_m: &[f64],
) -> Registration<D> {
    let mut parameters = *start;
    for &width_m in widths_m {
        for _ in 0..ROUNDS {
            let Some(step) =
                reweighted_step(points, patches, &parameters, start, prior_sigma, width_m)
            else {
                break;
            };
            parameters += step;
            if step.component_div(prior_sigma).amax() < SETTLED {
                break;
            }
        }
    }
    let last_m = widths_m.last().copied().unwrap_or(0.05);
    Registration {
        parameters,
        score: score(points, patches, &parameters, last_m),
    }
}

/// One Gauss-Newton step under the weights of the current position; `None` when nothing attracts.
fn reweighted_step<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    parameters: &SVector<f64, D>,
    start: &SVector<f64, D>,
    prior_sigma: &SVector<f64, D>,
    width_m: f64,
) -> Option<SVector<f64, D>> {
    let mut normal_matrix = prior_weights(prior_sigma);
    let mut right_side = normal_matrix * (start - parameters);
    let mut attracted = false;
    for k in (0..points.len()).step_by(stride(points.len(), width_m)) {
        let Some((row, weight, at)) = drawn(points, patches, parameters, k, width_m) else {
            continue;
        };
        normal_matrix.ger(weight, &row, &row, 1.0);
        right_side -= row * (weight * at.signed_m);
        attracted = true;
    }
    let solution = normal_matrix.try_inverse()? * right_side;
    (attracted && solution.iter().all(|v| v.is_finite())).then_some(solution)
}

/// Of how many points one is looked at under a kernel.
fn stride(points: usize, width_m: f64) -> usize {
    if width_m < COARSE_M {
        1
    } else {
        points.div_ceil(COARSE).max(1)
    }
}

fn prior_weights<const D: usize>(prior_sigma: &SVector<f64, D>) -> SMatrix<f64, D, D> {
    SMatrix::from_diagonal(&prior_sigma.map(|sigma| sigma.powi(-2)))
}

/// Point `k` as a condition: d(distance)/d(parameters), weight, and the face; `None` when no face attracts it.
fn drawn<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    parameters: &SVector<f64, D>,
    k: usize,
    width_m: f64,
) -> Option<(SVector<f64, D>, f64, Attraction)> {
    let sight = points.sight(k, parameters);
    let at = patches.attract(&sight.point_m, &sight.ray, 3.0 * width_m)?;
    let weight = geman_mcclure(at.away_m / width_m) / (width_m * width_m);
    Some((sight.jacobian.tr_mul(&at.normal), weight, at))
}

/// How a registration follows one of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<const D: usize> {
    /// Number of the point.
    pub point: usize,
    /// The face that it is drawn to (index in the target's faces).
    pub face: u16,
    /// Outward normal of that face.
    pub normal: Vector3<f64>,
    /// Change of the parameters per metre by which the point moves along that normal.
    pub parameters: SVector<f64, D>,
}

/// First derivatives of a registration that ended at `parameters`, its weights those of the last width: `-N^-1 w J^T n` for each
/// point, `N = sum w J^T n n^T J + prior`. Empty when nothing attracts.
#[must_use]
pub fn responses<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    parameters: &SVector<f64, D>,
    prior_sigma: &SVector<f64, D>,
    width_m: f64,
) -> Vec<Response<D>> {
    let one = |k| Some((k, drawn(points, patches, parameters, k, width_m)?));
    let all: Vec<_> = (0..points.len()).filter_map(one).collect();
    let mut normal_matrix = prior_weights(prior_sigma);
    for (_, (row, weight, _)) in &all {
        normal_matrix.ger(*weight, row, row, 1.0);
    }
    let Some(cofactor) = normal_matrix.try_inverse() else {
        return vec![];
    };
    let response =
        |(point, (row, weight, at)): (usize, (SVector<f64, D>, f64, Attraction))| Response {
            point,
            face: at.face,
            normal: at.normal,
            parameters: -(cofactor * row * weight),
        };
    all.into_iter().map(response).collect()
}

/// Soft number of points within `width_m` of a face, from an even sample of them.
#[must_use]
pub fn score<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    parameters: &SVector<f64, D>,
    width_m: f64,
) -> f64 {
    let stride = points.len().div_ceil(SCORED).max(1);
    let fits: f64 = (0..points.len())
        .step_by(stride)
        .filter_map(|k| {
            let sight = points.sight(k, parameters);
            patches.attract(&sight.point_m, &sight.ray, 3.0 * width_m)
        })
        .map(|at| geman_mcclure(at.away_m / width_m))
        .sum();
    fits * stride as f64
}

/// Weight of the Geman-McClure kernel at a misfit in widths.
fn geman_mcclure(x: f64) -> f64 {
    (1.0 + x * x).powi(-2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::Water;
    use crate::target::{Target, WallModel};

    struct Shifted(Vec<Vector3<f64>>);

    impl Movable<3> for Shifted {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn sight(&self, k: usize, parameters: &SVector<f64, 3>) -> Sight<3> {
            let point_m = self.0[k] + parameters;
            let ray = point_m - Vector3::new(-6.0, 0.0, -1.4);
            Sight {
                point_m,
                ray,
                jacobian: SMatrix::identity(),
            }
        }
    }

    fn scene() -> (Target, Patches) {
        let target = WallModel::of_tests();
        let origin = Vector3::new(-6.0, 0.0, -1.4);
        let patches = Patches::new(&target, Water::Below, 0.0, &[origin]);
        (target, patches)
    }

    fn wet_points(target: &Target, patches: &Patches) -> Vec<Vector3<f64>> {
        let faces = patches.faces();
        let samples = faces.flat_map(|f| target.faces[f].outline.samples_m(0.13));
        samples.filter(|p| p.z < 0.0).collect()
    }

    #[test]
    fn a_shift_of_40_cm_is_found_among_outliers() {
        let (target, patches) = scene();
        let shift = Vector3::new(0.4, -0.3, 0.25);
        let mut points = wet_points(&target, &patches);
        points.iter_mut().for_each(|p| *p -= shift);
        for k in 0..points.len() / 4 {
            points[4 * k] += Vector3::new(
                ((k * 37) % 101) as f64 * 0.02 - 1.0,
                0.0,
                ((k * 53) % 89) as f64 * 0.02 - 0.9,
            );
        }
        let found = register(
            &Shifted(points),
            &patches,
            &SVector::zeros(),
            &SVector::repeat(0.5),
            &[1.0, 0.5, 0.25, 0.12, 0.06, 0.03],
        );
        assert!(
            (found.parameters - shift).norm() < 0.005,
            "{:?}",
            found.parameters
        );
    }
    /// A bent cloud: the registration follows it as its responses say.
    #[test]
    fn responses_are_the_registrations_derivatives() {
        let (target, patches) = scene();
        let points = wet_points(&target, &patches);
        let bend = |p: &Vector3<f64>| {
            Vector3::new(2e-4 * p.y, 3e-4 * (p.z + 1.0), -1e-4 * p.y + 2e-4 * p.x)
        };
        let (width_m, sigma) = (0.025, SVector::repeat(0.05));
        let responses = responses(
            &Shifted(points.clone()),
            &patches,
            &SVector::zeros(),
            &sigma,
            width_m,
        );
        let expected: Vector3<f64> = responses
            .iter()
            .map(|r| r.parameters * r.normal.dot(&bend(&points[r.point])))
            .sum();
        let bent = Shifted(points.iter().map(|p| p + bend(p)).collect());
        let (mut found, zero) = (SVector::zeros(), SVector::zeros());
        for _ in 0..20 {
            let step = reweighted_step(&bent, &patches, &found, &zero, &sigma, width_m);
            found += step.expect("a step");
        }
        assert!(expected.amin().abs() > 5e-6, "{expected}");
        assert!(
            (found - expected).norm() < 0.02 * expected.norm(),
            "{found} {expected}"
        );
    }
}
