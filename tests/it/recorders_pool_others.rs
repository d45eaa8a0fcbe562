//! Pool surveys in `.s7k` and in XTF of an R2Sonic: a simulated survey of two arrays, written anew by writers of this file alone.
//!
//! No real pool was recorded in either; the bytes are those that the formats' descriptions have.

use std::path::Path;

use crate::common::{run, simulated, words};
use crate::recorders_pool::{SURVEY, Six, THIN, apart, calibrated_of, changed};

/// Seconds of the survey's midnight: 2024-06-01, day 153 of the year, UTC.
const MIDNIGHT_S: u32 = 1_717_200_000;
const SPEED: f64 = 1480.0;
/// Sampling rate of the sounder, a number that 32 bits hold.
const RATE_HZ: f64 = 34_482.757_812_5;

/// Arrays each mounted on its own, 0.27 m apart (`.s7k` has one record for both), or one mounting (all that XTF has).
fn scenario(apart: bool) -> String {
    let arrays = match apart {
        true => {
            "mounting_deg = { roll = -45.0, pitch = 1.1, heading = 0.3 }\narrays = { receiver_mounting_deg = { roll = -43.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 1 }"
        }
        false => {
            "mounting_deg = { roll = -45.0, pitch = 1.1, heading = 0.3 }\narrays = { sectors = 1 }"
        }
    };
    let text = THIN.replace("mounting_deg = { roll = -45.0 }", arrays);
    text.replace("[truth]", "[sound_speed]\nspeed_m_s = 1480.0\n\n[truth]")
}

/// A CSV by its columns.
struct Columns {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Columns {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a file");
        let mut lines = text.lines();
        let names = lines
            .next()
            .expect("a header")
            .split(',')
            .map(str::to_owned);
        let names = names.collect();
        let number = |field: &str| field.parse().expect("a number");
        let rows = lines.map(|line| line.split(',').map(number).collect());
        Self {
            names,
            rows: rows.collect(),
        }
    }

    fn of(&self, row: &[f64], name: &str) -> f64 {
        let at = self.names.iter().position(|n| n == name);
        row[at.unwrap_or_else(|| panic!("no {name} in {:?}", self.names))]
    }
}

/// A ping of the CSV: when, its number, angles to starboard of the receive array (radians) and two-way times.
struct Ping {
    time_s: f64,
    number: u32,
    beams: Vec<(f64, f64)>,
}

fn pings(survey: &Path) -> Vec<Ping> {
    let all = Columns::read(&survey.join("multibeam.csv"));
    let same = |a: &Vec<f64>, b: &Vec<f64>| all.of(a, "ping") == all.of(b, "ping");
    let ping = |rows: &[Vec<f64>]| Ping {
        time_s: all.of(&rows[0], "time_s"),
        number: all.of(&rows[0], "ping") as u32,
        beams: rows
            .iter()
            .map(|r| {
                (
                    all.of(r, "rx_angle_deg").to_radians(),
                    all.of(r, "two_way_travel_time_s"),
                )
            })
            .collect(),
    };
    all.rows.chunk_by(same).map(ping).collect()
}

/// One record of the trajectory: time, latitude, longitude (degrees), height, roll, pitch, heading (degrees).
fn poses(survey: &Path) -> Vec<[f64; 7]> {
    let all = Columns::read(&survey.join("trajectory.csv"));
    let names = [
        "time_s",
        "latitude_deg",
        "longitude_deg",
        "height_m",
        "roll_deg",
        "pitch_deg",
        "heading_deg",
    ];
    all.rows
        .iter()
        .map(|row| names.map(|name| all.of(row, name)))
        .collect()
}

/// Numbers one after the other.
#[derive(Default)]
struct Out(Vec<u8>);

impl Out {
    fn u8(self, v: u8) -> Self {
        self.raw(&[v])
    }
    fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }
    fn u16(self, v: u32) -> Self {
        self.raw(&(v as u16).to_le_bytes())
    }
    fn u32(self, v: u32) -> Self {
        self.raw(&v.to_le_bytes())
    }
    fn f32(self, v: f64) -> Self {
        self.raw(&(v as f32).to_le_bytes())
    }
    fn f64(self, v: f64) -> Self {
        self.raw(&v.to_le_bytes())
    }
    fn zeros(self, n: usize) -> Self {
        self.raw(&vec![0; n])
    }
    fn be32(self, v: u32) -> Self {
        self.raw(&v.to_be_bytes())
    }
    fn bef(self, v: f64) -> Self {
        self.raw(&(v as f32).to_be_bytes())
    }
}

