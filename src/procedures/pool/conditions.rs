//! The joint conditions: every sounding and every return lies on the plane of its face (`docs/joint-path.md`).
//!
//! `g = n . ( p + dp + Exp(psi) R_b^t [ R u + l ] ) - d - h = 0`, linearised at the adjusted observations (Gauss-Helmert).

use std::ops::Range;

use nalgebra::{Matrix3, Matrix3x2, Vector3};

use super::doubts::Passes;
use super::judge::Cells;
use super::scene::Scene;
use super::ties::{
    Tie, TieSet, TrajectoryVariance, return_gain, return_product, sounding_variance,
    sounding_variances,
};
use crate::adjust::{BlockId, ChainRow, ChainState, Conditions, ParameterSet, Row, tangent_basis};
use crate::georef::{Beam, BeamPartials, effects};
use crate::observe::{Acts, MOST_EXTRAS, Mounting, PoseSample, Trajectory};

/// Where the unknown plane of a face lives in the parameters.
#[derive(Clone, Copy, Debug)]
pub struct FacePlane {
    /// Unit normal of the face's group.
    pub normal: BlockId,
    /// Distance of the group's plane from its design position, metres.
    pub distance: BlockId,
    /// The face's own offset, where it has a tolerance.
    pub offset: Option<BlockId>,
    /// Design offset along the group's normal, metres: the offset itself where it is exact.
    pub design_m: f64,
}

/// A face's plane at the current parameters, with what its derivatives need.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vector3<f64>,
    distance_m: f64,
    tangents: Matrix3x2<f64>,
    /// Columns of normal, distance and offset.
    columns: (usize, usize, Option<usize>),
}

impl FacePlane {
    fn at(&self, x: &ParameterSet) -> Plane {
        let own_m = self.offset.map_or(self.design_m, |id| x.euclidean(id)[0]);
        let normal = x.normal(self.normal);
        Plane {
            normal,
            distance_m: x.euclidean(self.distance)[0] + own_m,
            tangents: tangent_basis(&normal),
            columns: (
                x.offset(self.normal),
                x.offset(self.distance),
                self.offset.map(|id| x.offset(id)),
            ),
        }
    }
}

impl Plane {
    /// Appends the derivatives by the plane's parameters at the adjusted point.
    fn derive(&self, point_m: &Vector3<f64>, row: &mut Row) {
        let (normal, distance, offset) = self.columns;
        row.extend(normal, self.tangents.tr_mul(point_m).as_slice());
        row.push(distance, -1.0);
        if let Some(offset) = offset {
            row.push(offset, -1.0);
        }
    }
}

/// The planes at the current parameters, each looked up when a run of conditions on its face begins.
struct Planes<'a> {
    faces: &'a [Option<FacePlane>],
    x: &'a ParameterSet,
    last: Option<(u16, Plane)>,
}

impl<'a> Planes<'a> {
    fn new(faces: &'a [Option<FacePlane>], x: &'a ParameterSet) -> Self {
        Self {
            faces,
            x,
            last: None,
        }
    }

    fn of(&mut self, face: u16) -> Option<&Plane> {
        if self.last.as_ref().is_none_or(|(known, _)| *known != face) {
            self.last = Some((face, self.faces.get(face as usize)?.as_ref()?.at(self.x)));
        }
        self.last.as_ref().map(|(_, plane)| plane)
    }
}

/// What the conditions of one sensor share at some parameters: its mounting, and the planes.
pub(super) struct Eyes<'a> {
    mounting: Mounting,
    planes: Planes<'a>,
}

/// Where a mounting lives in the parameters.
#[derive(Clone, Copy, Debug)]
pub struct MountingBlocks {
    /// Rotation, left perturbation in the body.
    pub rotation: BlockId,
    /// Lever arm, metres.
    pub lever_arm: BlockId,
}

impl MountingBlocks {
    /// The mounting at the current parameters.
    #[must_use]
    pub fn at(&self, x: &ParameterSet) -> Mounting {
        let lever_arm_m = Vector3::from_column_slice(x.euclidean(self.lever_arm));
        Mounting {
            rotation: x.rotation(self.rotation),
            lever_arm_m,
        }
    }
}

