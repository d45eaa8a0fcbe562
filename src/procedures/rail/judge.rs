//! What speaks against a rail calibration: its parts, doubts, shares and corrections, handed to the common verdict.

use super::conditions::Tie;
use super::doubts::Doubts;
use super::joint::RailJoint;
use super::model::Blocks;
use super::run::RailInput;
use super::scene::RailScene;
use super::trial::names;
use crate::adjust::{AdjustError, FitTest, Problem, Quality, Solution, prior_tests};
use crate::calibrate::verdict::alternatives::best;
use crate::calibrate::verdict::bounds::{Correction, Share, share, size};
use crate::calibrate::verdict::doubts::{self, Doubted};
use crate::calibrate::verdict::fit::{self, Part};
use crate::calibrate::verdict::{Alternative, Tried, VerdictConfig, accepted};
use crate::observe::{ProfilePoints, RailCampaign};
use crate::results::{Finding, Severity};
use crate::target::RailProfile;
use crate::target::rail::BUILT_IN;

/// A solution with what it is judged by.
pub struct Case<'a> {
    /// The scene.
    pub scene: &'a RailScene<'a>,
    /// Handles of the parameters.
    pub blocks: &'a Blocks,
    /// The solution.
    pub solution: &'a Solution,
    /// Its judgement.
    pub quality: &'a Quality,
    /// Points used.
    pub ties: &'a [Tie],
    /// The INS' attitudes used.
    pub ins: InsShares,
    /// Limits.
    pub config: &'a VerdictConfig,
}

/// How many of the INS' mean attitudes agree with the rest, about each axis: data snooping could take out all that contradict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InsShares {
    /// Positions with a record.
    pub positions: usize,
    /// Positions used, about x, about y and in heading.
    pub used: [usize; 3],
}

impl InsShares {
    /// Of so many positions, three conditions each, and which of those conditions were switched off.
    #[must_use]
    pub fn of(positions: usize, ignored: Option<&Vec<bool>>) -> Self {
        let off = |axis: usize| {
            let mask = ignored.into_iter().flatten().enumerate();
            mask.filter(|(k, off)| k % 3 == axis && **off).count()
        };
        Self {
            positions,
            used: [0, 1, 2].map(|axis| positions - off(axis).min(positions)),
        }
    }

    /// Share of the worst-off axis; one without an INS.
    #[must_use]
    pub fn least(&self) -> f64 {
        let least = self.used.iter().min().copied().unwrap_or(0);
        if self.positions == 0 {
            1.0
        } else {
            least as f64 / self.positions as f64
        }
    }

    /// The axis that contradicts, if one does.
    fn finding(&self, config: &VerdictConfig) -> Option<Finding> {
        let axes = ["about x", "about y", "in heading"].iter().zip(self.used);
        let (axis, used) = axes.min_by_key(|(_, used)| *used)?;
        (self.least() < config.good_share).then(|| {
            Finding::new(
                "ins_attitude",
                Severity::Withdraws,
                format!(
                    "{} of {} of the INS' attitudes contradict the table {axis} and were rejected",
                    self.positions - used,
                    self.positions
                ),
                format!("{:.0} % that agree", 100.0 * config.good_share),
                "check the INS' signs, order and unit, its alignment, and the seat of the beam",
            )
        })
    }
}

/// Number of a cell: profiler, then element.
#[must_use]
pub fn cell(scene: &RailScene, tie: &Tie) -> u16 {
    let profiler = scene.campaign.points.profiler[tie.row as usize] as usize;
    (profiler * scene.rail.elements.len() + usize::from(tie.element)) as u16
}

