//! All soundings of a survey under a calibration, line after line: the INS as it measured, the profile as it was cast. Mounting and
//! latency are the calibration's, and so are the heave channel's scale and lag and the heights of the lines, which keep the lines from
//! standing apart; drift of the INS is not applied.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::model::{Locator, Values};
use super::scene::Scene;
use super::screen::Screen;
use super::states::States;
use super::survey::LoadedSeabed;
use crate::calibrate::cloud::{CHUNK, Calibrated, Cloud, Placed};
use crate::formats::las::stream::is_standard_time;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::frames::{Point, Target};

/// The points of a survey; the site's origin is their middle.
#[must_use]
pub fn cloud<'s>(survey: &'s LoadedSeabed, calibrated: &Calibrated) -> Cloud<'s> {
    let scene = &survey.scene;
    let site = &survey.file.site;
    let pose = TargetPose {
        ellipsoid: site.ellipsoid,
        origin: site.origin.geodetic(),
        azimuth_rad: 0.0,
    };
    let under = Under::new(scene, calibrated);
    let widest_rad = survey.file.multibeam.max_angle_deg.to_radians();
    let line = move |rows| chunks(placed(scene, &under, &pose, widest_rad, rows));
    Cloud {
        ellipsoid: pose.ellipsoid,
        middle: pose.origin,
        standard_time: scene
            .soundings
            .first()
            .is_some_and(|s| is_standard_time(&[s.time_s])),
        total: scene.soundings.len(),
        sources: scene.lines.iter().map(|l| l.name.clone()).collect(),
        chunks: Box::new(lines(scene).into_iter().flat_map(line)),
    }
}

/// What holds for a whole survey under a calibration.
struct Under {
    states: States,
    values: Values,
}

impl Under {
    fn new(scene: &Scene, calibrated: &Calibrated) -> Self {
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        let sensor = &calibrated.sensor;
        let mut values = Values {
            mounting: sensor.mounting,
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
    let of_line = |line: &[super::scene::Sounding]| {
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
        point.filter(|_| scene.soundings[k].across_rad.abs() <= widest_rad)
    };
    let inside: Vec<_> = rows.clone().zip(&points).map(narrow).collect();
    let kept = Screen::for_depth(scene.typical_depth_m()).keep(&inside, rows.start as u64);
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
    rows.zip(points).zip(kept).filter_map(place).collect()
}