/// How the conditions see the trajectory's errors.
#[derive(Clone, Copy, Debug)]
pub enum TrajectoryErrors<'a> {
    /// As states of the chain; the epoch of each record.
    States(&'a [u32]),
    /// As variance, added to each condition.
    Variance(TrajectoryVariance),
}

/// The body at one moment with the estimated errors of the trajectory applied.
struct Moment {
    position_m: Vector3<f64>,
    attitude_error: Vector3<f64>,
}

impl TrajectoryErrors<'_> {
    fn moment(
        &self,
        pose: &PoseSample,
        interval: Option<u32>,
        chain: Option<&ChainState>,
    ) -> Moment {
        let (Some(interval), Some(chain)) = (interval, chain) else {
            return Moment {
                position_m: pose.position_m,
                attitude_error: Vector3::zeros(),
            };
        };
        let y = chain.between(interval, pose.weight_before, 1.0 - pose.weight_before);
        Moment {
            position_m: pose.position_m + Vector3::new(y[0], y[1], y[2]),
            attitude_error: Vector3::new(y[3], y[4], y[5]),
        }
    }

    /// Chain interval that begins at a record.
    fn interval(&self, record: u32) -> Option<u32> {
        match self {
            Self::States(epochs) => epochs.get(record as usize).copied(),
            Self::Variance(_) => None,
        }
    }

    /// Completes a row: derivatives by the chain, or variance.
    fn finish(&self, sight: &Sight, weight_before: f64, row: &mut Row) {
        let (normal, attitude) = (&sight.normal, &sight.attitude);
        match (self, sight.interval) {
            (Self::Variance(variance), _) => row.variance += variance.along(attitude),
            (Self::States(_), Some(interval)) => {
                row.chain = Some(ChainRow {
                    interval,
                    weight0: weight_before,
                    weight1: 1.0 - weight_before,
                    visible: [
                        normal.x, normal.y, normal.z, attitude.x, attitude.y, attitude.z,
                    ],
                });
            }
            (Self::States(_), None) => {}
        }
    }
}

/// How the body moves in the target frame.
pub(super) struct Motion {
    /// Metres per second.
    pub(super) velocity: Vector3<f64>,
    /// Radians per second.
    pub(super) rate: Vector3<f64>,
}

/// Velocity and angular rate of the body in the target frame: over a quarter and half a second, so that the record noise stays
/// out, and extrapolated to none (Richardson), so that the body's waves are not flattened.
pub(super) fn motion(trajectory: &Trajectory, time_s: f64) -> Option<Motion> {
    let (near, far) = (
        moved(trajectory, time_s, 0.125)?,
        moved(trajectory, time_s, 0.25)?,
    );
    let to_none = |near: Vector3<f64>, far: Vector3<f64>| (near * 4.0 - far) / 3.0;
    Some(Motion {
        velocity: to_none(near.velocity, far.velocity),
        rate: to_none(near.rate, far.rate),
    })
}

/// The body's motion, worked out at the records and taken linearly between them: of the records about the last moment asked for it is known.
pub(super) struct Motions<'a> {
    trajectory: &'a Trajectory,
    about: Option<(u32, [Motion; 2])>,
}

impl<'a> Motions<'a> {
    pub(super) fn of(trajectory: &'a Trajectory) -> Self {
        Self {
            trajectory,
            about: None,
        }
    }

    /// The motion at a moment; `None` where the trajectory tells none.
    pub(super) fn at(&mut self, pose: &PoseSample) -> Option<Motion> {
        let record = pose.record;
        if self
            .about
            .as_ref()
            .is_none_or(|(known, _)| *known != record)
        {
            let times_s = self.trajectory.times_s().get(record as usize..)?;
            let [first_s, second_s, ..] = *times_s else {
                return None;
            };
            let about = [first_s, second_s].map(|time_s| motion(self.trajectory, time_s));
            let [Some(first), Some(second)] = about else {
                return None;
            };
            self.about = Some((record, [first, second]));
        }
        let (_, [before, after]) = self.about.as_ref()?;
        let (w0, w1) = (pose.weight_before, 1.0 - pose.weight_before);
        Some(Motion {
            velocity: before.velocity * w0 + after.velocity * w1,
            rate: before.rate * w0 + after.rate * w1,
        })
    }
}

