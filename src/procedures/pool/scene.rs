//! The scene of a pool calibration: trajectory and laser points in the refined target frame, beams after refraction.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::frame::{self, LaserSample, turned};
use super::poses::Poses;
use super::rows::Rows;
use crate::geometry::ellipsoid::TargetPose;
use crate::georef::refraction::{Launch, Water as Refraction};
use crate::georef::{Beam, RayError, georeference, local_trajectory};
use crate::matching::{Movable, Patches, Registration, Sight, Water, register};
use crate::observe::{
    Campaign, Extra, LaserCoordinates, Mounting, PoseSample, SoundingRange, Struck, Trajectory,
};
use crate::target::{Outline, Target};

/// Points that the rough registrations use at the most.
const REGISTRATION_POINTS: usize = 2500;
/// Rows that are looked at to find them, when that is enough.
const LOOKED_AT: usize = 20_000;
/// What a nominal mounting displaces soundings by at the most, metres.
const FAR_OFF_M: f64 = 1.5;

/// Everything in the refined target frame.
#[derive(Debug)]
pub struct Scene<'a> {
    /// What was observed.
    pub campaign: &'a Campaign,
    /// The target at design dimensions.
    pub target: &'a Target,
    /// The refined pose of the target.
    pub pose: TargetPose,
    /// Refined origin in the prior target frame, metres.
    pub origin_shift_m: Vector3<f64>,
    /// Refined minus prior azimuth, radians.
    pub azimuth_shift_rad: f64,
    /// Trajectory in the refined target frame.
    pub trajectory: Trajectory,
    /// Rotation from the frame of already georeferenced laser points into the target frame, and the shift after it.
    laser_frame: Option<(Matrix3<f64>, Vector3<f64>)>,
    /// The water that travel times go through.
    pub(super) water: Option<Refraction>,
    /// Rows of the laser points by which the target was registered.
    pub registered: Vec<u32>,
    /// Sampled laser points near the target.
    pub laser_near: usize,
    /// Share of the sampled laser points near the target that lie on its faces.
    pub laser_fit: f64,
    /// What the reader of a report should know about the preparation.
    pub notes: Vec<String>,
    /// Where it is known (of a simulation, and only for an error budget): the face that each observation struck. Nothing is tied to
    /// another face then.
    pub struck: Option<&'a Struck>,
    /// Unknowns of the caller's own, of the joint paths.
    pub extras: &'a [Extra],
    /// Poses of the observations in the refined frame.
    poses: Poses,
}

impl<'a> Scene<'a> {
    /// Localises the trajectory, refines the target's pose from the laser points, converts travel times.
    ///
    /// # Errors
    /// [`RayError`] when the sound speed or its profile cannot be used.
    pub fn prepare(
        campaign: &'a Campaign,
        target: &'a Target,
        prior: &TargetPose,
    ) -> Result<Self, RayError> {
        let refraction = |speed| Refraction::new(speed, campaign.water_level_m);
        let water = campaign.sound_speed.as_ref().map(refraction).transpose()?;
        let local = local_trajectory(&campaign.trajectory, prior);
        let mut scene = Self {
            campaign,
            target,
            pose: *prior,
            origin_shift_m: Vector3::zeros(),
            azimuth_shift_rad: 0.0,
            trajectory: local.trajectory,
            laser_frame: laser_frame(campaign.laser.coordinates, prior),
            water,
            registered: vec![],
            laser_near: 0,
            laser_fit: 0.0,
            notes: local.note.into_iter().collect(),
            struck: None,
            extras: &[],
            poses: Poses::default(),
        };
        scene.refine_pose();
        scene.poses = Poses::kept(campaign, &scene.trajectory, scene.laser_uses_trajectory());
        Ok(scene)
    }

