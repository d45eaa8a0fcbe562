//! What a recorder's file holds, and what a calibration would still need: for `boresight info`.

use std::path::Path;

use serde_json::{Value, json};

use crate::formats::error::FormatError;
use crate::formats::recorder::{
    Attitude, Heading, Installation, Mounted, Ping, Position, Profile, Role, Sink, Solution,
    Summary, TimeScale, WaterHeight, table, utc,
};
use crate::units::degrees;

/// Width of the text, columns.
const WIDTH: usize = 80;

/// One stream: how many records, from when to when.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stream {
    /// Records.
    pub records: u64,
    /// Time of the earliest, seconds.
    pub first_s: f64,
    /// Time of the latest, seconds.
    pub last_s: f64,
}

impl Stream {
    fn add(&mut self, time_s: f64) {
        if self.records == 0 {
            (self.first_s, self.last_s) = (time_s, time_s);
        }
        self.records += 1;
        self.first_s = self.first_s.min(time_s);
        self.last_s = self.last_s.max(time_s);
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.first_s <= other.last_s && other.first_s <= self.last_s
    }
}

/// What a file holds. Memory does not grow with the file.
#[derive(Clone, Debug, Default)]
pub struct Overview {
    /// The reader's summary.
    pub summary: Summary,
    /// Attitude.
    pub attitude: Stream,
    /// Attitude records with a heading, and headings that came alone.
    pub headings: Stream,
    /// Positions.
    pub positions: Stream,
    /// Positions with a height above the ellipsoid.
    pub heights: Stream,
    /// Heights of the water level.
    pub water_heights: Stream,
    /// Sound-speed profiles.
    pub profiles: Stream,
    /// Pings.
    pub pings: Stream,
    /// The sounder's own solutions.
    pub solutions: Stream,
    /// Beams, and the valid ones of them.
    pub beams: (u64, u64),
    /// Most sectors of a ping.
    pub sectors: usize,
    /// Sound speed at the head, smallest and largest, metres per second.
    pub head_speed_m_s: Option<(f64, f64)>,
    /// The last installation record, and how many there were.
    pub installation: Option<Installation>,
    /// Installation records.
    pub installations: u64,
}

impl Sink for Overview {
    fn installation(&mut self, record: &Installation) {
        self.installations += 1;
        self.installation = Some(record.clone());
    }
    fn attitude(&mut self, record: &Attitude) {
        self.attitude.add(record.time_s);
        if record.heading_rad.is_some() {
            self.headings.add(record.time_s);
        }
    }
    fn heading(&mut self, record: &Heading) {
        self.headings.add(record.time_s);
    }
    fn position(&mut self, record: &Position) {
        self.positions.add(record.time_s);
        if record.height_m.is_some() {
            self.heights.add(record.time_s);
        }
    }
    fn water_height(&mut self, record: &WaterHeight) {
        self.water_heights.add(record.time_s);
    }
    fn profile(&mut self, record: &Profile) {
        self.profiles.add(record.time_s);
    }
    fn ping(&mut self, record: &Ping) {
        self.pings.add(record.time_s);
        let valid = record.beams.iter().filter(|b| b.valid).count();
        self.beams.0 += record.beams.len() as u64;
        self.beams.1 += valid as u64;
        self.sectors = self.sectors.max(record.sectors.len());
        let speed = record.head_speed_m_s;
        let (low, high) = self.head_speed_m_s.unwrap_or((speed, speed));
        self.head_speed_m_s = Some((low.min(speed), high.max(speed)));
    }
    fn solution(&mut self, record: &Solution) {
        self.solutions.add(record.time_s);
    }
}

/// Something that a calibration needs and the file does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// What is missing.
    pub what: &'static str,
    /// What would supply it.
    pub supplied_by: &'static str,
}

/// Reads a file and looks at what it holds.
///
/// # Errors
/// [`FormatError`] when it cannot be read or no reader knows it.
pub fn overview(path: &Path) -> Result<Overview, FormatError> {
    let mut overview = Overview::default();
    let summary = table::read(path, &mut overview)?;
    overview.summary = summary;
    Ok(overview)
}

