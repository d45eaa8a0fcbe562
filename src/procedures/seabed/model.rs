//! From an observation to its place on the seabed, and how that place moves with every parameter (seabed page, "The model").

use nalgebra::{Matrix3, Vector3};

use super::cones;
use super::parameters::{
    DEEP_SOUND_SPEED, HEAVE_LAG, HEAVE_SCALE, KINDS, LATENCY, RANGE_SCALE, count, own,
};
use super::scene::{Head, Scene, Sounding, axis};
use super::states::{Component, States};
use crate::georef::{self, Layers, effects};
use crate::math;
use crate::observe::{Acts, ArrayMountings, Extra, Mounting};

/// Values of the parameters, and of the trajectory's states.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Mounting of each head.
    pub mountings: Vec<Mounting>,
    /// Stamps are late by this, seconds.
    pub latency_s: f64,
    /// True range over measured range, minus 1.
    pub range_scale: f64,
    /// True heave over measured heave, minus 1.
    pub heave_scale: f64,
    /// The heave channel is late by this, seconds.
    pub heave_lag_s: f64,
    /// Relative error of the profile at the reference depth.
    pub deep_sound_speed: f64,
    /// Unknowns of the caller's own.
    pub extras: Vec<f64>,
    /// Trajectory errors on knots and heights of the lines.
    pub states: Vec<f64>,
}

impl Values {
    /// Everything as nominal.
    #[must_use]
    pub fn nominal(scene: &Scene, states: &States) -> Self {
        Self {
            mountings: scene.heads.iter().map(|head| head.nominal).collect(),
            latency_s: 0.0,
            range_scale: 0.0,
            heave_scale: 0.0,
            heave_lag_s: 0.0,
            deep_sound_speed: 0.0,
            extras: vec![0.0; scene.extras.len()],
            states: vec![0.0; states.len()],
        }
    }

    /// A step of nothing, for [`Self::stepped`].
    #[must_use]
    pub fn no_step(&self) -> Vec<f64> {
        let parameters = count(self.mountings.len()) + self.extras.len();
        vec![0.0; parameters + self.states.len()]
    }

    /// Applies a step: the parameters first, then the states.
    #[must_use]
    pub fn stepped(&self, step: &[f64]) -> Self {
        let corrected = |(head, mounting): (usize, &Mounting)| {
            let (angles, arm) = own(head);
            let turn = Vector3::from(angles.map(|k| step[k]));
            let arm = Vector3::from(arm.map(|k| k.map_or(0.0, |k| step[k])));
            mounting.corrected(&turn, &arm)
        };
        let behind = &step[count(self.mountings.len())..];
        let (extras, states) = behind.split_at(self.extras.len());
        let states = self.states.iter().zip(states);
        let extras = self.extras.iter().zip(extras);
        Self {
            mountings: self.mountings.iter().enumerate().map(corrected).collect(),
            latency_s: self.latency_s + step[LATENCY],
            range_scale: self.range_scale + step[RANGE_SCALE],
            heave_scale: self.heave_scale + step[HEAVE_SCALE],
            heave_lag_s: self.heave_lag_s + step[HEAVE_LAG],
            deep_sound_speed: self.deep_sound_speed + step[DEEP_SOUND_SPEED],
            extras: extras.map(|(x, dx)| x + dx).collect(),
            states: states.map(|(x, dx)| x + dx).collect(),
        }
    }

    /// Distance of every parameter from its nominal value, in the order of [`Scene::parameters`].
    #[must_use]
    pub fn from_nominal(&self, scene: &Scene) -> Vec<f64> {
        let mut off = vec![0.0; count(self.mountings.len())];
        for (head, (mounting, of)) in self.mountings.iter().zip(&scene.heads).enumerate() {
            let turn = mounting.correction_from(&of.nominal);
            let shift = mounting.lever_arm_m - of.nominal.lever_arm_m;
            let (angles, arm) = own(head);
            for axis in 0..3 {
                off[angles[axis]] = turn[axis];
                if let Some(place) = arm[axis] {
                    off[place] = shift[axis];
                }
            }
        }
        off[LATENCY] = self.latency_s;
        off[RANGE_SCALE] = self.range_scale;
        off[HEAVE_SCALE] = self.heave_scale;
        off[HEAVE_LAG] = self.heave_lag_s;
        off[DEEP_SOUND_SPEED] = self.deep_sound_speed;
        off.extend(&self.extras);
        off
    }
}

