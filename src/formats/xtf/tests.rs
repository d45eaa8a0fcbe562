use super::*;
use crate::formats::recorder::{Attitude, Out, Ping, Position};

#[derive(Default)]
struct All {
    attitude: Vec<Attitude>,
    positions: Vec<Position>,
    pings: Vec<Ping>,
}

impl Sink for All {
    fn attitude(&mut self, record: &Attitude) {
        self.attitude.push(*record);
    }
    fn position(&mut self, record: &Position) {
        self.positions.push(*record);
    }
    fn ping(&mut self, record: &Ping) {
        self.pings.push(record.clone());
    }
}

fn packet(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut out = Out::new(false);
    let size = (14 + body.len()).next_multiple_of(64);
    out.u16(raw::MAGIC)
        .u8(kind)
        .u8(0)
        .u16(1)
        .u32(0)
        .u32(size as u32);
    out.raw(body).zeros(size - 14 - body.len());
    out.data
}

fn header() -> Vec<u8> {
    let mut bytes = vec![0; HEADER];
    bytes[0] = 123;
    bytes[1] = 1;
    bytes[2..7].copy_from_slice(b"TRIAL");
    bytes
}

/// A ping of three beams by hand, with steps of angle (A2) or even ones (A0).
fn ping(even: bool) -> Vec<u8> {
    let mut block = Out::new(true);
    block.raw(b"BTH0").u32(0).u32(0);
    block
        .raw(b"H0")
        .u16(116)
        .raw(b"2024\0\0\0\0\0\0\0\0")
        .raw(b"100\0\0\0\0\0\0\0\0\0");
    block.u32(1_436_399_535).u32(250_000_000).u32(77).f32(0.1);
    block.f32(1500.0).f32(400e3).zeros(16).f32(0.0).f32(0.0);
    block.zeros(38).u16(3);
    block
        .raw(b"R0")
        .u16(14)
        .f32(0.0009765625)
        .u16(16)
        .u16(0)
        .u16(32);
    if even {
        block.raw(b"A0").u16(36).f32(-0.5).f32(0.5).zeros(24);
    } else {
        block.raw(b"A2").u16(42).f32(-0.5).f32(0.125).zeros(24);
        block.u16(0).u16(4).u16(4);
    }
    let size = block.data.len() as u32;
    block.set_u32(4, size);
    let mut body = vec![0; raw::PING_HEADER - 14];
    body.extend(block.data);
    packet(65, &body)
}

fn read_bytes(bytes: &[u8]) -> (All, Summary) {
    let mut all = All::default();
    let summary = read_from(Path::new("a.xtf"), bytes, &mut all).expect("readable");
    (all, summary)
}

#[test]
fn a_ping_by_hand_in_both_forms_of_angles() {
    for even in [false, true] {
        let (all, summary) = read_bytes(&[header(), ping(even)].concat());
        assert_eq!(summary.losses, Losses::default());
        assert_eq!(summary.device, "R2Sonic 2024 100");
        let read = &all.pings[0];
        assert_eq!((read.time_s, read.number), (1_436_399_535.25, 77));
        let angles: Vec<f64> = read.beams.iter().map(|b| b.angle_rad).collect();
        assert_eq!(angles, [-0.5, 0.0, 0.5]);
        let valid: Vec<bool> = read.beams.iter().map(|b| b.valid).collect();
        assert_eq!(valid, [true, false, true]);
        assert!((read.beams[2].two_way_s - 0.03125).abs() < 1e-12);
    }
}

#[test]
fn attitude_and_position_by_hand() {
    let mut attitude = Out::new(false);
    attitude
        .zeros(16)
        .f32(1.0)
        .f32(-2.0)
        .f32(0.25)
        .f32(0.0)
        .u32(0)
        .f32(250.0);
    attitude.u16(2015).u8(7).u8(8).u8(23).u8(52).u8(15).u16(908);
    let mut position = Out::new(false);
    position
        .u16(2015)
        .u8(7)
        .u8(8)
        .u8(23)
        .u8(52)
        .u8(15)
        .u16(9080);
    position.f64(37.75).f64(-122.5).f64(-25.5);
    let (a, p) = (packet(3, &attitude.data), packet(107, &position.data));
    let (all, summary) = read_bytes(&[header(), a, p].concat());
    assert!(
        summary
            .refusal
            .expect("no soundings")
            .contains("only packets 107, 3")
    );
    let a = &all.attitude[0];
    assert_eq!(a.roll_rad, (-2.0f64).to_radians());
    assert_eq!((a.pitch_rad, a.heave_m), (1.0f64.to_radians(), Some(0.25)));
    assert!((a.time_s - 1_436_399_535.908).abs() < 1e-6);
    let p = &all.positions[0];
    assert!((p.time_s - 1_436_399_535.908).abs() < 1e-6);
    assert_eq!(p.longitude_rad, (-122.5f64).to_radians());
    assert_eq!(p.height_m, Some(-25.5));
}

#[test]
fn garbage_between_packets_is_passed_over() {
    let (all, summary) = read_bytes(&[header(), vec![9; 100], ping(false), ping(true)].concat());
    assert_eq!((all.pings.len(), summary.losses.skipped_bytes), (2, 100));
}

#[test]
fn no_header_is_an_error() {
    let mut sink = All::default();
    assert!(read_from(Path::new("a.xtf"), [0u8; 2000].as_slice(), &mut sink).is_err());
}
