//! From packets to records in our frame and units.

use nalgebra::Vector3;

use super::raw::{Channel, Clock, HEADER, PING_HEADER, Packet, PingHead, RawAttitude, RawPosition};
use crate::formats::recorder::{
    Array, Attitude, BeamSample, Bytes, Installation, Losses, Mounted, Ping, Position, Role,
    Sector, Sink, Summary, utc,
};
use crate::observe::Mounting;
use crate::units::radians;

/// Most channels whose description is read; the header of a file with more is longer than any at hand.
const MOST_CHANNELS: usize = 126;
/// Bytes of the more-info block that follows the first numbers of a section of angles.
const MORE_INFO: usize = 24;

/// Turns packets into records, one after the other.
pub struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    ping: Ping,
    angle_rad: Vec<f64>,
    two_way_s: Vec<f64>,
}

/// Blocks of 1024 bytes in the file's header: channels above six make it longer.
#[must_use]
pub fn header_blocks(header: &Bytes) -> usize {
    (256 + channels(header) * Channel::BYTES).div_ceil(HEADER)
}

fn channels(header: &Bytes) -> usize {
    let count = |at| usize::from(header.u16(at).unwrap_or(0));
    (count(166) + count(168)).min(MOST_CHANNELS)
}

impl<'s> Reader<'s> {
    /// Nothing read yet.
    pub fn new(sink: &'s mut dyn Sink) -> Self {
        Self {
            sink,
            summary: Summary::of("xtf"),
            ping: Ping::default(),
            angle_rad: vec![],
            two_way_s: vec![],
        }
    }

    /// The file's header: where the sounder is mounted.
    pub fn header(&mut self, header: &Bytes) {
        let recorder = header.text(2, 8).unwrap_or_default();
        self.summary.device = format!("XTF by {recorder}");
        let channels = (0..channels(header))
            .filter_map(|k| Channel::read(&header.part(256 + k * Channel::BYTES, Channel::BYTES)?));
        let arrays: Vec<Array> = channels
            .filter(|c| c.kind == 3)
            .map(|c| array(&c))
            .collect();
        if arrays.is_empty() {
            return;
        }
        self.summary.note("offsets and angles of the header: the file does not say their signs; taken as starboard, forward, down and as in the XTF description, which no file at hand proves");
        self.sink.installation(&Installation {
            arrays,
            attitude_is_turned: true,
            ..Installation::default()
        });
    }

    /// Takes one packet.
    pub fn take(&mut self, record: &Bytes, losses: &mut Losses) {
        let Some(packet) = Packet::read(record) else {
            losses.malformed += 1;
            return;
        };
        self.summary.count(&packet.kind.to_string());
        let read = match packet.kind {
            3 => self.attitude(record, losses),
            107 => self.position(record, losses),
            65 => self.ping(record, losses),
            _ => Some(()),
        };
        losses.malformed += u64::from(read.is_none());
    }

    fn attitude(&mut self, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let raw = RawAttitude::read(record)?;
        let time_s = unix_s(&raw.clock, 1e-3 * f64::from(raw.milliseconds))?;
        let [pitch, roll] = raw.pitch_roll_deg.map(f64::from);
        let heading = f64::from(raw.heading_deg);
        if !(roll.abs() <= 180.0 && pitch.abs() <= 90.0 && heading.abs() <= 360.0) {
            losses.impossible += 1;
            return Some(());
        }
        let heave = f64::from(raw.heave_m);
        self.sink.attitude(&Attitude {
            time_s,
            roll_rad: radians(roll),
            pitch_rad: radians(pitch),
            heading_rad: Some(radians(heading)),
            heave_m: (heave.abs() < 100.0).then_some(heave),
            ..Attitude::default()
        });
        Some(())
    }

    fn position(&mut self, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let raw = RawPosition::read(record)?;
        let time_s = unix_s(&raw.clock, 1e-4 * f64::from(raw.tenths_ms))?;
        if !(raw.latitude_deg.abs() <= 90.0 && raw.longitude_deg.abs() <= 180.0) {
            losses.impossible += 1;
            return Some(());
        }
        self.sink.position(&Position {
            time_s,
            latitude_rad: radians(raw.latitude_deg),
            longitude_rad: radians(raw.longitude_deg),
            height_m: (raw.height_m.abs() < 2e4).then_some(raw.height_m),
            ..Position::default()
        });
        Some(())
    }

    fn ping(&mut self, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let rest = record.data.get(PING_HEADER..)?;
        if rest.get(..4)? != b"BTH0" {
            self.summary.note("packets of type 65 without a BTH0 block");
            return Some(());
        }
        let block = Bytes::big(rest);
        let size = (block.u32(4)? as usize).min(rest.len());
        let block = block.part(0, size)?;
        let head = self.sections(&block)?;
        let beams = usize::from(head.beams);
        if self.angle_rad.len() < beams || self.two_way_s.len() < beams {
            return None;
        }
        self.fill(&head, losses);
        self.sink.ping(&self.ping);
        Some(())
    }