    /// Registers a sample of the laser points against the design faces and moves everything into the refined frame.
    fn refine_pose(&mut self) {
        let origins = self.origins(&self.campaign.scanner);
        let patches = Patches::new(
            self.target,
            Water::Above,
            self.campaign.water_level_m,
            &origins,
        );
        let reach_m = 2.0;
        self.registered = self.laser_sample(&patches, reach_m);
        let sample = LaserSample::of(self);
        self.laser_near = sample.len();
        if sample.is_empty() {
            return;
        }
        let sigma = frame::prior_sigma();
        let rough = register(
            &sample,
            &patches,
            &SVector::zeros(),
            &sigma,
            &[0.8, 0.4, 0.2],
        );
        let found = best_height(
            &sample,
            &patches,
            rough,
            2,
            &sigma,
            &[0.2, 0.1, 0.05, frame::LAST_WIDTH_M],
        );
        self.laser_fit = found.score / sample.len() as f64;
        let (shift, turn) = (
            found.parameters.fixed_rows::<3>(0).into_owned(),
            found.parameters[3],
        );
        let back = turned(turn).transpose();
        let moved = -(back * shift);
        self.trajectory = self.trajectory.transformed(&back, &moved);
        if let Some((rotation, offset)) = &mut self.laser_frame {
            *rotation = back * *rotation;
            *offset = back * *offset + moved;
        }
        self.pose = self.pose.moved(&shift, turn);
        (self.origin_shift_m, self.azimuth_shift_rad) = (shift, turn);
    }

    /// Return `j`: pose of the body (for returns in the sensor frame), point, and ray from the scanner; `None` outside the trajectory.
    #[must_use]
    pub fn laser_point(&self, j: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let raw = self.campaign.laser.point(j);
        if let Some((rotation, offset)) = &self.laser_frame {
            let point = rotation * raw + offset;
            return Some((point, point - self.seen_from(j, &point)?));
        }
        let pose = self.return_pose(j)?;
        let point = georeference(&pose, &self.campaign.scanner, &raw);
        Some((
            point,
            pose.rotation * (self.campaign.scanner.rotation * raw),
        ))
    }

    /// Where the body was when it saw a georeferenced point: at the return's time, or where the trajectory does not cover it, at the
    /// nearest of a few hundred places along the trajectory.
    fn seen_from(&self, j: usize, point: &Vector3<f64>) -> Option<Vector3<f64>> {
        if let Some(pose) = self.return_pose(j) {
            return Some(pose.position_m);
        }
        let positions = self.trajectory.positions_m();
        let stride = (positions.len() / 300).max(1);
        let away = |p: &&Vector3<f64>| (point - **p).norm_squared();
        let nearer = |a: &&Vector3<f64>, b: &&Vector3<f64>| away(a).total_cmp(&away(b));
        positions.iter().step_by(stride).min_by(nearer).copied()
    }

    /// Whether laser points come through the trajectory (sensor frame) rather than already georeferenced.
    #[must_use]
    pub fn laser_uses_trajectory(&self) -> bool {
        self.laser_frame.is_none()
    }

    /// Coordinates of return `j` in the target frame where it came already georeferenced.
    #[must_use]
    pub fn laser_fixed_point(&self, j: usize) -> Option<Vector3<f64>> {
        let (rotation, offset) = self.laser_frame.as_ref()?;
        Some(rotation * self.campaign.laser.point(j) + offset)
    }

    /// Beam of sounding `k`: as observed where ranges or one sound speed are given, after refraction through a profile otherwise; of two
    /// arrays the beam of the mounting that stands for both.
    #[must_use]
    pub fn beam(&self, k: usize, pose: &PoseSample, mounting: &Mounting) -> Option<Beam> {
        let s = &self.campaign.soundings;
        if let Some(arrays) = &s.arrays {
            return self.array_beam(arrays, k, pose, mounting);
        }
        let [across_rad, along_rad, range] = s.measured(k);
        match &s.range {
            SoundingRange::Metres(_) => Some(Beam {
                range_m: range,
                across_rad,
                along_rad,
            }),
            SoundingRange::TwoWayTravelTime(_) => {
                let launch = Launch {
                    across_rad,
                    along_rad,
                    two_way_s: range,
                };
                self.water.as_ref()?.refract(&launch, pose, mounting).ok()
            }
        }
    }

    /// Pose of the body at the time of sounding `k`, less the latency; `None` outside the trajectory.
    #[must_use]
    pub fn sounding_pose(&self, k: usize, latency_s: f64) -> Option<PoseSample> {
        let kept = self.poses.of_sounding(k).filter(|_| latency_s == 0.0);
        kept.unwrap_or_else(|| {
            let moment_s = self.campaign.soundings.at_s(k) - latency_s;
            self.poses.again(&self.trajectory, moment_s)
        })
    }

