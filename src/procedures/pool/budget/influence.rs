//! From an error source to bias and covariance of the six parameters, through the pulls of one path.
//!
//! Every source moves the points along the normals of their faces by `eps = (d eps / d source) source`; the pulls
//! ([`crate::procedures::pool::influence`]) turn that into parameters: `dm = sum_k c_k eps_k`. What remains is statistics, linear in
//! the number of observations: independent noise adds squares, errors of a trajectory record are gathered over both sensors first,
//! a Gauss-Markov process is summed by the recursion that generates it, and a constant moves along one direction.

use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector2, Vector3, Vector6};

use super::records::Records;
use crate::geometry::rotation;
use crate::georef::refraction::{Launch, Water};
use crate::georef::{NormalPartials, along_normal};
use crate::observe::{
    LaserNoise, Mounting, PoseSample, SoundSpeed, SoundSpeedProfile, SoundingRange,
};
use crate::procedures::pool::Scene;
use crate::procedures::pool::influence::{Pull, Pulls};
use crate::procedures::pool::ties::return_gain;

/// Where an observation's point lies and how it moves along the normal of its face.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Row of the raw observation.
    pub row: u32,
    /// Face that it is tied to.
    pub face: u16,
    /// Pull on the six parameters per metre along the normal.
    pub six: Vector6<f64>,
    /// Body at its moment.
    pub pose: PoseSample,
    /// Derivatives of its place along the normal.
    pub along: NormalPartials,
    /// Derivatives by its own measurements: range, across angle, along angle (metres per metre and per radian); for a return range
    /// and angle in the scanner's plane, the third is 0.
    pub gain: Vector3<f64>,
    /// Measured range, metres.
    pub range_m: f64,
    /// Across angle of a sounding, radians.
    pub across_rad: f64,
}

/// One path's observations in an error-free scene.
#[derive(Debug)]
pub struct View<'a> {
    scene: &'a Scene<'a>,
    sonar: Mounting,
    normals: &'a [Option<Vector3<f64>>],
    turns: &'a [Matrix6x3<f64>],
    /// Soundings, in order of time.
    pub soundings: Vec<Seen>,
    /// Laser returns, in order of time.
    pub returns: Vec<Seen>,
}

/// Covariance that two errors of one source leave: `c c^T`.
pub(super) fn square(c: &Vector6<f64>) -> Matrix6<f64> {
    c * c.transpose()
}

impl<'a> View<'a> {
    /// The observations of a path, under the true mounting; `normals` by face.
    #[must_use]
    pub fn new(
        scene: &'a Scene<'a>,
        sonar: Mounting,
        normals: &'a [Option<Vector3<f64>>],
        pulls: &'a Pulls,
    ) -> Self {
        let mut view = Self {
            scene,
            sonar,
            normals,
            turns: &pulls.turns,
            soundings: vec![],
            returns: vec![],
        };
        view.soundings = pulls
            .soundings
            .iter()
            .filter_map(|p| view.sounding(p))
            .collect();
        view.returns = pulls.returns.iter().filter_map(|p| view.laser(p)).collect();
        view
    }

    fn normal(&self, face: u16) -> Option<Vector3<f64>> {
        *self.normals.get(face as usize)?
    }

    fn sounding(&self, pull: &Pull) -> Option<Seen> {
        let pose = self.scene.sounding_pose(pull.row as usize, 0.0)?;
        let beam = self.scene.beam(pull.row as usize, &pose, &self.sonar)?;
        let partials = beam.partials();
        let normal = self.normal(pull.face)?;
        let along = along_normal(&pose, &self.sonar, &partials.vector_m, &normal);
        Some(Seen {
            row: pull.row,
            face: pull.face,
            six: pull.six,
            pose,
            along,
            gain: partials.jacobian.tr_mul(&along.sensor),
            range_m: beam.range_m,
            across_rad: beam.across_rad,
        })
    }

    fn laser(&self, pull: &Pull) -> Option<Seen> {
        let campaign = self.scene.campaign;
        let time_s = campaign.laser.time_s[pull.row as usize];
        let pose = self.scene.trajectory.pose_at(time_s).ok()?;
        let u = campaign.laser.point(pull.row as usize);
        let along = along_normal(&pose, &campaign.scanner, &u, &self.normal(pull.face)?);
        let unit = LaserNoise {
            range_m: 1.0,
            angle_rad: 1.0,
            point_m: 0.0,
        };
        let gain: Vector2<f64> = return_gain(&unit, &u, &along.sensor);
        Some(Seen {
            row: pull.row,
            face: pull.face,
            six: pull.six,
            pose,
            along,
            gain: Vector3::new(gain.x, gain.y, 0.0),
            range_m: u.norm(),
            across_rad: 0.0,
        })
    }

