use super::write::Writer;
use super::*;
use crate::formats::recorder::{
    Attitude, BeamSample, Losses, OwnPoint, Ping, Position, Profile, Sector, Solution, WaterHeight,
};
use nalgebra::Vector3;

/// Everything that a file says, kept.
#[derive(Debug, Default, PartialEq)]
struct All {
    attitude: Vec<Attitude>,
    positions: Vec<Position>,
    heights: Vec<WaterHeight>,
    profiles: Vec<Profile>,
    pings: Vec<Ping>,
    solutions: Vec<Solution>,
    arrays: Vec<(String, u32)>,
}

impl Sink for All {
    fn installation(&mut self, record: &crate::formats::recorder::Installation) {
        let name = |a: &crate::formats::recorder::Array| (a.mounted.name.clone(), a.head);
        self.arrays.extend(record.arrays.iter().map(name));
    }
    fn attitude(&mut self, record: &Attitude) {
        self.attitude.push(*record);
    }
    fn position(&mut self, record: &Position) {
        self.positions.push(*record);
    }
    fn water_height(&mut self, record: &WaterHeight) {
        self.heights.push(*record);
    }
    fn profile(&mut self, record: &Profile) {
        self.profiles.push(record.clone());
    }
    fn ping(&mut self, record: &Ping) {
        self.pings.push(record.clone());
    }
    fn solution(&mut self, record: &Solution) {
        self.solutions.push(record.clone());
    }
}

fn read_bytes(bytes: &[u8]) -> (All, Summary) {
    let mut all = All::default();
    let summary = read_from(Path::new("a.all"), bytes, &mut all).expect("readable");
    (all, summary)
}

/// A ping whose numbers the format holds exactly.
fn ping(number: u32) -> Ping {
    let beam = |k: u32| BeamSample {
        number: k,
        sector: (k % 2) as u16,
        valid: k != 3,
        angle_rad: 0.01f64.to_radians() * (1000.0 * f64::from(k) - 3000.0),
        two_way_s: 0.015625,
    };
    let sector = |k: u8| Sector {
        tilt_rad: 0.01f64.to_radians() * (f64::from(k) * 250.0 - 100.0),
        delay_s: 0.001953125 * f64::from(k),
        frequency_hz: 300e3,
        array: 0,
    };
    Ping {
        time_s: 1_392_269_261.25,
        number,
        head: 102,
        head_speed_m_s: 1517.3,
        sectors: vec![sector(0), sector(1)],
        beams: (0..8).map(beam).collect(),
    }
}

fn solution() -> Solution {
    let point = |k: i32| OwnPoint {
        right_forward_up_m: Vector3::new(f64::from(k), 0.25, -10.5),
        valid: k != 3,
    };
    Solution {
        time_s: 1_392_269_261.25,
        number: 7,
        head: 102,
        heading_rad: 207.5f64.to_radians(),
        array_depth_m: 0.75,
        points: (0..8).map(point).collect(),
        ..Solution::default()
    }
}

fn attitude(k: i32) -> Attitude {
    Attitude {
        // the second sample of the day's last moment lies on the next day
        time_s: 1_392_335_999.99 + 0.01 * f64::from(k),
        roll_rad: 0.01f64.to_radians() * f64::from(k - 300),
        pitch_rad: 0.01f64.to_radians() * 55.0,
        heading_rad: Some(0.01f64.to_radians() * 20_750.0),
        heave_m: Some(-0.25),
        ..Attitude::default()
    }
}

const TEXT: &str = "WLZ=-0.600,STC=2,S1X=1.5,S1Y=-0.5,S1Z=0.7,S1H=359.61,S1P=1,S1R=-40,S2X=1.5,S2Y=0.5,S2Z=0.7,S2H=0,S2P=0,S2R=40,P1X=0,P1Y=0,P1Z=-3,P1T=1,MSX=0.1,MSY=0,MSZ=0,MSR=0.2,MSP=-0.5,MSG=1.0,ARO=2,APS=0,";

