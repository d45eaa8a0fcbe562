//! Unknowns that the joint path could have and has not: the columns of their score tests (`docs/verdict-measured.md`).
//!
//! A column is the derivative of a condition `n . X - d = 0` by the unknown, at the solution. With the body's pose `R`, the face's normal
//! in the body `b = R^T n` and `a = arm x b` (a turn of the body in its own axes moves the point along the normal by `a`):
//!
//! | unknown | column |
//! |---|---|
//! | stamps late | `-(n . v + a . w)`, velocity `v`, rate `w` of the body |
//! | attitude late | `a . w` |
//! | position of the body | `n` |
//! | attitude in the level frame | `R a` |
//! | scale of roll | `roll a . y`; of pitch `pitch a . x'`, `x'` the pitch axis |
//! | mounting of one pass | `R_m u x b`, `b` |
//! | scale and offset of the range | `b . R_m u` at the adjusted range, over the range |
//! | scale of the beam angle | `angle b . R_m du/dangle` |
//! | a face off its plane | `-1` |

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::conditions::{Eyes, Motion, Motions, ReturnConditions, Sight, SoundingConditions};
use super::joint::Blocks;
use super::planes::PASS_GAP_S;
use super::scene::Scene;
use super::ties::TieSet;
use crate::adjust::{ChainState, Component, Row, ScoreColumns, Solved, Unit};
use crate::calibrate::verdict::doubts::{append, late_attitude};
use crate::calibrate::verdict::{Alternative, Doubt};
use crate::geometry::rotation::{from_attitude, log, to_attitude};
use crate::math;
use crate::observe::SoundingRange;

/// Chi-square beyond which a wrong heading withdraws "usable". Two of the first 100 right surveys of `gross-errors-thin` had 18 and 20, which chance
/// gives one in 50 000.
const CERTAIN_HEADING: f64 = 25.0;

/// Passes by the time they begin at, split where the soundings pause.
#[derive(Clone, Debug, PartialEq)]
pub struct Passes {
    /// Begin of each pass but the first, seconds: the middle of the pause before it.
    begins_s: Vec<f64>,
}

impl Passes {
    /// Passes of the tied soundings.
    #[must_use]
    pub fn of(scene: &Scene, ties: &TieSet) -> Self {
        let time_s = |row: u32| scene.campaign.soundings.at_s(row as usize);
        let (mut before_s, mut begins_s) = (f64::INFINITY, vec![]);
        for now_s in ties.iter().map(|tie| time_s(tie.row)) {
            if now_s - before_s > PASS_GAP_S {
                begins_s.push(0.5 * (before_s + now_s));
            }
            before_s = now_s;
        }
        Self { begins_s }
    }

    /// Those that begin at these moments, the first aside.
    #[must_use]
    pub(super) fn beginning(begins_s: Vec<f64>) -> Self {
        Self { begins_s }
    }

    /// Begin of each pass but the first, seconds.
    #[must_use]
    pub(super) fn begins_s(&self) -> &[f64] {
        &self.begins_s
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.begins_s.len() + 1
    }

    /// The pass of a moment, from 0.
    #[must_use]
    pub fn at(&self, time_s: f64) -> usize {
        self.begins_s.partition_point(|begin| *begin <= time_s)
    }
}

/// First columns of the doubts; `None` where the model has the unknown already or cannot have it.
#[derive(Clone, Debug, Default)]
struct Columns {
    latency: Option<usize>,
    range_scale: Option<usize>,
    range_offset: Option<usize>,
    angle_scale: Option<usize>,
    gradient: Option<usize>,
    returns_latency: Option<usize>,
    returns_range: Option<usize>,
    scanner: Option<usize>,
    /// Scale of roll and pitch, and what each takes from the other.
    attitude: Option<usize>,
    attitude_latency: Option<usize>,
    level: Option<usize>,
    heading: Option<usize>,
    /// Per pass.
    mounting: Vec<Option<usize>>,
    datum: Vec<Option<usize>>,
    /// Per face.
    face: Vec<Option<usize>>,
}

