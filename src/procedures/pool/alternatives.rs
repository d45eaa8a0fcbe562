//! Discrete mistakes in a pool survey, tried on a thinned set when it does not fit: signs, units, axes, clocks.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::config::JointConfig;
use super::joint::{self, JointStart, Surfaces};
use super::run::{CANDIDATE_M, PoolInput, Scanned, Sounded};
use super::scene::Scene;
use super::verdict::Refusal;
use crate::calibrate::verdict::alternatives::{
    along_the_beam, best, from_below, from_forward_right_down,
};
use crate::calibrate::verdict::{Alternative, Tried};
use crate::geometry::ellipsoid::{TargetPose, ecef_from_level};
use crate::math;
use crate::observe::{Campaign, LaserScan, SoundingRange};
use crate::results::Finding;
use crate::watch::{Silently, Watch};

/// Soundings and returns that are tried at the most.
const SOUNDINGS: usize = 30_000;
const RETURNS: usize = 8_000;
/// Alternatives that are adjusted after a first look at all.
const ADJUSTED: usize = 5;

/// A survey as it would be without the mistake.
#[derive(Clone)]
struct Survey {
    campaign: Campaign,
    prior: TargetPose,
}

/// A mistake and how it is undone.
struct Mistake {
    alternative: Alternative,
    undo: Box<dyn Fn(&mut Survey)>,
}

/// Names the mistake that turns the misfit into a fit, if there is one; nothing, and soon, once `watch` says that it should stop.
#[must_use]
pub fn named(input: &PoolInput, watch: &dyn Watch) -> Option<Finding> {
    let survey = thinned(input);
    let first = look(&survey, input);
    let mut seen: Vec<(usize, f64)> = vec![];
    let mut all = mistakes(&survey);
    all.extend(misplaced(&survey, input));
    for (i, mistake) in all.iter().enumerate() {
        watch.go_on().ok()?;
        let mut undone = survey.clone();
        (mistake.undo)(&mut undone);
        seen.push((i, look(&undone, input)));
    }
    seen.sort_by(|a, b| b.1.total_cmp(&a.1));
    let hopeful = seen
        .iter()
        .filter(|(_, merit)| *merit > 0.0 && *merit > 0.8 * first);
    let tried: Vec<(Alternative, Tried)> = hopeful
        .take(ADJUSTED)
        .map(|(i, _)| {
            let mut undone = survey.clone();
            (all[*i].undo)(&mut undone);
            (all[*i].alternative.clone(), adjusted(&undone, input, watch))
        })
        .collect();
    best(
        &adjusted(&survey, input, watch),
        &tried,
        "each sensor's observations near the target",
    )
}

/// Share of the laser returns times share of the soundings that the rough registrations bring onto the target.
fn look(survey: &Survey, input: &PoolInput) -> f64 {
    let Ok(scene) = Scene::prepare(&survey.campaign, input.target, &survey.prior) else {
        return 0.0;
    };
    if scene.laser_near == 0 {
        return 0.0;
    }
    (scene.laser_fit * scene.rough_mounting().fit).max(0.0)
}

/// Shares and variance factor of the joint path on a thinned survey.
fn adjusted(survey: &Survey, input: &PoolInput, watch: &dyn Watch) -> Tried {
    let nothing = Tried::default();
    if watch.stopped() {
        return nothing;
    }
    let input = PoolInput {
        campaign: &survey.campaign,
        prior: &survey.prior,
        ..input.clone()
    };
    let Ok(scene) = Scene::prepare(input.campaign, input.target, input.prior) else {
        return nothing;
    };
    let scanned = Scanned::by(&scene, &input);
    if Refusal::of_scanner(&scene, &scanned.planes, &scanned.wide).is_some() {
        return nothing;
    }
    let near = (0..input.campaign.laser.len())
        .filter(|j| {
            scene
                .laser_point(*j)
                .is_some_and(|(p, _)| scanned.laser.near_box(&p, CANDIDATE_M))
        })
        .count();
    let rough = scene.rough_mounting();
    let sounded = Sounded::by(&scene, &input, &rough.mounting, &scanned.fitted);
    let mut surfaces = Surfaces {
        laser: scanned.laser,
        sonar: sounded.sonar,
    };
    let start = JointStart {
        mounting: rough.mounting,
        planes: &scanned.planes,
        returns: &scanned.returns,
        candidates: &sounded.candidates,
        soundings: &sounded.ties,
    };
    let config = JointConfig {
        variance_components: false,
        ..input.joint.clone()
    };
    let Ok(found) = joint::run(&scene, &start, &mut surfaces, &config, &Silently(watch)) else {
        return nothing;
    };
    let part = |used: usize, of: usize| {
        if of == 0 {
            0.0
        } else {
            used as f64 / of as f64
        }
    };
    Tried {
        share: part(found.soundings.len(), sounded.candidates.len())
            .min(part(found.returns.len(), near)),
        variance_factor: found.variance_factor(),
        oversize: false,
    }
}

