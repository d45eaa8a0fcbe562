//! What speaks against a USBL calibration: its doubts, parts, shares and discrete mistakes, handed to the common verdict.
//!
//! Columns of the score tests, `a` being the derivative of a direction's condition by a turn of the body in the level frame, `t` the same
//! in the body's axes, `w` the body's rate:
//!
//! | unknown | column |
//! |---|---|
//! | stamps of the fixes late against the attitude | `-a . w` |
//! | offset of the range | `-1` |
//! | scale of roll and pitch, and what each takes from the other | `roll t . y`, `pitch t . x'`, `pitch t . y`, `roll t . x'` |
//! | scale of heading | `heading a . up`, clockwise |
//! | a beacon, or the transducer, elsewhere than surveyed | those of its place |

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::UsblInput;
use super::conditions::{ANGLES, Blocks, PER_FIX, RANGES};
use super::joint::{self, JointOutcome, sought};
use super::observed::UsblCampaign;
use super::scene::Scene;
use crate::adjust::{
    AdjustError, Component, FitTest, ParameterSet, Problem, Quality, Row, ScoreColumns, Solution,
    Solved, Unit, prior_tests,
};
use crate::calibrate::verdict::alternatives::{self, Otherwise, best};
use crate::calibrate::verdict::bounds::{Correction, Share, share, size};
use crate::calibrate::verdict::doubts::{self, Doubt, Doubted, append};
use crate::calibrate::verdict::fit::{self, Part};
use crate::calibrate::verdict::{Alternative, Tried, VerdictConfig, accepted};
use crate::geometry::rotation::{from_attitude, log, to_attitude};
use crate::math;
use crate::observe::Trajectory;
use crate::results::{Finding, Severity};
use crate::stats::Moments;
use crate::units::wrap_angle;

/// Seconds before and after a fix over which the body's rate is taken.
const HALF_S: f64 = 0.1;

/// Chi-square up to which a scale of heading withdraws nothing: 3 of 400 right surveys of `usbl-thin` had 14 to 17.
const HEADING_CERTAIN: f64 = 25.0;

/// A solution with what it is judged by.
pub(super) struct Case<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) blocks: &'a Blocks,
    pub(super) solution: &'a Solution,
    pub(super) quality: &'a Quality,
    /// Rows of the fixes used.
    pub(super) used: &'a [u32],
    /// Limits.
    pub(super) config: &'a VerdictConfig,
}

/// The doubts of a USBL calibration.
struct Doubts<'a> {
    scene: &'a Scene<'a>,
    used: &'a [u32],
    /// Column of the datum's turn, whose derivatives a row holds.
    datum: usize,
    /// First columns of the places: of the unknown in a row, and of the doubt.
    places: Vec<(usize, usize)>,
    /// What is doubted, in the order of the columns.
    list: Vec<Doubt>,
    rates: Vec<Vector3<f64>>,
}

/// What is doubted of the sensors, in the order of the columns.
///
/// A scale's column holds the attitude as measured, noise included, so that its estimate has the mean `-sigma^2 / v` with the variance
/// `v` of what the boat turned (errors in variables, Fuller 1987, section 1.1); it is heard beyond three times that. What the mounting and the
/// datum take of the heading's variation makes that mean larger: see [`HEADING_CERTAIN`].
fn of_sensors(scene: &Scene, used: &[u32]) -> Vec<Doubt> {
    let noise = &scene.campaign.attitude_noise;
    let turned = |angle: usize| used.iter().map(move |fix| attitude(scene, *fix)[angle]);
    let by_noise = |sigma_rad: f64, angle: usize| 3.0 * sigma_rad.powi(2) / variance(turned(angle));
    let level = [0, 1].map(|angle| by_noise(noise.roll_pitch_rad, angle));
    let heading = by_noise(noise.heading_rad, 2);
    let scales = [
        "roll scale",
        "pitch scale",
        "roll by pitch",
        "pitch by roll",
    ];
    vec![
        Doubt::single(
            "latency",
            "the fixes' time stamps look late compared with the attitude",
            Unit::Second,
            "correct [fixes] time_offset_s, or check the attitude sensor's clock",
        ),
        Doubt::single(
            "range_offset",
            "the ranges look too short by a constant",
            Unit::Metre,
            "check the transponders' turn-around time",
        ),
        Doubt::several(
            "attitude_scale",
            "the recorded roll and pitch do not match the boat's motion",
            scales.map(|name| Component::new(name, Unit::One)).to_vec(),
            "check signs, order and unit of roll and pitch, and the axes of the attitude sensor (-200 % is a wrong sign)",
        )
        .beyond(level[0].max(level[1])),
        Doubt::single(
            "heading_scale",
            "the recorded heading does not match the boat's motion",
            Unit::One,
            "check the sign and unit of heading (-200 % is a wrong sign)",
        )
        .beyond(heading)
        .withdrawing_beyond(HEADING_CERTAIN),
    ]
}