/// A sounding on the seabed at some values, with what its derivatives need.
#[derive(Clone, Copy, Debug)]
pub struct Located {
    /// Where it struck, metres.
    pub point_m: Vector3<f64>,
    /// From the transducer to there, local frame, metres.
    pub ray_m: Vector3<f64>,
    /// Length of the ray's chord, metres.
    pub range_m: f64,
    /// Across direction of the beam in the local frame: `d(ray)/d(across) / range`.
    pub sideways: Vector3<f64>,
    /// Body into local frame.
    pub rotation: Matrix3<f64>,
    /// When it was measured on the trajectory's clock, seconds.
    pub time_s: f64,
    /// Sine of the across angle.
    pub sine: f64,
    /// Wave-band heave, metres, and its rate, metres per second.
    pub heave: [f64; 2],
    /// How the beam left the sonar.
    aim: Aim,
    /// Its angles, as own unknowns correct them, radians.
    across_rad: f64,
    along_rad: f64,
    /// By how much own unknowns lengthen the ray, metres.
    beyond_m: f64,
    /// Depth of the transducer, metres.
    pub(super) depth_m: f64,
    velocity_m_s: Vector3<f64>,
    turning: Matrix3<f64>,
    lever_arm_m: Vector3<f64>,
    scale: f64,
}

/// Step of the profile's error in its derivative.
const DEEP_STEP: f64 = 1e-3;
/// Half the interval over which the measured trajectory is differenced, seconds.
const RATE_STEP_S: f64 = 0.1;

/// Places soundings at one set of values.
pub struct Locator<'a> {
    /// The survey.
    pub scene: &'a Scene,
    /// The layout of the states.
    pub states: &'a States,
    values: &'a Values,
    /// Of each head, where it has two arrays.
    arrays: Vec<Option<ArrayMountings>>,
    layers: Vec<Layers>,
    deeper: Vec<Layers>,
}

/// How a beam leaves the sonar, in the local frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// From where, metres; of two arrays half way between them.
    pub(super) transducer_m: Vector3<f64>,
    /// Direction and its derivative by the across angle.
    pub(super) direction: Vector3<f64>,
    /// See `direction`.
    pub(super) sideways: Vector3<f64>,
    /// Derivative of `direction` by the along angle.
    pub(super) forwards: Vector3<f64>,
    /// Sonar into local frame, of one head; of two arrays the angle's derivative serves for small changes.
    pub(super) sensor: Option<Matrix3<f64>>,
    /// Sound speed that the beam former used; `None` for the profile's.
    pub(super) head_speed_m_s: Option<f64>,
}

impl Aim {
    /// The direction with the across angle changed by `by` radians.
    fn turned(&self, (across_rad, along_rad): (f64, f64), by_rad: f64) -> Vector3<f64> {
        match self.sensor {
            Some(sensor) => sensor * beam_directions(across_rad + by_rad, along_rad).0,
            None => (self.direction + self.sideways * by_rad).normalize(),
        }
    }
}

impl<'a> Locator<'a> {
    /// For these values; `None` when the profile cannot be used.
    #[must_use]
    pub fn new(scene: &'a Scene, states: &'a States, values: &'a Values) -> Option<Self> {
        let pair = |(head, mounting): (&Head, &Mounting)| {
            let arrays = head.arrays.as_ref()?;
            Some(arrays.moved(&head.nominal, mounting))
        };
        Some(Self {
            scene,
            states,
            values,
            arrays: scene
                .heads
                .iter()
                .zip(&values.mountings)
                .map(pair)
                .collect(),
            layers: scene.water.layers(values.deep_sound_speed)?,
            deeper: scene.water.layers(values.deep_sound_speed + DEEP_STEP)?,
        })
    }

