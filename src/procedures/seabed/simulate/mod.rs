//! Simulated seabed surveys: straight rays cast onto a known seabed from a boat in waves.
//!
//! It does not use the georeferencing of the calibration, so that the two check each other.

mod arrays;
pub mod bed;

use nalgebra::{Matrix3, Vector2, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::scene::Line;
use super::survey::SeabedScenario;
use super::survey::scenario::{Course, FurtherHead, START_S};
use crate::geometry::rotation;
use crate::math;
use crate::observe::ArrayMountings;
use crate::simulate::sources::GaussMarkov;
use crate::stats::normal::draw;
use crate::stats::stream;
use bed::Seabed;

/// One record of the trajectory as the INS gives it, in the local frame.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Time, seconds.
    pub time_s: f64,
    /// Position, metres.
    pub position_m: Vector3<f64>,
    /// Body into local frame.
    pub rotation: Matrix3<f64>,
}

/// One simulated sounding.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Stamp, seconds.
    pub time_s: f64,
    /// Ping.
    pub ping: u32,
    /// Beam.
    pub beam: u32,
    /// Index of the head.
    pub head: u8,
    /// Across angle as measured, radians; with two arrays the angle against the receive array.
    pub across_rad: f64,
    /// Tilt of the transmitted cone, radians.
    pub tilt_rad: f64,
    /// From the ping to this beam's transmission, seconds.
    pub delay_s: f64,
    /// Transmit sector.
    pub sector: u32,
    /// Two-way travel time as measured, seconds.
    pub two_way_s: f64,
    /// Whether it is a gross error.
    pub gross: bool,
}

/// What the survey must find.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeabedTruth {
    /// True mounting, sonar into body.
    pub rotation_matrix: [[f64; 3]; 3],
    /// True lever arm, metres.
    pub lever_arm_m: [f64; 3],
    /// Stamps are late by this, seconds.
    pub latency_s: f64,
    /// True range over measured range, minus 1.
    pub range_scale: f64,
    /// Further heads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_heads: Vec<TrueHead>,
}

/// A further head as it really is mounted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueHead {
    /// True mounting, sonar into body.
    pub rotation_matrix: [[f64; 3]; 3],
    /// True lever arm, metres.
    pub lever_arm_m: [f64; 3],
}

impl SeabedTruth {
    /// True mounting of each head, sonar into body.
    #[must_use]
    pub fn rotations(&self) -> Vec<Matrix3<f64>> {
        let further = self.further_heads.iter().map(|head| &head.rotation_matrix);
        let all = std::iter::once(&self.rotation_matrix).chain(further);
        all.map(|rows| Matrix3::from_fn(|i, j| rows[i][j]))
            .collect()
    }
}

/// A simulated survey.
pub struct Simulated {
    /// Trajectory.
    pub records: Vec<Record>,
    /// Soundings.
    pub shots: Vec<Shot>,
    /// Lines.
    pub lines: Vec<Line>,
    /// What the survey says of each head's lever arm, metres.
    pub lever_arms_m: Vec<[f64; 3]>,
    /// Relative error of the survey's profile at the reference depth.
    pub profile_error: f64,
    /// Truth.
    pub truth: SeabedTruth,
}

/// Between two lines, seconds.
const TURN_S: f64 = 60.0;
/// The trajectory reaches this far beyond a line, seconds.
const MARGIN_S: f64 = 2.0;

/// What goes wrong in a simulation besides the mounting: factors on what the scenario says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acts {
    /// White noise of the INS.
    pub white: f64,
    /// Drift of the INS.
    pub drift: f64,
    /// Noise of range and angle.
    pub sonar: f64,
    /// Gross errors.
    pub gross: f64,
    /// Scale and lag of the heave channel.
    pub heave: f64,
    /// Heights of the lines.
    pub heights: f64,
    /// Error of the profile.
    pub water: f64,
    /// Error of the lever arm.
    pub arm: f64,
}