/// Every mistake that this survey could hold.
fn mistakes(survey: &Survey) -> Vec<Mistake> {
    let mut all = of_attitude();
    all.extend(of_beams(survey));
    all.extend(of_ranges(survey));
    all.extend(of_axes_and_clocks());
    all
}

fn mistake(
    code: &'static str,
    words: &str,
    advice: &'static str,
    undo: fn(&mut Survey),
) -> Mistake {
    Mistake {
        alternative: Alternative::new(code, words, advice),
        undo: Box::new(undo),
    }
}

fn of_attitude() -> Vec<Mistake> {
    vec![
        mistake(
            "sign_of_roll",
            "with the sign of roll reversed",
            "check the sign of roll: positive is starboard down",
            |s| {
                negate(&mut s.campaign.trajectory.roll_rad);
            },
        ),
        mistake(
            "sign_of_pitch",
            "with the sign of pitch reversed",
            "check the sign of pitch: positive is bow up",
            |s| {
                negate(&mut s.campaign.trajectory.pitch_rad);
            },
        ),
        mistake(
            "sign_of_heading",
            "with the sign of heading reversed",
            "check the sign of heading: clockwise from north",
            |s| {
                negate(&mut s.campaign.trajectory.heading_rad);
            },
        ),
        mistake(
            "heading_turned",
            "with the heading turned by 180 deg",
            "the heading is that of the stern: add 180 deg",
            |s| {
                shift(&mut s.campaign.trajectory.heading_rad, PI);
            },
        ),
        mistake(
            "roll_and_pitch_exchanged",
            "with roll and pitch exchanged",
            "check the order of the columns roll and pitch",
            |s| {
                let t = &mut s.campaign.trajectory;
                std::mem::swap(&mut t.roll_rad, &mut t.pitch_rad);
            },
        ),
        mistake(
            "attitude_in_radians",
            "with roll, pitch and heading taken as radians",
            "roll, pitch and heading look like radians: give degrees",
            |s| {
                scale_attitude(s, 180.0 / PI);
            },
        ),
        mistake(
            "attitude_in_degrees",
            "with roll, pitch and heading taken as degrees",
            "roll, pitch and heading look like degrees where radians are expected",
            |s| {
                scale_attitude(s, PI / 180.0);
            },
        ),
    ]
}

fn of_beams(survey: &Survey) -> Vec<Mistake> {
    let mut all = vec![
        mistake(
            "sign_of_across_angle",
            "with the across-track angle reversed",
            "check the sign of the beam angles: positive is to starboard",
            |s| {
                negate(&mut s.campaign.soundings.across_rad);
            },
        ),
        mistake(
            "beam_angle_unit",
            "with the beam angles taken as radians",
            "the beam angles look like radians: give degrees",
            |s| {
                scale(&mut s.campaign.soundings.across_rad, 180.0 / PI);
                scale(&mut s.campaign.soundings.along_rad, 180.0 / PI);
            },
        ),
        mistake(
            "beam_angle_unit",
            "with the beam angles counted from the horizontal",
            "the beam angles look counted from the horizontal: 0 is straight below the sounder",
            |s| {
                let angles = s.campaign.soundings.across_rad.iter_mut();
                angles.for_each(|angle| *angle = from_below(*angle));
            },
        ),
    ];
    if survey
        .campaign
        .soundings
        .along_rad
        .iter()
        .any(|angle| *angle != 0.0)
    {
        all.push(mistake(
            "sign_of_along_angle",
            "with the along-track angle reversed",
            "check the sign of the along-track angles: positive is forward",
            |s| {
                negate(&mut s.campaign.soundings.along_rad);
            },
        ));
    }
    all
}

