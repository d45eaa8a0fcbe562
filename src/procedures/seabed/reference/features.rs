//! The paper's path: the lines' seabeds as images, features matched between them, the overall adjustment of the matched points.
//!
//! What the text leaves open and what was chosen is listed in `docs/seabed-measured.md`.

use crate::math;
use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use super::super::layout::Layout;
use super::super::model::{Located, Locator, Values};
use super::super::scene::Scene;
use super::super::states::States;
use super::config::{LATENCY, ReferenceConfig};
use super::image::{Grey, Image, cell_side_m};
use super::overall::{Overall, OverallError, Side, adjust, sigmas};
use super::sift::{self, Keypoints};

/// Two lines whose features were matched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Matched {
    /// Names of the lines.
    pub lines: [String; 2],
    /// Keypoints of each image.
    pub keypoints: [usize; 2],
    /// Keypoints that are each other's nearest.
    pub matched: usize,
    /// Matches that agree on one shift of the images.
    pub agreeing: usize,
    /// Matches within two standard deviations of the mean difference in every coordinate: those that are adjusted.
    pub kept: usize,
    /// Mean difference of the kept, first line minus second: north, east, down, metres.
    pub mean_m: [f64; 3],
    /// Its standard deviation, metres.
    pub sigma_m: [f64; 3],
    /// Places of the kept, east and north on the first line, then on the second, metres; every so-manieth.
    pub places_m: Vec<[f64; 4]>,
}

/// What the paper's path found.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// Values as the paper reports them.
    pub values: Values,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Every pair of lines.
    pub pairs: Vec<Matched>,
    /// The latency with and without its bound, seconds, in the sense of a result: positive where the soundings are late.
    pub latency_s: Latency,
}

/// The latency both ways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// Bounded as in (9): the position may be late, never the sounding.
    pub bounded: f64,
    /// Free.
    pub free: f64,
}

/// Why the paper's path has no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FeaturesError {
    /// This build has no SIFT.
    #[error("this program was built without its feature `sift`, which finds the keypoints")]
    NotBuilt,
    /// Too few features.
    #[error(
        "only {kept} of {matched} matched features agree between the lines; {FEWEST} are needed"
    )]
    TooFew {
        /// Those that agree.
        kept: usize,
        /// All.
        matched: usize,
    },
    /// The adjustment of the matched points.
    #[error("the adjustment of {kept} matched features has no result: {why}")]
    Overall {
        /// Matched points.
        kept: usize,
        /// Why.
        why: OverallError,
    },
    /// What the matched points leave open, or a solution that has run away.
    #[error("{kept} matched features between {pairs} pairs of lines do not determine {what}")]
    Undetermined {
        /// Matched points.
        kept: usize,
        /// Pairs of lines that have some.
        pairs: usize,
        /// Names of what is open.
        what: String,
    },
    /// The profile cannot be used.
    #[error("the sound-speed profile cannot be used")]
    Profile,
}

/// Matched points at least: five unknowns, and something to see an error by.
const FEWEST: usize = 12;
/// Agreeing matches of a pair at least: two or three may agree by chance.
const FEWEST_OF_PAIR: usize = 6;
/// The five, and what a solution must stay within: standard deviation and size, radians, seconds, 1.
const LIMITS: [(&str, f64, f64); 5] = [
    ("roll", DEGREE, 15.0 * DEGREE),
    ("pitch", DEGREE, 15.0 * DEGREE),
    ("yaw", DEGREE, 15.0 * DEGREE),
    ("latency", 1.0, 10.0),
    ("range scale", 0.1, 0.2),
];
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Matches of a pair agree on its shift within so many cells.
const AGREE_CELLS: f64 = 3.0;
/// Places of a pair in the result at most.
const MOST_PLACES: usize = 300;
/// Soundings of a line that its image is made of at most.
const MOST_SOUNDINGS: usize = 3_000_000;

/// A line's soundings on the bed, its image, and the image's keypoints.
struct Strip {
    located: Vec<Located>,
    image: Image,
    keypoints: Keypoints,
}

