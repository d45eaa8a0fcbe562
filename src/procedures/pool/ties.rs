//! Ties: which sounding or return lies on which face, found anew from the raw observations whenever the estimate moved.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::scene::Scene;
use crate::adjust::ChainState;
use crate::calibrate::cloud::SensorModel;
use crate::geometry::rotation::exp;
use crate::georef::{Beam, along_normal, effects};
use crate::matching::{Gate, Patches, Verdict};
use crate::observe::{LaserNoise, Mounting, PoseSample, SonarNoise, TrajectoryNoise};

/// Rows per parallel task.
const CHUNK: usize = 16_384;
/// A tie keeps this many sigmas of its own position noise away from the edges of its face.
const MARGIN_SIGMAS: f64 = 3.0;
/// But never less than this, metres.
const LEAST_MARGIN_M: f64 = 0.02;

/// One observation on one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tie {
    /// Row of the raw observation.
    pub row: u32,
    /// Index of the face in the target.
    pub face: u16,
}

/// Ties of one sensor and what became of the other rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TieSet {
    /// The ties in order of their rows.
    pub ties: Vec<Tie>,
    /// Rows that are not tied, by reason.
    pub rejected: BTreeMap<&'static str, u64>,
}

impl TieSet {
    /// Number of rows tied here but not there, or to another face.
    #[must_use]
    pub fn changed_from(&self, other: &Self) -> usize {
        let (mut i, mut j, mut same) = (0, 0, 0);
        while let (Some(a), Some(b)) = (self.ties.get(i), other.ties.get(j)) {
            same += usize::from(a == b);
            (i, j) = (
                i + usize::from(a.row <= b.row),
                j + usize::from(b.row <= a.row),
            );
        }
        self.ties.len().max(other.ties.len()) - same
    }

    /// At most `most` of the ties, evenly chosen.
    #[must_use]
    pub fn thinned(&self, most: usize) -> Self {
        let stride = self.ties.len().div_ceil(most).max(1);
        Self {
            ties: self.ties.iter().step_by(stride).copied().collect(),
            rejected: self.rejected.clone(),
        }
    }

    /// Leaves out ties to a face that the observation did not strike, where that is known.
    fn keep_true(&mut self, struck: Option<&[u16]>) {
        let Some(struck) = struck else { return };
        let before = self.ties.len();
        self.ties.retain(|t| struck[t.row as usize] == t.face);
        let wrong = (before - self.ties.len()) as u64;
        *self.rejected.entry("struck another surface").or_default() += wrong;
    }

    /// Number of ties on faces that `keep`.
    #[must_use]
    pub fn count(&self, keep: impl Fn(usize) -> bool) -> usize {
        self.ties.iter().filter(|t| keep(t.face as usize)).count()
    }
}

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

/// Variance of a laser return along a direction in the scanner frame (unit), square metres: range along the ray, angle in the
/// scanner's plane x-z.
#[must_use]
pub fn return_variance(noise: &LaserNoise, u_m: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
    let gain = return_gain(noise, u_m, direction);
    gain.x * gain.x + gain.y * gain.y
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

/// Variance of a sounding along a direction in the sonar frame, given its Jacobian, square metres.
#[must_use]
pub fn sounding_variance(noise: &SonarNoise, gain: &Vector3<f64>) -> f64 {
    (gain.x * noise.range_m).powi(2)
        + (gain.y * noise.across_rad).powi(2)
        + (gain.z * noise.along_rad).powi(2)
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
            Self::Tied(set) => set.ties.len(),
        }
    }

    /// Rows and the faces they were tied to, from the `i`-th on.
    fn from(&self, i: usize) -> impl Iterator<Item = (usize, Option<u16>)> + '_ {
        let ties: &[Tie] = match self {
            Self::All => &[],
            Self::AllLike(set) => &set.ties[set.ties.partition_point(|t| (t.row as usize) < i)..],
            Self::Tied(set) => &set.ties[i..],
        };
        let only_tied = matches!(self, Self::Tied(_));
        let (mut ties, mut row) = (ties.iter().peekable(), i);
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
        count,
        |i| among.from(i),
        |(j, known), before| {
            let hint = known.or(before);
            if let Some(point) = scene.laser_fixed_point(j) {
                let ray = scene.laser_point(j).map_or(Vector3::x(), |p| p.1);
                let gate = Gate {
                    sigmas: gate_sigmas,
                    largest_sigma_m: noise.point_m,
                    margin_m: (MARGIN_SIGMAS * noise.point_m).max(LEAST_MARGIN_M),
                };
                return (
                    j as u32,
                    Some(patches.assign(&point, &ray, &gate, hint, |_| noise.point_m)),
                );
            }
            let Some(pose) = scene.return_pose(j) else {
                return (j as u32, None);
            };
            let pose = association.pose(pose);
            let u = campaign.laser.point(j);
            let turned = campaign.scanner.rotation * u;
            let arm = turned + campaign.scanner.lever_arm_m;
            let point = pose.position_m + pose.rotation * arm;
            let own_m2 = noise.range_m.powi(2) + noise.angle_rad.powi(2) * u.norm_squared();
            let gate = gate(gate_sigmas, own_m2, spread_m2, &trajectory, &arm);
            let verdict =
                patches.assign(&point, &(pose.rotation * turned), &gate, hint, |normal| {
                    let partials = along_normal(&pose, &campaign.scanner, &u, normal);
                    (return_variance(noise, &u, &partials.sensor)
                        + trajectory.along(&partials.attitude))
                    .sqrt()
                });
            (j as u32, Some(verdict))
        },
    );
    if let Among::Tied(before) = among {
        set.reject_too(before);
    }
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
    rows: &[u32],
    model: &PlacedBy,
    association: &Association,
) -> TieSet {
    let mounting = &model.sensor.mounting;
    let campaign = scene.campaign;
    let gate_sigmas = association.gate_sigmas;
    let spread_m2 = TrajectoryVariance::new(&campaign.trajectory.noise, true).position_m2;
    let trajectory = association.variance(&campaign.trajectory.noise);
    let noise = &campaign.soundings.noise;
    let from = |i: usize| rows[i..].iter().copied();
    let mut set = collect(rows.len(), from, |row, before| {
        let k = row as usize;
        let Some((pose, beam)) = model.beam(scene, k) else {
            return (row, None);
        };
        let pose = association.pose(pose);
        let partials = beam.partials();
        let turned = mounting.rotation * partials.vector_m;
        let arm = turned + mounting.lever_arm_m;
        let point = pose.position_m + pose.rotation * arm;
        let swing_rad2 = noise.across_rad.powi(2) + noise.along_rad.powi(2);
        let own_m2 = noise.range_m.powi(2) + swing_rad2 * beam.range_m.powi(2);
        let gate = gate(gate_sigmas, own_m2, spread_m2, &trajectory, &arm);
        let verdict = patches.assign(&point, &(pose.rotation * turned), &gate, before, |normal| {
            let p = along_normal(&pose, mounting, &partials.vector_m, normal);
            let gain = partials.jacobian.tr_mul(&p.sensor);
            (sounding_variance(noise, &gain) + trajectory.along(&p.attitude)).sqrt()
        });
        (row, Some(verdict))
    });
    let far = campaign.soundings.len() - rows.len();
    *set.rejected.entry(NO_FACE).or_default() += far as u64;
    set.keep_true(scene.struck.map(|s| s.soundings.as_slice()));
    set
}

