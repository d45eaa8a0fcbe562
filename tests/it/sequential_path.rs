//! The reference path on exact soundings of a small forward model: a wall, two columns of inclined faces, block tops.

use boresight::geometry::{PlaneFit, plane, rotation};
use boresight::observe::Mounting;
use boresight::procedures::pool::SequentialConfig;
use boresight::procedures::pool::config::Variant;
use boresight::procedures::pool::sequential::{
    Axis, End, FaceSoundings, HorizontalReturns, HorizontalSoundings, Outcome, RoleSoundings,
    ScannerPlanes, SequentialError, offset_m, run,
};
use boresight::results::Status;
use nalgebra::{Matrix3, Vector3};

const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Heights of the block tops that the scanner and the multibeam see, metres.
const TOPS_M: [f64; 2] = [0.9, -1.5];

#[derive(Clone, Copy, PartialEq)]
enum On {
    P1,
    P2,
    P3,
    Top,
}

/// A point of the target, sounded: its face, the body's pose and the beam vector in the sonar frame.
struct Sounding {
    on: On,
    position_m: Vector3<f64>,
    attitude: Matrix3<f64>,
    u_m: Vector3<f64>,
}

/// How the boat moves while it passes.
#[derive(Clone, Copy)]
struct Boat {
    /// Heading against the target's +Y axis, radians.
    heading_rad: f64,
    /// Amplitude of roll, pitch and heading, radians.
    sway_rad: f64,
    /// Attitude written into the sums: the true one, or none, as the patent has it.
    carry_over: bool,
}

const PARALLEL: Boat = Boat {
    heading_rad: 0.0,
    sway_rad: 0.02,
    carry_over: true,
};

fn on_p1(a: f64, z: f64) -> Vector3<f64> {
    Vector3::new(-0.75, -4.75, z) + Vector3::new(HALF, HALF, 0.0) * a
}

fn on_p3(a: f64, z: f64) -> Vector3<f64> {
    Vector3::new(-0.75, 4.75, z) + Vector3::new(-HALF, HALF, 0.0) * a
}

/// Points of every face between two heights.
fn points(low_m: f64, high_m: f64, top_m: f64) -> Vec<(On, Vector3<f64>)> {
    let mut points = vec![];
    for i in 0..40 {
        for j in 0..12 {
            let (s, t) = (f64::from(i) / 39.0, f64::from(j) / 11.0);
            let z = low_m + t * (high_m - low_m);
            points.push((On::P2, Vector3::new(0.0, -4.0 + 8.0 * s, z)));
            points.push((On::P1, on_p1(2.0 * s - 1.0, z)));
            points.push((On::P3, on_p3(2.0 * s - 1.0, z)));
            points.push((On::Top, Vector3::new(-0.3 * s, -5.2 - 0.3 * t, top_m)));
            points.push((On::Top, Vector3::new(-0.3 * s, 5.2 + 0.3 * t, top_m)));
        }
    }
    points
}

fn fit_of(points: &[(On, Vector3<f64>)], on: On) -> PlaneFit {
    let chosen: Vec<_> = points.iter().filter(|p| p.0 == on).map(|p| p.1).collect();
    plane::fit(&chosen)
        .expect("a plane")
        .towards(&-Vector3::x())
}

fn scanner() -> ScannerPlanes {
    let seen = points(0.2, 2.8, TOPS_M[0]);
    ScannerPlanes {
        p1: fit_of(&seen, On::P1),
        p2: fit_of(&seen, On::P2),
        p3: fit_of(&seen, On::P3),
        wall_mean_x_m: 0.0,
        horizontal: vec![HorizontalReturns {
            face: 7,
            design_height_m: TOPS_M[0],
            mean_height_m: TOPS_M[0],
            count: 960,
        }],
    }
}

/// Soundings of every point below the water by a sonar that is truly mounted as `truth`.
fn soundings(truth: &Mounting, boat: &Boat) -> Vec<Sounding> {
    let sound = |(k, (on, point)): (usize, (On, Vector3<f64>))| {
        let phase = k as f64;
        let sway = |f: f64| boat.sway_rad * (f * phase).sin();
        let attitude =
            rotation::from_attitude(sway(0.37), sway(0.23), -boat.heading_rad + sway(0.11));
        let position_m = Vector3::new(-6.0 + 0.3 * (0.01 * phase).sin(), point.y + 0.2, 1.2);
        let in_body = attitude.tr_mul(&(point - position_m)) - truth.lever_arm_m;
        Sounding {
            on,
            position_m,
            attitude,
            u_m: truth.rotation.tr_mul(&in_body),
        }
    };
    points(-2.8, -0.3, TOPS_M[1])
        .into_iter()
        .enumerate()
        .map(sound)
        .collect()
}

