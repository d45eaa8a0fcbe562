//! The soundings of recorder files in columns, ready for a calibration, with everything else that the files say beside them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::collect::Recorded;
use crate::formats::error::FormatError;
use crate::formats::recorder::{
    Attitude, Heading, Installation, Ping, Position, Profile, Sink, Summary, WaterHeight, table,
};
use crate::formats::records::{ArrayColumns, SoundingRecords, heads_of};
use crate::observe::SoundingRange;

/// One file that was read.
#[derive(Clone, Debug)]
pub struct ObservedFile {
    /// Its path.
    pub path: PathBuf,
    /// Times of its first and last ping, seconds; nothing without pings.
    pub span_s: Option<(f64, f64)>,
    /// The reader's summary.
    pub summary: Summary,
    /// Its installation record, the last one.
    pub installation: Option<Installation>,
}

/// Several files of one recording put together.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// The files in the order in which they were named.
    pub files: Vec<ObservedFile>,
    /// Navigation, profiles and installation records; pings are in [`Self::soundings`].
    pub recorded: Recorded,
    /// Valid beams in order of their pings' times, times of the pings.
    pub soundings: Columns,
    /// Pings that came twice and were counted once.
    pub repeated_pings: usize,
    /// Beams that the sounder marks as not valid.
    pub invalid: usize,
    seen: HashSet<(u32, u64)>,
    span_s: Option<(f64, f64)>,
    installation: Option<Installation>,
}

/// Soundings in columns.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Time of the ping, seconds.
    pub time_s: Vec<f64>,
    /// Number of the ping.
    pub ping: Vec<u32>,
    /// Number of the beam.
    pub beam: Vec<u32>,
    /// Serial number of the head, or its index.
    pub head: Vec<u32>,
    /// Angle against the receive array, radians, positive to starboard.
    pub angle_rad: Vec<f64>,
    /// Tilt of the transmitted cone, radians, positive forward.
    pub tilt_rad: Vec<f64>,
    /// From the ping's time to this beam's transmission, seconds.
    pub delay_s: Vec<f64>,
    /// Two-way travel time, seconds.
    pub two_way_s: Vec<f64>,
    /// Sound speed at the head, metres per second.
    pub head_speed_m_s: Vec<f64>,
}

impl Sink for Observed {
    fn installation(&mut self, record: &Installation) {
        self.installation = Some(record.clone());
        // one is what a file needs; a recorder repeats it
        if self.recorded.installations.len() < 100 {
            self.recorded.installation(record);
        }
    }
    fn attitude(&mut self, record: &Attitude) {
        self.recorded.attitude(record);
    }
    fn heading(&mut self, record: &Heading) {
        self.recorded.heading(record);
    }
    fn position(&mut self, record: &Position) {
        self.recorded.position(record);
    }
    fn water_height(&mut self, record: &WaterHeight) {
        self.recorded.water_height(record);
    }
    fn profile(&mut self, record: &Profile) {
        self.recorded.profile(record);
    }
    fn ping(&mut self, ping: &Ping) {
        if !self.seen.insert((ping.head, ping.time_s.to_bits())) {
            self.repeated_pings += 1;
            return;
        }
        let (first, last) = self.span_s.unwrap_or((ping.time_s, ping.time_s));
        self.span_s = Some((first.min(ping.time_s), last.max(ping.time_s)));
        for beam in &ping.beams {
            let sector = ping.sectors.get(usize::from(beam.sector));
            let Some(sector) = sector.filter(|_| beam.valid) else {
                self.invalid += 1;
                continue;
            };
            let columns = &mut self.soundings;
            columns.time_s.push(ping.time_s);
            columns.ping.push(ping.number);
            columns.beam.push(beam.number);
            columns.head.push(ping.head);
            columns.angle_rad.push(beam.angle_rad);
            columns.tilt_rad.push(sector.tilt_rad);
            columns.delay_s.push(sector.delay_s);
            columns.two_way_s.push(beam.two_way_s);
            columns.head_speed_m_s.push(ping.head_speed_m_s);
        }
    }
}

impl Observed {
    /// Reads one more file.
    ///
    /// # Errors
    /// [`FormatError`] when it cannot be read or no reader knows it.
    pub fn read(&mut self, path: &Path) -> Result<(), FormatError> {
        (self.span_s, self.installation) = (None, None);
        let summary = table::read(path, self)?;
        self.files.push(ObservedFile {
            path: path.to_owned(),
            span_s: self.span_s.take(),
            summary,
            installation: self.installation.take(),
        });
        Ok(())
    }

    /// The heads that have pings, in order.
    #[must_use]
    pub fn heads(&self) -> Vec<u32> {
        heads_of(&self.soundings.head)
    }

    /// Time of the first ping, seconds.
    #[must_use]
    pub fn first_s(&self) -> Option<f64> {
        let first = self.files.iter().filter_map(|file| Some(file.span_s?.0));
        first.reduce(f64::min)
    }

    /// The soundings of these heads in order of time. Empties [`Self::soundings`].
    #[must_use]
    pub fn take_heads(&mut self, heads: &[u32]) -> SoundingRecords {
        let all = std::mem::take(&mut self.soundings);
        let mut order: Vec<usize> = (0..all.time_s.len())
            .filter(|k| heads.contains(&all.head[*k]))
            .collect();
        order.sort_by(|a, b| all.time_s[*a].total_cmp(&all.time_s[*b]));
        let all = SoundingRecords {
            time_s: all.time_s,
            ping: all.ping,
            beam: all.beam,
            across_rad: all.angle_rad,
            along_rad: all.tilt_rad,
            range: SoundingRange::TwoWayTravelTime(all.two_way_s),
            arrays: Some(ArrayColumns {
                delay_s: all.delay_s,
                head_speed_m_s: all.head_speed_m_s,
            }),
            head: all.head,
            notes: vec![],
        };
        all.rows(&order)
    }
}
