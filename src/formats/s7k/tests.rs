use super::*;
use crate::formats::recorder::{Attitude, Heading, Installation, Out, Ping, Position, Profile};
use nalgebra::Vector3;

#[derive(Default)]
struct All {
    attitude: Vec<Attitude>,
    headings: Vec<Heading>,
    positions: Vec<Position>,
    profiles: Vec<Profile>,
    pings: Vec<Ping>,
    installations: Vec<Installation>,
}

impl Sink for All {
    fn installation(&mut self, record: &Installation) {
        self.installations.push(record.clone());
    }
    fn attitude(&mut self, record: &Attitude) {
        self.attitude.push(*record);
    }
    fn heading(&mut self, record: &Heading) {
        self.headings.push(*record);
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
}

/// A record by hand, at noon of the 44th day of 2014 and 1.5 seconds.
fn record(kind: u32, data: &Out) -> Vec<u8> {
    let mut out = Out::new(false);
    out.u16(5).u16(60).u32(SYNC);
    out.u32((FRAME + data.data.len() + 4) as u32).u32(0).u32(0);
    out.u16(2014).u16(44).f32(1.5).u8(12).u8(0).u16(0);
    out.u32(kind).u32(7125).u16(0).zeros(6).u16(1).zeros(14);
    out.raw(&data.data);
    let sum = checksum(&out.data);
    out.u32(sum);
    out.data
}

fn settings(ping: u32) -> Vec<u8> {
    let mut out = Out::new(false);
    out.u64(0)
        .u32(ping)
        .u16(0)
        .f32(400e3)
        .zeros(100)
        .u32(1)
        .zeros(24);
    out.f32(1500.5).zeros(6);
    assert_eq!(out.data.len(), 156);
    record(7000, &out)
}

fn detections(ping: u32, bytes: usize) -> Vec<u8> {
    let mut out = Out::new(false);
    out.u64(0)
        .u32(ping)
        .u16(0)
        .u32(2)
        .u32(bytes as u32)
        .u8(0)
        .u32(0);
    out.f32(32768.0).f32(0.125).f32(0.0).zeros(60);
    for k in 0..2u16 {
        let end = out.data.len() + bytes;
        out.u16(10 + k)
            .f32(512.0)
            .f32(0.5 - f32::from(k))
            .u32(0)
            .u32(3);
        out.zeros(end - out.data.len());
    }
    record(7027, &out)
}

fn read_bytes(bytes: &[u8]) -> (All, Summary) {
    let mut all = All::default();
    let summary = read_from(Path::new("a.s7k"), bytes, &mut all).expect("readable");
    (all, summary)
}

const NOON_S: f64 = 1_392_249_600.0 + 43_200.0 + 1.5;

#[test]
fn halves_of_a_ping_join_in_either_order_and_every_size() {
    for bytes in [22, 26, 30, 34] {
        let (a, b) = (settings(7), detections(7, bytes));
        for whole in [[a.clone(), b.clone()], [b, a]] {
            let (all, summary) = read_bytes(&whole.concat());
            assert_eq!(summary.losses, Losses::default());
            let ping = &all.pings[0];
            assert_eq!((ping.number, ping.head, ping.time_s), (7, 7125, NOON_S));
            assert_eq!(ping.head_speed_m_s, 1500.5);
            assert_eq!(ping.sectors[0].tilt_rad, 0.125);
            assert_eq!((ping.beams[0].number, ping.beams[0].angle_rad), (10, 0.5));
            assert_eq!(
                (ping.beams[1].angle_rad, ping.beams[1].two_way_s),
                (-0.5, 0.015625)
            );
        }
    }
}

#[test]
fn halves_without_the_other_are_counted() {
    let bytes = [
        settings(1),
        settings(2),
        detections(2, 22),
        detections(3, 22),
    ]
    .concat();
    let (all, summary) = read_bytes(&bytes);
    assert_eq!((all.pings.len(), summary.losses.unpaired), (1, 2));
}

#[test]
fn navigation_and_sound_speed_by_hand() {
    let mut position = Out::new(false);
    position
        .u32(0)
        .f32(0.0)
        .f64(0.7)
        .f64(-0.2)
        .f64(41.5)
        .u8(0)
        .zeros(4);
    let mut motion = Out::new(false);
    motion.f32(0.25).f32(-0.125).f32(0.5);
    let mut heading = Out::new(false);
    heading.f32(1.5);
    let mut motions = Out::new(false);
    motions.u8(2);
    for ms in [0u16, 10] {
        motions.u16(ms).f32(0.25).f32(-0.125).f32(0.5).f32(3.0);
    }
    let mut profile = Out::new(false);
    profile
        .zeros(20)
        .u32(2)
        .f32(0.0)
        .f32(1500.0)
        .f32(10.0)
        .f32(1490.0);
    let mut cast = Out::new(false);
    cast.zeros(7).u8(1).zeros(24).u32(1);
    cast.f32(35.0).f32(10.0).f32(5.0).f32(1495.0).f32(0.0);
    let bytes = [
        record(1003, &position),
        record(1012, &motion),
        record(1013, &heading),
        record(1016, &motions),
        record(1009, &profile),
        record(1010, &cast),
    ];
    let (all, summary) = read_bytes(&bytes.concat());
    assert_eq!(summary.losses, Losses::default());
    assert_eq!(all.positions[0].latitude_rad, 0.7);
    assert_eq!((all.attitude.len(), all.headings.len()), (3, 1));
    assert_eq!(
        (all.attitude[0].roll_rad, all.attitude[0].heading_rad),
        (0.25, None)
    );
    assert_eq!(all.attitude[2].time_s, NOON_S + 0.01);
    assert_eq!(all.profiles[0].speed_m_s, [1500.0, 1490.0]);
    assert_eq!(all.profiles[1].depth_m, [5.0]);
}

#[test]
fn the_installation_record_keeps_its_axes() {
    let mut data = Out::new(false);
    data.f32(400e3).zeros(520);
    for value in [
        1.0f32, 2.0, -3.0, 0.25, 0.125, 0.5, 1.5, 2.0, -3.0, 0.0, 0.0, 0.0,
    ] {
        data.f32(value);
    }
    data.zeros(24)
        .u16(5)
        .f32(0.0)
        .f32(0.0)
        .f32(4.0)
        .u16(0)
        .f32(0.75);
    let (all, _) = read_bytes(&record(7030, &data));
    let record = &all.installations[0];
    let transmitter = &record.transmitter(7125).expect("TX").mounted.mounting;
    assert_eq!(transmitter.lever_arm_m, Vector3::new(1.0, 2.0, -3.0));
    let (roll, pitch, heading) = transmitter.angles();
    for (found, meant) in [(roll, 0.25), (pitch, 0.125), (heading, 0.5)] {
        assert!((found - meant).abs() < 1e-12);
    }
    assert_eq!(record.water_line_m, Some(0.75));
    assert_eq!(record.motion_sensors[0].delay_s, 0.005);
}

#[test]
fn a_wrong_sum_costs_one_record_and_old_detections_are_refused() {
    let mut wrong = settings(1);
    wrong[100] ^= 4;
    let bytes = [wrong, settings(2), detections(2, 22)].concat();
    let (all, summary) = read_bytes(&bytes);
    assert_eq!((all.pings.len(), summary.losses.bad_checksums), (1, 1));
    let refusal = read_bytes(&record(7006, &Out::new(false))).1.refusal;
    assert!(refusal.expect("refused").contains("levelled"));
}