/// Mean velocity and rate between `half_s` before and after; from the moment itself where the trajectory begins or ends.
fn moved(trajectory: &Trajectory, time_s: f64, half_s: f64) -> Option<Motion> {
    let at = |shift_s: f64| {
        let pose = trajectory.pose_at(time_s + shift_s);
        pose.map(|pose| (shift_s, pose))
    };
    let (begin_s, before) = at(-half_s).or_else(|_| at(0.0)).ok()?;
    let (end_s, after) = at(half_s).or_else(|_| at(0.0)).ok()?;
    let span_s = end_s - begin_s;
    let turn = crate::geometry::rotation::log(&(after.rotation * before.rotation.transpose()));
    (span_s > 0.0).then(|| Motion {
        velocity: (after.position_m - before.position_m) / span_s,
        rate: turn / span_s,
    })
}

/// Conditions of the soundings.
#[derive(Debug)]
pub struct SoundingConditions<'a> {
    /// The scene.
    pub scene: &'a Scene<'a>,
    /// Which sounding lies on which face.
    pub ties: &'a TieSet,
    /// Planes by face index; ties name only faces that have one.
    pub planes: &'a [Option<FacePlane>],
    /// The mounting sought.
    pub mounting: MountingBlocks,
    /// Latency of the time stamps, seconds.
    pub latency: Option<BlockId>,
    /// Scale of the ranges.
    pub range_scale: Option<BlockId>,
    /// Unknowns of the caller's own, in the order of the scene's.
    pub extras: &'a [BlockId],
    /// Latency (seconds) that decides which states a condition sees.
    pub latency_at_start_s: f64,
    /// Errors of the trajectory.
    pub trajectory: TrajectoryErrors<'a>,
    /// Observation group.
    pub group: u16,
    /// Cells of the tests of parts, and the passes they count.
    pub cells: Option<(Cells, &'a Passes)>,
}