fn of_ranges(survey: &Survey) -> Vec<Mistake> {
    if let SoundingRange::TwoWayTravelTime(_) = survey.campaign.soundings.range {
        return vec![
            mistake(
                "one_way_time",
                "with the travel times taken as one-way",
                "the travel times look one-way: give two-way times",
                |s| {
                    scale_ranges(s, 2.0);
                },
            ),
            mistake(
                "travel_time_doubled",
                "with the travel times halved",
                "the travel times are twice as long as they fit",
                |s| {
                    scale_ranges(s, 0.5);
                },
            ),
        ];
    }
    vec![
        mistake(
            "range_doubled",
            "with the ranges halved",
            "the ranges are twice as long as they fit: sum of both ways?",
            |s| {
                scale_ranges(s, 0.5);
            },
        ),
        mistake(
            "range_halved",
            "with the ranges doubled",
            "the ranges are half as long as they fit",
            |s| {
                scale_ranges(s, 2.0);
            },
        ),
        mistake(
            "range_unit",
            "with the ranges taken as feet",
            "check the unit of the ranges: they look like feet",
            |s| {
                scale_ranges(s, 0.3048);
            },
        ),
        mistake(
            "range_unit",
            "with the ranges taken as millimetres",
            "check the unit of the ranges: they look like millimetres",
            |s| {
                scale_ranges(s, 1e-3);
            },
        ),
        mistake(
            "range_unit",
            "with the ranges taken as depths below the sounder",
            "the ranges look like depths: give the distance along the beam",
            from_depths,
        ),
    ]
}

/// Ranges from depths below the sounder.
fn from_depths(survey: &mut Survey) {
    let soundings = &mut survey.campaign.soundings;
    if let SoundingRange::Metres(values) = &mut soundings.range {
        let angles = soundings.across_rad.iter();
        let both = values.iter_mut().zip(angles);
        both.for_each(|(value, angle)| *value = along_the_beam(*value, *angle));
    }
}

fn of_axes_and_clocks() -> Vec<Mistake> {
    vec![
        mistake(
            "axes_of_sounder_arm",
            "with the sounder's lever arm read as forward, right, down",
            "check the axes of the sounder's lever arm: x right, y forward, z up",
            |s| {
                let arm_m = &mut s.campaign.sonar.lever_arm_m;
                *arm_m = from_forward_right_down(arm_m);
            },
        ),
        mistake(
            "axes_of_scanner_arm",
            "with the scanner's lever arm read as forward, right, down",
            "check the axes of the scanner's lever arm: x right, y forward, z up",
            |s| {
                let arm_m = &mut s.campaign.scanner.lever_arm_m;
                *arm_m = from_forward_right_down(arm_m);
            },
        ),
        mistake(
            "target_azimuth",
            "with the azimuth turned by 180 deg",
            "[target] azimuth_deg fits when turned by 180 deg: it is the direction of the +Y axis",
            |s| {
                s.prior.azimuth_rad += PI;
            },
        ),
        mistake(
            "sounder_clock",
            "with the sounder's clock 18 s earlier",
            "the sounder's times look like UTC, the others like GPS time: set time_offset_s",
            |s| {
                shift(&mut s.campaign.soundings.time_s, -18.0);
            },
        ),
        mistake(
            "sounder_clock",
            "with the sounder's clock 18 s later",
            "the sounder's times look like GPS time, the others like UTC: set time_offset_s",
            |s| {
                shift(&mut s.campaign.soundings.time_s, 18.0);
            },
        ),
        mistake(
            "range_noise",
            "with ten times the stated noise of the ranges",
            "the soundings' noise is about ten times the stated one: check range_sigma_m",
            |s| {
                s.campaign.soundings.noise.range_m *= 10.0;
            },
        ),
        mistake(
            "range_noise",
            "with a thousandth of the stated noise of the ranges",
            "range_sigma_m looks like millimetres: give metres",
            |s| {
                s.campaign.soundings.noise.range_m *= 1e-3;
            },
        ),
    ]
}

/// Heights of the target's origin above the middle of the returns that are tried, metres: the scanner sees the upper half.
const HEIGHTS_M: [f64; 4] = [0.0, -1.0, -2.0, -3.0];

