//! The tide that a survey file names: read, held against the lines' times and the boat's own heights.

use std::path::{Path, PathBuf};

use super::super::scene::{Line, Scene};
use super::super::tides::{Contradiction, Lacking, contradiction, known_m};
use super::file::{SeabedSurveyFile, TideSection};
use crate::formats::read_tide;
use crate::formats::recorder::utc;
use crate::observe::TideCurve;
use crate::stats::Moments;
use crate::survey::clock::{Span, shift_of};
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};

/// Longest step between two rows that is interpolated, seconds.
const LONGEST_STEP_S: f64 = 3600.0;
/// Pieces of a line whose heights are compared with the tide, seconds: waves have no mean over so long.
const PIECE_S: f64 = 60.0;

/// A tide of the survey file.
pub(super) struct Named<'f> {
    section: &'f TideSection,
    path: PathBuf,
}

/// The key under which it stands.
pub(super) const PATH: [&str; 2] = ["tide", "path"];

/// Lines with a tide of their own beside a curve.
pub(super) fn twice(file: &SeabedSurveyFile, document: &Document<'_>) -> Option<Problem> {
    file.tide.as_ref()?;
    let own = file.line.iter().find(|line| line.tide_m != 0.0)?;
    let found = format!("line \"{}\" with a tide_m, and [tide]", own.name);
    let expected = "one of the two: the tide over time, or one height of each line";
    Some(document.problem(&["line"], found, expected))
}

/// Reads the tide on the survey's clock, if there is one.
pub(super) fn read(
    file: &SeabedSurveyFile,
    folder: &Path,
) -> Result<Option<TideCurve>, SurveyError> {
    let Some(named) = Named::of(file, folder) else {
        return Ok(None);
    };
    let mut curve = read_tide(&named.path)?;
    for time_s in &mut curve.time_s {
        *time_s += named.section.time_offset_s;
    }
    none_of(named.uncovered(&curve, &file.lines()))?;
    none_of(named.too_wide(&curve, &file.lines()))?;
    Ok(Some(curve))
}

/// Holds the tide against the boat's own heights, where they have it, and says what it is on the lines.
pub(super) fn noted(
    file: &SeabedSurveyFile,
    folder: &Path,
    scene: &Scene,
) -> Result<Vec<String>, SurveyError> {
    let named = Named::of(file, folder).zip(scene.water.tide.curve.as_ref());
    let Some((named, curve)) = named else {
        return Ok(vec![]);
    };
    let mut notes = vec![named.said(curve, scene)];
    if !scene.water.tide.lifts {
        notes.extend(named.against_the_boat(curve, scene)?);
        none_of(named.dry(scene))?;
    }
    Ok(notes)
}

impl<'f> Named<'f> {
    fn of(file: &'f SeabedSurveyFile, folder: &Path) -> Option<Self> {
        let section = file.tide.as_ref()?;
        let path = folder.join(&section.path);
        Some(Self { section, path })
    }

    fn problem(&self, found: String, expected: String) -> Problem {
        Problem::new(&self.path, "column time_s", found, expected)
    }

    /// Lines that the curve does not reach, with the confusion of clocks that would explain it.
    fn uncovered(&self, curve: &TideCurve, lines: &[Line]) -> Vec<Problem> {
        let Some(tide) = Span::of(&curve.time_s) else {
            return vec![];
        };
        let outside = |line: &&Line| !curve.covers([line.start_s, line.end_s]);
        let problem = |line: &Line| {
            let span = Span {
                first_s: line.start_s,
                last_s: line.end_s,
            };
            let clocks = shift_of(&tide, &span).map_or(String::new(), |(shift_s, why)| {
                let offset_s = self.section.time_offset_s - shift_s;
                format!("; [tide] time_offset_s = {offset_s} would reach it: {why}")
            });
            let expected = format!(
                "times that cover line \"{}\", {}{clocks}",
                line.name,
                written(&span)
            );
            self.problem(format!("times from {}", written(&tide)), expected)
        };
        lines.iter().filter(outside).take(1).map(problem).collect()
    }

    /// Rows too far apart about a line.
    fn too_wide(&self, curve: &TideCurve, lines: &[Line]) -> Vec<Problem> {
        let wide = |line: &Line| {
            let (row, step_s) = curve.widest_step([line.start_s, line.end_s])?;
            (step_s > LONGEST_STEP_S).then(|| {
                let found = format!(
                    "a step of {:.1} h before {} s, where line \"{}\" is",
                    step_s / 3600.0,
                    curve.time_s[row],
                    line.name
                );
                let expected = "rows at most an hour apart: a straight line between high and low water is no tide";
                self.problem(found, expected.to_owned())
            })
        };
        lines.iter().find_map(wide).into_iter().collect()
    }

