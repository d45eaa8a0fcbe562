//! Control points of a USBL calibration: `name,role`, coordinates and their standard deviations.
//!
//! The header says which coordinates: `x_m,y_m,z_m` (earth-centred, earth-fixed), `latitude_deg,longitude_deg,height_m`
//! (geodetic) or `east_m,north_m,up_m` (local level). Standard deviations: `sigma_east_m,sigma_north_m,sigma_up_m`, or with
//! geocentric coordinates `sigma_x_m,sigma_y_m,sigma_z_m`. Roles: `transducer` (one), `common`, `check`.

use std::io::{Read, Write};
use std::path::Path;

use crate::formats::error::{FaultKind, FormatError, Place, open, quoted};
use crate::formats::rows::Rows;
use crate::formats::table::{Limits, Table};
use crate::formats::trajectory_csv::{HEIGHT, LATITUDE, LONGITUDE};
use crate::formats::whole::write_whole;

// LAYOUT

const REQUIRED: [&str; 2] = ["name", "role"];
const OPTIONAL: [&str; 15] = [
    "x_m",
    "y_m",
    "z_m",
    "latitude_deg",
    "longitude_deg",
    "height_m",
    "east_m",
    "north_m",
    "up_m",
    "sigma_x_m",
    "sigma_y_m",
    "sigma_z_m",
    "sigma_east_m",
    "sigma_north_m",
    "sigma_up_m",
];
const GEOCENTRIC: Limits = Limits {
    min: -7e6,
    max: 7e6,
    expected: "metres from the centre of the earth, within 7000 km",
};
const LOCAL: Limits = Limits {
    min: -1e6,
    max: 1e6,
    expected: "metres within 1000 km",
};
const SIGMA: Limits = Limits {
    min: 0.0,
    max: 10.0,
    expected: "a standard deviation from 0 to 10 m",
};

/// Coordinates of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlCoordinates {
    /// Earth-centred, earth-fixed, metres.
    Geocentric,
    /// Latitude and longitude (radians), ellipsoidal height (metres).
    Geodetic,
    /// East, north, up, metres.
    Local,
}

/// Axes of the standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SigmaAxes {
    /// Those of the geocentric coordinates.
    Geocentric,
    /// East, north, up.
    Level,
}

/// What a control point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlRole {
    /// The transducer's centre.
    Transducer,
    /// A beacon that enters the calibration.
    Common,
    /// A beacon that only checks it.
    Check,
}

/// One control point.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlRow {
    /// Its name, as the fixes use it.
    pub name: String,
    /// What it is.
    pub role: ControlRole,
    /// Coordinates, as [`ControlCoordinates`] says.
    pub coordinates: [f64; 3],
    /// Standard deviations, metres.
    pub sigma_m: [f64; 3],
}

/// A control file.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlRecords {
    /// Its coordinates.
    pub coordinates: ControlCoordinates,
    /// Axes of its standard deviations.
    pub axes: SigmaAxes,
    /// Its points; one and only one is the transducer, and all names differ.
    pub rows: Vec<ControlRow>,
}

// READ

/// Reads a control file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, columns missing, values impossible, a name twice, none or two transducers.
pub fn read(path: &Path) -> Result<ControlRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads a control file of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(file: &Path, source: impl Read, size: u64) -> Result<ControlRecords, FormatError> {
    let mut table = Table::open(file, source, size, &REQUIRED, &OPTIONAL)?;
    let (coordinates, first) = coordinates(&table)?;
    let (axes, sigma) = axes(&table, coordinates)?;
    let mut rows: Vec<ControlRow> = vec![];
    table.each(None, |table| {
        let row = row(table, coordinates, (first, sigma))?;
        if rows.iter().any(|other| other.name == row.name) {
            let found = format!("{} a second time", quoted(row.name.as_bytes()));
            return Err(table.fault(FaultKind::BadValue, 0, found, "names that differ"));
        }
        let second = row.role == ControlRole::Transducer
            && rows
                .iter()
                .any(|other| other.role == ControlRole::Transducer);
        if second {
            let found = "a second transducer".to_owned();
            return Err(table.fault(FaultKind::BadValue, 1, found, "one transducer"));
        }
        rows.push(row);
        Ok(())
    })?;
    if !rows.iter().any(|row| row.role == ControlRole::Transducer) {
        return Err(FormatError::new(
            FaultKind::BadValue,
            file,
            Place::File,
            "no row with role transducer",
            "one row with role transducer: the surveyed centre of the transducer",
        ));
    }
    Ok(ControlRecords {
        coordinates,
        axes,
        rows,
    })
}