/// That a point stands elsewhere than surveyed.
fn misplaced(code: &str, name: &str) -> Doubt {
    let what = format!("{name} is not where it was surveyed");
    let advice = "survey it again; check its coordinates and its name";
    let axes = ["east", "north", "up"].map(|axis| Component::new(axis, Unit::Metre));
    Doubt::several(code, &what, axes.to_vec(), advice)
}

/// Roll, pitch and heading at a fix; the heading against the first fix's, so that north is no seam.
fn attitude(scene: &Scene, fix: u32) -> [f64; 3] {
    let of = |fix: usize| to_attitude(&scene.poses[fix].rotation);
    let (roll, pitch, heading) = of(fix as usize);
    [roll, pitch, wrap_angle(heading - of(0).2)]
}

/// Variance about the mean; 0 without values.
fn variance(values: impl Iterator<Item = f64>) -> f64 {
    let mut moments = Moments::new(1);
    values.for_each(|value| moments.add(&[value]));
    moments.variance().map_or(0.0, |v| v[0])
}

impl<'a> Doubts<'a> {
    fn of(scene: &'a Scene<'a>, used: &'a [u32], blocks: &Blocks, x: &ParameterSet) -> Self {
        let rate = |fix: &u32| {
            rate(
                &scene.campaign.attitude,
                scene.campaign.fixes.time_s[*fix as usize],
            )
        };
        let mut list = of_sensors(scene, used);
        let mut place = |id, doubt| (x.offset(id), append(&mut list, doubt));
        let transducer = misplaced("transducer_position", "the transducer");
        let mut places = vec![place(blocks.transducer, transducer)];
        let fixes = &scene.campaign.fixes;
        let beacons: BTreeSet<u32> = used.iter().map(|k| fixes.beacon[*k as usize]).collect();
        for beacon in beacons.into_iter().map(|beacon| beacon as usize) {
            if let Some(id) = blocks.beacons[beacon] {
                let name = format!("beacon {}", scene.campaign.beacons[beacon].point.name);
                places.push(place(id, misplaced("beacon_position", &name)));
            }
        }
        Self {
            scene,
            used,
            datum: x.offset(blocks.datum),
            places,
            list,
            rates: used.iter().map(rate).collect(),
        }
    }
}

/// The body's rate in the level frame, radians per second; zero at the ends of the record.
fn rate(attitude: &Trajectory, time_s: f64) -> Vector3<f64> {
    let pair = (
        attitude.pose_at(time_s - HALF_S),
        attitude.pose_at(time_s + HALF_S),
    );
    let (Ok(before), Ok(after)) = pair else {
        return Vector3::zeros();
    };
    log(&(after.rotation * before.rotation.transpose())) / (2.0 * HALF_S)
}

impl ScoreColumns for Doubts<'_> {
    fn derive(&self, k: usize, _: &Solved, row: &Row, push: &mut dyn FnMut(usize, f64)) {
        for (place, column) in &self.places {
            for (c, value) in row.columns().iter().zip(row.values()) {
                let axis = usize::from(*c).wrapping_sub(*place);
                if axis < 3 {
                    push(column + axis, *value);
                }
            }
        }
        if k.is_multiple_of(PER_FIX) {
            push(1, -1.0);
            return;
        }
        let fix = k / PER_FIX;
        let Some(first) = row
            .columns()
            .iter()
            .position(|c| usize::from(*c) == self.datum)
        else {
            return;
        };
        let by_turn = Vector3::from_column_slice(&row.values()[first..first + 3]);
        let pose = &self.scene.poses[self.used[fix] as usize];
        let (roll, pitch, heading) = to_attitude(&pose.rotation);
        let in_body = pose.rotation.tr_mul(&by_turn);
        let by_pitch = in_body.x * math::cos(roll) + in_body.z * math::sin(roll);
        push(0, -by_turn.dot(&self.rates[fix]));
        push(2, in_body.y * roll);
        push(3, by_pitch * pitch);
        push(4, in_body.y * pitch);
        push(5, by_pitch * roll);
        push(6, -by_turn.z * heading);
    }
}

