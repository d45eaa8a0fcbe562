//! What a scenario's survey would give, without a trial: one survey free of all errors but the sonar's noise, the adjustment's covariance
//! at the truth, and what each source has in it.

use nalgebra::{DMatrix, Matrix3};

use super::config::JointSettings;
use super::field::Field;
use super::joint::{Joint, JointError, foreseen};
use super::layout::Layout;
use super::shared::{Covariance, Parameters};
use super::simulate::{Acts, simulate};
use super::survey::load::scene_of;
use super::survey::{SeabedScenario, write};
use super::verdict::{Judgement, REPORTED, judge};
use crate::calibrate::tried::{Moved, Propagated, PropagatedPath};
use crate::observe::Mounting;

/// A survey foreseen.
pub struct Foresight {
    /// The adjustment at the truth.
    pub joint: Joint,
    /// What may be used of it.
    pub judged: Judgement,
}

/// Foresees a scenario's survey.
///
/// # Errors
/// [`JointError`] where its lines do not meet.
pub fn foresee(scenario: &SeabedScenario, seed: u64) -> Result<Foresight, JointError> {
    let quiet = Acts {
        sonar: 1.0,
        ..Acts::NONE
    };
    let survey = simulate(scenario, seed, quiet);
    let file = write::survey_file(scenario, &survey);
    let scene = scene_of(
        &file,
        &write::trajectory(scenario, &survey),
        &[write::profile(scenario, &survey)],
        &write::soundings(scenario, &survey.shots),
    );
    let truth = &survey.truth;
    let mounting = Mounting {
        rotation: Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]),
        lever_arm_m: scene.nominal.lever_arm_m,
    };
    let field = Field {
        sigma_m: scenario.bed.relief_m.max(LEAST_RELIEF_M),
        length_m: scenario.bed.length_m,
        noise_factor: 1.0,
    };
    let config: JointSettings = file.joint(seed);
    let joint = foreseen(&scene, &config, mounting, truth.latency_s, field)?;
    let layout = Layout::new(&scene, &joint.tiles);
    let judged = judge(&joint, &layout, &config);
    Ok(Foresight { joint, judged })
}

/// Less relief than this is none.
const LEAST_RELIEF_M: f64 = 2e-4;

/// What a source does, or why it cannot be said.
type Effect = Result<(Parameters, Covariance), &'static str>;

fn scattered(covariance: Covariance) -> Effect {
    Ok((Parameters::zeros(), covariance))
}

fn shifted(bias: Parameters) -> Effect {
    Ok((bias, Covariance::zeros()))
}

const HELD: &str = "held by the survey: trials show where the error goes";

/// What a source of a scenario does to its parameters.
fn effect(source: &str, scenario: &SeabedScenario, joint: &Joint) -> Effect {
    let (shares, errors) = (&joint.shares, &scenario.errors);
    // the true value of a relative error that the survey has: what is measured times it is true
    let true_of = |relative: f64| 1.0 / (1.0 + relative) - 1.0;
    let prior = |k: usize| joint.priors[k].ok_or(HELD);
    match source {
        "sonar" => scattered(shares.sonar),
        "ins_white" => scattered(shares.white),
        "ins_drift" => scattered(shares.drift),
        "line_height" => {
            let ratio = errors.line_height_m / scenario.site.line_height_sigma_m;
            scattered(shares.heights * ratio.powi(2))
        }
        "lever_arm" => {
            let of =
                |k: usize, sigma: f64| shares.held[k] * shares.held[k].transpose() * sigma.powi(2);
            let [right, forward, _] = scenario.multibeam.lever_arm_sigma_m;
            scattered(of(7, right) + of(8, forward))
        }
        "heave" => {
            prior(5).and(prior(6))?;
            let scale = shares.held[5] * true_of(errors.heave_scale);
            shifted(scale + shares.held[6] * errors.heave_lag_s)
        }
        "profile" => {
            prior(9)?;
            shifted(shares.held[9] * true_of(errors.profile))
        }
        _ => Err("rejected or not, one by one: trials show what is left of them"),
    }
}

/// Every source of a scenario through the derivatives of the joint path.
///
/// # Errors
/// Why there is no figure.
pub fn propagated<'s>(
    scenario: &SeabedScenario,
    seed: u64,
    sources: impl Iterator<Item = &'s str>,
) -> Result<Propagated, String> {
    let Foresight { joint, .. } = foresee(scenario, seed).map_err(|e| e.to_string())?;
    let (mut bias, mut covariance) = (Parameters::zeros(), Covariance::zeros());
    let mut each = vec![];
    let four = |all: &Parameters| all.iter().take(REPORTED).copied().collect::<Vec<f64>>();
    for source in sources {
        let effect = effect(source, scenario, &joint);
        if let Ok((shift, scatter)) = &effect {
            bias += shift;
            covariance += scatter;
        }
        let moved = effect.map(|(shift, scatter)| Moved {
            bias: four(&shift),
            variance: four(&scatter.diagonal()),
        });
        each.push((source.to_owned(), moved));
    }
    Ok(Propagated {
        paths: vec![PropagatedPath {
            name: "joint",
            method_bias: vec![0.0; REPORTED],
            sources: each,
            bias: four(&bias),
            covariance: DMatrix::from_fn(REPORTED, REPORTED, |i, j| covariance[(i, j)]),
        }],
        bound: None,
        notes: vec![
            "the reference path has no derivatives: it looks for the smallest difference of two surfaces"
                .to_owned(),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::seabed::survey::parse_scenario;

    fn thin() -> SeabedScenario {
        let text = include_str!("../../../models/scenarios/seabed-thin.toml");
        parse_scenario(std::path::Path::new("seabed-thin.toml"), text).expect("a scenario")
    }

    /// The parts of all sources, as large as the survey claims them, make up the covariance that the adjustment states.
    #[test]
    fn the_sources_make_up_what_is_stated() {
        let scenario = thin();
        let joint = foresee(&scenario, 3).expect("foreseen").joint;
        let shares = &joint.shares;
        let mut whole = shares.sonar + shares.white + shares.drift + shares.heights;
        for k in 0..whole.nrows() {
            if let Some(sigma) = joint.priors[k] {
                whole += shares.held[k] * shares.held[k].transpose() * sigma.powi(2);
            }
        }
        for k in 0..REPORTED {
            let stated = joint.sigma(k) / joint.inflation[k];
            let variance = whole[(k, k)];
            assert!((variance.sqrt() / stated - 1.0).abs() < 1e-6, "{k}");
            for part in [shares.sonar, shares.white, shares.drift, shares.heights] {
                assert!(part[(k, k)] > 0.0 && part[(k, k)] < variance);
            }
        }
    }

    /// A lever arm that is known less well costs what its part grows by.
    #[test]
    fn an_arm_known_less_well_costs_pitch() {
        let mut scenario = thin();
        let of = |scenario: &SeabedScenario| {
            let found = propagated(scenario, 3, ["lever_arm"].into_iter()).expect("propagated");
            found.paths[0].covariance[(0, 0)].sqrt()
        };
        let before = of(&scenario);
        scenario.multibeam.lever_arm_sigma_m = [0.005, 0.03, 0.01];
        assert!(of(&scenario) > 2.0 * before);
    }
}