    /// Gathers the errors of every trajectory record over both sensors.
    #[must_use]
    pub fn by_record(&self) -> Records {
        let trajectory = &self.scene.trajectory;
        let mut records = Records {
            times_s: trajectory.times_s().to_vec(),
            position: vec![Matrix6x3::zeros(); trajectory.len()],
            attitude: vec![Matrix6x3::zeros(); trajectory.len()],
        };
        let none = Matrix6x3::zeros();
        let soundings = self
            .soundings
            .iter()
            .map(|s| (s, self.turns[s.face as usize]));
        for (seen, turn) in soundings.chain(self.returns.iter().map(|s| (s, none))) {
            let Some(normal) = self.normal(seen.face) else {
                continue;
            };
            let moved = seen.six * normal.transpose();
            let turned = seen.six * seen.along.attitude.transpose() + turn;
            let before = seen.pose.weight_before;
            let k = seen.pose.record as usize;
            for (record, weight) in [(k, before), (k + 1, 1.0 - before)] {
                records.position[record] += moved * weight;
                records.attitude[record] += turned * weight;
            }
        }
        // roll, pitch and heading instead of turns about the target's axes
        for (sum, attitude) in records.attitude.iter_mut().zip(trajectory.attitudes()) {
            *sum *= attitude_axes(attitude);
        }
        records
    }

    /// Metres along the normal by which a sounding moves when its stamp goes from one delay to another (seconds).
    fn delayed(&self, seen: &Seen, from_s: f64, to_s: f64) -> f64 {
        let time_s = self.scene.campaign.soundings.at_s(seen.row as usize);
        let pose = |delay_s: f64| self.scene.trajectory.pose_at(time_s + delay_s);
        let (Ok(before), Ok(after), Some(normal)) =
            (pose(from_s), pose(to_s), self.normal(seen.face))
        else {
            return 0.0;
        };
        let turn = rotation::log(&(after.rotation * before.rotation.transpose()));
        let moved = normal.dot(&(after.position_m - before.position_m));
        moved + seen.along.attitude.dot(&turn)
    }

    /// Error from a constant latency (seconds): over the way itself, since between two records the motion has a bend at each.
    #[must_use]
    pub fn latency(&self, delay_s: f64) -> Vector6<f64> {
        let step_s = delay_s.clamp(-SHIFT_S, SHIFT_S);
        if step_s == 0.0 {
            return Vector6::zeros();
        }
        let moved = |s: &Seen| s.six * self.delayed(s, 0.0, step_s);
        self.soundings.iter().map(moved).sum::<Vector6<f64>>() * (delay_s / step_s)
    }

    /// Error from one sigma (seconds) of a latency that is as often early as late.
    #[must_use]
    pub fn latency_sigma(&self, sigma_s: f64) -> Vector6<f64> {
        (self.latency(sigma_s) - self.latency(-sigma_s)) * 0.5
    }

    /// Covariance of a delay that is drawn anew for each ping (one sigma, seconds).
    #[must_use]
    pub fn jitter(&self, sigma_s: f64) -> Matrix6<f64> {
        let step_s = sigma_s.min(SHIFT_S);
        if step_s <= 0.0 {
            return Matrix6::zeros();
        }
        let ping = |s: &Seen| self.scene.campaign.soundings.name(s.row as usize).0;
        let moved = |s: &Seen| s.six * self.delayed(s, -step_s, step_s);
        let sum: Matrix6<f64> = self
            .soundings
            .chunk_by(|a, b| ping(a) == ping(b))
            .map(|beams| square(&beams.iter().map(moved).sum()))
            .sum();
        sum * (0.5 * sigma_s / step_s).powi(2)
    }

    /// Direction of a scale of all ranges: true = measured (1 + scale).
    #[must_use]
    pub fn range_scale(&self) -> Vector6<f64> {
        let one = |s: &Seen| s.six * (-s.range_m * s.gain.x);
        self.soundings.iter().map(one).sum()
    }

    /// Direction of a sound-speed gradient that the survey does not know of, per 1/s.
    #[must_use]
    pub fn gradient(&self) -> Vector6<f64> {
        let Some(known) = self.scene.campaign.sound_speed.as_ref() else {
            return Vector6::zeros();
        };
        let level_m = self.scene.campaign.water_level_m;
        let steeper = |by: f64| Water::new(&SoundSpeed::Profile(profile(known, by)), level_m);
        let (Ok(less), Ok(more)) = (steeper(-GRADIENT_1_S), steeper(GRADIENT_1_S)) else {
            return Vector6::zeros();
        };
        let one = |s: &Seen| s.six * self.bent(s, &less, &more, known).unwrap_or(0.0);
        self.soundings.iter().map(one).sum()
    }