/// The stated origin far from the target that the returns themselves show.
fn misplaced(survey: &Survey, input: &PoolInput) -> Option<Mistake> {
    let scene = Scene::prepare(&survey.campaign, input.target, &survey.prior).ok()?;
    let middle_m = middle(&scene)?;
    let fitted = HEIGHTS_M.iter().filter_map(|height_m| {
        let place = middle_m + Vector3::new(0.0, 0.0, *height_m);
        let moved = survey.prior.moved(&place, 0.0);
        let found = Scene::prepare(&survey.campaign, input.target, &moved).ok()?;
        (found.laser_near > 0).then_some((found.laser_fit, found.pose))
    });
    let (_, pose) = fitted.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let words = moved_by(&survey.prior, &pose);
    let prior = TargetPose {
        azimuth_rad: survey.prior.azimuth_rad,
        ..pose
    };
    Some(Mistake {
        alternative: Alternative::new(
            "target_origin",
            format!("with the target's origin {words} of where [target] puts it"),
            "check [target] origin: its coordinates, their datum, and whether its height is ellipsoidal",
        ),
        undo: Box::new(move |survey| survey.prior = prior),
    })
}

/// Median of the returns in the target frame, metres.
fn middle(scene: &Scene) -> Option<Vector3<f64>> {
    let count = scene.campaign.laser.len();
    let points = (0..count).filter_map(|j| scene.laser_point(j).map(|(point, _)| point));
    let points: Vec<Vector3<f64>> = points.collect();
    let median = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    Some(Vector3::new(median(0)?, median(1)?, median(2)?))
}

/// Where a pose's origin lies from another's: "50.0 m to the south (182 deg) and 0.3 m above".
fn moved_by(from: &TargetPose, to: &TargetPose) -> String {
    let (a, b) = (&from.origin, &to.origin);
    let there =
        from.ellipsoid.to_geocentric(b).coordinates - from.ellipsoid.to_geocentric(a).coordinates;
    let level = ecef_from_level(a).matrix.tr_mul(&there);
    let azimuth_deg = math::atan2(level.x, level.y)
        .to_degrees()
        .round()
        .rem_euclid(360.0)
        + 0.0; // no "-0"
    let compass = [
        "north",
        "north-east",
        "east",
        "south-east",
        "south",
        "south-west",
        "west",
        "north-west",
    ];
    let toward = compass[((azimuth_deg / 45.0).round() as usize) % 8];
    let height = if level.z < 0.0 { "below" } else { "above" };
    format!(
        "{:.1} m to the {toward} ({azimuth_deg:.0} deg) and {:.1} m {height}",
        math::hypot(level.x, level.y),
        level.z.abs()
    )
}

fn negate(values: &mut [f64]) {
    scale(values, -1.0);
}

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn shift(values: &mut [f64], by: f64) {
    values.iter_mut().for_each(|value| *value += by);
}

fn scale_attitude(survey: &mut Survey, factor: f64) {
    let t = &mut survey.campaign.trajectory;
    for angles in [&mut t.roll_rad, &mut t.pitch_rad, &mut t.heading_rad] {
        scale(angles, factor);
    }
}

fn scale_ranges(survey: &mut Survey, factor: f64) {
    let (SoundingRange::Metres(values) | SoundingRange::TwoWayTravelTime(values)) =
        &mut survey.campaign.soundings.range;
    scale(values, factor);
}

/// Evenly chosen observations of both sensors.
fn thinned(input: &PoolInput) -> Survey {
    let campaign = input.campaign;
    Survey {
        campaign: Campaign {
            trajectory: campaign.trajectory.clone(),
            laser: thinned_returns(&campaign.laser),
            soundings: {
                let soundings = &campaign.soundings;
                soundings.every(soundings.len().div_ceil(SOUNDINGS))
            },
            scanner: campaign.scanner,
            scanner_sigma: campaign.scanner_sigma,
            sonar: campaign.sonar,
            sound_speed: campaign.sound_speed.clone(),
            water_level_m: campaign.water_level_m,
        },
        prior: *input.prior,
    }
}

/// Every so manieth value, so that at most `most` of `count` are left.
fn every<T: Copy>(values: &[T], count: usize, most: usize) -> Vec<T> {
    values
        .iter()
        .step_by(count.div_ceil(most).max(1))
        .copied()
        .collect()
}

fn thinned_returns(laser: &LaserScan) -> LaserScan {
    let every = |values: &Vec<f64>| every(values, laser.len(), RETURNS);
    LaserScan {
        time_s: every(&laser.time_s),
        x_m: every(&laser.x_m),
        y_m: every(&laser.y_m),
        z_m: every(&laser.z_m),
        coordinates: laser.coordinates,
        noise: laser.noise,
    }
}
