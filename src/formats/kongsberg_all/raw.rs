//! Mirror of the datagrams, numbers as they stand in the file (Kongsberg document 160692, revision W).

use crate::formats::recorder::Bytes;

/// Start of a datagram, behind its length.
pub const STX: u8 = 2;
/// End of a datagram, before its checksum.
pub const ETX: u8 = 3;
/// Bytes from the length field to the body.
pub const HEADER: usize = 20;
/// Bytes behind the body: end mark and checksum.
pub const TRAILER: usize = 3;
/// More bytes than any datagram has.
pub const LONGEST: usize = 1 << 20;

/// The header of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Kind, a letter.
    pub kind: u8,
    /// Model number.
    pub model: u16,
    /// Date as the number yyyymmdd.
    pub date: u32,
    /// Milliseconds since midnight.
    pub day_ms: u32,
    /// Ping or sequence counter.
    pub counter: u16,
    /// Serial number of the head.
    pub serial: u16,
}

impl Header {
    /// From a datagram, its length field included.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            kind: b.u8(5)?,
            model: b.u16(6)?,
            date: b.u32(8)?,
            day_ms: b.u32(12)?,
            counter: b.u16(16)?,
            serial: b.u16(18)?,
        })
    }
}

/// One sample of an attitude datagram (`A`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttitudeSample {
    /// Milliseconds after the header's time.
    pub after_ms: u16,
    /// Roll, hundredths of a degree.
    pub roll: i16,
    /// Pitch, hundredths of a degree.
    pub pitch: i16,
    /// Heave, centimetres, positive down.
    pub heave_cm: i16,
    /// Heading, hundredths of a degree.
    pub heading: u16,
}

impl AttitudeSample {
    /// Bytes of a sample.
    pub const BYTES: usize = 12;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            after_ms: b.u16(0)?,
            roll: b.i16(4)?,
            pitch: b.i16(6)?,
            heave_cm: b.i16(8)?,
            heading: b.u16(10)?,
        })
    }
}

/// A position datagram (`P`) without the telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Latitude, 1 / 2e7 degree.
    pub latitude: i32,
    /// Longitude, 1 / 1e7 degree.
    pub longitude: i32,
    /// Heading, hundredths of a degree.
    pub heading: u16,
    /// Bits 0 and 1 the system, 0x80 active.
    pub descriptor: u8,
}

impl Position {
    /// From a body.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            latitude: b.i32(0)?,
            longitude: b.i32(4)?,
            heading: b.u16(14)?,
            descriptor: b.u8(16)?,
        })
    }

    /// The telegram of a body.
    #[must_use]
    pub fn telegram<'a>(b: &Bytes<'a>) -> Option<&'a [u8]> {
        Some(b.part(18, usize::from(b.u8(17)?))?.data)
    }
}

/// Fixed part of the raw range and angle datagram (`N`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawHead {
    /// Sound speed at the head, decimetres per second.
    pub speed: u16,
    /// Transmit sectors.
    pub sectors: u16,
    /// Receive beams.
    pub beams: u16,
}

impl RawHead {
    /// Bytes of it.
    pub const BYTES: usize = 16;

    /// From a body.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            speed: b.u16(0)?,
            sectors: b.u16(2)?,
            beams: b.u16(4)?,
        })
    }
}

/// A transmit sector of `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawSector {
    /// Tilt, hundredths of a degree, positive forward.
    pub tilt: i16,
    /// Delay of the sector, seconds.
    pub delay_s: f32,
    /// Frequency, hertz.
    pub frequency_hz: f32,
    /// Number of the sector.
    pub number: u8,
}

impl RawSector {
    /// Bytes of a sector.
    pub const BYTES: usize = 24;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            tilt: b.i16(0)?,
            delay_s: b.f32(8)?,
            frequency_hz: b.f32(12)?,
            number: b.u8(19)?,
        })
    }
}

/// A receive beam of `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawBeam {
    /// Angle against the receive array, hundredths of a degree, positive to **port**.
    pub angle: i16,
    /// Number of its sector.
    pub sector: u8,
    /// Detection; 0x80 marks an invalid one.
    pub detection: u8,
    /// Two-way travel time, seconds.
    pub two_way_s: f32,
}

impl RawBeam {
    /// Bytes of a beam.
    pub const BYTES: usize = 16;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            angle: b.i16(0)?,
            sector: b.u8(2)?,
            detection: b.u8(3)?,
            two_way_s: b.f32(8)?,
        })
    }
}

/// Fixed part of the sounder's own solution (`X`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnHead {
    /// Heading, hundredths of a degree.
    pub heading: u16,
    /// Depth of the transmit array, metres.
    pub depth_m: f32,
    /// Beams.
    pub beams: u16,
}

impl OwnHead {
    /// Bytes of it.
    pub const BYTES: usize = 20;

    /// From a body.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            heading: b.u16(0)?,
            depth_m: b.f32(4)?,
            beams: b.u16(8)?,
        })
    }
}

/// A beam of `X`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnBeam {
    /// Depth, starboard, forward, metres.
    pub down_starboard_forward_m: [f32; 3],
    /// Detection; 0x80 marks an invalid one.
    pub detection: u8,
}

impl OwnBeam {
    /// Bytes of a beam.
    pub const BYTES: usize = 20;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            down_starboard_forward_m: [b.f32(0)?, b.f32(4)?, b.f32(8)?],
            detection: b.u8(16)?,
        })
    }
}

/// Fixed part of the sound-speed profile (`U`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProfileHead {
    /// Date of the profile, yyyymmdd.
    pub date: u32,
    /// Its time, seconds since midnight.
    pub day_s: u32,
    /// Entries.
    pub entries: u16,
    /// Unit of the depths, centimetres.
    pub unit_cm: u16,
}

impl ProfileHead {
    /// Bytes of it.
    pub const BYTES: usize = 12;

    /// From a body.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            date: b.u32(0)?,
            day_s: b.u32(4)?,
            entries: b.u16(8)?,
            unit_cm: b.u16(10)?,
        })
    }
}
