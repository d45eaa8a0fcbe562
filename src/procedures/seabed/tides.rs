//! Does the tide of the survey file fit what else tells the height of the water? Mistakes in a tide curve by which heights come out as they do.

use super::joint::Joint;
use super::scene::Scene;
use crate::observe::TideCurve;
use crate::results::{Finding, Severity};

/// By how much the water is higher at a time than the curve says, up to a constant, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lacking {
    /// When, seconds.
    pub time_s: f64,
    /// Metres.
    pub height_m: f64,
}

/// A mistake that explains what a curve lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// In words: the curve with it undone.
    pub words: String,
    /// Root mean square of what is lacking then, metres.
    pub left_m: f64,
}

/// What is lacking, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Root mean square about the mean of what the curve lacks, metres.
    pub rms_m: f64,
    /// How well the heights are known, metres.
    pub sigma_m: f64,
    /// The mistake without which they fit, if there is one.
    pub by: Option<Explained>,
}

/// Heights that scatter by so many of their sigmas contradict the tide.
const CONTRADICTED: f64 = 3.0;
/// A mistake explains them where they scatter by fewer than so many without it, and by less than a third of before.
const EXPLAINED: f64 = 1.5;
const SHARE: f64 = 1.0 / 3.0;
/// Of a foot, metres.
const FOOT_M: f64 = 0.3048;
/// Clocks that are wrong by whole hours: time zones and summer time.
const HOURS: i32 = 14;
/// Mistakes that leave less than so many times the least explain as much.
const ALIKE: f64 = 1.4;

/// Whether heights that are known to `sigma_m` contradict a curve, and which mistake explains them.
#[must_use]
pub fn contradiction(
    curve: &TideCurve,
    lacking: &[Lacking],
    sigma_m: f64,
) -> Option<Contradiction> {
    let rms_m = scatter_m(lacking.iter().map(|l| l.height_m));
    if lacking.len() < 2 || rms_m <= CONTRADICTED * sigma_m {
        return None;
    }
    let most_m = (EXPLAINED * sigma_m).min(SHARE * rms_m);
    let tried = mistakes().filter_map(|(words, height_m)| {
        let left = lacking.iter().map(|l| {
            let due_m = height_m(curve, l.time_s)? - curve.at(l.time_s);
            Some(l.height_m - due_m)
        });
        let left_m = scatter_m(left.collect::<Option<Vec<f64>>>()?.into_iter());
        Some(Explained { words, left_m })
    });
    let tried: Vec<Explained> = tried.collect();
    let best_m = tried.iter().fold(f64::INFINITY, |m, e| m.min(e.left_m));
    // of mistakes that explain as much the plainest: half a period is nearly a sign
    let nearly_m = (ALIKE * best_m).max(0.3 * sigma_m).min(most_m);
    Some(Contradiction {
        rms_m,
        sigma_m,
        by: tried.into_iter().find(|e| e.left_m <= nearly_m),
    })
}

/// The curve with a mistake undone; nothing where it does not reach.
type Undone = Box<dyn Fn(&TideCurve, f64) -> Option<f64>>;

fn mistakes() -> impl Iterator<Item = (String, Undone)> {
    let sized = |words: &str, factor: f64| -> (String, Undone) {
        let undone = move |curve: &TideCurve, t: f64| Some(factor * curve.at(t));
        (words.to_owned(), Box::new(undone) as Undone)
    };
    let moved = |hours: i32| -> (String, Undone) {
        let words = match hours {
            1.. => format!(
                "made {hours} h earlier: its times are too late (a time zone, summer time?)"
            ),
            _ => format!(
                "made {} h later: its times are too early (a time zone, summer time?)",
                -hours
            ),
        };
        let by_s = 3600.0 * f64::from(hours);
        let undone = move |curve: &TideCurve, t: f64| {
            let then = t + by_s;
            curve.covers([then, then]).then(|| curve.at(then))
        };
        (words, Box::new(undone) as Undone)
    };
    let sizes = [
        sized(
            "reversed in sign: heights of the water are positive upwards",
            -1.0,
        ),
        sized("taken as feet: give metres", FOOT_M),
        sized(
            "taken as metres in place of feet: a conversion too many",
            1.0 / FOOT_M,
        ),
        sized("left out", 0.0),
    ];
    sizes
        .into_iter()
        .chain((1..=HOURS).flat_map(|h| [h, -h]).map(moved))
}

