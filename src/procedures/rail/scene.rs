//! A campaign sorted by the table's positions.

use nalgebra::{Matrix3, Vector3};

use super::observed::RailCampaign;
use super::profile::RailProfile;
use crate::geometry::rotation;

/// A position at which the table was at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Turn about the vertical, radians, clockwise.
    pub heading_rad: f64,
    /// Turn about the lateral axis, radians, front up.
    pub pitch_rad: f64,
    /// Mean attitude of the INS there, body into level; `None` without a record.
    pub attitude: Option<Matrix3<f64>>,
    /// Records in the mean.
    pub records: usize,
}

/// A point and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Row of the campaign's points.
    pub row: u32,
    /// Index of the position.
    pub position: u32,
}

/// What both paths start from.
#[derive(Clone, Debug)]
pub struct RailScene<'a> {
    /// The observations.
    pub campaign: &'a RailCampaign,
    /// The standard profile.
    pub rail: &'a RailProfile,
    /// The table's positions, in time.
    pub positions: Vec<Position>,
    /// Points taken while the table was at rest, in the order of positions.
    pub points: Vec<Placed>,
    /// Points taken while the table turned: left out.
    pub turning: usize,
}

impl<'a> RailScene<'a> {
    /// Sorts the observations.
    #[must_use]
    pub fn new(campaign: &'a RailCampaign, rail: &'a RailProfile) -> Self {
        let place = |row: usize| campaign.table.at(campaign.points.time_s[row]);
        let mut points: Vec<Placed> = (0..campaign.points.len())
            .filter_map(|row| {
                let (row_, position) = (row as u32, place(row)? as u32);
                Some(Placed {
                    row: row_,
                    position,
                })
            })
            .collect();
        points.sort_by_key(|p| (p.position, p.row));
        Self {
            turning: campaign.points.len() - points.len(),
            positions: positions(campaign),
            points,
            campaign,
            rail,
        }
    }

    /// The position nearest to level.
    #[must_use]
    pub fn level_position(&self) -> usize {
        self.by_level().first().copied().unwrap_or(0)
    }

    /// Positions, nearest to level first.
    #[must_use]
    pub fn by_level(&self) -> Vec<usize> {
        let size =
            |k: &usize| self.positions[*k].heading_rad.abs() + self.positions[*k].pitch_rad.abs();
        let mut all: Vec<usize> = (0..self.positions.len()).collect();
        all.sort_by(|a, b| size(a).total_cmp(&size(b)));
        all
    }

    /// Points of one profiler at one position, in its frame.
    #[must_use]
    pub fn profile(&self, position: usize, profiler: usize) -> Vec<Vector3<f64>> {
        let first = self
            .points
            .partition_point(|p| (p.position as usize) < position);
        let here = self.points[first..]
            .iter()
            .take_while(|p| p.position as usize == position);
        let points = &self.campaign.points;
        here.map(|p| p.row as usize)
            .filter(|&row| points.profiler[row] as usize == profiler)
            .map(|row| points.point(row))
            .collect()
    }

    /// Range of the table's turns, radians: about the vertical, about the lateral axis; of positions with points only.
    #[must_use]
    pub fn turned_rad(&self) -> (f64, f64) {
        let used = |k: &usize| {
            self.points
                .binary_search_by_key(&(*k as u32), |p| p.position)
                .is_ok()
        };
        let places: Vec<usize> = (0..self.positions.len()).filter(used).collect();
        let range = |of: fn(&Position) -> f64| {
            let values = places.iter().map(|&k| of(&self.positions[k]));
            let low = values.clone().fold(f64::INFINITY, f64::min);
            (values.fold(f64::NEG_INFINITY, f64::max) - low).max(0.0)
        };
        (range(|p| p.heading_rad), range(|p| p.pitch_rad))
    }

    /// Attitude at a position by the INS, or by the table where the INS has no record there.
    #[must_use]
    pub fn attitude(&self, position: usize) -> Matrix3<f64> {
        let p = &self.positions[position];
        let heading = self.campaign.stand.rail_attitude_rad[2];
        p.attitude
            .unwrap_or_else(|| rotation::from_attitude(0.0, p.pitch_rad, heading + p.heading_rad))
    }
}

fn positions(campaign: &RailCampaign) -> Vec<Position> {
    let (table, record) = (&campaign.table, &campaign.attitude);
    let one = |k: usize| {
        let from = record.time_s.partition_point(|&t| t < table.from_s[k]);
        let to = record.time_s.partition_point(|&t| t <= table.to_s[k]);
        let attitudes = (from..to).map(|i| {
            rotation::from_attitude(
                record.roll_rad[i],
                record.pitch_rad[i],
                record.heading_rad[i],
            )
        });
        Position {
            heading_rad: table.heading_rad[k],
            pitch_rad: table.pitch_rad[k],
            attitude: mean(attitudes),
            records: to.saturating_sub(from),
        }
    };
    (0..table.len()).map(one).collect()
}

/// Mean of nearly equal rotations: the mean rotation vector from the first.
fn mean(mut rotations: impl Iterator<Item = Matrix3<f64>>) -> Option<Matrix3<f64>> {
    let first = rotations.next()?;
    let (mut sum, mut count) = (Vector3::zeros(), 1.0);
    for r in rotations {
        sum += rotation::log(&(r * first.transpose()));
        count += 1.0;
    }
    Some(rotation::exp(&(sum / count)) * first)
}
