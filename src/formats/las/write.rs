//! Columns into LAS and LAZ.

use std::io::{Cursor, Write};
use std::path::Path;

use las::point::Format;
use las::{Builder, Point, Transform, Vector};

use crate::formats::error::FormatError;
use crate::formats::extension;
use crate::formats::whole::write_whole;
use crate::observe::LaserScan;

/// Resolution of written coordinates, metres.
const SCALE_M: f64 = 0.0001;
/// Point format 6: coordinates, returns, GPS time.
const POINT_FORMAT: u8 = 6;

/// Columns of equal length to write.
#[derive(Clone, Copy, Debug)]
pub struct PointColumns<'a> {
    /// Time of each point, seconds.
    pub time_s: &'a [f64],
    /// First coordinate, metres.
    pub x_m: &'a [f64],
    /// Second coordinate, metres.
    pub y_m: &'a [f64],
    /// Third coordinate, metres.
    pub z_m: &'a [f64],
    /// Which sensor each point is from; empty for zero throughout.
    pub point_source_id: &'a [u16],
}

/// Writes a scan as LAZ, or as LAS when the name ends so: point format 6, coordinates to 0.1 mm, no date, so that the same
/// scan gives the same bytes.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`, also for coordinates that span more than 400 km.
pub fn write(path: &Path, scan: &LaserScan) -> Result<(), FormatError> {
    let columns = PointColumns {
        time_s: &scan.time_s,
        x_m: &scan.x_m,
        y_m: &scan.y_m,
        z_m: &scan.z_m,
        point_source_id: &[],
    };
    write_columns(path, &columns, None)
}

/// Writes columns as [`write()`] does, with the coordinate reference system as WKT where it is known.
///
/// # Errors
/// As [`write()`].
pub fn write_columns(
    path: &Path,
    columns: &PointColumns<'_>,
    wkt: Option<&str>,
) -> Result<(), FormatError> {
    let compressed = extension(path) != "las";
    let bytes = write_to(columns, compressed, wkt)
        .map_err(|error| FormatError::unwritable(path, &error))?;
    write_whole(path, |w| w.write_all(&bytes))
}

/// The bytes of a LAS or LAZ file.
///
/// # Errors
/// When coordinates do not fit the file's integers.
pub fn write_to(
    columns: &PointColumns<'_>,
    compressed: bool,
    wkt: Option<&str>,
) -> Result<Vec<u8>, las::Error> {
    let mut builder = Builder::from((1, 4));
    builder.point_format = Format::new(POINT_FORMAT)?;
    builder.point_format.is_compressed = compressed;
    builder.generating_software = "boresight".to_owned();
    builder.transforms = Vector {
        x: transform(columns.x_m),
        y: transform(columns.y_m),
        z: transform(columns.z_m),
    };
    let mut header = builder.into_header()?;
    if let Some(wkt) = wkt {
        header.set_wkt_crs(wkt.as_bytes().to_vec())?;
    }
    let mut writer = las::Writer::new(Cursor::new(Vec::new()), header)?;
    for k in 0..columns.time_s.len() {
        writer.write_point(point(columns, k))?;
    }
    Ok(writer.into_inner()?.into_inner())
}

fn point(columns: &PointColumns<'_>, k: usize) -> Point {
    Point {
        x: columns.x_m[k],
        y: columns.y_m[k],
        z: columns.z_m[k],
        return_number: 1,
        number_of_returns: 1,
        point_source_id: columns.point_source_id.get(k).copied().unwrap_or(0),
        gps_time: Some(columns.time_s[k]),
        ..Point::default()
    }
}

/// Integers of 0.1 mm about the middle of the column, on a whole metre; no offset where none is needed.
fn transform(column: &[f64]) -> Transform {
    let (low, high) = column
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    let near = low > -200_000.0 && high < 200_000.0;
    let middle = (low / 2.0 + high / 2.0).round();
    let offset = if near || !middle.is_finite() {
        0.0
    } else {
        middle
    };
    Transform {
        scale: SCALE_M,
        offset,
    }
}