    /// Record of the trajectory before the time of sounding `k`, less the latency; `None` outside the trajectory.
    #[must_use]
    pub fn sounding_record(&self, k: usize, latency_s: f64) -> Option<u32> {
        let kept = self.poses.of_sounding(k).filter(|_| latency_s == 0.0);
        kept.map_or_else(
            || self.record_before(self.campaign.soundings.at_s(k) - latency_s),
            |pose| Some(pose?.record),
        )
    }

    /// Record of the trajectory before the time of return `j`; `None` outside the trajectory.
    #[must_use]
    pub fn return_record(&self, j: usize) -> Option<u32> {
        let kept = self.poses.of_return(j);
        kept.map_or_else(
            || self.record_before(self.campaign.laser.time_s[j]),
            |pose| Some(pose?.record),
        )
    }

    fn record_before(&self, time_s: f64) -> Option<u32> {
        let record = self.trajectory.record_before(time_s).ok()?;
        Some(record as u32)
    }

    /// Time of return `j`, seconds; zero where returns came without one.
    #[must_use]
    pub fn return_time_s(&self, j: usize) -> f64 {
        self.campaign.laser.time_s.get(j).copied().unwrap_or(0.0)
    }

    /// Pose of the body at the time of return `j`; `None` outside the trajectory.
    #[must_use]
    pub fn return_pose(&self, j: usize) -> Option<PoseSample> {
        let moment = || self.campaign.laser.time_s[j];
        let kept = self.poses.of_return(j);
        kept.unwrap_or_else(|| self.trajectory.pose_at(moment()).ok())
    }

    /// Positions of a sensor along the trajectory, a few hundred at the most.
    #[must_use]
    pub fn origins(&self, mounting: &Mounting) -> Vec<Vector3<f64>> {
        let stride = (self.trajectory.len() / 300).max(1);
        let (positions, attitudes) = (self.trajectory.positions_m(), self.trajectory.attitudes());
        (0..self.trajectory.len())
            .step_by(stride)
            .map(|k| positions[k] + attitudes[k] * mounting.lever_arm_m)
            .collect()
    }

    /// Evenly chosen laser points within `reach_m` of the target's box.
    fn laser_sample(&self, patches: &Patches, reach_m: f64) -> Vec<u32> {
        let near = |j: usize| {
            self.laser_point(j)
                .is_some_and(|(p, _)| patches.near_box(&p, reach_m))
        };
        sampled(self.campaign.laser.len(), near).0
    }

    /// Heights of laser returns on the target's design faces, above the water and below, by up to 0.3 m off them; evenly chosen.
    #[must_use]
    pub fn return_heights_m(&self) -> Vec<f64> {
        let point = |j: usize| self.laser_point(j).map(|(point, _)| point);
        let step = self.campaign.laser.len().div_ceil(HEIGHTS).max(1);
        let points = (0..self.campaign.laser.len())
            .step_by(step)
            .filter_map(point);
        self.heights_on_target_m(points)
    }

    /// The same of soundings under a mounting.
    #[must_use]
    pub fn sounding_heights_m(&self, mounting: &Mounting) -> Vec<f64> {
        let point = |k: usize| {
            let pose = self.sounding_pose(k, 0.0)?;
            let beam = self.beam(k, &pose, mounting)?;
            Some(georeference(&pose, mounting, &beam.vector_m()))
        };
        let count = self.campaign.soundings.len();
        let rows = (0..count).step_by(count.div_ceil(HEIGHTS).max(1));
        self.heights_on_target_m(rows.filter_map(point))
    }

    fn heights_on_target_m(&self, points: impl Iterator<Item = Vector3<f64>>) -> Vec<f64> {
        let holds = |outline: &Outline, point: &Vector3<f64>| {
            let off_m = outline.normal.dot(&(point - outline.vertices_m[0]));
            off_m.abs() < NEAR_FACE_M && outline.inside_m(point) > 0.0
        };
        let on_target = |point: &Vector3<f64>| {
            let mut faces = self.target.faces.iter();
            faces.any(|face| holds(&face.outline, point))
        };
        points.filter(on_target).map(|point| point.z).collect()
    }

