//! The six-parameter problem of fixed association (point-to-plane, nothing else unknown), to be timed beside another solver.
//!
//! `cargo run --release --example six_parameters -- make FILE [N]` writes a problem of N soundings;
//! `cargo run --release --example six_parameters -- solve FILE` solves it in one thread and prints the time per sounding and pass.
//!
//! FILE: little-endian doubles: nominal rotation (9, row-major), nominal lever arm (3), then per sounding `n(3) d p(3)
//! R_b^t(9, row-major) u(3) sigma`: condition `n.(p + R_b^t (Exp(w) R0 u + l)) - d`, divided by sigma.

#![allow(
    clippy::disallowed_methods,
    reason = "no result of the program hangs on these"
)]

use std::time::Instant;

use boresight::adjust::{
    Block, BlockId, ChainState, Component, Conditions, Estimate, Options, ParameterSet, Problem,
    Row, Source, Unit, solve,
};
use boresight::georef::{Beam, along_normal, georeference};
use boresight::observe::{Mounting, PoseSample};
use nalgebra::{Matrix3, Vector3};

/// Doubles per sounding.
const WIDTH: usize = 20;

struct Fixed {
    rotation: BlockId,
    lever: BlockId,
    ties: Vec<[f64; WIDTH]>,
}

impl Fixed {
    fn fill(
        &self,
        tie: &[f64; WIDTH],
        mounting: &Mounting,
        columns: (usize, usize),
        row: &mut Row,
    ) {
        let pose = PoseSample {
            position_m: Vector3::from_column_slice(&tie[4..7]),
            rotation: Matrix3::from_row_slice(&tie[7..16]),
            record: 0,
            weight_before: 1.0,
        };
        let (normal, u) = (
            Vector3::from_column_slice(&tie[0..3]),
            Vector3::from_column_slice(&tie[16..19]),
        );
        let partials = along_normal(&pose, mounting, &u, &normal);
        row.misclosure = normal.dot(&partials.point_m) - tie[3];
        row.variance = tie[19] * tie[19];
        row.extend(columns.0, partials.rotation.as_slice());
        row.extend(columns.1, partials.lever_arm.as_slice());
    }
}

impl Conditions for Fixed {
    fn len(&self) -> usize {
        self.ties.len()
    }

    fn linearise(&self, k: usize, x: &ParameterSet, c: Option<&ChainState>, row: &mut Row) {
        self.linearise_range(k..k + 1, x, c, std::slice::from_mut(row));
    }

    fn linearise_range(
        &self,
        range: std::ops::Range<usize>,
        x: &ParameterSet,
        _: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        let mounting = Mounting {
            rotation: x.rotation(self.rotation),
            lever_arm_m: Vector3::from_column_slice(x.euclidean(self.lever)),
        };
        let columns = (x.offset(self.rotation), x.offset(self.lever));
        for (tie, row) in self.ties[range].iter().zip(rows) {
            row.clear();
            self.fill(tie, &mounting, columns, row);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["make", file] => make(file, 1_000_000),
        ["make", file, count] => make(file, count.parse()?),
        ["solve", file] => solve_file(file),
        _ => Err("usage: six_parameters make FILE [N] | solve FILE".into()),
    }
}

/// Four planes, poses and beams of a pass, noise of a centimetre; the nominal mounting is off by half a degree and 5 cm.
fn make(file: &str, count: u32) -> Result<(), Box<dyn std::error::Error>> {
    let nominal = Mounting::from_angles(-0.8, 0.01, 0.02, Vector3::new(0.5, -0.2, -1.6));
    let truth = nominal.corrected(
        &Vector3::new(0.008, -0.006, 0.01),
        &Vector3::new(0.05, -0.03, 0.02),
    );
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let normals = [
        Vector3::new(-1.0, 0.0, 0.0),
        Vector3::new(-half, half, 0.0),
        Vector3::new(-half, -half, 0.0),
        Vector3::z(),
    ];
    let mut values: Vec<f64> = nominal.rotation.transpose().as_slice().to_vec();
    values.extend(nominal.lever_arm_m.as_slice());
    for k in 0..count {
        let beam = Beam {
            range_m: 5.0 + f64::from(k % 13) * 0.3,
            across_rad: f64::from(k % 100) * 0.01,
            along_rad: 0.0,
        };
        let wave = f64::from(k) * 1e-3;
        let pose = PoseSample {
            position_m: Vector3::new(-6.0, wave.sin(), 1.0),
            rotation: boresight::geometry::rotation::from_attitude(
                0.03 * wave.sin(),
                0.02 * wave.cos(),
                0.05 * (0.3 * wave).sin(),
            ),
            record: 0,
            weight_before: 1.0,
        };
        let normal = normals[k as usize % 4];
        let u = beam.vector_m();
        // an even spread of errors, one centimetre as standard deviation
        let error = 0.01 * 12f64.sqrt() * ((f64::from(k) * 0.618_033_988_749_894_9).fract() - 0.5);
        let offset = normal.dot(&georeference(&pose, &truth, &u)) + error;
        values.extend(normal.as_slice());
        values.push(offset);
        values.extend(pose.position_m.as_slice());
        values.extend(pose.rotation.transpose().as_slice());
        values.extend(u.as_slice());
        values.push(0.01);
    }
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    Ok(std::fs::write(file, bytes)?)
}

fn solve_file(file: &str) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = std::fs::read(file)?;
    let values: Vec<f64> = bytes
        .as_chunks::<8>()
        .0
        .iter()
        .map(|b| f64::from_le_bytes(*b))
        .collect();
    let (head, rest) = values.split_at(12);
    let mut x = ParameterSet::new();
    let nominal = Matrix3::from_row_slice(&head[..9]);
    let rotation = x.push(Block::rotation(
        "angles",
        ["pitch", "roll", "yaw"],
        &nominal,
    ))?;
    let metres = ["lx", "ly", "lz"].map(|n| Component::new(n, Unit::Metre));
    let lever = x.push(Block::euclidean("lever arm", metres.to_vec(), &head[9..]))?;
    let ties = rest.as_chunks::<WIDTH>().0.to_vec();
    let problem = Fixed {
        rotation,
        lever,
        ties,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let begin = Instant::now();
    let solution = pool.install(|| {
        let problem = Problem::dense(vec![Source::new(&problem)]);
        solve(&problem, Estimate::new(x), &Options::default())
    })?;
    let seconds = begin.elapsed().as_secs_f64();
    let passes = solution.iterations.len() + 1;
    let mounting = Mounting {
        rotation: solution.estimate.parameters.rotation(rotation),
        lever_arm_m: Vector3::from_column_slice(solution.estimate.parameters.euclidean(lever)),
    };
    let turn = boresight::geometry::rotation::log(&(mounting.rotation * nominal.transpose()));
    println!(
        "n={} solve_s={seconds:.3} passes={passes} ns_per_sounding_and_pass={:.1} cost={:.9} x={:.9} {:.9} {:.9} l={:.6} {:.6} {:.6}",
        problem.ties.len(),
        seconds * 1e9 / (problem.ties.len() * passes) as f64,
        solution.cost,
        turn.x,
        turn.y,
        turn.z,
        mounting.lever_arm_m.x,
        mounting.lever_arm_m.y,
        mounting.lever_arm_m.z,
    );
    Ok(())
}
