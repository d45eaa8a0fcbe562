//! What is drawn once per survey: how things truly are, as against how the survey believes them to be.

use nalgebra::Vector3;

use super::scenario::{Scenario, Turn, Water};
use super::sources::Source;
use super::switches::Draws;
use crate::geometry::{ellipsoid::TargetPose, rotation};
use crate::observe::{Mounting, SoundSpeedProfile};
use crate::target::Target;

/// The true state of everything that a survey takes as constant.
#[derive(Clone, Debug)]
pub struct Reality {
    /// True pose of the target.
    pub target: TargetPose,
    /// Pose that the survey file gives.
    pub prior: TargetPose,
    /// True minus design value of each of the target's offsets, metres.
    pub offsets_m: Vec<f64>,
    /// True mounting of the multibeam.
    pub sonar: Mounting,
    /// Nominal mounting of the multibeam.
    pub nominal_sonar: Mounting,
    /// True mounting of the scanner.
    pub scanner: Mounting,
    /// The scanner's mounting as the survey knows it.
    pub nominal_scanner: Mounting,
    /// Stamp minus measurement epoch of the multibeam, seconds.
    pub latency_s: f64,
    /// True range = measured x (1 + scale).
    pub range_scale: f64,
    /// True sound speed over depth, where rays bend.
    pub water: Option<SoundSpeedProfile>,
}

impl Reality {
    /// Draws everything that the scenario leaves to chance.
    #[must_use]
    pub fn draw(scenario: &Scenario, design: &Target, seed: u64) -> Self {
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let truth = &scenario.truth;
        let (nominal_sonar, lidar) = (scenario.multibeam.nominal(), &scenario.lidar);
        let nominal_scanner = lidar.mounting_deg.mounting(lidar.lever_arm_m);
        let target = scenario.target.pose();
        let mut latency = draws(Source::Latency);
        let mut speed = draws(Source::SoundSpeed);
        let range_scale =
            truth.range_scale * speed.factor() + speed.normal(truth.range_scale_sigma);
        let gradient_1_s = gradient(scenario, draws(Source::SoundSpeedGradient));
        Self {
            prior: prior(scenario, &target, draws(Source::TargetPose)),
            target,
            offsets_m: offsets(design, draws(Source::TargetOffsets)),
            sonar: nominal_sonar.corrected(
                &turn(&truth.correction_deg),
                &Vector3::from(truth.lever_arm_correction_m),
            ),
            nominal_sonar,
            scanner: scanner(
                scenario,
                &nominal_scanner,
                draws(Source::LaserBoresight),
                draws(Source::LaserLeverArm),
            ),
            nominal_scanner,
            latency_s: truth.latency_s * latency.factor() + latency.normal(truth.latency_sigma_s),
            range_scale,
            water: scenario
                .sound_speed
                .as_ref()
                .and_then(|w| true_water(w, range_scale, gradient_1_s, scenario.deepest_m())),
        }
    }
}

fn turn(turn: &Turn) -> Vector3<f64> {
    Vector3::new(turn.pitch, turn.roll, turn.yaw).map(f64::to_radians)
}

fn prior(scenario: &Scenario, truth: &TargetPose, mut draws: Draws) -> TargetPose {
    let t = &scenario.target;
    let factor = draws.factor();
    let offset = Vector3::from(t.prior_offset_m)
        .map(|given| given * factor + draws.normal(t.prior_offset_sigma_m));
    let turn = t.prior_turn_deg * factor + draws.normal(t.prior_turn_sigma_deg);
    if offset == Vector3::zeros() && turn == 0.0 {
        return *truth;
    }
    truth.moved(&offset, turn.to_radians())
}

fn offsets(design: &Target, mut draws: Draws) -> Vec<f64> {
    design
        .offsets
        .iter()
        .map(|o| draws.normal(o.sigma_m))
        .collect()
}

fn scanner(
    scenario: &Scenario,
    nominal: &Mounting,
    mut boresight: Draws,
    mut arm: Draws,
) -> Mounting {
    let lidar = &scenario.lidar;
    let given = turn(&lidar.mounting_error_deg) * boresight.factor();
    let drawn = Vector3::from(lidar.mounting_sigma_deg).map(|s| boresight.normal(s.to_radians()));
    let given_arm = Vector3::from(lidar.lever_arm_error_m) * arm.factor();
    let drawn_arm = Vector3::from(lidar.lever_arm_sigma_m).map(|s| arm.normal(s));
    Mounting {
        rotation: rotation::exp(&(given + drawn)) * nominal.rotation,
        lever_arm_m: nominal.lever_arm_m + given_arm + drawn_arm,
    }
}

fn gradient(scenario: &Scenario, mut draws: Draws) -> f64 {
    let Some(water) = &scenario.sound_speed else {
        return 0.0;
    };
    water.gradient_error_1_s * draws.factor() + draws.normal(water.gradient_sigma_1_s)
}

/// The true speed over depth, down to what a ray can reach; `None` where it is one speed, so that rays are straight.
fn true_water(
    known: &Water,
    range_scale: f64,
    gradient_1_s: f64,
    deepest_m: f64,
) -> Option<SoundSpeedProfile> {
    if known.profile.is_empty() && gradient_1_s == 0.0 {
        return None;
    }
    let samples = match known.speed_m_s {
        Some(speed) if known.profile.is_empty() => vec![[0.0, speed], [deepest_m, speed]],
        _ => known.profile.clone(),
    };
    let truth = |[depth, speed]: &[f64; 2]| speed * (1.0 + range_scale) + gradient_1_s * depth;
    Some(SoundSpeedProfile {
        depth_m: samples.iter().map(|s| s[0]).collect(),
        speed_m_s: samples.iter().map(truth).collect(),
    })
}
