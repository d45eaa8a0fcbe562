//! From records to ours: the frame is the same, radians too.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use super::raw::{DETECTIONS, Detection, DetectionHead, FRAME, Frame, Settings};
use crate::formats::recorder::{
    Array, Attitude, BeamSample, Bytes, Heading, Installation, Losses, Mounted, Ping, Position,
    Profile, Role, Sector, Sink, Summary, utc,
};
use crate::observe::Mounting;

/// Most halves of pings that wait for the other half.
const MOST_WAITING: usize = 64;

/// What an angle of four bytes may exceed its limit by, radians.
const SLACK_RAD: f64 = 1e-3;

/// What joins settings and detections: device, ping, part.
type Key = (u32, u32, u16);

/// Turns records into ours, one after the other.
pub struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    settings: Vec<(Key, Settings, f64)>,
    detections: Vec<(Key, Ping)>,
}

impl<'s> Reader<'s> {
    /// Nothing read yet.
    pub fn new(sink: &'s mut dyn Sink) -> Self {
        let mut summary = Summary::of("s7k");
        summary.note("the reader of this format was written from its specification and has not been tried on a real file");
        Self {
            sink,
            summary,
            settings: vec![],
            detections: vec![],
        }
    }

    /// Takes one record.
    pub fn take(&mut self, record: &Bytes, losses: &mut Losses) {
        let Some(frame) = Frame::read(record) else {
            losses.malformed += 1;
            return;
        };
        self.summary.count(&frame.kind.to_string());
        if self.known(&frame, record, losses).is_none() {
            losses.malformed += 1;
        }
    }

    /// Reads the data of a kind that is used; `None` when its content does not fit its length or its time is no time.
    fn known(&mut self, frame: &Frame, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let data = record.part(FRAME, record.data.len() - FRAME - 4)?;
        match frame.kind {
            7000 => self.settings(frame, &data, losses),
            7027 => self.detections(frame, &data, losses),
            7030 => self.installation(&data, unix_s(frame)?),
            1003 => self.position(&data, unix_s(frame)?, losses),
            1012 => self.motion(&data, unix_s(frame)?, losses),
            1013 => self.heading(unix_s(frame)?, data.real(0)?, losses),
            1015 => self.navigation(&data, unix_s(frame)?, losses),
            1016 => self.motions(&data, unix_s(frame)?, losses),
            1009 => self.profile(&data, unix_s(frame)?, (20, 24, 8, 0, 4), losses),
            1010 => self.cast(&data, unix_s(frame)?, losses),
            _ => Some(()),
        }
    }

    fn settings(&mut self, frame: &Frame, data: &Bytes, losses: &mut Losses) -> Option<()> {
        let settings = Settings::read(data)?;
        let key = (frame.device, settings.ping.0, settings.ping.1);
        if settings.receive_flags & 1 == 1 {
            self.summary.applied("beams are steered for roll (7000); the angles of 7027 are the head's and still need roll");
        }
        let waiting = self.detections.iter().position(|(k, _)| *k == key);
        if let Some(at) = waiting {
            let (_, mut ping) = self.detections.swap_remove(at);
            self.finish(&settings, unix_s(frame)?, &mut ping);
            return Some(());
        }
        self.settings.push((key, settings, unix_s(frame)?));
        if self.settings.len() > MOST_WAITING {
            self.settings.remove(0);
            losses.unpaired += 1;
        }
        Some(())
    }

    fn detections(&mut self, frame: &Frame, data: &Bytes, losses: &mut Losses) -> Option<()> {
        let head = DetectionHead::read(data)?;
        if head.bytes < Detection::LEAST || !(head.rate_hz > 0.0 && head.rate_hz.is_finite()) {
            return None;
        }
        let rows = data.parts(DETECTIONS, head.count as usize, head.bytes as usize)?;
        let mut ping = Ping {
            number: head.ping.0,
            head: frame.device,
            sectors: vec![Sector {
                tilt_rad: head.transmit_rad.into(),
                ..Sector::default()
            }],
            ..Ping::default()
        };
        for row in rows {
            let raw = Detection::read(&row)?;
            let beam = beam(&raw, head.rate_hz.into());
            losses.impossible += u64::from(!beam.valid && raw.quality & 3 != 0);
            ping.beams.push(beam);
        }
        let key = (frame.device, head.ping.0, head.ping.1);
        if let Some(at) = self.settings.iter().position(|(k, _, _)| *k == key) {
            let (_, settings, time_s) = self.settings.swap_remove(at);
            self.finish(&settings, time_s, &mut ping);
            return Some(());
        }
        self.detections.push((key, ping));
        if self.detections.len() > MOST_WAITING {
            self.detections.remove(0);
            losses.unpaired += 1;
        }
        Some(())
    }

