//! All soundings of a survey under a calibration, line after line: the INS as it measured, the profile as it was cast. Latency and
//! mounting are the calibration's; what was estimated only to keep the others honest (heave, drift, heights of the lines) is not applied.

use rayon::prelude::*;

use super::model::{Locator, Values};
use super::scene::Scene;
use super::states::States;
use super::survey::LoadedSeabed;
use crate::calibrate::cloud::{CHUNK, Cloud, Placed, SensorModel};
use crate::formats::las::stream::is_standard_time;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::frames::{Point, Target};

/// The points of a survey; the site's origin is their middle.
#[must_use]
pub fn cloud<'s>(survey: &'s LoadedSeabed, model: &SensorModel) -> Cloud<'s> {
    let scene = &survey.scene;
    let site = &survey.file.site;
    let pose = TargetPose {
        ellipsoid: site.ellipsoid,
        origin: site.origin.geodetic(),
        azimuth_rad: 0.0,
    };
    let states = States::new(&scene.lines, &scene.ins);
    let values = Values {
        mounting: model.mounting,
        latency_s: model.latency_s,
        range_scale: model.range_scale,
        ..Values::nominal(scene, &states)
    };
    let count = scene.soundings.len();
    let chunk = move |begin: usize| {
        let rows = begin..(begin + CHUNK).min(count);
        placed(scene, &states, &values, &pose, rows)
    };
    Cloud {
        ellipsoid: pose.ellipsoid,
        middle: pose.origin,
        standard_time: scene
            .soundings
            .first()
            .is_some_and(|s| is_standard_time(&[s.time_s])),
        total: count,
        sources: scene.lines.iter().map(|l| l.name.clone()).collect(),
        chunks: Box::new((0..count).step_by(CHUNK).map(chunk)),
    }
}

fn placed(
    scene: &Scene,
    states: &States,
    values: &Values,
    pose: &TargetPose,
    rows: std::ops::Range<usize>,
) -> Vec<Placed> {
    let Some(locator) = Locator::new(scene, states, values) else {
        return vec![];
    };
    let to_ecef = pose.ecef_from_target();
    let place = |k: usize| {
        let sounding = &scene.soundings[k];
        let at = locator.locate(k)?.point_m;
        Some(Placed {
            time_s: sounding.time_s,
            position: to_ecef * Point::<Target>::new(at),
            source: sounding.line + 1,
            row: sounding.row,
            sounding: true,
            beam: Some(sounding.beam),
        })
    };
    rows.into_par_iter().filter_map(place).collect()
}