    /// Where sounding `k` struck; `None` outside the trajectory, out of the water, or without a ray.
    #[must_use]
    pub fn locate(&self, k: usize) -> Option<Located> {
        let (sounding, [lift_m, beyond_m]) = self.acted(k);
        let sounding = &sounding;
        let time_s = sounding.time_s - self.values.latency_s;
        let measured = self.scene.trajectory.pose_at(time_s).ok()?;
        let heave = self.heave(time_s)?;
        let line = usize::from(sounding.line);
        let drift = self.states.at(line, time_s, &self.values.states);
        let rotation = measured.rotation
            * crate::geometry::rotation::exp(&Vector3::new(drift[3], drift[4], drift[5]));
        let lift = self.scene.lift_m(line, time_s)
            + self.values.heave_scale * heave[0]
            + self.values.heave_lag_s * heave[1]
            + lift_m;
        let shift = Vector3::new(drift[0], drift[1], drift[2] + lift);
        let position = measured.position_m + shift;
        let head = usize::from(sounding.head);
        let aim = match &self.arrays[head] {
            None => self.one_head(sounding, &position, &rotation),
            Some(arrays) => {
                let heard_s = time_s + 2.0 * sounding.one_way_s;
                let heard = self.scene.trajectory.pose_at(heard_s).ok()?;
                let drifted = measured.rotation.tr_mul(&rotation);
                let sent = (position, rotation);
                let heard = (heard.position_m + shift, heard.rotation * drifted);
                cones::aim(arrays, sounding, sent, heard)?
            }
        };
        let depth_m =
            self.scene.water.level_m + self.scene.tide_m(line, time_s) - aim.transducer_m.z;
        let layers = &self.layers[self.cast(sounding)];
        let ray = self.chord(layers, depth_m, (&aim, aim.direction), sounding.one_way_s)?;
        let ray = lengthened(ray, beyond_m);
        let (velocity_m_s, turning) = self.rates(time_s)?;
        Some(Located {
            point_m: aim.transducer_m + ray,
            ray_m: ray,
            range_m: ray.norm(),
            sideways: aim.sideways,
            rotation,
            time_s,
            sine: math::sin(sounding.across_rad),
            heave,
            aim,
            across_rad: sounding.across_rad,
            along_rad: sounding.along_rad,
            beyond_m,
            depth_m,
            velocity_m_s,
            turning,
            lever_arm_m: self.values.mountings[head].lever_arm_m,
            scale: 1.0 + self.values.range_scale,
        })
    }

    /// Sounding `k` as own unknowns correct its angles; by how much they lift it and lengthen its ray, metres.
    fn acted(&self, k: usize) -> (Sounding, [f64; 2]) {
        let mut sounding = self.scene.soundings[k];
        if self.scene.extras.is_empty() {
            return (sounding, [0.0; 2]);
        }
        let mut beam = georef::Beam {
            range_m: 0.0,
            across_rad: sounding.across_rad,
            along_rad: sounding.along_rad,
        };
        let (extras, values) = (&self.scene.extras, &self.values.extras);
        let lift_m = effects::act(extras, values, sounding.row as usize, &mut beam);
        (sounding.across_rad, sounding.along_rad) = (beam.across_rad, beam.along_rad);
        (sounding, [lift_m, beam.range_m])
    }

    /// A beam of one head that sends and hears at one moment.
    fn one_head(
        &self,
        sounding: &Sounding,
        position: &Vector3<f64>,
        rotation: &Matrix3<f64>,
    ) -> Aim {
        let mounting = &self.values.mountings[usize::from(sounding.head)];
        let sensor = rotation * mounting.rotation;
        let (across_rad, along_rad) = (sounding.across_rad, sounding.along_rad);
        let (direction, sideways) = beam_directions(across_rad, along_rad);
        Aim {
            transducer_m: position + rotation * mounting.lever_arm_m,
            direction: sensor * direction,
            sideways: sensor * sideways,
            forwards: sensor * forwards(across_rad, along_rad),
            sensor: Some(sensor),
            head_speed_m_s: None,
        }
    }

    fn cast(&self, sounding: &Sounding) -> usize {
        self.scene.lines[usize::from(sounding.line)].cast
    }

    /// Change of sounding `k`'s ray with the error of the profile, metres, at the adjusted observation; nothing without a ray.
    ///
    /// Traced anew: a derivative at the raw angle is biased by the angle's noise.
    #[must_use]
    pub fn deep_m(&self, k: usize, located: &Located, adjusted: &Adjusted) -> Vector3<f64> {
        let sounding = &self.scene.soundings[k];
        let angles = (located.across_rad, located.along_rad);
        let launch = located.aim.turned(angles, adjusted.across_rad);
        let one_way_s = sounding.one_way_s * (1.0 + adjusted.range_m / located.range_m);
        let cast = self.cast(sounding);
        let chord = |layers: &[Layers]| {
            let aimed = (&located.aim, launch);
            self.chord(&layers[cast], located.depth_m, aimed, one_way_s)
        };
        match (chord(&self.layers), chord(&self.deeper)) {
            (Some(ray), Some(deeper)) => (deeper - ray) / DEEP_STEP,
            _ => Vector3::zeros(),
        }
    }