/// Georeferences all soundings with a mounting; which face they belong to is known.
fn pooled(soundings: &[Sounding], mounting: &Mounting, boat: &Boat) -> RoleSoundings {
    let mut roles = RoleSoundings::default();
    let mut tops = FaceSoundings::default();
    for s in soundings {
        let point = s.position_m + s.attitude * (mounting.rotation * s.u_m + mounting.lever_arm_m);
        let attitude = if boat.carry_over {
            s.attitude
        } else {
            Matrix3::identity()
        };
        match s.on {
            On::P1 => roles.p1.add(&point, &attitude),
            On::P2 => roles.p2.add(&point, &attitude),
            On::P3 => roles.p3.add(&point, &attitude),
            On::Top => tops.add(&point, &attitude),
        }
    }
    roles.horizontal.push(HorizontalSoundings {
        design_height_m: TOPS_M[1],
        soundings: tops,
    });
    roles
}

fn nominal() -> Mounting {
    Mounting::from_angles(-0.8, 0.01, -0.02, Vector3::new(0.5, -0.2, -1.6))
}

/// The truth that differs from the nominal mounting by these corrections (degrees, metres).
fn truth(delta_deg: [f64; 3], lever_m: [f64; 3]) -> Mounting {
    nominal().corrected(
        &Vector3::from(delta_deg).map(f64::to_radians),
        &Vector3::from(lever_m),
    )
}

fn config(variant: Variant, repeated: bool, threshold_deg: f64) -> SequentialConfig {
    SequentialConfig {
        variant,
        repeated,
        threshold_deg,
        ..SequentialConfig::default()
    }
}

fn calibrate(
    truth: &Mounting,
    boat: &Boat,
    config: &SequentialConfig,
) -> Result<Outcome, SequentialError> {
    let soundings = soundings(truth, boat);
    run(&nominal(), &scanner(), config, &mut |mounting, _| {
        pooled(&soundings, mounting, boat)
    })
}

/// Error of the rotation found, degrees.
fn error_deg(outcome: &Outcome, truth: &Mounting) -> Vector3<f64> {
    outcome.mounting.correction_from(truth).map(f64::to_degrees)
}

#[test]
fn projected_finds_the_rotation_when_the_lever_arm_is_right() {
    let truth = truth([0.6, -0.9, 1.2], [0.0; 3]);
    let outcome =
        calibrate(&truth, &PARALLEL, &config(Variant::Projected, false, 1e-5)).expect("runs");
    assert!(
        matches!(outcome.end, End::Converged { .. }),
        "{:?}",
        outcome.end
    );
    assert!(
        error_deg(&outcome, &truth).norm() < 3e-4,
        "{}",
        error_deg(&outcome, &truth)
    );
    assert!((outcome.mounting.lever_arm_m - truth.lever_arm_m).norm() < 5e-5);
    assert!(outcome.passes.len() < 20);
    assert_eq!(outcome.passes[0].correction_rad, Vector3::zeros());
    assert!(outcome.passes[0].angle_rad[0].to_degrees() > 0.5);
    let last = outcome.passes.last().expect("a pass");
    assert!(last.angle_rad.iter().all(|a| a.to_degrees() < 3e-4));
}

#[test]
fn signs_are_right_for_each_angle_alone_in_both_variants() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            for variant in [Variant::Literal, Variant::Projected] {
                let mut delta = [0.0; 3];
                delta[axis] = sign * 0.5;
                let truth = truth(delta, [0.0; 3]);
                let mut one_pass = config(variant, false, 0.0);
                one_pass.max_passes = 1;
                let outcome = calibrate(&truth, &PARALLEL, &one_pass).expect("runs");
                let first = outcome.passes[1].correction_rad[axis].to_degrees();
                // a yaw seen abeam turns P3 by half only: the boat moves along with the soundings
                assert!(
                    (0.2..0.52).contains(&(first * sign)),
                    "{axis} {sign} {variant:?}: {first}"
                );
            }
        }
    }
}

#[test]
fn literal_comes_close_and_says_how_it_ended() {
    let truth = truth([0.6, -0.9, 1.2], [0.0; 3]);
    let outcome = calibrate(&truth, &PARALLEL, &SequentialConfig::default()).expect("runs");
    let solution = outcome.solution(None);
    assert!(solution.usable, "{solution:?}");
    assert_eq!(solution.details["variant"], "literal");
    let passes = solution.details["passes"].as_array().expect("passes");
    assert_eq!(passes.len(), outcome.passes.len());
    assert!(
        error_deg(&outcome, &truth).norm() < 0.2,
        "{}",
        error_deg(&outcome, &truth)
    );
    let angle = |pass: &serde_json::Value| pass["angle_deg"]["P1"].as_f64().expect("an angle");
    let start = angle(&passes[0]);
    assert!(start > 0.5 && angle(passes.last().expect("pass")) < 0.2 * start);
}

