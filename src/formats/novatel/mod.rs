//! NovAtel logs, binary and ASCII, also mixed: INSPVA, INSPVAS, INSPVAX (position and attitude), INSATT, INSATTS (attitude).
//!
//! ```text
//! AA 44 12 | u8 header bytes | u16 id | .. | u16 body bytes | .. | u16 week | u32 ms | .. | body | CRC-32
//! AA 44 13 | u8 body bytes | u16 id | u16 week | u32 ms | body | CRC-32
//! #NAMEA,header fields;body fields*crc      %NAMEA,week,seconds;body fields*crc
//! ```
//!
//! Axes are ours (right, forward, up), azimuth clockwise from north. Times are GPS time. INSPVAX gives its height above the geoid and
//! the undulation; both are added here, so that every height is above the ellipsoid. Only solutions marked good are used.

pub mod raw;

use std::io::Read;
use std::path::Path;

use self::raw::{CRC, Header, LONG_HEADER, SHORT_HEADER, SOLUTION_GOOD, Solution, crc};
use super::error::{FormatError, open};
use super::recorder::{
    Attitude, Bytes, Frame, Framing, Losses, Position, Sink, Summary, TimeScale, Window, holds,
    scan, utc,
};
use crate::units::radians;

/// Longest line of an ASCII message that is looked at.
const LINE: usize = 2048;

/// How messages are framed.
struct Messages;

impl Framing for Messages {
    const HEAD: usize = LINE;
    const END_MARK: bool = false;

    fn length(&self, head: &[u8]) -> Option<usize> {
        if matches!(head.first(), Some(b'#' | b'%')) {
            return line_length(head);
        }
        let header = Header::read(&Bytes::little(head))?;
        let least = SHORT_HEADER.min(LONG_HEADER);
        (header.bytes >= least).then_some(header.bytes + header.body + CRC)
    }

    fn check(&self, record: &[u8]) -> Frame {
        let good = if record[0] == 0xAA {
            let end = record.len() - CRC;
            Bytes::little(record).u32(end) == Some(crc(&record[..end]))
        } else {
            let end = record.len() - 9;
            let written = std::str::from_utf8(&record[end + 1..]).ok();
            let sum = written.and_then(|hex| u32::from_str_radix(hex, 16).ok());
            sum == Some(crc(&record[1..end]))
        };
        match good {
            true => Frame::Good,
            false => Frame::BadChecksum,
        }
    }
}

/// Bytes of an ASCII message up to the end of its checksum, if one begins here.
fn line_length(head: &[u8]) -> Option<usize> {
    let named = head.get(1..4)?.iter().all(u8::is_ascii_uppercase);
    let line = &head[..head.len().min(LINE)];
    let text = line.iter().take_while(|b| (0x20..0x7f).contains(*b));
    let star = text.take_while(|b| **b != b'*').count();
    let whole = line.get(..star + 9)?;
    let hex = whole[star + 1..].iter().all(u8::is_ascii_hexdigit);
    (named && whole[star] == b'*' && hex).then_some(star + 9)
}

/// Whether a file's first bytes are such a message.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    Messages.length(head).is_some()
}

/// Whether two such messages stand one behind the other anywhere in these bytes.
#[must_use]
pub fn within(bytes: &[u8]) -> bool {
    holds(&Messages, bytes)
}

/// Reads a log, handing every record to `sink`.
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
    let mut reader = Reader {
        sink,
        summary: Summary {
            time: TimeScale::Gps,
            device: "NovAtel INS".to_owned(),
            refusal: Some("navigation only: no soundings".to_owned()),
            ..Summary::of("novatel")
        },
    };
    reader.summary.note(
        "the point whose position it is, is a setting of the receiver and not in these messages",
    );
    let mut losses = Losses::default();
    let mut window = Window::new(file, source);
    let mut between = LineEnds(0);
    scan(&mut window, &Messages, &mut losses, |record, losses| {
        reader.take(record, losses);
        between.0 += u64::from(record[0] != 0xAA);
        Ok(())
    })?;
    between.take_off(&mut losses);
    reader.summary.losses = losses;
    Ok(reader.summary)
}