    /// From the transducer to the end of the ray, stretched by the range scale.
    fn chord(
        &self,
        layers: &Layers,
        depth_m: f64,
        (aim, launch): (&Aim, Vector3<f64>),
        one_way_s: f64,
    ) -> Option<Vector3<f64>> {
        let stretched = 1.0 + self.values.range_scale;
        if let Some(speed_m_s) = aim.head_speed_m_s {
            let chord = layers.chord(depth_m, (launch, speed_m_s), one_way_s);
            return Some(chord.ok()? * stretched);
        }
        let sine = math::hypot(launch.x, launch.y);
        let end = layers.trace(depth_m, (sine, -launch.z), one_way_s).ok()?;
        let stretch = if sine > 0.0 {
            end.horizontal_m / sine
        } else {
            0.0
        };
        let chord = Vector3::new(launch.x * stretch, launch.y * stretch, -end.descent_m);
        Some(chord * stretched)
    }

    /// Wave-band heave and its rate at a time.
    ///
    /// The rate is taken over the same interval as the velocity: between two neighbouring records it would share their noise with
    /// the height, and where pings fall on records that sharing has a mean (5 ms of lag that is none).
    fn heave(&self, time_s: f64) -> Option<[f64; 2]> {
        let here = self.heave_at(time_s)?;
        let (late_s, early_s) = (time_s + RATE_STEP_S, time_s - RATE_STEP_S);
        let (late, late_s) = self
            .heave_at(late_s)
            .map_or((here, time_s), |h| (h, late_s));
        let (early, early_s) = self
            .heave_at(early_s)
            .map_or((here, time_s), |h| (h, early_s));
        Some([here, (late - early) / (late_s - early_s).max(1e-9)])
    }

    fn heave_at(&self, time_s: f64) -> Option<f64> {
        let trajectory = &self.scene.trajectory;
        let k = trajectory.record_before(time_s).ok()?;
        let times = trajectory.times_s();
        let part = (time_s - times[k]) / (times[k + 1] - times[k]);
        let (before, after) = (self.scene.heave_m[k], self.scene.heave_m[k + 1]);
        Some(before + (after - before) * part)
    }

    /// Velocity and rate of the rotation, differenced over the measured trajectory; one-sided at its ends.
    fn rates(&self, time_s: f64) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let pose = |t: f64| self.scene.trajectory.pose_at(t).ok();
        let middle = || pose(time_s).map(|p| (p, time_s));
        let late = pose(time_s + RATE_STEP_S).map(|p| (p, time_s + RATE_STEP_S));
        let early = pose(time_s - RATE_STEP_S).map(|p| (p, time_s - RATE_STEP_S));
        let (late, late_s) = late.or_else(middle)?;
        let (early, early_s) = early.or_else(middle)?;
        let over = (late_s - early_s).max(1e-9);
        let velocity = (late.position_m - early.position_m) / over;
        Some((velocity, (late.rotation - early.rotation) / over))
    }
}

/// Direction of a beam in the sonar's frame, and the across derivative of it.
fn beam_directions(across_rad: f64, along_rad: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sa, ca) = math::sin_cos(across_rad);
    let (sc, cc) = math::sin_cos(along_rad);
    (
        Vector3::new(sa * cc, sc, -ca * cc),
        Vector3::new(ca * cc, 0.0, sa * cc),
    )
}

/// Derivative of a beam's direction in the sonar's frame by its along angle.
fn forwards(across_rad: f64, along_rad: f64) -> Vector3<f64> {
    let (sa, ca) = math::sin_cos(across_rad);
    let (sc, cc) = math::sin_cos(along_rad);
    Vector3::new(-sa * sc, cc, ca * sc)
}

/// A ray that reaches on by so much.
fn lengthened(ray: Vector3<f64>, by_m: f64) -> Vector3<f64> {
    if by_m == 0.0 {
        return ray;
    }
    ray * (1.0 + by_m / ray.norm())
}

/// How far an observation is adjusted before its derivatives are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adjusted {
    /// Range, metres.
    pub range_m: f64,
    /// Across angle, radians.
    pub across_rad: f64,
}