/// The scanner's P1 is turned by 0.3 deg against its P2 and P3: no rotation aligns all, and the literal variant cycles.
#[test]
fn literal_stalls_in_a_cycle_and_keeps_its_best_pass() {
    let truth = truth([0.6, -0.9, 1.2], [0.0; 3]);
    let mut scanner = scanner();
    scanner.p1.plane.normal =
        rotation::exp(&Vector3::new(0.003, -0.002, 0.004)) * scanner.p1.plane.normal;
    let soundings = soundings(&truth, &PARALLEL);
    let outcome = run(
        &nominal(),
        &scanner,
        &SequentialConfig::default(),
        &mut |m, _| pooled(&soundings, m, &PARALLEL),
    )
    .expect("runs");
    let largest = |k: usize| outcome.passes[k].angle_rad.into_iter().fold(0.0, f64::max);
    let (End::Cycle {
        kept_pass,
        largest_rad,
        ..
    }
    | End::NoProgress {
        kept_pass,
        largest_rad,
    }) = outcome.end
    else {
        panic!("{:?} {:?}", outcome.end, outcome.passes)
    };
    assert_eq!(outcome.solution(None).status, Status::Stalled);
    assert!(
        outcome
            .solution(None)
            .message
            .contains(&format!("pass {kept_pass} kept")),
        "{}",
        outcome.solution(None).message
    );
    assert!(largest_rad > 0.05_f64.to_radians());
    assert!((0..outcome.passes.len()).all(|k| largest(k) >= largest_rad));
    let kept = outcome.passes[kept_pass as usize].correction_rad;
    assert!((outcome.mounting.correction_from(&outcome.nominal) - kept).norm() < 1e-12);
}

#[test]
fn offsets_are_exact_on_any_heading_when_the_rotation_is_right() {
    for heading_deg in [0.0_f64, 17.0, 100.0, -160.0] {
        let boat = Boat {
            heading_rad: heading_deg.to_radians(),
            sway_rad: 0.0,
            carry_over: true,
        };
        let truth = truth([0.0; 3], [0.08, -0.12, 0.05]);
        let outcome = calibrate(&truth, &boat, &SequentialConfig::default()).expect("runs");
        let off = outcome.mounting.lever_arm_m - truth.lever_arm_m;
        assert!(off.norm() < 1e-9, "{heading_deg}: {off}");
        let axes: Vec<Axis> = outcome.offsets.iter().map(|o| o.axis).collect();
        assert_eq!(axes, [Axis::X, Axis::Z, Axis::Y]);
    }
}

/// The face stands at 45 deg, so an X offset of 80 mm looks like 80 mm of Y when Y is taken before X.
#[test]
fn y_before_x_is_wrong_by_the_whole_x_offset() {
    let truth = truth([0.0; 3], [0.08, 0.0, 0.0]);
    let still = Boat {
        sway_rad: 0.0,
        ..PARALLEL
    };
    let soundings = soundings(&truth, &still);
    let before =
        offset_m(Axis::Y, &scanner(), &pooled(&soundings, &nominal(), &still)).expect("P1");
    assert!((before.abs() - 0.08).abs() < 1e-9, "{before}");
    let after = offset_m(Axis::Y, &scanner(), &pooled(&soundings, &truth, &still)).expect("P1");
    assert!(after.abs() < 1e-9, "{after}");
}

/// \[0041\] words the difference as multibeam minus scanner; added to the lever arm, that doubles the error.
#[test]
fn offsets_are_scanner_minus_multibeam() {
    let truth = truth([0.0; 3], [0.08, -0.12, 0.05]);
    let still = Boat {
        sway_rad: 0.0,
        ..PARALLEL
    };
    let outcome = calibrate(&truth, &still, &SequentialConfig::default()).expect("runs");
    let added: Vector3<f64> = outcome.offsets.iter().map(|o| o.body_m).sum();
    let missing = truth.lever_arm_m - nominal().lever_arm_m;
    assert!((added - missing).norm() < 1e-9);
    assert!((nominal().lever_arm_m - added - truth.lever_arm_m).norm() > 1.99 * missing.norm());
}

