//! Slow errors of the trajectory as Gauss-Markov states on knots, line by line, and one height of each line.

use super::scene::{DriftSigmas, InsNoise, Line};
use crate::math;
use crate::results::DriftSample;

/// What a state moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// East, metres.
    East,
    /// North, metres.
    North,
    /// Up, metres.
    Up,
    /// Turn about the body's x axis, radians.
    Pitch,
    /// Turn about the body's y axis, radians.
    Roll,
    /// Turn about the body's z axis, radians.
    Heading,
    /// One height of a line (tide, datum), metres.
    LineHeight,
}

/// The six that drift.
const DRIFTING: [Component; 6] = [
    Component::East,
    Component::North,
    Component::Up,
    Component::Pitch,
    Component::Roll,
    Component::Heading,
];

/// A component's drift over all lines: what it is, how large, how fast, and how its knots lie.
#[derive(Clone, Debug, PartialEq)]
struct Chain {
    component: Component,
    sigma: f64,
    /// Number of its first state.
    first: usize,
    /// Standard deviation at each knot, in the order of states.
    sigmas: Vec<f64>,
    correlation_s: f64,
    /// Of each line, in the order of the survey file; the states stand in the order of time.
    knots: Vec<Knots>,
}

impl Chain {
    /// The knots' times in the order of states: one line after the other as they were sailed.
    fn times_s(&self) -> impl Iterator<Item = f64> {
        let mut sailed = self.knots.clone();
        sailed.sort_by_key(|knots| knots.first);
        let of = |knots: Knots| (0..knots.count).map(move |k| knots.time_s(k));
        sailed.into_iter().flat_map(of)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knots {
    first: usize,
    start_s: f64,
    interval_s: f64,
    count: usize,
}

impl Knots {
    fn time_s(&self, k: usize) -> f64 {
        self.start_s + self.interval_s * k as f64
    }

    /// Knot before a time and the weight of the knot after it; held at the ends.
    fn place(&self, time_s: f64) -> (usize, f64) {
        let at = ((time_s - self.start_s) / self.interval_s).clamp(0.0, (self.count - 1) as f64);
        let before = (at as usize).min(self.count.saturating_sub(2));
        (before, at - before as f64)
    }
}

/// One state's share in an error at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// What the state moves.
    pub component: Component,
    /// Number of the state.
    pub state: usize,
    /// Weight of the state.
    pub weight: f64,
}

/// All states of a survey.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    chains: Vec<Chain>,
    heights: usize,
    /// Standard deviation of each line's height, metres.
    height_sigmas_m: Vec<f64>,
}

/// Knots of a slow component, seconds: what lies between them stays below a millimetre for an ordinary INS.
const SLOW_KNOTS_S: f64 = 12.0;
/// Knots of the height, seconds: its drift falls into the band of the waves, where pitch and yaw have their information. Straight lines
/// between knots of 2 s have half the drift's power at a period of 5 s, and the sigma of a pitch by motion alone is an eighth too small.
const HEIGHT_KNOTS_S: f64 = 1.0;
/// A stated sigma below this share of the component's own counts as this much: nothing is known without an error.
const LEAST_SIGMA: f64 = 1e-3;
/// Most states of one component; longer surveys get wider knots.
const MOST_KNOTS: usize = 200_000;

impl States {
    /// For these lines.
    #[must_use]
    pub fn new(lines: &[Line], ins: &InsNoise, drift: &DriftSigmas) -> Self {
        let (mut chains, mut next) = (vec![], 0);
        let sailed = as_sailed(lines);
        for (place, component) in DRIFTING.into_iter().enumerate() {
            let (sigma, correlation_s, wanted_s) = spec(component, ins);
            if sigma <= 0.0 {
                continue;
            }
            let mut chain = Chain {
                component,
                sigma,
                first: next,
                sigmas: vec![],
                correlation_s,
                knots: knots(lines, &sailed, widened(lines, wanted_s), &mut next),
            };
            let at = |time_s| drift.at(place, time_s).unwrap_or(sigma);
            let floor = LEAST_SIGMA * sigma;
            chain.sigmas = chain.times_s().map(|t| at(t).max(floor)).collect();
            chains.push(chain);
        }
        Self {
            chains,
            heights: next,
            height_sigmas_m: lines.iter().map(|l| l.height_sigma_m).collect(),
        }
    }