impl SoundingConditions<'_> {
    fn latency_s(&self, x: &ParameterSet) -> f64 {
        self.latency.map_or(0.0, |id| x.euclidean(id)[0])
    }

    /// What one condition sees at these parameters.
    fn sight(
        &self,
        tie: Tie,
        Eyes { mounting, planes }: &mut Eyes,
        chain: Option<&ChainState>,
    ) -> Option<SoundingSight> {
        let x = planes.x;
        let plane = planes.of(tie.face)?;
        let latency_s = self.latency_s(x);
        let pose = self.scene.sounding_pose(tie.row as usize, latency_s)?;
        let seen = if latency_s == self.latency_at_start_s {
            pose
        } else {
            self.scene
                .sounding_pose(tie.row as usize, self.latency_at_start_s)?
        };
        let interval = self.trajectory.interval(seen.record);
        let scale = self.range_scale.map_or(0.0, |id| x.euclidean(id)[0]);
        let mut beam = self.scene.beam(tie.row as usize, &pose, mounting)?;
        beam.range_m *= 1.0 + scale;
        let lift_m = self.act(tie, x, &mut beam);
        let moment = self.trajectory.moment(&seen, interval, chain);
        let mut moment = Moment {
            position_m: pose.position_m + (moment.position_m - seen.position_m),
            ..moment
        };
        moment.position_m.z += lift_m;
        let mut sight = Sight::new(plane, &pose, moment, interval);
        let in_sensor = mounting.rotation.tr_mul(&sight.in_body);
        let base_m = sight.base_m(plane, mounting);
        let noise = self.scene.sounding_noise(tie.row as usize);
        let adjusted = adjust_beam(&beam, &noise, &in_sensor, base_m);
        sight.reach(mounting, &adjusted.partials.vector_m);
        Some(SoundingSight {
            by_range: in_sensor.dot(&adjusted.partials.vector_m) / (1.0 + scale),
            stamp_s: self.scene.campaign.soundings.at_s(tie.row as usize) - latency_s,
            weight_before: seen.weight_before,
            pose,
            sight,
            in_sensor,
            adjusted,
        })
    }

    /// What the caller's own unknowns make of a beam; by how much the sounding stands higher, metres.
    fn act(&self, tie: Tie, x: &ParameterSet, beam: &mut Beam) -> f64 {
        if self.extras.is_empty() {
            return 0.0;
        }
        let mut values = [0.0; MOST_EXTRAS];
        for (value, id) in values.iter_mut().zip(self.extras) {
            *value = x.euclidean(*id)[0];
        }
        effects::act(self.scene.extras, &values, tie.row as usize, beam)
    }

    /// Derivatives by the caller's own unknowns, at the adjusted observation.
    fn by_extras(&self, tie: Tie, seen: &SoundingSight, x: &ParameterSet, row: &mut Row) {
        let by_beam = seen.adjusted.partials.jacobian.tr_mul(&seen.in_sensor);
        for (extra, id) in self.scene.extras.iter().zip(self.extras) {
            let Some(derivative) = extra.at(tie.row as usize) else {
                continue;
            };
            let by_effect = match extra.acts {
                Acts::Up => seen.sight.normal.z,
                Acts::Range => by_beam.x,
                Acts::Across => by_beam.y,
                Acts::Along => by_beam.z,
            };
            row.push(x.offset(*id), by_effect * derivative);
        }
    }

    /// What the turn of two arrays has beyond that of one head; nothing of one head.
    fn turn_beyond(&self, tie: Tie, seen: &SoundingSight, mounting: &Mounting) -> Vector3<f64> {
        let beyond = self
            .scene
            .turn_of_arrays(tie.row as usize, &seen.pose, mounting);
        beyond.map_or_else(Vector3::zeros, |turn| turn.tr_mul(&seen.sight.normal))
    }

    fn fill(
        &self,
        tie: Tie,
        eyes: &mut Eyes,
        chain: Option<&ChainState>,
        row: &mut Row,
    ) -> Option<()> {
        let x = eyes.planes.x;
        let seen = self.sight(tie, eyes, chain)?;
        let sight = &seen.sight;
        row.misclosure = seen.adjusted.misclosure;
        row.variance = seen.adjusted.variance;
        let by_turn = sight.by_turn() + self.turn_beyond(tie, &seen, &eyes.mounting);
        row.extend(x.offset(self.mounting.rotation), by_turn.as_slice());
        row.extend(x.offset(self.mounting.lever_arm), sight.in_body.as_slice());
        eyes.planes.of(tie.face)?.derive(&sight.point_m, row);
        if let Some(id) = self.latency {
            let motion = motion(&self.scene.trajectory, seen.stamp_s)?;
            row.push(x.offset(id), sight.by_delay(&motion));
        }
        if let Some(id) = self.range_scale {
            // by the adjusted range: the measured one errs together with the misclosure
            row.push(x.offset(id), seen.by_range);
        }
        if !self.extras.is_empty() {
            self.by_extras(tie, &seen, x, row);
        }
        self.trajectory.finish(sight, seen.weight_before, row);
        Some(())
    }

    /// What the conditions share at these parameters.
    pub(super) fn eyes<'a>(&'a self, x: &'a ParameterSet) -> Eyes<'a> {
        Eyes {
            mounting: self.mounting.at(x),
            planes: Planes::new(self.planes, x),
        }
    }

    /// What condition `k` sees, for columns that the model has not.
    pub(super) fn seen(
        &self,
        k: usize,
        eyes: &mut Eyes,
        chain: Option<&ChainState>,
    ) -> Option<SoundingSight> {
        self.sight(self.ties.get(k)?, eyes, chain)
    }
}

/// The line from the body to a face's plane as one condition sees it, with the estimated errors of the trajectory applied.
pub(super) struct Sight {
    /// Orientation of the body as recorded.
    pub(super) rotation: Matrix3<f64>,
    moment: Moment,
    interval: Option<u32>,
    /// Normal of the plane, in the target frame.
    pub(super) normal: Vector3<f64>,
    /// The same in the body.
    pub(super) in_body: Vector3<f64>,
    /// `R_m u` at the adjusted observation, in the body.
    pub(super) turned: Vector3<f64>,
    /// Derivative by a turn of the body in the target frame.
    pub(super) attitude: Vector3<f64>,
    point_m: Vector3<f64>,
}

