//! Soundings CSV: `time_s,ping,beam,across_angle_deg,along_angle_deg` and `range_m` or `two_way_travel_time_s`.
//!
//! Of a sounder whose transmit and receive arrays stand each on its own, instead of the two angles: `rx_angle_deg` (against the receive
//! array, positive to starboard) and `tx_tilt_deg` (of the transmitted cone, positive forward), with `two_way_travel_time_s`; where they
//! are known `tx_delay_s` (from `time_s` to this beam's transmission), `sector`, and `head_sound_speed_m_s` (that the beam former used).
//!
//! Of a sounder with several heads: `head`, the number of each sounding's.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, Place, open};
use super::faults::Invalid;
use super::records::{ArrayColumns, SoundingRecords};
use super::rows::Rows;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::files::spill::SpillError;
use crate::observe::{
    Room, SonarNoise, Sounding, SoundingArrays, SoundingFile, SoundingRange, SoundingWriter,
    Soundings,
};
use crate::units::{degrees, radians};

// LAYOUT

const REQUIRED: [&str; 3] = ["time_s", "ping", "beam"];
/// Counted on from [`REQUIRED`].
const OPTIONAL: [&str; 10] = [
    ANGLES[0],
    ANGLES[1],
    RANGES[0],
    RANGES[1],
    CONES[0],
    CONES[1],
    "tx_delay_s",
    "sector",
    "head_sound_speed_m_s",
    HEAD_NAME,
];
const ANGLES: [&str; 2] = ["across_angle_deg", "along_angle_deg"];
const RANGES: [&str; 2] = ["range_m", "two_way_travel_time_s"];
const CONES: [&str; 2] = ["rx_angle_deg", "tx_tilt_deg"];
const RX: usize = 7;
const TILT: usize = 8;
const DELAY: usize = 9;
const SECTOR: usize = 10;
const SPEED: usize = 11;
const HEAD: usize = 12;
const HEAD_NAME: &str = "head";
const ANGLE: Limits = Limits {
    min: -180.0,
    max: 180.0,
    expected: "an angle from -180 to 180 deg",
};
const ALONG: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "an angle from -90 to 90 deg",
};
const RANGE: Limits = Limits {
    min: f64::MIN_POSITIVE,
    max: 20_000.0,
    expected: "a range above 0 m and up to 20000 m (is it in millimetres?)",
};
/// The two-way time over 20 km of slow water.
const TRAVEL_TIME: Limits = Limits {
    min: f64::MIN_POSITIVE,
    max: 30.0,
    expected: "a travel time above 0 s and up to 30 s (seconds, not milliseconds)",
};
const DELAYS: Limits = Limits {
    min: -10.0,
    max: 10.0,
    expected: "a delay from -10 to 10 s (seconds, not milliseconds)",
};
const HEAD_SPEED: Limits = Limits {
    min: 1000.0,
    max: 2000.0,
    expected: "a sound speed from 1000 to 2000 m/s",
};

// READ

/// Reads a soundings CSV.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that descend, angles in radians.
pub fn read(path: &Path, invalid: Invalid) -> Result<SoundingRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size, invalid)
}

/// Reads a soundings CSV; soundings for which there is no room in memory go to a file without name as they are read, and the columns stay
/// empty; of several heads only the soundings of `head` go there, and the column of heads holds the number of each head once. Those of two
/// arrays stay in memory.
///
/// # Errors
/// As [`read`]; of kind `Unwritable` and with the folder where that file cannot be written.
pub fn read_within(
    path: &Path,
    invalid: Invalid,
    room: &Room,
    head: Option<u32>,
) -> Result<(SoundingRecords, Option<SoundingFile>), FormatError> {
    let (file, size) = open(path)?;
    taken(path, file, size, invalid, Some((room, head)))
}

/// Reads a soundings CSV of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
    invalid: Invalid,
) -> Result<SoundingRecords, FormatError> {
    Ok(taken(file, source, size, invalid, None)?.0)
}