/// A record of 7k: frame of 64 bytes, data, sum of all bytes.
fn record(kind: u32, time_s: f64, data: &Out) -> Vec<u8> {
    let minutes = (time_s / 60.0).floor();
    let device = if kind < 2000 { 0 } else { 7125 };
    let frame = Out::default()
        .u16(5)
        .u16(60)
        .u32(0xffff)
        .u32(64 + data.0.len() as u32 + 4)
        .u32(0)
        .u32(0)
        .u16(2024)
        .u16(153)
        .f32(time_s - 60.0 * minutes)
        .u8((minutes / 60.0) as u8)
        .u8((minutes % 60.0) as u8)
        .u16(1)
        .u32(kind)
        .u32(device)
        .u16(0)
        .u16(0)
        .u32(0)
        .u16(1)
        .u16(0)
        .zeros(12);
    assert_eq!(frame.0.len(), 64);
    let whole = frame.raw(&data.0);
    let sum = whole.0.iter().map(|b| u32::from(*b)).sum();
    whole.u32(sum).0
}

/// Installation (7030): arrays with arm (right, forward, up) and roll, pitch, heading in degrees.
fn installation(arrays: [([f64; 3], [f64; 3]); 2]) -> Out {
    let mut out = Out::default().f32(4e5);
    for _ in 0..4 {
        out = out.u16(3).raw(b"1.0").zeros(125);
    }
    for (arm, angles) in arrays {
        out = arm.iter().fold(out, |out, v| out.f32(*v));
        out = angles.iter().fold(out, |out, v| out.f32(v.to_radians()));
    }
    out.zeros(24 + 2 + 12 + 2 + 4)
}

fn s7k(survey: &Path) -> Vec<u8> {
    let (pings, poses) = (pings(survey), poses(survey));
    let begin_s = pings[0].time_s - 5.0;
    let mut all = vec![(
        begin_s,
        record(
            7030,
            begin_s,
            &installation([
                ([0.5, -0.2, -1.6], [-45.0, 1.1, 0.3]),
                ([0.6, -0.45, -1.58], [-43.5, -0.4, 0.6]),
            ]),
        ),
    )];
    let cast = Out::default().u8(1).u8(0).u16(0).f64(0.5).f64(2.1).u32(2);
    let cast = cast.f32(0.0).f32(SPEED).f32(100.0).f32(SPEED);
    all.push((begin_s, record(1009, begin_s, &cast)));
    for [t, latitude, longitude, height, roll, pitch, heading] in poses {
        let motion = Out::default()
            .u8(1)
            .u16(0)
            .f32(roll.to_radians())
            .f32(pitch.to_radians());
        let motion = motion.f32(0.0).f32(heading.rem_euclid(360.0).to_radians());
        all.push((t, record(1016, t, &motion)));
        let place = Out::default()
            .u32(0)
            .f32(0.0)
            .f64(latitude.to_radians())
            .f64(longitude.to_radians());
        all.push((t, record(1003, t, &place.f64(height).raw(&[0, 0, 4, 0, 9]))));
    }
    for ping in &pings {
        let settings = Out::default()
            .raw(&1u64.to_le_bytes())
            .u32(ping.number)
            .u16(0);
        let settings = settings
            .f32(4e5)
            .f32(RATE_HZ)
            .zeros(146 - 22)
            .f32(SPEED)
            .zeros(6);
        all.push((ping.time_s, record(7000, ping.time_s, &settings)));
        let head = Out::default()
            .raw(&1u64.to_le_bytes())
            .u32(ping.number)
            .u16(0);
        let head = head.u32(ping.beams.len() as u32).u32(26).u8(1).u32(0);
        let mut found = head.f32(RATE_HZ).f32(0.0).f32(0.0).zeros(60);
        for (k, (angle, two_way_s)) in ping.beams.iter().enumerate() {
            found = found.u16(k as u32).f32(two_way_s * RATE_HZ).f32(*angle);
            found = found.u32(0).u32(3).f32(0.0).f32(0.0);
        }
        all.push((ping.time_s, record(7027, ping.time_s, &found)));
    }
    in_order(all)
}

fn in_order(mut all: Vec<(f64, Vec<u8>)>) -> Vec<u8> {
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().flat_map(|(_, bytes)| bytes).collect()
}

