//! The columns that files hold, before a survey adds noise, frames and policies.

use crate::geometry::Ellipsoid;
use crate::observe::{
    GeodeticTrajectory, LaserCoordinates, LaserNoise, LaserScan, Outside, SonarNoise,
    SoundingRange, Soundings, TrajectoryNoise,
};

/// A trajectory file's columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajectoryRecords {
    /// Time, seconds, strictly ascending.
    pub time_s: Vec<f64>,
    /// Geodetic latitude, radians.
    pub latitude_rad: Vec<f64>,
    /// Longitude, radians.
    pub longitude_rad: Vec<f64>,
    /// Ellipsoidal height, metres.
    pub height_m: Vec<f64>,
    /// Roll, radians, positive starboard down.
    pub roll_rad: Vec<f64>,
    /// Pitch, radians, positive bow up.
    pub pitch_rad: Vec<f64>,
    /// True heading, radians, clockwise from north.
    pub heading_rad: Vec<f64>,
    /// Velocity east, north, up, metres per second, where the file holds it.
    pub velocity_m_s: Option<Vec<[f64; 3]>>,
    /// What was done to the records on reading, in words.
    pub notes: Vec<String>,
}

impl TrajectoryRecords {
    /// Latitude, longitude (radians) and height (metres).
    #[must_use]
    pub fn places(&self) -> [&[f64]; 3] {
        [&self.latitude_rad, &self.longitude_rad, &self.height_m]
    }

    /// Roll, pitch and heading, radians.
    #[must_use]
    pub fn angles(&self) -> [&[f64]; 3] {
        [&self.roll_rad, &self.pitch_rad, &self.heading_rad]
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no record.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// With what the file does not say.
    #[must_use]
    pub fn into_trajectory(
        self,
        ellipsoid: Ellipsoid,
        noise: TrajectoryNoise,
        max_gap_s: f64,
        outside: Outside,
    ) -> GeodeticTrajectory {
        GeodeticTrajectory {
            ellipsoid,
            time_s: self.time_s,
            latitude_rad: self.latitude_rad,
            longitude_rad: self.longitude_rad,
            height_m: self.height_m,
            roll_rad: self.roll_rad,
            pitch_rad: self.pitch_rad,
            heading_rad: self.heading_rad,
            velocity_m_s: self.velocity_m_s,
            noise,
            max_gap_s,
            outside,
        }
    }
}

/// A laser file's columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LaserRecords {
    /// Time, seconds, not descending.
    pub time_s: Vec<f64>,
    /// First coordinate, metres.
    pub x_m: Vec<f64>,
    /// Second coordinate, metres.
    pub y_m: Vec<f64>,
    /// Third coordinate, metres.
    pub z_m: Vec<f64>,
    /// What was done to the returns on reading, in words.
    pub notes: Vec<String>,
}

impl LaserRecords {
    /// Number of returns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no return.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// With what the file does not say.
    #[must_use]
    pub fn into_scan(self, coordinates: LaserCoordinates, noise: LaserNoise) -> LaserScan {
        LaserScan {
            time_s: self.time_s,
            x_m: self.x_m,
            y_m: self.y_m,
            z_m: self.z_m,
            coordinates,
            noise,
        }
    }
}

/// The numbers in a column of heads, in order, each once.
#[must_use]
pub fn heads_of(column: &[u32]) -> Vec<u32> {
    let mut heads = column.to_vec();
    heads.sort_unstable();
    heads.dedup();
    heads
}

/// A soundings file's columns.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundingRecords {
    /// Time of the ping, seconds, not descending.
    pub time_s: Vec<f64>,
    /// Ping number.
    pub ping: Vec<u32>,
    /// Beam number within the ping.
    pub beam: Vec<u32>,
    /// Across-track angle, radians, positive to starboard.
    pub across_rad: Vec<f64>,
    /// Along-track angle, radians, positive forward.
    pub along_rad: Vec<f64>,
    /// Ranges or two-way travel times.
    pub range: SoundingRange,
    /// What goes with each where the arrays that transmit and receive stand each on its own: then `along_rad` is the tilt of the
    /// transmitted cone and `across_rad` the angle against the receive array.
    pub arrays: Option<ArrayColumns>,
    /// Number of the head that each is of; empty where the file does not say it.
    pub head: Vec<u32>,
    /// What was done to the soundings on reading, in words.
    pub notes: Vec<String>,
}

/// Columns of soundings whose transmit and receive arrays stand, and move, each on its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArrayColumns {
    /// From the ping's time to the beam's transmission, seconds.
    pub delay_s: Vec<f64>,
    /// Sound speed at the head that the beam former used, metres per second; 0 where it is the profile's.
    pub head_speed_m_s: Vec<f64>,
}

impl SoundingRecords {
    /// Number of soundings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sounding.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The numbers of the heads that have soundings, in order; nothing where the file does not say them.
    #[must_use]
    pub fn heads(&self) -> Vec<u32> {
        heads_of(&self.head)
    }

    /// Some rows, in the order given.
    #[must_use]
    pub fn rows(&self, rows: &[usize]) -> Self {
        let real = |column: &[f64]| -> Vec<f64> { rows.iter().map(|k| column[*k]).collect() };
        // heads may be missing
        let count = |column: &[u32]| -> Vec<u32> {
            let of = |k: &usize| column.get(*k).copied();
            rows.iter().filter_map(of).collect()
        };
        Self {
            time_s: real(&self.time_s),
            ping: count(&self.ping),
            beam: count(&self.beam),
            across_rad: real(&self.across_rad),
            along_rad: real(&self.along_rad),
            range: match &self.range {
                SoundingRange::Metres(range) => SoundingRange::Metres(real(range)),
                SoundingRange::TwoWayTravelTime(time_s) => {
                    SoundingRange::TwoWayTravelTime(real(time_s))
                }
            },
            arrays: self.arrays.as_ref().map(|arrays| ArrayColumns {
                delay_s: real(&arrays.delay_s),
                head_speed_m_s: real(&arrays.head_speed_m_s),
            }),
            head: count(&self.head),
            notes: self.notes.clone(),
        }
    }

    /// With what the file does not say. How two arrays are mounted is left to the caller.
    #[must_use]
    pub fn into_soundings(self, noise: SonarNoise) -> Soundings {
        Soundings {
            time_s: self.time_s,
            ping: self.ping,
            beam: self.beam,
            across_rad: self.across_rad,
            along_rad: self.along_rad,
            range: self.range,
            noise,
            arrays: None,
            file: None,
        }
    }
}