fn taken(
    file: &Path,
    source: impl Read,
    size: u64,
    invalid: Invalid,
    room: Option<(&Room, Option<u32>)>,
) -> Result<(SoundingRecords, Option<SoundingFile>), FormatError> {
    let table = Table::open(file, source, size, &REQUIRED, &OPTIONAL);
    let mut table = table.map_err(with_the_rest)?;
    let cones = two_arrays(&table)?;
    let (across, along) = if cones { (RX, TILT) } else { (3, 4) };
    let (column, limits) = range_column(&table)?;
    if cones && column == 5 {
        return Err(table.missing(&RANGES[1..]));
    }
    let heads = table.has(HEAD);
    let mut taken = Taken::new(room.filter(|_| !cones));
    let mut arrays = ArrayColumns::default();
    let left_out = table.each(Some(invalid), |table| {
        let (ping, beam) = (table.count(1)?, table.count(2)?);
        let across_rad = radians(table.number(across, &ANGLE)?);
        let along_rad = radians(table.number(along, &ALONG)?);
        let range = table.number(column, limits)?;
        let time_s = table.time(0, taken.last_s, false)?;
        let head = heads.then(|| table.count(HEAD)).transpose()?;
        if cones {
            array_row(table, &mut arrays)?;
        }
        let row = Sounding {
            time_s,
            ping,
            beam,
            across_rad,
            along_rad,
            range,
        };
        taken
            .take(row, head, table.expected_rows())
            .map_err(|error| no_room(&error))
    })?;
    check_angle_unit(&table, &taken, across)?;
    let (mut records, streamed) = taken.ended(column == 5).map_err(|error| no_room(&error))?;
    records.notes.extend(left_out);
    records.arrays = cones.then_some(arrays);
    Ok((records, streamed))
}

/// Where a column is missing that every file has, the others are named too: so that a header is mended at once.
fn with_the_rest(mut fault: FormatError) -> FormatError {
    if fault.kind == FaultKind::MissingColumn {
        let (angles, ranges) = (ANGLES.join(", "), RANGES.join(" or "));
        fault.expected.push_str(&format!(", {angles} and {ranges}"));
    }
    fault
}

fn no_room(error: &SpillError) -> FormatError {
    let found = error.refused();
    let (folder, expected) = (Path::new(&error.folder), "room for the soundings");
    FormatError::new(FaultKind::Unwritable, folder, Place::File, found, expected)
}

/// The rows taken so far: in columns, or in a file where there is no room for them.
struct Taken<'a> {
    records: SoundingRecords,
    range: Vec<f64>,
    room: Option<&'a Room>,
    /// The head whose soundings go to the file; those of all heads where there is none.
    wanted: Option<u32>,
    /// The heads that there are.
    heads: BTreeSet<u32>,
    writer: Option<SoundingWriter>,
    last_s: Option<f64>,
    /// Largest angle across, without sign.
    widest_rad: f64,
    /// Ping of the last rows, how many of them have it, and the most that one ping had.
    ping: (u32, usize, usize),
}