/// A packet of XTF, padded to 64 bytes.
fn packet(kind: u8, channels: u32, body: &Out) -> Vec<u8> {
    let size = (14 + body.0.len()).next_multiple_of(64);
    let head = Out::default()
        .u16(0xface)
        .u8(kind)
        .u8(0)
        .u16(channels)
        .u32(0)
        .u32(size as u32);
    let whole = head.raw(&body.0);
    let short = size - whole.0.len();
    whole.zeros(short).0
}

/// Year, month, day, hour, minute, second.
fn clock(seconds: u32) -> Out {
    let [hour, minute, second] = [seconds / 3600, seconds / 60 % 60, seconds % 60].map(|v| v as u8);
    Out::default().u16(2024).raw(&[6, 1, hour, minute, second])
}

fn section(name: &[u8], body: &Out) -> Vec<u8> {
    let size = (4 + body.0.len()) as u16;
    Out::default()
        .raw(name)
        .raw(&size.to_be_bytes())
        .raw(&body.0)
        .0
}

fn bathymetry(ping: &Ping) -> Vec<u8> {
    let count = ping.beams.len();
    let whole_s = ping.time_s.floor();
    let head = Out::default()
        .raw(b"2026\0\0\0\0\0\0\0\0")
        .raw(b"100001\0\0\0\0\0\0");
    let head = head
        .be32(MIDNIGHT_S + whole_s as u32)
        .be32(((ping.time_s - whole_s) * 1e9) as u32);
    let head = head.be32(ping.number).bef(0.4).bef(SPEED).bef(4e5);
    let short = 110 - head.0.len();
    let head = head.zeros(short).raw(&(count as u16).to_be_bytes());
    let longest_s = ping.beams.iter().map(|b| b.1).fold(0.0, f64::max);
    let scale = f64::from((longest_s / 65_000.0) as f32);
    let ranges = ping
        .beams
        .iter()
        .fold(Out::default().bef(scale), |out, (_, two_way_s)| {
            out.raw(&((two_way_s / scale).round() as u16).to_be_bytes())
        });
    // steps between beams, whose sums are rounded rather than they themselves
    let (first, step) = (f64::from(ping.beams[0].0 as f32), f64::from(2e-5f32));
    let angles = [first, step, 0.0, 0.119, 0.0, 0.0, 0.0, 0.0];
    let mut angles = angles.iter().fold(Out::default(), |out, v| out.bef(*v));
    let mut sum = 0;
    for (angle, _) in &ping.beams {
        let due = ((angle - first) / step).round() as i64;
        angles = angles.raw(&((due - sum) as u16).to_be_bytes());
        sum = due;
    }
    let sections = [
        section(b"H0", &head),
        section(b"R0", &ranges),
        section(b"A2", &angles),
    ]
    .concat();
    let block = Out::default()
        .raw(b"BTH0")
        .be32(12 + sections.len() as u32)
        .be32(1);
    block.raw(&sections).0
}

fn xtf(survey: &Path) -> Vec<u8> {
    let head = Out::default()
        .raw(&[123, 1])
        .raw(b"recipe\0\0")
        .raw(b"1\0\0\0\0\0\0\0")
        .raw(b"R2Sonic\0");
    let short = 164 - head.0.len();
    let head = head.zeros(short).u16(3).u16(0).u16(1);
    let short = 256 - head.0.len();
    let head = head.zeros(short).u8(3).zeros(47);
    let head = [0.5, -0.2, 1.6, 0.3, 1.1, -45.0]
        .iter()
        .fold(head, |out, v| out.f32(*v));
    let short = 1024 - head.0.len();
    let head = head.zeros(short).0;
    let mut all = vec![];
    for [t, latitude, longitude, height, roll, pitch, heading] in poses(survey) {
        let ticks = (t * 1e4).round() as u32;
        let attitude = Out::default()
            .zeros(16)
            .f32(pitch)
            .f32(roll)
            .f32(0.0)
            .f32(0.0);
        let attitude = attitude.u32(ticks / 10).f32(heading.rem_euclid(360.0));
        let attitude = attitude
            .raw(&clock(ticks / 10_000).0)
            .u16(ticks / 10 % 1000)
            .u8(0);
        all.push((t, packet(3, 0, &attitude)));
        let place = clock(ticks / 10_000).u16(ticks % 10_000);
        let place = place.f64(latitude).f64(longitude).f64(height).zeros(17);
        all.push((t, packet(107, 0, &place)));
    }
    for ping in pings(survey) {
        let ahead = clock(ping.time_s as u32).u8(0).u16(153);
        let short = 242 - ahead.0.len();
        let body = ahead.zeros(short).raw(&bathymetry(&ping));
        all.push((ping.time_s, packet(65, 1, &body)));
    }
    [head, in_order(all)].concat()
}