impl Located {
    /// How far the point moves when its observation is adjusted, metres.
    #[must_use]
    pub fn moved_by(&self, adjusted: &Adjusted) -> Vector3<f64> {
        self.adjusted_ray(adjusted) - self.ray_m
    }

    /// Velocity of the boat over ground, metres per second.
    #[must_use]
    pub fn velocity_m_s(&self) -> Vector3<f64> {
        self.velocity_m_s
    }

    /// Derivatives of the point with respect to each kind of parameter (in the order of [`Kind`](super::parameters::Kind)) of its own head or of all, at the
    /// adjusted observation; `deep_m` is [`Locator::deep_m`].
    #[must_use]
    pub fn columns(&self, adjusted: &Adjusted, deep_m: Vector3<f64>) -> [Vector3<f64>; KINDS] {
        let ray = self.adjusted_ray(adjusted);
        let arm = self.rotation.tr_mul(&ray);
        let turned = |k: usize| self.rotation * Vector3::ith(k, 1.0).cross(&arm);
        [
            turned(0),
            turned(1),
            turned(2),
            self.latency_column(adjusted),
            // what own unknowns add to the range is not scaled
            (ray - self.ray_m * (self.beyond_m / self.range_m)) / self.scale,
            Vector3::new(0.0, 0.0, self.heave[0]),
            Vector3::new(0.0, 0.0, self.heave[1]),
            axis(&self.rotation, 0),
            axis(&self.rotation, 1),
            axis(&self.rotation, 2),
            deep_m,
        ]
    }

    /// Derivative with respect to a latency of the stamps.
    #[must_use]
    pub fn latency_column(&self, adjusted: &Adjusted) -> Vector3<f64> {
        -(self.velocity_m_s + self.attitude_latency_column(adjusted))
    }

    /// Derivative with respect to a latency of the attitude's records alone.
    #[must_use]
    pub fn attitude_latency_column(&self, adjusted: &Adjusted) -> Vector3<f64> {
        self.turning * (self.rotation.tr_mul(&self.adjusted_ray(adjusted)) + self.lever_arm_m)
    }

    /// Derivative with respect to one component of the trajectory's error.
    #[must_use]
    pub fn state_column(&self, component: Component, adjusted: &Adjusted) -> Vector3<f64> {
        match component {
            Component::East => Vector3::x(),
            Component::North => Vector3::y(),
            Component::Up | Component::LineHeight => Vector3::z(),
            Component::Pitch => self.attitude_column(0, adjusted),
            Component::Roll => self.attitude_column(1, adjusted),
            Component::Heading => self.attitude_column(2, adjusted),
        }
    }

    /// Derivative with respect to a scale of the beam angle.
    #[must_use]
    pub fn angle_scale_column(&self, adjusted: &Adjusted) -> Vector3<f64> {
        self.across_column(adjusted) * (math::asin(self.sine) + adjusted.across_rad)
    }

    /// Derivative with respect to an unknown of the caller's own; nothing where it does not act on the sounding of that row.
    #[must_use]
    pub fn own_column(&self, extra: &Extra, row: u32, adjusted: &Adjusted) -> Vector3<f64> {
        let Some(derivative) = extra.at(row as usize) else {
            return Vector3::zeros();
        };
        let by_effect = match extra.acts {
            Acts::Up => Vector3::z(),
            Acts::Range => self.ray_m / self.range_m + self.sideways * adjusted.across_rad,
            Acts::Across => self.across_column(adjusted),
            Acts::Along => self.along_column(adjusted),
        };
        by_effect * derivative
    }

    fn across_column(&self, adjusted: &Adjusted) -> Vector3<f64> {
        let swung = self.sideways * (self.range_m + adjusted.range_m);
        swung - self.ray_m * adjusted.across_rad
    }

    /// Of one head the direction's derivative turns with the across angle; how it does on a cone of two arrays is left out.
    fn along_column(&self, adjusted: &Adjusted) -> Vector3<f64> {
        let range_m = self.range_m + adjusted.range_m;
        let turning = match self.aim.sensor {
            Some(_) => self.sideways * (math::tan(self.along_rad) * adjusted.across_rad),
            None => Vector3::zeros(),
        };
        (self.aim.forwards - turning) * range_m
    }