impl Acts {
    /// Everything as the scenario says.
    pub const ALL: Self = Self::each(1.0);
    /// Nothing.
    pub const NONE: Self = Self::each(0.0);

    const fn each(factor: f64) -> Self {
        Self {
            white: factor,
            drift: factor,
            sonar: factor,
            gross: factor,
            heave: factor,
            heights: factor,
            water: factor,
            arm: factor,
        }
    }

    /// The scenario with what really happens; what the survey claims is not in it.
    fn applied(self, scenario: &SeabedScenario) -> SeabedScenario {
        let mut real = scenario.clone();
        let t = &mut real.trajectory;
        for white in [
            &mut t.position_sigma_m,
            &mut t.roll_pitch_sigma_deg,
            &mut t.heading_sigma_deg,
        ] {
            *white *= self.white;
        }
        for drift in [
            &mut t.position_drift_sigma_m,
            &mut t.height_drift_sigma_m,
            &mut t.roll_pitch_drift_sigma_deg,
            &mut t.heading_drift_sigma_deg,
        ] {
            *drift *= self.drift;
        }
        real.multibeam.range_sigma_m *= self.sonar;
        real.multibeam.angle_sigma_deg *= self.sonar;
        real.errors.gross *= self.gross;
        real.errors.heave_scale *= self.heave;
        real.errors.heave_lag_s *= self.heave;
        real.errors.line_height_m *= self.heights;
        real.errors.profile *= self.water;
        let further = real.head.iter_mut().map(|head| &mut head.lever_arm_sigma_m);
        for sigma in std::iter::once(&mut real.multibeam.lever_arm_sigma_m).chain(further) {
            *sigma = sigma.map(|s| s * self.arm);
        }
        real
    }
}

/// Where a beam struck: the angle against the receive array and the way, one way or there and back; `None` where it struck nothing.
type Way = Option<(f64, f64)>;

/// The seabed under a survey, with the beams that were cast on it before.
pub struct Ground {
    bed: Seabed,
    /// Of each head, in the order in which its beams are cast.
    cast: Vec<Vec<Way>>,
}

impl Ground {
    /// Of a scenario under a seed, under these lines too.
    #[must_use]
    pub fn under(scenario: &SeabedScenario, further: &[Course], seed: u64) -> Self {
        let lines = scenario.line.iter().chain(further).cloned().collect();
        let wide = SeabedScenario {
            line: lines,
            ..scenario.clone()
        };
        Self {
            bed: Seabed::of(&wide, seed),
            cast: vec![],
        }
    }

    /// The beams of a scenario, cast once for all scenarios whose first lines are its own.
    pub fn remember(&mut self, scenario: &SeabedScenario, seed: u64, acts: Acts) {
        self.cast = cast(self, scenario, seed, acts, true).1;
    }
}

/// Beams one after the other: those that were cast before are not cast again.
struct Beams<'g> {
    bed: &'g Seabed,
    before: std::slice::Iter<'g, Way>,
    /// All of them, where they are to be remembered.
    all: Option<Vec<Way>>,
}

impl Beams<'_> {
    fn next(&mut self, cast: impl FnOnce(&Seabed) -> Way) -> Way {
        let way = match self.before.next() {
            Some(way) => *way,
            None => cast(self.bed),
        };
        if let Some(all) = &mut self.all {
            all.push(way);
        }
        way
    }
}

/// Simulates a scenario under a seed.
#[must_use]
pub fn simulate(scenario: &SeabedScenario, seed: u64, acts: Acts) -> Simulated {
    simulate_on(&Ground::under(scenario, &[], seed), scenario, seed, acts)
}

/// As [`simulate`], on a seabed that is there already.
#[must_use]
pub fn simulate_on(ground: &Ground, scenario: &SeabedScenario, seed: u64, acts: Acts) -> Simulated {
    cast(ground, scenario, seed, acts, false).0
}

