//! Where the time of a calibration goes. Each bench says which question it answers; compare ratios within one run.
//!
//! `cargo bench --bench calibrate`

use boresight::adjust::{
    Block, BlockId, ChainState, Component, Conditions, Estimate, Options, ParameterSet, Problem,
    Row, Source, Unit, solve,
};
use boresight::geometry::plane::PlaneMoments;
use boresight::georef::{Beam, along_normal, georeference};
use boresight::matching::{Gate, Patches, Spread, Verdict, Water};
use boresight::observe::{Mounting, PoseSample};
use boresight::procedures::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::simulate::{DEMO, Scenario, Simulated, simulate};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Matrix3, Vector3};

fn main() {
    divan::main();
}

const THIN: &str = include_str!("../models/scenarios/three-pass-thin.toml");

fn pose() -> PoseSample {
    PoseSample {
        position_m: Vector3::new(-6.0, 1.0, 1.0),
        rotation: boresight::geometry::rotation::from_attitude(0.02, -0.01, 0.03),
        record: 0,
        weight_before: 0.5,
    }
}

fn mounting() -> Mounting {
    Mounting::from_angles(-0.8, 0.01, 0.02, Vector3::new(0.5, -0.2, -1.6))
}

/// What does one sounding cost from beam to point?
#[divan::bench]
fn georeference_a_sounding(bencher: Bencher) {
    let (pose, mounting) = (pose(), mounting());
    let beam = Beam {
        range_m: 6.0,
        across_rad: 0.4,
        along_rad: 0.0,
    };
    bencher.bench_local(|| georeference(&pose, &mounting, &black_box(beam).vector_m()));
}

/// And with every derivative along a plane's normal?
#[divan::bench]
fn georeference_with_derivatives(bencher: Bencher) {
    let (pose, mounting) = (pose(), mounting());
    let normal = Vector3::new(-1.0, 0.0, 0.0);
    let beam = Beam {
        range_m: 6.0,
        across_rad: 0.4,
        along_rad: 0.0,
    };
    bencher.bench_local(|| {
        along_normal(
            &pose,
            &mounting,
            &black_box(beam).partials().vector_m,
            &normal,
        )
    });
}

/// What does fitting a plane to 100 000 points cost?
#[divan::bench]
fn fit_a_plane(bencher: Bencher) {
    let points: Vec<Vector3<f64>> = (0..100_000u32)
        .map(|k| {
            Vector3::new(
                1e-3 * f64::from(k % 7),
                f64::from(k % 400) * 0.02,
                f64::from(k / 400) * 0.02,
            )
        })
        .collect();
    bencher
        .counter(ItemsCount::new(points.len()))
        .bench_local(|| {
            let mut moments = PlaneMoments::default();
            points.iter().for_each(|p| moments.add(p));
            moments.fit()
        });
}

fn wall() -> boresight::target::Target {
    let scenario = Scenario::from_toml(DEMO).expect("the demo");
    boresight::target::Target::from_model(&scenario.target.model).expect("a wall")
}

/// What does building the faces' k-d tree cost?
#[divan::bench]
fn build_the_tree(bencher: Bencher) {
    let (target, origin) = (wall(), [Vector3::new(-6.0, 0.0, -0.6)]);
    bencher.bench_local(|| Patches::new(&target, Water::Below, 0.0, &origin));
}

/// And tying 10 000 points with it, outlines and rivals included?
#[divan::bench]
fn tie_points(bencher: Bencher) {
    let (target, origin) = (wall(), Vector3::new(-6.0, 0.0, -0.6));
    let patches = Patches::new(&target, Water::Below, 0.0, &[origin]);
    let gate = Gate {
        sigmas: 5.0,
        largest_sigma_m: 0.02,
        margin_m: 0.04,
    };
    let points: Vec<Vector3<f64>> = (0..10_000u32)
        .map(|k| {
            Vector3::new(
                0.001,
                f64::from(k % 100) * 0.08 - 4.0,
                -f64::from(k / 100) * 0.03 - 0.1,
            )
        })
        .collect();
    bencher
        .counter(ItemsCount::new(points.len()))
        .bench_local(|| {
            points
                .iter()
                .filter(|p| {
                    let round = |normal: &Vector3<f64>| Spread::round(0.01, normal);
                    let verdict = patches.assign(p, &(*p - origin), &gate, None, round);
                    matches!(verdict, Verdict::Tie(_))
                })
                .count()
        });
}