fn written(big_endian: bool) -> Vec<u8> {
    let mut writer = Writer::new(vec![], 2040, 102);
    if big_endian {
        writer = writer.big_endian();
    }
    let mut all = || {
        writer.installation(1_392_269_256.0, TEXT, 103)?;
        writer.profile(&Profile {
            time_s: 1_392_269_200.0,
            depth_m: vec![0.0, 0.25, 40.0],
            speed_m_s: vec![1518.0, 1517.5, 1510.0],
        })?;
        writer.attitude(&[attitude(0), attitude(1), attitude(2)])?;
        writer.position(
            &Position {
                time_s: 1_392_269_262.352,
                latitude_rad: -0.67,
                longitude_rad: 2.48,
                height_m: Some(12.25),
                sensor: 1,
                ..Position::default()
            },
            3.6,
        )?;
        writer.water_height(&WaterHeight {
            time_s: 1_392_269_262.5,
            height_m: 8.3,
        })?;
        writer.ping(&ping(7))?;
        writer.solution(&solution(), 1517.3)?;
        writer.head(103);
        writer.ping(&Ping {
            head: 103,
            ..ping(7)
        })
    };
    all().expect("written");
    writer.into_inner()
}

#[test]
fn both_byte_orders_return_what_was_written() {
    for big_endian in [false, true] {
        let (all, summary) = read_bytes(&written(big_endian));
        assert_eq!(summary.losses, Losses::default());
        assert_eq!(summary.heads, [102, 103]);
        assert_eq!(summary.device, "Kongsberg EM 2040");
        assert_eq!(summary.refusal, None);
        let near = |a: f64, b: f64, tolerance: f64| assert!((a - b).abs() < tolerance, "{a} {b}");
        let read = &all.pings[0];
        assert_eq!((read.number, read.head, read.beams.len()), (7, 102, 8));
        near(read.time_s, 1_392_269_261.25, 1e-6);
        near(read.head_speed_m_s, 1517.3, 1e-9);
        for (found, meant) in read.beams.iter().zip(&ping(7).beams) {
            assert_eq!((found.sector, found.valid), (meant.sector, meant.valid));
            near(found.angle_rad, meant.angle_rad, 1e-12);
            near(found.two_way_s, meant.two_way_s, 1e-12);
        }
        for (found, meant) in read.sectors.iter().zip(&ping(7).sectors) {
            near(found.tilt_rad, meant.tilt_rad, 1e-12);
            near(found.delay_s, meant.delay_s, 1e-12);
        }
        assert_eq!(all.pings[1].head, 103);
        assert_eq!(all.solutions[0].points, solution().points);
        near(all.positions[0].latitude_rad, -0.67, 1e-9);
        near(all.positions[0].time_s, 1_392_269_262.352, 1e-6);
        assert_eq!(all.positions[0].height_m, Some(12.25));
        near(all.heights[0].height_m, 8.3, 1e-9);
        assert_eq!(all.profiles[0].depth_m, [0.0, 0.25, 40.0]);
        for (k, found) in all.attitude.iter().enumerate() {
            let meant = attitude(k as i32);
            near(found.time_s, meant.time_s, 1e-6);
            near(found.roll_rad, meant.roll_rad, 1e-12);
            near(found.heave_m.expect("heave"), -0.25, 1e-12);
        }
        assert_eq!(all.arrays, [("S1".to_owned(), 102), ("S2".to_owned(), 103)]);
    }
}

/// Layout by hand, without our writer: one beam of one sector, from the specification's table.
#[test]
fn a_ping_written_by_hand() {
    let mut bytes = vec![
        0, 0, 0, 0, 2, b'N', 0xfd, 0x07, // length, STX, kind, model 2045
        0x18, 0x51, 0x33, 0x01, // 20140312
        0xe8, 0x03, 0, 0, 9, 0, 102, 0, // 1000 ms, ping 9, serial 102
        0x4c, 0x3b, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0,
        0, // 1518.0 m/s, one sector, one beam
        0x9c, 0xff, 0, 0, 0, 0, 0, 0, // tilt -1.00 deg
        0, 0, 0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // delay 0.5 s
        0x10, 0x27, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3e, 0, 0, 0,
        0, // 100.00 deg to port, 0.25 s
        0, 3,
    ];
    let sum = bytes[5..bytes.len() - 1]
        .iter()
        .map(|b| u16::from(*b))
        .sum::<u16>();
    bytes.extend(sum.to_le_bytes());
    bytes[0] = bytes.len() as u8 - 4;
    let (all, summary) = read_bytes(&bytes);
    assert_eq!(summary.losses, Losses::default());
    let ping = &all.pings[0];
    assert_eq!((ping.number, ping.head), (9, 102));
    assert_eq!(ping.time_s, utc_of(2014, 3, 12) + 1.0);
    assert!((ping.beams[0].angle_rad.to_degrees() + 100.0).abs() < 1e-12);
    assert_eq!(ping.beams[0].two_way_s, 0.25);
    assert!((ping.sectors[0].tilt_rad.to_degrees() + 1.0).abs() < 1e-12);
    assert_eq!(ping.sectors[0].delay_s, 0.5);
    assert_eq!(ping.head_speed_m_s, 1518.0);
}