/// Runs the paper's path. `alive` marks soundings that passed the screen.
///
/// # Errors
/// [`FeaturesError`].
pub fn features(
    scene: &Scene,
    states: &States,
    alive: &[bool],
    layout: &Layout,
    config: &ReferenceConfig,
    widest_rad: f64,
) -> Result<Features, FeaturesError> {
    if !sift::BUILT {
        return Err(FeaturesError::NotBuilt);
    }
    let nominal = Values::nominal(scene, states);
    let locator = Locator::new(scene, states, &nominal).ok_or(FeaturesError::Profile)?;
    let lines: Vec<Vec<usize>> = (0..scene.lines.len())
        .map(|line| usable(scene, alive, line, widest_rad))
        .collect();
    let cell_m = cell_of_all(scene, &lines, layout);
    let up = layout
        .tracks
        .first()
        .map_or(Vector2::y(), |t| course(t.course_deg));
    let strips: Vec<Option<Strip>> = lines
        .iter()
        .map(|own| strip(&locator, own, cell_m, up, config.grey()))
        .collect();
    let (mut sides, mut pairs) = (vec![], vec![]);
    for pair in &layout.pairs {
        let [Some(a), Some(b)] = pair.lines.map(|k| strips[k].as_ref()) else {
            continue;
        };
        let names = pair.lines.map(|k| scene.lines[k].name.clone());
        let (matched, own) = match_pair([a, b], names, cell_m);
        pairs.push(matched);
        sides.extend(own);
    }
    let cell_m = strips
        .iter()
        .flatten()
        .map(|s| s.image.cell_m)
        .fold(cell_m, f64::max);
    solve(&nominal, &sides, pairs, cell_m, config)
}

fn solve(
    nominal: &Values,
    sides: &[[Side; 2]],
    pairs: Vec<Matched>,
    cell_m: f64,
    config: &ReferenceConfig,
) -> Result<Features, FeaturesError> {
    let kept = sides.len();
    if kept < FEWEST {
        let matched = pairs.iter().map(|p| p.matched).sum();
        return Err(FeaturesError::TooFew { kept, matched });
    }
    let adjusted =
        |bounded: bool| adjust(sides, bounded).map_err(|why| FeaturesError::Overall { kept, why });
    let (bounded, free) = (adjusted(true)?, adjusted(false)?);
    let chosen = if config.latency == LATENCY[0] {
        bounded
    } else {
        free
    };
    if let Some(what) = open(sides, &chosen) {
        let pairs = pairs.iter().filter(|p| p.kept > 0).count();
        return Err(FeaturesError::Undetermined { kept, pairs, what });
    }
    Ok(Features {
        values: corrected(nominal, &chosen),
        cell_m,
        pairs,
        latency_s: Latency {
            bounded: 0.0 - bounded.latency_s,
            free: 0.0 - free.latency_s,
        },
    })
}