/// The doubts of a pool calibration with their columns.
pub struct Doubts<'a> {
    scene: &'a Scene<'a>,
    soundings: &'a SoundingConditions<'a>,
    returns: &'a ReturnConditions<'a>,
    passes: &'a Passes,
    columns: Columns,
    /// What is doubted, in the order of the columns.
    pub list: Vec<Doubt>,
}

impl<'a> Doubts<'a> {
    /// Everything that these conditions could tell of.
    #[must_use]
    pub fn of(
        (scene, blocks): (&'a Scene<'a>, &Blocks),
        (soundings, returns): (&'a SoundingConditions<'a>, &'a ReturnConditions<'a>),
        passes: &'a Passes,
    ) -> Self {
        let mut doubts = Self {
            scene,
            soundings,
            returns,
            passes,
            columns: Columns::default(),
            list: vec![],
        };
        doubts.sounder(blocks);
        doubts.laser(blocks);
        doubts.body();
        doubts.by_pass();
        doubts.faces(blocks);
        doubts
    }

    /// Appends a doubt; returns its first column.
    fn add(&mut self, doubt: Doubt) -> Option<usize> {
        Some(append(&mut self.list, doubt))
    }

    fn sounder(&mut self, blocks: &Blocks) {
        if blocks.latency.is_none() {
            let what = "the sounder's time stamps look late";
            let advice = "set [joint] latency = true, or correct [multibeam] time_offset_s";
            self.columns.latency = self.add(Doubt::single("latency", what, Unit::Second, advice));
        }
        if blocks.range_scale.is_none() {
            let what = "the sounder's ranges look too short by a scale (sound speed)";
            let advice = "check the sound speed; set [joint] range_scale = true";
            self.columns.range_scale =
                self.add(Doubt::single("range_scale", what, Unit::One, advice));
        }
        let what = "the sounder's ranges look too short by a constant";
        let advice = "check the sounder's range offset (transducer draught, pulse detection)";
        self.columns.range_offset =
            self.add(Doubt::single("range_offset", what, Unit::Metre, advice));
        let what = "the beam angles look too narrow (sound speed at the transducer)";
        let advice = "check the sound speed that the sounder steered its beams with";
        self.columns.angle_scale =
            self.add(Doubt::single("beam_angle_scale", what, Unit::One, advice));
        if self.scene.has_profile() {
            let what =
                "the ranges look too short with depth (gradient of the sound speed), per 10 m";
            let advice = "measure the sound-speed profile again";
            self.columns.gradient = self.add(Doubt::single(
                "sound_speed_gradient",
                what,
                Unit::One,
                advice,
            ));
        }
    }

    fn laser(&mut self, blocks: &Blocks) {
        if !self.scene.laser_uses_trajectory() || self.returns.ties.is_empty() {
            return;
        }
        let what = "the scanner's time stamps look late";
        let advice = "correct [lidar] time_offset_s";
        self.columns.returns_latency =
            self.add(Doubt::single("laser_latency", what, Unit::Second, advice));
        let what = "the scanner's ranges look too short by a constant";
        let advice = "check the scanner's range offset";
        self.columns.returns_range = self.add(Doubt::single(
            "laser_range_offset",
            what,
            Unit::Metre,
            advice,
        ));
        if blocks.scanner.is_none() {
            let what = "the scanner's own mounting looks wrong";
            let advice = "calibrate the scanner again, or state [lidar] mounting_sigma_deg and lever_arm_sigma_m";
            let doubt = Doubt::several("scanner_mounting", what, mounting_components(), advice);
            let signs = signs(&self.scene.campaign.scanner.rotation);
            self.columns.scanner = self.add(doubt.or(signs));
        }
    }

