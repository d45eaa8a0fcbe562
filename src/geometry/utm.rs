//! Universal transverse Mercator, by the `geodesy` crate (Engsager and Poder 2007, sixth order).

use geodesy::prelude::{Context, Coor2D, Direction, Minimal, OpHandle};
use rayon::prelude::*;
use thiserror::Error;

use super::ellipsoid::{Ellipsoid, Geodetic};

/// Points handed to the projection at a time.
const CHUNK: usize = 4096;

/// Farthest a point may lie from the central meridian: more than twice the zone's width at the equator.
const FARTHEST_EASTING_M: f64 = 1.0e6;

/// Northing of a pole in its own hemisphere, rounded up: nothing lies beyond.
const FARTHEST_NORTHING_M: f64 = 1.0e7;

/// Why a point has no UTM coordinates, or coordinates no point.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UtmError {
    /// The zone does not exist.
    #[error("UTM zone {zone}, expected 1 to 60, or -1 to -60 for the southern hemisphere")]
    Zone {
        /// Zone asked for.
        zone: i8,
    },
    /// A coordinate pair is outside the zone's reach.
    #[error(
        "row {row}: {first}, {second} is too far from UTM zone {zone} (easting within 500000 +- 1000000 m, northing within +-10000000 m of the equator)"
    )]
    Outside {
        /// Row, from 0.
        row: usize,
        /// Easting (metres) or longitude (radians), as given.
        first: f64,
        /// Northing (metres) or latitude (radians), as given.
        second: f64,
        /// The zone.
        zone: i8,
    },
    /// The projection library refused the definition.
    #[error("UTM zone {zone}: {reason}")]
    Library {
        /// The zone.
        zone: i8,
        /// What it said.
        reason: String,
    },
}

/// One UTM zone on one ellipsoid. Agrees with PROJ to better than 10 nm within the zone (`tests/it/proj.rs`).
#[derive(Debug)]
pub struct Utm {
    zone: i8,
    projection: Minimal,
    operation: OpHandle,
}

impl Utm {
    /// Zone 1 to 60, negative in the southern hemisphere (false northing 10 000 km).
    ///
    /// # Errors
    /// [`UtmError::Zone`] when there is no such zone.
    pub fn new(ellipsoid: Ellipsoid, zone: i8) -> Result<Self, UtmError> {
        if zone == 0 || !(-60..=60).contains(&zone) {
            return Err(UtmError::Zone { zone });
        }
        let mut projection = Minimal::new();
        let operation = projection
            .op(&definition(ellipsoid, zone))
            .map_err(|fault| UtmError::Library {
                zone,
                reason: fault.to_string(),
            })?;
        Ok(Self {
            zone,
            projection,
            operation,
        })
    }

    /// The zone of a position by the 6-degree rule, negative in the south, without the exceptions off Norway.
    #[must_use]
    pub fn zone_of(position: &Geodetic) -> i8 {
        let turned = position.longitude_rad.to_degrees() + 180.0;
        let zone = (turned.rem_euclid(360.0) / 6.0).floor().clamp(0.0, 59.0) as i8 + 1;
        if position.latitude_rad < 0.0 {
            -zone
        } else {
            zone
        }
    }

    /// Zone number, negative in the south.
    #[must_use]
    pub fn zone(&self) -> i8 {
        self.zone
    }

    /// Columns of easting and northing (metres) become longitude and latitude (radians) in place.
    ///
    /// # Errors
    /// [`UtmError::Outside`] names the first row out of reach; the columns are then partly converted and of no use.
    pub fn to_geodetic_in_place(
        &self,
        easting_m: &mut [f64],
        northing_m: &mut [f64],
    ) -> Result<(), UtmError> {
        self.refuse_outside(easting_m, northing_m, (easting_m, northing_m))?;
        self.apply(|| Direction::Inv, easting_m, northing_m)
    }

    /// Columns of longitude and latitude (radians) become easting and northing (metres) in place.
    ///
    /// # Errors
    /// [`UtmError::Outside`] names the first row out of reach; the columns are then of no use.
    pub fn from_geodetic_in_place(
        &self,
        longitude_rad: &mut [f64],
        latitude_rad: &mut [f64],
    ) -> Result<(), UtmError> {
        let given = (longitude_rad.to_vec(), latitude_rad.to_vec());
        self.apply(|| Direction::Fwd, longitude_rad, latitude_rad)?;
        self.refuse_outside(longitude_rad, latitude_rad, (&given.0, &given.1))
    }

    /// One point: easting, northing and ellipsoidal height (metres) to a geodetic position.
    ///
    /// # Errors
    /// [`UtmError::Outside`] when it is out of the zone's reach.
    pub fn to_geodetic(
        &self,
        easting_m: f64,
        northing_m: f64,
        height_m: f64,
    ) -> Result<Geodetic, UtmError> {
        let (mut first, mut second) = ([easting_m], [northing_m]);
        self.to_geodetic_in_place(&mut first, &mut second)?;
        Ok(Geodetic {
            latitude_rad: second[0],
            longitude_rad: first[0],
            height_m,
        })
    }

    /// One point: easting and northing, metres; the height stays the ellipsoidal one.
    ///
    /// # Errors
    /// [`UtmError::Outside`] when it is out of the zone's reach.
    pub fn from_geodetic(&self, position: &Geodetic) -> Result<(f64, f64), UtmError> {
        let (mut first, mut second) = ([position.longitude_rad], [position.latitude_rad]);
        self.from_geodetic_in_place(&mut first, &mut second)?;
        Ok((first[0], second[0]))
    }

