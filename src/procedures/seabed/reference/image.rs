//! One line's seabed as an image: heights on a regular grid, grey levels of them, and heights back from a place in the image.
//!
//! Equations (12) to (15) of Li 2019. Rows run against a course that all images of a survey share, columns to the right of it; a node
//! without soundings near it is a hole.

use nalgebra::{Vector2, Vector3};

use crate::math;
use crate::stats::mad_sigma;

/// How heights become grey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grey {
    /// The whole range of heights on 256 levels, as the paper has it.
    Depth,
    /// Heights less their mean over a window, three standard deviations either way on 256 levels.
    Relief,
}

/// Side of the window whose mean is the plain ground under the relief, in cells.
const PLAIN_CELLS: usize = 23;
/// Nodes of an image at most; a longer line gets wider cells.
const MOST_NODES: f64 = 1.5e6;
/// Soundings reach nodes so many cells away.
const REACH_CELLS: f64 = 1.5;
/// Grey of a hole: the middle.
const HOLE_GREY: f32 = 128.0;

/// Side of a cell, metres: mean of the spacing along and across the track at a third of the swath (12), (13).
#[must_use]
pub fn cell_side_m(along_m: f64, depth_m: f64, swath_rad: f64, beams: u32) -> f64 {
    let (at, step) = (swath_rad / 3.0, swath_rad / f64::from(beams.max(1)));
    let across_m = depth_m * (math::tan(at + step) - math::tan(at));
    0.5 * (along_m + across_m)
}

/// A line's seabed on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Unit vector up the image, east and north.
    up: Vector2<f64>,
    /// To the right and up to the first node, metres.
    corner_m: Vector2<f64>,
    /// Height of each node, metres; not a number in a hole.
    heights_m: Vec<f32>,
    /// Nearest point of each node; none in a hole.
    nearest: Vec<u32>,
}

impl Image {
    /// Of these points by inverse squared distances, `up` a unit vector of east and north; nothing without points.
    #[must_use]
    pub fn new(points_m: &[Vector3<f64>], wanted_m: f64, up: Vector2<f64>) -> Option<Self> {
        let turned = || points_m.iter().map(|p| turned(&up, &p.xy()));
        let low = turned().reduce(|a, b| a.inf(&b))?;
        let high = turned().reduce(|a, b| a.sup(&b))?;
        let span = high - low;
        let cell_m = wanted_m.max((span.x * span.y / MOST_NODES).sqrt());
        let size = |length_m: f64| (length_m / cell_m).ceil() as usize + 1;
        let (width, height) = (size(span.x), size(span.y));
        let mut image = Self {
            width,
            height,
            cell_m,
            up,
            corner_m: Vector2::new(low.x, high.y),
            heights_m: vec![],
            nearest: vec![u32::MAX; width * height],
        };
        image.interpolate(points_m);
        Some(image)
    }

    fn interpolate(&mut self, points_m: &[Vector3<f64>]) {
        let nodes = self.width * self.height;
        let (mut weights, mut sums) = (vec![0.0_f64; nodes], vec![0.0_f64; nodes]);
        let mut closest = vec![f64::INFINITY; nodes];
        for (k, point) in points_m.iter().enumerate() {
            let at = self.pixel(&point.xy());
            for (node, square) in self.near(&at) {
                let weight = 1.0 / (square + 1e-4);
                weights[node] += weight;
                sums[node] += weight * point.z;
                if square < closest[node] {
                    closest[node] = square;
                    self.nearest[node] = k as u32;
                }
            }
        }
        let mean = |(sum, weight): (f64, f64)| (sum / weight) as f32;
        self.heights_m = sums.into_iter().zip(weights).map(mean).collect();
    }

    /// Nodes within reach of a place in the image, and their squared distances in cells.
    fn near(&self, at: &Vector2<f64>) -> impl Iterator<Item = (usize, f64)> + use<> {
        let (width, height, at) = (self.width, self.height, *at);
        let range = |x: f64, most: usize| {
            let first = (x - REACH_CELLS).ceil().max(0.0) as usize;
            let last = (x + REACH_CELLS).floor().min(most as f64 - 1.0) as usize;
            first..last + 1
        };
        let columns = range(at.x, width);
        range(at.y, height)
            .flat_map(move |row| columns.clone().map(move |column| (row, column)))
            .map(move |(row, column)| {
                let off = Vector2::new(column as f64, row as f64) - at;
                (row * width + column, off.norm_squared())
            })
            .filter(|(_, square)| *square <= REACH_CELLS * REACH_CELLS)
    }

