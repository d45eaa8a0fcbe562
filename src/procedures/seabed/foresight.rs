//! What a scenario's survey would give, without a trial: one survey free of all errors but the sonar's noise, the adjustment's covariance
//! at the truth, and what each source has in it.

use nalgebra::{DMatrix, Matrix3};

use super::config::JointSettings;
use super::field::Field;
use super::joint::{Joint, JointError, foreseen};
use super::layout::Layout;
use super::parameters::{DEEP_SOUND_SPEED, HEAVE_LAG, HEAVE_SCALE};
use super::scene::Head;
use super::shared::{Covariance, Parameters, add_square};
use super::simulate::{Acts, Ground, simulate_on};
use super::survey::{SeabedScenario, write};
use super::verdict::{Judgement, judge};
use crate::calibrate::tried::{Moved, Propagated, PropagatedPath};
use crate::observe::Mounting;

/// A survey foreseen.
pub struct Foresight {
    /// The adjustment at the truth.
    pub joint: Joint,
    /// What may be used of it.
    pub judged: Judgement,
}

/// What acts in a survey that is foreseen: the noise of the sonar.
pub const QUIET: Acts = Acts {
    sonar: 1.0,
    ..Acts::NONE
};

/// Foresees a scenario's survey.
///
/// # Errors
/// [`JointError`] where its lines do not meet.
pub fn foresee(scenario: &SeabedScenario, seed: u64) -> Result<Foresight, JointError> {
    foresee_on(&Ground::under(scenario, &[], seed), scenario, seed)
}

/// As [`foresee`], on a seabed that is there already.
///
/// # Errors
/// As [`foresee`].
pub fn foresee_on(
    ground: &Ground,
    scenario: &SeabedScenario,
    seed: u64,
) -> Result<Foresight, JointError> {
    let survey = simulate_on(ground, scenario, seed, QUIET);
    let file = write::survey_file(scenario, &survey);
    let scene = write::scene(&file, scenario, &survey);
    let truth = &survey.truth;
    let mounting = |(rotation, head): (Matrix3<f64>, &Head)| Mounting {
        rotation,
        lever_arm_m: head.nominal.lever_arm_m,
    };
    let mountings = truth.rotations().into_iter().zip(&scene.heads);
    let mountings = mountings.map(mounting).collect();
    let field = Field {
        sigma_m: scenario.bed.relief_m.max(LEAST_RELIEF_M),
        length_m: scenario.bed.length_m,
        noise_factor: 1.0,
    };
    let config: JointSettings = file.joint(seed);
    let joint = foreseen(&scene, &config, mountings, truth.latency_s, field)?;
    let layout = Layout::new(&scene, &joint.tiles);
    let judged = judge(&joint, &layout, &config);
    Ok(Foresight { joint, judged })
}

/// Less relief than this is none.
const LEAST_RELIEF_M: f64 = 2e-4;

/// What a source does, or why it cannot be said.
type Effect = Result<(Parameters, Covariance), &'static str>;

fn scattered(covariance: Covariance) -> Effect {
    Ok((Parameters::zeros(covariance.nrows()), covariance))
}

fn shifted(bias: Parameters) -> Effect {
    let count = bias.len();
    Ok((bias, Covariance::zeros(count, count)))
}

const HELD: &str = "held by the survey: trials show where the error goes";

/// What a source of a scenario does to its parameters.
fn effect(source: &str, scenario: &SeabedScenario, joint: &Joint) -> Effect {
    let (shares, errors) = (&joint.shares, &scenario.errors);
    // the true value of a relative error that the survey has: what is measured times it is true
    let true_of = |relative: f64| 1.0 / (1.0 + relative) - 1.0;
    let prior = |k: usize| joint.priors[k].ok_or(HELD);
    match source {
        "sonar" => scattered(shares.sonar.clone()),
        "ins_white" => scattered(shares.white.clone()),
        "ins_drift" => scattered(shares.drift.clone()),
        "line_height" => {
            let ratio = errors.line_height_m / scenario.site.line_height_sigma_m;
            scattered(&shares.heights * ratio.powi(2))
        }
        "lever_arm" => {
            let mut all = Covariance::zeros(joint.off.len(), joint.off.len());
            for (k, parameter) in joint.parameters.iter().enumerate() {
                if let Some(axis) = parameter.kind.arm() {
                    let head = parameter.head.map_or(0, usize::from);
                    let sigma_m = scenario.arm_sigma_m(head, axis);
                    add_square(&mut all, &shares.held[k], sigma_m.powi(2));
                }
            }
            scattered(all)
        }
        "heave" => {
            prior(HEAVE_SCALE).and(prior(HEAVE_LAG))?;
            let scale = &shares.held[HEAVE_SCALE] * true_of(errors.heave_scale);
            shifted(scale + &shares.held[HEAVE_LAG] * errors.heave_lag_s)
        }
        "profile" => {
            prior(DEEP_SOUND_SPEED)?;
            shifted(&shares.held[DEEP_SOUND_SPEED] * true_of(errors.profile))
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
    let reported: Vec<usize> = joint.reported().collect();
    let count = joint.off.len();
    let mut bias = Parameters::zeros(count);
    let mut covariance = Covariance::zeros(count, count);
    let mut each = vec![];
    let chosen = |all: &Parameters| reported.iter().map(|k| all[*k]).collect::<Vec<f64>>();
    for source in sources {
        let effect = effect(source, scenario, &joint);
        if let Ok((shift, scatter)) = &effect {
            bias += shift;
            covariance += scatter;
        }
        let moved = effect.map(|(shift, scatter)| Moved {
            bias: chosen(&shift),
            variance: chosen(&scatter.diagonal()),
        });
        each.push((source.to_owned(), moved));
    }
    Ok(Propagated {
        paths: vec![PropagatedPath {
            name: "joint",
            method_bias: vec![0.0; reported.len()],
            sources: each,
            bias: chosen(&bias),
            covariance: DMatrix::from_fn(reported.len(), reported.len(), |i, j| {
                covariance[(reported[i], reported[j])]
            }),
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
        let mut whole = &shares.sonar + &shares.white + &shares.drift + &shares.heights;
        for k in 0..whole.nrows() {
            if let Some(sigma) = joint.priors[k] {
                add_square(&mut whole, &shares.held[k], sigma.powi(2));
            }
        }
        for k in joint.reported() {
            let stated = joint.sigma(k) / joint.inflation[k];
            let variance = whole[(k, k)];
            assert!((variance.sqrt() / stated - 1.0).abs() < 1e-6, "{k}");
            for part in [&shares.sonar, &shares.white, &shares.drift, &shares.heights] {
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
