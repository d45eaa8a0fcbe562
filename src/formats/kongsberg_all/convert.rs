//! From datagrams to records in our frame and units.

use nalgebra::Vector3;

use super::installation::{Heads, installation};
use super::raw::{
    AttitudeSample, HEADER, Header, OwnBeam, OwnHead, Position as RawPosition, ProfileHead,
    RawBeam, RawHead, RawSector, TRAILER,
};
use crate::formats::recorder::{
    Attitude, BeamSample, Bytes, Installation, Losses, OwnPoint, Ping, Position, Profile, Sector,
    Sink, Solution, Summary, WaterHeight, utc,
};
use crate::units::radians;

/// Turns datagrams into records, one after the other.
pub struct Reader<'s> {
    sink: &'s mut dyn Sink,
    summary: Summary,
    model: u16,
    position_time_from_telegram: [bool; 4],
    ping: Ping,
    solution: Solution,
    profile: Profile,
    raw: u64,
    old: [bool; 3],
}

/// Hundredths of a degree in radians.
fn hundredths(angle: impl Into<f64>) -> f64 {
    radians(0.01 * angle.into())
}

impl<'s> Reader<'s> {
    /// Nothing read yet.
    pub fn new(sink: &'s mut dyn Sink) -> Self {
        Self {
            sink,
            summary: Summary::of("kongsberg-all"),
            model: 0,
            position_time_from_telegram: [false; 4],
            ping: Ping::default(),
            solution: Solution::default(),
            profile: Profile::default(),
            raw: 0,
            old: [false; 3],
        }
    }

    /// Takes one datagram.
    pub fn take(&mut self, record: &Bytes, losses: &mut Losses) {
        let Some(header) = Header::read(record) else {
            losses.malformed += 1;
            return;
        };
        self.summary.count(kind_name(header.kind));
        self.model = header.model;
        if record.big_endian {
            self.summary.note("the file is big-endian");
        }
        if self.known(&header, record, losses).is_none() {
            losses.malformed += 1;
        }
    }

    /// Reads the body of a kind that is used; `None` when its content does not fit its length or its time is no time.
    fn known(&mut self, header: &Header, record: &Bytes, losses: &mut Losses) -> Option<()> {
        let body = record.part(HEADER, record.data.len() - HEADER - TRAILER)?;
        let day_s = 1e-3 * f64::from(header.day_ms);
        let time = || utc::from_digits(header.date, day_s);
        match header.kind {
            b'I' | b'i' => self.installation(header, &body, time()?),
            b'A' => self.attitude(&body, time()?, losses),
            b'P' => self.position(&body, time()?, losses),
            b'h' => self.water_height(&body, time()?),
            b'U' => self.profile(&body, losses),
            b'N' => self.ping(header, &body, time()?, losses),
            b'X' => self.solution(header, &body, time()?),
            kind => {
                self.note_old(kind);
                Some(())
            }
        }
    }

    fn note_old(&mut self, kind: u8) {
        if let Some(at) = b"DFf".iter().position(|k| *k == kind) {
            self.old[at] = true;
        }
    }

    fn installation(&mut self, header: &Header, body: &Bytes, time_s: f64) -> Option<()> {
        let heads = Heads {
            first: header.serial.into(),
            second: body.u16(0)?.into(),
        };
        let text = body.text(2, body.data.len() - 2)?;
        let record = installation(time_s, &text, header.model, heads);
        self.note_sources(&record);
        self.sink.installation(&record);
        Some(())
    }

    fn note_sources(&mut self, record: &Installation) {
        let telegram = |n: usize| {
            let key = format!("P{n}T");
            record.fields.iter().any(|(k, v)| *k == key && v == "1")
        };
        for n in 1..4 {
            self.position_time_from_telegram[n] = telegram(n);
        }
        self.summary.applied(
            "the motion sensor's mounting angles (MSR, MSP, MSG) are in the recorded attitude",
        );
    }

    fn attitude(&mut self, body: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        let count = usize::from(body.u16(0)?);
        let samples = body.parts(2, count, AttitudeSample::BYTES)?;
        let descriptor = body.u8(2 + count * AttitudeSample::BYTES)?;
        for sample in samples {
            let raw = AttitudeSample::read(&sample)?;
            let attitude = attitude(&raw, time_s, descriptor);
            if possible(&attitude) {
                self.sink.attitude(&attitude);
            } else {
                losses.impossible += 1;
            }
        }
        Some(())
    }