/// A survey, and its beams where they are to be remembered.
fn cast(
    ground: &Ground,
    scenario: &SeabedScenario,
    seed: u64,
    acts: Acts,
    remember: bool,
) -> (Simulated, Vec<Vec<Way>>) {
    let scenario = &acts.applied(scenario);
    let boat = Boat::new(scenario, seed);
    let lines = boat.lines();
    let heads = scenario.heads();
    let turns: Vec<Matrix3<f64>> = heads.iter().map(true_turn).collect();
    let mountings: Vec<Matrix3<f64>> = heads
        .iter()
        .zip(&turns)
        .map(|(head, turn)| turn * nominal(scenario, head))
        .collect();
    let mut of_arm = stream(seed, 7);
    let mut said = |head: &FurtherHead| {
        let off = |k: usize, draws: &mut ChaCha8Rng| {
            head.lever_arm_m[k] + normal(draws, head.lever_arm_sigma_m[k])
        };
        std::array::from_fn(|k| off(k, &mut of_arm))
    };
    let truth = |k: usize| TrueHead {
        rotation_matrix: std::array::from_fn(|i| std::array::from_fn(|j| mountings[k][(i, j)])),
        lever_arm_m: heads[k].lever_arm_m,
    };
    let TrueHead {
        rotation_matrix,
        lever_arm_m,
    } = truth(0);
    let (shots, beams) = of_all_heads(scenario, (&boat, &lines), &turns, (ground, remember), seed);
    let survey = Simulated {
        lever_arms_m: heads.iter().map(&mut said).collect(),
        profile_error: scenario.errors.profile,
        records: records(scenario, &boat, &lines, seed),
        shots,
        truth: SeabedTruth {
            rotation_matrix,
            lever_arm_m,
            latency_s: scenario.errors.latency_s,
            range_scale: scenario.errors.range_scale,
            further_heads: (1..heads.len()).map(truth).collect(),
        },
        lines,
    };
    (survey, beams)
}

/// By how much a head is really turned from its nominal mounting.
fn true_turn(head: &FurtherHead) -> Matrix3<f64> {
    let turn = head.correction_deg;
    rotation::exp(&Vector3::new(turn.pitch, turn.roll, turn.yaw).map(f64::to_radians))
}

/// Nominal rotation of a head.
fn nominal(scenario: &SeabedScenario, head: &FurtherHead) -> Matrix3<f64> {
    let arrays = head.arrays(head.lever_arm_m);
    match scenario.two_arrays() {
        Some(_) => arrays.together().rotation,
        None => arrays.transmitter.rotation,
    }
}

/// A head on the boat: its number, its place, and how it stamps.
#[derive(Clone, Copy, Debug)]
struct OfHead {
    head: u8,
    lever_arm_m: Vector3<f64>,
    /// Its stamps are late by this, seconds.
    latency_s: f64,
    /// Stream of its noise.
    draws: u64,
}

impl OfHead {
    fn new(number: usize, head: &FurtherHead, scenario: &SeabedScenario) -> Self {
        Self {
            head: number as u8,
            lever_arm_m: head.lever_arm_m.into(),
            latency_s: scenario.errors.latency_s + head.latency_s,
            draws: 4 + 100 * number as u64,
        }
    }
}