    /// The point under the water known less the point under the true one, along the normal, per 1/s.
    fn bent(&self, seen: &Seen, less: &Water, more: &Water, known: &SoundSpeed) -> Option<f64> {
        let soundings = &self.scene.campaign.soundings;
        let [across_rad, along_rad, range] = soundings.measured(seen.row as usize);
        let two_way_s = match &soundings.range {
            SoundingRange::Metres(_) => 2.0 * range / first_speed(known),
            SoundingRange::TwoWayTravelTime(_) => range,
        };
        let launch = Launch {
            across_rad,
            along_rad,
            two_way_s,
        };
        let end = |water: &Water| water.refract(&launch, &seen.pose, &self.sonar).ok();
        let moved = end(less)?.vector_m() - end(more)?.vector_m();
        Some(seen.along.sensor.dot(&moved) / (2.0 * GRADIENT_1_S))
    }

    /// Directions of a scanner that is turned (about the body's axes, per radian) against what the survey knows.
    #[must_use]
    pub fn scanner_turn(&self) -> Matrix6x3<f64> {
        let one = |s: &Seen| s.six * -s.along.rotation.transpose();
        self.returns.iter().map(one).sum()
    }

    /// Directions of a scanner that stands elsewhere (body frame, per metre) than the survey knows.
    #[must_use]
    pub fn scanner_arm(&self) -> Matrix6x3<f64> {
        let one = |s: &Seen| s.six * -s.along.lever_arm.transpose();
        self.returns.iter().map(one).sum()
    }

    /// Directions of the target's offsets, per metre, in their order.
    #[must_use]
    pub fn offsets(&self) -> Vec<Vector6<f64>> {
        let target = self.scene.target;
        let mut all = vec![Vector6::zeros(); target.offsets.len()];
        for seen in self.soundings.iter().chain(&self.returns) {
            all[target.faces[seen.face as usize].offset] += seen.six;
        }
        all
    }
}

/// Longest delay over which a latency's effect is differenced, seconds; longer ones are scaled.
const SHIFT_S: f64 = 0.02;
/// Step of the gradient's difference, 1/s: less would lose digits, more the linearity of 10 m of water.
const GRADIENT_1_S: f64 = 0.01;
/// Deep enough for every basin, metres.
const DEEPEST_M: f64 = 1000.0;

/// Turns of the body in the target frame per radian of recorded roll, pitch, heading: about the body's forward axis, about the
/// level axis to the right, and about down.
fn attitude_axes(body: &Matrix3<f64>) -> Matrix3<f64> {
    let forward = body * Vector3::y();
    let right = forward.cross(&Vector3::z()).normalize();
    Matrix3::from_columns(&[forward, right, -Vector3::z()])
}

/// The speed that exchanges metres and seconds.
fn first_speed(known: &SoundSpeed) -> f64 {
    match known {
        SoundSpeed::Constant(speed) => *speed,
        SoundSpeed::Profile(p) => p.speed_m_s.first().copied().unwrap_or(1500.0),
    }
}

/// The water as known, with a gradient more.
fn profile(known: &SoundSpeed, gradient_1_s: f64) -> SoundSpeedProfile {
    let mut profile = match known {
        SoundSpeed::Constant(speed) => SoundSpeedProfile {
            depth_m: vec![0.0, DEEPEST_M],
            speed_m_s: vec![*speed; 2],
        },
        SoundSpeed::Profile(p) => p.clone(),
    };
    for (speed, depth) in profile.speed_m_s.iter_mut().zip(&profile.depth_m) {
        *speed += gradient_1_s * depth;
    }
    profile
}

/// Covariance of noise that is independent from observation to observation; `sigma` in metres along the normal.
#[must_use]
pub fn independent(seen: &[Seen], sigma: impl Fn(&Seen) -> f64) -> Matrix6<f64> {
    seen.iter().map(|s| square(&(s.six * sigma(s)))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the attitude of the conventions page, by differences.
    #[test]
    fn attitude_axes_agree_with_differences() {
        let (roll, pitch, heading, step) = (0.1, -0.07, 2.1, 1e-6);
        let body = rotation::from_attitude(roll, pitch, heading);
        let axes = attitude_axes(&body);
        for (i, d) in [
            (0, [step, 0.0, 0.0]),
            (1, [0.0, step, 0.0]),
            (2, [0.0, 0.0, step]),
        ] {
            let moved = rotation::from_attitude(roll + d[0], pitch + d[1], heading + d[2]);
            let turn = rotation::log(&(moved * body.transpose())) / step;
            assert!((turn - axes.column(i)).norm() < 1e-6, "{i}: {turn}");
        }
    }
}