    /// Number of states.
    #[must_use]
    pub fn len(&self) -> usize {
        self.heights + self.height_sigmas_m.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// East, north, up (metres), turns about x, y, z (radians) on a line at a time.
    #[must_use]
    pub fn at(&self, line: usize, time_s: f64, states: &[f64]) -> [f64; 6] {
        let mut error = [0.0; 6];
        self.each_share(line, time_s, |share| {
            let place = match share.component {
                Component::East => 0,
                Component::North => 1,
                Component::Up | Component::LineHeight => 2,
                Component::Pitch => 3,
                Component::Roll => 4,
                Component::Heading => 5,
            };
            error[place] += share.weight * states[share.state];
        });
        error
    }

    /// Calls `take` with every state that acts on a line at a time.
    pub fn each_share(&self, line: usize, time_s: f64, mut take: impl FnMut(Share)) {
        for chain in &self.chains {
            let knots = &chain.knots[line];
            let (before, part) = knots.place(time_s);
            for (state, weight) in [(before, 1.0 - part), (before + 1, part)] {
                take(Share {
                    component: chain.component,
                    state: knots.first + state,
                    weight,
                });
            }
        }
        take(Share {
            component: Component::LineHeight,
            state: self.heights + line,
            weight: 1.0,
        });
    }

    /// The drift of every component that has one, a part for each line; times count from the first knot.
    #[must_use]
    pub fn drifts(&self, states: &[f64]) -> Vec<DriftSample> {
        let starts = self.chains.iter().flat_map(|c| &c.knots).map(|k| k.start_s);
        let begin_s = starts.fold(f64::INFINITY, f64::min);
        let of = |chain: &Chain| {
            let part = |knots: &Knots| {
                let at = |k| [knots.time_s(k) - begin_s, states[knots.first + k]];
                (0..knots.count).map(at).collect()
            };
            let (name, angle) = match chain.component {
                Component::East => ("east", false),
                Component::North => ("north", false),
                Component::Up | Component::LineHeight => ("up", false),
                Component::Pitch => ("pitch, bow up", true),
                Component::Roll => ("roll, starboard down", true),
                Component::Heading => ("heading, counter-clockwise", true),
            };
            let parts = chain.knots.iter().map(part).collect();
            DriftSample::new(name, angle, chain.sigma, parts)
        };
        self.chains.iter().map(of).collect()
    }

    /// Whether a state is the height of a line.
    #[must_use]
    pub fn is_height(&self, state: usize) -> bool {
        state >= self.heights
    }

    /// Number of the state that is a line's height.
    #[must_use]
    pub fn height_of(&self, line: usize) -> usize {
        self.heights + line
    }

    /// Calls `add(row, column, information)` with the lower triangle of the priors' information.
    ///
    /// A chain runs on from line to line as they were sailed: `x' / sigma' = phi x / sigma + w`, `var w = 1 - phi^2`, exact for any interval; the sigma may
    /// change from knot to knot.
    pub fn each_information(&self, mut add: impl FnMut(usize, usize, f64)) {
        for chain in &self.chains {
            let mut before: Option<(usize, f64, f64)> = None;
            for (k, (time_s, sigma)) in chain.times_s().zip(&chain.sigmas).enumerate() {
                let (state, sigma) = (chain.first + k, *sigma);
                if let Some((last, last_s, sigma_before)) = before {
                    let keep = math::exp(-(time_s - last_s).abs() / chain.correlation_s);
                    let fresh = (1.0 - keep * keep).max(1e-12);
                    let of = |a: f64, b: f64| 1.0 / (a * b * fresh);
                    add(state, state, of(sigma, sigma));
                    add(last, last, keep * keep * of(sigma_before, sigma_before));
                    add(state, last, -keep * of(sigma, sigma_before));
                } else {
                    add(state, state, 1.0 / (sigma * sigma));
                }
                before = Some((state, time_s, sigma));
            }
        }
        for (line, sigma_m) in self.height_sigmas_m.iter().enumerate() {
            add(self.heights + line, self.heights + line, sigma_m.powi(-2));
        }
    }
}

/// Standard deviation, correlation time and wanted knot interval of a component.
fn spec(component: Component, ins: &InsNoise) -> (f64, f64, f64) {
    match component {
        Component::East | Component::North => (
            ins.position_drift_m,
            ins.position_correlation_s,
            SLOW_KNOTS_S,
        ),
        Component::Up | Component::LineHeight => (
            ins.height_drift_m,
            ins.position_correlation_s,
            HEIGHT_KNOTS_S,
        ),
        Component::Pitch | Component::Roll => (
            ins.roll_pitch_drift_rad,
            ins.roll_pitch_correlation_s,
            SLOW_KNOTS_S,
        ),
        Component::Heading => (
            ins.heading_drift_rad,
            ins.heading_correlation_s,
            SLOW_KNOTS_S,
        ),
    }
}

/// Numbers of the lines in the order in which they were sailed.
fn as_sailed(lines: &[Line]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..lines.len()).collect();
    order.sort_by(|a, b| lines[*a].start_s.total_cmp(&lines[*b].start_s));
    order
}

/// The knots of each line, their states numbered from `next` on as the lines were sailed.
fn knots(lines: &[Line], sailed: &[usize], interval_s: f64, next: &mut usize) -> Vec<Knots> {
    let mut knots: Vec<Knots> = lines.iter().map(|line| over(line, interval_s)).collect();
    for line in sailed {
        knots[*line].first = *next;
        *next += knots[*line].count;
    }
    knots
}