    /// Soundings that could lie on the target if the mounting were wrong by up to `reach_m`, in order.
    #[must_use]
    pub fn soundings_near(&self, patches: &Patches, mounting: &Mounting, reach_m: f64) -> Rows {
        let near = |k: usize| self.is_near(k, patches, mounting, reach_m);
        Rows::chosen(self.campaign.soundings.len(), near)
    }

    fn is_near(&self, k: usize, patches: &Patches, mounting: &Mounting, reach_m: f64) -> bool {
        let point = self.sounding_pose(k, 0.0).and_then(|pose| {
            let beam = self.beam(k, &pose, mounting)?;
            Some(georeference(&pose, mounting, &beam.vector_m()))
        });
        point.is_some_and(|p| patches.near_box(&p, reach_m))
    }

    /// Evenly chosen soundings near the target under a mounting that may be far off, and how many there are.
    fn sonar_sample(&self, patches: &Patches, mounting: &Mounting) -> (Vec<u32>, usize) {
        let near = |k: usize| self.is_near(k, patches, mounting, FAR_OFF_M);
        sampled(self.campaign.soundings.len(), near)
    }

    /// Rough mounting of the sounder from a sample of its soundings, and the share of the sample that fits.
    #[must_use]
    pub fn rough_mounting(&self) -> RoughMounting {
        let nominal = &self.campaign.sonar;
        let patches = Patches::new(
            self.target,
            Water::Below,
            self.campaign.water_level_m,
            &self.origins(nominal),
        );
        let (chosen, near) = self.sonar_sample(&patches, nominal);
        let sample = SonarSample::new(self, &chosen, nominal);
        let sigma = rough_sigma();
        let rough = register(
            &sample,
            &patches,
            &SVector::zeros(),
            &sigma,
            &[1.0, 0.6, 0.35, 0.2],
        );
        let found = best_height(&sample, &patches, rough, 5, &sigma, &[0.2, 0.1, 0.05]);
        let delta = found.parameters.fixed_rows::<3>(0).into_owned();
        let arm = found.parameters.fixed_rows::<3>(3).into_owned();
        let fit = found.score / sample.len().max(1) as f64;
        let mirrored = (fit < DOUBTFUL_FIT)
            .then(|| self.mirrored_fit(&patches))
            .flatten();
        RoughMounting {
            mounting: nominal.corrected(&delta, &arm),
            near,
            fit,
            mirrored,
        }
    }

    /// Share of soundings that would fit if the across-track angles had the other sign.
    fn mirrored_fit(&self, patches: &Patches) -> Option<(&'static str, f64)> {
        let nominal = &self.campaign.sonar;
        let flip = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
        let mirrored = Mounting {
            rotation: nominal.rotation * flip,
            ..*nominal
        };
        let (chosen, _) = self.sonar_sample(patches, &mirrored);
        let sample = SonarSample::new(self, &chosen, &mirrored);
        if sample.is_empty() {
            return None;
        }
        let found = register(
            &sample,
            patches,
            &SVector::zeros(),
            &rough_sigma(),
            &[1.0, 0.6, 0.35, 0.2, 0.1, 0.05],
        );
        Some(("the across-track angle", found.score / sample.len() as f64))
    }
}

/// A point so near to a design face lies on it, metres.
const NEAR_FACE_M: f64 = 0.3;
/// Heights that are looked at, at the most.
const HEIGHTS: usize = 5000;

/// What a nominal mounting may be wrong by, one sigma: 5 degrees and 0.4 m.
fn rough_sigma() -> SVector<f64, 6> {
    SVector::from([0.09, 0.09, 0.09, 0.4, 0.4, 0.4])
}

/// Below this share of fitting soundings a mirrored axis is tried.
const DOUBTFUL_FIT: f64 = 0.15;

