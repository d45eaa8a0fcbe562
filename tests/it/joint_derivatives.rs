//! The joint conditions' analytic derivatives against central differences of their misclosures, over every optional unknown.
//!
//! The survey is simulated without any error, so that the residuals vanish and the adjusted observations are the observations: there
//! the derivatives at the adjusted observations are those of the misclosure itself.

use boresight::adjust::{
    Block, BlockId, ChainModel, ChainState, Component, Conditions, DerivativeFault, Estimate,
    ParameterSet, Process, ProcessKind, Row, Unit, check_derivatives,
};
use boresight::calibrate::cloud::SensorModel;
use boresight::matching::{Patches, Water};
use boresight::observe::{Acts, Extra, Mounting};
use boresight::procedures::pool::Scene;
use boresight::procedures::pool::conditions::{
    FacePlane, MountingBlocks, ReturnConditions, SoundingConditions, TrajectoryErrors,
};
use boresight::procedures::pool::rows::Rows;
use boresight::procedures::pool::ties::{
    Among, Association, PlacedBy, TieSet, tie_returns, tie_soundings,
};
use boresight::simulate::motion::Wave;
use boresight::simulate::scenario::{Angles, Arrays};
use boresight::simulate::{Scenario, Simulated, Source, Sources, simulate};
use nalgebra::{Matrix3, Vector3};

/// A late sounder with short ranges on a slowly turning, rolling boat: its velocity and its rates hardly change within the half second over which they are taken.
fn survey(arrays: Option<Arrays>) -> Simulated {
    let text = include_str!("../../models/scenarios/three-pass-thin.toml");
    let mut scenario = Scenario::from_toml(text).expect("a scenario");
    scenario.sources = Sources::none()
        .with(Source::Latency, 1.0)
        .with(Source::SoundSpeed, 1.0);
    scenario.multibeam.arrays = arrays;
    if arrays.is_some() {
        scenario.sound_speed = Some(boresight::simulate::scenario::Water {
            speed_m_s: Some(1480.0),
            profile: vec![],
            gradient_error_1_s: 0.0,
            gradient_sigma_1_s: 0.0,
        });
    }
    scenario.truth.latency_s = 0.005;
    scenario.truth.range_scale = 0.001;
    scenario.target.prior_offset_m = [0.0; 3];
    scenario.target.prior_turn_deg = 0.0;
    let slow = |amplitude, phase_deg| {
        vec![Wave {
            amplitude,
            period_s: 60.0,
            phase_deg,
        }]
    };
    let motion = &mut scenario.motion;
    motion.sway.wave = slow(0.5, 10.0);
    motion.height.wave = slow(0.2, 80.0);
    motion.roll.wave = slow(5.0, 40.0);
    motion.pitch.wave = slow(4.0, 120.0);
    motion.heading.wave = slow(6.0, 200.0);
    simulate(&scenario, 1).expect("a survey")
}

fn lengths<const N: usize>(name: &str, value: &[f64; N], unit: Unit) -> Block {
    let components = (0..N).map(|i| Component::new(format!("{name} {i}"), unit));
    Block::euclidean(name, components.collect(), value)
}

/// Unknowns of the caller's own, of every kind.
const OWN: [(&str, Acts); 4] = [
    ("higher", Acts::Up),
    ("longer", Acts::Range),
    ("wider", Acts::Across),
    ("forward", Acts::Along),
];

/// They act on two soundings of three, by more and less.
fn own(soundings: usize) -> Vec<Extra> {
    let by = |k: usize| [f64::NAN, 0.7, -1.3][k % 3];
    let one = |(name, acts): (&str, Acts)| Extra {
        name: name.to_owned(),
        unit: "1".to_owned(),
        acts,
        derivative: (0..soundings).map(by).collect(),
        prior_sigma: None,
    };
    OWN.map(one).to_vec()
}

/// Every block that the joint path can have, at the truth.
struct Unknowns {
    x: ParameterSet,
    sonar: MountingBlocks,
    scanner: MountingBlocks,
    latency: BlockId,
    range_scale: BlockId,
    extras: Vec<BlockId>,
    planes: Vec<Option<FacePlane>>,
}