fn utc_of(year: u32, month: u32, day: u32) -> f64 {
    crate::formats::recorder::utc::days(year, month, day).expect("a date") as f64 * 86_400.0
}

#[test]
fn the_installation_record_comes_into_our_axes() {
    struct Keep(Option<crate::formats::recorder::Installation>);
    impl Sink for Keep {
        fn installation(&mut self, record: &crate::formats::recorder::Installation) {
            self.0 = Some(record.clone());
        }
    }
    let mut keep = Keep(None);
    read_from(Path::new("a.all"), written(false).as_slice(), &mut keep).expect("readable");
    let record = keep.0.expect("a record");
    let head = &record
        .transmitter(102)
        .expect("the first head")
        .mounted
        .mounting;
    assert_eq!(head.lever_arm_m, Vector3::new(-0.5, 1.5, -0.7));
    let (roll, pitch, heading) = head.angles();
    for (found, meant) in [(roll, -40.0), (pitch, 1.0), (heading, -0.39)] {
        assert!((found.to_degrees() - meant).abs() < 1e-9, "{found} {meant}");
    }
    assert_eq!(record.receiver(103).expect("the second").mounted.name, "S2");
    assert_eq!(record.water_line_m, Some(0.6));
    assert!(record.attitude_is_turned);
    assert_eq!(record.motion_sensor().map(|m| m.name.as_str()), Some("MS"));
}

#[test]
fn damage_costs_what_is_damaged_and_is_counted() {
    let whole = written(false);
    let (clean, _) = read_bytes(&whole);
    // garbage before, one wrong byte in the first datagram's text, the end cut off
    let mut damaged = [&[2u8, b'N', 0xff, 0][..], &whole].concat();
    damaged[60] ^= 0x40;
    damaged.truncate(damaged.len() - 5);
    let (all, summary) = read_bytes(&damaged);
    assert_eq!(all.attitude, clean.attitude);
    assert_eq!(all.pings.len(), 1);
    assert!(all.arrays.is_empty());
    let losses = &summary.losses;
    assert_eq!(losses.skipped_places, 1);
    assert!(losses.truncated_bytes > 100, "{losses:?}");
    assert!(losses.any());
}

#[test]
fn a_zero_checksum_is_used_and_counted() {
    let mut bytes = written(false);
    let end = bytes.len();
    bytes[end - 2..].fill(0);
    let (all, summary) = read_bytes(&bytes);
    assert_eq!(all.pings.len(), 2);
    assert_eq!(summary.losses.zero_checksums, 1);
    assert!(!summary.losses.any());
}

#[test]
fn old_sounders_are_refused_by_name() {
    let mut writer = Writer::new(vec![], 3000, 5).big_endian();
    let body = crate::formats::recorder::Out::new(true);
    writer.datagram(b'D', 9.3e8, 1, &body).expect("written");
    let (_, summary) = read_bytes(&writer.into_inner());
    let refusal = summary.refusal.expect("a refusal");
    assert!(
        refusal.contains("EM 3000") && refusal.contains("corrected depths"),
        "{refusal}"
    );
    let mut writer = Writer::new(vec![], 1002, 5);
    let body = crate::formats::recorder::Out::new(false);
    writer.datagram(b'f', 9.3e8, 1, &body).expect("written");
    let refusal = read_bytes(&writer.into_inner())
        .1
        .refusal
        .expect("a refusal");
    assert!(
        refusal.contains("EM 1002") && refusal.contains("before 2009"),
        "{refusal}"
    );
}

#[test]
fn impossible_beams_are_not_valid_and_counted() {
    let mut bad = ping(1);
    bad.beams[0].two_way_s = 0.0;
    bad.beams[1].two_way_s = f64::NAN;
    bad.beams[2].sector = 9;
    let mut writer = Writer::new(vec![], 2040, 102);
    writer.ping(&bad).expect("written");
    let (all, summary) = read_bytes(&writer.into_inner());
    let valid = all.pings[0].beams.iter().filter(|b| b.valid).count();
    assert_eq!((valid, summary.losses.impossible), (4, 3));
}