/// The six-parameter problem of fixed association that the Ceres peer solves: point-to-plane, nothing else unknown.
struct Fixed {
    rotation: BlockId,
    lever: BlockId,
    ties: Vec<(PoseSample, Vector3<f64>, Vector3<f64>)>,
}

impl Conditions for Fixed {
    fn len(&self) -> usize {
        self.ties.len()
    }

    fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
        let (pose, u, normal) = &self.ties[k];
        let mounting = Mounting {
            rotation: x.rotation(self.rotation),
            lever_arm_m: Vector3::from_column_slice(x.euclidean(self.lever)),
        };
        let partials = along_normal(pose, &mounting, u, normal);
        row.misclosure = normal.dot(&partials.point_m);
        row.variance = 1e-4;
        row.extend(x.offset(self.rotation), partials.rotation.as_slice());
        row.extend(x.offset(self.lever), partials.lever_arm.as_slice());
    }
}

/// What does an iteration of the six-parameter problem cost per sounding? (All iterations of a solve, 200 000 soundings.)
#[divan::bench(sample_count = 5)]
fn normal_equations_of_six_parameters(bencher: Bencher) {
    let mut x = ParameterSet::new();
    let metre = |name: &str| Component::new(name, Unit::Metre);
    let start = mounting();
    let rotation = x
        .push(Block::rotation(
            "angles",
            ["pitch", "roll", "yaw"],
            &start.rotation,
        ))
        .expect("block");
    let lever = vec![metre("lx"), metre("ly"), metre("lz")];
    let lever = x
        .push(Block::euclidean(
            "lever",
            lever,
            start.lever_arm_m.as_slice(),
        ))
        .expect("block");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let normals = [
        Vector3::new(-1.0, 0.0, 0.0),
        Vector3::new(-half, half, 0.0),
        Vector3::new(-half, -half, 0.0),
        Vector3::z(),
    ];
    let ties = (0..200_000u32)
        .map(|k| {
            let beam = Beam {
                range_m: 5.0 + f64::from(k % 13) * 0.3,
                across_rad: f64::from(k % 100) * 0.01,
                along_rad: 0.0,
            };
            let mut pose = pose();
            let normal = normals[k as usize % 4];
            let point = georeference(&pose, &start, &beam.vector_m());
            pose.position_m -= normal * normal.dot(&point);
            (pose, beam.vector_m(), normal)
        })
        .collect();
    let mut moved = x.clone();
    let nudged =
        Matrix3::from(nalgebra::Rotation3::new(Vector3::new(0.01, -0.01, 0.01))) * start.rotation;
    moved
        .block_mut(rotation)
        .value
        .copy_from_slice(nudged.as_slice());
    let problem = Fixed {
        rotation,
        lever,
        ties,
    };
    bencher
        .counter(ItemsCount::new(problem.ties.len()))
        .bench_local(|| {
            solve(
                &Problem::dense(vec![Source::new(&problem)]),
                Estimate::new(moved.clone()),
                &Options::default(),
            )
        });
}

fn survey() -> Simulated {
    simulate(&Scenario::from_toml(THIN).expect("a scenario"), 1).expect("a survey")
}

/// What does a whole calibration by both paths cost, in memory?
#[divan::bench(sample_count = 5)]
fn calibrate_by_both_paths(bencher: Bencher) {
    let survey = survey();
    let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &sequential,
        joint: &joint,
        seed: 1,
        extras: &[],
    };
    bencher.bench_local(|| calibrate(&input, &boresight::watch::Unwatched));
}