/// What the rough registration of the soundings found.
#[derive(Clone, Copy, Debug)]
pub struct RoughMounting {
    /// The mounting.
    pub mounting: Mounting,
    /// Soundings near the target under the nominal mounting; in a large survey judged by an even sample of them.
    pub near: usize,
    /// Share of the sample that lies on the target's faces.
    pub fit: f64,
    /// What was mirrored, and the share that fits then; only tried when the fit is poor.
    pub mirrored: Option<(&'static str, f64)>,
}

/// Heights that are tried beside the one found: blocks repeat, so a registration may have locked one block too high or low.
const HEIGHT_STEP_M: f64 = 0.1;
const HEIGHT_REACH: i32 = 12;

/// Scans the vertical parameter for a better fit and finishes the registration there.
fn best_height<const D: usize>(
    points: &impl Movable<D>,
    patches: &Patches,
    rough: Registration<D>,
    vertical: usize,
    sigma: &SVector<f64, D>,
    widths_m: &[f64],
) -> Registration<D> {
    let here = register(points, patches, &rough.parameters, sigma, widths_m);
    let scan = |k: i32| {
        let mut start = here.parameters;
        start[vertical] += f64::from(k) * HEIGHT_STEP_M;
        (crate::matching::score(points, patches, &start, 0.1), start)
    };
    let (_, start) = (-HEIGHT_REACH..=HEIGHT_REACH)
        .filter(|k| k.abs() >= 3)
        .map(scan)
        .fold((0.0, here.parameters), |best, trial| {
            if trial.0 > best.0 { trial } else { best }
        });
    let there = register(points, patches, &start, sigma, widths_m);
    if there.score > here.score {
        there
    } else {
        here
    }
}

/// Evenly chosen rows for a registration among those for which `keep` holds, and how many hold. Of many rows only every so many
/// are looked at, if that yields enough; their number is then a multiple.
fn sampled(count: usize, keep: impl Fn(usize) -> bool + Sync) -> (Vec<u32>, usize) {
    let stride = count / LOOKED_AT;
    if stride > 1 {
        let some = Rows::chosen(count / stride, |k| keep(k * stride));
        if some.len() >= REGISTRATION_POINTS {
            let mut rows = some.thinned(REGISTRATION_POINTS);
            rows.iter_mut().for_each(|k| *k *= stride as u32);
            return (rows, some.len() * stride);
        }
    }
    let all = Rows::chosen(count, keep);
    (all.thinned(REGISTRATION_POINTS), all.len())
}

fn laser_frame(
    coordinates: LaserCoordinates,
    pose: &TargetPose,
) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    match coordinates {
        LaserCoordinates::Sensor => None,
        LaserCoordinates::Target => Some((Matrix3::identity(), Vector3::zeros())),
        LaserCoordinates::Geocentric => {
            let back = pose.ecef_from_target().inverse();
            Some((back.rotation.matrix, back.translation.coordinates))
        }
    }
}

/// Soundings that move with the mounting: rotation vector (pitch, roll, yaw) and lever arm correction.
struct SonarSample {
    poses: Vec<PoseSample>,
    /// `R_nominal u` in the body, metres.
    arms: Vec<Vector3<f64>>,
    lever_arm_m: Vector3<f64>,
}

impl SonarSample {
    fn new(scene: &Scene, rows: &[u32], nominal: &Mounting) -> Self {
        let pairs = rows.iter().filter_map(|&k| {
            let pose = scene.sounding_pose(k as usize, 0.0)?;
            let beam = scene.beam(k as usize, &pose, nominal)?;
            Some((pose, nominal.rotation * beam.vector_m()))
        });
        let (poses, arms) = pairs.unzip();
        Self {
            poses,
            arms,
            lever_arm_m: nominal.lever_arm_m,
        }
    }
}

impl Movable<6> for SonarSample {
    fn len(&self) -> usize {
        self.poses.len()
    }

    fn sight(&self, k: usize, parameters: &SVector<f64, 6>) -> Sight<6> {
        use crate::geometry::rotation::{exp, skew};
        let pose = &self.poses[k];
        let delta = parameters.fixed_rows::<3>(0).into_owned();
        let arm = exp(&delta) * self.arms[k];
        let lever = self.lever_arm_m + parameters.fixed_rows::<3>(3);
        let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
        jacobian
            .fixed_columns_mut::<3>(0)
            .copy_from(&(-(pose.rotation * skew(&arm))));
        jacobian.fixed_columns_mut::<3>(3).copy_from(&pose.rotation);
        let ray = pose.rotation * arm;
        Sight {
            point_m: pose.position_m + ray + pose.rotation * lever,
            ray,
            jacobian,
        }
    }
}
