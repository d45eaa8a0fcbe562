//! Ties: which sounding or return lies on which face, found anew from the raw observations whenever the estimate moved.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::rows::Rows;
use super::scene::Scene;
use super::tie_set::code;
pub use super::tie_set::{Reason, Tie, TieSet, Ties};
use crate::adjust::ChainState;
use crate::calibrate::cloud::SensorModel;
use crate::geometry::rotation::exp;
use crate::georef::{Beam, effects};
use crate::matching::{Gate, Patches, Spread, Verdict};
use crate::observe::{LaserNoise, Mounting, PoseSample, SonarNoise, TrajectoryNoise};

/// Rows per parallel task.
const CHUNK: usize = 16_384;
/// A tie keeps this many sigmas of its own position noise away from the edges of its face.
const MARGIN_SIGMAS: f64 = 3.0;
/// But never less than this, metres.
const LEAST_MARGIN_M: f64 = 0.02;

/// A-priori variance of the trajectory as one point feels it.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryVariance {
    position_m2: f64,
    level_rad2: f64,
    heading_rad2: f64,
}

impl TrajectoryVariance {
    /// White noise, and drift where `with_drift`.
    #[must_use]
    pub fn new(noise: &TrajectoryNoise, with_drift: bool) -> Self {
        let drift = f64::from(u8::from(with_drift));
        Self {
            position_m2: noise.position_m.powi(2) + drift * noise.position_drift_m.powi(2),
            level_rad2: noise.roll_pitch_rad.powi(2),
            heading_rad2: noise.heading_rad.powi(2) + drift * noise.heading_drift_rad.powi(2),
        }
    }

    /// Largest variance along any unit normal of a point `arm_m` away from the INS, square metres.
    #[must_use]
    pub fn at_most(&self, arm_m: f64) -> f64 {
        self.position_m2 + self.level_rad2.max(self.heading_rad2) * arm_m * arm_m
    }

    /// Variance along a unit normal, given d(n.X)/d(attitude) (metres per radian), square metres.
    #[must_use]
    pub fn along(&self, attitude: &Vector3<f64>) -> f64 {
        self.position_m2
            + self.level_rad2 * (attitude.x.powi(2) + attitude.y.powi(2))
            + self.heading_rad2 * attitude.z.powi(2)
    }

    /// Its covariance of a point `arm` (target frame, metres) away from the INS, times a unit normal, square metres.
    #[must_use]
    pub fn product(&self, normal: &Vector3<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        let attitude = arm.cross(normal);
        let swing = Vector3::new(self.level_rad2, self.level_rad2, self.heading_rad2);
        normal * self.position_m2 + swing.component_mul(&attitude).cross(arm)
    }
}

/// The body's poses corrected by estimated trajectory errors.
#[derive(Clone, Copy, Debug)]
pub struct Corrected<'a> {
    /// Epoch of each record of the trajectory.
    pub epochs: &'a [u32],
    /// Estimated errors.
    pub chain: &'a ChainState,
}

impl Corrected<'_> {
    fn pose(&self, mut pose: PoseSample) -> PoseSample {
        let Some(&interval) = self
            .epochs
            .get(pose.record as usize)
            .filter(|e| **e != u32::MAX)
        else {
            return pose;
        };
        let y = self
            .chain
            .between(interval, pose.weight_before, 1.0 - pose.weight_before);
        pose.position_m += Vector3::new(y[0], y[1], y[2]);
        pose.rotation = exp(&Vector3::new(y[3], y[4], y[5])) * pose.rotation;
        pose
    }
}

/// What an association knows of the trajectory's errors: their estimate, or their a-priori variance.
#[derive(Clone, Copy, Debug)]
pub struct Association<'a> {
    /// Gate in sigmas.
    pub gate_sigmas: f64,
    /// Estimated errors; `None` before the first adjustment.
    pub corrected: Option<Corrected<'a>>,
}

impl Association<'static> {
    /// Before anything is known of the trajectory's errors: the gate allows for all of them.
    #[must_use]
    pub fn before(gate_sigmas: f64) -> Self {
        Self {
            gate_sigmas,
            corrected: None,
        }
    }
}

