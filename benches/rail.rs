//! What does a rail calibration cost? Simulating, the patent's path, the joint path on the thin scenario (42 profiles of two profilers, some
//! 6000 points).

use boresight::procedures::pool::Method;
use boresight::procedures::rail::RailProfile;
use boresight::procedures::rail::simulate::{RailScenario, SimulatedRail, simulate};
use boresight::procedures::rail::{RailInput, RailJointConfig, RailReferenceConfig, calibrate};

const THIN: &str = include_str!("../models/scenarios/rail-thin.toml");

fn main() {
    divan::main();
}

fn scenario() -> (RailScenario, RailProfile) {
    let scenario = RailScenario::from_toml(THIN).expect("a scenario");
    (scenario, RailProfile::built_in("chn60").expect("a rail"))
}

fn run(survey: &SimulatedRail, rail: &RailProfile, method: Method) -> bool {
    let (reference, joint) = (RailReferenceConfig::default(), RailJointConfig::default());
    let input = RailInput {
        campaign: &survey.campaign,
        rail,
        method,
        reference: &reference,
        joint: &joint,
    };
    calibrate(&input).refusal.is_none()
}

#[divan::bench(sample_count = 10)]
fn simulation(bencher: divan::Bencher) {
    let (scenario, rail) = scenario();
    bencher.bench(|| simulate(&scenario, &rail, 1));
}

#[divan::bench(sample_count = 10, args = [Method::Reference, Method::Joint])]
fn calibration(bencher: divan::Bencher, method: Method) {
    let (scenario, rail) = scenario();
    let survey = simulate(&scenario, &rail, 1).expect("a survey");
    bencher.bench(|| run(&survey, &rail, method));
}