impl Case<'_> {
    /// Findings in the order of their importance, and the bounds of every doubt.
    pub(super) fn heard(&self, problem: &Problem) -> Result<Doubted, AdjustError> {
        let doubted = self.doubts(problem)?;
        let mut findings = doubted.findings;
        findings.extend(self.beacons(self.config)); // they explain a share that is too small
        let all = Share {
            name: "fixes of common beacons".to_owned(),
            candidates: self.scene.common.len(),
            used: self.used.len(),
        };
        findings.extend(share(&all, self.config));
        findings.extend(fit::priors(&prior_tests(self.solution), self.config));
        let (whole, parts) = self.fits()?;
        findings.extend(fit::whole(&whole, self.config));
        findings.extend(fit::parts(&parts, self.config));
        findings.extend(size(&self.correction(), self.config));
        Ok(Doubted {
            findings: accepted(findings, self.config),
            bounds: doubted.bounds,
        })
    }

    fn doubts(&self, problem: &Problem) -> Result<Doubted, AdjustError> {
        let x = &self.solution.estimate.parameters;
        let columns = Doubts::of(self.scene, self.used, self.blocks, x);
        let names = sought().into_iter().take(3).enumerate();
        let wanted: Vec<(String, usize)> =
            names.map(|(i, (name, _))| (name.to_owned(), i)).collect();
        let global = &self.quality.global;
        let misfit = (global.omega, global.degrees_of_freedom);
        doubts::test(
            (problem, self.solution),
            &columns.list,
            &[Some(&columns)],
            &wanted,
            misfit,
        )
    }

    fn fits(&self) -> Result<(FitTest, Vec<Part>), AdjustError> {
        let kernel = self.solution.kernel;
        let part = |code, name: String, test, advice: &str, strict| Part {
            code,
            name,
            test,
            advice: advice.to_owned(),
            strict,
        };
        let mut parts = vec![];
        for group in &self.quality.groups {
            let test = FitTest::of(group, kernel);
            parts.push(match group.group {
                RANGES => part(
                    "noise",
                    "the ranges".to_owned(),
                    test,
                    "check [fixes] range_sigma_m and the sound speed",
                    true,
                ),
                ANGLES => part(
                    "noise",
                    "the angles".to_owned(),
                    test,
                    "check [fixes] angle_sigma_deg, and the attitude's signs and noise",
                    true,
                ),
                _ => continue,
            });
        }
        let freedom = self.quality.global.degrees_of_freedom;
        let conditions = parts.iter().map(|part| part.test);
        let (whole, chain) = fit::together(conditions, self.solution, freedom)?;
        let advice = "check the attitude's standard deviations; is its noise white, or does it wander (coloured noise)?";
        parts.push(part(
            "attitude",
            "the attitude's estimated errors".to_owned(),
            chain,
            advice,
            false,
        ));
        for cell in &self.quality.cells {
            let Some(beacon) = self.scene.campaign.beacons.get(usize::from(cell.group)) else {
                continue;
            };
            let name = format!("the fixes of beacon {}", beacon.point.name);
            parts.push(part(
                "beacon",
                name,
                FitTest::of(cell, kernel),
                "check its coordinates and its signal",
                false,
            ));
        }
        Ok((whole, parts))
    }

    fn correction(&self) -> Correction {
        let found = self
            .solution
            .estimate
            .parameters
            .rotation(self.blocks.mounting);
        correction(&found, self.scene)
    }

    /// Beacons many of whose fixes were rejected.
    fn beacons(&self, config: &VerdictConfig) -> Vec<Finding> {
        let fixes = &self.scene.campaign.fixes;
        let of = |rows: &[u32], beacon: u32| {
            rows.iter()
                .filter(|fix| fixes.beacon[**fix as usize] == beacon)
                .count()
        };
        let one = |beacon: u32| {
            let (all, used) = (of(&self.scene.common, beacon), of(self.used, beacon));
            let few = (used as f64) < config.good_share * all as f64;
            few.then(|| {
                let name = &self.scene.campaign.beacons[beacon as usize].point.name;
                let seen = if used == 0 {
                    format!("all {all} fixes of beacon {name} disagree with the rest and were rejected")
                } else {
                    format!("{} of {all} fixes of beacon {name} disagree with the rest and were rejected", all - used)
                };
                let advice = "has the beacon moved, or are its coordinates wrong? Survey it again, or give it the role check";
                let threshold = format!("{:.0} % of a beacon's fixes", 100.0 * config.good_share);
                Finding::new("beacon", Severity::Finding, seen, threshold, advice)
            })
        };
        self.scene
            .common_beacons()
            .into_iter()
            .filter_map(one)
            .collect()
    }
}