    fn body(&mut self) {
        if !self.scene.laser_uses_trajectory() {
            return;
        }
        let scales = [
            "roll scale",
            "pitch scale",
            "roll by pitch",
            "pitch by roll",
        ];
        let what = "the recorded roll and pitch do not match the boat's motion";
        let advice = "check signs, order and unit of roll and pitch, and the axes of the motion sensor (-200 % is a wrong sign, \
                      -100 % with +100 % of the other an exchange)";
        let components = scales.map(|name| Component::new(name, Unit::One)).to_vec();
        self.columns.attitude =
            self.add(Doubt::several("attitude_scale", what, components, advice));
        self.columns.attitude_latency = self.add(late_attitude());
        let level = ["about east of the target", "about north of the target"];
        let what = "the attitude is not level";
        let advice = "check the motion sensor's level";
        let components = level
            .map(|name| Component::new(name, Unit::Radian))
            .to_vec();
        self.columns.level = self.add(Doubt::several("attitude_offset", what, components, advice));
        // by itself: beside five others a wrong heading, or a scanner turned by as much, goes unheard
        let what = "the heading is off, or the scanner is turned on the boat (counter-clockwise)";
        let advice = "check the heading (grid or magnetic instead of true, [target] azimuth_deg), and the heading of [lidar] mounting_deg";
        let doubt = Doubt::single("heading_offset", what, Unit::Radian, advice)
            .withdrawing_beyond(CERTAIN_HEADING);
        self.columns.heading = self.add(doubt);
    }

    fn by_pass(&mut self) {
        let count = self.passes.count();
        (self.columns.mounting, self.columns.datum) = (vec![None; count], vec![None; count]);
        if count < 2 {
            return;
        }
        // with two passes the second one's own mounting is the first one's with the other sign
        let first = usize::from(count == 2);
        for pass in first..count {
            let number = pass + 1;
            let what = format!("the sounder is mounted differently in pass {number}");
            let advice = "the pole or the transducer has moved: look at its mount, and calibrate the passes before and after it separately";
            let code = "mounting_of_pass";
            let doubt = Doubt::several(code, &what, mounting_components(), advice);
            self.columns.mounting[pass] = self.add(doubt);
            let what =
                format!("the boat's position in pass {number} is offset from the other passes");
            let advice =
                "check the position's fix type and datum, and [trajectory] position_drift_sigma_m";
            let axes = ["away from the boat", "along the wall", "up"];
            let components = axes.map(|name| Component::new(name, Unit::Metre)).to_vec();
            self.columns.datum[pass] =
                self.add(Doubt::several("datum_of_pass", &what, components, advice));
        }
    }

    fn faces(&mut self, blocks: &Blocks) {
        let target = self.scene.target;
        self.columns.face = vec![None; target.faces.len()];
        let seen =
            [self.soundings.ties, self.returns.ties].map(|ties| ties.by_face(target.faces.len()));
        let seen_by = |face: usize| seen[0][face] + seen[1][face];
        for face in 0..target.faces.len() {
            let plane = blocks.faces[face].as_ref();
            let alone = (0..target.faces.len())
                .filter(|other| target.faces[*other].group == target.faces[face].group)
                .all(|other| other == face || seen_by(other) < 20);
            let few = seen_by(face) < 20;
            if plane.is_none_or(|plane| plane.offset.is_some()) || alone || few {
                continue;
            }
            let what = format!("face {} does not lie in its plane", target.faces[face].name);
            let advice = "survey the target again, or give the faces a tolerance (coplanarity_sigma_m, height_sigma_m)";
            self.columns.face[face] =
                self.add(Doubt::single("face_offset", &what, Unit::Metre, advice));
        }
    }