impl Sight {
    /// The direction of the plane; how far the sensor reaches is yet to come.
    fn new(plane: &Plane, pose: &PoseSample, moment: Moment, interval: Option<u32>) -> Self {
        let erring = plane.normal + plane.normal.cross(&moment.attitude_error);
        Self {
            rotation: pose.rotation,
            moment,
            interval,
            normal: plane.normal,
            in_body: pose.rotation.tr_mul(&erring),
            turned: Vector3::zeros(),
            attitude: Vector3::zeros(),
            point_m: Vector3::zeros(),
        }
    }

    /// Distance of the sensor's centre from the plane, metres.
    fn base_m(&self, plane: &Plane, mounting: &Mounting) -> f64 {
        plane.normal.dot(&self.moment.position_m) + self.in_body.dot(&mounting.lever_arm_m)
            - plane.distance_m
    }

    /// Places the adjusted observation, in the sensor's frame.
    fn reach(&mut self, mounting: &Mounting, u_m: &Vector3<f64>) {
        self.turned = mounting.rotation * u_m;
        let arm = self.rotation * (self.turned + mounting.lever_arm_m);
        let error = &self.moment.attitude_error;
        self.point_m = self.moment.position_m + arm + error.cross(&arm);
        self.attitude = arm.cross(&(self.normal + self.normal.cross(error)));
    }

    /// Derivative by a turn of the mounting in the body.
    pub(super) fn by_turn(&self) -> Vector3<f64> {
        self.turned.cross(&self.in_body)
    }

    /// Derivative by the delay of the stamps, metres per second.
    pub(super) fn by_delay(&self, motion: &Motion) -> f64 {
        -(self.normal.dot(&motion.velocity) + self.by_attitude_delay(motion))
    }

    /// Derivative by the delay of the attitude's records alone, metres per second.
    pub(super) fn by_attitude_delay(&self, motion: &Motion) -> f64 {
        self.attitude.dot(&motion.rate)
    }
}

/// A sounding's condition.
pub(super) struct SoundingSight {
    pub(super) sight: Sight,
    /// Normal of the plane in the sensor's frame.
    pub(super) in_sensor: Vector3<f64>,
    pub(super) adjusted: AdjustedBeam,
    /// Derivative by the scale of the range.
    pub(super) by_range: f64,
    /// When it was, seconds.
    pub(super) stamp_s: f64,
    /// Where the body was by then, as recorded.
    pub(super) pose: PoseSample,
    weight_before: f64,
}

/// A laser return's condition.
pub(super) struct ReturnSight {
    pub(super) sight: Sight,
    misclosure: f64,
    variance: f64,
    /// Derivative by the range.
    pub(super) by_range: f64,
    /// When it was, seconds.
    pub(super) stamp_s: f64,
    /// Where the body was by then, as recorded.
    pub(super) pose: PoseSample,
}

/// A beam at its adjusted observations.
pub(super) struct AdjustedBeam {
    misclosure: f64,
    variance: f64,
    pub(super) partials: BeamPartials,
    /// Change of range (metres), across and along angle (radians) that brought it onto the plane.
    pub(super) correction: Vector3<f64>,
}

/// Moves range and angles onto the plane `base + in_sensor . u = 0` by least squares and linearises there:
/// `w = f(l_adj) + B (l - l_adj)`, `m = B S B^T`.
fn adjust_beam(
    observed: &Beam,
    noise: &crate::observe::SonarNoise,
    in_sensor: &Vector3<f64>,
    base: f64,
) -> AdjustedBeam {
    let weights = sounding_variances(noise);
    let beam = observed.resolved();
    let mut partials = beam.partials();
    let mut gain = partials.jacobian.tr_mul(in_sensor);
    let mut variance = sounding_variance(noise, &gain);
    let mut misclosure = base + in_sensor.dot(&partials.vector_m);
    let mut correction = Vector3::zeros();
    for _ in 0..2 {
        correction = weights.component_mul(&gain) * (-misclosure / variance);
        partials = beam.moved(&correction).partials();
        gain = partials.jacobian.tr_mul(in_sensor);
        variance = sounding_variance(noise, &gain);
        misclosure = base + in_sensor.dot(&partials.vector_m) - gain.dot(&correction);
    }
    AdjustedBeam {
        misclosure,
        variance,
        partials,
        correction,
    }
}

