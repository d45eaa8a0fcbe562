//! Discrete mistakes in a seabed survey, tried on fewer tiles when it does not fit: signs, order, units.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::config::{JointSettings, SeabedConfig};
use super::joint::fitted;
use super::scene::{Scene, Sounding};
use crate::calibrate::verdict::alternatives::{
    along_the_beam, best, from_below, from_forward_right_down,
};
use crate::calibrate::verdict::bounds::{Correction, size};
use crate::calibrate::verdict::{Alternative, Tried};
use crate::geometry::rotation::{from_attitude, to_attitude};
use crate::observe::{Mounting, Trajectory};
use crate::results::Finding;
use crate::watch::Watch;

/// Tiles and passes of a trial.
const TILES: usize = 60;
const PASSES: usize = 8;
/// Soundings that are tried at the most.
const SOUNDINGS: usize = 40_000;

/// A mistake and how it is undone.
type Mistake = (Alternative, fn(&mut Scene));

/// Names the mistake that turns the misfit into a fit, if there is one; nothing, and soon, once `watch` says that it should stop.
#[must_use]
pub fn named(scene: &Scene, settings: &JointSettings, watch: &dyn Watch) -> Option<Finding> {
    let scene = thinned(scene);
    let settings = JointSettings {
        seabed: SeabedConfig {
            max_tiles: TILES,
            max_passes: PASSES,
            ..settings.seabed.clone()
        },
        ..settings.clone()
    };
    let given = tried(&scene, &settings);
    let mut all: Vec<(Alternative, Tried)> = vec![];
    let of_heads = match scene.heads.len() {
        1 => vec![],
        _ => of_heads(),
    };
    let mistakes = of_attitude().into_iter().chain(of_soundings());
    let mistakes = mistakes.chain(of_arms());
    for (alternative, undo) in mistakes.chain(of_heads) {
        watch.go_on().ok()?;
        let mut undone = scene.clone();
        undo(&mut undone);
        all.push((alternative, tried(&undone, &settings)));
    }
    best(&given, &all, "the soundings")
}

/// Whole pings, evenly chosen, would leave holes in the tiles; so every so-manieth sounding.
fn thinned(scene: &Scene) -> Scene {
    let step = scene.soundings.len().div_ceil(SOUNDINGS).max(1);
    Scene {
        soundings: scene.soundings.iter().step_by(step).copied().collect(),
        ..scene.clone()
    }
}

/// Share of the soundings of the common tiles that are kept, and how they scatter about the common one.
fn tried(scene: &Scene, settings: &JointSettings) -> Tried {
    let Ok(found) = fitted(scene, settings) else {
        return Tried::default();
    };
    let correction = Correction {
        name: String::new(),
        turn_rad: (0..scene.heads.len())
            .map(|head| found.turn_rad(head))
            .fold(0.0, f64::max),
        arm_m: 0.0,
    };
    Tried {
        share: found.kept().map_or(0.0, |kept| kept.value()),
        variance_factor: Some(found.omega_over_freedom * found.field.noise_factor.powi(2).max(1.0)),
        oversize: size(&correction, &settings.verdict).is_some(),
    }
}

fn mistake(code: &'static str, words: &str, advice: &'static str, undo: fn(&mut Scene)) -> Mistake {
    (Alternative::new(code, words, advice), undo)
}

fn of_attitude() -> Vec<Mistake> {
    vec![
        mistake(
            "sign_of_roll",
            "with the sign of roll reversed",
            "check the sign of roll: positive is starboard down",
            |s| turned(s, |(roll, pitch, heading)| (-roll, pitch, heading)),
        ),
        mistake(
            "sign_of_pitch",
            "with the sign of pitch reversed",
            "check the sign of pitch: positive is bow up",
            |s| turned(s, |(roll, pitch, heading)| (roll, -pitch, heading)),
        ),
        mistake(
            "sign_of_heading",
            "with the sign of heading reversed",
            "check the sign of heading: clockwise from north",
            |s| turned(s, |(roll, pitch, heading)| (roll, pitch, -heading)),
        ),
        mistake(
            "heading_turned",
            "with the heading turned by 180 deg",
            "the heading is that of the stern: add 180 deg",
            |s| turned(s, |(roll, pitch, heading)| (roll, pitch, heading + PI)),
        ),
        mistake(
            "roll_and_pitch_exchanged",
            "with roll and pitch exchanged",
            "check the order of the columns roll and pitch",
            |s| turned(s, |(roll, pitch, heading)| (pitch, roll, heading)),
        ),
        mistake(
            "attitude_in_radians",
            "with roll, pitch and heading taken as radians",
            "roll, pitch and heading look like radians: give degrees",
            |s| {
                turned(s, |(roll, pitch, heading)| {
                    (roll.to_degrees(), pitch.to_degrees(), heading.to_degrees())
                });
            },
        ),
    ]
}

