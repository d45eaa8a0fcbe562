//! Wrong inputs must not pass as a result, and right ones must: each mistake is made to a simulated survey in memory.

use boresight::geometry::ellipsoid::TargetPose;
use boresight::geometry::rotation::{from_attitude, to_attitude};
use boresight::observe::{Campaign, SoundingRange};
use boresight::procedures::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::results::{Verdict, VerdictState};
use boresight::simulate::{Scenario, Simulated, simulate};
use nalgebra::Vector3;

const ONE: &str = include_str!("../../models/scenarios/single-pass-thin.toml");
const THREE: &str = include_str!("../../models/scenarios/three-pass-thin.toml");

fn survey(text: &str, seed: u64) -> Simulated {
    let scenario = Scenario::from_toml(text).expect("a scenario");
    simulate(&scenario, seed).expect("a survey")
}

/// The verdict on a survey after something was done to it.
fn verdict_with(
    text: &str,
    joint: &JointConfig,
    spoil: impl FnOnce(&mut Campaign, &mut TargetPose),
) -> Verdict {
    let mut survey = survey(text, 3);
    spoil(&mut survey.campaign, &mut survey.prior);
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Joint,
        sequential: &SequentialConfig::default(),
        joint,
        seed: 1,
        extras: &[],
    };
    calibrate(&input, &boresight::watch::Unwatched)
        .expect("a run")
        .verdict()
}

fn verdict(text: &str, spoil: impl FnOnce(&mut Campaign)) -> Verdict {
    verdict_with(text, &JointConfig::default(), |campaign, _| spoil(campaign))
}

