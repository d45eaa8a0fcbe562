//! The simulator against theory, and against a georeferencing written only for this test.

use boresight::geometry::Geodetic;
use boresight::geometry::ellipsoid::ecef_from_level;
use boresight::observe::SoundingRange;
use boresight::simulate::{DEMO, Scenario, Simulated, Source, Sources, simulate};
use boresight::target::Face;
use nalgebra::{Matrix3, Rotation3, Vector3};

const FLOOR_M: f64 = -4.5;

/// A short pass of the demo on which only these sources act.
fn short(sources: Sources) -> Scenario {
    let mut scenario = Scenario::from_toml(DEMO).expect("the embedded scenario");
    scenario.pass.truncate(1);
    scenario.pass[0].from_m = -6.0;
    scenario.pass[0].to_m = 6.0;
    scenario.multibeam.ping_rate_hz = 4.0;
    scenario.sources = sources;
    scenario
}

/// Attitude as elementary turns: about z by -heading, about x by pitch, about y by roll.
fn attitude(roll: f64, pitch: f64, heading: f64) -> Matrix3<f64> {
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
    let turned = about(Vector3::z_axis(), -heading) * about(Vector3::x_axis(), pitch);
    (turned * about(Vector3::y_axis(), roll)).into_inner()
}

/// Time, position and attitude in the true target frame of the first record not before a time.
fn record(survey: &Simulated, time_s: f64) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let t = &survey.campaign.trajectory;
    let k = t.time_s.partition_point(|&x| x < time_s - 1e-7);
    let place = Geodetic {
        latitude_rad: t.latitude_rad[k],
        longitude_rad: t.longitude_rad[k],
        height_m: t.height_m[k],
    };
    let frame = survey.reality.target.ecef_from_target();
    let to_target = frame.rotation.matrix.transpose();
    let ecef = t.ellipsoid.to_geocentric(&place).coordinates;
    let body = attitude(t.roll_rad[k], t.pitch_rad[k], t.heading_rad[k]);
    (
        t.time_s[k],
        to_target * (ecef - frame.translation.coordinates),
        to_target * ecef_from_level(&place).matrix * body,
    )
}

fn metres(range: &SoundingRange) -> &[f64] {
    let SoundingRange::Metres(metres) = range else {
        panic!("expected metres")
    };
    metres
}

/// Distance from the nearest true face that the point lies on, or from the floor.
fn misfit(survey: &Simulated, p: &Vector3<f64>) -> f64 {
    let target = &survey.target;
    let off = |f: &Face| {
        let true_offset = target.offsets[f.offset].value_m + survey.reality.offsets_m[f.offset];
        let h = target.groups[f.group].normal.dot(p) - true_offset;
        if f.outline.inside_m(p) > -0.02 {
            h.abs()
        } else {
            f64::INFINITY
        }
    };
    let floor = (p.z - FLOOR_M).abs();
    target.faces.iter().map(off).fold(floor, f64::min)
}

#[test]
fn without_noise_every_sounding_lies_on_its_face() {
    let scenario = short(Sources::none().with(Source::TargetOffsets, 1.0));
    let survey = simulate(&scenario, 7).expect("a survey");
    let s = &survey.campaign.soundings;
    assert!(s.len() > 10_000, "{}", s.len());
    let mut worst_m = 0.0_f64;
    for k in 0..s.len() {
        let (time_s, position, body) = record(&survey, s.time_s[k]);
        assert!((time_s - s.time_s[k]).abs() < 1e-9);
        let (a, r) = (s.across_rad[k], metres(&s.range)[k]);
        let u = Vector3::new(r * a.sin(), 0.0, -r * a.cos());
        let p = position + body * (survey.truth.rotation() * u + survey.truth.lever_arm());
        worst_m = worst_m.max(misfit(&survey, &p));
    }
    // geocentric coordinates are only good to a nanometre, geodetic ones to a few
    assert!(worst_m < 1e-8, "{worst_m} m");
}

