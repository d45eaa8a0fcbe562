//! Discrete mistakes in a rail survey: tried on a thinned set when it does not fit, and signs of the INS on every survey.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::joint::RailJoint;
use super::observed::{ProfilePoints, RailCampaign};
use super::profile::BUILT_IN;
use super::profile::RailProfile;
use super::run::RailInput;
use super::scene::RailScene;
use super::trial::names;
use crate::calibrate::verdict::alternatives::{self, Otherwise, best};
use crate::calibrate::verdict::{Alternative, Tried};
use crate::geometry::rotation::log;
use crate::results::Finding;

impl RailJoint {
    /// Share of the resting points of the worst-off profiler that are used, or of the INS' attitudes, and the variance factor.
    fn tried(&self, scene: &RailScene) -> Tried {
        let profilers = scene.campaign.profilers.len();
        let (mut all, mut used) = (vec![0usize; profilers], vec![0usize; profilers]);
        let of = |row: u32| scene.campaign.points.profiler[row as usize] as usize;
        scene
            .points
            .iter()
            .for_each(|point| all[of(point.row)] += 1);
        self.ties.iter().for_each(|tie| used[of(tie.row)] += 1);
        let shares = all
            .iter()
            .zip(&used)
            .map(|(all, used)| *used as f64 / (*all).max(1) as f64);
        Tried {
            share: shares.fold(self.ins_share, f64::min),
            variance_factor: Some(self.quality.global.variance_factor),
            oversize: false,
        }
    }
}

/// Whether fewer points of a profiler lie on the rail than should, though enough for a result: a mistake may be why.
#[must_use]
pub fn is_thin(joint: &RailJoint) -> bool {
    let mut findings = joint.doubted.findings.iter();
    findings.any(|finding| finding.code == "share" && !finding.accepted)
}

/// Names the discrete mistake that turns the misfit of a rail calibration into a fit, if there is one.
#[must_use]
pub fn named(input: &RailInput, as_given: &RailJoint) -> Option<Finding> {
    let survey = thinned(input.campaign);
    let mut tried: Vec<(Alternative, Tried)> = vec![];
    for name in BUILT_IN {
        let Some(rail) = RailProfile::built_in(name).filter(|rail| rail.name != input.rail.name)
        else {
            continue;
        };
        let alternative = Alternative::new(
            "other_rail",
            format!("with the built-in rail {name}"),
            "another rail profile fits better: check [rail] model",
        );
        tried.extend(fitted(&survey, &rail, input).map(|found| (alternative, found)));
    }
    let all = mistakes(&survey).into_par_iter();
    let undone: Vec<_> = all
        .filter_map(|(alternative, undo)| {
            let mut undone = survey.clone();
            undo(&mut undone);
            fitted(&undone, input.rail, input).map(|found| (alternative, found))
        })
        .collect();
    tried.extend(undone);
    let given = as_given.tried(&RailScene::new(input.campaign, input.rail));
    best(
        &given,
        &tried,
        "each profiler's points and the INS' attitudes",
    )
}

impl RailJoint {
    /// By how many of its sigmas each parameter is another in a second outcome.
    fn moved_to(&self, other: &Self, names: Vec<String>) -> BTreeMap<String, f64> {
        let pairs = self.mountings.iter().zip(&other.mountings);
        let off = pairs.flat_map(|(a, b)| {
            let turn = log(&(b.rotation * a.rotation.transpose()));
            let arm = b.lever_arm_m - a.lever_arm_m;
            [turn.x, turn.y, turn.z, arm.x, arm.z]
        });
        let sigmas = off.enumerate().map(|(k, off)| {
            let sigma = self.covariance[(k, k)].sqrt();
            off / sigma
        });
        names.into_iter().zip(sigmas).collect()
    }

    /// Weighted squares of everything; an observation that is out counts as one that lies just beyond its limit.
    fn squares(&self) -> f64 {
        let global = &self.quality.global;
        global.omega - OUT * global.degrees_of_freedom
    }
}

/// Weighted square that an observation counts which data snooping or the gate took out.
const OUT: f64 = 16.0;