/// How far a mounting lies from the nominal one; the transducer has no nominal lever arm.
fn correction(found: &Matrix3<f64>, scene: &Scene) -> Correction {
    let turn: Matrix3<f64> = found * scene.campaign.nominal.transpose();
    Correction {
        name: "the transducer".to_owned(),
        turn_rad: log(&turn).norm(),
        arm_m: 0.0,
    }
}

impl JointOutcome {
    /// By how many of its sigmas each angle of the mounting is another in a second outcome.
    fn moved_to(&self, other: &Self) -> BTreeMap<String, f64> {
        let turn: Matrix3<f64> = other.rotation * self.rotation.transpose();
        let turn = log(&turn);
        let one = |(i, (name, _)): (usize, (&str, Unit))| {
            let sigma = self.covariance[(i, i)].sqrt();
            (name.to_owned(), turn[i] / sigma)
        };
        sought().into_iter().take(3).enumerate().map(one).collect()
    }

    /// Weighted squares of everything, where it was judged.
    fn squares(&self) -> Option<f64> {
        self.judgement.as_ref().map(|j| j.quality.global.omega)
    }

    fn tried(&self, scene: &Scene, config: &VerdictConfig) -> Tried {
        Tried {
            share: self.used.len() as f64 / scene.common.len().max(1) as f64,
            variance_factor: self
                .judgement
                .as_ref()
                .map(|j| j.quality.global.variance_factor),
            oversize: size(&correction(&self.rotation, scene), config).is_some(),
        }
    }
}

/// Share of the fixes that fit beside one beacon of three that stands elsewhere.
const LEAST_BESIDE: f64 = 0.6;

/// Names the discrete mistake that turns the misfit of a USBL calibration into a fit, if there is one.
#[must_use]
pub fn named(input: &UsblInput, scene: &Scene, as_given: Option<&JointOutcome>) -> Option<Finding> {
    let config = &input.joint.verdict;
    let given = as_given.map_or(Tried::default(), |joint| joint.tried(scene, config));
    let mut all = of_attitude();
    all.extend(of_fixes());
    // a beacon elsewhere than surveyed scatters its fixes as more noise would, but not those of the others
    let misplaced = given.share > LEAST_BESIDE
        && as_given.is_some_and(|joint| {
            let mut findings = joint.doubted.findings.iter();
            findings.any(|finding| finding.code == "beacon_position")
        });
    if !misplaced {
        all.extend(of_noise());
    }
    all.extend(of_layout(scene));
    all.extend(of_names(scene));
    let tried: Vec<(Alternative, Tried)> = all
        .into_iter()
        .filter_map(|mistake| {
            let tried = mistake.undone(input, |scene, found| found.tried(scene, config))?;
            Some((mistake.alternative, tried))
        })
        .collect();
    best(&given, &tried, "the fixes of common beacons")
}

/// A sign or order of the attitude that a survey which fits does not decide, or decides against what is given. On a boat nearly at rest
/// the mounting takes up all of it but the boat's little motion.
#[must_use]
pub fn preferred(input: &UsblInput, as_given: &JointOutcome) -> Vec<Finding> {
    let config = &input.joint.verdict;
    if config.accept.iter().any(|code| code == "attitude_scale") {
        return vec![];
    }
    let Some(given) = as_given.squares() else {
        return vec![];
    };
    let tried = of_signs().into_iter().filter_map(|mistake| {
        let otherwise = |scene: &Scene, found: JointOutcome| {
            let comparable = found.used.len() >= as_given.used.len();
            let plausible = size(&correction(&found.rotation, scene), config).is_none();
            let squares = found.squares().filter(|_| comparable && plausible)?;
            Some((given - squares, as_given.moved_to(&found)))
        };
        let (gain, moved) = mistake.undone(input, otherwise)??;
        Some(Otherwise {
            alternative: mistake.alternative,
            gain,
            moved,
        })
    });
    alternatives::preferred(tried)
}

/// A mistake and how it is undone.
struct Mistake {
    alternative: Alternative,
    undo: Box<dyn Fn(&mut UsblCampaign)>,
}

