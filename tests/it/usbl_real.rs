//! Real travel times to seafloor transponders from a rolling ship with a lever arm: rays, attitude and lever arm as a whole.
//!
//! GNSS-A observation of the Japan Coast Guard, site SAGA, campaign `1903.kaiyo_k4` (open data of the `garpos` software,
//! s-watanabe-jhod/garpos, sample/obsdata/SAGA), in the folder `gnss-a` of `BORESIGHT_DATA`. There are no angles in it, so that it
//! tests the ray between two points and the conventions, not the calibration. The same fit with scipy-style least squares and a
//! ray solver of its own in Python (bisection on the ray parameter) gave 0.0613 ms, with the roll reversed 0.123 ms, without
//! attitude and horizontal lever arm 0.089 ms, on 31 shots.

use std::path::PathBuf;

use boresight::adjust::{
    Block, BlockId, ChainState, Component, Conditions, Estimate, Options, ParameterSet, Problem,
    Row, Source, Unit, solve,
};
use boresight::geometry::rotation;
use boresight::georef::Medium;
use boresight::observe::{SoundSpeed, SoundSpeedProfile};
use nalgebra::{DMatrix, Vector3};

/// A-priori positions, east, north, up (m), and the lever arm from the antenna to the transducer, right, forward, up (m): the
/// campaign's initcfg.ini.
const TRANSPONDERS: [(&str, [f64; 3]); 4] = [
    ("M11", [-47.0050, 408.6450, -1345.0440]),
    ("M12", [486.6430, 48.1280, -1354.3120]),
    ("M13", [-26.3580, -506.1430, -1335.8170]),
    ("M14", [-538.1190, -22.7480, -1330.4880]),
];
const LEVER_ARM_M: [f64; 3] = [-1.2690, 1.5547, -23.7295];
/// Standard deviation of a travel time, seconds.
const SIGMA_S: f64 = 1e-4;
/// Shots of the file's beginning: later ones see other water.
const SHOTS: usize = 100;

struct Shot {
    transponder: usize,
    two_way_s: f64,
    /// Transducer when it sent and when it heard, east, north, up, metres.
    ends_m: [Vector3<f64>; 2],
}

struct Times<'a> {
    shots: &'a [Shot],
    medium: &'a Medium,
    places: [BlockId; 4],
    scale: BlockId,
}

impl Conditions for Times<'_> {
    fn len(&self) -> usize {
        self.shots.len()
    }

    fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
        let shot = &self.shots[k];
        let place = self.places[shot.transponder];
        let beacon_m = Vector3::from_column_slice(x.euclidean(place));
        let (mut time_s, mut slope) = (0.0, Vector3::zeros());
        for end_m in &shot.ends_m {
            let Ok(ray) = self.medium.eigenray(-end_m.z, &(beacon_m - end_m)) else {
                return;
            };
            time_s += ray.time_s;
            slope += ray.time_by_end;
        }
        let scale = 1.0 - x.euclidean(self.scale)[0];
        row.misclosure = time_s * scale - shot.two_way_s;
        row.variance = SIGMA_S * SIGMA_S;
        row.extend(x.offset(place), (slope * scale).as_slice());
        row.push(x.offset(self.scale), -time_s);
    }
}

fn shots(text: &str, roll_sign: f64, arm_m: &Vector3<f64>) -> Vec<Shot> {
    let rows = text
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()));
    rows.take(SHOTS)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |k: usize| fields[k].parse::<f64>().expect("a number");
            let end = |first: usize| {
                let antenna = Vector3::new(number(first), number(first + 1), number(first + 2));
                let [heading, pitch, roll] = [3, 4, 5].map(|k| number(first + k).to_radians());
                antenna + rotation::from_attitude(roll_sign * roll, pitch, heading) * arm_m
            };
            let name = fields[3];
            Shot {
                transponder: TRANSPONDERS
                    .iter()
                    .position(|t| t.0 == name)
                    .expect("a known name"),
                two_way_s: number(4),
                ends_m: [end(10), end(17)],
            }
        })
        .collect()
}

/// Root mean square residuals (s) with the a-priori positions and after the fit.
fn fitted(shots: &[Shot], medium: &Medium) -> (f64, f64) {
    let mut set = ParameterSet::new();
    let names =
        |name: &str| ["e", "n", "u"].map(|a| Component::new(format!("{name} {a}"), Unit::Metre));
    let places = TRANSPONDERS.map(|(name, at)| {
        let block = Block::euclidean(name, names(name).to_vec(), &at);
        let prior = DMatrix::identity(3, 3) * 9.0;
        set.push(block.with_prior(at.to_vec(), prior))
            .expect("a block")
    });
    let component = vec![Component::new("scale", Unit::One)];
    let block = Block::euclidean("scale", component, &[0.0]);
    let prior = DMatrix::from_element(1, 1, 4e-6);
    let scale = set
        .push(block.with_prior(vec![0.0], prior))
        .expect("a block");
    let times = Times {
        shots,
        medium,
        places,
        scale,
    };
    let rms = |x: &ParameterSet| {
        let mut row = Row::default();
        let squares = (0..shots.len()).map(|k| {
            row.clear();
            times.linearise(k, x, None, &mut row);
            row.misclosure.powi(2)
        });
        (squares.sum::<f64>() / shots.len() as f64).sqrt()
    };
    let before = rms(&set);
    let problem = Problem::dense(vec![Source::new(&times)]);
    let solution = solve(&problem, Estimate::new(set), &Options::default()).expect("a solution");
    assert!(solution.status.was_successful());
    (before, rms(&solution.estimate.parameters))
}

#[test]
fn travel_times_at_sea_are_explained() {
    let Some(folder) = std::env::var_os("BORESIGHT_DATA") else {
        println!("skipped: BORESIGHT_DATA is not set");
        return;
    };
    let folder = PathBuf::from(folder).join("gnss-a");
    let read = |name: &str| std::fs::read_to_string(folder.join(name));
    let (Ok(observed), Ok(water)) = (
        read("SAGA.1903.kaiyo_k4-obs.csv"),
        read("SAGA.1903.kaiyo_k4-svp.csv"),
    ) else {
        println!("skipped: no gnss-a in BORESIGHT_DATA");
        return;
    };
    let samples = water.lines().filter_map(|line| {
        let (depth, speed) = line.split_once(',')?;
        Some((depth.parse::<f64>().ok()?, speed.parse::<f64>().ok()?))
    });
    let (depth_m, speed_m_s) = samples.unzip();
    let profile = SoundSpeedProfile { depth_m, speed_m_s };
    let medium = Medium::new(&SoundSpeed::Profile(profile)).expect("water");
    let arm = Vector3::from(LEVER_ARM_M);
    let (before, after) = fitted(&shots(&observed, 1.0, &arm), &medium);
    let (_, reversed) = fitted(&shots(&observed, -1.0, &arm), &medium);
    println!("before {before:.2e} s, after {after:.2e} s, roll reversed {reversed:.2e} s");
    // 3 m of prior are 4 ms; the raw residual is half a metre
    assert!(before < 1e-3 && after < 1e-4, "{before} {after}");
    assert!(reversed > 1.5 * after, "{reversed} {after}");
}