fn has<R: Read>(table: &Table<R>, first: usize) -> bool {
    (first..first + 3).all(|column| table.has(column))
}

/// The kind of coordinates and their first column.
fn coordinates<R: Read>(table: &Table<R>) -> Result<(ControlCoordinates, usize), FormatError> {
    let kinds = [
        (ControlCoordinates::Geocentric, 2),
        (ControlCoordinates::Geodetic, 5),
        (ControlCoordinates::Local, 8),
    ];
    let names = [
        "x_m,y_m,z_m",
        "latitude_deg,longitude_deg,height_m",
        "east_m,north_m,up_m",
    ];
    let found = kinds.into_iter().find(|(_, first)| has(table, *first));
    found.ok_or_else(|| table.missing(&names))
}

fn axes<R: Read>(
    table: &Table<R>,
    coordinates: ControlCoordinates,
) -> Result<(SigmaAxes, usize), FormatError> {
    if has(table, 14) {
        return Ok((SigmaAxes::Level, 14));
    }
    if coordinates == ControlCoordinates::Geocentric && has(table, 11) {
        return Ok((SigmaAxes::Geocentric, 11));
    }
    Err(table.missing(&["sigma_east_m,sigma_north_m,sigma_up_m"]))
}

fn row<R: Read>(
    table: &Table<R>,
    coordinates: ControlCoordinates,
    (first, sigma): (usize, usize),
) -> Result<ControlRow, FormatError> {
    let limits = match coordinates {
        ControlCoordinates::Geocentric => [&GEOCENTRIC; 3],
        ControlCoordinates::Geodetic => [&LATITUDE, &LONGITUDE, &HEIGHT],
        ControlCoordinates::Local => [&LOCAL; 3],
    };
    let mut values = [0.0; 3];
    for (k, value) in values.iter_mut().enumerate() {
        *value = table.number(first + k, limits[k])?;
    }
    if coordinates == ControlCoordinates::Geodetic {
        values = [values[0].to_radians(), values[1].to_radians(), values[2]];
    }
    let mut sigma_m = [0.0; 3];
    for (k, value) in sigma_m.iter_mut().enumerate() {
        *value = table.number(sigma + k, &SIGMA)?;
    }
    let name = table.text(0)?.to_owned();
    if name.is_empty() {
        return Err(table.bad_value(0, "a name"));
    }
    Ok(ControlRow {
        name,
        role: role(table)?,
        coordinates: values,
        sigma_m,
    })
}

fn role<R: Read>(table: &Table<R>) -> Result<ControlRole, FormatError> {
    match table.text(1)?.to_ascii_lowercase().as_str() {
        "transducer" => Ok(ControlRole::Transducer),
        "common" => Ok(ControlRole::Common),
        "check" => Ok(ControlRole::Check),
        _ => Err(table.bad_value(1, "transducer, common or check")),
    }
}

// WRITE

/// Writes a control file: lengths to 1 micrometre, angles to 1e-12 deg.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, records: &ControlRecords) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, records))
}

/// Writes a control file into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, records: &ControlRecords) -> std::io::Result<()> {
    let first = match records.coordinates {
        ControlCoordinates::Geocentric => 0,
        ControlCoordinates::Geodetic => 3,
        ControlCoordinates::Local => 6,
    };
    let sigma = match records.axes {
        SigmaAxes::Geocentric => 9,
        SigmaAxes::Level => 12,
    };
    let names = [
        &REQUIRED[..],
        &OPTIONAL[first..first + 3],
        &OPTIONAL[sigma..sigma + 3],
    ]
    .concat();
    writeln!(out, "{}", names.join(","))?;
    for row in &records.rows {
        let role = match row.role {
            ControlRole::Transducer => "transducer",
            ControlRole::Common => "common",
            ControlRole::Check => "check",
        };
        let [a, b, c] = row.coordinates;
        let place = match records.coordinates {
            ControlCoordinates::Geodetic => {
                format!("{:.12},{:.12},{c:.6}", a.to_degrees(), b.to_degrees())
            }
            _ => format!("{a:.6},{b:.6},{c:.6}"),
        };
        let [sa, sb, sc] = row.sigma_m;
        writeln!(out, "{},{role},{place},{sa:.6},{sb:.6},{sc:.6}", row.name)?;
    }
    Ok(())
}