/// Knots over a line, not numbered yet.
fn over(line: &Line, interval_s: f64) -> Knots {
    let span_s = (line.end_s - line.start_s).max(interval_s);
    let count = (span_s / interval_s).ceil() as usize + 1;
    Knots {
        first: 0,
        start_s: line.start_s,
        interval_s: span_s / (count - 1) as f64,
        count,
    }
}

/// The interval, widened where the survey is so long that there would be too many knots.
fn widened(lines: &[Line], wanted_s: f64) -> f64 {
    let span_s: f64 = lines.iter().map(|l| (l.end_s - l.start_s).max(0.0)).sum();
    wanted_s.max(span_s / MOST_KNOTS as f64)
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    /// Roll and pitch that drift, nothing else.
    const INS: InsNoise = InsNoise {
        position_m: 0.01,
        position_drift_m: 0.0,
        height_drift_m: 0.0,
        position_correlation_s: 100.0,
        roll_pitch_rad: 1e-4,
        roll_pitch_drift_rad: 2e-4,
        roll_pitch_correlation_s: 60.0,
        heading_rad: 1e-4,
        heading_drift_rad: 0.0,
        heading_correlation_s: 100.0,
    };

    fn information(states: &States) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(states.len(), states.len());
        states.each_information(|row, column, information| {
            all[(row, column)] += information;
            if row != column {
                all[(column, row)] += information;
            }
        });
        all
    }

    /// Of the turn about x, `a` at 0 s and `b` at 200 s.
    fn drift(a: f64, b: f64) -> DriftSigmas {
        let mut components: [Vec<f64>; 6] = Default::default();
        components[3] = vec![a, b];
        DriftSigmas {
            time_s: vec![0.0, 200.0],
            components,
        }
    }

    /// Two lines, a gap between them: the covariance of any two knots is the product of their own sigmas and the correlation.
    #[test]
    fn sigmas_over_time_make_the_drift_s_covariance() {
        let lines = [Line::between(0.0, 60.0), Line::between(130.0, 170.0)];
        let states = States::new(&lines, &INS, &drift(1e-4, 5e-4));
        let chain = &states.chains[0];
        assert_eq!(chain.component, Component::Pitch);
        let times: Vec<f64> = chain.times_s().collect();
        let covariance = information(&states).try_inverse().expect("regular");
        for (i, a) in times.iter().enumerate() {
            for (j, b) in times.iter().enumerate() {
                let sigma = |t: f64| 1e-4 + 2e-6 * t;
                let due = sigma(*a) * sigma(*b) * math::exp(-(a - b).abs() / 60.0);
                let off = (covariance[(i, j)] - due).abs();
                assert!(off < 1e-9 * sigma(*a) * sigma(*b), "{i} {j}: {off}");
            }
        }
        // the other components have their own all along
        let roll = covariance[(times.len(), times.len())];
        assert!((roll - 4e-8).abs() < 1e-16, "{roll}");
    }

    /// The order of the lines in the survey file says nothing of when they were sailed.
    #[test]
    fn a_chain_runs_on_as_the_lines_were_sailed() {
        let sailed = [
            Line::between(0.0, 60.0),
            Line::between(90.0, 150.0),
            Line::between(170.0, 230.0),
        ];
        let listed = [2, 0, 1].map(|k| sailed[k].clone());
        let [sailed, listed] = [&sailed, &listed].map(|lines| {
            let states = States::new(lines, &INS, &DriftSigmas::default());
            let covariance = information(&states).try_inverse().expect("regular");
            (states, covariance)
        });
        let roll = |(states, covariance): &(States, DMatrix<f64>), lines: [usize; 2]| {
            let of = |line: usize| states.chains[1].knots[line].first;
            covariance[(of(lines[0]), of(lines[1]))]
        };
        for [a, b] in [[0, 1], [0, 2], [1, 2]] {
            let due = 4e-8 * math::exp(-[90.0, 170.0, 80.0][a + b - 1] / 60.0);
            assert!((roll(&sailed, [a, b]) - due).abs() < 1e-16);
            assert!((roll(&listed, [(a + 1) % 3, (b + 1) % 3]) - due).abs() < 1e-16);
        }
    }

    #[test]
    fn a_constant_sigma_over_time_is_the_stated_one() {
        let lines = [Line::between(0.0, 60.0), Line::between(130.0, 170.0)];
        let stated = States::new(&lines, &INS, &DriftSigmas::default());
        let constant = States::new(&lines, &INS, &drift(2e-4, 2e-4));
        assert_eq!(information(&stated), information(&constant));
    }

    #[test]
    fn a_sigma_of_nothing_leaves_the_equations_regular() {
        let states = States::new(&[Line::between(0.0, 60.0)], &INS, &drift(0.0, 0.0));
        assert!(information(&states).iter().all(|i| i.is_finite()));
    }
}