fn mounting(x: &mut ParameterSet, name: &str, at: &Mounting) -> MountingBlocks {
    let turn = Block::rotation(name, ["pitch", "roll", "yaw"], &at.rotation);
    let arm = lengths(name, &at.lever_arm_m.into(), Unit::Metre);
    MountingBlocks {
        rotation: x.push(turn).expect("a rotation"),
        lever_arm: x.push(arm).expect("a lever arm"),
    }
}

fn unknowns(s: &Simulated) -> (Unknowns, Mounting) {
    let true_sonar = Mounting {
        rotation: Matrix3::from_fn(|i, j| s.truth.rotation_matrix[i][j]),
        lever_arm_m: Vector3::from(s.truth.lever_arm_m),
    };
    let mut x = ParameterSet::new();
    let sonar = mounting(&mut x, "sonar", &true_sonar);
    let scanner = mounting(&mut x, "scanner", &s.campaign.scanner);
    let mut scalar = |name, value, unit| x.push(lengths(name, &[value], unit)).expect("a scalar");
    let latency = scalar("latency", s.truth.latency_s, Unit::Second);
    let range_scale = scalar("range scale", s.truth.range_scale, Unit::One);
    let extras = OWN.map(|(name, _)| scalar(name, 0.0, Unit::One)).to_vec();
    let groups: Vec<(BlockId, BlockId)> = s
        .target
        .groups
        .iter()
        .map(|group| {
            let normal = Block::unit_normal(format!("normal of {}", group.name), &group.normal);
            let distance = lengths(&group.name, &[0.0], Unit::Metre);
            (
                x.push(normal).expect("a normal"),
                x.push(distance).expect("a distance"),
            )
        })
        .collect();
    let offsets: Vec<BlockId> = s
        .target
        .offsets
        .iter()
        .map(|offset| {
            x.push(lengths(&offset.name, &[offset.value_m], Unit::Metre))
                .expect("an offset")
        })
        .collect();
    let planes = s
        .target
        .faces
        .iter()
        .map(|face| {
            let (normal, distance) = groups[face.group];
            Some(FacePlane {
                normal,
                distance,
                offset: Some(offsets[face.offset]),
                design_m: f64::NAN,
            })
        })
        .collect();
    let all = Unknowns {
        x,
        sonar,
        scanner,
        latency,
        range_scale,
        extras,
        planes,
    };
    (all, true_sonar)
}

/// White noise of every visible quantity, one epoch per record.
fn chain(scene: &Scene) -> ChainModel {
    let white = |component| Process {
        component,
        sigma: 0.01,
        kind: ProcessKind::White,
    };
    ChainModel::new(
        scene.trajectory.times_s().to_vec(),
        (0..6).map(white).collect(),
    )
    .expect("a chain")
}

/// Some conditions of every face, spread over the survey.
fn spread(ties: &TieSet, faces: usize) -> Vec<usize> {
    let of_face = |face: usize| {
        let of_face = ties.iter().enumerate();
        let of_face = of_face.filter(|(_, tie)| usize::from(tie.face) == face);
        let all: Vec<usize> = of_face.map(|(k, _)| k).collect();
        let stride = all.len().div_ceil(12).max(1);
        all.into_iter().step_by(stride).collect::<Vec<_>>()
    };
    (0..faces).flat_map(of_face).collect()
}

/// The derivatives of a trajectory interpolated between records and of a velocity taken over half a second agree to a few parts in ten thousand.
const TOLERANCE: f64 = 5e-4;

fn faults(
    conditions: &dyn Conditions,
    which: &[usize],
    x: &ParameterSet,
    model: &ChainModel,
) -> Vec<DerivativeFault> {
    let at = Estimate {
        parameters: x.clone(),
        chain: Some(ChainState::zero(model)),
    };
    check_derivatives(conditions, which, &at, Some(model), 1e-5, TOLERANCE)
}

fn named(x: &ParameterSet, faults: &[DerivativeFault]) -> Vec<String> {
    let name = |column: usize| {
        x.components().nth(column).map_or_else(
            || format!("visible {}", column - x.columns()),
            |c| c.name.clone(),
        )
    };
    faults
        .iter()
        .take(10)
        .map(|f| {
            format!(
                "condition {} by {}: {} given, {} by differences",
                f.condition,
                name(f.column),
                f.given,
                f.difference
            )
        })
        .collect()
}