impl<'a> Taken<'a> {
    fn new(room: Option<(&'a Room, Option<u32>)>) -> Self {
        Self {
            records: empty(),
            range: vec![],
            room: room.map(|(room, _)| room),
            wanted: room.and_then(|(_, head)| head),
            heads: BTreeSet::new(),
            writer: None,
            last_s: None,
            widest_rad: 0.0,
            ping: (0, 0, 0),
        }
    }

    fn take(
        &mut self,
        row: Sounding,
        head: Option<u32>,
        expected_rows: usize,
    ) -> Result<(), SpillError> {
        if self.last_s.is_none() {
            self.begin(expected_rows)?;
        }
        self.last_s = Some(row.time_s);
        self.widest_rad = self.widest_rad.max(row.across_rad.abs());
        let (ping, beams, most) = self.ping;
        let beams = if ping == row.ping { beams + 1 } else { 1 };
        self.ping = (row.ping, beams, most.max(beams));
        self.heads.extend(head);
        let goes = self.goes(head);
        if let Some(writer) = &mut self.writer {
            return if goes { writer.push(&row) } else { Ok(()) };
        }
        self.push(&row);
        self.records.head.extend(head);
        match self.room {
            Some(room) if !room.holds(self.records.len()) => self.move_out(room),
            _ => Ok(()),
        }
    }

    /// Whether a sounding of a head goes to the file.
    fn goes(&self, head: Option<u32>) -> bool {
        head.is_none() || self.wanted.is_none() || head == self.wanted
    }

    /// Makes room for so many rows: in the file from the first on, if they will not all stay in memory.
    fn begin(&mut self, expected_rows: usize) -> Result<(), SpillError> {
        match self.room.filter(|room| !room.holds(expected_rows)) {
            Some(room) => self.writer = Some(room.writer()?),
            None => reserve(&mut self.records, &mut self.range, expected_rows),
        }
        Ok(())
    }

    fn push(&mut self, row: &Sounding) {
        self.records.time_s.push(row.time_s);
        self.records.ping.push(row.ping);
        self.records.beam.push(row.beam);
        self.records.across_rad.push(row.across_rad);
        self.records.along_rad.push(row.along_rad);
        self.range.push(row.range);
    }

    /// Moves the columns into a file: there were more rows than expected.
    fn move_out(&mut self, room: &Room) -> Result<(), SpillError> {
        let mut writer = room.writer()?;
        let (from, range) = (
            std::mem::replace(&mut self.records, empty()),
            std::mem::take(&mut self.range),
        );
        for (k, range) in range.into_iter().enumerate() {
            if !self.goes(from.head.get(k).copied()) {
                continue;
            }
            writer.push(&Sounding {
                time_s: from.time_s[k],
                ping: from.ping[k],
                beam: from.beam[k],
                across_rad: from.across_rad[k],
                along_rad: from.along_rad[k],
                range,
            })?;
        }
        self.writer = Some(writer);
        Ok(())
    }

    fn ended(self, metres: bool) -> Result<(SoundingRecords, Option<SoundingFile>), SpillError> {
        let (mut records, mut range) = (self.records, self.range);
        for column in [
            &mut records.time_s,
            &mut records.across_rad,
            &mut records.along_rad,
            &mut range,
        ] {
            column.shrink_to_fit();
        }
        records.ping.shrink_to_fit();
        records.beam.shrink_to_fit();
        records.range = if metres {
            SoundingRange::Metres(range)
        } else {
            SoundingRange::TwoWayTravelTime(range)
        };
        let streamed = self.writer.map(SoundingWriter::finish).transpose()?;
        if streamed.is_some() {
            records.head = self.heads.into_iter().collect();
        }
        Ok((records, streamed))
    }
}

/// Whether the angles are those of two arrays.
fn two_arrays<R: Read>(table: &Table<R>) -> Result<bool, FormatError> {
    let cones = table.has(RX) || table.has(TILT);
    let (wanted, first) = if cones { (CONES, RX) } else { (ANGLES, 3) };
    for (k, name) in wanted.iter().enumerate() {
        if !table.has(first + k) {
            return Err(table.missing(&[name]));
        }
    }
    if cones && (table.has(3) || table.has(4)) {
        let found = format!("both {} and {}", ANGLES[0], CONES[0]);
        let expected = "the angles of one head, or those of two arrays";
        return Err(table.fault(FaultKind::BadValue, RX, found, expected));
    }
    Ok(cones)
}

/// What only two arrays have, of one row. The sector is for the reader of the file: its delay and tilt stand in the row.
fn array_row<R: Read>(table: &Table<R>, arrays: &mut ArrayColumns) -> Result<(), FormatError> {
    if table.has(SECTOR) {
        table.count(SECTOR)?;
    }
    let value = |column: usize, limits: &Limits| {
        if table.has(column) {
            table.number(column, limits)
        } else {
            Ok(0.0)
        }
    };
    let (delay_s, head_speed_m_s) = (value(DELAY, &DELAYS)?, value(SPEED, &HEAD_SPEED)?);
    arrays.delay_s.push(delay_s);
    arrays.head_speed_m_s.push(head_speed_m_s);
    Ok(())
}

/// Which of the two range columns is there.
fn range_column<R: Read>(table: &Table<R>) -> Result<(usize, &'static Limits), FormatError> {
    match (table.has(5), table.has(6)) {
        (true, false) => Ok((5, &RANGE)),
        (false, true) => Ok((6, &TRAVEL_TIME)),
        (false, false) => Err(table.missing(&RANGES)),
        (true, true) => Err(table.fault(
            FaultKind::BadValue,
            5,
            format!("both {} and {}", RANGES[0], RANGES[1]),
            "one of them",
        )),
    }
}

fn empty() -> SoundingRecords {
    SoundingRecords {
        time_s: vec![],
        ping: vec![],
        beam: vec![],
        across_rad: vec![],
        along_rad: vec![],
        range: SoundingRange::Metres(vec![]),
        arrays: None,
        head: vec![],
        notes: vec![],
    }
}

fn reserve(records: &mut SoundingRecords, range: &mut Vec<f64>, rows: usize) {
    records.time_s.reserve(rows);
    records.ping.reserve(rows);
    records.beam.reserve(rows);
    records.across_rad.reserve(rows);
    records.along_rad.reserve(rows);
    range.reserve(rows);
}

/// Beams a ping must have before its swath says anything about the unit.
const MANY_BEAMS: usize = 16;

/// Refuses across angles that are all within a right angle in radians although pings of many beams fan out with them:
/// no multibeam has a swath of three degrees.
fn check_angle_unit<R: Read>(
    table: &Table<R>,
    taken: &Taken,
    column: usize,
) -> Result<(), FormatError> {
    let (widest, (_, _, beams)) = (degrees(taken.widest_rad), taken.ping);
    if !(0.05..=1.6).contains(&widest) || beams < MANY_BEAMS {
        return Ok(());
    }
    let found =
        format!("angles within {widest:.3} over pings of up to {beams} beams, which are radians");
    Err(table.fault(
        FaultKind::WrongUnit,
        column,
        found,
        "degrees, positive to starboard",
    ))
}

// WRITE

/// Writes a soundings CSV: time as it is, angles to 1e-7 deg, ranges to 1 micrometre, travel times to 1 nanosecond.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, soundings: &Soundings) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, soundings))
}