    fn attitude_column(&self, k: usize, adjusted: &Adjusted) -> Vector3<f64> {
        let body = self.rotation.tr_mul(&self.adjusted_ray(adjusted)) + self.lever_arm_m;
        self.rotation * Vector3::ith(k, 1.0).cross(&body)
    }

    fn adjusted_ray(&self, adjusted: &Adjusted) -> Vector3<f64> {
        self.ray_m * (1.0 + adjusted.range_m / self.range_m)
            + self.sideways * (self.range_m * adjusted.across_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::seabed::parameters::Kind;
    use crate::procedures::seabed::simulate::{Acts, Simulated, bed::Seabed, simulate};
    use crate::procedures::seabed::survey::{SeabedScenario, parse_scenario, write};

    /// Two heads, with one head for both arrays or with two arrays of each.
    fn dual(arrays: bool) -> SeabedScenario {
        let text = include_str!("../../../models/scenarios/seabed-dual.toml");
        let apart = "[multibeam]\narrays = { receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3, sector_tilt_deg = 1.5, sector_delay_s = 0.004 }";
        let further = "[[head]]\nreceiver_mounting_deg = { roll = -34.2, pitch = 0.1, heading = -0.6 }\nreceiver_offset_m = [0.0, 0.2, 0.0]";
        let text = match arrays {
            true => text
                .replace("[multibeam]", apart)
                .replace("[[head]]", further),
            false => text.to_owned(),
        };
        parse_scenario(std::path::Path::new("dual.toml"), &text).expect("a scenario")
    }

    fn scene(scenario: &SeabedScenario) -> (Scene, Simulated) {
        let survey = simulate(scenario, 3, Acts::NONE);
        let scene = write::scene(&write::survey_file(scenario, &survey), scenario, &survey);
        (scene, survey)
    }

    /// The simulator does not use the georeferencing: at the truth the soundings of both heads lie on its bed, at the nominal mountings
    /// those of neither do.
    #[test]
    fn at_the_true_mountings_the_soundings_of_both_heads_lie_on_the_bed() {
        for arrays in [false, true] {
            let scenario = dual(arrays);
            let (scene, survey) = scene(&scenario);
            let states = States::new(&scene.lines, &scene.ins, &scene.drift);
            let bed = Seabed::of(&scenario, 3);
            let off_m = |values: &Values, head: u8| {
                let locator = Locator::new(&scene, &states, values).expect("a profile");
                let own = |k: &usize| scene.soundings[*k].head == head;
                let numbers = (0..scene.soundings.len()).filter(own).step_by(37);
                let points: Vec<_> = numbers
                    .filter_map(|k| Some(locator.locate(k)?.point_m))
                    .collect();
                assert!(points.len() > 100, "{}", points.len());
                let off = points.iter().map(|p| (p.z - bed.height_m(&p.xy())).abs());
                off.fold(0.0, f64::max)
            };
            let nominal = Values::nominal(&scene, &states);
            let mut right = nominal.clone();
            for (mounting, rotation) in right.mountings.iter_mut().zip(survey.truth.rotations()) {
                mounting.rotation = rotation;
            }
            right.latency_s = survey.truth.latency_s;
            for head in 0..2 {
                let (true_m, nominal_m) = (off_m(&right, head), off_m(&nominal, head));
                // the outer beams graze the bed at 13 deg: the millimetre of one wavelength of time between records is four there
                assert!(
                    true_m < 0.012 && nominal_m > 0.1,
                    "{arrays} {head}: {true_m} {nominal_m}"
                );
            }
        }
    }

    /// Derivatives at an adjusted observation are those of a sounding that was observed so: what is left is of second order.
    #[test]
    fn columns_stand_at_the_adjusted_observation() {
        for arrays in [false, true] {
            let (mut scene, _) = scene(&dual(arrays));
            let states = States::new(&scene.lines, &scene.ins, &scene.drift);
            let values = Values::nominal(&scene, &states);
            let adjusted = Adjusted {
                range_m: 0.02,
                across_rad: 2e-3,
            };
            let numbers = (40..scene.soundings.len()).step_by(1009);
            let columns = |scene: &Scene, adjusted: &Adjusted| -> Vec<Vec<Vector3<f64>>> {
                let locator = Locator::new(scene, &states, &values).expect("a profile");
                let of = |k: usize| {
                    let located = locator.locate(k)?;
                    let deep_m = locator.deep_m(k, &located, adjusted);
                    let mut columns = located.columns(adjusted, deep_m).to_vec();
                    columns.push(located.angle_scale_column(adjusted));
                    columns.push(located.ray_m + located.moved_by(adjusted));
                    Some(columns)
                };
                numbers.clone().filter_map(of).collect()
            };
            let (found, raw) = (
                columns(&scene, &adjusted),
                columns(&scene, &Adjusted::default()),
            );
            let ranges = numbers.clone().map(|k| {
                let locator = Locator::new(&scene, &states, &values).expect("a profile");
                locator.locate(k).map_or(1.0, |l| l.range_m)
            });
            let ranges: Vec<f64> = ranges.collect();
            for (k, range_m) in numbers.clone().zip(&ranges) {
                let sounding = &mut scene.soundings[k];
                sounding.across_rad += adjusted.across_rad;
                sounding.one_way_s *= 1.0 + adjusted.range_m / range_m;
            }
            let due = columns(&scene, &Adjusted::default());
            assert!(found.len() > 20 && found.len() == due.len());
            for ((found, due), raw) in found.iter().zip(&due).zip(&raw) {
                for (c, ((found, due), raw)) in found.iter().zip(due).zip(raw).enumerate() {
                    let (left, moved) = ((found - due).norm(), (raw - due).norm());
                    // how a cone of two arrays turns with its sector's tilt is left out of the second order
                    let near = if arrays { 0.04 } else { 0.01 };
                    assert!(
                        left < near * moved + 2e-4,
                        "{arrays} {c}: {left} of {moved}"
                    );
                }
            }
        }
    }

    /// Every parameter against differences: it moves the soundings of its own head, or of all, and no others.
    #[test]
    fn a_head_s_parameters_move_its_own_soundings() {
        for arrays in [false, true] {
            let (scene, _) = scene(&dual(arrays));
            let states = States::new(&scene.lines, &scene.ins, &scene.drift);
            let values = Values::nominal(&scene, &states);
            let parameters = scene.parameters();
            let locator = Locator::new(&scene, &states, &values).expect("a profile");
            for (place, parameter) in parameters.iter().enumerate() {
                // the column of the latency is a difference over the same time, as the attitude's noise would else drown the boat's turning
                let by = match parameter.kind {
                    Kind::Latency => RATE_STEP_S,
                    _ => 1e-5,
                };
                let mut step = vec![0.0; parameters.len() + states.len()];
                step[place] = by;
                let moved = values.stepped(&step);
                assert!((moved.from_nominal(&scene)[place] - by).abs() < 1e-12);
                let there = Locator::new(&scene, &states, &moved).expect("a profile");
                step[place] = -by;
                let back = values.stepped(&step);
                let back = Locator::new(&scene, &states, &back).expect("a profile");
                for k in (40..scene.soundings.len()).step_by(1009) {
                    let Some(located) = locator.locate(k) else {
                        continue;
                    };
                    let (Some(after), Some(before)) = (there.locate(k), back.locate(k)) else {
                        continue;
                    };
                    let adjusted = Adjusted::default();
                    let deep_m = locator.deep_m(k, &located, &adjusted);
                    let column = located.columns(&adjusted, deep_m)[parameter.kind as usize];
                    let due = match parameter.acts_on(scene.soundings[k].head) {
                        true => column,
                        false => Vector3::zeros(),
                    };
                    let found = (after.point_m - before.point_m) / (2.0 * by);
                    // two arrays are taken to turn about the point half way between them, and each turns about itself: they are 0.27 m
                    // apart, and 0.03 m more by what the boat sails between transmission and reception. The boat's rate of turn is that
                    // at transmission; till reception it changes
                    let (range_m, time_s) = (located.range_m, scene.soundings[k].time_s);
                    let rate = |time_s| locator.rates(time_s).expect("a rate").1;
                    let change = rate(time_s + 2.0 * range_m / 1500.0) - rate(time_s);
                    let apart = match parameter.kind {
                        kind if arrays && kind.is_angle() => 0.5 * 0.3,
                        Kind::Latency if arrays => change.norm() * range_m,
                        _ => 0.0,
                    };
                    let near = 0.02 * due.norm() + 1e-3 + apart;
                    assert!(
                        (found - due).norm() < near,
                        "{}: {found} {due}",
                        parameter.name()
                    );
                }
            }
        }
    }
}
