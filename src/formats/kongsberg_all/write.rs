//! Writes datagrams, for simulators that export the format and for tests.
//!
//! The format rounds: angles to 0.01 degree, heave to a centimetre, sound speed to a decimetre per second, times to a millisecond.

use std::io::{self, Write};

use super::checksum;
use super::raw::{ETX, STX};
use crate::formats::recorder::{
    Attitude, Out, Ping, Position, Profile, Solution, WaterHeight, utc,
};
use crate::units::degrees;

/// Writes datagrams into a file.
pub struct Writer<W> {
    out: W,
    model: u16,
    serial: u16,
    big_endian: bool,
    counter: u16,
}

impl<W: Write> Writer<W> {
    /// Of a model and a serial number, little-endian as today's systems are.
    pub fn new(out: W, model: u16, serial: u16) -> Self {
        Self {
            out,
            model,
            serial,
            big_endian: false,
            counter: 0,
        }
    }

    /// The same with the most significant byte first.
    #[must_use]
    pub fn big_endian(mut self) -> Self {
        self.big_endian = true;
        self
    }

    /// Another head: the serial number of what follows.
    pub fn head(&mut self, serial: u16) {
        self.serial = serial;
    }

    /// What was written into.
    pub fn into_inner(self) -> W {
        self.out
    }

    fn body(&self) -> Out {
        Out::new(self.big_endian)
    }

    /// A datagram of any kind.
    ///
    /// # Errors
    /// Those of the output.
    pub fn datagram(&mut self, kind: u8, time_s: f64, counter: u16, body: &Out) -> io::Result<()> {
        let (date, day_ms) = date_and_ms(time_s);
        let mut whole = self.body();
        whole.u32(0).u8(STX).u8(kind).u16(self.model);
        whole.u32(date).u32(day_ms).u16(counter).u16(self.serial);
        whole.raw(&body.data);
        // the whole, length field left out, has an even number of bytes
        whole.zeros((whole.data.len() + 1) % 2);
        let sum = checksum(&whole.data[5..]);
        whole.u8(ETX).u16(sum);
        let rest = whole.data.len() - 4;
        whole.set_u32(0, rest as u32);
        self.out.write_all(&whole.data)
    }

    fn next(&mut self) -> u16 {
        self.counter = self.counter.wrapping_add(1);
        self.counter
    }

    /// The installation record (`I`) as its text `KEY=value,...`, and the serial number of a second head (0 for none).
    ///
    /// # Errors
    /// Those of the output.
    pub fn installation(&mut self, time_s: f64, text: &str, second: u16) -> io::Result<()> {
        let mut body = self.body();
        body.u16(second).raw(text.as_bytes()).u8(0);
        let counter = self.next();
        self.datagram(b'I', time_s, counter, &body)
    }

    /// Attitude samples (`A`), at most 65 s and 1000 samples, in order of time.
    ///
    /// # Errors
    /// Those of the output.
    pub fn attitude(&mut self, samples: &[Attitude]) -> io::Result<()> {
        let Some(first) = samples.first() else {
            return Ok(());
        };
        let begin_s = (1e3 * first.time_s).floor() / 1e3;
        let mut body = self.body();
        body.u16(samples.len() as u16);
        for a in samples {
            body.u16((1e3 * (a.time_s - begin_s)).round() as u16).u16(0);
            body.i16(hundredths(a.roll_rad))
                .i16(hundredths(a.pitch_rad));
            body.i16((-100.0 * a.heave_m.unwrap_or(0.0)).round() as i16);
            body.u16(turn(a.heading_rad.unwrap_or(0.0)));
        }
        body.u8(first.sensor << 4);
        let counter = self.next();
        self.datagram(b'A', begin_s, counter, &body)
    }

    /// A position (`P`) with a GGA telegram that holds the height above the ellipsoid, where there is one.
    ///
    /// # Errors
    /// Those of the output.
    pub fn position(&mut self, p: &Position, heading_rad: f64) -> io::Result<()> {
        let mut body = self.body();
        body.i32((2e7 * degrees(p.latitude_rad)).round() as i32);
        body.i32((1e7 * degrees(p.longitude_rad)).round() as i32);
        body.u16(0).u16(0).u16(0).u16(turn(heading_rad));
        let telegram = p.height_m.map_or(String::new(), |h| gga(p.time_s, h));
        body.u8(0x80 | p.sensor.clamp(1, 3))
            .u8(telegram.len() as u8);
        body.raw(telegram.as_bytes());
        let counter = self.next();
        self.datagram(b'P', p.time_s, counter, &body)
    }