/// Line ends behind ASCII messages are no loss: up to two bytes each.
struct LineEnds(u64);

impl LineEnds {
    fn take_off(&self, losses: &mut Losses) {
        let most = losses.skipped_bytes.min(2 * self.0);
        losses.skipped_bytes -= most;
        losses.skipped_places = losses.skipped_places.saturating_sub(self.0);
    }
}

struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
}

impl Reader<'_> {
    fn take(&mut self, record: &[u8], losses: &mut Losses) {
        if record[0] == 0xAA {
            self.binary(&Bytes::little(record), losses);
        } else {
            self.ascii(record, losses);
        }
    }

    fn binary(&mut self, record: &Bytes, losses: &mut Losses) {
        let Some(header) = Header::read(record) else {
            return;
        };
        let sensor = match header.id {
            raw::INSPVA | raw::INSPVAS => 0,
            raw::INSPVAX => 1,
            raw::INSATT | raw::INSATTS => 2,
            id => return self.summary.count(&id.to_string()),
        };
        self.summary.count(name(header.id));
        let body = record.part(header.bytes, header.body);
        match body.and_then(|b| Solution::read(&header, &b)) {
            Some(solution) => self.solution(&solution, sensor, losses),
            None => losses.malformed += 1,
        }
    }

    fn ascii(&mut self, record: &[u8], losses: &mut Losses) {
        let text = String::from_utf8_lossy(&record[1..record.len() - 9]);
        let (head, body) = text.split_once(';').unwrap_or((&text, ""));
        let header: Vec<&str> = head.split(',').collect();
        let name = header[0].strip_suffix('A').unwrap_or(header[0]);
        self.summary.count(name);
        let sensor = match name {
            "INSPVA" | "INSPVAS" => 0,
            "INSPVAX" => 1,
            "INSATT" | "INSATTS" => 2,
            _ => return,
        };
        let body: Vec<&str> = body.split(',').collect();
        match Solution::parse(name, &header, &body) {
            Some(solution) => self.solution(&solution, sensor, losses),
            None => losses.malformed += 1,
        }
    }

    fn solution(&mut self, s: &Solution, sensor: u8, losses: &mut Losses) {
        let time_s = utc::from_gps_week(s.week, s.week_s);
        let [roll, pitch, azimuth] = s.attitude_deg;
        let possible = roll.abs() <= 180.0 && pitch.abs() <= 90.0 && azimuth.abs() <= 360.0;
        if s.status != SOLUTION_GOOD {
            losses.not_good += 1;
            return;
        }
        if !possible || !(0.0..=utc::WEEK_S).contains(&s.week_s) {
            losses.impossible += 1;
            return;
        }
        self.sink.attitude(&Attitude {
            time_s,
            roll_rad: radians(roll),
            pitch_rad: radians(pitch),
            heading_rad: Some(radians(azimuth)),
            sensor,
            ..Attitude::default()
        });
        let Some([latitude_deg, longitude_deg, height_m]) = s.place else {
            return;
        };
        let height_m = height_m + s.undulation_m.unwrap_or(0.0);
        if !(latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0 && height_m.abs() < 2e4) {
            losses.impossible += 1;
            return;
        }
        self.sink.position(&Position {
            time_s,
            latitude_rad: radians(latitude_deg),
            longitude_rad: radians(longitude_deg),
            height_m: Some(height_m),
            sensor,
            ..Position::default()
        });
    }
}

