//! All points of a survey under a calibration: both sensors' observations georeferenced, in order of time.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::PoolError;
use super::scene::Scene;
use super::summary::residuals::sounding_point;
use super::survey::LoadedSurvey;
use super::ties::PlacedBy;
use crate::calibrate::cloud::{Beam, CHUNK, Cloud, Placed, SensorModel};
use crate::calibrate::seam::InputError;
use crate::formats::las::stream::is_standard_time;
use crate::geometry::frames::{Point, Target};
use crate::georef::RayError;

/// The instrument that a point is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sensor {
    Laser,
    Multibeam,
}

/// The points of a survey; the target's origin is their middle.
///
/// # Errors
/// [`RayError`] when the sound speed or its profile cannot be used.
pub fn cloud<'s>(survey: &'s LoadedSurvey, model: &SensorModel) -> Result<Cloud<'s>, RayError> {
    let scene = Scene::prepare(&survey.campaign, &survey.target, &survey.pose)?;
    let soundings = &survey.campaign.soundings;
    Ok(Cloud {
        ellipsoid: scene.pose.ellipsoid,
        middle: scene.pose.origin,
        standard_time: is_standard_time(&soundings.span_s().unwrap_or_default()),
        total: survey.campaign.laser.len() + soundings.len(),
        sources: ["laser", "multibeam"].map(str::to_owned).to_vec(),
        chunks: Box::new(points(scene, *model)),
    })
}

/// Chunks of all points in order of time; where times are equal, laser first. Observations without a position are left out;
/// soundings that cannot be read again from their file are an error.
fn points(
    scene: Scene<'_>,
    model: SensorModel,
) -> impl Iterator<Item = Result<Vec<Placed>, InputError>> {
    let campaign = scene.campaign;
    let (laser, sonar) = (&campaign.laser.time_s, &campaign.soundings);
    let (mut j, mut k) = (0, 0);
    std::iter::from_fn(move || {
        let mut rows = Vec::with_capacity(CHUNK);
        while rows.len() < CHUNK && (j < laser.len() || k < sonar.len()) {
            let next_is_laser =
                k >= sonar.len() || laser.get(j).is_some_and(|t| *t <= sonar.at_s(k));
            if next_is_laser {
                rows.push((Sensor::Laser, j, laser[j]));
                j += 1;
            } else {
                rows.push((Sensor::Multibeam, k, sonar.at_s(k)));
                k += 1;
            }
        }
        (!rows.is_empty()).then(|| {
            let placed = placed(&scene, &model, &rows);
            // what could not be read had no place, or a wrong one in this order
            let fault = campaign.soundings.fault().cloned().map(PoolError::from);
            fault.map_or(Ok(placed), |fault| Err(InputError::unworkable(fault)))
        })
    })
}

fn placed(scene: &Scene<'_>, model: &SensorModel, rows: &[(Sensor, usize, f64)]) -> Vec<Placed> {
    let to_ecef = scene.pose.ecef_from_target();
    let soundings = &scene.campaign.soundings;
    let model = PlacedBy::from(*model);
    let place = |&(sensor, row, time_s): &(Sensor, usize, f64)| {
        let (in_target, source, beam): (Vector3<f64>, _, _) = match sensor {
            Sensor::Laser => (scene.laser_point(row)?.0, 1, None),
            Sensor::Multibeam => {
                let (ping, beam) = soundings.name(row);
                let at = sounding_point(scene, row, &model)?;
                (at, 2, Some(Beam { ping, beam }))
            }
        };
        Some(Placed {
            time_s,
            position: to_ecef * Point::<Target>::new(in_target),
            source,
            row: row as u32,
            sounding: beam.is_some(),
            on_surface: beam.is_some(),
            beam,
        })
    };
    rows.par_iter().filter_map(place).collect()
}