/// What a solution does not determine, in words; nothing where it determines everything.
fn open(sides: &[[Side; 2]], found: &Overall) -> Option<String> {
    let sigma = sigmas(sides, found).unwrap_or([f64::INFINITY; 5]);
    let value = [
        found.roll_rad,
        found.pitch_rad,
        found.heading_rad,
        found.latency_s,
        found.scale,
    ];
    let beyond = |k: &usize| {
        let (_, most_sigma, most) = LIMITS[*k];
        !(sigma[*k] <= most_sigma && value[*k].abs() <= most)
    };
    let names: Vec<&str> = (0..5).filter(beyond).map(|k| LIMITS[k].0).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// The paper's unknowns in the sense of this program: roll, heading and latency with the opposite sign (`docs/seabed-measured.md`).
fn corrected(nominal: &Values, found: &Overall) -> Values {
    let mut step = nominal.no_step();
    step[0] = found.pitch_rad;
    step[1] = -found.roll_rad;
    step[2] = -found.heading_rad;
    step[3] = 0.0 - found.latency_s;
    step[4] = found.scale;
    nominal.stepped(&step)
}

fn course(degrees: f64) -> Vector2<f64> {
    let (east, north) = math::sin_cos(degrees.to_radians());
    Vector2::new(east, north)
}

fn usable(scene: &Scene, alive: &[bool], line: usize, widest_rad: f64) -> Vec<usize> {
    let own = |k: &usize| {
        let s = &scene.soundings[*k];
        usize::from(s.line) == line && alive[*k] && scene.aside_rad(*k).abs() <= widest_rad
    };
    let all: Vec<usize> = (0..scene.soundings.len()).filter(own).collect();
    let stride = all.len().div_ceil(MOST_SOUNDINGS).max(1);
    all.into_iter().step_by(stride).collect()
}

/// The widest cell that (12) and (13) give for one of the lines: the fastest line sets it, as in the paper's trial.
fn cell_of_all(scene: &Scene, lines: &[Vec<usize>], layout: &Layout) -> f64 {
    let depth_m = scene.typical_depth_m();
    let each = lines.iter().zip(&layout.tracks).map(|(own, track)| {
        let pings = pings(scene, own);
        let beams = own.len() as f64 / pings.max(1) as f64;
        let swath_rad = swath_rad(scene, own);
        let along_m = track.length_m / pings.max(1) as f64;
        cell_side_m(along_m, depth_m, swath_rad, beams.round() as u32)
    });
    each.fold(0.05, f64::max)
}

/// Pings of a line: times that differ.
fn pings(scene: &Scene, own: &[usize]) -> usize {
    own.chunk_by(|a, b| scene.soundings[*a].time_s == scene.soundings[*b].time_s)
        .count()
}

fn swath_rad(scene: &Scene, own: &[usize]) -> f64 {
    let across = || own.iter().map(|k| scene.soundings[*k].across_rad);
    across().fold(0.0, f64::max) - across().fold(0.0, f64::min)
}

fn strip(
    locator: &Locator<'_>,
    own: &[usize],
    cell_m: f64,
    up: Vector2<f64>,
    grey: Grey,
) -> Option<Strip> {
    let located: Vec<Located> = own.iter().filter_map(|k| locator.locate(*k)).collect();
    let points: Vec<Vector3<f64>> = located.iter().map(|l| l.point_m).collect();
    let image = Image::new(&points, cell_m, up)?;
    Some(Strip {
        keypoints: sift::keypoints(&image, grey),
        located,
        image,
    })
}

/// One feature on both lines: the point, and the sounding nearest to it.
type Twin = [(Vector3<f64>, usize); 2];

fn match_pair(strips: [&Strip; 2], lines: [String; 2], cell_m: f64) -> (Matched, Vec<[Side; 2]>) {
    let matched = sift::matches(&strips[0].keypoints, &strips[1].keypoints);
    let twin = |numbers: &[usize; 2]| -> Option<Twin> {
        let point = |k: usize| {
            let [column, row] = strips[k].keypoints.at[numbers[k]];
            strips[k].image.point(column, row)
        };
        Some([point(0)?, point(1)?])
    };
    let twins: Vec<Twin> = matched.iter().filter_map(twin).collect();
    let agreeing = agreeing(&twins, AGREE_CELLS * cell_m);
    let enough = agreeing.len() >= FEWEST_OF_PAIR;
    let (kept, mean, sigma) = screened(if enough { &agreeing } else { &[] });
    let stride = kept.len().div_ceil(MOST_PLACES).max(1);
    let places = |[a, b]: &Twin| [a.0.x, a.0.y, b.0.x, b.0.y];
    let side = |k: usize, twin: &Twin| side(&twin[k].0, &strips[k].located[twin[k].1]);
    let sides = kept.iter().map(|twin| [side(0, twin), side(1, twin)]);
    let found = Matched {
        lines,
        keypoints: strips.map(|s| s.keypoints.at.len()),
        matched: matched.len(),
        agreeing: agreeing.len(),
        kept: kept.len(),
        mean_m: mean.into(),
        sigma_m: sigma.into(),
        places_m: kept.iter().step_by(stride).map(places).collect(),
    };
    (found, sides.collect())
}

/// RANSAC with one match as a sample: the shift of the images that most matches agree on. Every match is tried, so nothing is drawn.
fn agreeing(twins: &[Twin], within_m: f64) -> Vec<Twin> {
    let shift = |twin: &Twin| (twin[1].0 - twin[0].0).xy();
    let near = |about: Vector2<f64>| move |twin: &&Twin| (shift(twin) - about).norm() <= within_m;
    let votes = |twin: &&Twin| twins.iter().filter(near(shift(twin))).count();
    let Some(best) = twins.iter().max_by_key(votes) else {
        return vec![];
    };
    twins.iter().filter(near(shift(best))).copied().collect()
}

/// North, east, down of the first point less the second.
fn difference(twin: &Twin) -> Vector3<f64> {
    let off = twin[0].0 - twin[1].0;
    Vector3::new(off.y, off.x, -off.z)
}

/// The 2 sigma rule: matches within two standard deviations of the mean difference in every coordinate, their mean and deviation.
fn screened(twins: &[Twin]) -> (Vec<Twin>, Vector3<f64>, Vector3<f64>) {
    let (mean, sigma) = moments(twins);
    let near = |twin: &&Twin| {
        let off = difference(twin) - mean;
        (0..3).all(|k| off[k].abs() <= 2.0 * sigma[k])
    };
    let kept: Vec<Twin> = twins.iter().filter(near).copied().collect();
    let (mean, sigma) = moments(&kept);
    (kept, mean, sigma)
}

fn moments(twins: &[Twin]) -> (Vector3<f64>, Vector3<f64>) {
    let count = twins.len().max(1) as f64;
    let mean = twins.iter().map(difference).sum::<Vector3<f64>>() / count;
    let square = |twin: &Twin| (difference(twin) - mean).map(|x| x * x);
    let variance = twins.iter().map(square).sum::<Vector3<f64>>() / (count - 1.0).max(1.0);
    (mean, variance.map(f64::sqrt))
}

/// A matched point as its line measured it: heading, speed and transducer of the nearest sounding.
fn side(point_m: &Vector3<f64>, nearest: &Located) -> Side {
    let forward = nearest.rotation.column(1).xy().normalize();
    let transducer = nearest.point_m - nearest.ray_m;
    side_of(point_m, &transducer, forward, &nearest.velocity_m_s())
}

/// The same from a transducer that heads `forward`, moved along its heading until the point lies abeam of it, as (4) has it.
fn side_of(
    point_m: &Vector3<f64>,
    transducer_m: &Vector3<f64>,
    forward: Vector2<f64>,
    velocity_m_s: &Vector3<f64>,
) -> Side {
    let right = Vector2::new(forward.y, -forward.x);
    let off = point_m - transducer_m;
    let (across_m, depth_m) = (right.dot(&off.xy()), -off.z);
    let abeam = point_m.xy() - right * across_m;
    Side {
        transducer_m: Vector3::new(abeam.y, abeam.x, -transducer_m.z),
        heading_rad: math::atan2(forward.x, forward.y),
        speed_m_s: forward.dot(&velocity_m_s.xy()),
        beam_rad: math::atan2(across_m, depth_m),
        range_m: math::hypot(across_m, depth_m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twin(k: usize, shift: Vector3<f64>) -> Twin {
        let at = Vector3::new(k as f64, (k % 7) as f64, -14.0);
        [(at, k), (at + shift, k)]
    }

    #[test]
    fn the_shift_of_most_is_found_among_wrong_matches() {
        let shift = Vector3::new(0.3, -0.6, 0.02);
        let wobble = |k: usize| 0.05 * ((k * 31 % 11) as f64 / 5.0 - 1.0);
        let mut twins: Vec<Twin> = (0..30)
            .map(|k| twin(k, shift + Vector3::repeat(wobble(k))))
            .collect();
        let wrong =
            |k: usize| Vector3::new(5.0 * math::sin(k as f64), 9.0 * math::cos(k as f64), 0.0);
        twins.extend((30..90).map(|k| twin(k, wrong(k))));
        let agreed = agreeing(&twins, 0.6);
        let right = agreed.iter().filter(|t| t[0].1 < 30).count();
        assert!(
            right == 30 && agreed.len() < 34,
            "{right} of {}",
            agreed.len()
        );
        let (kept, mean, _) = screened(&agreed);
        assert!(
            (mean - Vector3::new(0.6, -0.3, 0.02)).norm() < 0.1,
            "{mean}"
        );
        assert!(kept.len() >= 25);
    }

    #[test]
    fn a_side_says_where_its_point_is() {
        let point = Vector3::new(3.0, 8.0, -14.2);
        let transducer = Vector3::new(1.0, 2.0, -1.0);
        let velocity = Vector3::new(1.2, 1.6, 0.3);
        let side = side_of(&point, &transducer, Vector2::new(0.6, 0.8), &velocity);
        let found = side.point_m(&Overall::default());
        assert!(
            (found - Vector3::new(8.0, 3.0, 14.2)).norm() < 1e-9,
            "{found}"
        );
        assert!((side.speed_m_s - 2.0).abs() < 1e-12);
        // six metres north and two east of a transducer that heads north-east: a little to port
        assert!(side.beam_rad < 0.0);
    }
}
