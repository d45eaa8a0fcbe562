//! From datagrams to records in our frame and units.

use nalgebra::Vector3;

use super::installation::installation;
use super::raw::{
    Common, HEADER, Header, LONGEST, Motion, PingInfo, RawPosition, RawSector, RawSounding,
    ReceiverInfo,
};
use crate::formats::recorder::{
    Attitude, BeamSample, Bytes, Losses, Origin, OwnPoint, Ping, Position, Profile, Sector, Sink,
    Solution, Summary,
};
use crate::units::radians;

/// Bytes of the partition that follows the header of multibeam datagrams.
const PARTITION: usize = 4;
/// Fewest bytes of a sounding that reach its last used value.
const LEAST_SOUNDING: usize = 108;

/// Turns datagrams into records, one after the other.
pub struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    sounder: u16,
    parts: Parts,
    ping: Ping,
    solution: Solution,
    profile: Profile,
}

/// A split datagram on its way to be whole.
#[derive(Default)]
struct Parts {
    header: Option<Header>,
    of: u16,
    got: u16,
    bytes: Vec<u8>,
}

impl Parts {
    /// Takes a part; the bytes behind the partition when it was the last.
    fn take(&mut self, header: &Header, body: &Bytes, losses: &mut Losses) -> Option<Vec<u8>> {
        let (of, number) = (body.u16(0)?, body.u16(2)?);
        if number == 1 {
            self.drop_begun(losses);
            (self.header, self.of) = (Some(*header), of);
        }
        let continues = self.header == Some(*header) && self.of == of && self.got + 1 == number;
        let bytes = body.data.get(PARTITION..)?;
        if !continues || self.bytes.len() + bytes.len() > LONGEST {
            losses.incomplete += 1;
            self.drop_begun(losses);
            return None;
        }
        self.bytes.extend_from_slice(bytes);
        self.got = number;
        if number < of {
            return None;
        }
        self.got = 0;
        self.header = None;
        Some(std::mem::take(&mut self.bytes))
    }

    /// Gives up what was begun, and counts its parts.
    fn drop_begun(&mut self, losses: &mut Losses) {
        losses.incomplete += u64::from(self.got);
        *self = Self::default();
    }
}

/// Unix time of whole seconds and nanoseconds.
fn time_s(seconds: u32, nanoseconds: u32) -> f64 {
    f64::from(seconds) + 1e-9 * f64::from(nanoseconds)
}

impl<'s> Reader<'s> {
    /// Nothing read yet.
    pub fn new(sink: &'s mut dyn Sink) -> Self {
        let mut summary = Summary::of("kmall");
        summary.applied("the corrections of angle and travel time (MRZ) are in the beams");
        Self {
            sink,
            summary,
            sounder: 0,
            parts: Parts::default(),
            ping: Ping::default(),
            solution: Solution::default(),
            profile: Profile::default(),
        }
    }

    /// Takes one datagram.
    pub fn take(&mut self, record: &Bytes, losses: &mut Losses) {
        let Some(header) = Header::read(record) else {
            losses.malformed += 1;
            return;
        };
        let kind = std::str::from_utf8(&header.kind[1..]).unwrap_or("?");
        self.summary.count(kind);
        self.sounder = header.sounder;
        if self.known(&header, record, losses).is_none() {
            losses.malformed += 1;
        }
    }

    /// Reads the body of a kind that is used; `None` when its content does not fit its length.
    fn known(&mut self, header: &Header, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let body = record.part(HEADER, record.data.len() - HEADER - 4)?;
        match &header.kind {
            b"#MRZ" => self.partitioned(header, &body, losses),
            b"#SKM" => self.motion(&body, losses),
            b"#SPO" => self.position(&body, losses),
            b"#SVP" => self.profile(header, &body, losses),
            b"#IIP" => {
                let text = body.text(6, body.data.len().checked_sub(6)?)?;
                let record = installation(time_s(header.seconds, header.nanoseconds), &text);
                self.sink.installation(&record);
                Some(())
            }
            _ => Some(()),
        }
    }

    /// A multibeam datagram that may be one part of several.
    fn partitioned(&mut self, header: &Header, body: &Bytes, losses: &mut Losses) -> Option<()> {
        if body.u16(0)? <= 1 {
            self.parts.drop_begun(losses);
            let rest = body.part(PARTITION, body.data.len() - PARTITION)?;
            return self.ping(header, &rest, losses);
        }
        match self.parts.take(header, body, losses) {
            Some(whole) => self.ping(header, &Bytes::little(&whole), losses),
            None => Some(()),
        }
    }

