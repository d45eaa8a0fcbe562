//! POS MV groups 1 (vessel), 102 and 103 (sensors 1 and 2): position and attitude. Tried on no real file.
//!
//! ```text
//! $GRP | u16 group | u16 bytes of the rest | f64 time 1 | f64 time 2 | f64 distance | u8 u8 types | data | u16 sum | $#
//! ```
//!
//! The sum of all 16-bit words of a group is zero. Axes are forward, starboard, down: roll, pitch and heading are ours, heave is turned.
//! Times are seconds of the week, GPS or UTC as flagged; the groups that are read here do not say the week.

pub mod raw;

use std::io::Read;
use std::path::Path;

use self::raw::{HEADER, Header, LONGEST, Solution};
use super::error::{FormatError, open};
use super::recorder::{
    Attitude, Bytes, Frame, Framing, Losses, Position, Sink, Summary, TimeScale, Window, holds,
    scan, utc,
};
use super::week;
use crate::units::radians;

/// How groups are framed.
struct Groups;

impl Framing for Groups {
    const HEAD: usize = 8;
    const END_MARK: bool = true;

    fn length(&self, head: &[u8]) -> Option<usize> {
        if !matches!(head.get(..4)?, b"$GRP" | b"$MSG") {
            return None;
        }
        let length = 8 + usize::from(Bytes::little(head).u16(6)?);
        (12..=LONGEST).contains(&length).then_some(length)
    }

    fn check(&self, record: &[u8]) -> Frame {
        let words = record.as_chunks::<2>().0;
        let sum = words.iter().map(|w| u16::from_le_bytes(*w));
        match sum.fold(0, u16::wrapping_add) {
            _ if !record.ends_with(b"$#") => Frame::Nothing,
            0 => Frame::Good,
            _ => Frame::BadChecksum,
        }
    }
}

/// Whether a file's first bytes are such a group.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    Groups.length(head).is_some()
}

/// Whether two such groups stand one behind the other anywhere in these bytes.
#[must_use]
pub fn within(bytes: &[u8]) -> bool {
    holds(&Groups, bytes)
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
    let mut reader = Reader {
        sink,
        summary: Summary {
            time: TimeScale::SecondsOfWeek,
            device: "Applanix POS MV".to_owned(),
            refusal: Some("navigation only: no soundings".to_owned()),
            ..Summary::of("pos-mv")
        },
        last_s: None,
    };
    let mut losses = Losses::default();
    let mut window = Window::new(file, source);
    scan(&mut window, &Groups, &mut losses, |record, losses| {
        let record = Bytes::little(record);
        losses.malformed += u64::from(reader.take(&record, losses).is_none());
        Ok(())
    })?;
    reader.summary.losses = losses;
    Ok(reader.summary)
}

struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    /// Time of the last solution, counted on over the end of a week.
    last_s: Option<f64>,
}