    fn position(&mut self, body: &Bytes, time_s: f64, losses: &mut Losses) -> Option<()> {
        let raw = RawPosition::read(body)?;
        let sensor = raw.descriptor & 3;
        let telegram = RawPosition::telegram(body).unwrap_or_default();
        let own_time = self.position_time_from_telegram[usize::from(sensor)];
        let time_of_day = gga_field(telegram, 1).filter(|_| own_time);
        let latitude_deg = f64::from(raw.latitude) / 2e7;
        let longitude_deg = f64::from(raw.longitude) / 1e7;
        if !(latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0) {
            losses.impossible += 1;
            return Some(());
        }
        self.sink.position(&Position {
            time_s: time_of_day.map_or(time_s, |clock| on_day(time_s, clock)),
            latitude_rad: radians(latitude_deg),
            longitude_rad: radians(longitude_deg),
            height_m: gga_height_m(telegram),
            sensor,
            passive: raw.descriptor & 0x80 == 0,
            at_reference: false,
        });
        Some(())
    }

    fn water_height(&mut self, body: &Bytes, time_s: f64) -> Option<()> {
        let height_m = 0.01 * f64::from(body.i32(0)?);
        self.sink.water_height(&WaterHeight { time_s, height_m });
        Some(())
    }

    fn profile(&mut self, body: &Bytes, losses: &mut Losses) -> Option<()> {
        let head = ProfileHead::read(body)?;
        let entries = body.parts(ProfileHead::BYTES, head.entries.into(), 8)?;
        self.profile.time_s = utc::from_digits(head.date, f64::from(head.day_s))?;
        self.profile.depth_m.clear();
        self.profile.speed_m_s.clear();
        for entry in entries {
            let depth_m = 0.01 * f64::from(head.unit_cm) * f64::from(entry.u32(0)?);
            let speed_m_s = 0.1 * f64::from(entry.u32(4)?);
            let below = self.profile.depth_m.last().is_none_or(|d| depth_m > *d);
            if below && (1000.0..2000.0).contains(&speed_m_s) {
                self.profile.depth_m.push(depth_m);
                self.profile.speed_m_s.push(speed_m_s);
            } else {
                losses.impossible += 1;
            }
        }
        self.sink.profile(&self.profile);
        Some(())
    }

    fn ping(
        &mut self,
        header: &Header,
        body: &Bytes,
        time_s: f64,
        losses: &mut Losses,
    ) -> Option<()> {
        let head = RawHead::read(body)?;
        let sectors = body.parts(RawHead::BYTES, head.sectors.into(), RawSector::BYTES)?;
        let behind = RawHead::BYTES + usize::from(head.sectors) * RawSector::BYTES;
        let beams = body.parts(behind, head.beams.into(), RawBeam::BYTES)?;
        let ping = &mut self.ping;
        ping.time_s = time_s;
        ping.number = header.counter.into();
        ping.head = header.serial.into();
        ping.head_speed_m_s = 0.1 * f64::from(head.speed);
        ping.sectors.clear();
        let mut index = [u16::MAX; 256];
        for (k, sector) in sectors.enumerate() {
            let raw = RawSector::read(&sector)?;
            index[usize::from(raw.number)] = k as u16;
            ping.sectors.push(sector_of(&raw));
        }
        ping.beams.clear();
        for (k, beam) in beams.enumerate() {
            let raw = RawBeam::read(&beam)?;
            let sample = beam_of(k as u32, &raw, index[usize::from(raw.sector)]);
            losses.impossible += u64::from(!sample.valid && raw.detection & 0x80 == 0);
            ping.beams.push(sample);
        }
        self.raw += 1;
        self.summary.head(header.serial.into());
        self.sink.ping(&self.ping);
        Some(())
    }

    fn solution(&mut self, header: &Header, body: &Bytes, time_s: f64) -> Option<()> {
        let head = OwnHead::read(body)?;
        let beams = body.parts(OwnHead::BYTES, head.beams.into(), OwnBeam::BYTES)?;
        let solution = &mut self.solution;
        solution.time_s = time_s;
        solution.number = header.counter.into();
        solution.head = header.serial.into();
        solution.heading_rad = hundredths(head.heading);
        solution.array_depth_m = head.depth_m.into();
        solution.points.clear();
        for beam in beams {
            solution.points.push(own_point(&OwnBeam::read(&beam)?));
        }
        self.sink.solution(&self.solution);
        Some(())
    }

    /// The summary of the whole file.
    pub fn finished(mut self, losses: Losses) -> Summary {
        // of a file without one good datagram the model is not known
        if self.model != 0 {
            self.summary.device = format!("Kongsberg {}", model_name(self.model));
        }
        self.summary.losses = losses;
        if self.raw == 0 {
            self.summary.refusal = self.refusal();
        }
        self.summary
    }