    /// The height of the water level (`h`).
    ///
    /// # Errors
    /// Those of the output.
    pub fn water_height(&mut self, h: &WaterHeight) -> io::Result<()> {
        let mut body = self.body();
        body.i32((100.0 * h.height_m).round() as i32).u8(0);
        let counter = self.next();
        self.datagram(b'h', h.time_s, counter, &body)
    }

    /// A sound-speed profile (`U`), depths to the centimetre.
    ///
    /// # Errors
    /// Those of the output.
    pub fn profile(&mut self, profile: &Profile) -> io::Result<()> {
        let (date, day_ms) = date_and_ms(profile.time_s);
        let mut body = self.body();
        body.u32(date).u32(day_ms / 1000);
        body.u16(profile.depth_m.len() as u16).u16(1);
        for (depth_m, speed_m_s) in profile.depth_m.iter().zip(&profile.speed_m_s) {
            body.u32((100.0 * depth_m).round() as u32);
            body.u32((10.0 * speed_m_s).round() as u32);
        }
        let counter = self.next();
        self.datagram(b'U', profile.time_s, counter, &body)
    }

    /// A ping (`N`).
    ///
    /// # Errors
    /// Those of the output.
    pub fn ping(&mut self, ping: &Ping) -> io::Result<()> {
        let mut body = self.body();
        let valid = ping.beams.iter().filter(|b| b.valid).count();
        body.u16((10.0 * ping.head_speed_m_s).round() as u16);
        body.u16(ping.sectors.len() as u16);
        body.u16(ping.beams.len() as u16).u16(valid as u16);
        body.f32(0.0).u32(0);
        for (k, s) in ping.sectors.iter().enumerate() {
            body.i16(hundredths(s.tilt_rad)).u16(0).f32(0.0);
            body.real(s.delay_s).real(s.frequency_hz);
            body.u16(0).u8(0).u8(k as u8).f32(0.0);
        }
        for b in &ping.beams {
            body.i16(hundredths(-b.angle_rad)).u8(b.sector as u8);
            body.u8(if b.valid { 0 } else { 0x80 }).zeros(4);
            body.real(b.two_way_s).zeros(4);
        }
        body.u8(0);
        self.datagram(b'N', ping.time_s, ping.number as u16, &body)
    }

    /// The own solution of a ping (`X`).
    ///
    /// # Errors
    /// Those of the output.
    pub fn solution(&mut self, s: &Solution, head_speed_m_s: f64) -> io::Result<()> {
        let mut body = self.body();
        let valid = s.points.iter().filter(|p| p.valid).count();
        body.u16(turn(s.heading_rad));
        body.u16((10.0 * head_speed_m_s).round() as u16);
        body.real(s.array_depth_m);
        body.u16(s.points.len() as u16).u16(valid as u16);
        body.f32(0.0).zeros(4);
        for p in &s.points {
            let v = p.right_forward_up_m;
            body.real(-v.z).real(v.x).real(v.y).zeros(4);
            body.u8(if p.valid { 0 } else { 0x80 }).zeros(3);
        }
        body.u8(0);
        self.datagram(b'X', s.time_s, s.number as u16, &body)
    }
}

/// Hundredths of a degree.
fn hundredths(angle_rad: f64) -> i16 {
    (100.0 * degrees(angle_rad)).round() as i16
}

/// Hundredths of a degree from 0 to 360.
fn turn(angle_rad: f64) -> u16 {
    (100.0 * degrees(angle_rad).rem_euclid(360.0)).round() as u16 % 36_000
}

/// A Unix time as the number yyyymmdd and milliseconds of the day.
fn date_and_ms(time_s: f64) -> (u32, u32) {
    let ms = (1e3 * time_s).round().max(0.0) as u64;
    let (year, month, day) = utc::date((ms / 86_400_000) as i64);
    (year * 10_000 + month * 100 + day, (ms % 86_400_000) as u32)
}

/// A telegram with a time and a height above the ellipsoid, the undulation zero.
fn gga(time_s: f64, height_m: f64) -> String {
    let of_day = time_s.rem_euclid(utc::DAY_S);
    let (hour, minute) = ((of_day / 3600.0).floor(), (of_day / 60.0).floor() % 60.0);
    let second = of_day % 60.0;
    format!("INGGA,{hour:02.0}{minute:02.0}{second:06.3},,,,,4,9,0.7,{height_m:.3},M,0.000,M,,")
}
