//! What does a USBL calibration cost? Simulating, the patent's path, the joint path on the demo's survey (five beacons, 1000 fixes), and
//! one ray.

use boresight::georef::Medium;
use boresight::procedures::pool::Method;
use boresight::procedures::usbl::simulate::{DEMO, Scenario, Simulated, simulate};
use boresight::procedures::usbl::{JointConfig, ReferenceConfig, UsblInput, calibrate};
use divan::{Bencher, black_box};
use nalgebra::Vector3;

fn main() {
    divan::main();
}

fn survey() -> Simulated {
    let scenario: Scenario = toml::from_str(DEMO).expect("a scenario");
    simulate(&scenario, 1).expect("a survey")
}

fn run(survey: &Simulated, method: Method) -> bool {
    let input = UsblInput {
        campaign: &survey.campaign,
        method,
        reference: ReferenceConfig::default(),
        joint: JointConfig::default(),
    };
    calibrate(&input).expect("an outcome").refusal.is_none()
}

/// What does a simulated survey cost?
#[divan::bench]
fn simulate_a_survey(bencher: Bencher) {
    bencher.bench(survey);
}

/// What does the patent's path cost?
#[divan::bench]
fn reference_path(bencher: Bencher) {
    let survey = survey();
    bencher.bench(|| run(&survey, Method::Reference));
}

/// And the joint path, with its attitude states and data snooping?
#[divan::bench]
fn joint_path(bencher: Bencher) {
    let survey = survey();
    bencher.bench(|| run(&survey, Method::Joint));
}

/// What does one ray between two points cost, derivatives included?
#[divan::bench]
fn one_eigenray(bencher: Bencher) {
    let survey = survey();
    let medium = Medium::new(&survey.campaign.sound_speed).expect("water");
    let offset_m = Vector3::new(3.0, -2.5, -6.0);
    bencher.bench(|| medium.eigenray(black_box(1.0), black_box(&offset_m)));
}