/// Ties the soundings in `rows` under a rough mounting, before anything is known of latency, range scale and trajectory errors.
#[must_use]
pub fn tie_soundings_first(
    scene: &Scene,
    patches: &Patches,
    rows: &[u32],
    mounting: &Mounting,
    gate_sigmas: f64,
) -> TieSet {
    let association = Association::before(gate_sigmas);
    let model = PlacedBy::mounting(*mounting);
    tie_soundings(scene, patches, rows, &model, &association)
}

const NO_FACE: &str = "no face within the gate";

/// Runs `judge` over `count` rows in parallel and sorts the verdicts, in order; `from(i)` gives the rows from the `i`-th on. The
/// judge is told the face of the last tie, where the next is likely to be.
fn collect<R, I: Iterator<Item = R>>(
    count: usize,
    from: impl Fn(usize) -> I + Sync,
    judge: impl Fn(R, Option<u16>) -> (u32, Option<Verdict>) + Sync,
) -> TieSet {
    let parts: Vec<TieSet> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|c| {
            let mut part = TieSet::default();
            let length = CHUNK.min(count - c * CHUNK);
            for row in from(c * CHUNK).take(length) {
                let before = part.ties.last().map(|t| t.face);
                part.file(judge(row, before));
            }
            part
        })
        .collect();
    let mut all = TieSet {
        ties: Vec::with_capacity(parts.iter().map(|p| p.ties.len()).sum()),
        ..TieSet::default()
    };
    for part in parts {
        all.reject_too(&part);
        all.ties.extend(part.ties);
    }
    all
}

impl TieSet {
    /// Counts the rejected rows of another set too.
    fn reject_too(&mut self, other: &Self) {
        for (reason, n) in &other.rejected {
            *self.rejected.entry(reason).or_default() += n;
        }
    }

    fn file(&mut self, (row, verdict): (u32, Option<Verdict>)) {
        let reason = match verdict {
            Some(Verdict::Tie(face)) => {
                self.ties.push(Tie { row, face });
                return;
            }
            Some(Verdict::NoFace) => NO_FACE,
            Some(Verdict::OutsideOutline) => "outside outline",
            Some(Verdict::Ambiguous) => "ambiguous",
            Some(Verdict::Obstacle) => "on an obstacle",
            None => "outside the trajectory",
        };
        *self.rejected.entry(reason).or_default() += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_counted_in_rows() {
        let set = |pairs: &[(u32, u16)]| TieSet {
            ties: pairs.iter().map(|&(row, face)| Tie { row, face }).collect(),
            ..TieSet::default()
        };
        let before = set(&[(1, 0), (2, 0), (5, 1)]);
        assert_eq!(before.changed_from(&before), 0);
        assert_eq!(set(&[(1, 0), (2, 3), (5, 1)]).changed_from(&before), 1);
        assert_eq!(
            set(&[(1, 0), (5, 1), (6, 1), (7, 1)]).changed_from(&before),
            2
        );
    }

    #[test]
    fn angle_noise_acts_across_the_ray_in_the_scan_plane() {
        let noise = LaserNoise {
            range_m: 0.005,
            angle_rad: 0.001,
            point_m: 0.0,
        };
        let u = Vector3::new(10.0, 0.0, 0.0);
        assert!((return_variance(&noise, &u, &Vector3::x()).sqrt() - 0.005).abs() < 1e-15);
        assert!((return_variance(&noise, &u, &Vector3::z()).sqrt() - 0.010).abs() < 1e-15);
        assert!(return_variance(&noise, &u, &Vector3::y()) < 1e-30);
    }
}