    /// Runs the projection chunk by chunk; every point by itself, so the result does not depend on the threads.
    fn apply(
        &self,
        direction: fn() -> Direction,
        first: &mut [f64],
        second: &mut [f64],
    ) -> Result<(), UtmError> {
        first
            .par_chunks_mut(CHUNK)
            .zip(second.par_chunks_mut(CHUNK))
            .try_for_each(|(first, second)| self.apply_chunk(direction, first, second))
    }

    fn apply_chunk(
        &self,
        direction: fn() -> Direction,
        first: &mut [f64],
        second: &mut [f64],
    ) -> Result<(), UtmError> {
        let pairs = first.iter().zip(second.iter());
        let mut points: Vec<Coor2D> = pairs.map(|(&x, &y)| Coor2D::raw(x, y)).collect();
        self.projection
            .apply(self.operation, direction(), &mut points)
            .map_err(|fault| UtmError::Library {
                zone: self.zone,
                reason: fault.to_string(),
            })?;
        for ((x, y), point) in first.iter_mut().zip(second.iter_mut()).zip(&points) {
            (*x, *y) = (point.0[0], point.0[1]);
        }
        Ok(())
    }

    /// Names the first row whose easting or northing is out of reach, with the figures `given` for it.
    fn refuse_outside(
        &self,
        easting_m: &[f64],
        northing_m: &[f64],
        given: (&[f64], &[f64]),
    ) -> Result<(), UtmError> {
        let equator_m = if self.zone < 0 { 1.0e7 } else { 0.0 };
        let reachable = |(&easting, &northing): (&f64, &f64)| {
            (easting - 5.0e5).abs() <= FARTHEST_EASTING_M
                && (northing - equator_m).abs() <= FARTHEST_NORTHING_M + 1.0e4
        };
        let outside = easting_m
            .iter()
            .zip(northing_m)
            .position(|pair| !reachable(pair));
        outside.map_or(Ok(()), |row| {
            Err(UtmError::Outside {
                row,
                first: given.0[row],
                second: given.1[row],
                zone: self.zone,
            })
        })
    }
}

/// The ellipsoid is always given: the library's default is GRS80.
fn definition(ellipsoid: Ellipsoid, zone: i8) -> String {
    format!(
        "utm zone={} ellps={},{}{}",
        zone.unsigned_abs(),
        ellipsoid.semi_major_axis_m(),
        1.0 / ellipsoid.flattening(),
        if zone < 0 { " south" } else { "" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn position(latitude: f64, longitude: f64) -> Geodetic {
        Geodetic {
            latitude_rad: latitude.to_radians(),
            longitude_rad: longitude.to_radians(),
            height_m: 12.0,
        }
    }

    #[test]
    fn zones_end_at_sixty_and_zero_is_none() {
        for zone in [0, 61, -61, i8::MIN, i8::MAX] {
            assert_eq!(
                Utm::new(Ellipsoid::Wgs84, zone).err(),
                Some(UtmError::Zone { zone })
            );
        }
        for zone in [1, 60, -1, -60] {
            assert_eq!(
                Utm::new(Ellipsoid::Wgs84, zone).expect("a zone").zone(),
                zone
            );
        }
    }

    #[test]
    fn the_zone_follows_the_longitude() {
        assert_eq!(Utm::zone_of(&position(30.0, 120.5)), 51);
        assert_eq!(Utm::zone_of(&position(-30.0, 119.9)), -50);
        assert_eq!(Utm::zone_of(&position(1.0, 180.0)), 1);
        assert_eq!(Utm::zone_of(&position(1.0, -180.0)), 1);
    }

    #[test]
    fn columns_longer_than_a_chunk_return() {
        let utm = Utm::new(Ellipsoid::Cgcs2000, -51).expect("a zone");
        let longitude: Vec<f64> = (0..9001)
            .map(|k| (120.0 + f64::from(k) * 6e-4).to_radians())
            .collect();
        let latitude: Vec<f64> = (0..9001)
            .map(|k| (-f64::from(k) * 8e-3).to_radians())
            .collect();
        let (mut first, mut second) = (longitude.clone(), latitude.clone());
        utm.from_geodetic_in_place(&mut first, &mut second)
            .expect("inside");
        assert!(first[9000] > 5e5 && second[9000] < 1e7);
        utm.to_geodetic_in_place(&mut first, &mut second)
            .expect("inside");
        for k in 0..9001 {
            assert!(
                (first[k] - longitude[k]).abs() < 2e-15 && (second[k] - latitude[k]).abs() < 2e-15
            );
        }
    }

    #[test]
    fn a_point_out_of_reach_is_named() {
        let utm = Utm::new(Ellipsoid::Wgs84, 51).expect("a zone");
        let (mut easting, mut northing) = (vec![5e5, 3.5e6], vec![3.3e6, 5e5]);
        let fault = utm.to_geodetic_in_place(&mut easting, &mut northing);
        assert!(matches!(fault, Err(UtmError::Outside { row: 1, first, .. }) if first == 3.5e6));
        assert!(utm.to_geodetic(f64::NAN, 0.0, 0.0).is_err());
        assert!(utm.from_geodetic(&position(0.0, 0.0)).is_err());
    }
}