    /// What the tide is on the lines, what it does, and how straight it is between rows.
    fn said(&self, curve: &TideCurve, scene: &Scene) -> String {
        let of = |line: &Line| {
            let [begin, end] = [line.start_s, line.end_s].map(|t| curve.at(t));
            format!("{} {begin:.2} to {end:.2} m", line.name)
        };
        let each: Vec<String> = scene.lines.iter().map(of).collect();
        let does = match scene.water.tide.lifts {
            true => "heights of the heave are lifted by it moment by moment",
            false => {
                "heights above the ellipsoid have it already, the depth of the transducer in the profile follows it"
            }
        };
        let spans = scene.lines.iter().map(|l| [l.start_s, l.end_s]);
        let off = spans.filter_map(|span| curve.straightness_m(span));
        let straight = off.reduce(f64::max).map_or(String::new(), |off_m| {
            format!("; straight lines between its rows are off by up to {off_m:.3} m")
        });
        format!(
            "tide of {}: {}; {does}{straight}",
            self.section.path,
            each.join(", ")
        )
    }

    /// A tide by which the transducer is out of the water.
    fn dry(&self, scene: &Scene) -> Vec<Problem> {
        let depth_m = scene.median_depth_m();
        let out = depth_m.filter(|depth_m| *depth_m <= 0.0).map(|depth_m| {
            let found = format!(
                "a tide by which the transducer is {:.2} m above the water",
                -depth_m
            );
            let expected =
                "heights over [site] water_level_m, in metres, upwards, on the survey's clock";
            Problem::new(&self.path, "column height_m", found, expected)
        });
        out.into_iter().collect()
    }

    /// The boat floats on the tide: its heights above the ellipsoid, in pieces of a minute, less the curve are one constant.
    fn against_the_boat(
        &self,
        curve: &TideCurve,
        scene: &Scene,
    ) -> Result<Option<String>, SurveyError> {
        let sigma_m = known_m(scene);
        let lacking: Vec<Lacking> = pieces(scene)
            .map(|(time_s, height_m)| Lacking {
                time_s,
                height_m: height_m - curve.at(time_s),
            })
            .collect();
        let Some(Contradiction { rms_m, by, .. }) = contradiction(curve, &lacking, sigma_m) else {
            return Ok(None);
        };
        let found = format!(
            "the boat's heights above the ellipsoid go {rms_m:.2} m (root mean square) off it, known to {sigma_m:.2} m"
        );
        let Some(by) = by else {
            return Ok(Some(format!(
                "tide of {}: {found}; check which gauge and datum it is of",
                self.section.path
            )));
        };
        let expected = format!(
            "a tide that the boat floats on: {:.2} m is left with it {}",
            by.left_m, by.words
        );
        Err(Problem::new(&self.path, "column height_m", found, expected).into())
    }
}

/// Mean time and height of the boat in pieces of the lines, seconds and metres.
fn pieces(scene: &Scene) -> impl Iterator<Item = (f64, f64)> {
    let (times, places) = (scene.trajectory.times_s(), scene.trajectory.positions_m());
    scene.lines.iter().flat_map(move |line| {
        let count = ((line.end_s - line.start_s) / PIECE_S).round().max(1.0);
        let end_s = move |k: f64| line.start_s + (line.end_s - line.start_s) * k / count;
        (0..count as u32).filter_map(move |k| {
            let at = |t: f64| times.partition_point(|other| *other < t);
            let rows = at(end_s(f64::from(k)))..at(end_s(f64::from(k) + 1.0));
            let mut mean = Moments::new(2);
            for row in rows {
                mean.add(&[times[row], places[row].z]);
            }
            mean.mean().map(|m| (m[0], m[1]))
        })
    })
}

/// Seconds, and the date where they are such of UTC.
fn written(span: &Span) -> String {
    let dated = span.first_s > utc::GPS_EPOCH_S;
    let date = match dated {
        true => format!(
            " ({} to {})",
            utc::written(span.first_s),
            utc::written(span.last_s)
        ),
        false => String::new(),
    };
    format!("{} to {} s{date}", span.first_s, span.last_s)
}