#[test]
fn derivatives_of_the_soundings() {
    let worst_m = of_soundings(None);
    assert!(worst_m < 5e-6, "{worst_m}");
}

/// Sent at one moment and heard at another, by arrays 0.27 m apart and turned by degrees, in tilted sectors. The simulator finds the way
/// of the sound step by step; what its stamps round (half a millisecond at 0.8 m/s) is left of the misclosures at the truth.
#[test]
fn derivatives_of_the_soundings_of_two_arrays() {
    let worst_m = of_soundings(Some(Arrays {
        receiver_mounting_deg: Some(Angles {
            roll: -43.5,
            pitch: -0.4,
            heading: 0.6,
        }),
        receiver_offset_m: [0.1, -0.25, 0.02],
        sectors: 3,
        sector_tilt_deg: 3.0,
        sector_delay_s: 0.004,
    }));
    assert!(worst_m < 4e-4, "{worst_m}");
}

/// Checks the derivatives; the largest misclosure at the truth, metres.
fn of_soundings(arrays: Option<Arrays>) -> f64 {
    let s = survey(arrays);
    let own = own(s.campaign.soundings.len());
    let mut scene = Scene::prepare(&s.campaign, &s.target, &s.prior).expect("a scene");
    scene.extras = &own;
    let (all, true_sonar) = unknowns(&s);
    let patches = Patches::new(
        &s.target,
        Water::Below,
        s.campaign.water_level_m,
        &scene.origins(&true_sonar),
    );
    let rows = Rows::chosen(s.campaign.soundings.len(), |_| true);
    let truth = PlacedBy {
        sensor: SensorModel {
            mounting: true_sonar,
            latency_s: s.truth.latency_s,
            range_scale: s.truth.range_scale,
        },
        extras: &[0.0; OWN.len()],
    };
    let gate = Association::before(5.0);
    let ties = tie_soundings(&scene, &patches, &rows, &truth, &gate);
    let model = chain(&scene);
    let epochs: Vec<u32> = (0..scene.trajectory.len() as u32).collect();
    let conditions = SoundingConditions {
        cells: None,
        scene: &scene,
        ties: &ties,
        planes: &all.planes,
        mounting: all.sonar,
        latency: Some(all.latency),
        range_scale: Some(all.range_scale),
        extras: &all.extras,
        latency_at_start_s: s.truth.latency_s,
        trajectory: TrajectoryErrors::States(&epochs),
        group: 0,
    };
    let which = spread(&ties, s.target.faces.len());
    assert!(which.len() > 100, "{} conditions", which.len());
    let found = faults(&conditions, &which, &all.x, &model);
    assert!(
        found.is_empty(),
        "{} of {} conditions: {:#?}",
        found.len(),
        which.len(),
        named(&all.x, &found)
    );
    let mut row = Row::default();
    let misclosure_m = |k: &usize| {
        conditions.linearise(*k, &all.x, Some(&ChainState::zero(&model)), &mut row);
        row.misclosure.abs()
    };
    which.iter().map(misclosure_m).fold(0.0, f64::max)
}

#[test]
fn derivatives_of_the_returns() {
    let s = survey(None);
    let scene = Scene::prepare(&s.campaign, &s.target, &s.prior).expect("a scene");
    let (all, _) = unknowns(&s);
    let patches = Patches::new(
        &s.target,
        Water::Above,
        s.campaign.water_level_m,
        &scene.origins(&s.campaign.scanner),
    );
    let ties = tie_returns(&scene, &patches, Among::All, &Association::before(5.0));
    let model = chain(&scene);
    let epochs: Vec<u32> = (0..scene.trajectory.len() as u32).collect();
    let conditions = ReturnConditions {
        cells: None,
        scene: &scene,
        ties: &ties,
        planes: &all.planes,
        scanner: Some(all.scanner),
        trajectory: TrajectoryErrors::States(&epochs),
        group: 1,
    };
    let which = spread(&ties, s.target.faces.len());
    assert!(which.len() > 50, "{} conditions", which.len());
    let found = faults(&conditions, &which, &all.x, &model);
    assert!(
        found.is_empty(),
        "{} of {} conditions: {:#?}",
        found.len(),
        which.len(),
        named(&all.x, &found)
    );
}
