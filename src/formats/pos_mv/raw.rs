//! Mirror of the groups, numbers as they stand in the file (Applanix PUBS-ICD-004089, revision 10). Little-endian.

use crate::formats::recorder::Bytes;

/// Bytes before a group's data: start, group, length, times, distance, types.
pub const HEADER: usize = 34;
/// More bytes than any group has.
pub const LONGEST: usize = 1 << 16;

/// The header of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Number of the group.
    pub group: u16,
    /// First time, seconds on the scale of [`Self::scale`].
    pub time_s: f64,
    /// Scale of the first time: 0 since power-on, 1 GPS seconds of the week, 2 UTC seconds of the week.
    pub scale: u8,
}

impl Header {
    /// From a group, its start mark included.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            group: b.u16(4)?,
            time_s: b.f64(8)?,
            scale: b.u8(32)? & 15,
        })
    }
}

/// Position and attitude of groups 1, 102 and 103.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Latitude, longitude, degrees.
    pub place_deg: [f64; 2],
    /// Height above the ellipsoid, metres.
    pub height_m: f64,
    /// Roll, pitch, heading, degrees; axes forward, starboard, down.
    pub attitude_deg: [f64; 3],
    /// Heave, metres, positive down; only in groups 102 and 103.
    pub heave_m: Option<f64>,
    /// Alignment of group 1: 0 is full navigation.
    pub alignment: Option<u8>,
}

impl Solution {
    /// From a group's data.
    #[must_use]
    pub fn read(group: u16, b: &Bytes) -> Option<Self> {
        let sensor = group != 1;
        Some(Self {
            place_deg: [b.f64(0)?, b.f64(8)?],
            height_m: b.f64(16)?,
            attitude_deg: [b.f64(36)?, b.f64(44)?, b.f64(52)?],
            heave_m: if sensor { Some(b.real(68)?) } else { None },
            alignment: if sensor { None } else { Some(b.u8(100)?) },
        })
    }
}