/// The survey with its soundings in a recorder's file; with `own`, the navigation too. XTF has no sound speed, `.s7k` a cast.
fn recorded(folder: &Path, format: &str, own: bool) {
    let survey = folder.join("survey");
    let bytes = if format == "s7k" {
        s7k(&survey)
    } else {
        xtf(&survey)
    };
    std::fs::write(survey.join(format!("pool.{format}")), bytes).expect("written");
    std::fs::remove_file(survey.join("multibeam.csv")).expect("removed");
    let path = folder.join(SURVEY);
    let text = std::fs::read_to_string(&path).expect("a file");
    let mut section = String::new();
    let mut lines = vec![];
    for line in text.lines() {
        if line.starts_with('[') {
            section = line.to_owned();
        }
        let key = line.split(" = ").next().unwrap_or_default();
        let mounted = [
            "lever_arm_m",
            "mounting_deg",
            "receiver_lever_arm_m",
            "receiver_mounting_deg",
        ];
        let dropped = section.starts_with("[multibeam") && mounted.contains(&key)
            || section.starts_with("[multibeam.")
            || format == "s7k" && section == "[sound_speed]"
            || own && section == "[trajectory]" && key == "path";
        if dropped {
            continue;
        }
        lines.push(match (section.as_str(), key) {
            ("[multibeam]", "path") => format!("path = \"pool.{format}\""),
            ("[trajectory]", "path") => format!("{line}\ntime = \"utc-day\""),
            ("[lidar]", "path") if own => format!("{line}\ntime = \"utc-day\""),
            _ => line.to_owned(),
        });
    }
    std::fs::write(path, lines.join("\n") + "\n").expect("written");
}

fn found(apart: bool, recorder: Option<(&str, bool)>) -> Six {
    let name = recorder.map_or("csv", |r| r.0);
    calibrated_of(&scenario(apart), name, |folder| {
        if let Some((format, own)) = recorder {
            recorded(folder, format, own);
        }
    })
}

/// The truth within 4.5 sigmas, and the CSV's result but for what the formats round. `.s7k` keeps angles and times in 32 bits, a ten-thousandth
/// of the sounder's noise; XTF steps of 1e-5 rad and of a quarter of a millimetre at the most, 0.6 and 1 % of it as standard deviations, 4.5
/// of them at the most. With the recorder's navigation attitudes are rounded to 32 bits: headings to 2.4e-7 rad beside 0.005 deg.
#[test]
fn one_pool_survey_as_csv_s7k_and_xtf_has_one_result() {
    for (apart_arrays, format) in [(true, "s7k"), (false, "xtf")] {
        let csv = found(apart_arrays, None);
        let off = apart(&csv.found, &csv.truth, &csv.sigma);
        assert!(off < 4.5, "{off}: {:?} {:?}", csv.found, csv.truth);
        for (own, most) in [(false, 0.06), (true, 0.08)] {
            let other = found(apart_arrays, Some((format, own)));
            let off = apart(&other.found, &csv.found, &csv.sigma);
            assert!(off < most, "{format}, own navigation {own}: {off}");
        }
    }
}

/// What `check` says of a survey, in one line, with its exit code.
fn checked(format: &str, own: bool, change: impl Fn(&Path)) -> (Option<i32>, String) {
    let folder = simulated(&scenario(format == "s7k"));
    recorded(folder.path(), format, own);
    change(folder.path());
    let output = run(&["check", SURVEY], folder.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    let said: Vec<&str> = said.split_whitespace().collect();
    (output.status.code(), said.join(" "))
}

#[test]
fn what_these_files_say_of_a_pool_and_what_they_lack_is_said() {
    let (code, said) = checked("s7k", true, |_| {});
    assert_eq!(code, Some(0), "{said}");
    let due = "installation record, receive array: 0.600 m right, -0.450 m forward, -1.580 m up";
    assert!(said.contains(due), "{said}");
    assert!(said.contains("has not been tried on a real file"), "{said}");
    let (code, said) = checked("xtf", true, |_| {});
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("the file does not say their signs"), "{said}");
    let (code, said) = checked("xtf", true, |folder| {
        changed(folder, "[sound_speed]\nspeed_m_s = 1480.0\n", "");
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("no sound-speed profile") && said.contains("under [sound_speed]"),
        "{said}"
    );
}
