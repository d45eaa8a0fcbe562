//! A line's seabed in small cells, a plane in each: what two lines are compared by.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::tiles::{Cell, depth_scale};

/// Smallest side of a cell, metres, in 15 m of water and less.
const LEAST_CELL_M: f64 = 1.5;
/// Soundings of a line that a cell should have on the average: twice what its plane needs.
const PER_CELL: f64 = 12.0;

/// Smallest side of a cell at a depth, metres.
#[must_use]
pub fn least_cell_m(depth_m: f64) -> f64 {
    LEAST_CELL_M * depth_scale(depth_m)
}

/// Side of the cells in which so many soundings on this area make planes, metres.
#[must_use]
pub fn cell_side_m(area_m2: f64, soundings: usize) -> f64 {
    (PER_CELL * area_m2 / soundings.max(1) as f64).sqrt()
}

/// The planes of these points in cells of this side; cells with too few points have none.
#[must_use]
pub fn surfaces(points_m: &[Vector3<f64>], cell_m: f64) -> BTreeMap<Cell, Surface> {
    let mut cells: BTreeMap<Cell, Vec<Vector3<f64>>> = BTreeMap::new();
    for point in points_m {
        cells
            .entry(Cell::of(point, cell_m))
            .or_default()
            .push(*point);
    }
    let fit = |(cell, points): (Cell, Vec<Vector3<f64>>)| Some((cell, Surface::fit(&points)?));
    cells.into_iter().filter_map(fit).collect()
}

/// A plane of one line in one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Mean of its points, metres.
    pub centre: Vector3<f64>,
    slope: [f64; 2],
    /// Variance of its height in the middle, square metres.
    pub variance: f64,
}

impl Surface {
    /// Through at least six points that span two dimensions.
    #[must_use]
    pub fn fit(points: &[Vector3<f64>]) -> Option<Self> {
        if points.len() < 6 {
            return None;
        }
        let n = points.len() as f64;
        let centre = points.iter().sum::<Vector3<f64>>() / n;
        let mut scatter = Matrix3::zeros();
        for p in points {
            let off = p - centre;
            scatter += off * off.transpose();
        }
        let flat = scatter.fixed_view::<2, 2>(0, 0).into_owned();
        if flat.determinant() < 1e-3 * flat.trace().powi(2) {
            return None;
        }
        let slope = flat.try_inverse()? * scatter.fixed_view::<2, 1>(0, 2);
        let rest = scatter[(2, 2)] - slope.dot(&scatter.fixed_view::<2, 1>(0, 2));
        Some(Self {
            centre,
            slope: [slope[0], slope[1]],
            variance: (rest / (n - 3.0)).max(0.0) / n,
        })
    }

    /// Height at a place, metres.
    #[must_use]
    pub fn height_at(&self, p: &Vector3<f64>) -> f64 {
        self.centre.z
            + self.slope[0] * (p.x - self.centre.x)
            + self.slope[1] * (p.y - self.centre.y)
    }
}