    fn ping(&mut self, header: &Header, body: &Bytes, losses: &mut Losses) -> Option<()> {
        let common = Common::read(body)?;
        let info_at = usize::from(common.bytes);
        let info = PingInfo::read(&body.part(info_at, body.data.len().checked_sub(info_at)?)?)?;
        let sectors_at = info_at + usize::from(info.bytes);
        let sector_bytes = usize::from(info.sector_bytes);
        let sectors = body.parts(sectors_at, info.sectors.into(), sector_bytes)?;
        let receiver_at = sectors_at + usize::from(info.sectors) * sector_bytes;
        let rest = body.data.len().checked_sub(receiver_at)?;
        let receiver = ReceiverInfo::read(&body.part(receiver_at, rest)?)?;
        let classes = usize::from(receiver.classes) * usize::from(receiver.class_bytes);
        let soundings_at = receiver_at + usize::from(receiver.bytes) + classes;
        let count = usize::from(receiver.soundings) + usize::from(receiver.extra);
        let sounding_bytes = usize::from(receiver.sounding_bytes);
        let soundings = body.parts(soundings_at, count, sounding_bytes)?;
        if count > 0 && sounding_bytes < LEAST_SOUNDING {
            return None;
        }
        self.begin(header, &common, &info);
        let mut index = [u16::MAX; 256];
        for (k, sector) in sectors.enumerate() {
            let raw = RawSector::read(&sector)?;
            index[usize::from(raw.number)] = k as u16;
            self.ping.sectors.push(sector_of(&raw));
        }
        for (k, sounding) in soundings.enumerate() {
            let raw = RawSounding::read(&sounding)?;
            let sample = beam_of(k as u32, &raw, index[usize::from(raw.sector)]);
            losses.impossible += u64::from(!sample.valid && raw.kind == 0);
            self.solution.points.push(own_point(&raw, sample.valid));
            self.ping.beams.push(sample);
        }
        self.summary.head(self.ping.head);
        self.sink.ping(&self.ping);
        self.sink.solution(&self.solution);
        Some(())
    }

    /// Begins a ping and its solution from the fixed parts.
    fn begin(&mut self, header: &Header, common: &Common, info: &PingInfo) {
        let (ping, solution) = (&mut self.ping, &mut self.solution);
        ping.time_s = time_s(header.seconds, header.nanoseconds);
        ping.number = common.ping.into();
        ping.head = u32::from(common.receiver) + 1;
        ping.head_speed_m_s = info.speed_m_s.into();
        ping.sectors.clear();
        ping.beams.clear();
        solution.time_s = ping.time_s;
        (solution.number, solution.head) = (ping.number, ping.head);
        solution.heading_rad = radians(info.heading_deg.into());
        solution.array_depth_m = info.depth_m.into();
        solution.water_line_m = -f64::from(info.water_line_m);
        solution.origin = Origin::ReferencePoint;
        solution.points.clear();
    }

    fn motion(&mut self, body: &Bytes, losses: &mut Losses) -> Option<()> {
        let (bytes, system, status) = (body.u16(0)?, body.u8(2)?, body.u8(3)?);
        let (count, sample_bytes) = (body.u16(6)?, body.u16(8)?);
        let samples = body.parts(bytes.into(), count.into(), sample_bytes.into())?;
        for sample in samples {
            let raw = Motion::read(&sample)?;
            let passive = status & 1 == 0;
            self.motion_sample(&raw, system, passive, losses);
        }
        Some(())
    }

    fn motion_sample(&mut self, raw: &Motion, sensor: u8, passive: bool, losses: &mut Losses) {
        let time_s = time_s(raw.seconds, raw.nanoseconds);
        let [roll, pitch, heading] = raw.roll_pitch_heading_deg.map(f64::from);
        let invalid = |bit: u32| raw.status >> bit & 1 == 1;
        let possible = roll.abs() <= 180.0 && pitch.abs() <= 90.0;
        if possible && !invalid(1) {
            let headed = heading.abs() <= 360.0 && !invalid(2);
            let heave = f64::from(raw.heave_m);
            self.sink.attitude(&Attitude {
                time_s,
                roll_rad: radians(roll),
                pitch_rad: radians(pitch),
                heading_rad: headed.then(|| radians(heading)),
                heave_m: (heave.abs() < 100.0 && !invalid(3)).then_some(-heave),
                sensor,
                passive,
            });
        } else {
            losses.impossible += 1;
        }
        if !invalid(0) {
            let place = (raw.latitude_deg, raw.longitude_deg, raw.height_m);
            if let Some(position) = position(time_s, place, sensor, passive) {
                self.sink.position(&position);
            }
        }
    }