    /// Walks the sections of a ping; its head, with angles and times put aside.
    fn sections(&mut self, block: &Bytes) -> Option<PingHead> {
        let (mut at, mut head) = (12, None);
        self.angle_rad.clear();
        self.two_way_s.clear();
        while at + 4 <= block.data.len() {
            let name = block.part(at, 2)?.data;
            let size = usize::from(block.u16(at + 2)?);
            if size < 4 {
                break;
            }
            let body = block.part(at + 4, size - 4)?;
            let beams = head.as_ref().map_or(0, |h: &PingHead| usize::from(h.beams));
            match name {
                b"H0" => head = Some(PingHead::read(&body)?),
                b"R0" => times(&body, beams, &mut self.two_way_s)?,
                b"A2" => steps(&body, beams, &mut self.angle_rad)?,
                b"A0" => even(&body, beams, &mut self.angle_rad)?,
                _ => {}
            }
            at += size;
        }
        head
    }

    fn fill(&mut self, head: &PingHead, losses: &mut Losses) {
        let ping = &mut self.ping;
        self.summary.device = format!("R2Sonic {} {}", head.model, head.serial);
        if head.steering_rad.iter().any(|s| s.abs() > 1e-4) {
            self.summary.note(
                "the projector is steered; the sign of its angle has not been tried on a real file",
            );
        }
        ping.time_s = f64::from(head.seconds) + 1e-9 * f64::from(head.nanoseconds);
        ping.number = head.ping;
        ping.head_speed_m_s = head.speed_m_s.into();
        ping.sectors.clear();
        ping.sectors.push(Sector {
            tilt_rad: head.steering_rad[0].into(),
            frequency_hz: head.frequency_hz.into(),
            ..Sector::default()
        });
        ping.beams.clear();
        let both = self.angle_rad.iter().zip(&self.two_way_s);
        for (k, (angle_rad, two_way_s)) in both.take(head.beams.into()).enumerate() {
            let possible = angle_rad.abs() <= std::f64::consts::PI && *two_way_s < 60.0;
            losses.impossible += u64::from(!possible);
            ping.beams.push(BeamSample {
                number: k as u32,
                sector: 0,
                valid: possible && *two_way_s > 0.0,
                angle_rad: *angle_rad,
                two_way_s: *two_way_s,
            });
        }
    }

    /// The summary of the whole file.
    pub fn finished(mut self, losses: Losses) -> Summary {
        self.summary.losses = losses;
        self.summary.head(0);
        if !self.summary.records.contains_key("65") {
            let kinds: Vec<&str> = self.summary.records.keys().map(String::as_str).collect();
            self.summary.refusal = Some(format!(
                "no R2Sonic soundings (packet 65) in this XTF, only packets {}: other bathymetry in XTF is processed depths or a maker's own layout",
                kinds.join(", ")
            ));
        }
        self.summary
    }
}

/// The sounder's mounting of the header.
fn array(channel: &Channel) -> Array {
    let [starboard, forward, down] = channel.offset_m.map(f64::from);
    let [yaw, pitch, roll] = channel.yaw_pitch_roll_deg.map(|a| radians(a.into()));
    let arm_m = Vector3::new(starboard, forward, -down);
    Array {
        mounted: Mounted {
            name: channel.name.clone(),
            mounting: Mounting::from_angles(roll, pitch, yaw, arm_m),
            delay_s: 0.0,
            active: true,
        },
        role: Role::Both,
        head: 0,
        inner_m: [Vector3::zeros(); 2],
    }
}

fn unix_s(clock: &Clock, rest_s: f64) -> Option<f64> {
    let ((year, month, day), (hour, minute, second)) = (clock.date, clock.time);
    let days = utc::days(year.into(), month.into(), day.into())? as f64;
    let of_day = 3600.0 * f64::from(hour) + 60.0 * f64::from(minute) + f64::from(second);
    (hour < 24 && minute < 60 && second < 61).then_some(days * utc::DAY_S + of_day + rest_s)
}

/// Two-way times: a scale and a number for each beam.
fn times(body: &Bytes, beams: usize, into: &mut Vec<f64>) -> Option<()> {
    let scale = body.real(0)?;
    for step in body.parts(4, beams, 2)? {
        into.push(scale * f64::from(step.u16(0)?));
    }
    Some(())
}

/// Angles: the first, and steps that add up.
fn steps(body: &Bytes, beams: usize, into: &mut Vec<f64>) -> Option<()> {
    let (first, scale) = (body.real(0)?, body.real(4)?);
    let mut sum = 0u32;
    for step in body.parts(8 + MORE_INFO, beams, 2)? {
        sum += u32::from(step.u16(0)?);
        into.push(first + scale * f64::from(sum));
    }
    Some(())
}

/// Angles evenly spread from the first to the last.
fn even(body: &Bytes, beams: usize, into: &mut Vec<f64>) -> Option<()> {
    let (first, last) = (body.real(0)?, body.real(4)?);
    let gaps = beams.saturating_sub(1).max(1) as f64;
    into.extend((0..beams).map(|k| first + (last - first) * k as f64 / gaps));
    Some(())
}