impl Association<'_> {
    fn pose(&self, pose: PoseSample) -> PoseSample {
        self.corrected.map_or(pose, |c| c.pose(pose))
    }

    /// Variance of the trajectory that the gate must allow for.
    fn variance(&self, noise: &TrajectoryNoise) -> TrajectoryVariance {
        if self.corrected.is_some() {
            TrajectoryVariance {
                position_m2: 0.0,
                level_rad2: 0.0,
                heading_rad2: 0.0,
            }
        } else {
            TrajectoryVariance::new(noise, true)
        }
    }
}

/// Sensitivity of the distance along `direction` to one sigma of range and of angle, metres.
#[must_use]
pub fn return_gain(
    noise: &LaserNoise,
    u_m: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> nalgebra::Vector2<f64> {
    let range_m = u_m.norm().max(1e-9);
    let across = Vector3::new(u_m.z, 0.0, -u_m.x);
    nalgebra::Vector2::new(
        u_m.dot(direction) / range_m * noise.range_m,
        across.dot(direction) * noise.angle_rad,
    )
}

/// Covariance of a laser return times a direction in the scanner frame, given its gain along that direction, square metres.
#[must_use]
pub fn return_product(
    noise: &LaserNoise,
    u_m: &Vector3<f64>,
    gain: &nalgebra::Vector2<f64>,
) -> Vector3<f64> {
    let range_m = u_m.norm().max(1e-9);
    let across = Vector3::new(u_m.z, 0.0, -u_m.x);
    u_m * (gain.x * noise.range_m / range_m) + across * (gain.y * noise.angle_rad)
}

/// Variance of a sounding along a direction in the sonar frame, given its Jacobian, square metres.
#[must_use]
pub fn sounding_variance(noise: &SonarNoise, gain: &Vector3<f64>) -> f64 {
    (gain.x * noise.range_m).powi(2)
        + (gain.y * noise.across_rad).powi(2)
        + (gain.z * noise.along_rad).powi(2)
}

/// Variances of range (square metres), across and along angle (square radians) of a sounding.
#[must_use]
pub fn sounding_variances(noise: &SonarNoise) -> Vector3<f64> {
    Vector3::new(
        noise.range_m.powi(2),
        noise.across_rad.powi(2),
        noise.along_rad.powi(2),
    )
}

/// Limits of the tie of a point whose own noise has the variance `own_m2` at the most, `spread_m2` the INS's position, and which
/// lies `arm` away from the INS.
fn gate(
    sigmas: f64,
    own_m2: f64,
    spread_m2: f64,
    trajectory: &TrajectoryVariance,
    arm: &Vector3<f64>,
) -> Gate {
    Gate {
        sigmas,
        largest_sigma_m: (own_m2 + trajectory.at_most(arm.norm())).sqrt(),
        margin_m: (MARGIN_SIGMAS * (own_m2 + spread_m2).sqrt()).max(LEAST_MARGIN_M),
    }
}

/// Which rows are tied, and what is known of them.
#[derive(Clone, Copy, Debug)]
pub enum Among<'a> {
    /// All; nothing is known.
    All,
    /// All; those of an earlier association are probably where they were.
    AllLike(&'a TieSet),
    /// Only those of an earlier association.
    Tied(&'a TieSet),
}

impl Among<'_> {
    fn count(&self, all: usize) -> usize {
        match self {
            Self::All | Self::AllLike(_) => all,
            Self::Tied(set) => set.len(),
        }
    }

    /// What is known of the rows before they are judged.
    fn codes(&self, all: usize) -> Vec<u16> {
        match self {
            Self::All | Self::AllLike(_) => vec![Reason::NotLookedAt.code(); all],
            Self::Tied(set) => set.codes(),
        }
    }

    /// Rows and the faces they were tied to, from the `i`-th on.
    fn from(&self, i: usize) -> impl Iterator<Item = (usize, Option<u16>)> + '_ {
        let ties = match self {
            Self::All => None,
            Self::AllLike(set) => Some(set.beginning_at(i)),
            Self::Tied(set) => Some(set.from(i)),
        };
        let only_tied = matches!(self, Self::Tied(_));
        let (mut ties, mut row) = (ties.into_iter().flatten().peekable(), i);
        std::iter::from_fn(move || {
            if only_tied {
                return ties.next().map(|t| (t.row as usize, Some(t.face)));
            }
            row += 1;
            let known = ties.next_if(|t| t.row as usize == row - 1);
            Some((row - 1, known.map(|t| t.face)))
        })
    }
}