    fn position(&mut self, body: &Bytes, losses: &mut Losses) -> Option<()> {
        let (bytes, system, status) = (usize::from(body.u16(0)?), body.u16(2)?, body.u16(4)?);
        let rest = body.data.len().checked_sub(bytes)?;
        let raw = RawPosition::read(&body.part(bytes, rest)?)?;
        let time_s = time_s(raw.seconds, raw.nanoseconds);
        let place = (raw.latitude_deg, raw.longitude_deg, raw.height_m);
        match position(time_s, place, system as u8, status & 1 == 0) {
            Some(found) => self.sink.position(&Position {
                at_reference: true,
                ..found
            }),
            None => losses.impossible += 1,
        }
        Some(())
    }

    fn profile(&mut self, header: &Header, body: &Bytes, losses: &mut Losses) -> Option<()> {
        let (bytes, count) = (body.u16(0)?, body.u16(2)?);
        let entries = body.parts(bytes.into(), count.into(), 20)?;
        let taken = body.u32(8)?;
        self.profile.time_s = f64::from(if taken > 0 { taken } else { header.seconds });
        self.profile.depth_m.clear();
        self.profile.speed_m_s.clear();
        for entry in entries {
            let (depth_m, speed_m_s) = (entry.real(0)?, entry.real(4)?);
            let below = self.profile.depth_m.last().is_none_or(|d| depth_m > *d);
            if below && depth_m >= 0.0 && (1000.0..2000.0).contains(&speed_m_s) {
                self.profile.depth_m.push(depth_m);
                self.profile.speed_m_s.push(speed_m_s);
            } else {
                losses.impossible += 1;
            }
        }
        self.sink.profile(&self.profile);
        Some(())
    }

    /// The summary of the whole file.
    pub fn finished(mut self, mut losses: Losses) -> Summary {
        self.parts.drop_begun(&mut losses);
        self.summary.device = format!(
            "Kongsberg {}",
            crate::formats::kongsberg_all::model_name(self.sounder)
        );
        self.summary.losses = losses;
        if !self.summary.records.contains_key("MRZ") {
            let reason = "no soundings with angles and times (MRZ) in the file";
            self.summary.refusal = Some(reason.to_owned());
        }
        self.summary
    }
}

fn position(
    time_s: f64,
    (latitude_deg, longitude_deg, height_m): (f64, f64, f32),
    sensor: u8,
    passive: bool,
) -> Option<Position> {
    if !(latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0) {
        return None;
    }
    let height_m = f64::from(height_m);
    Some(Position {
        time_s,
        latitude_rad: radians(latitude_deg),
        longitude_rad: radians(longitude_deg),
        height_m: (height_m.abs() < 2e4 && height_m != -999.0).then_some(height_m),
        sensor,
        passive,
        at_reference: false,
    })
}

fn sector_of(raw: &RawSector) -> Sector {
    Sector {
        tilt_rad: radians(raw.tilt_deg.into()),
        delay_s: raw.delay_s.into(),
        frequency_hz: raw.frequency_hz.into(),
        array: raw.array,
    }
}

/// A beam; its angle turned from port to starboard. Extra and rejected detections are not valid, nor is one without a possible time.
fn beam_of(number: u32, raw: &RawSounding, sector: u16) -> BeamSample {
    let timed = raw.two_way_s > 0.0 && raw.two_way_s < 60.0 && raw.angle_deg.abs() <= 180.0;
    BeamSample {
        number,
        sector,
        valid: raw.kind == 0 && timed && sector != u16::MAX,
        angle_rad: -radians(raw.angle_deg.into()),
        two_way_s: raw.two_way_s.into(),
    }
}

fn own_point(raw: &RawSounding, valid: bool) -> OwnPoint {
    let [forward, starboard, down] = raw.forward_starboard_down_m.map(f64::from);
    let right_forward_up_m = Vector3::new(starboard, forward, -down);
    OwnPoint {
        right_forward_up_m,
        valid: valid && right_forward_up_m.iter().all(|v| v.is_finite()),
    }
}
