//! Heights in square cells: mean, count and standard deviation, gathered point by point.

use std::collections::HashMap;

/// Sums of one cell; Welford's recurrence about the mean (*Technometrics* 4, 1962).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heights {
    /// How many.
    pub count: u32,
    /// Their mean, metres.
    pub mean_m: f64,
    about_mean_m2: f64,
}

impl Heights {
    fn add(&mut self, height_m: f64) {
        self.count += 1;
        let off = height_m - self.mean_m;
        self.mean_m += off / f64::from(self.count);
        self.about_mean_m2 += off * (height_m - self.mean_m);
    }

    /// Standard deviation about the mean, metres; `None` of fewer than two.
    #[must_use]
    pub fn deviation_m(&self) -> Option<f64> {
        let freedom = f64::from(self.count) - 1.0;
        (freedom > 0.0).then(|| (self.about_mean_m2 / freedom).sqrt())
    }
}

/// Cells that hold heights.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    cell_m: f64,
    cells: HashMap<[i64; 2], Heights>,
}

/// The rectangle of a grid's cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Column of the western and row of the northern edge.
    west_north: [i64; 2],
    /// Columns and rows.
    pub size: [u64; 2],
}

impl Grid {
    /// An empty one; its cells begin at multiples of their side.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        Self {
            cell_m,
            cells: HashMap::new(),
        }
    }

    /// Adds a point: two coordinates in the plane and a height, metres.
    pub fn add(&mut self, [x_m, y_m, height_m]: [f64; 3]) {
        let place = [x_m, y_m].map(|m| (m / self.cell_m).floor() as i64);
        self.cells.entry(place).or_default().add(height_m);
    }

    /// The rectangle that holds every cell; `None` of an empty grid.
    #[must_use]
    pub fn extent(&self) -> Option<Extent> {
        let bounds = |k: usize| {
            let all = || self.cells.keys().map(|cell| cell[k]);
            Some((all().min()?, all().max()?))
        };
        let ((west, east), (south, north)) = (bounds(0)?, bounds(1)?);
        Some(Extent {
            west_north: [west, north],
            size: [(east - west + 1) as u64, (north - south + 1) as u64],
        })
    }

    /// The north-western corner of an extent, metres.
    #[must_use]
    pub fn corner_m(&self, extent: &Extent) -> [f64; 2] {
        let [west, north] = extent.west_north;
        [west as f64 * self.cell_m, (north + 1) as f64 * self.cell_m]
    }

    /// Mean, count and standard deviation of every cell of an extent, row by row from the north; NaN where there is none.
    #[must_use]
    pub fn bands(&self, extent: &Extent) -> Vec<f32> {
        let [width, height] = extent.size;
        let mut all = vec![f32::NAN; 3 * (width * height) as usize];
        for ([column, row], heights) in &self.cells {
            let (across, down) = (column - extent.west_north[0], extent.west_north[1] - row);
            let at = 3 * (down as u64 * width + across as u64) as usize;
            all[at] = heights.mean_m as f32;
            all[at + 1] = heights.count as f32;
            all[at + 2] = heights.deviation_m().unwrap_or(f64::NAN) as f32;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_lie_in_their_cells_from_the_north() {
        let mut grid = Grid::new(2.0);
        assert!(grid.extent().is_none());
        for point in [[-0.5, 1.0, 4.0], [-1.5, 0.5, 5.0], [3.0, 3.9, 7.0]] {
            grid.add(point);
        }
        let extent = grid.extent().expect("cells");
        assert_eq!(extent.size, [3, 2]);
        assert_eq!(grid.corner_m(&extent), [-2.0, 4.0]);
        let bands = grid.bands(&extent);
        assert_eq!(bands.len(), 18);
        assert_eq!(bands[6..8], [7.0, 1.0]);
        assert!(bands[8].is_nan() && bands[0].is_nan() && bands[1].is_nan());
        assert_eq!(bands[9..12], [4.5, 2.0, 0.5f32.sqrt()]);
    }
}