impl Case<'_> {
    /// Findings in the order of their importance, and the bounds of every doubt.
    ///
    /// # Errors
    /// What a pass over the conditions can find wrong.
    pub fn heard(&self, problem: &Problem) -> Result<Doubted, AdjustError> {
        let doubted = self.doubts(problem)?;
        let mut findings = self.shares();
        findings.extend(self.ins.finding(self.config));
        findings.extend(doubted.findings);
        let priors = fit::priors(&prior_tests(self.solution), self.config);
        findings.extend(priors.into_iter().map(|finding| self.of_element(finding)));
        let (whole, parts) = self.fits()?;
        findings.extend(fit::whole(&whole, self.config));
        findings.extend(fit::parts(&parts, self.config));
        findings.extend(self.sizes());
        Ok(Doubted {
            findings: accepted(findings, self.config),
            bounds: doubted.bounds,
        })
    }

    /// A contradicted offset of an element of the rail says that the rail is not its model.
    fn of_element(&self, finding: Finding) -> Finding {
        let mut names = self.scene.rail.names.iter();
        if !names.any(|name| finding.seen.starts_with(&format!("rail {name}:"))) {
            return finding;
        }
        Finding {
            code: "rail_element".to_owned(),
            advice: "the rail differs from its model there: worn, dirty or another one; use a good rail, or state [rail] profile_sigma_m"
                .to_owned(),
            ..finding
        }
    }

    fn doubts(&self, problem: &Problem) -> Result<Doubted, AdjustError> {
        let estimate = &self.solution.estimate;
        let handles = (self.blocks, &estimate.parameters, estimate.chain.as_ref());
        let doubts = Doubts::of(self.scene, handles, self.ties);
        let (points, ins) = (doubts.of_points(), doubts.of_ins());
        let sought: Vec<(String, usize)> = names(&self.scene.campaign.profilers)
            .into_iter()
            .zip(0..)
            .collect();
        let global = &self.quality.global;
        let misfit = (global.omega, global.degrees_of_freedom);
        let columns = [Some(&points as _), Some(&ins as _)];
        doubts::test(
            (problem, self.solution),
            &doubts.list,
            &columns,
            &sought,
            misfit,
        )
    }

    fn fits(&self) -> Result<(FitTest, Vec<Part>), AdjustError> {
        let kernel = self.solution.kernel;
        let groups = &self.quality.groups;
        let conditions: Vec<FitTest> = groups.iter().map(|g| FitTest::of(g, kernel)).collect();
        let freedom = self.quality.global.degrees_of_freedom;
        let (whole, chain) = fit::together(conditions.iter().copied(), self.solution, freedom)?;
        let profilers = &self.scene.campaign.profilers;
        let mut parts: Vec<Part> = groups
            .iter()
            .zip(&conditions)
            .map(|(group, test)| {
                sensor(
                    profilers
                        .get(usize::from(group.group))
                        .map(|p| p.name.as_str()),
                    *test,
                )
            })
            .collect();
        parts.push(Part {
            code: "table",
            name: "the table's angles".to_owned(),
            test: chain,
            advice: "check [table] angle_sigma_deg, the signs of the table's angles and their zero"
                .to_owned(),
            strict: false,
        });
        parts.extend(self.quality.cells.iter().filter_map(|cell| {
            let (profiler, element) = self.element(usize::from(cell.group))?;
            Some(Part {
                code: "rail_element",
                name: format!("the points of {profiler} on the rail's {element}"),
                test: FitTest::of(cell, kernel),
                advice: "the rail is worn, dirty, or another one there".to_owned(),
                strict: false,
            })
        }));
        Ok((whole, parts))
    }

    fn element(&self, cell: usize) -> Option<(&str, &str)> {
        let elements = self.scene.rail.elements.len();
        let profiler = self.scene.campaign.profilers.get(cell / elements)?;
        Some((&profiler.name, &self.scene.rail.names[cell % elements]))
    }

    fn shares(&self) -> Vec<Finding> {
        let profilers = self.scene.campaign.profilers.iter().enumerate();
        let of = |profiler: usize, row: u32| {
            self.scene.campaign.points.profiler[row as usize] as usize == profiler
        };
        let one = |(p, profiler): (usize, &crate::observe::Profiler)| Share {
            name: format!("points of {}", profiler.name),
            candidates: self
                .scene
                .points
                .iter()
                .filter(|point| of(p, point.row))
                .count(),
            used: self.ties.iter().filter(|tie| of(p, tie.row)).count(),
        };
        profilers
            .map(one)
            .filter_map(|one| share(&one, self.config))
            .collect()
    }

    fn sizes(&self) -> Vec<Finding> {
        let x = &self.solution.estimate.parameters;
        let profilers = self.scene.campaign.profilers.iter().enumerate();
        let one = |(p, profiler): (usize, &crate::observe::Profiler)| {
            let found = self.blocks.mounting(x, p);
            Correction {
                name: format!("profiler {}", profiler.name),
                turn_rad: found.correction_from(&profiler.nominal).norm(),
                arm_m: (found.lever_arm_m - profiler.nominal.lever_arm_m).norm(),
            }
        };
        profilers
            .map(one)
            .filter_map(|one| size(&one, self.config))
            .collect()
    }
}

fn sensor(profiler: Option<&str>, test: FitTest) -> Part {
    let (name, advice) = match profiler {
        Some(name) => (
            format!("the points of {name}"),
            "check its lateral_sigma_m and vertical_sigma_m, and the rail",
        ),
        None => (
            "the INS' attitudes".to_owned(),
            "check the INS' standard deviations, its clock and its signs",
        ),
    };
    Part {
        code: "noise",
        name,
        test,
        advice: advice.to_owned(),
        strict: true,
    }
}

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
    for (alternative, undo) in mistakes() {
        let mut undone = survey.clone();
        undo(&mut undone);
        tried.extend(fitted(&undone, input.rail, input).map(|found| (alternative, found)));
    }
    let given = as_given.tried(&RailScene::new(input.campaign, input.rail));
    best(
        &given,
        &tried,
        "each profiler's points and the INS' attitudes",
    )
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

type Undo = fn(&mut RailCampaign);

fn mistakes() -> Vec<(Alternative, Undo)> {
    let mut all = of_points();
    all.extend(of_table());
    all.extend(of_ins());
    all
}

fn one(code: &'static str, words: &str, advice: &'static str, undo: Undo) -> (Alternative, Undo) {
    (Alternative::new(code, words, advice), undo)
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
            "points_in_millimetres",
            "with the points taken as millimetres",
            "check the unit of y_m and z_m: they look like millimetres",
            |c| {
                let points = &mut c.points;
                let all = points.y_m.iter_mut().chain(&mut points.z_m);
                all.for_each(|value| *value *= 1e-3);
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

fn of_ins() -> Vec<(Alternative, Undo)> {
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
    ]
}
