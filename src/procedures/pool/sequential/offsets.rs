//! Step 4: the lever arm's corrections along X, Z and Y, scanner minus multibeam.

use nalgebra::Vector3;

use super::{RoleSoundings, ScannerPlanes, SequentialError};
use crate::geometry::PlaneFit;

/// Smallest Y component of P1's normal that still gives a Y.
const LEAST_SLANT: f64 = 0.1;

/// Axis of the target frame along which an offset is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Away from the boat through the wall.
    X,
    /// Along the wall.
    Y,
    /// Up.
    Z,
}

/// One offset found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetStep {
    /// Axis of the target frame.
    pub axis: Axis,
    /// Offset along it, scanner minus multibeam, metres.
    pub offset_m: f64,
    /// What was added to the lever arm: the offset carried into the body frame, metres.
    pub body_m: Vector3<f64>,
}

impl OffsetStep {
    /// Finds the offset and carries it into the body with the mean attitude of the soundings used.
    ///
    /// # Errors
    /// [`SequentialError`] naming the plane that is missing.
    pub fn find(
        axis: Axis,
        scanner: &ScannerPlanes,
        soundings: &RoleSoundings,
    ) -> Result<Self, SequentialError> {
        let offset_m = offset_m(axis, scanner, soundings)?;
        let (direction, attitude) = match axis {
            Axis::X => (Vector3::x(), soundings.p2.mean_attitude("P2")?),
            Axis::Y => (Vector3::y(), soundings.p1.mean_attitude("P1")?),
            Axis::Z => (
                Vector3::z(),
                soundings.level().mean_attitude("the horizontal faces")?,
            ),
        };
        Ok(Self {
            axis,
            offset_m,
            body_m: attitude.tr_mul(&(direction * offset_m)),
        })
    }
}

/// Offset along an axis of the target frame, scanner minus multibeam, metres.
///
/// # Errors
/// [`SequentialError`] naming the plane that is missing.
pub fn offset_m(
    axis: Axis,
    scanner: &ScannerPlanes,
    soundings: &RoleSoundings,
) -> Result<f64, SequentialError> {
    match axis {
        Axis::X => Ok(scanner.wall_mean_x_m - soundings.p2.mean_m("P2")?.x),
        Axis::Y => along_y_m(scanner, soundings),
        Axis::Z => {
            Ok(above_design_of_returns_m(scanner)? - above_design_of_soundings_m(soundings)?)
        }
    }
}

/// \[0040\]: the P1 lines of both sensors, cut with the line parallel to Y at the mean X of P1's soundings.
fn along_y_m(scanner: &ScannerPlanes, soundings: &RoleSoundings) -> Result<f64, SequentialError> {
    let multibeam = soundings.p1.plane("P1", &scanner.p1.plane.normal)?;
    let x_m = multibeam.centroid_m.x;
    Ok(cut_at_m("scanner", &scanner.p1, x_m)? - cut_at_m("multibeam", &multibeam, x_m)?)
}

/// Y of the plane's line in plan at this X. The line is taken at the mean height of the plane's own points, as if they
/// were projected to the floor, so that a remaining tilt is not carried over the height between the sensors' points.
fn cut_at_m(sensor: &'static str, fit: &PlaneFit, x_m: f64) -> Result<f64, SequentialError> {
    let n = fit.plane.normal;
    if n.y.abs() < LEAST_SLANT {
        return Err(SequentialError::ParallelToY { sensor, found: n.y });
    }
    Ok(fit.centroid_m.y - n.x / n.y * (x_m - fit.centroid_m.x))
}

/// \[0039\]: mean height of the returns less their faces' design heights, each return counted once.
fn above_design_of_returns_m(scanner: &ScannerPlanes) -> Result<f64, SequentialError> {
    let pairs = scanner
        .horizontal
        .iter()
        .map(|h| (h.mean_height_m - h.design_height_m, h.count));
    weighted_mean(pairs).ok_or(SequentialError::NoHorizontalReturns)
}

/// The same of the soundings.
fn above_design_of_soundings_m(soundings: &RoleSoundings) -> Result<f64, SequentialError> {
    let all = soundings.level();
    let height_m = all.mean_m("the horizontal faces")?.z;
    let design = soundings
        .horizontal
        .iter()
        .map(|h| (h.design_height_m, h.soundings.count()));
    Ok(height_m - weighted_mean(design).unwrap_or(0.0))
}

fn weighted_mean(pairs: impl Iterator<Item = (f64, usize)>) -> Option<f64> {
    let (sum, count) = pairs.fold((0.0, 0), |(s, n), (value, count)| {
        (s + value * count as f64, n + count)
    });
    (count > 0).then(|| sum / count as f64)
}