/// Root mean square about the mean.
fn scatter_m(heights_m: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = heights_m.collect();
    let n = all.len().max(1) as f64;
    let mean = all.iter().sum::<f64>() / n;
    let squares = all.iter().map(|h| (h - mean).powi(2)).sum::<f64>();
    (squares / (n - 1.0).max(1.0)).sqrt()
}

/// How well the heights of the lines are known, root mean square: datum or tide, and the drift, metres.
#[must_use]
pub fn known_m(scene: &Scene) -> f64 {
    let squares = scene.lines.iter().map(|l| l.height_sigma_m.powi(2));
    let of_lines = squares.sum::<f64>() / scene.lines.len().max(1) as f64;
    (of_lines + scene.ins.height_drift_m.powi(2)).sqrt()
}

/// What the heights of the lines, as a joint solution found them, say of the tide; nothing where they are as well known as the survey claims.
#[must_use]
pub fn doubted(scene: &Scene, joint: &Joint) -> Option<Finding> {
    // the drift takes its share of what lifts a line
    let drift_m = scene.ins.height_drift_m;
    let whole = |sigma_m: f64| 1.0 + (drift_m / sigma_m).powi(2);
    let lines = scene.lines.iter().enumerate();
    let lacking: Vec<Lacking> = lines
        .map(|(k, line)| Lacking {
            time_s: f64::midpoint(line.start_s, line.end_s),
            height_m: joint.line_height_m(k) * whole(line.height_sigma_m),
        })
        .collect();
    let sigma_m = known_m(scene);
    let stated = TideCurve::default();
    let curve = scene.water.tide.curve.as_ref();
    // heights above the ellipsoid have the tide in them, whatever the curve says
    let curve = curve.filter(|_| scene.water.tide.lifts);
    let found = contradiction(curve.unwrap_or(&stated), &lacking, sigma_m)?;
    let known = format!(
        "the heights of the lines come out {:.2} m apart (root mean square), although they are known to {sigma_m:.2} m",
        found.rms_m
    );
    let by = found.by.filter(|_| curve.is_some());
    let (code, seen, advice) = match by {
        Some(by) => (
            "tide",
            format!(
                "{known}; {:.2} m is left of it with the tide {}",
                by.left_m, by.words
            ),
            "check sign, unit and clock of the tide curve",
        ),
        None => (
            "line_heights",
            known,
            "check the tide and the datum of the lines, or state how well they are known (line_height_sigma_m of [site])",
        ),
    };
    let limit = format!("{CONTRADICTED} times");
    Some(Finding::new(code, Severity::Finding, seen, limit, advice))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::seabed::Scene;
    use crate::procedures::seabed::model::{Locator, Values};
    use crate::procedures::seabed::simulate::{Acts, simulate};
    use crate::procedures::seabed::states::States;
    use crate::procedures::seabed::survey::load::scene_of;
    use crate::procedures::seabed::survey::{parse_scenario, write};

    /// 6 m from low to high water, high at 20 000 s, a row every ten minutes.
    fn curve() -> TideCurve {
        TideCurve::of_one_period((6.0, 44_714.0, 20_000.0), 600.0, [0.0, 60_000.0])
    }

    /// What is said of a curve with a mistake in it, by heights of `n` moments 150 s apart that are right.
    fn said(wrong: impl Fn(f64, f64) -> (f64, f64), begin_s: f64, n: u32) -> Option<Contradiction> {
        let right = curve();
        let rows = right.time_s.iter().zip(&right.height_m);
        let (time_s, height_m) = rows.map(|(t, h)| wrong(*t, *h)).unzip();
        let given = TideCurve { time_s, height_m };
        let lacking = |k: u32| {
            let time_s = begin_s + 150.0 * f64::from(k);
            // a datum of its own, and a centimetre of noise
            let off_m = 40.0 + 0.01 * f64::from(k % 3);
            Lacking {
                time_s,
                height_m: off_m + right.at(time_s) - given.at(time_s),
            }
        };
        let all: Vec<Lacking> = (0..n).map(lacking).collect();
        contradiction(&given, &all, 0.03)
    }

    fn words(found: Option<Contradiction>) -> String {
        found
            .and_then(|c| c.by)
            .map_or(String::new(), |by| by.words)
    }

    #[test]
    fn a_mistake_in_a_tide_is_named_and_a_right_one_contradicts_nothing() {
        assert_eq!(said(|t, h| (t, h), 30_000.0, 12), None);
        // a datum is no mistake
        assert_eq!(said(|t, h| (t, h + 3.0), 30_000.0, 12), None);
        assert!(words(said(|t, h| (t, -h), 30_000.0, 12)).starts_with("reversed in sign"));
        assert!(words(said(|t, h| (t, h / FOOT_M), 30_000.0, 12)).starts_with("taken as feet"));
        assert!(
            words(said(|t, h| (t, h * FOOT_M), 30_000.0, 12)).contains("a conversion too many")
        );
        // towards high water an hour makes another slope
        assert!(words(said(|t, h| (t + 3600.0, h), 17_500.0, 12)).starts_with("made 1 h earlier"));
        assert!(words(said(|t, h| (t - 7200.0, h), 17_500.0, 12)).starts_with("made 2 h later"));
        // at half tide it makes next to none, and moves all lines alike
        assert_eq!(said(|t, h| (t + 3600.0, h), 30_000.0, 4), None);
        // nothing of all this: said without a cause
        let odd = said(
            |t, h| (t, h + 0.4 * (t / 600.0).rem_euclid(2.0)),
            30_000.0,
            12,
        );
        assert!(odd.is_some_and(|c| c.by.is_none()));
    }

    /// A survey whose water rises by half a metre an hour, its heights above the ellipsoid or above the water.
    fn scene(heights: &str, with_tide: bool) -> Scene {
        let tide = "[tide]\nrange_m = 8.0\nhigh_water_s = 11000\n\n[errors]";
        let text = include_str!("../../../models/scenarios/seabed-thin.toml")
            .replace("[errors]", tide)
            .replace("seed = 1\n", "seed = 1\nformat = \"kmall\"\n")
            .replace(
                "[trajectory]\n",
                &format!("[trajectory]\nheights = \"{heights}\"\n"),
            );
        let scenario = parse_scenario(std::path::Path::new("thin"), &text).expect("a scenario");
        let survey = simulate(&scenario, 1, Acts::NONE);
        scene_of(
            &write::survey_file(&scenario, &survey),
            &write::trajectory(&scenario, &survey),
            &[write::profile(&scenario, &survey)],
            write::tide(&scenario, &survey, 0.0).filter(|_| with_tide),
            &write::soundings(&scenario, &survey.shots),
        )
    }

    /// Heights above the water and the tide of a sounding's own moment make its height above the ellipsoid, to a straight line's error
    /// over ten minutes (0.9 mm for 4 m); without the tide they lack it.
    #[test]
    fn a_sounding_is_lifted_by_the_tide_of_its_moment() {
        let [whole, lifted, bare] = [("ellipsoid", true), ("heave", true), ("heave", false)]
            .map(|(heights, tide)| scene(heights, tide));
        let heights = |scene: &Scene, k: usize| {
            let states = States::new(&scene.lines, &scene.ins, &scene.drift);
            let values = Values::nominal(scene, &states);
            let locator = Locator::new(scene, &states, &values).expect("a profile");
            let found = locator.locate(k).expect("a point");
            (found.point_m.z, found.depth_m)
        };
        for k in (0..whole.soundings.len()).step_by(1117) {
            let time_s = whole.soundings[k].time_s;
            let tide_m =
                4.0 * crate::math::cos(std::f64::consts::TAU * (time_s - 12_000.0) / 44_714.0);
            let ((z, depth), (lifted_z, lifted_depth)) = (heights(&whole, k), heights(&lifted, k));
            assert!(
                (z - lifted_z).abs() < 1e-3 && (depth - lifted_depth).abs() < 1e-3,
                "{k}"
            );
            let (bare_z, bare_depth) = heights(&bare, k);
            assert!(
                (z - bare_z - tide_m).abs() < 1e-3,
                "{k}: {z} {bare_z} {tide_m}"
            );
            assert!((bare_depth - depth).abs() < 1e-3, "{k}");
        }
        assert!((whole.water.transducer_m - lifted.water.transducer_m).abs() < 1e-3);
    }
}
