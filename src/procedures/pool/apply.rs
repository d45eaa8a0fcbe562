//! All points of a survey under a calibration: both sensors' observations georeferenced, in order of time.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::scene::Scene;
use super::summary::residuals::{Model, sounding_point};
use crate::geometry::frames::{Ecef, Point, Target};

/// Points georeferenced at a time.
const CHUNK: usize = 65_536;

/// The instrument that a point is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// The laser scanner.
    Laser,
    /// The multibeam.
    Multibeam,
}

/// A georeferenced point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeferenced {
    /// Its instrument.
    pub sensor: Sensor,
    /// Row of the raw observation.
    pub row: usize,
    /// Its stamp, seconds.
    pub time_s: f64,
    /// Where it is.
    pub position: Point<Ecef>,
}

/// Chunks of all points in order of time; where times are equal, laser first. Observations without a position are left out.
pub fn points<'s>(scene: &'s Scene, model: Model) -> impl Iterator<Item = Vec<Georeferenced>> + 's {
    let (laser, sonar) = (
        &scene.campaign.laser.time_s,
        &scene.campaign.soundings.time_s,
    );
    let (mut j, mut k) = (0, 0);
    std::iter::from_fn(move || {
        let mut rows = Vec::with_capacity(CHUNK);
        while rows.len() < CHUNK && (j < laser.len() || k < sonar.len()) {
            let next_is_laser = k >= sonar.len() || laser.get(j).is_some_and(|t| *t <= sonar[k]);
            if next_is_laser {
                rows.push((Sensor::Laser, j, laser[j]));
                j += 1;
            } else {
                rows.push((Sensor::Multibeam, k, sonar[k]));
                k += 1;
            }
        }
        (!rows.is_empty()).then(|| placed(scene, &model, &rows))
    })
}

fn placed(scene: &Scene, model: &Model, rows: &[(Sensor, usize, f64)]) -> Vec<Georeferenced> {
    let to_ecef = scene.pose.ecef_from_target();
    let place = |&(sensor, row, time_s): &(Sensor, usize, f64)| {
        let in_target: Vector3<f64> = match sensor {
            Sensor::Laser => scene.laser_point(row)?.0,
            Sensor::Multibeam => sounding_point(scene, row, model)?,
        };
        Some(Georeferenced {
            sensor,
            row,
            time_s,
            position: to_ecef * Point::<Target>::new(in_target),
        })
    };
    rows.par_iter().filter_map(place).collect()
}
