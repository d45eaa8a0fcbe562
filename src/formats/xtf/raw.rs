//! Mirror of the packets, numbers as they stand in the file. XTF is little-endian; the sounder's own part in it is big-endian.

use crate::formats::recorder::Bytes;

/// Bytes of a block of the file's header.
pub const HEADER: usize = 1024;
/// Bytes of a packet's header.
pub const PACKET: usize = 14;
/// Bytes from a packet's begin to the sounder's own part.
pub const PING_HEADER: usize = 256;
/// More bytes than any packet has.
pub const LONGEST: usize = 1 << 24;
/// First two bytes of a packet.
pub const MAGIC: u16 = 0xFACE;

/// A packet's header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Type: 3 attitude, 65 R2Sonic bathymetry, 107 position.
    pub kind: u8,
    /// Bytes of the packet.
    pub size: u32,
}

impl Packet {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        (b.u16(0)? == MAGIC).then_some(())?;
        Some(Self {
            kind: b.u8(2)?,
            size: b.u32(10)?,
        })
    }
}

/// A channel of the file's header.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// 3 for bathymetry.
    pub kind: u8,
    /// Name.
    pub name: String,
    /// Offset to starboard, forward, down, metres.
    pub offset_m: [f32; 3],
    /// Yaw, pitch, roll, degrees.
    pub yaw_pitch_roll_deg: [f32; 3],
}

impl Channel {
    /// Bytes of a channel.
    pub const BYTES: usize = 128;

    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            kind: b.u8(0)?,
            name: b.text(12, 16)?,
            offset_m: [b.f32(48)?, b.f32(52)?, b.f32(56)?],
            yaw_pitch_roll_deg: [b.f32(60)?, b.f32(64)?, b.f32(68)?],
        })
    }
}

/// A date and a time of day as packets write them: seven bytes, year first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// Year, month, day.
    pub date: (u16, u8, u8),
    /// Hour, minute, second.
    pub time: (u8, u8, u8),
}

impl Clock {
    /// From its first byte on.
    #[must_use]
    pub fn read(b: &Bytes, at: usize) -> Option<Self> {
        Some(Self {
            date: (b.u16(at)?, b.u8(at + 2)?, b.u8(at + 3)?),
            time: (b.u8(at + 4)?, b.u8(at + 5)?, b.u8(at + 6)?),
        })
    }
}

/// An attitude packet (3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawAttitude {
    /// Pitch, roll, degrees.
    pub pitch_roll_deg: [f32; 2],
    /// Heave, metres.
    pub heave_m: f32,
    /// Heading, degrees.
    pub heading_deg: f32,
    /// Whole seconds.
    pub clock: Clock,
    /// The rest, milliseconds.
    pub milliseconds: u16,
}

impl RawAttitude {
    /// From a packet.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            pitch_roll_deg: [b.f32(30)?, b.f32(34)?],
            heave_m: b.f32(38)?,
            heading_deg: b.f32(50)?,
            clock: Clock::read(b, 54)?,
            milliseconds: b.u16(61)?,
        })
    }
}

/// A position packet (107).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawPosition {
    /// Whole seconds.
    pub clock: Clock,
    /// The rest, tenths of a millisecond.
    pub tenths_ms: u16,
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Height, metres.
    pub height_m: f64,
}

impl RawPosition {
    /// From a packet.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            clock: Clock::read(b, 14)?,
            tenths_ms: b.u16(21)?,
            latitude_deg: b.f64(23)?,
            longitude_deg: b.f64(31)?,
            height_m: b.f64(39)?,
        })
    }
}

/// The head section of a sounder's ping (`H0`), from behind its name and size on.
#[derive(Clone, Debug, PartialEq)]
pub struct PingHead {
    /// Model and serial number.
    pub model: String,
    /// Serial number.
    pub serial: String,
    /// Unix time, whole seconds of UTC.
    pub seconds: u32,
    /// The rest, nanoseconds.
    pub nanoseconds: u32,
    /// Number of the ping.
    pub ping: u32,
    /// Sound speed at the head, metres per second.
    pub speed_m_s: f32,
    /// Frequency, hertz.
    pub frequency_hz: f32,
    /// Steering of the projector, vertical and horizontal, radians.
    pub steering_rad: [f32; 2],
    /// Beams.
    pub beams: u16,
}

impl PingHead {
    /// From its bytes.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        Some(Self {
            model: b.text(0, 12)?,
            serial: b.text(12, 12)?,
            seconds: b.u32(24)?,
            nanoseconds: b.u32(28)?,
            ping: b.u32(32)?,
            speed_m_s: b.f32(40)?,
            frequency_hz: b.f32(44)?,
            steering_rad: [b.f32(64)?, b.f32(68)?],
            beams: b.u16(110)?,
        })
    }
}