impl Overview {
    /// The streams by name.
    #[must_use]
    pub fn streams(&self) -> [(&'static str, Stream); 8] {
        [
            ("pings", self.pings),
            ("own solutions", self.solutions),
            ("attitude", self.attitude),
            ("heading", self.headings),
            ("position", self.positions),
            ("height above the ellipsoid", self.heights),
            ("height of the water level", self.water_heights),
            ("sound-speed profiles", self.profiles),
        ]
    }

    /// What a calibration would need besides, and what supplies it.
    #[must_use]
    pub fn missing(&self) -> Vec<Missing> {
        let need =
            |absent: bool, what, supplied_by| absent.then_some(Missing { what, supplied_by });
        let none = |stream: &Stream| stream.records == 0;
        let soundings = !none(&self.pings);
        let ours = |stream: &Stream| soundings && !none(stream) && !stream.overlaps(&self.pings);
        [
            need(!soundings, "soundings", "the sounder's own file"),
            need(
                none(&self.attitude),
                "attitude",
                "an SBET, a NovAtel log or POS MV groups of the same time",
            ),
            need(
                none(&self.headings),
                "heading",
                "an SBET, a NovAtel log or POS MV groups of the same time",
            ),
            need(
                none(&self.positions),
                "positions",
                "an SBET, a NovAtel log or POS MV groups of the same time",
            ),
            need(
                !none(&self.positions) && none(&self.heights),
                "heights above the ellipsoid",
                "an SBET (post-processed), or a GGA telegram that states the undulation",
            ),
            need(
                soundings && none(&self.profiles),
                "a sound-speed profile",
                "a CSV with depth_m, sound_speed_m_s as [sound_speed] profile",
            ),
            need(
                soundings && self.installation.is_none(),
                "nominal arms and angles",
                "lever_arm_m and mounting_deg under [multibeam]",
            ),
            need(
                ours(&self.attitude),
                "attitude at the time of the pings",
                "files of one recording; the two do not overlap",
            ),
            need(
                ours(&self.positions),
                "positions at the time of the pings",
                "files of one recording; the two do not overlap",
            ),
            need(
                self.summary.time == TimeScale::SecondsOfWeek,
                "the week, and whether the times are GPS or UTC",
                "week and time under [trajectory]",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// As text of at most 80 columns, ending with a newline.
    #[must_use]
    pub fn text(&self, path: &Path) -> String {
        let s = &self.summary;
        let mut text = Text::default();
        text.line(&path.display().to_string());
        text.pair("format", s.format);
        if !s.device.is_empty() {
            text.pair("device", &s.device);
        }
        if !s.heads.is_empty() {
            let heads: Vec<String> = s.heads.iter().map(u32::to_string).collect();
            text.pair("heads", &heads.join(", "));
        }
        text.pair("time", s.time.words());
        self.streams_text(&mut text);
        text.pair("records", &self.record_counts());
        self.installation_text(&mut text);
        text.list("already applied by the recorder", &s.applied);
        let lost = s.losses.lines().into_iter();
        let lost: Vec<String> = lost.map(|(what, n)| format!("{n} {what}")).collect();
        text.list("lost or odd", &lost);
        text.list("notes", &s.notes);
        if let Some(refusal) = &s.refusal {
            text.list(
                "no calibration from this file alone",
                std::slice::from_ref(refusal),
            );
        }
        let missing = self.missing().into_iter();
        let missing: Vec<String> = missing
            .map(|m| format!("{}: {}", m.what, m.supplied_by))
            .collect();
        text.list("missing for a calibration, and what supplies it", &missing);
        text.0
    }

    fn streams_text(&self, text: &mut Text) {
        for (name, stream) in self.streams() {
            if stream.records == 0 {
                continue;
            }
            let span = format!("{} to {}", self.at(stream.first_s), self.at(stream.last_s));
            text.pair(name, &format!("{} records", stream.records));
            text.pair("", &span);
        }
        if self.beams.0 > 0 {
            let (all, valid) = self.beams;
            text.pair("beams", &format!("{all}, {valid} of them valid"));
            text.pair("sectors", &format!("up to {} a ping", self.sectors));
        }
        if let Some((low, high)) = self.head_speed_m_s {
            text.pair(
                "sound speed at the head",
                &format!("{low:.1} to {high:.1} m/s"),
            );
        }
    }

    /// A time in words of the file's scale.
    fn at(&self, time_s: f64) -> String {
        match self.summary.time {
            TimeScale::SecondsOfWeek => format!("{time_s:.3} s"),
            TimeScale::Utc | TimeScale::Gps => utc::written(time_s),
        }
    }

    fn record_counts(&self) -> String {
        let counts = self.summary.records.iter();
        let counts: Vec<String> = counts.map(|(kind, n)| format!("{kind} {n}")).collect();
        counts.join(", ")
    }

    fn installation_text(&self, text: &mut Text) {
        let Some(record) = &self.installation else {
            return;
        };
        let parts: Vec<String> = mounted(record)
            .map(|(what, m)| mounting_words(what, m))
            .collect();
        text.list(
            "installation (right, forward, up; roll, pitch, heading)",
            &parts,
        );
        if let Some(height_m) = record.water_line_m {
            text.pair(
                "water line",
                &format!("{height_m:.3} m above the reference point"),
            );
        }
        let turned = if record.attitude_is_turned {
            "the sensor's mounting is already in it"
        } else {
            "the sensor's own; its mounting is still to be applied"
        };
        text.pair("recorded attitude", turned);
    }

    /// As JSON, units in the names.
    #[must_use]
    pub fn json(&self, path: &Path) -> Value {
        let s = &self.summary;
        let streams = self.streams().into_iter().filter(|(_, s)| s.records > 0);
        let streams = streams.map(|(name, s)| {
            json!({ "name": name, "records": s.records, "time_s": [s.first_s, s.last_s] })
        });
        let lost = s.losses.lines().into_iter();
        let lost = lost.map(|(what, n)| json!({ "what": what, "count": n }));
        let missing = self.missing().into_iter();
        let missing = missing.map(|m| json!({ "what": m.what, "supplied_by": m.supplied_by }));
        json!({
            "file": path.display().to_string(),
            "format": s.format,
            "device": s.device,
            "heads": s.heads,
            "time_scale": s.time.words(),
            "streams": streams.collect::<Vec<_>>(),
            "records": s.records,
            "beams": self.beams.0,
            "valid_beams": self.beams.1,
            "sectors": self.sectors,
            "head_sound_speed_m_s": self.head_speed_m_s.map(|(low, high)| [low, high]),
            "installation": self.installation.as_ref().map(installation_json),
            "already_applied": s.applied,
            "lost": lost.collect::<Vec<_>>(),
            "notes": s.notes,
            "refusal": s.refusal,
            "missing": missing.collect::<Vec<_>>(),
        })
    }
}

/// Arrays and sensors of an installation record with what they are.
fn mounted(record: &Installation) -> impl Iterator<Item = (&'static str, &Mounted)> {
    let role = |role| match role {
        Role::Transmit => "transmits",
        Role::Receive => "receives",
        Role::Both => "head",
    };
    let arrays = record
        .arrays
        .iter()
        .map(move |a| (role(a.role), &a.mounted));
    let motion = record.motion_sensors.iter().map(|m| ("motion", m));
    let antennas = record.position_sensors.iter().map(|m| ("position", m));
    arrays.chain(motion).chain(antennas)
}

fn mounting_words(what: &str, m: &Mounted) -> String {
    let arm = m.mounting.lever_arm_m;
    let (roll, pitch, heading) = m.mounting.angles();
    let [roll, pitch, heading] = [roll, pitch, heading].map(|a| plain(degrees(a), 2));
    let [x, y, z] = [arm.x, arm.y, arm.z].map(|v| plain(v, 3));
    let used = if m.active { "" } else { " (not in use)" };
    format!(
        "{} {what}{used}: {x}, {y}, {z} m; {roll}, {pitch}, {heading} deg",
        m.name
    )
}

/// A number with so many decimals, never a negative zero.
fn plain(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text
        .trim_start_matches('-')
        .chars()
        .all(|c| c == '0' || c == '.');
    if zero {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

fn installation_json(record: &Installation) -> Value {
    let parts = mounted(record).map(|(what, m)| {
        let arm = m.mounting.lever_arm_m;
        let (roll, pitch, heading) = m.mounting.angles();
        json!({
            "name": m.name,
            "what": what,
            "in_use": m.active,
            "lever_arm_m": [arm.x, arm.y, arm.z],
            "mounting_deg": { "roll": degrees(roll), "pitch": degrees(pitch), "heading": degrees(heading) },
            "delay_s": m.delay_s,
        })
    });
    json!({
        "mountings": parts.collect::<Vec<_>>(),
        "water_line_m": record.water_line_m,
        "attitude_is_turned": record.attitude_is_turned,
        "fields": record.fields.iter().map(|(k, v)| json!([k, v])).collect::<Vec<_>>(),
    })
}

/// Text that is wrapped as it grows.
#[derive(Default)]
struct Text(String);

impl Text {
    fn line(&mut self, words: &str) {
        self.0.push_str(words);
        self.0.push('\n');
    }

    /// A name in 28 columns and a value.
    fn pair(&mut self, name: &str, value: &str) {
        self.wrapped(&format!("  {name:<28}"), value);
    }

    fn list(&mut self, title: &str, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.line(&format!("  {title}:"));
        for item in items {
            self.wrapped("    - ", item);
        }
    }

    /// Words behind a beginning, further lines indented as far.
    fn wrapped(&mut self, begin: &str, words: &str) {
        let indent = begin.chars().count();
        let mut column = indent;
        self.0.push_str(begin);
        for (k, word) in words.split_whitespace().enumerate() {
            let length = word.chars().count();
            if k > 0 && column + 1 + length > WIDTH {
                self.0.push('\n');
                self.0.push_str(&" ".repeat(indent));
                column = indent;
            } else if k > 0 {
                self.0.push(' ');
                column += 1;
            }
            self.0.push_str(word);
            column += length;
        }
        self.0.truncate(self.0.trim_end_matches(' ').len());
        self.0.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::kongsberg_all::write::Writer;

    fn file() -> Overview {
        let mut writer = Writer::new(vec![], 2045, 102);
        let text =
            "S1X=1,S1Y=2,S1Z=3,S1R=0,S1P=0,S1H=359.5,P1X=0,P1Y=0,P1Z=0,MSX=0,MSY=0,MSZ=0,WLZ=-0.5,";
        writer.installation(1.4e9, text, 0).expect("written");
        let position = Position {
            time_s: 1.4e9,
            sensor: 1,
            ..Position::default()
        };
        writer.position(&position, 0.0).expect("written");
        let ping = Ping {
            time_s: 1.4e9 + 100.0,
            head_speed_m_s: 1500.0,
            ..Ping::default()
        };
        writer.ping(&ping).expect("written");
        let bytes = writer.into_inner();
        let mut overview = Overview::default();
        let read = crate::formats::kongsberg_all::read_from;
        let summary = read(Path::new("a.all"), bytes.as_slice(), &mut overview);
        overview.summary = summary.expect("readable");
        overview
    }

    #[test]
    fn the_text_keeps_to_80_columns_and_names_what_is_missing() {
        let text = file().text(Path::new("a.all"));
        assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
        for words in [
            "EM 2040C",
            "S1 head: 2.000, 1.000, -3.000 m; 0.00, 0.00, -0.50 deg",
            "0.500 m above the reference point",
            "already in it",
            "attitude: an SBET",
            "heights above the ellipsoid: an SBET",
            "a sound-speed profile: a CSV",
            "positions at the time of the pings",
        ] {
            assert!(text.contains(words), "{words} in\n{text}");
        }
    }

    #[test]
    fn the_json_has_the_same() {
        let value = file().json(Path::new("a.all"));
        assert_eq!(value["format"], "kongsberg-all");
        assert_eq!(value["installation"]["mountings"][0]["lever_arm_m"][1], 1.0);
        assert_eq!(value["streams"][0]["records"], 1);
        assert!(value["missing"].as_array().expect("a list").len() >= 4);
    }
}
