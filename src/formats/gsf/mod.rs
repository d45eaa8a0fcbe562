//! GSF 3: navigation (pings and attitude records) and sound speed. No calibration: the tilt of a beam's sector is not in it.
//!
//! ```text
//! u32 bytes of data | u32 kind, bit 31: a u32 checksum follows | data          (big-endian)
//! ```
//!
//! Nothing marks the beginning of a record: one is believed where the next one follows. Version 2 has other layouts and is refused.

use std::io::Read;
use std::path::Path;

use super::error::{FormatError, open};
use super::recorder::{
    Attitude, Bytes, Frame, Framing, Losses, Position, Profile, Sink, Summary, Window, scan,
};
use crate::units::radians;

/// More bytes than any record has.
const LONGEST: usize = 1 << 22;
/// Kinds of records.
const KINDS: std::ops::RangeInclusive<u32> = 1..=12;
/// Bytes of the fixed part of a ping.
const PING: usize = 56;

/// How records are framed.
struct Records;

impl Framing for Records {
    const HEAD: usize = 8;
    const END_MARK: bool = false;

    fn length(&self, head: &[u8]) -> Option<usize> {
        let length = plausible(head)?;
        match head.get(length..length + 8) {
            Some(next) => plausible(next).map(|_| length),
            None => Some(length),
        }
    }

    fn check(&self, _: &[u8]) -> Frame {
        Frame::Good
    }
}

/// Bytes of the record that these may begin.
fn plausible(head: &[u8]) -> Option<usize> {
    let b = Bytes::big(head);
    let (size, kind) = (b.u32(0)? as usize, b.u32(4)?);
    let summed = kind >> 31 == 1;
    let known = KINDS.contains(&(kind & 0x7FFF_FFFF)) && size > 0 && size < LONGEST;
    known.then_some(8 + size + if summed { 4 } else { 0 })
}

/// Whether a file's first bytes are such a header.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    plausible(head).is_some() && head.get(8..13) == Some(b"GSF-v")
}

/// Reads a file, handing every record to `sink`.
///
/// # Errors
/// [`FormatError`] when it cannot be read. Damage is counted in the summary.
pub fn read(path: &Path, sink: &mut dyn Sink) -> Result<Summary, FormatError> {
    read_from(path, open(path)?.0, sink)
}

/// Reads from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    sink: &mut dyn Sink,
) -> Result<Summary, FormatError> {
    let mut summary = Summary::of("gsf");
    let reason = "GSF holds no tilt of the transmit sectors and its angles are from the vertical: use the sounder's own file (.all, .kmall, .s7k, XTF)";
    summary.refusal = Some(reason.to_owned());
    summary.applied("angles are from the vertical: roll and pitch are taken off them");
    let mut reader = Reader {
        sink,
        summary,
        old: false,
    };
    let mut losses = Losses::default();
    let mut window = Window::new(file, source);
    scan(&mut window, &Records, &mut losses, |record, losses| {
        let record = Bytes::big(record);
        losses.malformed += u64::from(reader.take(&record, losses).is_none());
        Ok(())
    })?;
    reader.summary.losses = losses;
    Ok(reader.summary)
}

struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    old: bool,
}

impl Reader<'_> {
    fn take(&mut self, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let kind = record.u32(4)?;
        let begin = if kind >> 31 == 1 { 12 } else { 8 };
        let data = record.part(begin, record.data.len() - begin)?;
        let kind = kind & 0x7FFF_FFFF;
        self.summary.count(name(kind));
        match kind {
            1 => self.version(&data),
            2 if !self.old => self.ping(&data, losses),
            3 if !self.old => self.profile(&data, losses),
            12 if !self.old => self.attitude(&data, losses),
            _ => Some(()),
        }
    }

    fn version(&mut self, data: &Bytes) -> Option<()> {
        let version = data.text(0, data.data.len())?;
        self.old = !version.starts_with("GSF-v03");
        if self.old {
            self.summary
                .note(format!("{version}: only version 3 is read"));
        }
        self.summary.device = version;
        Some(())
    }

    fn ping(&mut self, data: &Bytes, losses: &mut Losses) -> Option<()> {
        let data = data.part(0, PING)?;
        let time_s = unix_s(&data, 0)?;
        let degrees = |at| Some(f64::from(data.i32(at)?) * 1e-7);
        let (longitude, latitude) = (degrees(8)?, degrees(12)?);
        if latitude.abs() <= 90.0 && longitude.abs() <= 180.0 {
            let height_m = 1e-3 * f64::from(data.i32(42)?);
            self.sink.position(&Position {
                time_s,
                latitude_rad: radians(latitude),
                longitude_rad: radians(longitude),
                height_m: (height_m != 0.0 && height_m.abs() < 2e4).then_some(height_m),
                ..Position::default()
            });
        } else {
            losses.impossible += 1;
        }
        Some(())
    }

    /// Rows of time after the base, pitch, roll, heave, heading.
    fn attitude(&mut self, data: &Bytes, losses: &mut Losses) -> Option<()> {
        let base_s = unix_s(data, 0)?;
        let count = usize::from(data.u16(8)?);
        for row in data.parts(10, count, 10)? {
            let hundredths = |at| Some(0.01 * f64::from(row.i16(at)?));
            let (pitch, roll, heave) = (hundredths(2)?, hundredths(4)?, hundredths(6)?);
            let heading = 0.01 * f64::from(row.u16(8)?);
            if pitch.abs() > 90.0 || roll.abs() > 180.0 || heading > 360.0 {
                losses.impossible += 1;
                continue;
            }
            self.sink.attitude(&Attitude {
                time_s: base_s + 1e-3 * f64::from(row.u16(0)?),
                roll_rad: radians(roll),
                pitch_rad: radians(pitch),
                heading_rad: Some(radians(heading)),
                heave_m: Some(heave),
                ..Attitude::default()
            });
        }
        Some(())
    }

    fn profile(&mut self, data: &Bytes, losses: &mut Losses) -> Option<()> {
        let count = data.u32(24)? as usize;
        let mut profile = Profile {
            time_s: unix_s(data, 0)?,
            ..Profile::default()
        };
        for row in data.parts(28, count, 8)? {
            let depth_m = 0.01 * f64::from(row.u32(0)?);
            let speed_m_s = 0.01 * f64::from(row.u32(4)?);
            let below = profile.depth_m.last().is_none_or(|d| depth_m > *d);
            if below && (1000.0..2000.0).contains(&speed_m_s) {
                profile.depth_m.push(depth_m);
                profile.speed_m_s.push(speed_m_s);
            } else {
                losses.impossible += 1;
            }
        }
        self.sink.profile(&profile);
        Some(())
    }
}