    /// Column and row of a place, east and north, metres.
    fn pixel(&self, place_m: &Vector2<f64>) -> Vector2<f64> {
        let off = turned(&self.up, place_m) - self.corner_m;
        Vector2::new(off.x, -off.y) / self.cell_m
    }

    /// East and north of a place in the image (14), metres.
    #[must_use]
    pub fn place_m(&self, column: f64, row: f64) -> Vector2<f64> {
        let [right_m, up_m] = (self.corner_m + Vector2::new(column, -row) * self.cell_m).into();
        self.up * up_m + Vector2::new(self.up.y, -self.up.x) * right_m
    }

    fn is_hole(&self, node: usize) -> bool {
        self.nearest[node] == u32::MAX
    }

    /// Point of the seabed at a place in the image, its height by inverse squared distances to the four nodes around it (14), (15), and
    /// the number of the nearest sounding; nothing beside a hole.
    #[must_use]
    pub fn point(&self, column: f64, row: f64) -> Option<(Vector3<f64>, usize)> {
        let (left, top) = (column.floor(), row.floor());
        let inside = left >= 0.0
            && top >= 0.0
            && (left as usize) + 1 < self.width
            && (top as usize) + 1 < self.height;
        if !inside {
            return None;
        }
        let (mut weights, mut sum, mut best) = (0.0, 0.0, (f64::INFINITY, 0));
        for (down, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (x, y) = (left as usize + right, top as usize + down);
            let node = y * self.width + x;
            if self.is_hole(node) {
                return None;
            }
            let square = (x as f64 - column).powi(2) + (y as f64 - row).powi(2);
            let weight = 1.0 / (square + 1e-9);
            weights += weight;
            sum += weight * f64::from(self.heights_m[node]);
            if square < best.0 {
                best = (square, self.nearest[node] as usize);
            }
        }
        let place = self.place_m(column, row);
        Some((Vector3::new(place.x, place.y, sum / weights), best.1))
    }

    /// The image in grey levels, 0 to 255.
    #[must_use]
    pub fn grey(&self, how: Grey) -> Vec<f32> {
        match how {
            Grey::Depth => self.by_depth(),
            Grey::Relief => self.by_relief(),
        }
    }

    fn by_depth(&self) -> Vec<f32> {
        let there = || self.heights_m.iter().copied().filter(|z| z.is_finite());
        let (low, high) = (
            there().fold(f32::INFINITY, f32::min),
            there().fold(f32::NEG_INFINITY, f32::max),
        );
        let level = |z: &f32| level((z - low) / (high - low).max(f32::MIN_POSITIVE));
        self.heights_m.iter().map(level).collect()
    }

    fn by_relief(&self) -> Vec<f32> {
        let plain = Sums::new(self);
        let relief: Vec<f32> = (0..self.heights_m.len())
            .map(|node| self.heights_m[node] - plain.mean(node % self.width, node / self.width))
            .collect();
        // where the plain runs out of the image its mean is off: the spread is that of the most
        let there = relief.iter().copied().filter(|r| r.is_finite());
        let mut there: Vec<f64> = there.map(f64::from).collect();
        let sigma = mad_sigma(&mut there).unwrap_or(0.0) as f32;
        let level = |r: &f32| level(0.5 + r / (6.0 * sigma.max(f32::MIN_POSITIVE)));
        relief.iter().map(level).collect()
    }
}

/// How far a place lies to the right of and along a unit vector.
fn turned(up: &Vector2<f64>, place_m: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(up.y * place_m.x - up.x * place_m.y, up.dot(place_m))
}

/// Grey level of a share of the range; the middle for none.
fn level(share: f32) -> f32 {
    if share.is_finite() {
        (share.clamp(0.0, 1.0) * 255.0).round()
    } else {
        HOLE_GREY
    }
}

/// Sums over rectangles from the first node on, holes left out.
struct Sums {
    width: usize,
    height: usize,
    all: Vec<(f64, f64)>,
}

impl Sums {
    fn new(image: &Image) -> Self {
        let stride = image.width + 1;
        let mut all = vec![(0.0, 0.0); stride * (image.height + 1)];
        for row in 0..image.height {
            let mut run = (0.0, 0.0);
            for column in 0..image.width {
                let z = f64::from(image.heights_m[row * image.width + column]);
                if z.is_finite() {
                    run = (run.0 + z, run.1 + 1.0);
                }
                let above = all[row * stride + column + 1];
                all[(row + 1) * stride + column + 1] = (above.0 + run.0, above.1 + run.1);
            }
        }
        Self {
            width: image.width,
            height: image.height,
            all,
        }
    }

