//! Points into LAS and LAZ as they come, without holding them.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use las::point::{Classification, Format};
use las::{Builder, GpsTimeType, Point, Transform, Vector, Vlr};

use crate::files::write_whole;
use crate::formats::error::FormatError;
use crate::formats::extension;

/// System identifier of the files written here: georeferenced by this program, so that it may replace them.
pub const WRITTEN_BY: &str = "boresight apply";
/// Resolution of written coordinates, metres.
const SCALE_M: f64 = 0.0001;

/// The class of soundings: bathymetric point (LAS domain profile for topo-bathymetric lidar).
const BATHYMETRIC: Classification = Classification::UserDefinable(40);

/// Where the coordinates are, and in which system.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// About the middle of the points, metres; they lie within 200 km of it.
    pub middle_m: [f64; 3],
    /// The coordinate reference system as WKT.
    pub wkt: String,
    /// Whether the times are adjusted standard GPS time and not seconds of the week.
    pub standard_time: bool,
}

/// Whether times are adjusted standard GPS time (seconds since 1980, less 1e9), judged by their size: no second of a week is as large.
#[must_use]
pub fn is_standard_time(time_s: &[f64]) -> bool {
    let largest = time_s.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
    // a week, and a survey that goes on counting after its end
    (14.0 * 86_400.0..1e9).contains(&largest)
}

/// One point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// GPS time, seconds.
    pub time_s: f64,
    /// Coordinates, metres.
    pub position_m: [f64; 3],
    /// Point source id.
    pub source: u16,
    /// Whether it is a sounding: ASPRS class 40, else 1.
    pub sounding: bool,
    /// Whether it lies on the surface about it; not written.
    pub on_surface: bool,
    /// The values of [`EXTRA`]; [`NOTHING`] where there is none.
    pub extra: [u32; EXTRA.len()],
}

/// Extra dimensions of a point, each with what it holds.
pub const EXTRA: [(&str, &str); 3] = [
    ("row", "number in the raw file, from 0"),
    ("ping", "ping number"),
    ("beam", "beam number within the ping"),
];
/// The value of an extra dimension that a point does not have.
pub const NOTHING: u32 = u32::MAX;

/// Writes the chunks to LAZ (LAS when the name ends so): point format 6, coordinates to 0.1 mm. Whole or not at all. Returns the
/// number of points.
///
/// # Errors
/// The first error of the chunks, or [`FormatError`] of kind `Unwritable`.
pub fn write<E: From<FormatError>>(
    path: &Path,
    layout: &Layout,
    chunks: impl Iterator<Item = Result<Vec<CloudPoint>, E>>,
) -> Result<u64, E> {
    let refused = |error: &dyn std::fmt::Display| E::from(FormatError::unwritable(path, error));
    let header = header(layout, extension(path) != "las").map_err(|e| refused(&e))?;
    let mut filled = Ok(0);
    let written = write_whole(path, |file| {
        let file = file.get_ref().try_clone()?;
        filled = filling(file, header, chunks, &refused);
        match filled {
            Ok(_) => Ok(()),
            Err(_) => Err(std::io::Error::other("not filled")),
        }
    });
    let count = filled?;
    written.map_err(|e| refused(&e.source))?;
    Ok(count)
}

fn filling<E>(
    file: File,
    header: las::Header,
    chunks: impl Iterator<Item = Result<Vec<CloudPoint>, E>>,
    refused: &dyn Fn(&dyn std::fmt::Display) -> E,
) -> Result<u64, E> {
    let file = BufWriter::with_capacity(1 << 20, file);
    let writer = las::Writer::new(file, header).map_err(|e| refused(&e))?;
    fill(writer, chunks, refused)
}

type Sink = las::Writer<BufWriter<File>>;

fn fill<E>(
    mut writer: Sink,
    chunks: impl Iterator<Item = Result<Vec<CloudPoint>, E>>,
    refused: &dyn Fn(&dyn std::fmt::Display) -> E,
) -> Result<u64, E> {
    let written = append(&mut writer, chunks, refused)
        .and_then(|n| writer.close().map(|()| n).map_err(|e| refused(&e)));
    if written.is_err() {
        // dropped unfinished, the writer would try to finish the file and panic where it cannot
        std::mem::forget(writer);
    }
    written
}