/// Writes a soundings CSV into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, soundings: &Soundings) -> std::io::Result<()> {
    if let Some(arrays) = &soundings.arrays {
        return write_arrays_to(out, &columns(soundings, arrays));
    }
    rows_to(out, soundings, &[])
}

/// Soundings of two arrays, whose times are those of transmission, as a file's columns.
fn columns(soundings: &Soundings, arrays: &SoundingArrays) -> SoundingRecords {
    let head_speed_m_s = arrays.head_speed_m_s.iter().map(|speed| f64::from(*speed));
    SoundingRecords {
        time_s: soundings.time_s.clone(),
        ping: soundings.ping.clone(),
        beam: soundings.beam.clone(),
        across_rad: soundings.across_rad.clone(),
        along_rad: soundings.along_rad.clone(),
        range: soundings.range.clone(),
        arrays: Some(ArrayColumns {
            delay_s: vec![0.0; soundings.len()],
            head_speed_m_s: head_speed_m_s.collect(),
        }),
        head: vec![],
        notes: vec![],
    }
}

/// What stands behind the last column of a row, or of the header: the head, where the file has several.
fn behind(head: &[u32], row: Option<usize>) -> String {
    match row {
        _ if head.is_empty() => String::new(),
        None => format!(",{HEAD_NAME}"),
        Some(k) => format!(",{}", head[k]),
    }
}

fn rows_to(out: &mut impl Write, soundings: &Soundings, head: &[u32]) -> std::io::Result<()> {
    let (name, decimals) = match soundings.range {
        SoundingRange::Metres(_) => (RANGES[0], 6),
        SoundingRange::TwoWayTravelTime(_) => (RANGES[1], 9),
    };
    let (required, angles) = (REQUIRED.join(","), ANGLES.join(","));
    writeln!(out, "{required},{angles},{name}{}", behind(head, None))?;
    for k in 0..soundings.len() {
        let ([across_rad, along_rad, range], (ping, beam)) =
            (soundings.measured(k), soundings.name(k));
        writeln!(
            out,
            "{},{ping},{beam},{:.7},{:.7},{range:.decimals$}{}",
            soundings.at_s(k),
            degrees(across_rad),
            degrees(along_rad),
            behind(head, Some(k)),
        )?;
    }
    Ok(())
}

/// Writes the columns of a soundings file again: of two arrays with angles to 1e-7 deg, times to 1 nanosecond.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write_records(path: &Path, mut records: SoundingRecords) -> Result<(), FormatError> {
    if records.arrays.is_some() {
        return write_whole(path, |out| write_arrays_to(out, &records));
    }
    let none = SonarNoise {
        range_m: 0.0,
        across_rad: 0.0,
        along_rad: 0.0,
    };
    let head = std::mem::take(&mut records.head);
    let soundings = records.into_soundings(none);
    write_whole(path, |out| rows_to(out, &soundings, &head))
}