    /// Columns that both sensors share: those of the body's motion, of the passes' datum and of the face.
    fn shared(
        &self,
        (sight, motion): (&Sight, Option<&Motion>),
        stamp_s: f64,
        face: u16,
        push: &mut dyn FnMut(usize, f64),
    ) {
        if let Some(first) = self.columns.attitude {
            let turn = sight.rotation.tr_mul(&sight.attitude);
            let (roll, pitch, _) = to_attitude(&sight.rotation);
            let by_pitch = turn.x * math::cos(roll) + turn.z * math::sin(roll);
            push(first, turn.y * roll);
            push(first + 1, by_pitch * pitch);
            push(first + 2, turn.y * pitch);
            push(first + 3, by_pitch * roll);
        }
        let late = || motion.map_or(0.0, |motion| sight.by_attitude_delay(motion));
        push_one(self.columns.attitude_latency, late, push);
        if let Some(first) = self.columns.level {
            push(first, sight.attitude.x);
            push(first + 1, sight.attitude.y);
        }
        push_one(self.columns.heading, || sight.attitude.z, push);
        let datum = self.columns.datum[self.passes.at(stamp_s)];
        push_three(datum, &sight.normal, push);
        self.face(face, push);
    }

    fn face(&self, face: u16, push: &mut dyn FnMut(usize, f64)) {
        if let Some(column) = self.columns.face[face as usize] {
            push(column, -1.0);
        }
    }

    fn sounding(
        &self,
        k: usize,
        chain: Option<&ChainState>,
        Look { eyes, motions }: &mut Look,
        push: &mut dyn FnMut(usize, f64),
    ) -> Option<()> {
        let seen = self.soundings.seen(k, eyes, chain)?;
        let tie = self.soundings.ties.get(k)?;
        let (sight, columns) = (&seen.sight, &self.columns);
        let by_beam = seen.adjusted.partials.jacobian.tr_mul(&seen.in_sensor);
        let [across_rad, ..] = self.scene.campaign.soundings.measured(tie.row as usize);
        let gradient = || -seen.by_range * (sight.rotation * sight.turned).z / 20.0;
        let motion = motions.at(&seen.pose);
        let motion = motion.as_ref();
        push_one(columns.latency, || late(sight, motion), push);
        push_one(columns.range_scale, || seen.by_range, push);
        push_one(columns.range_offset, || by_beam.x, push);
        let across_rad = across_rad + seen.adjusted.correction.y;
        push_one(columns.angle_scale, || by_beam.y * across_rad, push);
        push_one(columns.gradient, gradient, push);
        if let Some(first) = columns.mounting[self.passes.at(seen.stamp_s)] {
            push_mounting(first, sight, push);
        }
        self.shared((sight, motion), seen.stamp_s, tie.face, push);
        Some(())
    }

    fn of_return(
        &self,
        k: usize,
        chain: Option<&ChainState>,
        Look { eyes, motions }: &mut Look,
        push: &mut dyn FnMut(usize, f64),
    ) -> Option<()> {
        let face = self.returns.ties.get(k)?.face;
        if !self.scene.laser_uses_trajectory() {
            self.face(face, push);
            return Some(());
        }
        let seen = self.returns.seen(k, eyes, chain)?;
        let (sight, columns) = (&seen.sight, &self.columns);
        let motion = motions.at(&seen.pose);
        let motion = motion.as_ref();
        push_one(columns.returns_latency, || late(sight, motion), push);
        push_one(columns.returns_range, || seen.by_range, push);
        if let Some(first) = columns.scanner {
            push_mounting(first, sight, push);
        }
        self.shared((sight, motion), seen.stamp_s, face, push);
        Some(())
    }

    /// The columns of one sensor's conditions.
    #[must_use]
    pub fn columns_of(&self, sensor: Sensor) -> OfSensor<'_> {
        OfSensor {
            doubts: self,
            sensor,
        }
    }
}

/// What the columns of neighbouring conditions share.
struct Look<'a> {
    eyes: Eyes<'a>,
    motions: Motions<'a>,
}

/// Derivative by the delay of the stamps, metres per second; zero at the ends of the trajectory.
fn late(sight: &Sight, motion: Option<&Motion>) -> f64 {
    motion.map_or(0.0, |motion| sight.by_delay(motion))
}

fn push_one(column: Option<usize>, value: impl FnOnce() -> f64, push: &mut dyn FnMut(usize, f64)) {
    if let Some(column) = column {
        push(column, value());
    }
}