    /// A ping whose two halves are there.
    fn finish(&mut self, settings: &Settings, time_s: f64, ping: &mut Ping) {
        ping.time_s = time_s;
        ping.head_speed_m_s = settings.speed_m_s.into();
        ping.sectors[0].frequency_hz = settings.frequency_hz.into();
        self.summary.head(ping.head);
        self.sink.ping(ping);
    }

    fn installation(&mut self, data: &Bytes, time_s: f64) -> Option<()> {
        let transmitter = array(data, 524, "transmitter", Role::Transmit)?;
        let receiver = array(data, 548, "receiver", Role::Receive)?;
        let motion = mounted(data, 572, "motion sensor", 1e-3 * f64::from(data.u16(596)?))?;
        let antenna = Mounted {
            mounting: Mounting::from_angles(0.0, 0.0, 0.0, vector(data, 598)?),
            name: "position sensor".to_owned(),
            ..motion.clone()
        };
        let arrays = vec![transmitter, receiver];
        let water_line_m = Some(data.real(612)?);
        if arrays
            .iter()
            .all(|a| a.mounted.mounting.lever_arm_m == Vector3::zeros())
        {
            self.summary.note("the installation record (7030) holds zeros: some recorders bring everything to the reference point themselves; give the arms in the survey file");
        }
        self.sink.installation(&Installation {
            time_s,
            arrays,
            motion_sensors: vec![motion],
            position_sensors: vec![antenna],
            water_line_m,
            attitude_is_turned: true,
            ..Installation::default()
        });
        Some(())
    }

    fn position(&mut self, data: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        let (latitude, longitude, height) = (data.f64(8)?, data.f64(16)?, data.f64(24)?);
        if data.u8(32)? != 0 {
            self.summary
                .note("positions (1003) on a grid, not geographic, are not used");
            return Some(());
        }
        self.place(time_s, (latitude, longitude, height), 0, losses);
        Some(())
    }

    fn place(&mut self, time_s: f64, place: (f64, f64, f64), sensor: u8, losses: &mut Losses) {
        let (latitude_rad, longitude_rad, height_m) = place;
        let placed =
            latitude_rad.abs() <= FRAC_PI_2 + SLACK_RAD && longitude_rad.abs() <= PI + SLACK_RAD;
        if !(placed && time_s.is_finite()) {
            losses.impossible += 1;
            return;
        }
        self.sink.position(&Position {
            time_s,
            latitude_rad,
            longitude_rad,
            height_m: (height_m.abs() < 2e4).then_some(height_m),
            sensor,
            passive: false,
            at_reference: sensor == 1,
        });
    }

    fn motion(&mut self, data: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        let (roll, pitch, heave) = (data.real(0)?, data.real(4)?, data.real(8)?);
        self.attitude(time_s, [roll, pitch, heave], None, 0, losses);
        Some(())
    }

    fn attitude(
        &mut self,
        time_s: f64,
        [roll_rad, pitch_rad, heave_m]: [f64; 3],
        heading_rad: Option<f64>,
        sensor: u8,
        losses: &mut Losses,
    ) {
        let turned = roll_rad.abs() <= PI + SLACK_RAD && pitch_rad.abs() <= FRAC_PI_2 + SLACK_RAD;
        let headed = heading_rad.is_none_or(|h| h.abs() <= TAU + SLACK_RAD);
        if !(turned && headed && time_s.is_finite()) {
            losses.impossible += 1;
            return;
        }
        self.sink.attitude(&Attitude {
            time_s,
            roll_rad,
            pitch_rad,
            heading_rad,
            heave_m: (heave_m.abs() < 100.0).then_some(heave_m),
            sensor,
            passive: false,
        });
    }

    fn heading(&mut self, time_s: f64, heading_rad: f64, losses: &mut Losses) -> Option<()> {
        if heading_rad.abs() <= TAU + SLACK_RAD {
            self.sink.heading(&Heading {
                time_s,
                heading_rad,
            });
        } else {
            losses.impossible += 1;
        }
        Some(())
    }

    fn navigation(&mut self, data: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        let place = (data.f64(1)?, data.f64(9)?, data.real(21)?);
        self.place(time_s, place, 1, losses);
        self.heading(time_s, data.real(37)?, losses)
    }