#[test]
fn without_noise_every_return_lies_on_its_face() {
    let mut scenario = short(Sources::none().with(Source::TargetOffsets, 1.0));
    // a shot every 2 ms, each on a record
    scenario.trajectory.rate_hz = 500.0;
    scenario.lidar.line_rate_hz = 1.0;
    scenario.lidar.points_per_line = 401;
    let survey = simulate(&scenario, 7).expect("a survey");
    let laser = &survey.campaign.laser;
    assert!(laser.len() > 500, "{}", laser.len());
    for k in 0..laser.len() {
        let (time_s, position, body) = record(&survey, laser.time_s[k]);
        assert!((time_s - laser.time_s[k]).abs() < 1e-9);
        let scanner = &survey.campaign.scanner;
        let p = position + body * (scanner.rotation * laser.point(k) + scanner.lever_arm_m);
        assert!(misfit(&survey, &p) < 1e-8 && p.z > -1e-9, "{p:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_survey_and_another_seed_another() {
    let scenario = short(Sources::default());
    let run = |seed| simulate(&scenario, seed).expect("a survey").campaign;
    let (a, b, c) = (run(3), run(3), run(4));
    assert!(a.soundings == b.soundings && a.laser == b.laser && a.trajectory == b.trajectory);
    assert!(a.soundings != c.soundings && a.laser != c.laser && a.trajectory != c.trajectory);
}

/// Common random numbers: with one source off, what the other sources drew is what they drew before.
#[test]
fn switching_a_source_off_leaves_the_others_alone() {
    let scenario = |sources| simulate(&short(sources), 11).expect("a survey").campaign;
    let all = scenario(Sources::default());
    let no_range = scenario(Sources::default().with(Source::SonarRange, 0.0));
    assert_eq!(all.soundings.across_rad, no_range.soundings.across_rad);
    assert_eq!(all.trajectory, no_range.trajectory);
    assert_eq!(all.laser, no_range.laser);
    assert_ne!(all.soundings.range, no_range.soundings.range);
    let no_angle = scenario(Sources::default().with(Source::SonarAngle, 0.0));
    assert_eq!(all.soundings.range, no_angle.soundings.range);
    let still = scenario(Sources::none());
    let only = scenario(Sources::only(&[Source::PositionDrift]));
    let rest = scenario(Sources::default().with(Source::PositionDrift, 0.0));
    let height = |c: &boresight::observe::Campaign, k: usize| c.trajectory.height_m[k];
    for k in (0..all.trajectory.time_s.len()).step_by(50) {
        let drift = height(&only, k) - height(&still, k);
        assert!((height(&all, k) - height(&rest, k) - drift).abs() < 1e-8);
    }
}

/// Latency and range scale as the interface has them: epoch = stamp - latency, true range = measured x (1 + scale).
#[test]
fn latency_and_range_scale_have_the_signs_of_the_interface() {
    let mut scenario = short(Sources::none());
    let plain = simulate(&scenario, 1).expect("a survey").campaign.soundings;
    scenario.truth.latency_s = 0.02;
    scenario.truth.range_scale = 0.01;
    scenario.sources = scenario
        .sources
        .with(Source::Latency, 1.0)
        .with(Source::SoundSpeed, 1.0);
    let wrong = simulate(&scenario, 1).expect("a survey").campaign.soundings;
    assert_eq!(plain.len(), wrong.len());
    for k in 0..plain.len() {
        assert!((wrong.time_s[k] - plain.time_s[k] - 0.02).abs() < 1e-9);
        let truth = metres(&wrong.range)[k] * 1.01;
        assert!((truth - metres(&plain.range)[k]).abs() < 1e-12);
    }
}

/// Travel times to a level floor through a constant gradient: `t = ln(tan(a1/2) / tan(a0/2)) / g` with Snell's `sin a / c` constant.
#[test]
fn bent_rays_take_the_time_of_the_closed_form() {
    let mut scenario = short(Sources::none());
    scenario.pass[0].distance_m = 1000.0; // nothing but the floor within reach
    scenario.multibeam.records = boresight::simulate::scenario::Recorded::TravelTime;
    let (surface, gradient) = (1500.0, 4.0);
    let text = format!(
        "profile = [[0.0, {surface}], [20.0, {}]]",
        surface + 20.0 * gradient
    );
    scenario.sound_speed = Some(toml::from_str(&text).expect("a profile"));
    let survey = simulate(&scenario, 1).expect("a survey");
    let s = &survey.campaign.soundings;
    let SoundingRange::TwoWayTravelTime(times) = &s.range else {
        panic!("expected travel times")
    };
    let (mut steep, mut flat) = (0, 0);
    for (k, &time_s) in times.iter().enumerate() {
        let (_, position, body) = record(&survey, s.time_s[k]);
        let a = s.across_rad[k];
        let down = -(body * survey.truth.rotation() * Vector3::new(a.sin(), 0.0, -a.cos())).z;
        let depth = -(position + body * survey.truth.lever_arm()).z;
        let (c0, c1) = (surface + gradient * depth, surface - gradient * FLOOR_M);
        let begin = down.clamp(-1.0, 1.0).acos();
        let end_sine = begin.sin() * c1 / c0;
        if down < 0.2 || end_sine > 0.98 {
            flat += 1;
            continue; // grazing rays: the closed form and the steps both lose digits
        }
        steep += 1;
        let expected = ((end_sine.asin() / 2.0).tan() / (begin / 2.0).tan()).ln() / gradient;
        assert!(
            (0.5 * time_s - expected).abs() * 1500.0 < 1e-6,
            "{time_s} {expected}"
        );
    }
    assert!(steep > 5000 && flat < steep, "{steep} {flat}");
}

/// Speed falling with depth loses no hit on the way; a speed that no water has is refused.
#[test]
fn falling_speed_bends_rays_and_loses_none() {
    let mut scenario = short(Sources::none());
    let water = |gradient: f64| {
        let text = format!("speed_m_s = 1480.0\ngradient_error_1_s = {gradient}");
        Some(toml::from_str(&text).expect("water"))
    };
    scenario.sources = Sources::only(&[Source::SoundSpeedGradient]);
    let soundings =
        |scenario: &Scenario| simulate(scenario, 1).expect("a survey").campaign.soundings;
    scenario.sound_speed = water(0.0);
    let straight = soundings(&scenario).len();
    for gradient in [-1e-6, -0.1, -0.2, -1.0] {
        scenario.sound_speed = water(gradient);
        let bent = soundings(&scenario).len();
        let lost = straight as f64 - bent as f64;
        println!("{gradient}: {bent} of {straight}");
        assert!(
            lost < 0.001 * straight as f64,
            "{gradient}: {bent} of {straight}"
        );
    }
    scenario.sound_speed = water(-5.0);
    scenario.multibeam.max_range_m = 200.0;
    let faults = scenario.check();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(
        faults[0].starts_with("sound_speed: true speed at 20"),
        "{faults:?}"
    );
    scenario.sources = Sources::none();
    assert_eq!(scenario.check(), Vec::<String>::new());
}

#[test]
fn gross_errors_are_as_many_and_as_wide_as_asked() {
    let mut scenario = short(Sources::only(&[Source::GrossErrors]));
    scenario.disturbance.gross_fraction = 0.3;
    scenario.disturbance.gross_range_m = 3.0;
    let survey = simulate(&scenario, 4).expect("a survey").campaign.soundings;
    scenario.sources = Sources::none();
    let clean = simulate(&scenario, 4).expect("a survey").campaign.soundings;
    let place = |s: &boresight::observe::Soundings, k: usize| (s.ping[k], s.beam[k]);
    let ranges: std::collections::BTreeMap<_, _> = (0..clean.len())
        .map(|k| (place(&clean, k), metres(&clean.range)[k]))
        .collect();
    let errors: Vec<f64> = (0..survey.len())
        .map(|k| metres(&survey.range)[k] - ranges[&place(&survey, k)])
        .filter(|e| e.abs() > 1e-9)
        .collect();
    let (count, all) = (errors.len() as f64, survey.len() as f64);
    let four_sigma = 4.0 * (0.3 * 0.7 / all).sqrt();
    assert!(
        (count / all - 0.3).abs() < four_sigma + 0.005,
        "{}",
        count / all
    );
    assert!(errors.iter().all(|e| e.abs() <= 3.0));
    let ratio = variance(&errors) / 3.0; // a uniform error within 3 m has the variance 3 m2
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// Even when another scene makes other beams hit, the beams common to both keep their noise.
#[test]
fn a_beam_keeps_its_noise_whatever_the_others_hit() {
    let noise = |truth_roll: f64| {
        let mut noisy = short(Sources::only(&[Source::SonarRange]));
        noisy.truth.correction_deg.roll = truth_roll;
        let mut silent = noisy.clone();
        silent.sources = Sources::none();
        let (a, b) = (
            simulate(&noisy, 5).expect("a survey"),
            simulate(&silent, 5).expect("a survey"),
        );
        let (a, b) = (a.campaign.soundings, b.campaign.soundings);
        let place = |k: usize| (a.ping[k], a.beam[k]);
        (0..a.len())
            .map(|k| (place(k), metres(&a.range)[k] - metres(&b.range)[k]))
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    let (one, two) = (noise(0.0), noise(5.0));
    assert_ne!(one.len(), two.len());
    let common: Vec<_> = one
        .iter()
        .filter_map(|(k, v)| two.get(k).map(|w| (v, w)))
        .collect();
    assert!(common.len() > 5000);
    assert!(common.iter().all(|(v, w)| (*v - *w).abs() < 1e-12));
}

fn variance(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
}

#[test]
fn white_noise_has_the_variances_it_claims() {
    let mut scenario = short(Sources::none());
    scenario.disturbance = boresight::simulate::scenario::Disturbance::default();
    let still = simulate(&scenario, 2).expect("a survey").campaign;
    scenario.sources = Sources::only(&[
        Source::SonarRange,
        Source::SonarAngle,
        Source::LaserRange,
        Source::PositionWhite,
        Source::RollPitch,
        Source::Heading,
    ]);
    let noisy = simulate(&scenario, 2).expect("a survey").campaign;
    let differences =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
    let range_of = |c: &boresight::observe::Campaign| {
        (0..c.laser.len())
            .map(|k| c.laser.point(k).norm())
            .collect::<Vec<_>>()
    };
    let (s, t) = (&noisy.soundings, &noisy.trajectory);
    let degree = 1.0_f64.to_radians();
    let cases = [
        (
            "sonar range",
            differences(metres(&s.range), metres(&still.soundings.range)),
            0.01,
        ),
        (
            "sonar angle",
            differences(&s.across_rad, &still.soundings.across_rad),
            0.06 * degree,
        ),
        (
            "laser range",
            differences(&range_of(&noisy), &range_of(&still)),
            0.005,
        ),
        (
            "height",
            differences(&t.height_m, &still.trajectory.height_m),
            0.002,
        ),
        (
            "roll",
            differences(&t.roll_rad, &still.trajectory.roll_rad),
            0.003 * degree,
        ),
        (
            "pitch",
            differences(&t.pitch_rad, &still.trajectory.pitch_rad),
            0.003 * degree,
        ),
        (
            "heading",
            differences(&t.heading_rad, &still.trajectory.heading_rad),
            0.005 * degree,
        ),
    ];
    for (name, errors, sigma) in cases {
        let (count, ratio) = (errors.len() as f64, variance(&errors) / (sigma * sigma));
        assert!(count > 1000.0, "{name}: {count}");
        // chi-square on `count`: sigma of the ratio is sqrt(2/n); four of them
        assert!(
            (ratio - 1.0).abs() < 4.0 * (2.0 / count).sqrt(),
            "{name}: {ratio}"
        );
    }
}

/// Over many seeds: variance sigma^2 at every time and covariance sigma^2 exp(-dt/tau) between two passes, across the gap.
#[test]
fn the_drift_is_a_gauss_markov_process_across_gaps() {
    let mut scenario = Scenario::from_toml(DEMO).expect("the embedded scenario");
    scenario.pass.truncate(2);
    for pass in &mut scenario.pass {
        (pass.from_m, pass.to_m, pass.speed_m_s, pass.gap_s) = (-0.4, 0.4, 0.8, 30.0);
    }
    scenario.trajectory.rate_hz = 10.0;
    scenario.multibeam.beams = 2;
    scenario.lidar.points_per_line = 2;
    let height =
        |sources: Sources, seed| scenario_with(&scenario, sources, seed).campaign.trajectory;
    let still = height(Sources::none(), 0);
    let last = still.time_s.len() - 1;
    let seeds = 2000;
    let (mut begin, mut end, mut product) = (vec![], vec![], 0.0);
    for seed in 0..seeds {
        let drifting = height(Sources::only(&[Source::PositionDrift]), seed);
        let (a, b) = (
            drifting.height_m[0] - still.height_m[0],
            drifting.height_m[last] - still.height_m[last],
        );
        begin.push(a / 0.01);
        end.push(b / 0.01);
        product += a * b / 0.01 / 0.01 / seeds as f64;
    }
    let span_s = still.time_s[last] - still.time_s[0];
    assert!(span_s > 30.0);
    let expected = (-span_s / 60.0).exp();
    let tolerance = 4.0 * (2.0 / seeds as f64).sqrt();
    assert!(
        (variance(&begin) - 1.0).abs() < tolerance,
        "{}",
        variance(&begin)
    );
    assert!(
        (variance(&end) - 1.0).abs() < tolerance,
        "{}",
        variance(&end)
    );
    let spread = ((1.0 + expected * expected) / seeds as f64).sqrt();
    assert!(
        (product - expected).abs() < 4.0 * spread,
        "{product} {expected}"
    );
}

fn scenario_with(scenario: &Scenario, sources: Sources, seed: u64) -> Simulated {
    let scenario = Scenario {
        sources,
        ..scenario.clone()
    };
    simulate(&scenario, seed).expect("a survey")
}

/// Roll, pitch and crab angle of the scenario are what the INS records, in the signs of the conventions.
#[test]
fn the_recorded_attitude_is_the_motion_asked_for() {
    let mut scenario = short(Sources::none());
    let still = "height = { mean = 1.0 }\nroll = { mean = 2.0 }\npitch = { mean = 1.0 }";
    scenario.motion = toml::from_str(still).expect("a motion");
    scenario.pass[0].crab_deg = 10.0;
    let t = simulate(&scenario, 1)
        .expect("a survey")
        .campaign
        .trajectory;
    for k in (0..t.time_s.len()).step_by(100) {
        // the level turns by a thousandth of a degree in 100 m
        let near = |rad: f64, deg: f64| (rad.to_degrees() - deg).abs() < 1e-3;
        assert!(near(t.roll_rad[k], 2.0) && near(t.pitch_rad[k], 1.0));
        assert!(near(t.heading_rad[k], scenario.target.azimuth_deg + 10.0));
    }
}