fn push_mounting(first: usize, sight: &Sight, push: &mut dyn FnMut(usize, f64)) {
    push_three(Some(first), &sight.by_turn(), push);
    push_three(Some(first + 3), &sight.in_body, push);
}

fn push_three(first: Option<usize>, values: &Vector3<f64>, push: &mut dyn FnMut(usize, f64)) {
    let Some(first) = first else { return };
    (0..3).for_each(|i| push(first + i, values[i]));
}

/// The scanner's stated mounting with one sign reversed: by how much that turns it in the body. An angle of zero has no sign.
fn signs(stated: &Matrix3<f64>) -> Vec<(Alternative, Vec<f64>)> {
    let (roll, pitch, heading) = to_attitude(stated);
    let advice = "check the signs of [lidar] mounting_deg: roll is positive starboard down, pitch bow up, heading clockwise; \
                  with mounting_sigma_deg the survey estimates them too";
    let reversed = |code, axis, to: Matrix3<f64>| {
        let words = format!("with the sign of the scanner's {axis} reversed");
        let turn: Matrix3<f64> = to * stated.transpose();
        let turn = log(&turn);
        let known = vec![turn.x, turn.y, turn.z, 0.0, 0.0, 0.0];
        (Alternative::new(code, words, advice), known)
    };
    vec![
        reversed(
            "sign_of_scanner_roll",
            "roll",
            from_attitude(-roll, pitch, heading),
        ),
        reversed(
            "sign_of_scanner_pitch",
            "pitch",
            from_attitude(roll, -pitch, heading),
        ),
        reversed(
            "sign_of_scanner_heading",
            "heading",
            from_attitude(roll, pitch, -heading),
        ),
    ]
}

fn mounting_components() -> Vec<Component> {
    let angles = ["pitch", "roll", "yaw"].map(|name| Component::new(name, Unit::Radian));
    let arm = ["lx", "ly", "lz"].map(|name| Component::new(name, Unit::Metre));
    angles.into_iter().chain(arm).collect()
}

/// Whose conditions.
#[derive(Clone, Copy, Debug)]
pub enum Sensor {
    /// The soundings'.
    Sounder,
    /// The laser returns'.
    Scanner,
}

/// [`Doubts`] as one sensor's conditions see them.
pub struct OfSensor<'a> {
    doubts: &'a Doubts<'a>,
    sensor: Sensor,
}

impl ScoreColumns for OfSensor<'_> {
    fn derive(&self, k: usize, at: &Solved, row: &Row, push: &mut dyn FnMut(usize, f64)) {
        let one = |_: usize, column, value| push(column, value);
        self.derive_range(k..k + 1, at, std::slice::from_ref(row), &mut { one });
    }

    fn derive_range(
        &self,
        range: Range<usize>,
        at: &Solved,
        _: &[Row],
        push: &mut dyn FnMut(usize, usize, f64),
    ) {
        let doubts = self.doubts;
        let mut look = Look {
            eyes: match self.sensor {
                Sensor::Sounder => doubts.soundings.eyes(at.parameters),
                Sensor::Scanner => doubts.returns.eyes(at.parameters),
            },
            motions: Motions::of(&doubts.scene.trajectory),
        };
        for (i, k) in range.enumerate() {
            let push = &mut |column, value| push(i, column, value);
            let _ = match self.sensor {
                Sensor::Sounder => doubts.sounding(k, at.chain, &mut look, push),
                Sensor::Scanner => doubts.of_return(k, at.chain, &mut look, push),
            };
        }
    }
}

impl Scene<'_> {
    /// Whether soundings are travel times through a measured profile.
    #[must_use]
    pub fn has_profile(&self) -> bool {
        let by_time = matches!(
            self.campaign.soundings.range,
            SoundingRange::TwoWayTravelTime(_)
        );
        let profile = matches!(
            self.campaign.sound_speed,
            Some(crate::observe::SoundSpeed::Profile(_))
        );
        by_time && profile
    }
}
