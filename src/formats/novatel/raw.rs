//! Mirror of the messages, numbers as they stand in the log. Little-endian.

use crate::formats::recorder::Bytes;

/// Bytes of a long header, where the header itself does not say another number.
pub const LONG_HEADER: usize = 28;
/// Bytes of a short header.
pub const SHORT_HEADER: usize = 12;
/// Bytes of the checksum behind a message.
pub const CRC: usize = 4;
/// The status of a good solution.
pub const SOLUTION_GOOD: u32 = 3;

/// INSPVA.
pub const INSPVA: u16 = 507;
/// INSPVAS.
pub const INSPVAS: u16 = 508;
/// INSPVAX.
pub const INSPVAX: u16 = 1465;
/// INSATT.
pub const INSATT: u16 = 263;
/// INSATTS.
pub const INSATTS: u16 = 319;

/// The header of a binary message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Bytes of the header.
    pub bytes: usize,
    /// Bytes of the body.
    pub body: usize,
    /// Message.
    pub id: u16,
    /// GPS week.
    pub week: u16,
    /// Milliseconds of the week.
    pub week_ms: u32,
}

impl Header {
    /// From a message, long or short.
    #[must_use]
    pub fn read(b: &Bytes) -> Option<Self> {
        match b.data.get(..3)? {
            [0xAA, 0x44, 0x12] => Some(Self {
                bytes: b.u8(3)?.into(),
                id: b.u16(4)?,
                body: b.u16(8)?.into(),
                week: b.u16(14)?,
                week_ms: b.u32(16)?,
            }),
            [0xAA, 0x44, 0x13] => Some(Self {
                bytes: SHORT_HEADER,
                body: b.u8(3)?.into(),
                id: b.u16(4)?,
                week: b.u16(6)?,
                week_ms: b.u32(8)?,
            }),
            _ => None,
        }
    }
}

/// Position and attitude of a message; fields that the message lacks are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// GPS week.
    pub week: u32,
    /// Seconds of the week.
    pub week_s: f64,
    /// Latitude, longitude, degrees; height, metres.
    pub place: Option<[f64; 3]>,
    /// Height of the geoid above the ellipsoid, metres, where the height is counted from the geoid.
    pub undulation_m: Option<f64>,
    /// Roll, pitch, azimuth, degrees.
    pub attitude_deg: [f64; 3],
    /// Status of the solution.
    pub status: u32,
}

impl Solution {
    /// From a binary message's body.
    #[must_use]
    pub fn read(header: &Header, b: &Bytes) -> Option<Self> {
        match header.id {
            INSPVA | INSPVAS => Self::pva(b),
            INSATT | INSATTS => Self::attitude(b),
            INSPVAX => Self::extended(header, b),
            _ => None,
        }
    }

    fn pva(b: &Bytes) -> Option<Self> {
        Some(Self {
            week: b.u32(0)?,
            week_s: b.f64(4)?,
            place: Some([b.f64(12)?, b.f64(20)?, b.f64(28)?]),
            undulation_m: None,
            attitude_deg: [b.f64(60)?, b.f64(68)?, b.f64(76)?],
            status: b.u32(84)?,
        })
    }

    fn attitude(b: &Bytes) -> Option<Self> {
        Some(Self {
            week: b.u32(0)?,
            week_s: b.f64(4)?,
            place: None,
            undulation_m: None,
            attitude_deg: [b.f64(12)?, b.f64(20)?, b.f64(28)?],
            status: b.u32(36)?,
        })
    }

    fn extended(header: &Header, b: &Bytes) -> Option<Self> {
        Some(Self {
            week: header.week.into(),
            week_s: 1e-3 * f64::from(header.week_ms),
            place: Some([b.f64(8)?, b.f64(16)?, b.f64(24)?]),
            undulation_m: Some(b.real(32)?),
            attitude_deg: [b.f64(60)?, b.f64(68)?, b.f64(76)?],
            status: b.u32(0)?,
        })
    }

    /// From an ASCII message: its name without the closing `A`, the fields of its header and of its body.
    #[must_use]
    pub fn parse(name: &str, header: &[&str], body: &[&str]) -> Option<Self> {
        let number = |k: usize| body.get(k)?.trim().parse::<f64>().ok();
        let three = |k: usize| Some([number(k)?, number(k + 1)?, number(k + 2)?]);
        let good = |k: usize| match body.get(k)?.trim() {
            "INS_SOLUTION_GOOD" | "3" => Some(SOLUTION_GOOD),
            _ => Some(0),
        };
        match name {
            "INSPVA" | "INSPVAS" => Some(Self {
                week: body.first()?.trim().parse().ok()?,
                week_s: number(1)?,
                place: Some(three(2)?),
                undulation_m: None,
                attitude_deg: three(8)?,
                status: good(11)?,
            }),
            "INSATT" | "INSATTS" => Some(Self {
                week: body.first()?.trim().parse().ok()?,
                week_s: number(1)?,
                place: None,
                undulation_m: None,
                attitude_deg: three(2)?,
                status: good(5)?,
            }),
            "INSPVAX" => {
                let at = header
                    .len()
                    .checked_sub(if header.len() > 3 { 5 } else { 2 })?;
                Some(Self {
                    week: header.get(at)?.trim().parse().ok()?,
                    week_s: header.get(at + 1)?.trim().parse().ok()?,
                    place: Some(three(2)?),
                    undulation_m: Some(number(5)?),
                    attitude_deg: three(9)?,
                    status: good(0)?,
                })
            }
            _ => None,
        }
    }
}

/// The checksum: CRC-32, polynomial 0xEDB88320 reflected, begun with 0, not inverted.
#[must_use]
pub fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| TABLE[usize::from((crc as u8) ^ byte)] ^ (crc >> 8);
    bytes.iter().fold(0, step)
}

const TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut k = 0;
    while k < 256 {
        let (mut value, mut bit) = (k as u32, 0);
        while bit < 8 {
            value = (value >> 1) ^ (0xEDB8_8320 * (value & 1));
            bit += 1;
        }
        table[k] = value;
        k += 1;
    }
    table
};
