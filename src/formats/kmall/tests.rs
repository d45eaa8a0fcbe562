use nalgebra::Vector3;

use super::write::Writer;
use super::*;
use crate::formats::recorder::{
    Attitude, BeamSample, Installation, OwnPoint, Ping, Position, Profile, Role, Sector, Solution,
};

#[derive(Debug, Default)]
struct All {
    attitude: Vec<Attitude>,
    positions: Vec<Position>,
    profiles: Vec<Profile>,
    pings: Vec<Ping>,
    solutions: Vec<Solution>,
    installations: Vec<Installation>,
}

impl Sink for All {
    fn installation(&mut self, record: &Installation) {
        self.installations.push(record.clone());
    }
    fn attitude(&mut self, record: &Attitude) {
        self.attitude.push(*record);
    }
    fn position(&mut self, record: &Position) {
        self.positions.push(*record);
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
    let summary = read_from(Path::new("a.kmall"), bytes, &mut all).expect("readable");
    (all, summary)
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} {b}");
}

fn ping() -> (Ping, Solution) {
    let beam = |k: u32| BeamSample {
        number: k,
        sector: (k % 3) as u16,
        valid: k != 5,
        angle_rad: (3.5 * f64::from(k) - 60.0f64).to_radians(),
        two_way_s: 0.0123 + 0.001 * f64::from(k),
    };
    let sector = |k: u8| Sector {
        tilt_rad: (2.0 * f64::from(k) - 2.5f64).to_radians(),
        delay_s: 0.0025 * f64::from(k),
        frequency_hz: 300e3,
        array: k,
    };
    let point = |k: u32| OwnPoint {
        right_forward_up_m: Vector3::new(f64::from(k), 0.25, -10.5),
        valid: k != 5,
    };
    let ping = Ping {
        time_s: 1_557_607_590.25,
        number: 9,
        head: 2,
        head_speed_m_s: 1445.0,
        sectors: (0..3).map(sector).collect(),
        beams: (0..40).map(beam).collect(),
    };
    let own = Solution {
        time_s: ping.time_s,
        number: 9,
        head: 2,
        heading_rad: 5.0,
        array_depth_m: 0.75,
        water_line_m: -0.25,
        origin: crate::formats::recorder::Origin::ReferencePoint,
        points: (0..40).map(point).collect(),
    };
    (ping, own)
}

const TEXT: &str = "OSCV:Empty,EMXV:EM2040,TRAI_TX1:N=2045;X=4.1;Y=0.2;Z=1.3;R=0.1;P=-0.5;H=180.2;S=0.5;IPX=0;IPY=-0.05;IPZ=-0.01;ICX=0.01;ICY=0;ICZ=0,TRAI_RX1:N=220;X=4.0;Y=-0.2;Z=1.3;R=0;P=0;H=0.1;G=0;IX=0.01;IY=0;IZ=-0.006,ATTI_1:X=0;Y=0.5;Z=0;R=0.2;P=0.3;H=-0.4;D=0.010;M=POSMV;U=ACTIVE,ATTI_2:X=1;Y=0;Z=0;R=0;P=0;H=0;D=0;U=PASSIVE\nPOSI_1:X=-2;Y=0;Z=-6;D=0;U=ACTIVE,EMXI:SSNL=0;SWLZ=-0.300,";

fn attitude() -> Attitude {
    Attitude {
        time_s: 1_557_607_590.125,
        roll_rad: 0.03,
        pitch_rad: -0.01,
        heading_rad: Some(6.1),
        heave_m: Some(0.5),
        sensor: 0,
        passive: false,
    }
}

fn position() -> Position {
    Position {
        time_s: 1_557_607_590.125,
        latitude_rad: 0.7,
        longitude_rad: -0.2,
        height_m: Some(41.5),
        ..Position::default()
    }
}

fn written(version: u8, split: usize) -> Vec<u8> {
    let mut writer = Writer::new(vec![], 2040).version(version).split(split);
    let mut all = || {
        writer.installation(1_557_607_580.0, TEXT)?;
        writer.profile(&Profile {
            time_s: 1_557_600_000.0,
            depth_m: vec![0.0, 10.0, 40.0],
            speed_m_s: vec![1450.0, 1445.0, 1440.0],
        })?;
        writer.motion(&[(attitude(), Some(position())), (attitude(), None)])?;
        writer.position(&position())?;
        let (ping, own) = ping();
        writer.ping(&ping, &own)
    };
    all().expect("written");
    writer.into_inner()
}