/// A sign of the INS that a survey which fits does not decide, or decides against what is given: the seat of the beam takes up all of a
/// constant angle.
#[must_use]
pub fn preferred(input: &RailInput, as_given: &RailJoint) -> Vec<Finding> {
    if input.campaign.attitude.time_s.is_empty() {
        return vec![];
    }
    let tried = of_signs().into_iter().filter_map(|(alternative, undo)| {
        let mut undone = input.campaign.clone();
        undo(&mut undone);
        let scene = RailScene::new(&undone, input.rail);
        let found = super::joint::joint(&scene, input.joint, &as_given.mountings).ok()?;
        Some(Otherwise {
            alternative,
            gain: as_given.squares() - found.squares(),
            moved: as_given.moved_to(&found, names(&input.campaign.profilers)),
        })
    });
    alternatives::preferred(tried)
}

/// As [`named`], before the survey is solved: where much of it does not fit after the first round.
#[must_use]
pub fn suspected(input: &RailInput, scene: &RailScene, first: &RailJoint) -> Option<Finding> {
    let few = first.tried(scene).share < input.joint.verdict.good_share;
    few.then(|| named(input, first)).flatten()
}

/// Points that alternatives are tried with at the most.
const POINTS: usize = 8_000;

/// Evenly chosen points, so that every alternative is tried in a moment.
fn thinned(campaign: &RailCampaign) -> RailCampaign {
    let points = &campaign.points;
    let step = points.len().div_ceil(POINTS).max(1);
    let every = |values: &[f64]| values.iter().step_by(step).copied().collect();
    RailCampaign {
        points: ProfilePoints {
            time_s: every(&points.time_s),
            profiler: points.profiler.iter().step_by(step).copied().collect(),
            y_m: every(&points.y_m),
            z_m: every(&points.z_m),
        },
        ..campaign.clone()
    }
}

fn fitted(campaign: &RailCampaign, rail: &RailProfile, input: &RailInput) -> Option<Tried> {
    let scene = RailScene::new(campaign, rail);
    let start = super::run::start(&scene, input.reference).ok()?;
    let found = super::joint::joint(&scene, input.joint, &start).ok()?;
    Some(found.tried(&scene))
}

type Undo = Box<dyn Fn(&mut RailCampaign) + Send + Sync>;

fn mistakes(campaign: &RailCampaign) -> Vec<(Alternative, Undo)> {
    let mut all = of_points();
    all.extend(in_millimetres(campaign));
    all.extend(of_one_profiler(campaign));
    all.extend(of_table());
    all.extend(of_ins());
    all
}

fn one(
    code: &'static str,
    words: impl Into<String>,
    advice: &'static str,
    undo: impl Fn(&mut RailCampaign) + Send + Sync + 'static,
) -> (Alternative, Undo) {
    (Alternative::new(code, words, advice), Box::new(undo))
}

fn negate(values: &mut [f64]) {
    values.iter_mut().for_each(|value| *value = -*value);
}

fn to_degrees(values: &mut [f64]) {
    values
        .iter_mut()
        .for_each(|value| *value = value.to_degrees());
}

fn of_points() -> Vec<(Alternative, Undo)> {
    vec![
        one(
            "sign_of_lateral",
            "with the lateral coordinate reversed",
            "check the sign of y_m: positive is to the right",
            |c| negate(&mut c.points.y_m),
        ),
        one(
            "sign_of_vertical",
            "with the vertical coordinate reversed",
            "check the sign of z_m: positive is up, away from the rail",
            |c| negate(&mut c.points.z_m),
        ),
        one(
            "point_noise",
            "with ten times the stated noise of the points",
            "the points' noise is about ten times the stated one: check lateral_sigma_m and vertical_sigma_m",
            |c| {
                for profiler in &mut c.profilers {
                    profiler.lateral_sigma_m *= 10.0;
                    profiler.vertical_sigma_m *= 10.0;
                }
            },
        ),
        one(
            "profilers_exchanged",
            "with the profilers in reverse order",
            "check which profiler is which: they are numbered as in the survey file",
            |c| {
                let last = c.profilers.len().saturating_sub(1) as u32;
                let all = c.points.profiler.iter_mut();
                all.for_each(|profiler| *profiler = last.saturating_sub(*profiler));
            },
        ),
    ]
}

