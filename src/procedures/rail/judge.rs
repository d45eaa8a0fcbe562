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
use crate::observe::RailCampaign;
use crate::results::Finding;
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
    /// Limits.
    pub config: &'a VerdictConfig,
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
    /// Share of the resting points of the worst-off profiler that are used, and the variance factor.
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
            share: shares.fold(1.0, f64::min),
            variance_factor: Some(self.quality.global.variance_factor),
            oversize: false,
        }
    }
}

/// Names the discrete mistake that turns the misfit of a rail calibration into a fit, if there is one.
#[must_use]
pub fn named(input: &RailInput, as_given: &RailJoint) -> Option<Finding> {
    let scene = RailScene::new(input.campaign, input.rail);
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
        tried.extend(fitted(input.campaign, &rail, input).map(|found| (alternative, found)));
    }
    for (alternative, undo) in mistakes() {
        let mut campaign = input.campaign.clone();
        undo(&mut campaign);
        tried.extend(fitted(&campaign, input.rail, input).map(|found| (alternative, found)));
    }
    best(&as_given.tried(&scene), &tried, "each profiler's points")
}

fn fitted(campaign: &RailCampaign, rail: &RailProfile, input: &RailInput) -> Option<Tried> {
    let scene = RailScene::new(campaign, rail);
    let start = super::run::start(&scene, input.reference).ok()?;
    let found = super::joint::joint(&scene, input.joint, &start).ok()?;
    Some(found.tried(&scene))
}

type Undo = fn(&mut RailCampaign);

fn mistakes() -> Vec<(Alternative, Undo)> {
    let one = |code, words: &str, advice, undo: Undo| (Alternative::new(code, words, advice), undo);
    vec![
        one(
            "sign_of_lateral",
            "with the lateral coordinate reversed",
            "check the sign of y_m: positive is to the right",
            |c| {
                c.points.y_m.iter_mut().for_each(|y| *y = -*y);
            },
        ),
        one(
            "sign_of_table_heading",
            "with the table's turn about the vertical reversed",
            "check the sign of the table's heading: clockwise",
            |c| {
                c.table.heading_rad.iter_mut().for_each(|a| *a = -*a);
            },
        ),
        one(
            "sign_of_table_pitch",
            "with the table's turn about the lateral axis reversed",
            "check the sign of the table's pitch: front up",
            |c| {
                c.table.pitch_rad.iter_mut().for_each(|a| *a = -*a);
            },
        ),
    ]
}
