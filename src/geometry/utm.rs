//! Universal transverse Mercator: Krüger's series to the sixth order, as Karney has it ("Transverse Mercator with an accuracy of a few
//! nanometers", *Journal of Geodesy* 85, 2011; equations are his).

use rayon::prelude::*;
use thiserror::Error;

use super::ellipsoid::{Ellipsoid, Geodetic};
use crate::math;

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
}

/// One UTM zone on one ellipsoid. Agrees with PROJ to better than 10 nm within the zone (`tests/it/proj.rs`).
#[derive(Clone, Debug)]
pub struct Utm {
    zone: i8,
    /// Longitude of the central meridian, radians.
    meridian_rad: f64,
    /// Northing of the equator, metres.
    equator_m: f64,
    /// Radius of the rectifying sphere times the scale of the central meridian, metres.
    radius_m: f64,
    /// First eccentricity.
    eccentricity: f64,
    /// Coefficients of the series from the conformal sphere (35), and back to it (36).
    series: [[f64; ORDER]; 2],
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
        let n = ellipsoid.flattening() / (2.0 - ellipsoid.flattening());
        let rectifying = 1.0 + n * n / 4.0 + n.powi(4) / 64.0 + n.powi(6) / 256.0;
        Ok(Self {
            zone,
            meridian_rad: (6.0 * f64::from(zone.unsigned_abs()) - 183.0).to_radians(),
            equator_m: if zone < 0 { 1.0e7 } else { 0.0 },
            radius_m: SCALE * ellipsoid.semi_major_axis_m() * rectifying / (1.0 + n),
            eccentricity: (ellipsoid.flattening() * (2.0 - ellipsoid.flattening())).sqrt(),
            series: [coefficients(&TO_PLANE, n), coefficients(&FROM_PLANE, n)],
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
        each(easting_m, northing_m, |x, y| self.inverse(x, y));
        Ok(())
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
        each(longitude_rad, latitude_rad, |x, y| self.forward(x, y));
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

    /// Easting and northing of a longitude and a latitude.
    fn forward(&self, longitude_rad: f64, latitude_rad: f64) -> (f64, f64) {
        let (sine, cosine) = math::sin_cos(longitude_rad - self.meridian_rad);
        let tangent = self.conformal(math::tan(latitude_rad));
        let at = (
            math::atan2(tangent, cosine),
            math::asinh(sine / math::hypot(tangent, cosine)),
        );
        let moved = wave(&self.series[0], at);
        (
            FALSE_EASTING_M + self.radius_m * (at.1 + moved.1),
            self.equator_m + self.radius_m * (at.0 + moved.0),
        )
    }

    /// Longitude, within half a turn of zero, and latitude of an easting and a northing.
    fn inverse(&self, easting_m: f64, northing_m: f64) -> (f64, f64) {
        let at = (
            (northing_m - self.equator_m) / self.radius_m,
            (easting_m - FALSE_EASTING_M) / self.radius_m,
        );
        let moved = wave(&self.series[1], at);
        let (sine, cosine) = math::sin_cos(at.0 - moved.0);
        let across = math::sinh(at.1 - moved.1);
        let longitude_rad = self.meridian_rad + math::atan2(across, cosine);
        let tangent = self.geographic(sine / math::hypot(across, cosine));
        (wrapped(longitude_rad), math::atan2(tangent, 1.0))
    }

    /// Tangent of the conformal latitude from that of the geographic one (7), (9).
    fn conformal(&self, tangent: f64) -> f64 {
        let secant = math::hypot(1.0, tangent);
        let e = self.eccentricity;
        let sigma = math::sinh(e * math::atanh(e * tangent / secant));
        tangent * math::hypot(1.0, sigma) - sigma * secant
    }

    /// Its inverse, by Newton's method (19) to (21); three steps reach the last bits.
    fn geographic(&self, conformal: f64) -> f64 {
        let rest = 1.0 - self.eccentricity * self.eccentricity;
        let mut tangent = conformal / rest;
        for _ in 0..4 {
            let found = self.conformal(tangent);
            let secant = 1.0 + tangent * tangent;
            let slope =
                math::hypot(1.0, found) * rest * secant.sqrt() / (1.0 + rest * tangent * tangent);
            tangent += (conformal - found) / slope;
        }
        tangent
    }

    /// Names the first row whose easting or northing is out of reach, with the figures `given` for it.
    fn refuse_outside(
        &self,
        easting_m: &[f64],
        northing_m: &[f64],
        given: (&[f64], &[f64]),
    ) -> Result<(), UtmError> {
        let reachable = |(&easting, &northing): (&f64, &f64)| {
            (easting - FALSE_EASTING_M).abs() <= FARTHEST_EASTING_M
                && (northing - self.equator_m).abs() <= FARTHEST_NORTHING_M + 1.0e4
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

/// Scale of the central meridian.
const SCALE: f64 = 0.9996;

/// Easting of the central meridian, metres.
const FALSE_EASTING_M: f64 = 5.0e5;

/// Terms of the series.
const ORDER: usize = 6;

/// Converts two columns in place, chunk by chunk; every point by itself, so the result does not depend on the threads.
fn each(first: &mut [f64], second: &mut [f64], convert: impl Fn(f64, f64) -> (f64, f64) + Sync) {
    let chunks = first
        .par_chunks_mut(CHUNK)
        .zip(second.par_chunks_mut(CHUNK));
    chunks.for_each(|(first, second)| {
        for (x, y) in first.iter_mut().zip(second) {
            (*x, *y) = convert(*x, *y);
        }
    });
}

/// An angle within half a turn of zero.
fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    match angle_rad {
        x if x > PI => x - TAU,
        x if x < -PI => x + TAU,
        x => x,
    }
}

/// `sum c_j sin(2 j (xi + i eta))`, real and imaginary part, by Clenshaw's recurrence.
fn wave(series: &[f64; ORDER], (xi, eta): (f64, f64)) -> (f64, f64) {
    let (sine, cosine) = math::sin_cos(2.0 * xi);
    let (grow, shrink) = (math::exp(2.0 * eta), math::exp(-2.0 * eta));
    let (cosh, sinh) = (0.5 * (grow + shrink), math::sinh(2.0 * eta));
    let turn = (2.0 * cosine * cosh, -2.0 * sine * sinh);
    let times = |a: (f64, f64), b: (f64, f64)| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let (mut one, mut two) = ((0.0, 0.0), (0.0, 0.0));
    for c in series.iter().rev() {
        let next = times(turn, one);
        (one, two) = ((next.0 - two.0 + c, next.1 - two.1), one);
    }
    times(one, (sine * cosh, cosine * sinh))
}

/// Coefficients of a series for a third flattening.
fn coefficients(table: &[[f64; ORDER]; ORDER], n: f64) -> [f64; ORDER] {
    table.map(|row| n * row.iter().rev().fold(0.0, |sum, c| sum * n + c))
}

/// Krüger's coefficients in powers of the third flattening from the first on (35).
#[rustfmt::skip]
const TO_PLANE: [[f64; ORDER]; ORDER] = [
    [1.0 / 2.0, -2.0 / 3.0, 5.0 / 16.0, 41.0 / 180.0, -127.0 / 288.0, 7891.0 / 37800.0],
    [0.0, 13.0 / 48.0, -3.0 / 5.0, 557.0 / 1440.0, 281.0 / 630.0, -1983433.0 / 1935360.0],
    [0.0, 0.0, 61.0 / 240.0, -103.0 / 140.0, 15061.0 / 26880.0, 167603.0 / 181440.0],
    [0.0, 0.0, 0.0, 49561.0 / 161280.0, -179.0 / 168.0, 6601661.0 / 7257600.0],
    [0.0, 0.0, 0.0, 0.0, 34729.0 / 80640.0, -3418889.0 / 1995840.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 212378941.0 / 319334400.0],
];

/// And back (36).
#[rustfmt::skip]
const FROM_PLANE: [[f64; ORDER]; ORDER] = [
    [1.0 / 2.0, -2.0 / 3.0, 37.0 / 96.0, -1.0 / 360.0, -81.0 / 512.0, 96199.0 / 604800.0],
    [0.0, 1.0 / 48.0, 1.0 / 15.0, -437.0 / 1440.0, 46.0 / 105.0, -1118711.0 / 3870720.0],
    [0.0, 0.0, 17.0 / 480.0, -37.0 / 840.0, -209.0 / 4480.0, 5569.0 / 90720.0],
    [0.0, 0.0, 0.0, 4397.0 / 161280.0, -11.0 / 504.0, -830251.0 / 7257600.0],
    [0.0, 0.0, 0.0, 0.0, 4583.0 / 161280.0, -108847.0 / 3991680.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 20648693.0 / 638668800.0],
];

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