/// One profiler that looks the other way along the rail than the others.
fn of_one_profiler(campaign: &RailCampaign) -> Vec<(Alternative, Undo)> {
    let all = campaign.profilers.iter().zip(0_u32..);
    let reversed = all.map(|(profiler, number)| {
        let undo = move |c: &mut RailCampaign| {
            let points = &mut c.points;
            let own = points.y_m.iter_mut().zip(&points.profiler);
            own.filter(|(_, p)| **p == number)
                .for_each(|(y_m, _)| *y_m = -*y_m);
        };
        one(
            "sign_of_lateral",
            format!("with the lateral coordinate of {} reversed", profiler.name),
            "check the sign of that profiler's y_m, and whether it is mounted the other way round",
            undo,
        )
    });
    reversed.collect()
}

/// A profiler stands nearer to the rail than this, metres: shrunk to a thousandth, points that already are metres would all find a place on it.
const NEAR_M: f64 = 2.0;

fn in_millimetres(campaign: &RailCampaign) -> Option<(Alternative, Undo)> {
    let far = |z_m: &&f64| z_m.abs() > NEAR_M;
    let all = &campaign.points.z_m;
    let undo = one(
        "points_in_millimetres",
        "with the points taken as millimetres",
        "check the unit of y_m and z_m: they look like millimetres",
        |c| {
            let points = &mut c.points;
            let all = points.y_m.iter_mut().chain(&mut points.z_m);
            all.for_each(|value| *value *= 1e-3);
        },
    );
    (2 * all.iter().filter(far).count() > all.len()).then_some(undo)
}

fn of_table() -> Vec<(Alternative, Undo)> {
    vec![
        one(
            "sign_of_table_heading",
            "with the table's turn about the vertical reversed",
            "check the sign of the table's heading: clockwise",
            |c| negate(&mut c.table.heading_rad),
        ),
        one(
            "sign_of_table_pitch",
            "with the table's turn about the lateral axis reversed",
            "check the sign of the table's pitch: front up",
            |c| negate(&mut c.table.pitch_rad),
        ),
        one(
            "table_axes_exchanged",
            "with the table's two turns exchanged",
            "check the order of the table's columns heading and pitch",
            |c| std::mem::swap(&mut c.table.heading_rad, &mut c.table.pitch_rad),
        ),
        one(
            "table_in_radians",
            "with the table's angles taken as radians",
            "the table's angles look like radians: give degrees",
            |c| {
                to_degrees(&mut c.table.heading_rad);
                to_degrees(&mut c.table.pitch_rad);
            },
        ),
    ]
}

/// Signs of the INS, which the seat of the beam and the mountings take up where the table does not turn about that axis.
fn of_signs() -> Vec<(Alternative, Undo)> {
    vec![
        one(
            "sign_of_ins_roll",
            "with the sign of the INS' roll reversed",
            "check the sign of the INS' roll: positive is starboard down",
            |c| negate(&mut c.attitude.roll_rad),
        ),
        one(
            "sign_of_ins_pitch",
            "with the sign of the INS' pitch reversed",
            "check the sign of the INS' pitch: positive is bow up",
            |c| negate(&mut c.attitude.pitch_rad),
        ),
        one(
            "sign_of_ins_heading",
            "with the sign of the INS' heading reversed",
            "check the sign of the INS' heading: clockwise",
            |c| negate(&mut c.attitude.heading_rad),
        ),
    ]
}

fn of_ins() -> Vec<(Alternative, Undo)> {
    let mut all = of_signs();
    all.extend([
        one(
            "ins_roll_and_pitch_exchanged",
            "with the INS' roll and pitch exchanged",
            "check the order of the INS' columns roll and pitch",
            |c| std::mem::swap(&mut c.attitude.roll_rad, &mut c.attitude.pitch_rad),
        ),
        one(
            "ins_in_radians",
            "with the INS' angles taken as radians",
            "the INS' angles look like radians: give degrees",
            |c| {
                let a = &mut c.attitude;
                for angles in [&mut a.roll_rad, &mut a.pitch_rad, &mut a.heading_rad] {
                    to_degrees(angles);
                }
            },
        ),
    ]);
    all
}
