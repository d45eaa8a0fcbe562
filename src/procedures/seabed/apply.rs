//! All soundings of a survey under a calibration, line after line: the INS as it measured, the profile as it was cast. Mounting and
//! latency are the calibration's, and so are the heave channel's scale and lag and the heights of the lines, which keep the lines from
//! standing apart; drift of the INS is not applied.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::model::{Locator, Values};
use super::scene::{Head, Scene, Sounding};
use super::screen::Screen;
use super::states::States;
use super::survey::LoadedSeabed;
use crate::calibrate::cloud::{CHUNK, Calibrated, Cloud, Placed};
use crate::formats::las::stream::is_standard_time;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::frames::{Point, Target};
use crate::observe::Mounting;

/// The points of a survey; the site's origin is their middle.
///
/// # Errors
/// [`OtherHeads`].
pub fn cloud<'s>(
    survey: &'s LoadedSeabed,
    calibrated: &Calibrated,
) -> Result<Cloud<'s>, OtherHeads> {
    let scene = &survey.scene;
    let mountings = of_heads(scene, calibrated)?;
    let site = &survey.file.site;
    let pose = TargetPose {
        ellipsoid: site.ellipsoid,
        origin: site.origin.geodetic(),
        azimuth_rad: 0.0,
    };
    let under = Under::new(scene, calibrated, mountings);
    let widest_rad = survey.file.multibeam.max_angle_deg.to_radians();
    let line = move |rows| chunks(placed(scene, &under, &pose, widest_rad, rows));
    Ok(Cloud {
        ellipsoid: pose.ellipsoid,
        middle: pose.origin,
        standard_time: scene
            .soundings
            .first()
            .is_some_and(|s| is_standard_time(&[s.time_s])),
        total: scene.soundings.len(),
        sources: scene.lines.iter().map(|l| l.name.clone()).collect(),
        chunks: Box::new(lines(scene).into_iter().flat_map(line).map(Ok)),
    })
}

/// A calibration that lacks a head of the survey.
#[derive(Debug, thiserror::Error)]
#[error("the survey has {wanted}, and the solution has {found}: each head needs its own mounting")]
pub struct OtherHeads {
    wanted: String,
    found: String,
}

/// The mounting of each head of the survey: of its name, or the only one where there is one on either side.
fn of_heads(scene: &Scene, calibrated: &Calibrated) -> Result<Vec<Mounting>, OtherHeads> {
    if scene.heads.len() == 1 && calibrated.heads.len() < 2 {
        return Ok(vec![calibrated.sensor.mounting]);
    }
    let own = |head: &Head| {
        let is_own = |found: &&(String, Mounting)| found.0 == head.name();
        Some(calibrated.heads.iter().find(is_own)?.1)
    };
    let all: Option<Vec<Mounting>> = scene.heads.iter().map(own).collect();
    let names = |all: Vec<String>| all.join(", ");
    all.ok_or_else(|| OtherHeads {
        wanted: names(scene.heads.iter().map(Head::name).collect()),
        found: names(calibrated.heads.iter().map(|h| h.0.clone()).collect()),
    })
}

/// What holds for a whole survey under a calibration.
struct Under {
    states: States,
    values: Values,
}

impl Under {
    fn new(scene: &Scene, calibrated: &Calibrated, mountings: Vec<Mounting>) -> Self {
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        let sensor = &calibrated.sensor;

        let mut values = Values {
            mountings,
            latency_s: sensor.latency_s,
            range_scale: sensor.range_scale,
            heave_scale: calibrated.heave_scale,
            heave_lag_s: calibrated.heave_lag_s,
            ..Values::nominal(scene, &states)
        };
        for (k, line) in scene.lines.iter().enumerate() {
            let height_m = calibrated.line_heights_m.get(&line.name);
            values.states[states.height_of(k)] = height_m.copied().unwrap_or(0.0);
        }
        Self { states, values }
    }
}

/// The soundings of each line.
fn lines(scene: &Scene) -> Vec<std::ops::Range<usize>> {
    let mut begin = 0;
    let of_line = |line: &[Sounding]| {
        let rows = begin..begin + line.len();
        begin = rows.end;
        rows
    };
    let by_line = scene.soundings.chunk_by(|a, b| a.line == b.line);
    by_line.map(of_line).collect()
}

fn chunks(points: Vec<Placed>) -> impl Iterator<Item = Vec<Placed>> {
    let mut rest = points.into_iter();
    std::iter::from_fn(move || {
        let chunk: Vec<Placed> = rest.by_ref().take(CHUNK).collect();
        (!chunk.is_empty()).then_some(chunk)
    })
}

/// The soundings of a line; those within the widest angle that lie on the line's own surface are marked.
fn placed(
    scene: &Scene,
    under: &Under,
    pose: &TargetPose,
    widest_rad: f64,
    rows: std::ops::Range<usize>,
) -> Vec<Placed> {
    let Some(locator) = Locator::new(scene, &under.states, &under.values) else {
        return vec![];
    };
    let points: Vec<Option<Vector3<f64>>> = rows
        .clone()
        .into_par_iter()
        .map(|k| locator.locate(k).map(|l| l.point_m))
        .collect();
    let narrow = |(k, point): (usize, &Option<Vector3<f64>>)| {
        point.filter(|_| scene.aside_rad(k).abs() <= widest_rad)
    };
    let inside: Vec<_> = rows.clone().zip(&points).map(narrow).collect();
    let screen = Screen::for_depth(scene.typical_depth_m());
    let (mut kept, mut begin) = (vec![], 0);
    let one = |a: &Sounding, b: &Sounding| a.head == b.head;
    for strip in scene.soundings[rows.clone()].chunk_by(one) {
        let end = begin + strip.len();
        kept.extend(screen.keep(&inside[begin..end], (rows.start + begin) as u64));
        begin = end;
    }
    let to_ecef = pose.ecef_from_target();
    let place = |((k, point), on_surface): ((usize, Option<Vector3<f64>>), bool)| {
        let sounding = &scene.soundings[k];
        Some(Placed {
            time_s: sounding.time_s,
            position: to_ecef * Point::<Target>::new(point?),
            source: sounding.line + 1,
            row: sounding.row,
            sounding: true,
            on_surface,
            beam: Some(sounding.beam),
        })
    };
    let mut all: Vec<Placed> = rows.zip(points).zip(kept).filter_map(place).collect();
    // the heads of a line one after the other, its points in order of time
    if scene.heads.len() > 1 {
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    all
}