impl Conditions for SoundingConditions<'_> {
    fn len(&self) -> usize {
        self.ties.len()
    }

    fn group(&self, _k: usize) -> u16 {
        self.group
    }

    fn cell(&self, k: usize) -> u16 {
        let (Some((cells, passes)), Some(tie)) = (self.cells, self.ties.get(k)) else {
            return self.group;
        };
        let time_s = self.scene.campaign.soundings.at_s(tie.row as usize);
        cells.number(self.group, passes.at(time_s), tie.face)
    }

    fn interval(&self, k: usize) -> Option<u32> {
        let row = self.ties.get(k)?.row as usize;
        let record = self.scene.sounding_record(row, self.latency_at_start_s)?;
        self.trajectory.interval(record)
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        self.linearise_range(k..k + 1, x, chain, std::slice::from_mut(row));
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        let mut eyes = self.eyes(x);
        for (tie, row) in self.ties.from(range.start).zip(rows) {
            row.clear();
            if self.fill(tie, &mut eyes, chain, row).is_none() {
                row.misclosure = f64::NAN;
            }
        }
    }
}

/// Conditions of the laser returns.
#[derive(Debug)]
pub struct ReturnConditions<'a> {
    /// The scene.
    pub scene: &'a Scene<'a>,
    /// Which return lies on which face.
    pub ties: &'a TieSet,
    /// Planes by face index.
    pub planes: &'a [Option<FacePlane>],
    /// The scanner's own mounting, where it is an unknown with a prior.
    pub scanner: Option<MountingBlocks>,
    /// Errors of the trajectory.
    pub trajectory: TrajectoryErrors<'a>,
    /// Observation group.
    pub group: u16,
    /// Cells of the tests of parts, and the passes they count.
    pub cells: Option<(Cells, &'a Passes)>,
}

impl ReturnConditions<'_> {
    fn fill(
        &self,
        tie: Tie,
        eyes: &mut Eyes,
        chain: Option<&ChainState>,
        row: &mut Row,
    ) -> Option<()> {
        let x = eyes.planes.x;
        if let Some(point) = self.scene.laser_fixed_point(tie.row as usize) {
            self.fill_fixed(&point, eyes.planes.of(tie.face)?, row);
            return Some(());
        }
        let seen = self.sight(tie, eyes, chain)?;
        let sight = &seen.sight;
        (row.misclosure, row.variance) = (seen.misclosure, seen.variance);
        eyes.planes.of(tie.face)?.derive(&sight.point_m, row);
        if let Some(blocks) = self.scanner {
            row.extend(x.offset(blocks.rotation), sight.by_turn().as_slice());
            row.extend(x.offset(blocks.lever_arm), sight.in_body.as_slice());
        }
        self.trajectory.finish(sight, seen.pose.weight_before, row);
        Some(())
    }

    /// What one condition sees at these parameters, of a return in the scanner's frame.
    fn sight(
        &self,
        tie: Tie,
        Eyes { mounting, planes }: &mut Eyes,
        chain: Option<&ChainState>,
    ) -> Option<ReturnSight> {
        let plane = planes.of(tie.face)?;
        let scan = &self.scene.campaign.laser;
        let pose = self.scene.return_pose(tie.row as usize)?;
        let interval = self.trajectory.interval(pose.record);
        let u = scan.point(tie.row as usize);
        let moment = self.trajectory.moment(&pose, interval, chain);
        let mut sight = Sight::new(plane, &pose, moment, interval);
        let in_sensor = mounting.rotation.tr_mul(&sight.in_body);
        let gain = return_gain(&scan.noise, &u, &in_sensor);
        let variance = gain.norm_squared();
        let misclosure = sight.base_m(plane, mounting) + in_sensor.dot(&u);
        let adjusted = u - return_product(&scan.noise, &u, &gain) * (misclosure / variance);
        sight.reach(mounting, &adjusted);
        Some(ReturnSight {
            by_range: in_sensor.dot(&adjusted) / adjusted.norm().max(1e-9),
            stamp_s: scan.time_s[tie.row as usize],
            pose,
            sight,
            misclosure,
            variance,
        })
    }

    /// What the conditions share at these parameters.
    pub(super) fn eyes<'a>(&'a self, x: &'a ParameterSet) -> Eyes<'a> {
        let stated = self.scene.campaign.scanner;
        Eyes {
            mounting: self.scanner.map_or(stated, |blocks| blocks.at(x)),
            planes: Planes::new(self.planes, x),
        }
    }

    /// What condition `k` sees, for columns that the model has not.
    pub(super) fn seen(
        &self,
        k: usize,
        eyes: &mut Eyes,
        chain: Option<&ChainState>,
    ) -> Option<ReturnSight> {
        self.sight(self.ties.get(k)?, eyes, chain)
    }

    /// A return that came already georeferenced: isotropic noise, no trajectory.
    fn fill_fixed(&self, point: &Vector3<f64>, plane: &Plane, row: &mut Row) {
        row.variance = self.scene.campaign.laser.noise.point_m.powi(2);
        row.misclosure = plane.normal.dot(point) - plane.distance_m;
        let adjusted = point - plane.normal * row.misclosure;
        plane.derive(&adjusted, row);
    }
}

