//! What speaks against a rail calibration: its parts, doubts, shares and corrections, handed to the common verdict.

use super::conditions::Tie;
use super::doubts::Doubts;
use super::model::Blocks;
use super::observed::Profiler;
use super::scene::RailScene;
use super::trial::names;
use crate::adjust::{AdjustError, Bits, FitTest, Problem, Quality, Solution, prior_tests};
use crate::calibrate::verdict::bounds::{Correction, Share, share, size};
use crate::calibrate::verdict::doubts::{self, Doubted};
use crate::calibrate::verdict::fit::{self, Part};
use crate::calibrate::verdict::{VerdictConfig, accepted};
use crate::results::{Finding, Severity};

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
    pub fn of(positions: usize, ignored: Option<&Bits>) -> Self {
        let off = |axis: usize| {
            let mask = ignored.into_iter().flat_map(Bits::iter).enumerate();
            mask.filter(|(k, off)| k % 3 == axis && *off).count()
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
            advice: "the rail differs from its model there: worn, dirty or of another type; use a good rail, or state [rail] profile_sigma_m"
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
                advice: "the rail is worn or dirty there, or of another type".to_owned(),
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
        let one = |(p, profiler): (usize, &Profiler)| Share {
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
        let one = |(p, profiler): (usize, &Profiler)| {
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