impl Mistake {
    fn new(
        code: &'static str,
        words: impl Into<String>,
        advice: &'static str,
        undo: impl Fn(&mut UsblCampaign) + 'static,
    ) -> Self {
        Self {
            alternative: Alternative::new(code, words, advice),
            undo: Box::new(undo),
        }
    }

    /// What comes of the joint path without the mistake, where it comes to an end.
    fn undone<T>(
        &self,
        input: &UsblInput,
        then: impl FnOnce(&Scene, JointOutcome) -> T,
    ) -> Option<T> {
        let mut campaign = input.campaign.clone();
        (self.undo)(&mut campaign);
        let scene = Scene::new(&campaign).ok()?;
        let found = joint::run(&scene, &input.joint).ok()??;
        Some(then(&scene, found))
    }
}

/// Signs and order of the attitude, which a boat at rest hides best.
fn of_signs() -> Vec<Mistake> {
    vec![
        Mistake::new(
            "sign_of_roll",
            "with the sign of roll reversed",
            "check the sign of roll: positive is starboard down",
            |c| turned(c, |(roll, pitch, heading)| (-roll, pitch, heading)),
        ),
        Mistake::new(
            "sign_of_pitch",
            "with the sign of pitch reversed",
            "check the sign of pitch: positive is bow up",
            |c| turned(c, |(roll, pitch, heading)| (roll, -pitch, heading)),
        ),
        Mistake::new(
            "signs_of_roll_and_pitch",
            "with the signs of roll and pitch reversed",
            "check the signs of roll (positive is starboard down) and pitch (positive is bow up)",
            |c| turned(c, |(roll, pitch, heading)| (-roll, -pitch, heading)),
        ),
        Mistake::new(
            "sign_of_heading",
            "with the sign of heading reversed",
            "check the sign of heading: clockwise from north",
            |c| turned(c, |(roll, pitch, heading)| (roll, pitch, -heading)),
        ),
        Mistake::new(
            "roll_and_pitch_exchanged",
            "with roll and pitch exchanged",
            "check the order of the columns roll and pitch",
            |c| turned(c, |(roll, pitch, heading)| (pitch, roll, heading)),
        ),
    ]
}

/// Everything that can be wrong with the attitude.
fn of_attitude() -> Vec<Mistake> {
    let mut all = of_signs();
    all.push(Mistake::new(
        "attitude_in_radians",
        "with roll, pitch and heading taken as radians",
        "roll, pitch and heading look like radians: the attitude in radians is read as degrees",
        |c| {
            turned(c, |(roll, pitch, heading)| {
                (roll.to_degrees(), pitch.to_degrees(), heading.to_degrees())
            });
        },
    ));
    all.push(Mistake::new(
        "heading_turned",
        "with the heading turned by 180 deg",
        "the heading is that of the stern: turn it, or state [transducer] mounting_deg heading = 180 where the transducer sits so",
        |c| turned(c, |(roll, pitch, heading)| (roll, pitch, heading + PI)),
    ));
    all
}

/// Axes and units of the fixes.
fn of_fixes() -> Vec<Mistake> {
    vec![
        Mistake::new(
            "sign_of_x",
            "with the fixes' x reversed",
            "check the fixes' axes: x is right",
            |c| c.fixes.direction.iter_mut().for_each(|d| d.x = -d.x),
        ),
        Mistake::new(
            "sign_of_y",
            "with the fixes' y reversed",
            "check the fixes' axes: y is forward",
            |c| c.fixes.direction.iter_mut().for_each(|d| d.y = -d.y),
        ),
        Mistake::new(
            "axes_exchanged",
            "with the fixes' x and y exchanged",
            "check the fixes' axes: x is right, y is forward",
            |c| c.fixes.direction.iter_mut().for_each(|d| d.swap_rows(0, 1)),
        ),
        Mistake::new(
            "angles_in_gon",
            "with the angles taken as gon",
            "the angles look like gon: give degrees",
            |c| c.fixes.direction.iter_mut().for_each(from_gon),
        ),
        Mistake::new(
            "two_way_time",
            "with the travel times halved",
            "the travel times look like two-way times",
            |c| c.fixes.travel_time_s.iter_mut().for_each(|t| *t *= 0.5),
        ),
        Mistake::new(
            "half_time",
            "with the travel times doubled",
            "the travel times are half as long as they fit",
            |c| c.fixes.travel_time_s.iter_mut().for_each(|t| *t *= 2.0),
        ),
        Mistake::new(
            "time_in_milliseconds",
            "with the travel times taken as milliseconds",
            "the travel times look like milliseconds: give seconds",
            |c| c.fixes.travel_time_s.iter_mut().for_each(|t| *t *= 1e-3),
        ),
    ]
}

