//! What speaks against a joint solution: the pool's cells, doubts, shares and corrections, handed to the common verdict.

use super::conditions::{ReturnConditions, SoundingConditions};
use super::doubts::{Doubts, Passes, Sensor};
use super::joint::{Blocks, RETURNS, SIX, SOUNDINGS};
use super::scene::Scene;
use crate::adjust::{
    AdjustError, FitTest, GroupQuality, Kernel, Problem, Quality, Solution, prior_tests,
};
use crate::calibrate::verdict::bounds::{Correction, size};
use crate::calibrate::verdict::doubts::{self, Doubted};
use crate::calibrate::verdict::fit::{self, Part};
use crate::calibrate::verdict::{VerdictConfig, accepted};
use crate::observe::Mounting;

/// Cells of the tests of parts: sensor, pass, face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Passes.
    pub passes: usize,
    /// Faces of the target.
    pub faces: usize,
}

impl Cells {
    /// Number of a cell.
    #[must_use]
    pub fn number(&self, sensor: u16, pass: usize, face: u16) -> u16 {
        (usize::from(sensor) * self.passes * self.faces + pass * self.faces + face as usize) as u16
    }

    /// Sensor, pass and face of a cell.
    fn of(&self, cell: u16) -> (u16, usize, usize) {
        let cell = cell as usize;
        let sensor = cell / (self.passes * self.faces);
        (
            sensor as u16,
            cell / self.faces % self.passes,
            cell % self.faces,
        )
    }
}

/// A solution with what it is judged by.
pub struct Case<'a> {
    /// The scene.
    pub scene: &'a Scene<'a>,
    /// Handles of the parameters.
    pub blocks: &'a Blocks,
    /// The solution.
    pub solution: &'a Solution,
    /// Its judgement.
    pub quality: &'a Quality,
    /// Conditions of soundings and returns.
    pub conditions: (&'a SoundingConditions<'a>, &'a ReturnConditions<'a>),
    /// Passes.
    pub passes: &'a Passes,
    /// Limits.
    pub config: &'a VerdictConfig,
}

impl Case<'_> {
    /// Findings in the order of their importance, and the bounds of every doubt.
    ///
    /// # Errors
    /// What a pass over the conditions can find wrong.
    pub fn heard(&self, problem: &Problem) -> Result<Doubted, AdjustError> {
        let doubted = self.doubts(problem)?;
        let mut findings = doubted.findings;
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
        let doubts = Doubts::of((self.scene, self.blocks), self.conditions, self.passes);
        let [soundings, returns] =
            [Sensor::Sounder, Sensor::Scanner].map(|sensor| doubts.columns_of(sensor));
        let columns = [Some(&soundings as _), Some(&returns as _)];
        let first = [
            x.offset(self.blocks.mounting.rotation),
            x.offset(self.blocks.mounting.lever_arm),
        ];
        let sought: Vec<(String, usize)> = SIX
            .iter()
            .enumerate()
            .map(|(i, name)| ((*name).to_owned(), first[i / 3] + i % 3))
            .collect();
        let global = &self.quality.global;
        let misfit = (global.omega, global.degrees_of_freedom);
        doubts::test(
            (problem, self.solution),
            &doubts.list,
            &columns,
            &sought,
            misfit,
        )
    }

    /// The test of everything, and those of sensors, passes, faces and the trajectory.
    fn fits(&self) -> Result<(FitTest, Vec<Part>), AdjustError> {
        let kernel = self.solution.kernel;
        let conditions: Vec<FitTest> = self
            .quality
            .groups
            .iter()
            .map(|g| FitTest::of(g, kernel))
            .collect();
        let freedom = self.quality.global.degrees_of_freedom;
        let (whole, chain) = fit::together(conditions.iter().copied(), self.solution, freedom)?;
        let mut parts = vec![Part {
            code: "trajectory",
            name: "the trajectory's estimated errors (drift, noise of position and attitude)".to_owned(),
            test: chain,
            advice: "check [trajectory]'s standard deviations; a wrong sign, unit or clock of the attitude shows here too".to_owned(),
            strict: false,
        }];
        for group in &self.quality.groups {
            parts.push(sensor_part(group, kernel));
        }
        parts.extend(self.cells(kernel));
        Ok((whole, parts))
    }

    fn cells(&self, kernel: Kernel) -> Vec<Part> {
        let cells = Cells {
            passes: self.passes.count(),
            faces: self.scene.target.faces.len(),
        };
        let sum = |wanted: &dyn Fn((u16, usize, usize)) -> bool| {
            let tests = self
                .quality
                .cells
                .iter()
                .filter(|cell| wanted(cells.of(cell.group)));
            tests.fold(FitTest::default(), |all, cell| {
                all.with(FitTest::of(cell, kernel))
            })
        };
        let mut parts = vec![];
        for (sensor, words) in [(SOUNDINGS, "soundings"), (RETURNS, "laser returns")] {
            for pass in 0..cells.passes {
                parts.push(Part {
                    code: "pass",
                    name: format!("the {words} of pass {}", pass + 1),
                    test: sum(&|cell| (cell.0, cell.1) == (sensor, pass)),
                    advice: "look at what happened in that pass: the pole, the position's fix, the water".to_owned(),
                    strict: false,
                });
            }
            for (face, known) in self.scene.target.faces.iter().enumerate() {
                parts.push(Part {
                    code: "face",
                    name: format!("the {words} on face {}", known.name),
                    test: sum(&|cell| (cell.0, cell.2) == (sensor, face)),
                    advice: "look at that face: is it flat, clean, where the target file says?"
                        .to_owned(),
                    strict: false,
                });
            }
        }
        parts
    }

    fn correction(&self) -> Correction {
        let found = self.blocks.mounting.at(&self.solution.estimate.parameters);
        correction(&found, &self.scene.campaign.sonar)
    }
}

/// How far a mounting lies from the nominal one.
#[must_use]
pub fn correction(found: &Mounting, nominal: &Mounting) -> Correction {
    Correction {
        name: "the sounder".to_owned(),
        turn_rad: found.correction_from(nominal).norm(),
        arm_m: (found.lever_arm_m - nominal.lever_arm_m).norm(),
    }
}

fn sensor_part(group: &GroupQuality, kernel: Kernel) -> Part {
    let (name, advice) = match group.group {
        SOUNDINGS => (
            "the soundings",
            "check [multibeam] range_sigma_m and angle_sigma_deg, and what else scatters the soundings",
        ),
        _ => (
            "the laser returns",
            "check [lidar] range_sigma_m and angle_sigma_deg, and what else scatters the returns",
        ),
    };
    Part {
        code: "noise",
        name: name.to_owned(),
        test: FitTest::of(group, kernel),
        advice: advice.to_owned(),
        strict: true,
    }
}