    /// Mean height about a node.
    fn mean(&self, column: usize, row: usize) -> f32 {
        let half = PLAIN_CELLS / 2;
        let (left, top) = (column.saturating_sub(half), row.saturating_sub(half));
        let right = (column + half + 1).min(self.width);
        let bottom = (row + half + 1).min(self.height);
        let at = |row: usize, column: usize| self.all[row * (self.width + 1) + column];
        let corners = [
            at(bottom, right),
            at(top, left),
            at(bottom, left),
            at(top, right),
        ];
        let part = |pick: fn(&(f64, f64)) -> f64| {
            let [a, b, c, d] = corners.each_ref().map(pick);
            a + b - c - d
        };
        (part(|c| c.0) / part(|c| c.1)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's example: 3.5 m/s at 25 Hz, 140 degrees, 256 beams, 14.2 m deep.
    #[test]
    fn the_cell_is_that_of_the_paper() {
        let cell_m = cell_side_m(3.5 / 25.0, 14.2, 140f64.to_radians(), 256);
        assert!((cell_m - 0.22).abs() < 0.005, "{cell_m}");
    }

    fn plane() -> Vec<Vector3<f64>> {
        let at = |k: usize| {
            let (x, y) = ((k % 50) as f64 * 0.2, (k / 50) as f64 * 0.2);
            Vector3::new(100.0 + x, 40.0 + y, -14.0 + 0.1 * x - 0.05 * y)
        };
        (0..2500).map(at).collect()
    }

    #[test]
    fn a_point_of_the_image_lies_on_the_bed_at_its_place() {
        let image = Image::new(&plane(), 0.2, Vector2::y()).expect("an image");
        assert_eq!((image.width, image.height), (50, 50));
        let (point, nearest) = image.point(20.3, 12.6).expect("inside");
        assert!((point.x - 104.06).abs() < 1e-9 && (point.y - 47.28).abs() < 1e-9);
        let due = -14.0 + 0.1 * 4.06 - 0.05 * 7.28;
        assert!((point.z - due).abs() < 0.01, "{point} {due}");
        assert_eq!(nearest, 36 * 50 + 20);
        assert_eq!(image.point(-0.1, 3.0), None);
    }

    /// Up the image is where the lines go; places stay where they are.
    #[test]
    fn a_turned_image_shows_the_same_places() {
        let up = Vector2::new(0.6, -0.8);
        let image = Image::new(&plane(), 0.2, up).expect("an image");
        let place = Vector2::new(104.0, 45.0);
        let pixel = image.pixel(&place);
        assert!((image.place_m(pixel.x, pixel.y) - place).norm() < 1e-9);
        let further = image.pixel(&(place + up));
        assert!((further - pixel - Vector2::new(0.0, -5.0)).norm() < 1e-9);
    }

    #[test]
    fn a_hole_gives_no_point_and_the_middle_grey() {
        let open = |p: &Vector3<f64>| math::hypot(p.x - 105.0, p.y - 45.0) > 1.5;
        let points: Vec<_> = plane().into_iter().filter(open).collect();
        let image = Image::new(&points, 0.2, Vector2::y()).expect("an image");
        let (column, row) = (25.0, 24.0);
        assert_eq!(image.point(column + 0.1, row + 0.1), None);
        for how in [Grey::Depth, Grey::Relief] {
            assert_eq!(image.grey(how)[24 * image.width + 25], HOLE_GREY);
        }
    }

    /// Ripples of 3 cm on a slope of 5 m: two grey levels of the whole range, most of them without the slope.
    #[test]
    fn relief_shows_what_the_range_of_depths_hides() {
        let rippled = |k: usize| {
            let (x, y) = ((k % 120) as f64 * 0.2, (k / 120) as f64 * 0.2);
            Vector3::new(x, y, -14.0 + 0.2 * x + 0.03 * math::sin(3.0 * y))
        };
        let points: Vec<_> = (0..14400).map(rippled).collect();
        let image = Image::new(&points, 0.2, Vector2::y()).expect("an image");
        let swing = |how: Grey| {
            let grey = image.grey(how);
            let column = (40..80).map(|row| grey[row * image.width + 60]);
            column.clone().fold(0.0, f32::max) - column.fold(255.0, f32::min)
        };
        let swings = [swing(Grey::Depth), swing(Grey::Relief)];
        assert!(swings[0] <= 4.0 && swings[1] > 50.0, "{swings:?}");
    }
}
