//! Writes datagrams, for simulators that export the format and for tests.
//!
//! Angles and travel times keep seven digits (four-byte reals), times nanoseconds.

use std::io::{self, Write};

use super::raw::HEADER;
use crate::formats::recorder::{Attitude, Out, Ping, Position, Profile, Solution};
use crate::units::degrees;

/// Writes datagrams into a file.
pub struct Writer<W> {
    out: W,
    sounder: u16,
    version: u8,
    split: Option<usize>,
}

impl<W: Write> Writer<W> {
    /// Of a model number; soundings in version 2 of their layout.
    pub fn new(out: W, sounder: u16) -> Self {
        Self {
            out,
            sounder,
            version: 2,
            split: None,
        }
    }

    /// Soundings in another version of their layout, 0 to 2.
    #[must_use]
    pub fn version(mut self, version: u8) -> Self {
        self.version = version;
        self
    }

    /// Soundings split into parts of so many bytes.
    #[must_use]
    pub fn split(mut self, bytes: usize) -> Self {
        self.split = Some(bytes.max(1));
        self
    }

    /// What was written into.
    pub fn into_inner(self) -> W {
        self.out
    }

    /// A datagram of any kind, `kind` with its `#`.
    ///
    /// # Errors
    /// Those of the output.
    pub fn datagram(&mut self, kind: &[u8; 4], time_s: f64, body: &[u8]) -> io::Result<()> {
        let size = (HEADER + body.len() + 4) as u32;
        let (seconds, nanoseconds) = seconds_and_rest(time_s);
        let mut whole = Out::new(false);
        whole.u32(size).raw(kind).u8(self.version).u8(0);
        whole.u16(self.sounder).u32(seconds).u32(nanoseconds);
        whole.raw(body).u32(size);
        self.out.write_all(&whole.data)
    }

    /// The installation record as its text.
    ///
    /// # Errors
    /// Those of the output.
    pub fn installation(&mut self, time_s: f64, text: &str) -> io::Result<()> {
        let mut body = Out::new(false);
        body.u16(6).u16(0).u16(0).raw(text.as_bytes()).u8(0);
        self.datagram(b"#IIP", time_s, &body.data)
    }

    /// Motion samples with positions, where there is one for a sample.
    ///
    /// # Errors
    /// Those of the output.
    pub fn motion(&mut self, samples: &[(Attitude, Option<Position>)]) -> io::Result<()> {
        let Some((first, _)) = samples.first() else {
            return Ok(());
        };
        let mut body = Out::new(false);
        body.u16(12).u8(first.sensor).u8(1).u16(0);
        body.u16(samples.len() as u16).u16(132).u16(0);
        for (attitude, position) in samples {
            motion_sample(&mut body, attitude, position.as_ref());
        }
        self.datagram(b"#SKM", first.time_s, &body.data)
    }

    /// A position of the reference point.
    ///
    /// # Errors
    /// Those of the output.
    pub fn position(&mut self, p: &Position) -> io::Result<()> {
        let (seconds, nanoseconds) = seconds_and_rest(p.time_s);
        let mut body = Out::new(false);
        body.u16(8).u16(p.sensor.into()).u16(1).u16(0);
        body.u32(seconds).u32(nanoseconds).f32(0.0);
        body.f64(degrees(p.latitude_rad))
            .f64(degrees(p.longitude_rad));
        body.f32(0.0).f32(0.0).real(p.height_m.unwrap_or(-999.0));
        self.datagram(b"#SPO", p.time_s, &body.data)
    }

    /// A sound-speed profile.
    ///
    /// # Errors
    /// Those of the output.
    pub fn profile(&mut self, profile: &Profile) -> io::Result<()> {
        let mut body = Out::new(false);
        body.u16(28).u16(profile.depth_m.len() as u16).raw(b"S00 ");
        body.u32(profile.time_s.max(0.0) as u32)
            .f64(200.0)
            .f64(200.0);
        for (depth_m, speed_m_s) in profile.depth_m.iter().zip(&profile.speed_m_s) {
            body.real(*depth_m).real(*speed_m_s).zeros(12);
        }
        self.datagram(b"#SVP", profile.time_s, &body.data)
    }