impl Conditions for ReturnConditions<'_> {
    fn len(&self) -> usize {
        self.ties.len()
    }

    fn group(&self, _k: usize) -> u16 {
        self.group
    }

    fn cell(&self, k: usize) -> u16 {
        let (Some((cells, passes)), Some(tie)) = (self.cells, self.ties.get(k)) else {
            return self.group;
        };
        let time_s = self.scene.return_time_s(tie.row as usize);
        cells.number(self.group, passes.at(time_s), tie.face)
    }

    fn interval(&self, k: usize) -> Option<u32> {
        if !self.scene.laser_uses_trajectory() {
            return None;
        }
        let record = self.scene.return_record(self.ties.get(k)?.row as usize)?;
        self.trajectory.interval(record)
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        self.linearise_range(k..k + 1, x, chain, std::slice::from_mut(row));
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        let mut eyes = self.eyes(x);
        for (tie, row) in self.ties.from(range.start).zip(rows) {
            row.clear();
            if self.fill(tie, &mut eyes, chain, row).is_none() {
                row.misclosure = f64::NAN;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation::from_attitude;

    /// A boat that rolls and heaves once in five seconds, recorded ten times a second.
    fn rolling() -> Trajectory {
        let time_s: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        let phase = |t: &f64| std::f64::consts::TAU * t / 5.0;
        let position = |t: &f64| Vector3::new(0.0, 2.0 * t, 0.3 * crate::math::sin(phase(t)));
        let attitude = |t: &f64| from_attitude(0.1 * crate::math::cos(phase(t)), 0.0, 0.0);
        let (positions, attitudes) = (
            time_s.iter().map(position).collect(),
            time_s.iter().map(attitude).collect(),
        );
        Trajectory::new(time_s, positions, attitudes, None, 1.0)
    }

    /// At the records the motion is the one worked out there; half way between, the curvature of a wave of five seconds, `h^2 / 8 (2 pi / 5)^2`
    /// of its speed, is 0.2 %.
    #[test]
    fn motion_between_records_is_linear() {
        let trajectory = rolling();
        let mut motions = Motions::of(&trajectory);
        for (time_s, tolerance) in [(4.0, 1e-9), (4.05, 0.004), (6.0, 1e-9), (6.05, 0.004)] {
            let pose = trajectory.pose_at(time_s).expect("within");
            let found = motions.at(&pose).expect("a motion");
            let expected = motion(&trajectory, time_s).expect("a motion");
            let apart = (found.velocity - expected.velocity).norm();
            assert!(apart <= tolerance * 0.38, "{time_s} {apart}");
            let apart = (found.rate - expected.rate).norm();
            assert!(apart <= tolerance * 0.13, "{time_s} {apart}");
        }
    }
}