fn name(id: u16) -> &'static str {
    match id {
        raw::INSPVA => "INSPVA",
        raw::INSPVAS => "INSPVAS",
        raw::INSPVAX => "INSPVAX",
        raw::INSATT => "INSATT",
        _ => "INSATTS",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::recorder::Out;

    #[derive(Default)]
    struct All(Vec<Attitude>, Vec<Position>);
    impl Sink for All {
        fn attitude(&mut self, record: &Attitude) {
            self.0.push(*record);
        }
        fn position(&mut self, record: &Position) {
            self.1.push(*record);
        }
    }

    fn read_bytes(bytes: &[u8]) -> (All, Summary) {
        let mut all = All::default();
        let summary = read_from(Path::new("a.gps"), bytes, &mut all).expect("readable");
        (all, summary)
    }

    /// A short-header INSPVAS by hand.
    fn binary(week_s: f64, status: u32) -> Vec<u8> {
        let mut out = Out::new(false);
        out.raw(&[0xAA, 0x44, 0x13, 88])
            .u16(508)
            .u16(2100)
            .u32(1000);
        out.u32(2100).f64(week_s).f64(51.0).f64(-114.0).f64(1080.5);
        out.f64(0.0).f64(0.0).f64(0.0).f64(1.0).f64(-2.0).f64(270.0);
        out.u32(status);
        let sum = crc(&out.data);
        out.u32(sum);
        out.data
    }

    const INSPVASA: &str = "INSPVASA,1264,144059.000;1264,144059.002135700,51.116680071,-114.037929194,515.286704183,277.896368884,84.915188605,-8.488207941,0.759619515,-2.892414901,6.179554750,INS_SOLUTION_GOOD";

    fn line(begin: char, text: &str) -> String {
        format!("{begin}{text}*{:08x}\r\n", crc(text.as_bytes()))
    }

    #[test]
    fn a_binary_message_by_hand() {
        let (all, summary) = read_bytes(&binary(345_600.25, 3));
        assert!(!summary.losses.any());
        assert_eq!(all.0[0].time_s, utc::from_gps_week(2100, 345_600.25));
        assert_eq!(all.0[0].heading_rad, Some(270f64.to_radians()));
        assert_eq!(all.0[0].pitch_rad, (-2f64).to_radians());
        assert_eq!(all.1[0].height_m, Some(1080.5));
    }

    /// Text and checksum of an example in the maker's manual.
    #[test]
    fn the_checksum_is_the_makers() {
        let text = "BESTPOSA,COM1,0,78.0,FINESTEERING,1427,325298.000,00000000,6145,2748;SOL_COMPUTED,SINGLE,51.11678928753,-114.03886216575,1064.3470,-16.2708,WGS84,2.3434,1.3043,4.7300,\"\",0.000,0.000,7,7,0,0,0,06,0,03";
        assert_eq!(crc(text.as_bytes()), 0x9c9a_92bb);
    }

    #[test]
    fn ascii_messages_between_line_ends() {
        let (all, summary) = read_bytes(line('%', INSPVASA).repeat(2).as_bytes());
        assert!(!summary.losses.any(), "{:?}", summary.losses);
        assert_eq!(summary.records["INSPVAS"], 2);
        assert_eq!(all.0[0].roll_rad, 0.759619515f64.to_radians());
        assert_eq!(all.1[0].latitude_rad, 51.116680071f64.to_radians());
    }

    #[test]
    fn the_extended_ascii_message_gives_its_height_above_the_ellipsoid() {
        let text = "INSPVAXA,COM1,0,73.5,FINESTEERING,1695,309428.000,02000040,4e77,43562;INS_SOLUTION_GOOD,INS_PSRSP,51.116,-114.038,1063.6,-16.9,-0.06,0.01,-0.01,-1.5,0.25,88.5,3.3,2.6,5.7,0.1,0.1,0.1,0.4,0.4,0.9,0,0";
        let (all, summary) = read_bytes(line('#', text).as_bytes());
        assert!(!summary.losses.any(), "{:?}", summary.losses);
        let height_m = all.1[0].height_m.expect("a height");
        assert!((height_m - 1046.7).abs() < 1e-9);
        assert_eq!(all.0[0].heading_rad, Some(88.5f64.to_radians()));
        assert_eq!(all.0[0].time_s, utc::from_gps_week(1695, 309_428.0));
    }

    #[test]
    fn a_wrong_checksum_and_a_solution_that_is_not_good_are_not_used() {
        let mut wrong = binary(2.0, 3);
        wrong[30] ^= 1;
        let bytes = [binary(1.0, 3), wrong, binary(3.0, 1), binary(4.0, 3)].concat();
        let (all, summary) = read_bytes(&bytes);
        assert_eq!(all.0.len(), 2);
        assert_eq!(
            (summary.losses.bad_checksums, summary.losses.not_good),
            (1, 1)
        );
    }
}