fn append<E>(
    writer: &mut Sink,
    chunks: impl Iterator<Item = Result<Vec<CloudPoint>, E>>,
    refused: &dyn Fn(&dyn std::fmt::Display) -> E,
) -> Result<u64, E> {
    let mut count = 0;
    for chunk in chunks {
        for point in chunk? {
            writer
                .write_point(las_point(&point))
                .map_err(|e| refused(&e))?;
            count += 1;
        }
    }
    Ok(count)
}

fn header(layout: &Layout, compressed: bool) -> Result<las::Header, las::Error> {
    let mut builder = Builder::from((1, 4));
    builder.point_format = Format::new(6)?;
    builder.point_format.is_compressed = compressed;
    builder.point_format.extra_bytes = 4 * EXTRA.len() as u16;
    builder.vlrs.push(extra_bytes());
    builder.generating_software = "boresight".to_owned();
    builder.system_identifier = WRITTEN_BY.to_owned();
    if layout.standard_time {
        builder.gps_time_type = GpsTimeType::Standard;
    }
    let transform = |middle_m: f64| Transform {
        scale: SCALE_M,
        offset: middle_m.round(),
    };
    let [x, y, z] = layout.middle_m.map(transform);
    builder.transforms = Vector { x, y, z };
    let mut header = builder.into_header()?;
    header.set_wkt_crs(layout.wkt.clone().into_bytes())?;
    Ok(header)
}

/// What the extra bytes mean: LAS 1.4 R15, table 24, one record of 192 bytes for each dimension.
fn extra_bytes() -> Vlr {
    const UNSIGNED_LONG: u8 = 5;
    const HAS_NOTHING_VALUE: u8 = 1;
    let mut data = vec![];
    for (name, about) in EXTRA {
        let mut record = [0; 192];
        record[2] = UNSIGNED_LONG;
        record[3] = HAS_NOTHING_VALUE;
        record[4..4 + name.len()].copy_from_slice(name.as_bytes());
        record[40..48].copy_from_slice(&u64::from(NOTHING).to_le_bytes());
        record[160..160 + about.len()].copy_from_slice(about.as_bytes());
        data.extend(record);
    }
    Vlr {
        user_id: "LASF_Spec".to_owned(),
        record_id: 4,
        description: "extra bytes".to_owned(),
        data,
    }
}

fn las_point(point: &CloudPoint) -> Point {
    let [x, y, z] = point.position_m;
    Point {
        x,
        y,
        z,
        return_number: 1,
        number_of_returns: 1,
        classification: if point.sounding {
            BATHYMETRIC
        } else {
            Classification::Unclassified
        },
        point_source_id: point.source,
        gps_time: Some(point.time_s),
        extra_bytes: point.extra.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ..Point::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::las;

    fn layout() -> Layout {
        Layout {
            middle_m: [500_000.4, 3e6, 15.0],
            wkt: super::super::wkt::utm(crate::geometry::Ellipsoid::Wgs84, 50),
            standard_time: false,
        }
    }

    fn point(k: u32) -> CloudPoint {
        CloudPoint {
            time_s: f64::from(k),
            position_m: [500_000.123_4, 3e6 + f64::from(k), 15.5],
            source: 2,
            on_surface: false,
            sounding: true,
            extra: [k, 7, NOTHING],
        }
    }

    #[test]
    fn points_come_back() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("cloud.laz");
        let chunks = [vec![point(0), point(1)], vec![point(2)]].map(Ok::<_, FormatError>);
        assert_eq!(
            write(&path, &layout(), chunks.into_iter()).expect("written"),
            3
        );
        let back = las::read(&path, crate::formats::Invalid::Error).expect("read");
        assert_eq!((back.time_s.len(), back.time_s[2]), (3, 2.0));
        assert!(
            (back.x_m[1] - 500_000.123_4).abs() < 1e-9 && (back.y_m[2] - 3_000_002.0).abs() < 1e-9
        );
    }

    #[test]
    fn a_failed_chunk_leaves_nothing() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("cloud.laz");
        let failed = FormatError::unwritable(&path, &"no more");
        let chunks = [Ok(vec![point(0)]), Err(failed.clone())];
        assert_eq!(write(&path, &layout(), chunks.into_iter()), Err(failed));
        assert_eq!(std::fs::read_dir(folder.path()).expect("list").count(), 0);
    }
}
