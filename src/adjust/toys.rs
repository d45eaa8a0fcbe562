//! A small linear problem over a chain, and the same problem with the states as ordinary parameters.

use crate::math;
use crate::stats::normal::draw;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// Parameters of a toy.
pub(super) const GLOBALS: usize = 4;

/// One linear condition `a x + v y - l = 0`.
pub(super) struct ToyRow {
    pub a: [f64; GLOBALS],
    pub v: [f64; VISIBLE],
    pub weight0: f64,
    pub interval: u32,
    pub observed: f64,
    pub variance: f64,
}

/// Linear conditions over a chain.
pub(super) struct Toy {
    pub model: ChainModel,
    pub rows: Vec<ToyRow>,
    /// Parameters that the observations were made with.
    pub truth: [f64; GLOBALS],
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    draw(random)
}

/// White and Gauss-Markov noise on all three positions, white noise on all attitudes.
fn processes() -> Vec<Process> {
    let white = |component| Process {
        component,
        sigma: 0.3,
        kind: ProcessKind::White,
    };
    let drift = |component| Process {
        component,
        sigma: 0.5,
        kind: ProcessKind::GaussMarkov { tau_s: 20.0 },
    };
    (0..6).map(white).chain((0..3).map(drift)).collect()
}

impl Toy {
    /// A survey of `epochs` epochs with `per_interval` conditions in each interval, drawn from its own model.
    pub(super) fn new(seed: u64, epochs: usize, per_interval: usize) -> Self {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let times = (0..epochs)
            .map(|k| k as f64 * 0.5 + 0.1 * math::sin(k as f64))
            .collect();
        let model = ChainModel::new(times, processes()).unwrap();
        let visible = drawn_visible(&model, random);
        let truth = std::array::from_fn(|_| normal(random));
        let mut rows = Vec::new();
        for interval in 0..model.intervals() {
            for _ in 0..per_interval {
                rows.push(drawn_row(interval, &truth, &visible, random));
            }
        }
        Toy { model, rows, truth }
    }

    pub(super) fn parameters(&self) -> ParameterSet {
        let names =
            ["roll", "yaw", "along", "across"].map(|name| Component::new(name, Unit::Metre));
        let mut set = ParameterSet::new();
        set.push(Block::euclidean("globals", names.to_vec(), &[0.0; GLOBALS]).sought())
            .unwrap();
        set
    }

    pub(super) fn problem(&self) -> Problem<'_> {
        Problem::with_chain(vec![Source::new(self)], &self.model)
    }
}

fn drawn_visible(model: &ChainModel, random: &mut ChaCha8Rng) -> Vec<[f64; VISIBLE]> {
    let mut state: Vec<f64> = model
        .processes()
        .iter()
        .map(|p| p.sigma * normal(random))
        .collect();
    let mut visible = Vec::new();
    for epoch in 0..model.epochs() {
        let mut sum = [0.0; VISIBLE];
        for (process, state) in model.processes().iter().zip(&mut state) {
            if epoch > 0 {
                let innovation = model.innovation(process, epoch - 1).sqrt() * normal(random);
                *state = model.transition(process, epoch - 1) * *state + innovation;
            }
            sum[process.component] += *state;
        }
        visible.push(sum);
    }
    visible
}

fn drawn_row(
    interval: usize,
    truth: &[f64; GLOBALS],
    visible: &[[f64; VISIBLE]],
    random: &mut ChaCha8Rng,
) -> ToyRow {
    let a: [f64; GLOBALS] = std::array::from_fn(|_| normal(random));
    let v: [f64; VISIBLE] = std::array::from_fn(|_| normal(random));
    let weight0: f64 = random.random();
    let variance = 0.01 + 0.05 * random.random::<f64>();
    let mut observed = variance.sqrt() * normal(random);
    observed += a.iter().zip(truth).map(|(a, x)| a * x).sum::<f64>();
    for i in 0..VISIBLE {
        observed +=
            v[i] * (weight0 * visible[interval][i] + (1.0 - weight0) * visible[interval + 1][i]);
    }
    ToyRow {
        a,
        v,
        weight0,
        interval: interval as u32,
        observed,
        variance,
    }
}

