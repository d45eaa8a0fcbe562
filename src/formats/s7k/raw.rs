//! Mirror of the records, numbers as they stand in the file (Teledyne 7k Data Format Definition 3.12). Little-endian.

use crate::formats::recorder::Bytes;

/// Bytes of a record's frame before its data.
pub const FRAME: usize = 64;
/// What stands at byte 4 of every record.
pub const SYNC: u32 = 0x0000_FFFF;
/// More bytes than any record has.
pub const LONGEST: usize = 1 << 26;
/// Bytes of a detection record before its detections.
pub const DETECTIONS: usize = 99;

/// The frame of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Bytes of the record, checksum included.
    pub size: u32,
    /// Kind.
    pub kind: u32,
    /// Device.
    pub device: u32,
    /// Bit 0: the checksum is valid.
    pub flags: u16,
    /// Year and day of the year.
    pub date: (u16, u16),
    /// Hour, minute.
    pub clock: (u8, u8),
    /// Seconds of the minute.
    pub seconds: f32,
}

impl Frame {
    /// From a record.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        (b.u32(4)? == SYNC).then_some(())?;
        Some(Self {
            size: b.u32(8)?,
            kind: b.u32(32)?,
            device: b.u32(36)?,
            flags: b.u16(48)?,
            date: (b.u16(20)?, b.u16(22)?),
            clock: (b.u8(28)?, b.u8(29)?),
            seconds: b.f32(24)?,
        })
    }
}

/// Settings of a ping (7000).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Number of the ping and of its part.
    pub ping: (u32, u16),
    /// Frequency, hertz.
    pub frequency_hz: f32,
    /// Transmit flags: pitch and yaw stabilisation.
    pub transmit_flags: u32,
    /// Receive flags; bit 0 roll compensation.
    pub receive_flags: u32,
    /// Sound speed at the head, metres per second.
    pub speed_m_s: f32,
}

impl Settings {
    /// From a record's data.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            ping: (b.u32(8)?, b.u16(12)?),
            frequency_hz: b.f32(14)?,
            transmit_flags: b.u32(102)?,
            receive_flags: b.u32(118)?,
            speed_m_s: b.f32(146)?,
        })
    }
}

/// Fixed part of the detections of a ping (7027).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionHead {
    /// Number of the ping and of its part.
    pub ping: (u32, u16),
    /// Detections.
    pub count: u32,
    /// Bytes of a detection.
    pub bytes: u32,
    /// Rate of the samples, hertz.
    pub rate_hz: f32,
    /// Transmit angle, radians, positive forward.
    pub transmit_rad: f32,
}

impl DetectionHead {
    /// From a record's data.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            ping: (b.u32(8)?, b.u16(12)?),
            count: b.u32(14)?,
            bytes: b.u32(18)?,
            rate_hz: b.f32(27)?,
            transmit_rad: b.f32(31)?,
        })
    }
}

/// A detection of 7027.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Number of the beam.
    pub beam: u16,
    /// Samples from transmission to detection.
    pub samples: f32,
    /// Receive angle, radians, positive to starboard.
    pub angle_rad: f32,
    /// Bit 0: brightness, bit 1: collinearity passed.
    pub quality: u32,
}

impl Detection {
    /// Bytes that every version has.
    pub const LEAST: u32 = 18;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            beam: b.u16(0)?,
            samples: b.f32(2)?,
            angle_rad: b.f32(6)?,
            quality: b.u32(14)?,
        })
    }
}