#[test]
fn every_version_whole_or_split_returns_what_was_written() {
    for (version, split) in [(0, 1 << 20), (1, 1 << 20), (2, 1 << 20), (2, 1000), (0, 64)] {
        let (all, summary) = read_bytes(&written(version, split));
        assert_eq!(summary.losses, Losses::default());
        assert_eq!(summary.refusal, None);
        let (meant, own) = ping();
        let read = &all.pings[0];
        assert_eq!((read.number, read.head, read.beams.len()), (9, 2, 40));
        near(read.time_s, meant.time_s, 1e-6);
        near(read.head_speed_m_s, 1445.0, 1e-4);
        for (found, meant) in read.beams.iter().zip(&meant.beams) {
            assert_eq!((found.sector, found.valid), (meant.sector, meant.valid));
            near(found.angle_rad, meant.angle_rad, 1e-7);
            near(found.two_way_s, meant.two_way_s, 1e-8);
        }
        for (found, meant) in read.sectors.iter().zip(&meant.sectors) {
            assert_eq!(found.array, meant.array);
            near(found.tilt_rad, meant.tilt_rad, 1e-8);
            near(found.delay_s, meant.delay_s, 1e-9);
        }
        assert_eq!(all.solutions[0].points, own.points);
        near(all.solutions[0].water_line_m, -0.25, 1e-9);
        near(all.solutions[0].heading_rad, 5.0, 1e-6);
        assert_eq!(all.attitude.len(), 2);
        near(all.attitude[0].roll_rad, 0.03, 1e-8);
        near(all.attitude[0].heave_m.expect("heave"), 0.5, 1e-7);
        assert!(!all.attitude[0].passive);
        let at_reference: Vec<bool> = all.positions.iter().map(|p| p.at_reference).collect();
        assert_eq!(at_reference, [false, true]);
        near(all.positions[1].latitude_rad, 0.7, 1e-15);
        assert_eq!(all.positions[1].height_m, Some(41.5));
        assert_eq!(all.profiles[0].depth_m, [0.0, 10.0, 40.0]);
    }
}

#[test]
fn the_installation_record_comes_into_our_axes() {
    let record = read_bytes(&written(2, 1 << 20)).0.installations.remove(0);
    assert_eq!(record.arrays.len(), 2);
    let transmitter = record.transmitter(1).expect("TX");
    assert_eq!((transmitter.role, transmitter.head), (Role::Transmit, 0));
    assert_eq!(
        transmitter.mounted.mounting.lever_arm_m,
        Vector3::new(0.2, 4.1, -1.3)
    );
    near(
        transmitter.mounted.mounting.angles().2.to_degrees(),
        -179.8,
        1e-9,
    );
    let receiver = record.receiver(1).expect("RX");
    assert_eq!(receiver.inner_m[1], Vector3::new(0.0, 0.01, 0.006));
    assert_eq!(record.water_line_m, Some(0.3));
    let motion = record.motion_sensor().expect("a motion sensor");
    assert_eq!((motion.name.as_str(), motion.delay_s), ("ATTI_1", 0.010));
    assert_eq!(record.motion_sensors.iter().filter(|m| m.active).count(), 1);
    let antenna = record.position_sensor().expect("an antenna");
    assert_eq!(antenna.mounting.lever_arm_m, Vector3::new(0.0, -2.0, 6.0));
    assert!(!record.attitude_is_turned);
}

#[test]
fn a_missing_part_is_counted_and_costs_one_ping() {
    let bytes = written(2, 1000);
    let (clean, _) = read_bytes(&bytes);
    assert_eq!(clean.pings.len(), 1);
    // the last part is gone
    let cut = bytes.len() - 40;
    let (all, summary) = read_bytes(&bytes[..cut]);
    assert_eq!(all.pings.len(), 0);
    assert!(summary.losses.truncated_bytes > 0 && summary.losses.incomplete > 1);
}

#[test]
fn damage_to_the_size_costs_one_datagram() {
    let mut bytes = written(2, 1 << 20);
    bytes[1] ^= 0x10;
    let (all, summary) = read_bytes(&bytes);
    assert_eq!((all.installations.len(), all.pings.len()), (0, 1));
    assert_eq!(summary.losses.skipped_places, 1);
}

#[test]
fn values_that_mean_none_are_none() {
    let mut writer = Writer::new(vec![], 2040);
    let nowhere = Position {
        latitude_rad: 200f64.to_radians(),
        ..position()
    };
    let flat = Position {
        height_m: None,
        ..position()
    };
    writer.position(&nowhere).expect("written");
    writer.position(&flat).expect("written");
    let (all, summary) = read_bytes(&writer.into_inner());
    assert_eq!((all.positions.len(), summary.losses.impossible), (1, 1));
    assert_eq!(all.positions[0].height_m, None);
}