impl Conditions for Toy {
    fn len(&self) -> usize {
        self.rows.len()
    }

    fn interval(&self, k: usize) -> Option<u32> {
        Some(self.rows[k].interval)
    }

    fn group(&self, k: usize) -> u16 {
        (k % 2) as u16
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        let toy = &self.rows[k];
        let (weight0, weight1) = (toy.weight0, 1.0 - toy.weight0);
        let y = chain.unwrap().between(toy.interval, weight0, weight1);
        let predicted: f64 = toy
            .a
            .iter()
            .zip(&x.blocks()[0].value)
            .map(|(a, x)| a * x)
            .sum();
        row.misclosure =
            predicted + toy.v.iter().zip(y).map(|(v, y)| v * y).sum::<f64>() - toy.observed;
        row.variance = toy.variance;
        row.extend(0, &toy.a);
        row.chain = Some(ChainRow {
            interval: toy.interval,
            weight0,
            weight1,
            visible: toy.v,
        });
    }
}

/// The toy without a chain: its states are parameters, its processes conditions.
pub(super) struct DenseToy<'a>(pub &'a Toy);

impl DenseToy<'_> {
    pub(super) fn parameters(&self) -> ParameterSet {
        let mut set = self.0.parameters();
        let size = self.0.model.state_size();
        for _ in 0..self.0.model.epochs() {
            let components = vec![Component::new("state", Unit::Metre); size];
            set.push(Block::euclidean("epoch", components, &vec![0.0; size]))
                .unwrap();
        }
        set
    }

    fn observation(&self, k: usize, x: &ParameterSet, row: &mut Row) {
        let toy = &self.0.rows[k];
        row.misclosure = -toy.observed;
        row.variance = toy.variance;
        row.extend(0, &toy.a);
        for (epoch, weight) in [
            (toy.interval, toy.weight0),
            (toy.interval + 1, 1.0 - toy.weight0),
        ] {
            for (i, process) in self.0.model.processes().iter().enumerate() {
                row.push(
                    self.column(epoch as usize, i),
                    weight * toy.v[process.component],
                );
            }
        }
        self.evaluate(x, row);
    }

    /// Innovation of a process at an epoch.
    fn innovation(&self, k: usize, x: &ParameterSet, row: &mut Row) {
        let model = &self.0.model;
        let (epoch, i) = (k / model.state_size(), k % model.state_size());
        let process = &model.processes()[i];
        row.misclosure = 0.0;
        row.variance = process.sigma * process.sigma;
        row.push(self.column(epoch, i), 1.0);
        if epoch > 0 {
            row.variance = model.innovation(process, epoch - 1);
            row.push(
                self.column(epoch - 1, i),
                -model.transition(process, epoch - 1),
            );
        }
        self.evaluate(x, row);
    }

    fn column(&self, epoch: usize, i: usize) -> usize {
        GLOBALS + epoch * self.0.model.state_size() + i
    }

    fn evaluate(&self, x: &ParameterSet, row: &mut Row) {
        let all: Vec<f64> = x
            .blocks()
            .iter()
            .flat_map(|block| block.value.clone())
            .collect();
        let terms = row
            .columns()
            .iter()
            .zip(row.values())
            .map(|(c, a)| a * all[usize::from(*c)]);
        row.misclosure += terms.sum::<f64>();
    }
}

impl Conditions for DenseToy<'_> {
    fn len(&self) -> usize {
        self.0.rows.len() + self.0.model.epochs() * self.0.model.state_size()
    }

    fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
        match k.checked_sub(self.0.rows.len()) {
            None => self.observation(k, x, row),
            Some(k) => self.innovation(k, x, row),
        }
    }
}
