//! Mirror of the datagrams, numbers as they stand in the file (Kongsberg `EMdgmFormat`, revision I). Little-endian.
//!
//! Parts carry their own byte counts, which differ between versions: every offset is counted from the beginning of a part.

use crate::formats::recorder::Bytes;

/// Bytes of the common header.
pub const HEADER: usize = 20;
/// More bytes than any datagram has.
pub const LONGEST: usize = 1 << 25;

/// The common header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Kind, `#` and three letters.
    pub kind: [u8; 4],
    /// Version of the datagram.
    pub version: u8,
    /// Model number.
    pub sounder: u16,
    /// Unix time, whole seconds of UTC.
    pub seconds: u32,
    /// The rest, nanoseconds.
    pub nanoseconds: u32,
}

impl Header {
    /// From a datagram, its length field included.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            kind: *b.data.get(4..8)?.first_chunk()?,
            version: b.u8(8)?,
            sounder: b.u16(10)?,
            seconds: b.u32(12)?,
            nanoseconds: b.u32(16)?,
        })
    }
}

/// Common part of a multibeam datagram, of 12 bytes or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Common {
    /// Bytes of this part.
    pub bytes: u16,
    /// Ping counter.
    pub ping: u16,
    /// Index of the receiver.
    pub receiver: u8,
}

impl Common {
    /// From the part's first byte on.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            bytes: b.u16(0)?,
            ping: b.u16(2)?,
            receiver: b.u8(9)?,
        })
    }
}

/// Ping information.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingInfo {
    /// Bytes of this part.
    pub bytes: u16,
    /// Transmit sectors.
    pub sectors: u16,
    /// Bytes of a sector.
    pub sector_bytes: u16,
    /// Heading of the vessel, degrees.
    pub heading_deg: f32,
    /// Sound speed at the head, metres per second.
    pub speed_m_s: f32,
    /// Depth of the transmit array below the water line, metres.
    pub depth_m: f32,
    /// Water line from the reference point, metres, positive down.
    pub water_line_m: f32,
}

impl PingInfo {
    /// From the part's first byte on.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            bytes: b.u16(0)?,
            sectors: b.u16(92)?,
            sector_bytes: b.u16(94)?,
            heading_deg: b.f32(96)?,
            speed_m_s: b.f32(100)?,
            depth_m: b.f32(104)?,
            water_line_m: b.f32(108)?,
        })
    }
}

/// A transmit sector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawSector {
    /// Number.
    pub number: u8,
    /// Transmit array.
    pub array: u8,
    /// Delay, seconds.
    pub delay_s: f32,
    /// Tilt, degrees, positive forward.
    pub tilt_deg: f32,
    /// Frequency, hertz.
    pub frequency_hz: f32,
}

impl RawSector {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            number: b.u8(0)?,
            array: b.u8(1)?,
            delay_s: b.f32(4)?,
            tilt_deg: b.f32(8)?,
            frequency_hz: b.f32(20)?,
        })
    }
}

/// Receiver information: how many soundings of how many bytes follow, behind the classes of extra detections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceiverInfo {
    /// Bytes of this part.
    pub bytes: u16,
    /// Soundings of the main fan.
    pub soundings: u16,
    /// Bytes of a sounding.
    pub sounding_bytes: u16,
    /// Extra detections behind them.
    pub extra: u16,
    /// Classes of extra detections.
    pub classes: u16,
    /// Bytes of a class.
    pub class_bytes: u16,
}

impl ReceiverInfo {
    /// From the part's first byte on.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            bytes: b.u16(0)?,
            soundings: b.u16(2)?,
            sounding_bytes: b.u16(6)?,
            extra: b.u16(26)?,
            classes: b.u16(28)?,
            class_bytes: b.u16(30)?,
        })
    }
}

/// A sounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawSounding {
    /// Number of its sector.
    pub sector: u8,
    /// 0 normal, 1 extra, 2 rejected.
    pub kind: u8,
    /// Angle against the receive array, degrees, positive to **port**; corrections already in it.
    pub angle_deg: f32,
    /// Two-way travel time, seconds; corrections already in it.
    pub two_way_s: f32,
    /// Forward, starboard, down from the reference point, metres.
    pub forward_starboard_down_m: [f32; 3],
}

impl RawSounding {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            sector: b.u8(2)?,
            kind: b.u8(3)?,
            angle_deg: b.f32(72)?,
            two_way_s: b.f32(80)?,
            forward_starboard_down_m: [b.f32(104)?, b.f32(100)?, b.f32(96)?],
        })
    }
}

/// A motion sensor's sample (`#KMB` within `#SKM`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Unix time, whole seconds.
    pub seconds: u32,
    /// The rest, nanoseconds.
    pub nanoseconds: u32,
    /// Bits of what is invalid: 0 position, 1 roll and pitch, 2 heading, 3 heave.
    pub status: u32,
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, metres.
    pub height_m: f32,
    /// Roll, pitch, heading, degrees.
    pub roll_pitch_heading_deg: [f32; 3],
    /// Heave, metres, positive down.
    pub heave_m: f32,
}

impl Motion {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            seconds: b.u32(8)?,
            nanoseconds: b.u32(12)?,
            status: b.u32(16)?,
            latitude_deg: b.f64(20)?,
            longitude_deg: b.f64(28)?,
            height_m: b.f32(36)?,
            roll_pitch_heading_deg: [b.f32(40)?, b.f32(44)?, b.f32(48)?],
            heave_m: b.f32(52)?,
        })
    }
}

/// A position (`#SPO`), from the byte behind its common part on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawPosition {
    /// Unix time of the sensor, whole seconds.
    pub seconds: u32,
    /// The rest, nanoseconds.
    pub nanoseconds: u32,
    /// Latitude, degrees; 200 for none.
    pub latitude_deg: f64,
    /// Longitude, degrees; 200 for none.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, metres; -999 for none.
    pub height_m: f32,
}

impl RawPosition {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            seconds: b.u32(0)?,
            nanoseconds: b.u32(4)?,
            latitude_deg: b.f64(12)?,
            longitude_deg: b.f64(20)?,
            height_m: b.f32(36)?,
        })
    }
}