/// What only a sounder with several heads can have.
fn of_heads() -> Vec<Mistake> {
    vec![
        mistake(
            "heads_exchanged",
            "with the mountings of the first two heads exchanged",
            "check which head sits where: the numbers of the heads look exchanged",
            |s| {
                let [first, second, ..] = s.heads.as_mut_slice() else {
                    return;
                };
                std::mem::swap(&mut first.nominal, &mut second.nominal);
                std::mem::swap(&mut first.arrays, &mut second.arrays);
            },
        ),
        mistake(
            "sign_of_first_head",
            "with the roll of the first head's mounting reversed",
            "check the sign of roll of the first head's mounting_deg: positive is starboard down",
            |s| rolled_back(s, 0),
        ),
        mistake(
            "sign_of_second_head",
            "with the roll of the second head's mounting reversed",
            "check the sign of roll of the second head's mounting_deg: positive is starboard down",
            |s| rolled_back(s, 1),
        ),
    ]
}

/// Reverses the roll of a head's nominal mounting.
fn rolled_back(scene: &mut Scene, head: usize) {
    let reversed = |m: &Mounting| {
        let (roll, pitch, heading) = m.angles();
        Mounting::from_angles(-roll, pitch, heading, m.lever_arm_m)
    };
    if let Some(head) = scene.heads.get_mut(head) {
        head.nominal = reversed(&head.nominal);
        if let Some(arrays) = &mut head.arrays {
            arrays.transmitter = reversed(&arrays.transmitter);
            arrays.receiver = reversed(&arrays.receiver);
        }
    }
}

fn of_soundings() -> Vec<Mistake> {
    vec![
        mistake(
            "sign_of_across_angle",
            "with the across-track angle reversed",
            "check the sign of the beam angles: positive is to starboard",
            |s| each(s, |sounding| sounding.across_rad = -sounding.across_rad),
        ),
        mistake(
            "beam_angle_unit",
            "with the beam angles taken as gon",
            "the beam angles look like gon: give degrees",
            |s| each(s, |sounding| sounding.across_rad *= 0.9),
        ),
        mistake(
            "beam_angle_unit",
            "with the beam angles counted from the horizontal",
            "the beam angles look counted from the horizontal: 0 is straight below the sounder",
            |s| {
                each(s, |sounding| {
                    sounding.across_rad = from_below(sounding.across_rad);
                });
            },
        ),
        mistake(
            "range_unit",
            "with the ranges taken as depths below the sounder",
            "the ranges look like depths: give the distance along the beam",
            |s| {
                each(s, |sounding| {
                    sounding.one_way_s = along_the_beam(sounding.one_way_s, sounding.across_rad);
                });
            },
        ),
        mistake(
            "range_doubled",
            "with the travel times halved",
            "the travel times or ranges are twice as long as they fit",
            |s| each(s, |sounding| sounding.one_way_s *= 0.5),
        ),
        mistake(
            "range_halved",
            "with the travel times doubled",
            "the travel times or ranges are half as long as they fit: one-way times?",
            |s| each(s, |sounding| sounding.one_way_s *= 2.0),
        ),
    ]
}

/// Lever arms in other axes. An exchange of right and forward alone hardly moves a boat's soundings and is left to the tests.
fn of_arms() -> Vec<Mistake> {
    const ADVICE: &str = "check the axes of the sounder's lever arm: from the INS to the sounder, x right, y forward, z up";
    let arm = |words, undo| mistake("axes_of_sounder_arm", words, ADVICE, undo);
    vec![
        arm(
            "with the sounder's lever arm read as forward, right, down",
            |s| {
                moved(s, from_forward_right_down);
            },
        ),
        arm(
            "with the sounder's lever arm read as right, forward, down",
            |s| {
                moved(s, |arm_m| Vector3::new(arm_m.x, arm_m.y, -arm_m.z));
            },
        ),
        arm(
            "with the sounder's lever arm taken the other way round",
            |s| {
                moved(s, |arm_m| -arm_m);
            },
        ),
        arm(
            "with the forward part of the sounder's lever arm reversed",
            |s| {
                moved(s, |arm_m| Vector3::new(arm_m.x, -arm_m.y, arm_m.z));
            },
        ),
    ]
}

/// Changes every array's lever arm, and with it the depth of the transducer.
fn moved(scene: &mut Scene, change: fn(&Vector3<f64>) -> Vector3<f64>) {
    let arm = |m: &mut Mounting| m.lever_arm_m = change(&m.lever_arm_m);
    for head in &mut scene.heads {
        arm(&mut head.nominal);
        if let Some(arrays) = &mut head.arrays {
            arm(&mut arrays.transmitter);
            arm(&mut arrays.receiver);
        }
    }
    scene.water.transducer_m = scene.transducer_depth_m();
}

fn each(scene: &mut Scene, change: fn(&mut Sounding)) {
    scene.soundings.iter_mut().for_each(change);
}

/// Roll, pitch and heading, radians.
type Angles = (f64, f64, f64);

/// Changes every attitude's roll, pitch and heading.
fn turned(scene: &mut Scene, change: fn(Angles) -> Angles) {
    let record = &scene.trajectory;
    let attitudes = record.attitudes().iter().map(|r| {
        let (roll, pitch, heading) = change(to_attitude(r));
        from_attitude(roll, pitch, heading)
    });
    // gaps were judged when the soundings got their pose
    scene.trajectory = Trajectory::new(
        record.times_s().to_vec(),
        record.positions_m().to_vec(),
        attitudes.collect(),
        None,
        f64::INFINITY,
    );
}
