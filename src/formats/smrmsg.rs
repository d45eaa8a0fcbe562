//! SMRMSG, the accuracies that go with an SBET: ten little-endian doubles a record, no header.
//!
//! Time; position north, east, down (m); velocity north, east, down (m/s); roll, pitch, heading (minutes of arc, a reading of their
//! size that no document at hand confirms).

use std::io::{BufReader, Read};
use std::path::Path;

use super::error::{FaultKind, FormatError, Place, open};
use super::week;
use crate::units::radians;

/// Bytes of a record.
const RECORD: usize = 80;

/// Standard deviations over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accuracies {
    /// Time, seconds of the week, not descending: counted on past the end of the week.
    pub time_s: Vec<f64>,
    /// Position east, north, up, metres.
    pub position_m: Vec<[f64; 3]>,
    /// Roll, pitch, heading, radians.
    pub attitude_rad: Vec<[f64; 3]>,
}

/// Reads a file.
///
/// # Errors
/// [`FormatError`]: unreadable, no whole number of records, a negative accuracy, times that descend.
pub fn read(path: &Path) -> Result<Accuracies, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(file: &Path, source: impl Read, size: u64) -> Result<Accuracies, FormatError> {
    let fault = |kind, place, found: String, expected| {
        Err(FormatError::new(kind, file, place, found, expected))
    };
    if size == 0 || !size.is_multiple_of(RECORD as u64) {
        let found = format!("{size} bytes");
        return fault(
            FaultKind::Truncated,
            Place::File,
            found,
            "records of 80 bytes",
        );
    }
    let mut source = BufReader::new(source);
    let (mut all, mut bytes) = (Accuracies::default(), [0; RECORD]);
    for record in 0..size / RECORD as u64 {
        let read = source.read_exact(&mut bytes);
        read.map_err(|e| FormatError::unreadable(file, &e))?;
        let mut d = [0.0; 10];
        for (value, chunk) in d.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *value = f64::from_le_bytes(*chunk);
        }
        let place = Place::Record {
            record,
            byte: record * RECORD as u64,
        };
        if !(d[0].is_finite() && d[1..].iter().all(|s| (0.0..1e6).contains(s))) {
            let expected = "a time and nine accuracies that are not negative";
            return fault(FaultKind::BadValue, place, format!("{d:?}"), expected);
        }
        d[0] = week::following(all.time_s.last().copied(), d[0]);
        if all.time_s.last().is_some_and(|before| d[0] < *before) {
            let found = format!("time {}", d[0]);
            return fault(FaultKind::Order, place, found, "times that do not descend");
        }
        all.time_s.push(d[0]);
        all.position_m.push([d[2], d[1], d[3]]);
        all.attitude_rad
            .push([d[7], d[8], d[9]].map(|minutes| radians(minutes / 60.0)));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(record: [f64; 10]) -> Vec<u8> {
        record.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn read_bytes(bytes: &[u8]) -> Result<Accuracies, FormatError> {
        read_from(Path::new("a.out"), bytes, bytes.len() as u64)
    }

    #[test]
    fn a_record_by_hand() {
        let bytes = file([1.0, 0.02, 0.01, 0.03, 0.0, 0.0, 0.0, 0.3, 0.6, 1.2]);
        let all = read_bytes(&bytes).expect("readable");
        assert_eq!(all.position_m, [[0.01, 0.02, 0.03]]);
        assert!((all.attitude_rad[0][2].to_degrees() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn the_end_of_a_week_is_counted_on() {
        let sigmas = |time_s: f64| {
            let mut record = [0.01; 10];
            record[0] = time_s;
            file(record)
        };
        let all = read_bytes(&[sigmas(604_799.5), sigmas(0.5)].concat()).expect("readable");
        assert_eq!(all.time_s, [604_799.5, 604_800.5]);
    }

    #[test]
    fn faults_are_named() {
        let bad = file([1.0, -0.02, 0.01, 0.03, 0.0, 0.0, 0.0, 0.3, 0.6, 1.2]);
        assert_eq!(
            read_bytes(&bad).expect_err("refused").kind,
            FaultKind::BadValue
        );
        assert_eq!(
            read_bytes(&bad[1..]).expect_err("refused").kind,
            FaultKind::Truncated
        );
        let late = file([2.0; 10]);
        let two = [late, file([1.0; 10])].concat();
        assert_eq!(
            read_bytes(&two).expect_err("refused").kind,
            FaultKind::Order
        );
    }
}