/// A direction whose two angles to the axes were read as degrees and are gon.
fn from_gon(direction: &mut Vector3<f64>) {
    const GON: f64 = 0.9;
    let [x, y] = [direction.x, direction.y].map(|cosine| math::cos(GON * math::acos(cosine)));
    let down = (1.0 - x * x - y * y).max(0.0).sqrt();
    *direction = Vector3::new(x, y, direction.z.signum() * down);
}

/// Noise stated far too small.
fn of_noise() -> Vec<Mistake> {
    vec![
        Mistake::new(
            "angle_noise",
            "with ten times the stated noise of the angles",
            "the angles' noise is about ten times the stated one: check [fixes] angle_sigma_deg",
            |c| c.fixes.noise.angle_rad *= 10.0,
        ),
        Mistake::new(
            "range_noise",
            "with ten times the stated noise of the ranges",
            "the ranges' noise is about ten times the stated one: check [fixes] range_sigma_m",
            |c| c.fixes.noise.range_m *= 10.0,
        ),
    ]
}

/// Travel times all too long or too short by as much, against those between the surveyed places.
fn of_layout(scene: &Scene) -> Option<Mistake> {
    let fixes = &scene.campaign.fixes;
    let late = |fix: &u32| {
        let beacon = &scene.campaign.beacons[fixes.beacon[*fix as usize] as usize];
        let place = &scene.campaign.transducer.position_m;
        let ray = scene.ray(place, &beacon.point.position_m).ok()?;
        Some(fixes.travel_time_s[*fix as usize] - ray.time_s)
    };
    let mut late_s: Vec<f64> = scene.common.iter().filter_map(late).collect();
    late_s.sort_by(f64::total_cmp);
    let late_s = *late_s.get(late_s.len() / 2)?;
    let shortest = fixes.travel_time_s.iter().copied().fold(f64::MAX, f64::min);
    (late_s < shortest).then(|| {
        Mistake::new(
            "range_offset",
            format!(
                "with the ranges {:.3} m {}",
                (late_s * fixes.speed_m_s).abs(),
                if late_s > 0.0 { "shorter" } else { "longer" }
            ),
            "check the transponders' turn-around time ([fixes] turnaround_s) and the sound speed",
            move |c| c.fixes.travel_time_s.iter_mut().for_each(|t| *t -= late_s),
        )
    })
}

/// Beacons whose exchange for each other is tried at the most.
const MOST_BEACONS: usize = 6;

/// Two beacons whose names are exchanged.
fn of_names(scene: &Scene) -> Vec<Mistake> {
    let beacons = scene.common_beacons();
    let name = |beacon: u32| scene.campaign.beacons[beacon as usize].point.name.as_str();
    let pair = |a: u32, b: u32| {
        Mistake::new(
            "beacons_exchanged",
            format!("with beacons {} and {} exchanged", name(a), name(b)),
            "check which beacon answers by which name, and the control file",
            move |c| {
                c.fixes
                    .beacon
                    .iter_mut()
                    .for_each(|x| *x = other_of((a, b), *x));
            },
        )
    };
    let firsts = beacons.iter().take(MOST_BEACONS).enumerate();
    let pairs = firsts.flat_map(|(i, a)| {
        let seconds = beacons.iter().take(MOST_BEACONS).skip(i + 1);
        seconds.map(move |b| pair(*a, *b))
    });
    pairs.collect()
}

fn other_of((a, b): (u32, u32), beacon: u32) -> u32 {
    match beacon {
        x if x == a => b,
        x if x == b => a,
        x => x,
    }
}

/// Roll, pitch and heading, radians.
type Angles = (f64, f64, f64);

/// Changes every attitude's roll, pitch and heading.
fn turned(campaign: &mut UsblCampaign, change: fn(Angles) -> Angles) {
    let record = &campaign.attitude;
    let attitudes = record.attitudes().iter().map(|r| {
        let (roll, pitch, heading) = change(to_attitude(r));
        from_attitude(roll, pitch, heading)
    });
    let attitudes = attitudes.collect();
    // gaps were judged when the fixes got their attitude
    campaign.attitude = Trajectory::new(
        record.times_s().to_vec(),
        record.positions_m().to_vec(),
        attitudes,
        None,
        f64::INFINITY,
    );
}