    /// Why there is no raw range and angle (N).
    fn refusal(&self) -> Option<String> {
        let model = model_name(self.model);
        let kinds = ["D", "F", "f"].into_iter().zip(self.old);
        let seen: Vec<&str> = kinds.filter(|k| k.1).map(|k| k.0).collect();
        Some(match seen.as_slice() {
            [] => "no raw range and angle datagrams (N) in the file".to_owned(),
            ["D"] => format!(
                "the {model} wrote corrected depths only (D): they hold no angle and no travel time of a beam"
            ),
            kinds => format!(
                "the {model} wrote the raw ranges of before 2009 ({}), whose layout is not read: no sector tilt and no installation key of the present form goes with it",
                kinds.join(", ")
            ),
        })
    }
}

/// An attitude is possible when it is a boat's: the fields of two bytes hold more.
fn possible(attitude: &Attitude) -> bool {
    let right_angle = std::f64::consts::FRAC_PI_2;
    let full_turn = std::f64::consts::TAU;
    attitude.roll_rad.abs() <= std::f64::consts::PI
        && attitude.pitch_rad.abs() <= right_angle
        && attitude.heading_rad.is_none_or(|h| h <= full_turn)
}

fn attitude(raw: &AttitudeSample, time_s: f64, descriptor: u8) -> Attitude {
    Attitude {
        time_s: time_s + 1e-3 * f64::from(raw.after_ms),
        roll_rad: hundredths(raw.roll),
        pitch_rad: hundredths(raw.pitch),
        heading_rad: Some(hundredths(raw.heading)),
        heave_m: Some(-0.01 * f64::from(raw.heave_cm)),
        sensor: descriptor >> 4 & 3,
        passive: descriptor & 0b110 != 0,
    }
}

fn sector_of(raw: &RawSector) -> Sector {
    Sector {
        tilt_rad: hundredths(raw.tilt),
        delay_s: raw.delay_s.into(),
        frequency_hz: raw.frequency_hz.into(),
        array: 0,
    }
}

/// A beam; its angle turned from port to starboard. Without a sector or a time of up to 60 s it is not valid.
fn beam_of(number: u32, raw: &RawBeam, sector: u16) -> BeamSample {
    let timed = raw.two_way_s > 0.0 && raw.two_way_s < 60.0;
    BeamSample {
        number,
        sector,
        valid: raw.detection & 0x80 == 0 && timed && sector != u16::MAX,
        angle_rad: -hundredths(raw.angle),
        two_way_s: raw.two_way_s.into(),
    }
}

fn own_point(raw: &OwnBeam) -> OwnPoint {
    let [down, starboard, forward] = raw.down_starboard_forward_m.map(f64::from);
    let right_forward_up_m = Vector3::new(starboard, forward, -down);
    let finite = right_forward_up_m.iter().all(|v| v.is_finite());
    OwnPoint {
        right_forward_up_m,
        valid: raw.detection & 0x80 == 0 && finite,
    }
}

/// A kind's letter as text.
fn kind_name(kind: u8) -> &'static str {
    let at = super::KINDS.iter().position(|k| *k == kind);
    const NAMES: &str = "01234ACDEFGHIJKLNOPQRSTUVWXYZefhijklmnpruv";
    at.and_then(|k| NAMES.get(k..=k)).unwrap_or("?")
}

/// A model as its maker names it.
#[must_use]
pub fn model_name(model: u16) -> String {
    match model {
        2045 => "EM 2040C".to_owned(),
        3020 => "EM 3002".to_owned(),
        n => format!("EM {n}"),
    }
}

/// A number of a GGA telegram; field 1 is the time of day.
fn gga_field(telegram: &[u8], field: usize) -> Option<f64> {
    let text = std::str::from_utf8(telegram).ok()?;
    let mut fields = text.split(',');
    fields.next().filter(|head| head.ends_with("GGA"))?;
    fields.nth(field - 1)?.trim().parse().ok()
}

/// Height above the ellipsoid: above the geoid plus its undulation, where both are given.
fn gga_height_m(telegram: &[u8]) -> Option<f64> {
    let height_m = gga_field(telegram, 9)? + gga_field(telegram, 11)?;
    (height_m.abs() < 2e4).then_some(height_m)
}

/// The time that a clock of the form hhmmss.sss means near `time_s`.
fn on_day(time_s: f64, clock: f64) -> f64 {
    let (hours, minutes) = ((clock / 1e4).floor(), (clock / 100.0).floor() % 100.0);
    let of_day = 3600.0 * hours + 60.0 * minutes + clock % 100.0;
    let ahead = of_day - time_s.rem_euclid(utc::DAY_S);
    time_s + ahead - utc::DAY_S * (ahead / utc::DAY_S).round()
}