    fn motions(&mut self, data: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        for row in data.parts(1, data.u8(0)?.into(), 18)? {
            let after_s = 1e-3 * f64::from(row.u16(0)?);
            let motion = [row.real(2)?, row.real(6)?, row.real(10)?];
            let heading = Some(row.real(14)?);
            self.attitude(time_s + after_s, motion, heading, 1, losses);
        }
        Some(())
    }

    /// Sound speed: where the count and the rows stand, bytes of a row, where in it depth and speed are.
    fn profile(
        &mut self,
        data: &Bytes,
        time_s: f64,
        (count_at, rows_at, bytes, depth_at, speed_at): (usize, usize, usize, usize, usize),
        losses: &mut Losses,
    ) -> Option<()> {
        let count = data.u32(count_at)? as usize;
        let mut profile = Profile {
            time_s,
            ..Profile::default()
        };
        for row in data.parts(rows_at, count, bytes)? {
            let (depth_m, speed_m_s) = (row.real(depth_at)?, row.real(speed_at)?);
            let below = profile.depth_m.last().is_none_or(|d| depth_m > *d);
            if below && depth_m >= 0.0 && (1000.0..2000.0).contains(&speed_m_s) {
                profile.depth_m.push(depth_m);
                profile.speed_m_s.push(speed_m_s);
            } else {
                losses.impossible += 1;
            }
        }
        self.sink.profile(&profile);
        Some(())
    }

    fn cast(&mut self, data: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        if data.u8(7)? == 0 {
            self.summary
                .note("a cast (1010) by pressure, not depth, is not used");
            return Some(());
        }
        self.profile(data, time_s, (32, 36, 20, 8, 12), losses)
    }

    /// The summary of the whole file.
    pub fn finished(mut self, mut losses: Losses) -> Summary {
        losses.unpaired += (self.settings.len() + self.detections.len()) as u64;
        self.summary.losses = losses;
        let heads = self.summary.heads.iter().map(u32::to_string);
        self.summary.device = format!("Teledyne {}", heads.collect::<Vec<_>>().join(", "));
        let has = |kind: &str| self.summary.records.contains_key(kind);
        if !has("7027") {
            let only_old = has("7006") || has("7004");
            let reason = if only_old {
                "only the older detections (7004 with 7006): their angles are levelled under roll stabilisation, which hides the mounting; record 7027"
            } else {
                "no detections (7027) in the file"
            };
            self.summary.refusal = Some(reason.to_owned());
        }
        self.summary
    }
}

/// Unix time of a frame.
fn unix_s(frame: &Frame) -> Option<f64> {
    let ((year, day), (hour, minute)) = (frame.date, frame.clock);
    let seconds = f64::from(frame.seconds);
    let possible = hour < 24 && minute < 60 && (0.0..61.0).contains(&seconds);
    let of_day = 3600.0 * f64::from(hour) + 60.0 * f64::from(minute) + seconds;
    utc::from_day_of_year(year.into(), day.into(), of_day).filter(|_| possible)
}

fn beam(raw: &Detection, rate_hz: f64) -> BeamSample {
    let two_way_s = f64::from(raw.samples) / rate_hz;
    let possible =
        two_way_s > 0.0 && two_way_s < 60.0 && f64::from(raw.angle_rad).abs() <= PI + SLACK_RAD;
    BeamSample {
        number: raw.beam.into(),
        sector: 0,
        valid: possible && raw.quality & 3 != 0,
        angle_rad: raw.angle_rad.into(),
        two_way_s,
    }
}

fn vector(data: &Bytes, at: usize) -> Option<Vector3<f64>> {
    let v = Vector3::new(data.real(at)?, data.real(at + 4)?, data.real(at + 8)?);
    v.iter().all(|c| c.is_finite()).then_some(v)
}

/// Six numbers: X, Y, Z, roll, pitch, yaw.
fn mounted(data: &Bytes, at: usize, name: &str, delay_s: f64) -> Option<Mounted> {
    let angles = vector(data, at + 12)?;
    let arm_m = vector(data, at)?;
    Some(Mounted {
        name: name.to_owned(),
        mounting: Mounting::from_angles(angles.x, angles.y, angles.z, arm_m),
        delay_s,
        active: true,
    })
}

fn array(data: &Bytes, at: usize, name: &str, role: Role) -> Option<Array> {
    Some(Array {
        mounted: mounted(data, at, name, 0.0)?,
        role,
        head: 0,
        inner_m: [Vector3::zeros(); 2],
    })
}
