//! Coordinates against PROJ: values made by `tests/recipes/proj.py`.

use boresight::geometry::ellipsoid::{TargetPose, ecef_from_level};
use boresight::geometry::{Ellipsoid, Geodetic, Point, Utm};
use nalgebra::Vector3;
use serde_json::Value;

/// A difference that PROJ and we may have, metres: a few roundings of 6.4e6 m (a double there has steps of 0.9e-9 m).
const ROUNDING_M: f64 = 5e-9;

/// The same for projected northings up to 1e7 m and the series of both.
const PROJECTED_M: f64 = 1e-8;

/// Keeps the worst distance and refuses one that is not below the limit (or not a number).
fn within(limit_m: f64, worst_m: &mut f64, distance_m: f64, row: &[f64]) {
    assert!(distance_m < limit_m, "{distance_m:e} m at {row:?}");
    *worst_m = worst_m.max(distance_m);
}

fn rows(table: &str) -> Vec<(Ellipsoid, Vec<f64>)> {
    let reference: Value =
        serde_json::from_str(include_str!("../reference/proj.json")).expect("JSON");
    let rows = reference[table].as_array().expect("a table");
    assert!(rows.len() >= 40, "{table} has {} rows", rows.len());
    rows.iter()
        .map(|row| {
            let ellipsoid = serde_json::from_value(row[0].clone()).expect("an ellipsoid");
            let row = row.as_array().expect("a row");
            let numbers = row[1..].iter().map(|v| v.as_f64().expect("a number"));
            (ellipsoid, numbers.collect())
        })
        .collect()
}

fn position(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Geodetic {
    Geodetic {
        latitude_rad: latitude_deg.to_radians(),
        longitude_rad: longitude_deg.to_radians(),
        height_m,
    }
}

#[test]
fn geodetic_to_geocentric_and_back() {
    let (mut worst_m, mut worst_back_m) = (0.0f64, 0.0f64);
    for (ellipsoid, row) in rows("geocentric") {
        let geodetic = position(row[0], row[1], row[2]);
        let proj = Vector3::new(row[3], row[4], row[5]);
        let ours = ellipsoid.to_geocentric(&geodetic).coordinates;
        within(ROUNDING_M, &mut worst_m, (ours - proj).norm(), &row);
        let back = ellipsoid.to_geodetic(&Point::new(proj));
        let north = (back.latitude_rad - geodetic.latitude_rad) * 6.4e6;
        let turn = (back.longitude_rad - geodetic.longitude_rad).sin();
        let east = turn * proj.x.hypot(proj.y);
        let up = back.height_m - geodetic.height_m;
        let away = Vector3::new(east, north, up).norm();
        within(ROUNDING_M, &mut worst_back_m, away, &row);
    }
    println!("geodetic to geocentric {worst_m:.1e} m, back {worst_back_m:.1e} m from PROJ");
}

#[test]
fn utm_forward_and_back() {
    let (mut worst_m, mut worst_back_m) = (0.0f64, 0.0f64);
    for (ellipsoid, row) in rows("utm") {
        let utm = Utm::new(ellipsoid, row[0] as i8).expect("a zone");
        let geodetic = position(row[1], row[2], 7.0);
        let (easting_m, northing_m) = utm.from_geodetic(&geodetic).expect("inside");
        let away = (easting_m - row[3]).hypot(northing_m - row[4]);
        within(PROJECTED_M, &mut worst_m, away, &row);
        let back = utm.to_geodetic(row[3], row[4], 7.0).expect("inside");
        let north = (back.latitude_rad - geodetic.latitude_rad) * 6.4e6;
        let east = (back.longitude_rad - geodetic.longitude_rad).sin()
            * 6.4e6
            * geodetic.latitude_rad.cos();
        within(PROJECTED_M, &mut worst_back_m, north.hypot(east), &row);
        assert_eq!(back.height_m, 7.0);
    }
    println!("UTM forward {worst_m:.1e} m, back {worst_back_m:.1e} m from PROJ");
}

/// PROJ's topocentric vectors against the target pose at azimuth 0 and against the level axes.
#[test]
fn topocentric_vectors() {
    let mut worst_m = 0.0f64;
    for (ellipsoid, row) in rows("topocentric") {
        let origin = position(row[0], row[1], row[2]);
        let point = ellipsoid.to_geocentric(&position(row[3], row[4], row[5]));
        let proj = Vector3::new(row[6], row[7], row[8]);
        let pose = TargetPose {
            ellipsoid,
            origin,
            azimuth_rad: 0.0,
        };
        let in_target = (pose.ecef_from_target().inverse() * point).coordinates;
        let from_origin = point.coordinates - ellipsoid.to_geocentric(&origin).coordinates;
        let in_level = ecef_from_level(&origin).inverse().matrix * from_origin;
        within(ROUNDING_M, &mut worst_m, (in_target - proj).norm(), &row);
        within(ROUNDING_M, &mut worst_m, (in_level - proj).norm(), &row);
    }
    println!("topocentric {worst_m:.1e} m from PROJ");
}

/// With an azimuth the target's axes are PROJ's east and north turned clockwise.
#[test]
fn topocentric_vectors_in_a_turned_target() {
    let azimuth_rad: f64 = 0.7;
    let (sine, cosine) = azimuth_rad.sin_cos();
    for (ellipsoid, row) in rows("topocentric") {
        let pose = TargetPose {
            ellipsoid,
            origin: position(row[0], row[1], row[2]),
            azimuth_rad,
        };
        let point = ellipsoid.to_geocentric(&position(row[3], row[4], row[5]));
        let local = (pose.ecef_from_target().inverse() * point).coordinates;
        let (east, north) = (row[6], row[7]);
        assert!((local.y - (east * sine + north * cosine)).abs() < ROUNDING_M);
        assert!((local.x - (east * cosine - north * sine)).abs() < ROUNDING_M);
    }
}