fn write_arrays_to(out: &mut impl Write, records: &SoundingRecords) -> std::io::Result<()> {
    let (names, cones, range) = (REQUIRED.join(","), CONES.join(","), RANGES[1]);
    writeln!(
        out,
        "{names},{cones},{range},tx_delay_s,head_sound_speed_m_s{}",
        behind(&records.head, None)
    )?;
    let arrays = records.arrays.iter();
    for arrays in arrays {
        for (k, two_way_s) in records.range.values().iter().enumerate() {
            writeln!(
                out,
                "{},{},{},{:.7},{:.7},{two_way_s:.9},{:.9},{:.4}{}",
                records.time_s[k],
                records.ping[k],
                records.beam[k],
                degrees(records.across_rad[k]),
                degrees(records.along_rad[k]),
                arrays.delay_s[k],
                arrays.head_speed_m_s[k],
                behind(&records.head, Some(k)),
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize) -> String {
        let mut text = "time_s,ping,beam,across_angle_deg,along_angle_deg,range_m\n".to_owned();
        for k in 0..count {
            let (ping, beam) = (k / 20, k % 20);
            let time_s = 0.1 * ping as f64;
            text += &format!(
                "{time_s},{ping},{beam},{},0.5,{}\n",
                5 * beam,
                3.0 + 0.001 * k as f64
            );
        }
        text
    }

    #[test]
    fn a_foreign_header_is_told_every_column_at_once() {
        let foreign = "Time,PingNo,BeamNo,Angle,Tilt,Range\n1,0,0,0,0,5\n";
        let fault = read_from(Path::new("s.csv"), foreign.as_bytes(), 1, Invalid::Error);
        let said = fault.expect_err("refused").to_string();
        for name in REQUIRED.iter().chain(&ANGLES).chain(&RANGES) {
            assert!(said.contains(name), "{name}: {said}");
        }
    }

    /// Whether the rows are expected to fit or not, whether they do or not, and wherever they stop to.
    #[test]
    fn rows_without_room_are_in_the_file_and_the_same() {
        let (text, file) = (rows(10_000), Path::new("s.csv"));
        let of = |bytes: u64, size: u64| {
            let room = Room {
                bytes,
                folder: None,
            };
            let source = text.as_bytes();
            taken(file, source, size, Invalid::Error, Some((&room, None))).expect("soundings")
        };
        let (all, none) = of(u64::MAX, text.len() as u64);
        assert!(none.is_none() && all.len() == 10_000);
        for (bytes, size) in [(0, text.len() as u64), (399_999, 1), (40_000, 1)] {
            let (empty, streamed) = of(bytes, size);
            let streamed = streamed.expect("a file");
            assert!(empty.is_empty() && streamed.len() == 10_000);
            for k in 0..10_000 {
                let row = streamed.row(k);
                let measured = [all.across_rad[k], all.along_rad[k], all.range.values()[k]];
                assert_eq!(
                    (row.time_s, row.ping, row.beam),
                    (all.time_s[k], all.ping[k], all.beam[k])
                );
                assert_eq!([row.across_rad, row.along_rad, row.range], measured);
            }
        }
    }

    #[test]
    fn of_several_heads_one_is_in_the_file() {
        let (mut text, size) = (String::new(), rows(10_000).len() as u64);
        for (k, line) in rows(10_000).lines().enumerate() {
            let head = ["head", "7", "4"][if k == 0 { 0 } else { 1 + k % 3 / 2 }];
            text += &format!("{line},{head}\n");
        }
        let of = |bytes, size, head| {
            let room = Room {
                bytes,
                folder: None,
            };
            let (file, source) = (Path::new("s.csv"), text.as_bytes());
            taken(file, source, size, Invalid::Error, Some((&room, head))).expect("soundings")
        };
        let (all, _) = of(u64::MAX, size, Some(4));
        assert_eq!((all.len(), all.heads()), (10_000, vec![4, 7]));
        for (bytes, size) in [(0, size), (40_000, 1)] {
            for (head, rows) in [(Some(4), 3333), (Some(7), 6667), (None, 10_000)] {
                let (records, streamed) = of(bytes, size, head);
                let streamed = streamed.expect("a file");
                assert_eq!((streamed.len(), &records.head), (rows, &vec![4, 7]));
                let own = |k: &usize| head.is_none_or(|head| all.head[*k] == head);
                for (row, k) in (0..10_000).filter(own).enumerate() {
                    let found = streamed.row(row);
                    assert_eq!((found.time_s, found.beam), (all.time_s[k], all.beam[k]));
                }
            }
        }
    }

    #[test]
    fn angles_in_radians_are_refused_in_a_file_too() {
        let room = Room {
            bytes: 0,
            folder: None,
        };
        let header = rows(0);
        let radians: String = (0..20)
            .map(|b| format!("0,0,{b},{},0,3\n", 0.05 * f64::from(b)))
            .collect();
        let text = format!("{header}{radians}");
        let source = text.as_bytes();
        let refused = taken(
            Path::new("s.csv"),
            source,
            100,
            Invalid::Error,
            Some((&room, None)),
        );
        assert_eq!(refused.unwrap_err().kind, FaultKind::WrongUnit);
    }
}