/// Ties laser returns.
#[must_use]
pub fn tie_returns(
    scene: &Scene,
    patches: &Patches,
    among: Among,
    association: &Association,
) -> TieSet {
    let campaign = scene.campaign;
    let gate_sigmas = association.gate_sigmas;
    let spread_m2 = TrajectoryVariance::new(&campaign.trajectory.noise, true).position_m2;
    let trajectory = association.variance(&campaign.trajectory.noise);
    let noise = &campaign.laser.noise;
    let count = among.count(campaign.laser.len());
    let mut set = collect(
        among.codes(campaign.laser.len()),
        count,
        |i| among.from(i),
        |j, hint| {
            if let Some(point) = scene.laser_fixed_point(j) {
                let ray = scene.laser_point(j).map_or(Vector3::x(), |p| p.1);
                let gate = Gate {
                    sigmas: gate_sigmas,
                    largest_sigma_m: noise.point_m,
                    margin_m: (MARGIN_SIGMAS * noise.point_m).max(LEAST_MARGIN_M),
                };
                let round = |normal: &Vector3<f64>| Spread::round(noise.point_m, normal);
                return Some(patches.assign(&point, &ray, &gate, hint, round));
            }
            let pose = association.pose(scene.return_pose(j)?);
            let u = campaign.laser.point(j);
            let turned = campaign.scanner.rotation * u;
            let arm = turned + campaign.scanner.lever_arm_m;
            let arm_in_target = pose.rotation * arm;
            let point = pose.position_m + arm_in_target;
            let own_m2 = noise.range_m.powi(2) + noise.angle_rad.powi(2) * u.norm_squared();
            let gate = gate(gate_sigmas, own_m2, spread_m2, &trajectory, &arm);
            let to_target = pose.rotation * campaign.scanner.rotation;
            let verdict =
                patches.assign(&point, &(pose.rotation * turned), &gate, hint, |normal| {
                    let gain = return_gain(noise, &u, &to_target.tr_mul(normal));
                    let own = to_target * return_product(noise, &u, &gain);
                    let product = own + trajectory.product(normal, &arm_in_target);
                    Spread::of_product(&product, normal)
                });
            Some(verdict)
        },
    );
    set.keep_true(scene.struck.map(|s| s.returns.as_slice()));
    set
}

/// What places a sounding: mounting, latency and range scale, and the values of the caller's own unknowns.
#[derive(Clone, Copy, Debug)]
pub struct PlacedBy<'a> {
    /// Mounting, latency, range scale.
    pub sensor: SensorModel,
    /// Values of the scene's own unknowns; empty where a path does not have them.
    pub extras: &'a [f64],
}

impl From<SensorModel> for PlacedBy<'_> {
    /// The sensor alone.
    fn from(sensor: SensorModel) -> Self {
        Self {
            sensor,
            extras: &[],
        }
    }
}

impl PlacedBy<'_> {
    /// A mounting without latency and scale.
    #[must_use]
    pub fn mounting(mounting: Mounting) -> Self {
        SensorModel::plain(mounting).into()
    }

    /// Pose and beam of a sounding, corrected; `None` outside the trajectory and of a beam without a ray.
    #[must_use]
    pub fn beam(&self, scene: &Scene, row: usize) -> Option<(PoseSample, Beam)> {
        let mut pose = scene.sounding_pose(row, self.sensor.latency_s)?;
        let mut beam = scene.beam(row, &pose, &self.sensor.mounting)?;
        beam.range_m *= 1.0 + self.sensor.range_scale;
        pose.position_m.z += effects::act(scene.extras, self.extras, row, &mut beam);
        Some((pose, beam))
    }
}