fn scaled(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn ranges(campaign: &mut Campaign, factor: f64) {
    if let SoundingRange::Metres(values) = &mut campaign.soundings.range {
        scaled(values, factor);
    }
}

/// The one-step estimate of an unknown in a survey, and its standard deviations.
fn bound(verdict: &Verdict, code: &str, nth: usize) -> (Vec<f64>, Vec<f64>) {
    let mut found = verdict.bounds.iter().filter(|bound| bound.code == code);
    let found = found
        .nth(nth)
        .unwrap_or_else(|| panic!("no {code}: {verdict:#?}"));
    (found.values.clone(), found.sigmas.clone())
}

/// What is put into the data comes out of the score test's one step: each column against the data that it is a derivative of. The
/// same noise is in both surveys, so that the difference of the estimates is as large as what was put in, to a tenth of it; ties that
/// change hands, about one in twenty, move it by sqrt(2 / 20) of its sigma (one standard deviation) beside that, and twice that is allowed.
#[test]
fn one_step_estimates_what_was_put_in() {
    type Spoil = fn(&mut Campaign);
    let before = verdict(THREE, |_| {});
    let cases: [(&str, usize, f64, Spoil); 10] = [
        ("latency", 0, 0.002, |c| {
            shifted(&mut c.soundings.time_s, 0.002);
        }),
        ("laser_latency", 0, 0.002, |c| {
            shifted(&mut c.laser.time_s, 0.002);
        }),
        ("range_scale", 0, -5e-4, |c| ranges(c, 1.000_5)),
        ("range_offset", 0, -0.003, |c| {
            if let SoundingRange::Metres(values) = &mut c.soundings.range {
                shifted(values, 0.003);
            }
        }),
        ("beam_angle_scale", 0, -1e-3, |c| {
            scaled(&mut c.soundings.across_rad, 1.001);
        }),
        ("laser_range_offset", 0, -0.003, |c| {
            longer_returns(c, 0.003);
        }),
        ("attitude_scale", 0, -0.01, |c| {
            scaled(&mut c.trajectory.roll_rad, 1.01);
        }),
        ("attitude_scale", 1, -0.01, |c| {
            scaled(&mut c.trajectory.pitch_rad, 1.01);
        }),
        ("attitude_latency", 0, 0.002, |c| {
            let times_s = c.trajectory.time_s.clone();
            let record = &mut c.trajectory;
            later(&times_s, &mut record.roll_rad, 0.002);
            later(&times_s, &mut record.pitch_rad, 0.002);
            later(&times_s, &mut record.heading_rad, 0.002);
        }),
        ("heading_offset", 0, 5e-4, |c| {
            shifted(&mut c.trajectory.heading_rad, 5e-4);
        }),
    ];
    for (code, component, size, spoil) in cases {
        let after = verdict(THREE, spoil);
        let ((was, _), (is, sigma)) = (bound(&before, code, 0), bound(&after, code, 0));
        let moved = is[component] - was[component];
        let free = sigma[component] > 0.0 && sigma[component] < 3.0 * size.abs();
        println!(
            "{code} {component}: {moved:.6} of {size}, sigma {:.6}",
            sigma[component]
        );
        assert!(
            !free || (moved - size).abs() < 0.1 * size.abs() + 0.64 * sigma[component],
            "{code} {component}: {moved} of {size}"
        );
    }
}

/// Each record shows what the record before it came to so much earlier.
fn later(times_s: &[f64], values: &mut [f64], by_s: f64) {
    for k in (1..values.len()).rev() {
        let rate = (values[k] - values[k - 1]) / (times_s[k] - times_s[k - 1]);
        values[k] -= rate * by_s;
    }
}

fn shifted(values: &mut [f64], by: f64) {
    values.iter_mut().for_each(|value| *value += by);
}

fn longer_returns(campaign: &mut Campaign, by_m: f64) {
    let laser = &mut campaign.laser;
    for k in 0..laser.x_m.len() {
        let range_m = laser.x_m[k].hypot(laser.y_m[k]).hypot(laser.z_m[k]);
        let factor = 1.0 + by_m / range_m;
        for column in [&mut laser.x_m, &mut laser.y_m, &mut laser.z_m] {
            column[k] *= factor;
        }
    }
}

/// The first finding withdraws "usable" and is one of these.
fn assert_named(verdict: &Verdict, codes: &[&str]) {
    assert!(!verdict.state.is_usable(), "{verdict:?}");
    let first = &verdict.findings[0];
    assert!(codes.contains(&first.code.as_str()), "{first:#?}");
}

/// A right survey has nothing against it but what it cannot tell: a sign of the scanner's stated mounting. Without angles there is none.
#[test]
fn right_surveys_are_usable() {
    for text in [ONE, THREE] {
        let found = verdict(text, |_| {});
        assert!(found.state.is_usable(), "{found:#?}");
        let mut codes = found.findings.iter().map(|f| f.code.as_str());
        assert!(
            codes.all(|code| code.starts_with("sign_of_scanner")),
            "{found:#?}"
        );
        let level = text.replace(
            "mounting_deg = { roll = -0.4, pitch = 0.1, heading = -0.2 }",
            LEVEL,
        );
        let level = level.replace(
            "mounting_deg = { roll = 0.3, pitch = -0.2, heading = -0.5 }",
            LEVEL,
        );
        let found = verdict(&level, |_| {});
        assert_eq!(found.state, VerdictState::Usable, "{found:#?}");
    }
}

const LEVEL: &str = "mounting_deg = { roll = 0.0, pitch = 0.0, heading = 0.0 }";

/// A scanner's angle entered with the wrong sign: named where the passes decide it, else a finding with what it would move.
#[test]
fn a_sign_of_the_scanner_s_mounting_is_named_or_said_to_be_undecided() {
    for sign in 0..3 {
        let found = verdict(THREE, |campaign| {
            let mut angles: [f64; 3] = to_attitude(&campaign.scanner.rotation).into();
            angles[sign] = -angles[sign];
            let [roll, pitch, heading] = angles;
            campaign.scanner.rotation = from_attitude(roll, pitch, heading);
        });
        let said = found.findings.iter().any(|f| {
            let of_scanner = f.code.starts_with("sign_of_scanner") || f.code == "scanner_mounting";
            of_scanner || f.code == "heading_offset"
        });
        assert!(said, "{sign}: {found:#?}");
    }
}

#[test]
fn a_late_clock_is_named_with_its_size() {
    let late = |campaign: &mut Campaign| {
        campaign
            .soundings
            .time_s
            .iter_mut()
            .for_each(|t| *t += 0.03);
    };
    let found = verdict(THREE, late);
    assert_named(&found, &["latency"]);
    let seen = &found.findings[0].seen;
    let figure = seen.split(": ").nth(1).and_then(|s| s.split(' ').next());
    let late_ms: f64 = figure.and_then(|s| s.parse().ok()).expect("a figure");
    assert!((late_ms - 30.0).abs() < 5.0, "{seen}");
}

/// What the surveyor accepts is listed and no longer withdraws.
#[test]
fn an_accepted_finding_is_listed() {
    let mut joint = JointConfig::default();
    joint.verdict.accept = ["latency", "attitude_scale", "datum_of_pass"]
        .map(str::to_owned)
        .to_vec();
    let found = verdict_with(THREE, &joint, |campaign, _| {
        campaign
            .soundings
            .time_s
            .iter_mut()
            .for_each(|t| *t += 0.004);
    });
    let latency = found.findings.iter().find(|f| f.code == "latency");
    assert!(
        latency.is_some_and(|f| f.accepted && !f.withdraws()),
        "{found:#?}"
    );
}

#[test]
fn a_wrong_sound_speed_is_named() {
    let found = verdict(THREE, |campaign| ranges(campaign, 1.01));
    assert_named(&found, &["range_scale", "range_offset"]);
}

/// The pole slips by 0.3 deg and 3 cm before the last of three passes.
#[test]
fn the_pass_of_a_slipped_pole_is_named() {
    let scenario = Scenario::from_toml(THREE).expect("a scenario");
    let before = simulate(&scenario, 3).expect("a survey");
    let mut slipped = scenario.clone();
    slipped.truth.lever_arm_correction_m[0] += 0.03;
    slipped.truth.correction_deg.roll += 0.3;
    let after = simulate(&slipped, 3).expect("a survey");
    let found = verdict(THREE, |campaign| {
        let last = after.campaign.soundings.time_s.len() * 2 / 3;
        let begin_s = after.campaign.soundings.time_s[last];
        splice(campaign, &before.campaign, &after.campaign, begin_s - 10.0);
    });
    assert_named(&found, &["mounting_of_pass"]);
    assert!(
        found.findings[0].seen.contains("pass 3"),
        "{}",
        found.findings[0].seen
    );
}

/// Soundings of one survey until a moment, of another after it.
fn splice(into: &mut Campaign, first: &Campaign, second: &Campaign, at_s: f64) {
    let mut soundings = first.soundings.clone();
    let keep = first.soundings.time_s.partition_point(|t| *t < at_s);
    let from = second.soundings.time_s.partition_point(|t| *t < at_s);
    let join = |a: &[f64], b: &[f64]| [&a[..keep], &b[from..]].concat();
    let (a, b) = (&first.soundings, &second.soundings);
    soundings.time_s = join(&a.time_s, &b.time_s);
    soundings.across_rad = join(&a.across_rad, &b.across_rad);
    soundings.along_rad = join(&a.along_rad, &b.along_rad);
    soundings.ping = [&a.ping[..keep], &b.ping[from..]].concat();
    soundings.beam = [&a.beam[..keep], &b.beam[from..]].concat();
    soundings.range = SoundingRange::Metres(join(a.range.values(), b.range.values()));
    into.soundings = soundings;
}

#[test]
fn signs_and_order_of_the_attitude_are_named() {
    let roll = verdict(ONE, |campaign| {
        scaled(&mut campaign.trajectory.roll_rad, -1.0);
    });
    assert_named(&roll, &["sign_of_roll"]);
    let pitch = verdict(ONE, |campaign| {
        scaled(&mut campaign.trajectory.pitch_rad, -1.0);
    });
    assert_named(&pitch, &["sign_of_pitch", "attitude_scale"]);
    let exchanged = verdict(ONE, |campaign| {
        let t = &mut campaign.trajectory;
        std::mem::swap(&mut t.roll_rad, &mut t.pitch_rad);
    });
    assert_named(&exchanged, &["roll_and_pitch_exchanged"]);
}

#[test]
fn units_and_axes_are_named() {
    let doubled = verdict(ONE, |campaign| ranges(campaign, 2.0));
    assert_named(&doubled, &["range_doubled"]);
    let feet = verdict(ONE, |campaign| ranges(campaign, 1.0 / 0.3048));
    assert_named(&feet, &["range_unit"]);
    let arm = verdict(ONE, |campaign| {
        let arm = campaign.scanner.lever_arm_m;
        campaign.scanner.lever_arm_m = Vector3::new(arm.y, arm.x, -arm.z);
    });
    assert_named(&arm, &["axes_of_scanner_arm"]);
    let azimuth = verdict_with(ONE, &JointConfig::default(), |_, prior| {
        prior.azimuth_rad += std::f64::consts::PI;
    });
    assert_named(&azimuth, &["target_azimuth"]);
}