#[test]
fn without_transfer_to_the_body_the_angles_diverge_beyond_sixty_degrees() {
    let truth = truth([0.3, -0.4, 0.5], [0.0; 3]);
    let run = |heading_deg: f64, carry_over: bool| {
        let boat = Boat {
            heading_rad: heading_deg.to_radians(),
            sway_rad: 0.01,
            carry_over,
        };
        calibrate(&truth, &boat, &config(Variant::Projected, false, 1e-4))
    };
    let carried = run(100.0, true).expect("runs");
    assert!(
        matches!(carried.end, End::Converged { .. }),
        "{:?}",
        carried.end
    );
    assert!(error_deg(&carried, &truth).norm() < 1e-3);
    let near = run(30.0, false).expect("runs");
    assert!(matches!(near.end, End::Converged { .. }), "{:?}", near.end);
    let largest = |o: &Outcome, k: usize| o.passes[k].angle_rad.into_iter().fold(0.0, f64::max);
    match run(100.0, false) {
        Ok(lost) => {
            assert!(!matches!(lost.end, End::Converged { .. }), "{:?}", lost.end);
            assert!(largest(&lost, lost.passes.len() - 1) > 3.0 * largest(&lost, 0));
        }
        Err(fault) => assert!(matches!(fault, SequentialError::NoPlane { .. }), "{fault}"),
    }
}

/// With a wrong lever arm and a rolling boat the single round is biased, without any noise; repeating heals it.
#[test]
fn repeating_removes_the_bias_of_the_single_round() {
    let truth = truth([0.3, -0.4, 0.5], [0.1, -0.15, 0.08]);
    let boat = Boat {
        heading_rad: 0.1,
        sway_rad: 0.08,
        carry_over: true,
    };
    let single = calibrate(&truth, &boat, &config(Variant::Projected, false, 1e-4)).expect("runs");
    let repeated = calibrate(&truth, &boat, &config(Variant::Projected, true, 1e-4)).expect("runs");
    assert_eq!(single.rounds, 1);
    assert!(repeated.rounds > 1 && repeated.rounds < 20);
    let (once, again) = (
        error_deg(&single, &truth).norm(),
        error_deg(&repeated, &truth).norm(),
    );
    assert!(once > 0.01, "{once}");
    assert!(again < 0.002, "{again}");
    let off = |o: &Outcome| (o.mounting.lever_arm_m - truth.lever_arm_m).norm();
    assert!(
        off(&single) > 10.0 * off(&repeated) && off(&repeated) < 5e-4,
        "{} {}",
        off(&single),
        off(&repeated)
    );
    assert_eq!(
        repeated.solution(None).details["variant"],
        "projected, repeated"
    );
}

#[test]
fn a_plane_without_soundings_is_named() {
    let all = soundings(&nominal(), &PARALLEL);
    let without = |on: On| {
        run(
            &nominal(),
            &scanner(),
            &SequentialConfig::default(),
            &mut |m, _| {
                let few: Vec<Sounding> = all
                    .iter()
                    .filter(|s| s.on != on)
                    .map(|s| Sounding { ..*s })
                    .collect();
                pooled(&few, m, &PARALLEL)
            },
        )
    };
    for (on, name) in [
        (On::P1, "P1"),
        (On::P2, "P2"),
        (On::P3, "P3"),
        (On::Top, "the horizontal faces"),
    ] {
        match without(on) {
            Err(SequentialError::TooFewSoundings {
                plane, found: 0, ..
            }) => assert_eq!(plane, name),
            other => panic!("{name}: {other:?}"),
        }
    }
    let mut blind = scanner();
    blind.horizontal.clear();
    let outcome = run(
        &nominal(),
        &blind,
        &SequentialConfig::default(),
        &mut |m, _| pooled(&all, m, &PARALLEL),
    );
    assert_eq!(outcome, Err(SequentialError::NoHorizontalReturns));
}

#[test]
fn contrary_headings_are_refused() {
    let truth = truth([0.3, 0.0, 0.0], [0.0; 3]);
    let back = Boat {
        heading_rad: std::f64::consts::PI,
        ..PARALLEL
    };
    let (there, again) = (soundings(&truth, &PARALLEL), soundings(&truth, &back));
    let outcome = run(
        &nominal(),
        &scanner(),
        &SequentialConfig::default(),
        &mut |m, _| {
            let mut all = pooled(&there, m, &PARALLEL);
            let other = pooled(&again, m, &back);
            all.p1.merge(&other.p1);
            all.p2.merge(&other.p2);
            all.p3.merge(&other.p3);
            all
        },
    );
    assert!(
        matches!(outcome, Err(SequentialError::ContraryHeadings { .. })),
        "{outcome:?}"
    );
}
