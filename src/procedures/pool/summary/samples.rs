//! Decimated points for the report's pictures.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::super::run::PoolOutcome;
use super::super::ties::{PlacedBy, Tie, TieSet, TrajectoryVariance, sounding_variance};
use super::residuals::{Residuals, Sums, sounding_point};
use super::sample_types::{
    FaceSample, FaceStatistics, PerPath, ReportSamples, ReturnSample, SoundingSample,
};
use crate::adjust::{Process, ProcessKind, VISIBLE};
use crate::georef::along_normal;
use crate::observe::Mounting;
use crate::results::DriftSample;
use crate::target::Role;

/// Most tied soundings or returns that are shown, and most of the others.
const MOST_TIED: usize = 20_000;
const MOST_OTHERS: usize = 10_000;
/// Most points of a trajectory's polyline.
const MOST_TRACK: usize = 500;

/// Samples of an outcome.
#[must_use]
pub fn samples(outcome: &PoolOutcome) -> ReportSamples {
    let residuals = Residuals::of(outcome);
    ReportSamples {
        water_level_m: Some(outcome.scene.campaign.water_level_m),
        faces: faces(outcome),
        soundings: soundings(outcome, &residuals),
        returns: returns(outcome, &residuals),
        trajectory_m: tracks(outcome),
        face_statistics: statistics(outcome, &residuals),
        drift: drift(outcome).unwrap_or_default(),
    }
}

/// A curve of the drift is broken where no observation hangs on the records for longer, seconds.
const DRIFT_GAP_S: f64 = 2.0;

/// What drifts, by the number of its component: the place in the target frame, and turns about its axes.
const DRIFTS: [&str; VISIBLE] = [
    "through the wall, away from the boat",
    "along the wall",
    "up",
    "turn about the axis through the wall",
    "turn about the axis along the wall",
    "heading, counter-clockwise",
];

/// The drift that the joint path estimates along; nothing where it has none or no usable result.
fn drift(outcome: &PoolOutcome) -> Option<Vec<DriftSample>> {
    let joint = outcome.joint.as_ref()?;
    let (model, state) = (
        joint.chain.as_ref()?,
        joint.solution.estimate.chain.as_ref()?,
    );
    let begin_s = *model.times_s().first()?;
    let times: Vec<(usize, f64)> = model.times_s().iter().copied().enumerate().collect();
    let of = |(place, process): (usize, &Process)| {
        let value = |&(epoch, time_s): &(usize, f64)| [time_s - begin_s, state.state(epoch)[place]];
        let parts = times.chunk_by(|a, b| b.1 - a.1 <= DRIFT_GAP_S);
        let parts = parts.map(|part| part.iter().map(value).collect());
        let (name, angle) = (DRIFTS[process.component], process.component > 2);
        DriftSample::new(name, angle, process.sigma, parts.collect())
    };
    let processes = model.processes().iter().enumerate();
    let slow = processes.filter(|(_, p)| p.kind != ProcessKind::White);
    Some(slow.filter(|_| outcome.refusal.is_none()).map(of).collect())
}

fn faces(outcome: &PoolOutcome) -> Vec<FaceSample> {
    let level_m = outcome.scene.campaign.water_level_m;
    let sample = |face: &crate::target::Face| FaceSample {
        name: face.name.clone(),
        role: role(face.role).to_owned(),
        vertices_m: face
            .outline
            .vertices_m
            .iter()
            .map(|v| (*v).into())
            .collect(),
        above_water: face.outline.vertices_m.iter().any(|v| v.z > level_m),
    };
    outcome.scene.target.faces.iter().map(sample).collect()
}

fn role(role: Role) -> &'static str {
    match role {
        Role::P1 => "P1",
        Role::P2 => "P2",
        Role::P3 => "P3",
        Role::Horizontal => "horizontal",
        Role::Other | Role::Obstacle => "other",
    }
}

/// Rows to show, ascending: some of those tied, with their tie, and some of the others.
fn chosen(rows: usize, ties: &TieSet) -> Vec<(usize, Option<Tie>)> {
    let shown = ties.len().min(MOST_TIED);
    let tied = (0..shown).filter_map(|k| ties.get(k * ties.len() / shown));
    let mut both: Vec<_> = tied.map(|t| (t.row as usize, Some(t))).collect();
    let others = rows.saturating_sub(ties.len());
    let mut tied = ties.iter().map(|t| t.row as usize).peekable();
    let untied = (0..rows).filter(|row| tied.next_if_eq(row).is_none());
    let stride = others.div_ceil(MOST_OTHERS).max(1);
    both.extend(untied.step_by(stride).map(|row| (row, None)));
    both.sort_unstable_by_key(|(row, _)| *row);
    both
}

/// At most `most` of the items, evenly.
fn thinned<T: Copy>(items: &[T], most: usize) -> Vec<T> {
    let n = items.len().min(most);
    (0..n).map(|k| items[k * items.len() / n]).collect()
}