/// Unix time of whole seconds and nanoseconds.
fn unix_s(data: &Bytes, at: usize) -> Option<f64> {
    Some(f64::from(data.i32(at)?) + 1e-9 * f64::from(data.i32(at + 4)?))
}

fn name(kind: u32) -> &'static str {
    const NAMES: [&str; 13] = [
        "?",
        "header",
        "ping",
        "sound speed",
        "processing",
        "sensor",
        "comment",
        "history",
        "navigation error",
        "single-beam ping",
        "swath summary",
        "single-beam ping",
        "attitude",
    ];
    NAMES.get(kind as usize).copied().unwrap_or("?")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::recorder::Out;

    #[derive(Default)]
    struct All(Vec<Attitude>, Vec<Position>, Vec<Profile>);
    impl Sink for All {
        fn attitude(&mut self, record: &Attitude) {
            self.0.push(*record);
        }
        fn position(&mut self, record: &Position) {
            self.1.push(*record);
        }
        fn profile(&mut self, record: &Profile) {
            self.2.push(record.clone());
        }
    }

    fn record(kind: u32, data: &Out) -> Vec<u8> {
        let mut out = Out::new(true);
        out.u32(data.data.len() as u32).u32(kind).raw(&data.data);
        out.data
    }

    fn header(version: &str) -> Vec<u8> {
        let mut out = Out::new(true);
        out.raw(version.as_bytes()).zeros(2);
        record(1, &out)
    }

    fn records() -> Vec<u8> {
        let mut ping = Out::new(true);
        ping.u32(1_000_000_000).u32(500_000_000);
        ping.i32(-1_200_000_000)
            .i32(450_000_000)
            .zeros(26)
            .i32(-20_500)
            .zeros(10);
        let mut profile = Out::new(true);
        profile.u32(1_000_000_000).u32(0).zeros(16).u32(2);
        profile.u32(0).u32(150_000).u32(1000).u32(149_000);
        let mut attitude = Out::new(true);
        attitude.u32(1_000_000_000).u32(0).u16(1);
        attitude.u16(250).i16(-150).i16(275).i16(-30).u16(20_000);
        [record(2, &ping), record(3, &profile), record(12, &attitude)].concat()
    }

    #[test]
    fn records_by_hand() {
        let bytes = [header("GSF-v03.06"), records()].concat();
        let mut all = All::default();
        let summary = read_from(Path::new("a.gsf"), bytes.as_slice(), &mut all).expect("readable");
        assert!(!summary.losses.any(), "{:?}", summary.losses);
        assert!(begins(&bytes) && summary.refusal.is_some());
        assert_eq!(all.1[0].time_s, 1_000_000_000.5);
        assert_eq!(all.1[0].latitude_rad, 45f64.to_radians());
        assert_eq!(all.1[0].height_m, Some(-20.5));
        assert_eq!(all.2[0].speed_m_s, [1500.0, 1490.0]);
        assert_eq!(all.0[0].roll_rad, 2.75f64.to_radians());
        assert_eq!(all.0[0].heave_m, Some(-0.3));
    }

    #[test]
    fn version_2_is_not_read() {
        let bytes = [header("GSF-v02.09"), records()].concat();
        let mut all = All::default();
        let summary = read_from(Path::new("a.gsf"), bytes.as_slice(), &mut all).expect("readable");
        assert!(all.1.is_empty() && summary.notes[0].contains("only version 3"));
    }

    #[test]
    fn the_next_record_is_found_after_garbage() {
        let bytes = [header("GSF-v03.06"), vec![0xEE; 37], records()].concat();
        let mut all = All::default();
        let summary = read_from(Path::new("a.gsf"), bytes.as_slice(), &mut all).expect("readable");
        assert_eq!((all.0.len(), all.1.len(), all.2.len()), (1, 1, 1));
        assert!(summary.losses.skipped_bytes >= 37);
    }
}