/// Ties the soundings in `rows`, as placed by a model.
#[must_use]
pub fn tie_soundings(
    scene: &Scene,
    patches: &Patches,
    rows: &Rows,
    model: &PlacedBy,
    association: &Association,
) -> TieSet {
    let mounting = &model.sensor.mounting;
    let campaign = scene.campaign;
    let gate_sigmas = association.gate_sigmas;
    let spread_m2 = TrajectoryVariance::new(&campaign.trajectory.noise, true).position_m2;
    let trajectory = association.variance(&campaign.trajectory.noise);
    let from = |i: usize| rows.from(i).map(|row| (row as usize, None));
    // rows that are not among these lie far from every face
    let codes = vec![Reason::NoFace.code(); campaign.soundings.len()];
    let mut set = collect(codes, rows.len(), from, |k, before| {
        let (pose, beam) = model.beam(scene, k)?;
        let noise = &scene.sounding_noise(k);
        let pose = association.pose(pose);
        let partials = beam.partials();
        let turned = mounting.rotation * partials.vector_m;
        let arm = turned + mounting.lever_arm_m;
        let arm_in_target = pose.rotation * arm;
        let point = pose.position_m + arm_in_target;
        let to_target = pose.rotation * mounting.rotation;
        let weights = sounding_variances(noise);
        let swing_rad2 = noise.across_rad.powi(2) + noise.along_rad.powi(2);
        let own_m2 = noise.range_m.powi(2) + swing_rad2 * beam.range_m.powi(2);
        let gate = gate(gate_sigmas, own_m2, spread_m2, &trajectory, &arm);
        let verdict = patches.assign(&point, &(pose.rotation * turned), &gate, before, |normal| {
            let gain = partials.jacobian.tr_mul(&to_target.tr_mul(normal));
            let own = to_target * (partials.jacobian * weights.component_mul(&gain));
            Spread::of_product(&(own + trajectory.product(normal, &arm_in_target)), normal)
        });
        Some(verdict)
    });
    set.keep_true(scene.struck.map(|s| s.soundings.as_slice()));
    set
}

/// Ties the soundings in `rows` under a rough mounting, before anything is known of latency, range scale and trajectory errors.
#[must_use]
pub fn tie_soundings_first(
    scene: &Scene,
    patches: &Patches,
    rows: &Rows,
    mounting: &Mounting,
    gate_sigmas: f64,
) -> TieSet {
    let association = Association::before(gate_sigmas);
    let model = PlacedBy::mounting(*mounting);
    tie_soundings(scene, patches, rows, &model, &association)
}

/// Runs `judge` over `count` rows in parallel and keeps the ties in order; `from(i)` gives the rows, ascending, from the `i`-th on, each
/// with the face it probably lies on, else the face of the last tie is taken for that. `codes` holds what is known of all rows before.
fn collect<I: Iterator<Item = (usize, Option<u16>)>>(
    mut codes: Vec<u16>,
    count: usize,
    from: impl Fn(usize) -> I + Sync,
    judge: impl Fn(usize, Option<u16>) -> Option<Verdict> + Sync,
) -> TieSet {
    let starts = (0..count).step_by(CHUNK);
    let ends = starts.clone().skip(1).map(|i| from(i).next());
    let ends = ends.map(|next| next.map_or(usize::MAX, |(row, _)| row));
    let ends: Vec<usize> = ends.chain([usize::MAX]).collect();
    let (mut rest, mut first) = (codes.as_mut_slice(), 0);
    let mut parts = vec![];
    for (i, end) in starts.zip(ends) {
        let length = (end - first).min(rest.len());
        let (own, behind) = rest.split_at_mut(length);
        parts.push((i, first, own));
        (rest, first) = (behind, first + length);
    }
    let judged = |(i, first, codes): (usize, usize, &mut [u16])| {
        let mut last = None;
        for (row, known) in from(i).take(CHUNK.min(count - i)) {
            let verdict = judge(row, known.or(last));
            if let Some(Verdict::Tie(face)) = verdict {
                last = Some(face);
            }
            codes[row - first] = code(verdict);
        }
    };
    parts.into_par_iter().for_each(judged);
    TieSet::of_codes(codes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_noise_acts_across_the_ray_in_the_scan_plane() {
        let noise = LaserNoise {
            range_m: 0.005,
            angle_rad: 0.001,
            point_m: 0.0,
        };
        let u = Vector3::new(10.0, 0.0, 0.0);
        let sigma_m = |d: Vector3<f64>| return_gain(&noise, &u, &d).norm();
        assert!((sigma_m(Vector3::x()) - 0.005).abs() < 1e-15);
        assert!((sigma_m(Vector3::z()) - 0.010).abs() < 1e-15);
        assert!(sigma_m(Vector3::y()) < 1e-15);
        let oblique = Vector3::new(0.6, 0.0, 0.8);
        let product = return_product(&noise, &u, &return_gain(&noise, &u, &oblique));
        let expected = Vector3::new(0.6 * 25e-6, 0.0, 0.8 * 100e-6);
        assert!((product - expected).norm() < 1e-18);
    }
}