/// The soundings of all heads, which ping together, in order of their stamps.
fn of_all_heads(
    scenario: &SeabedScenario,
    (boat, lines): (&Boat<'_>, &[Line]),
    turns: &[Matrix3<f64>],
    (ground, remember): (&Ground, bool),
    seed: u64,
) -> (Vec<Shot>, Vec<Vec<Way>>) {
    let (mut all, mut cast) = (vec![], vec![]);
    for (number, (head, turn)) in scenario.heads().iter().zip(turns).enumerate() {
        let of_head = OfHead::new(number, head, scenario);
        let mut beams = Beams {
            bed: &ground.bed,
            before: ground
                .cast
                .get(number)
                .map_or([].iter(), |ways| ways.iter()),
            all: remember.then(Vec::new),
        };
        all.extend(match scenario.two_arrays() {
            Some(two) => {
                let arrays = head.arrays(head.lever_arm_m);
                let arrays = ArrayMountings {
                    transmitter: arrays.transmitter.turned(turn),
                    receiver: arrays.receiver.turned(turn),
                };
                arrays::shots(
                    scenario,
                    (boat, lines),
                    (&two, &arrays, &of_head),
                    &mut beams,
                    seed,
                )
            }
            None => {
                let mounting = turn * nominal(scenario, head);
                shots(
                    scenario,
                    (boat, lines),
                    (&mounting, &of_head),
                    &mut beams,
                    seed,
                )
            }
        });
        cast.extend(beams.all);
    }
    if turns.len() > 1 {
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    (all, cast)
}

/// Waves in one degree of freedom.
struct Waves(Vec<[f64; 3]>);

impl Waves {
    /// Six sines about the typical period with this standard deviation together.
    fn new(sigma: f64, period_s: f64, draws: &mut ChaCha8Rng) -> Self {
        let sine = |k: i32| {
            let stretch = 0.7 + 0.12 * f64::from(k) + draws.random_range(0.0..0.1);
            let phase = draws.random_range(0.0..std::f64::consts::TAU);
            let amplitude = sigma * (2.0f64 / 6.0).sqrt();
            [
                amplitude,
                std::f64::consts::TAU / (period_s * stretch),
                phase,
            ]
        };
        Self((0..6).map(sine).collect())
    }

    fn at(&self, time_s: f64) -> f64 {
        let one = |[a, rate, phase]: &[f64; 3]| a * math::sin(rate * time_s + phase);
        self.0.iter().map(one).sum()
    }
}

/// The boat's true motion.
struct Boat<'a> {
    scenario: &'a SeabedScenario,
    roll: Waves,
    pitch: Waves,
    yaw: Waves,
    heave: Waves,
}

impl<'a> Boat<'a> {
    fn new(scenario: &'a SeabedScenario, seed: u64) -> Self {
        let m = &scenario.motion;
        let mut draws = stream(seed, 2);
        let degree = 1f64.to_radians();
        let mut waves = |sigma| Waves::new(sigma, m.period_s, &mut draws);
        Self {
            scenario,
            roll: waves(m.roll_deg * degree),
            pitch: waves(m.pitch_deg * degree),
            yaw: waves(m.yaw_deg * degree),
            heave: waves(m.heave_m),
        }
    }

    fn lines(&self) -> Vec<Line> {
        let mut start_s = START_S;
        let each = self.scenario.line.iter().map(|course| {
            let way = Vector2::from(course.to_m) - Vector2::from(course.from_m);
            let line = Line {
                name: course.name.clone(),
                start_s,
                end_s: start_s + way.norm() / course.speed_m_s,
                cast: 0,
                tide_m: 0.0,
                height_sigma_m: self.scenario.site.line_height_sigma_m,
            };
            start_s = line.end_s + TURN_S;
            line
        });
        each.collect()
    }

    /// What the heave channel measures too much.
    fn false_heave_m(&self, time_s: f64) -> f64 {
        let errors = &self.scenario.errors;
        let measured = self.heave.at(time_s - errors.heave_lag_s) * (1.0 + errors.heave_scale);
        measured - self.heave.at(time_s)
    }

    /// Position and attitude on a line at a time.
    fn pose(&self, number: usize, line: &Line, time_s: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let course = &self.scenario.line[number];
        let from = Vector2::from(course.from_m);
        let way = Vector2::from(course.to_m) - from;
        let at = from + way * ((time_s - line.start_s) / (line.end_s - line.start_s));
        let heading = math::atan2(way.x, way.y) + self.yaw.at(time_s);
        let level = self.scenario.site.water_level_m + self.scenario.tide_m(time_s);
        let height = level + self.heave.at(time_s);
        let rotation =
            rotation::from_attitude(self.roll.at(time_s), self.pitch.at(time_s), heading);
        (Vector3::new(at.x, at.y, height), rotation)
    }
}

fn normal(draws: &mut ChaCha8Rng, sigma: f64) -> f64 {
    draw(draws) * sigma
}

/// The trajectory with the INS's errors.
fn records(scenario: &SeabedScenario, boat: &Boat<'_>, lines: &[Line], seed: u64) -> Vec<Record> {
    let t = &scenario.trajectory;
    let mut draws = stream(seed, 3);
    let slow = t.drift_correlation_time_s;
    let tilt = t.roll_pitch_drift_sigma_deg.to_radians();
    let mut drifts = [
        GaussMarkov::new(t.position_drift_sigma_m, slow),
        GaussMarkov::new(t.position_drift_sigma_m, slow),
        GaussMarkov::new(t.height_drift_sigma_m, slow),
        GaussMarkov::new(tilt, t.roll_pitch_correlation_time_s),
        GaussMarkov::new(tilt, t.roll_pitch_correlation_time_s),
        GaussMarkov::new(
            t.heading_drift_sigma_deg.to_radians(),
            t.heading_correlation_time_s,
        ),
    ];
    let white = [
        t.position_sigma_m,
        t.position_sigma_m,
        t.position_sigma_m,
        t.roll_pitch_sigma_deg.to_radians(),
        t.roll_pitch_sigma_deg.to_radians(),
        t.heading_sigma_deg.to_radians(),
    ];
    let mut of_lines = stream(seed, 6);
    let offsets_m: Vec<f64> = lines
        .iter()
        .map(|_| normal(&mut of_lines, scenario.errors.line_height_m))
        .collect();
    let mut all = vec![];
    for (number, line) in lines.iter().enumerate() {
        let first = ((line.start_s - MARGIN_S) * scenario.trajectory_rate_hz).ceil() as i64;
        let last = ((line.end_s + MARGIN_S) * scenario.trajectory_rate_hz).floor() as i64;
        for k in first..=last {
            let time_s = k as f64 / scenario.trajectory_rate_hz;
            let (position, attitude) = boat.pose(number, line, time_s);
            let error: [f64; 6] = std::array::from_fn(|c| {
                let drift = drifts[c].at(time_s, |sigma| normal(&mut draws, sigma));
                drift + normal(&mut draws, white[c])
            });
            let shift = Vector3::new(error[0], error[1], error[2] + boat.false_heave_m(time_s));
            let shift = shift + Vector3::z() * offsets_m[number];
            let turn = rotation::exp(&Vector3::new(error[3], error[4], error[5]));
            all.push(Record {
                time_s,
                position_m: position + shift,
                rotation: attitude * turn,
            });
        }
    }
    all
}

/// The rectangle that the lines' swaths cover, generously: two corners.
fn area(scenario: &SeabedScenario) -> [Vector2<f64>; 2] {
    let ends = scenario.line.iter().flat_map(|l| [l.from_m, l.to_m]);
    let reach = Vector2::repeat(4.0 * scenario.bed.depth_m);
    let wide = |(low, high): (Vector2<f64>, Vector2<f64>), end: [f64; 2]| {
        let end = Vector2::from(end);
        (low.inf(&end), high.sup(&end))
    };
    let nothing = (
        Vector2::repeat(f64::INFINITY),
        Vector2::repeat(-f64::INFINITY),
    );
    let (low, high) = ends.fold(nothing, wide);
    [low - reach, high + reach]
}

impl Seabed {
    /// The seabed of a scenario under a seed.
    #[must_use]
    pub fn of(scenario: &SeabedScenario, seed: u64) -> Self {
        Self::new(&scenario.bed, area(scenario), seed)
    }
}

/// All soundings of a head.
fn shots(
    scenario: &SeabedScenario,
    (boat, lines): (&Boat<'_>, &[Line]),
    (mounting, of_head): (&Matrix3<f64>, &OfHead),
    beams: &mut Beams<'_>,
    seed: u64,
) -> Vec<Shot> {
    let m = &scenario.multibeam;
    let mut draws = stream(seed, of_head.draws);
    let (mut all, mut ping) = (vec![], 0);
    for (number, line) in lines.iter().enumerate() {
        let count = ((line.end_s - line.start_s) * m.ping_rate_hz) as u32;
        for k in 0..count {
            // pings drift against the INS's records
            let time_s = line.start_s + (f64::from(k) + 0.37) / m.ping_rate_hz * 0.9999;
            let (position, attitude) = boat.pose(number, line, time_s);
            let transducer = position + attitude * of_head.lever_arm_m;
            let sensor = attitude * mounting;
            for beam in 0..m.beams {
                let part = f64::from(beam) / f64::from((m.beams - 1).max(1));
                let across = (2.0 * part - 1.0) * m.half_swath_deg.to_radians();
                let direction = sensor * Vector3::new(math::sin(across), 0.0, -math::cos(across));
                let way = |bed: &Seabed| Some((across, strike(bed, &transducer, &direction)?));
                let Some((_, range_m)) = beams.next(way) else {
                    continue;
                };
                let outward = across.abs() / 60f64.to_radians();
                let sigma =
                    m.angle_sigma_deg.to_radians() * (1.0 + m.angle_sigma_growth * outward.powi(3));
                let measured_m = range_m / (1.0 + scenario.errors.range_scale)
                    + normal(&mut draws, m.range_sigma_m);
                all.push(Shot {
                    time_s: time_s + of_head.latency_s,
                    ping,
                    beam,
                    head: of_head.head,
                    across_rad: across + normal(&mut draws, sigma),
                    tilt_rad: 0.0,
                    delay_s: 0.0,
                    sector: 0,
                    two_way_s: 2.0 * measured_m / scenario.sound_speed_m_s,
                    gross: false,
                });
            }
            ping += 1;
        }
    }
    spoil(&mut all, scenario.errors.gross, m.beams, &mut draws);
    all
}

/// Range at which a straight ray meets the bed; `None` where it does not.
fn strike(bed: &Seabed, from: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
    let over = |r: f64| {
        let p = from + direction * r;
        p.z - bed.height_m(&p.xy())
    };
    let mut range = (from.z - bed.height_m(&from.xy())) / (-direction.z).max(0.1);
    for _ in 0..40 {
        let step = over(range) / (-direction.z).max(0.2);
        range += step;
        if step.abs() < 1e-7 {
            return (range > 0.5 && range < 2000.0).then_some(range);
        }
    }
    None
}

/// Gross errors: a third single, a third in clusters of eight neighbouring soundings, a third in bursts of half a swath; 2 to 15 % short
/// or long, a burst anywhere in the water.
fn spoil(shots: &mut [Shot], part: f64, beams: u32, draws: &mut ChaCha8Rng) {
    let wanted = (part * shots.len() as f64) as usize;
    let half = (beams as usize / 2).max(1);
    let mut done = 0;
    while done < wanted && !shots.is_empty() {
        let left = wanted - done;
        let size = match 3 * left / wanted.max(1) {
            0 => half,
            1 => 8,
            _ => 1,
        };
        let first = draws.random_range(0..shots.len());
        let sign = if draws.random_bool(0.7) { -1.0 } else { 1.0 };
        let off = draws.random_range(0.02..0.15) * sign;
        for shot in shots.iter_mut().skip(first).take(size) {
            shot.two_way_s *= if size == half {
                draws.random_range(0.2..0.97)
            } else {
                1.0 + off
            };
            shot.gross = true;
        }
        done += size;
    }
}
