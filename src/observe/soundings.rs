//! Soundings of a multibeam echo sounder: one row per beam of each ping.

use super::sounding_file::{Room, Sounding, SoundingFile};
use super::{ArrayMountings, Mounting};
use crate::files::spill::SpillError;

/// What a sounding measured along its beam.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundingRange {
    /// Slant range, metres.
    Metres(Vec<f64>),
    /// Two-way travel time, seconds; needs a sound speed.
    TwoWayTravelTime(Vec<f64>),
}

impl SoundingRange {
    /// The column, whatever its unit.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Metres(values) | Self::TwoWayTravelTime(values) => values,
        }
    }

    /// The column, to be changed.
    #[must_use]
    pub fn values_mut(&mut self) -> &mut Vec<f64> {
        match self {
            Self::Metres(values) | Self::TwoWayTravelTime(values) => values,
        }
    }

    /// The same kind, without values.
    #[must_use]
    pub fn empty(&self) -> Self {
        match self {
            Self::Metres(_) => Self::Metres(vec![]),
            Self::TwoWayTravelTime(_) => Self::TwoWayTravelTime(vec![]),
        }
    }
}

/// A-priori noise of the soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarNoise {
    /// Range, metres, one sigma.
    pub range_m: f64,
    /// Across-track beam angle, radians, one sigma.
    pub across_rad: f64,
    /// Along-track beam angle, radians, one sigma.
    pub along_rad: f64,
}

/// What soundings of a transmit and a receive array have besides: each is sent at one moment and heard at another.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundingArrays {
    /// Nominal mountings of the two arrays.
    pub mountings: ArrayMountings,
    /// The one nominal mounting that stands for both: as it is corrected, both are.
    pub nominal: Mounting,
    /// Sound speed at the head that the beam former used for each sounding, metres per second; 0 where it is the water's.
    pub head_speed_m_s: Vec<f32>,
}

/// Soundings in columns of equal length, in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Soundings {
    /// Time of the ping (of two arrays: of this sounding's transmission) on the trajectory's clock, seconds, not descending.
    pub time_s: Vec<f64>,
    /// Ping number.
    pub ping: Vec<u32>,
    /// Beam number within the ping.
    pub beam: Vec<u32>,
    /// Across-track angle (of two arrays: against the receive array), radians, positive to starboard.
    pub across_rad: Vec<f64>,
    /// Along-track angle (of two arrays: tilt of the transmitted cone), radians, elevation out of the across plane, positive forward.
    pub along_rad: Vec<f64>,
    /// Ranges or travel times.
    pub range: SoundingRange,
    /// A-priori noise.
    pub noise: SonarNoise,
    /// Where a transmit and a receive array stand each on its own; always with travel times.
    pub arrays: Option<SoundingArrays>,
    /// Where the soundings are too many for memory: all of them, and the columns are empty. The methods read both alike.
    pub file: Option<SoundingFile>,
}

impl Soundings {
    /// Number of soundings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.file
            .as_ref()
            .map_or(self.time_s.len(), SoundingFile::len)
    }

    /// Whether there is no sounding.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time of sounding `k`, seconds; not a number where a file cannot be read.
    #[must_use]
    #[inline]
    pub fn at_s(&self, k: usize) -> f64 {
        match &self.file {
            None => self.time_s[k],
            Some(file) => file.time_s(k),
        }
    }

    /// First and last time, seconds.
    #[must_use]
    pub fn span_s(&self) -> Option<[f64; 2]> {
        let last = self.len().checked_sub(1)?;
        Some([self.at_s(0), self.at_s(last)])
    }

    /// All times in order, seconds.
    pub fn times_s(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|k| self.at_s(k))
    }

    /// Across-track angle, along-track angle (radians) and range or travel time of sounding `k`; not numbers where a file cannot be read.
    #[must_use]
    #[inline]
    pub fn measured(&self, k: usize) -> [f64; 3] {
        match &self.file {
            None => [
                self.across_rad[k],
                self.along_rad[k],
                self.range.values()[k],
            ],
            Some(file) => file.measured(k),
        }
    }

    /// Ping and beam number of sounding `k`.
    #[must_use]
    pub fn name(&self, k: usize) -> (u32, u32) {
        match &self.file {
            None => (self.ping[k], self.beam[k]),
            Some(file) => file.name(k),
        }
    }

    /// What went wrong in reading them from a file, if anything did.
    #[must_use]
    pub fn fault(&self) -> Option<&SpillError> {
        self.file.as_ref()?.fault()
    }

    fn row(&self, k: usize) -> Sounding {
        let ([across_rad, along_rad, range], (ping, beam)) = (self.measured(k), self.name(k));
        Sounding {
            time_s: self.at_s(k),
            ping,
            beam,
            across_rad,
            along_rad,
            range,
        }
    }

    /// Every `step`-th sounding, in memory.
    #[must_use]
    pub fn every(&self, step: usize) -> Self {
        let mut some = self.blank();
        for k in (0..self.len()).step_by(step.max(1)) {
            some.push(&self.row(k));
        }
        some.arrays = self.arrays.as_ref().map(|arrays| SoundingArrays {
            head_speed_m_s: (arrays.head_speed_m_s.iter())
                .step_by(step.max(1))
                .copied()
                .collect(),
            ..*arrays
        });
        some
    }

    /// The same, in a file where there is no room for them in memory.
    ///
    /// # Errors
    /// [`SpillError`]: the folder is missing or the disk is full, for one.
    pub fn within(self, room: &Room) -> Result<Self, SpillError> {
        if self.file.is_some() || room.holds(self.len()) {
            return Ok(self);
        }
        let mut writer = room.writer()?;
        for k in 0..self.len() {
            writer.push(&self.row(k))?;
        }
        Ok(Self {
            file: Some(writer.finish()?),
            arrays: self.arrays.clone(),
            ..self.blank()
        })
    }

    /// The same without any sounding.
    fn blank(&self) -> Self {
        Self {
            time_s: vec![],
            ping: vec![],
            beam: vec![],
            across_rad: vec![],
            along_rad: vec![],
            range: self.range.empty(),
            noise: self.noise,
            arrays: None,
            file: None,
        }
    }

    fn push(&mut self, row: &Sounding) {
        self.time_s.push(row.time_s);
        self.ping.push(row.ping);
        self.beam.push(row.beam);
        self.across_rad.push(row.across_rad);
        self.along_rad.push(row.along_rad);
        self.range.values_mut().push(row.range);
    }
}