fn soundings(outcome: &PoolOutcome, residuals: &Residuals) -> Vec<SoundingSample> {
    let nominal = PlacedBy::mounting(outcome.scene.campaign.sonar);
    let sample = |(row, tie): &(usize, Option<Tie>)| {
        let place =
            |model: Option<PlacedBy>| model.and_then(|m| sounding_point(&outcome.scene, *row, &m));
        let models = &residuals.models;
        let at = each(models, |m| place(Some(*m)));
        let off = |p: &Vector3<f64>| {
            tie.and_then(|t| Some(residuals.faces[t.face as usize]?.distance_m(p)))
        };
        let before = place(Some(nominal))?;
        let mounting = models
            .joint
            .or(models.reference)
            .unwrap_or(nominal)
            .sensor
            .mounting;
        let pose = outcome.scene.sounding_pose(*row, 0.0)?;
        Some(SoundingSample {
            nominal_m: before.into(),
            position_m: each(&at, |p| Some((*p).into())),
            face: tie.map(|t| u32::from(t.face)),
            nominal_residual_m: off(&before),
            residual_m: each(&at, off),
            used: tie.is_some(),
            across_deg: outcome.scene.campaign.soundings.measured(*row)[0].to_degrees(),
            range_m: outcome.scene.beam(*row, &pose, &mounting)?.range_m,
            time_s: outcome.scene.campaign.soundings.at_s(*row),
            stated_sigma_m: tie.and_then(|t| {
                let plane = residuals.faces[t.face as usize]?;
                stated_sigma_m(outcome, *row, &mounting, &plane.normal)
            }),
        })
    };
    let rows = chosen(outcome.scene.campaign.soundings.len(), &residuals.ties);
    rows.par_iter().filter_map(sample).collect()
}

/// What the survey's noise figures make of a sounding's distance along a normal: the beam's own noise and the INS's, drift included.
fn stated_sigma_m(
    outcome: &PoolOutcome,
    row: usize,
    mounting: &Mounting,
    normal: &Vector3<f64>,
) -> Option<f64> {
    let scene = &outcome.scene;
    let pose = scene.sounding_pose(row, 0.0)?;
    let partials = scene.beam(row, &pose, mounting)?.partials();
    let along = along_normal(&pose, mounting, &partials.vector_m, normal);
    let gain = partials.jacobian.tr_mul(&along.sensor);
    let own_m2 = sounding_variance(&scene.sounding_noise(row), &gain);
    let of_ins = TrajectoryVariance::new(&scene.campaign.trajectory.noise, true);
    Some((own_m2 + of_ins.along(&along.attitude)).sqrt())
}

/// Applies `f` to the value of each path.
fn each<T, U>(paths: &PerPath<T>, f: impl Fn(&T) -> Option<U>) -> PerPath<U> {
    PerPath {
        reference: paths.reference.as_ref().and_then(&f),
        joint: paths.joint.as_ref().and_then(&f),
        joint_simple: paths.joint_simple.as_ref().and_then(&f),
    }
}

fn returns(outcome: &PoolOutcome, residuals: &Residuals) -> Vec<ReturnSample> {
    let sample = |(row, tie): &(usize, Option<Tie>)| {
        let (point, _) = outcome.scene.laser_point(*row)?;
        Some(ReturnSample {
            position_m: point.into(),
            face: tie.map(|t| u32::from(t.face)),
            residual_m: tie
                .and_then(|t| Some(residuals.faces[t.face as usize]?.distance_m(&point))),
            used: tie.is_some(),
        })
    };
    let rows = chosen(
        outcome.scene.campaign.laser.len(),
        super::returns_of(outcome),
    );
    rows.par_iter().filter_map(sample).collect()
}

/// INS positions, a polyline for each part of the trajectory without a gap.
fn tracks(outcome: &PoolOutcome) -> Vec<Vec<[f64; 3]>> {
    let trajectory = &outcome.scene.trajectory;
    let gap_s = outcome.scene.campaign.trajectory.max_gap_s;
    let (times, positions) = (trajectory.times_s(), trajectory.positions_m());
    let mut begin = 0;
    let mut parts = vec![];
    for end in 1..=times.len() {
        if end == times.len() || times[end] - times[end - 1] > gap_s {
            parts.push(
                thinned(&positions[begin..end], MOST_TRACK)
                    .iter()
                    .map(|p| (*p).into())
                    .collect(),
            );
            begin = end;
        }
    }
    parts
}

fn statistics(outcome: &PoolOutcome, residuals: &Residuals) -> Vec<FaceStatistics> {
    let sums = each(&residuals.models, |m| Some(residuals.sums(outcome, m)));
    let of = |face: usize, f: &dyn Fn(&Sums) -> Option<f64>| each(&sums, |all| f(&all[face]));
    let count = |face: usize| residuals.ties.count(|f| f == face) as u64;
    (0..outcome.scene.target.faces.len())
        .filter(|&face| count(face) > 0)
        .map(|face| FaceStatistics {
            face: face as u32,
            soundings: count(face),
            mean_m: of(face, &Sums::mean),
            rms_m: of(face, &Sums::rms),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_shown_once_in_order_with_their_ties() {
        let tie = |k: u32| Tie {
            row: 2 * k,
            face: 3,
        };
        let ties = TieSet::of_ties(100_000, (0..50_000).map(tie));
        let rows = chosen(100_000, &ties);
        assert_eq!(rows.len(), MOST_TIED + MOST_OTHERS);
        assert!(rows.windows(2).all(|w| w[0].0 < w[1].0));
        assert!(
            rows.iter()
                .all(|(row, tie)| tie.is_some() == (row % 2 == 0))
        );
        assert!(thinned::<u8>(&[], 5).is_empty());
    }
}