    /// A ping with the own solution of it.
    ///
    /// # Errors
    /// Those of the output.
    pub fn ping(&mut self, ping: &Ping, own: &Solution) -> io::Result<()> {
        let (info_bytes, sector_bytes) = if self.version == 0 {
            (144, 36)
        } else {
            (152, 48)
        };
        let mut body = Out::new(false);
        common(&mut body, ping);
        ping_info(&mut body, ping, own, info_bytes, sector_bytes);
        for (k, s) in ping.sectors.iter().enumerate() {
            let end = body.data.len() + usize::from(sector_bytes);
            body.u8(k as u8).u8(s.array).u16(0).real(s.delay_s);
            body.real(degrees(s.tilt_rad)).zeros(8).real(s.frequency_hz);
            body.zeros(end - body.data.len());
        }
        body.u16(32).u16(ping.beams.len() as u16);
        body.u16(0).u16(120).zeros(18).u16(0).u16(0).u16(0);
        for (beam, point) in ping.beams.iter().zip(&own.points) {
            let end = body.data.len() + 120;
            let v = point.right_forward_up_m;
            body.u16(beam.number as u16).u8(beam.sector as u8);
            body.u8(if beam.valid { 0 } else { 2 }).zeros(68);
            body.real(-degrees(beam.angle_rad)).f32(0.0);
            body.real(beam.two_way_s).f32(0.0).zeros(8);
            body.real(-v.z).real(v.x).real(v.y);
            body.zeros(end - body.data.len());
        }
        self.parts(ping.time_s, &body.data)
    }

    /// A multibeam datagram, split where that is wanted.
    fn parts(&mut self, time_s: f64, body: &[u8]) -> io::Result<()> {
        let size = self.split.unwrap_or(body.len()).max(1);
        let of = body.len().div_ceil(size) as u16;
        for (k, part) in body.chunks(size).enumerate() {
            let mut whole = Out::new(false);
            whole.u16(of).u16(k as u16 + 1).raw(part);
            self.datagram(b"#MRZ", time_s, &whole.data)?;
        }
        Ok(())
    }
}

/// Whole seconds and nanoseconds of a Unix time.
fn seconds_and_rest(time_s: f64) -> (u32, u32) {
    let whole = time_s.floor();
    let rest = (1e9 * (time_s - whole)).round() as u32;
    (whole as u32 + rest / 1_000_000_000, rest % 1_000_000_000)
}

fn common(body: &mut Out, ping: &Ping) {
    let receiver = ping.head.saturating_sub(1) as u8;
    body.u16(12).u16(ping.number as u16).u8(1).u8(receiver);
    body.u8(1).u8(0).u8(0).u8(receiver).u8(1).u8(0);
}

fn ping_info(body: &mut Out, ping: &Ping, own: &Solution, bytes: u16, sector_bytes: u16) {
    let end = body.data.len() + usize::from(bytes);
    body.u16(bytes).zeros(90);
    body.u16(ping.sectors.len() as u16).u16(sector_bytes);
    body.real(degrees(own.heading_rad).rem_euclid(360.0));
    body.real(ping.head_speed_m_s).real(own.array_depth_m);
    body.real(-own.water_line_m);
    body.zeros(end - body.data.len());
}

fn motion_sample(body: &mut Out, a: &Attitude, position: Option<&Position>) {
    let end = body.data.len() + 132;
    let (seconds, nanoseconds) = seconds_and_rest(a.time_s);
    let unknown = u32::from(position.is_none()) | u32::from(a.heading_rad.is_none()) << 2;
    let of = |value: fn(&Position) -> f64| position.map_or(0.0, value);
    body.raw(b"#KMB")
        .u16(120)
        .u16(1)
        .u32(seconds)
        .u32(nanoseconds);
    body.u32(unknown | u32::from(a.heave_m.is_none()) << 3);
    body.f64(degrees(of(|p| p.latitude_rad)));
    body.f64(degrees(of(|p| p.longitude_rad)));
    body.real(of(|p| p.height_m.unwrap_or(-999.0)));
    body.real(degrees(a.roll_rad)).real(degrees(a.pitch_rad));
    body.real(degrees(a.heading_rad.unwrap_or(0.0)).rem_euclid(360.0));
    body.real(-a.heave_m.unwrap_or(0.0));
    body.zeros(end - body.data.len());
}