impl Reader<'_> {
    fn take(&mut self, record: &Bytes, losses: &mut Losses) -> Option<()> {
        if record.data.starts_with(b"$MSG") {
            self.summary.count("messages");
            return Some(());
        }
        let group = record.u16(4)?;
        self.summary.count(&group.to_string());
        if !matches!(group, 1 | 102 | 103) {
            return Some(());
        }
        let header = Header::read(record)?;
        let data = record.part(HEADER, record.data.len().checked_sub(HEADER + 4)?)?;
        let solution = Solution::read(group, &data)?;
        self.note_scale(header.scale);
        if solution.alignment.is_some_and(|a| a != 0) || header.scale == 0 {
            losses.not_good += 1;
        } else {
            self.solution(&header, &solution, losses);
        }
        Some(())
    }

    fn note_scale(&mut self, scale: u8) {
        match scale {
            0 => self
                .summary
                .note("some times are counted from power-on and cannot be used"),
            1 => self
                .summary
                .note("times are flagged as GPS seconds of the week"),
            2 => self
                .summary
                .note("times are flagged as UTC seconds of the week"),
            _ => self.summary.note("times are on a scale of the user's own"),
        }
    }

    fn solution(&mut self, header: &Header, s: &Solution, losses: &mut Losses) {
        let [roll, pitch, heading] = s.attitude_deg;
        let [latitude, longitude] = s.place_deg;
        let turned = roll.abs() <= 180.0 && pitch.abs() <= 90.0 && heading.abs() <= 360.0;
        let placed = latitude.abs() <= 90.0 && longitude.abs() <= 180.0 && s.height_m.abs() < 2e4;
        if !(turned && placed && (0.0..=utc::WEEK_S).contains(&header.time_s)) {
            losses.impossible += 1;
            return;
        }
        let sensor = header.group.saturating_sub(101) as u8;
        let time_s = week::following(self.last_s, header.time_s);
        self.last_s = Some(time_s);
        if time_s > header.time_s {
            self.summary.note(
                "the times pass the end of a GPS week (604800 s) and are counted on from there",
            );
        }
        self.sink.attitude(&Attitude {
            time_s,
            roll_rad: radians(roll),
            pitch_rad: radians(pitch),
            heading_rad: Some(radians(heading)),
            heave_m: s.heave_m.filter(|h| h.abs() < 100.0).map(|down| -down),
            sensor,
            ..Attitude::default()
        });
        self.sink.position(&Position {
            time_s,
            latitude_rad: radians(latitude),
            longitude_rad: radians(longitude),
            height_m: Some(s.height_m),
            sensor,
            at_reference: header.group == 1,
            ..Position::default()
        });
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

    /// A group by hand: data, then the sum that makes all words add up to zero.
    fn group(number: u16, time_s: f64, scale: u8) -> Vec<u8> {
        let mut out = Out::new(false);
        out.raw(b"$GRP").u16(number).u16(0);
        out.f64(time_s).f64(0.0).f64(0.0).u8(scale).u8(0);
        out.f64(43.5)
            .f64(-70.25)
            .f64(-20.5)
            .f32(1.0)
            .f32(2.0)
            .f32(3.0);
        out.f64(1.5).f64(-0.5).f64(200.0).f64(0.0);
        out.f32(0.25).zeros(28).u8(0).zeros(3);
        let size = (out.data.len() + 4 - 8) as u16;
        out.data[6..8].copy_from_slice(&size.to_le_bytes());
        let words = out
            .data
            .as_chunks::<2>()
            .0
            .iter()
            .map(|w| u16::from_le_bytes(*w));
        let sum = words.fold(u16::from_le_bytes(*b"$#"), u16::wrapping_add);
        out.u16(sum.wrapping_neg()).raw(b"$#");
        out.data
    }

    #[test]
    fn groups_by_hand() {
        let mut wrong = group(102, 3.0, 1);
        wrong[50] ^= 1;
        let bytes = [
            group(1, 345_600.5, 1),
            wrong,
            group(102, 345_600.6, 2),
            group(7, 1.0, 1),
        ];
        let mut all = All::default();
        let summary =
            read_from(Path::new("a.000"), bytes.concat().as_slice(), &mut all).expect("readable");
        assert_eq!(
            (summary.losses.bad_checksums, summary.losses.malformed),
            (1, 0)
        );
        assert_eq!((all.0.len(), all.1.len()), (2, 2));
        assert_eq!(all.0[0].roll_rad, 1.5f64.to_radians());
        assert_eq!((all.0[0].heave_m, all.0[1].heave_m), (None, Some(-0.25)));
        assert_eq!(all.0[1].heading_rad, Some(200f64.to_radians()));
        assert_eq!(
            (all.1[0].at_reference, all.1[1].at_reference),
            (true, false)
        );
        assert_eq!(all.1[0].height_m, Some(-20.5));
        assert_eq!(all.0[0].time_s, 345_600.5);
    }

    /// Group 102 may come a little behind group 1; a stray time is no week's end.
    #[test]
    fn seconds_of_the_week_are_counted_on_over_its_end() {
        let told = |times: &[(u16, f64)]| {
            let groups = times.iter().map(|(number, t)| group(*number, *t, 1));
            let mut all = All::default();
            let bytes = groups.collect::<Vec<_>>().concat();
            let summary =
                read_from(Path::new("a.000"), bytes.as_slice(), &mut all).expect("readable");
            let times: Vec<f64> = all.0.iter().map(|a| a.time_s).collect();
            assert!(all.1.iter().map(|p| p.time_s).eq(times.iter().copied()));
            (
                times,
                summary
                    .notes
                    .iter()
                    .any(|n| n.contains("end of a GPS week")),
            )
        };
        let over = [
            (1, 604_799.75),
            (1, 0.25),
            (102, 604_799.75),
            (102, 0.25),
            (1, 0.5),
        ];
        let due = [604_799.75, 604_800.25, 604_799.75, 604_800.25, 604_800.5];
        assert_eq!(told(&over), (due.to_vec(), true));
        let stray = [(1, 400_000.0), (1, 0.25), (1, 400_000.5)];
        assert_eq!(told(&stray), (vec![400_000.0, 0.25, 400_000.5], false));
    }

    #[test]
    fn times_since_power_on_are_not_used() {
        let mut all = All::default();
        let bytes = group(1, 5.0, 0);
        let summary = read_from(Path::new("a.000"), bytes.as_slice(), &mut all).expect("readable");
        assert_eq!((summary.losses.not_good, all.0.len()), (1, 0));
    }
}
