//! Damaged recorder files: whatever happens to the bytes, no reader panics, hangs or loses records in silence.
//!
//! Each format's seeds are spoilt some hundred times by flipped bytes, cuts, splices, holes and counts at their limits;
//! `BORESIGHT_MUTANTS` sets how often. Seeds are written here, or are the first part of a real file where `BORESIGHT_DATA` names them.

use std::path::Path;
use std::time::{Duration, Instant};

use boresight::formats::recorder::table::RECORDERS;
use boresight::formats::recorder::{
    Attitude, BeamSample, Origin, Out, OwnPoint, Ping, Position, Profile, Sector, Sink, Solution,
    Summary,
};
use boresight::formats::{gsf, kmall, kongsberg_all, novatel, pos_mv, s7k, xtf};

type Read = fn(&[u8], &mut Counted) -> Summary;

/// Counts what comes, and holds every number to be finite where a caller relies on it.
#[derive(Default)]
struct Counted(u64);

impl Sink for Counted {
    fn attitude(&mut self, a: &Attitude) {
        self.0 += 1;
        assert!(a.time_s.is_finite() && a.roll_rad.is_finite() && a.pitch_rad.is_finite());
    }
    fn position(&mut self, p: &Position) {
        self.0 += 1;
        assert!(p.latitude_rad.is_finite() && p.longitude_rad.is_finite());
        assert!(p.height_m.is_none_or(f64::is_finite));
    }
    fn profile(&mut self, p: &Profile) {
        self.0 += 1;
        assert_eq!(p.depth_m.len(), p.speed_m_s.len());
        assert!(p.depth_m.windows(2).all(|d| d[0] < d[1]));
    }
    fn ping(&mut self, ping: &Ping) {
        self.0 += 1;
        for beam in ping.beams.iter().filter(|b| b.valid) {
            assert!(usize::from(beam.sector) < ping.sectors.len());
            assert!(beam.angle_rad.is_finite() && beam.two_way_s > 0.0 && beam.two_way_s < 60.0);
        }
    }
}

/// A cheap generator of bits, the same on every machine.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// One mutant of a seed; whether its end was cut.
fn mutant(seed: &[u8], dice: &mut Dice) -> (Vec<u8>, bool) {
    let mut bytes = seed.to_vec();
    let mut cut = false;
    for _ in 0..=dice.below(3) {
        let at = dice.below(bytes.len());
        let length = 1 + dice.below(400);
        let end = (at + length).min(bytes.len());
        match dice.below(6) {
            0 => (0..1 + dice.below(20)).for_each(|_| {
                let k = dice.below(bytes.len());
                bytes[k] ^= 1 << dice.below(8);
            }),
            1 => {
                bytes.truncate(at.max(1));
                cut = true;
            }
            2 => {
                let piece = bytes[at..end].to_vec();
                let to = dice.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            3 => {
                bytes.drain(at..end.min(bytes.len() - 1).max(at));
            }
            4 => bytes[at..end].fill(if dice.below(2) == 0 { 0 } else { 0xFF }),
            _ => {
                let limit = [0, 1, 0x7F, 0x80, 0xFF][dice.below(5)];
                let end = (at + 4).min(bytes.len());
                bytes[at..end].fill(limit);
            }
        }
    }
    (bytes, cut)
}

fn mutants() -> u64 {
    let wanted = std::env::var("BORESIGHT_MUTANTS").ok();
    wanted.and_then(|n| n.parse().ok()).unwrap_or(300)
}

/// Spoils the seeds of a format; `summed`: its records carry checksums, so that every record lost must be counted.
fn spoil(name: &str, seeds: &[Vec<u8>], read: Read, summed: bool) {
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let whole: Vec<u64> = seeds
        .iter()
        .map(|s| records(&read(s, &mut Counted::default())))
        .collect();
    assert!(
        whole.iter().all(|n| *n > 0),
        "{name}: a seed without records"
    );
    let (mut lost, mut slowest) = (0, Duration::ZERO);
    for k in 0..mutants() {
        let which = k as usize % seeds.len();
        let (bytes, cut) = mutant(&seeds[which], &mut dice);
        let begun = Instant::now();
        let summary = read(&bytes, &mut Counted::default());
        slowest = slowest.max(begun.elapsed());
        let gone = whole[which].saturating_sub(records(&summary));
        let fewer = gone > 0 && !taken_out(&seeds[which], whole[which], &bytes, gone);
        lost += u64::from(summary.losses.any());
        assert!(
            cut || !summed || !fewer || summary.losses.any(),
            "{name}, mutant {k}: lost in silence"
        );
        let counted = summary.losses.skipped_bytes + summary.losses.truncated_bytes;
        assert!(
            counted <= bytes.len() as u64,
            "{name}, mutant {k}: more lost than there was"
        );
    }
    eprintln!(
        "{name}: {} mutants, {lost} with losses, slowest {slowest:?}",
        mutants()
    );
    assert!(lost > 0, "{name}: no mutant lost anything");
    assert!(
        slowest < Duration::from_secs(20),
        "{name}: {slowest:?} for one file"
    );
}

/// Whether so many whole records were taken out of a seed whose records all have one length: what is left is a good file.
fn taken_out(seed: &[u8], whole: u64, bytes: &[u8], gone: u64) -> bool {
    let length = seed.len() as u64 / whole;
    length * whole == seed.len() as u64 && bytes.len() as u64 + gone * length == seed.len() as u64
}

fn records(summary: &Summary) -> u64 {
    summary.records.values().sum()
}

/// The first part of a real file, where it is at hand.
fn real(name: &str) -> Option<Vec<u8>> {
    let folder = std::env::var_os("BORESIGHT_DATA")?;
    let mut bytes = std::fs::read(Path::new(&folder).join(name)).expect("a real file");
    bytes.truncate(120_000);
    Some(bytes)
}

fn ping() -> (Ping, Solution) {
    let beam = |k: u32| BeamSample {
        number: k,
        sector: (k % 2) as u16,
        valid: true,
        angle_rad: f64::from(k) * 0.02 - 0.6,
        two_way_s: 0.02,
    };
    let sector = Sector {
        tilt_rad: 0.01,
        ..Sector::default()
    };
    let ping = Ping {
        time_s: 1.4e9,
        number: 3,
        head: 1,
        head_speed_m_s: 1500.0,
        sectors: vec![sector; 2],
        beams: (0..60).map(beam).collect(),
    };
    let own = Solution {
        time_s: 1.4e9,
        number: 3,
        head: 1,
        origin: Origin::ReferencePoint,
        points: vec![OwnPoint::default(); 60],
        ..Solution::default()
    };
    (ping, own)
}

fn profile() -> Profile {
    Profile {
        time_s: 1.4e9,
        depth_m: vec![0.0, 5.0, 10.0],
        speed_m_s: vec![1500.0, 1499.0, 1490.0],
    }
}

fn attitude(k: i32) -> Attitude {
    Attitude {
        time_s: 1.4e9 + 0.01 * f64::from(k),
        roll_rad: 0.01,
        heading_rad: Some(1.0),
        ..Attitude::default()
    }
}

#[test]
fn kongsberg_all_survives() {
    let mut seeds = vec![];
    for big_endian in [false, true] {
        let mut writer = kongsberg_all::write::Writer::new(vec![], 2040, 1);
        if big_endian {
            writer = writer.big_endian();
        }
        writer
            .installation(1.4e9, "S1X=1,S1Y=1,S1Z=1,S2X=0,S2Y=0,S2Z=0,", 2)
            .expect("written");
        for _ in 0..8 {
            let (ping, own) = ping();
            writer.ping(&ping).expect("written");
            writer.solution(&own, 1500.0).expect("written");
            writer.profile(&profile()).expect("written");
            writer.position(&Position::default(), 1.0).expect("written");
            let samples: Vec<Attitude> = (0..50).map(attitude).collect();
            writer.attitude(&samples).expect("written");
        }
        seeds.push(writer.into_inner());
    }
    seeds.extend(real("kongsberg/0001_20140213_052736_Yolla.all"));
    let read: Read = |b, s| kongsberg_all::read_from(Path::new("a.all"), b, s).expect("bytes");
    spoil("all", &seeds, read, true);
}

#[test]
fn kmall_survives() {
    let mut seeds = vec![];
    for (version, split) in [(0, 1 << 20), (2, 900)] {
        let mut writer = kmall::write::Writer::new(vec![], 2040)
            .version(version)
            .split(split);
        writer
            .installation(1.4e9, "TRAI_HD1:X=0;Y=0;Z=1;R=0;P=0;H=0,")
            .expect("written");
        for _ in 0..8 {
            let (ping, own) = ping();
            writer.ping(&ping, &own).expect("written");
            writer.profile(&profile()).expect("written");
            writer.position(&Position::default()).expect("written");
            let samples: Vec<_> = (0..50).map(|k| (attitude(k), None)).collect();
            writer.motion(&samples).expect("written");
        }
        seeds.push(writer.into_inner());
    }
    seeds.extend(real("kmall/MRZ_versionF.kmall"));
    let read: Read = |b, s| kmall::read_from(Path::new("a.kmall"), b, s).expect("bytes");
    spoil("kmall", &seeds, read, false);
}

#[test]
fn xtf_survives() {
    let mut header = vec![0; 1024];
    header[0] = 123;
    let mut packet = Out::new(false);
    packet
        .u16(xtf::raw::MAGIC)
        .u8(3)
        .u8(0)
        .u16(1)
        .u32(0)
        .u32(64);
    packet
        .zeros(40)
        .u16(2015)
        .u8(7)
        .u8(8)
        .u8(1)
        .u8(1)
        .u8(1)
        .u16(0)
        .zeros(1);
    let mut seeds = vec![[header, packet.data.repeat(50)].concat()];
    seeds.extend(real("r2sonic/0009-150708-R2Testing-0001.xtf"));
    // where the header itself was spoilt the file is refused with an error, which is no loss in silence
    let read: Read = |b, s| xtf::read_from(Path::new("a.xtf"), b, s).unwrap_or_default();
    spoil("xtf", &seeds, read, false);
}

#[test]
fn novatel_survives() {
    let mut seed = vec![];
    for k in 0..60u32 {
        let mut out = Out::new(false);
        out.raw(&[0xAA, 0x44, 0x13, 88]).u16(508).u16(2100).u32(k);
        out.u32(2100)
            .f64(f64::from(k))
            .f64(51.0)
            .f64(-114.0)
            .f64(80.5);
        out.zeros(24).f64(1.0).f64(-2.0).f64(270.0).u32(3);
        let sum = novatel::raw::crc(&out.data);
        out.u32(sum);
        seed.extend(out.data);
        let text = "INSATTA,COM1,0,50.0,FINESTEERING,2100,5.0,0,0,0;2100,5.0,1.0,2.0,3.0,INS_SOLUTION_GOOD";
        let sum = novatel::raw::crc(text.as_bytes());
        seed.extend(format!("#{text}*{sum:08x}\r\n").into_bytes());
    }
    let mut seeds = vec![seed];
    seeds.extend(real("novatel/ins2.gps"));
    let read: Read = |b, s| novatel::read_from(Path::new("a.gps"), b, s).expect("bytes");
    spoil("novatel", &seeds, read, true);
}

#[test]
fn s7k_survives() {
    let record = |kind: u32, data: &Out| {
        let mut out = Out::new(false);
        out.u16(5).u16(60).u32(s7k::raw::SYNC);
        out.u32((68 + data.data.len()) as u32).u32(0).u32(0);
        out.u16(2014).u16(44).f32(1.5).u8(12).u8(0).u16(0);
        out.u32(kind)
            .u32(7125)
            .u16(0)
            .zeros(6)
            .u16(1)
            .zeros(14)
            .raw(&data.data);
        let sum = out.data.iter().map(|b| u32::from(*b)).sum();
        out.u32(sum);
        out.data
    };
    let mut seed = vec![];
    for ping in 0..30 {
        let mut settings = Out::new(false);
        settings
            .u64(0)
            .u32(ping)
            .u16(0)
            .zeros(132)
            .f32(1500.0)
            .zeros(6);
        let mut detections = Out::new(false);
        detections
            .u64(0)
            .u32(ping)
            .u16(0)
            .u32(20)
            .u32(26)
            .zeros(5)
            .f32(32e3)
            .zeros(68);
        for k in 0..20u16 {
            detections.u16(k).f32(640.0).f32(0.5).u32(0).u32(3).zeros(8);
        }
        let mut motions = Out::new(false);
        motions.u8(3).zeros(54);
        seed.extend(
            [
                record(7000, &settings),
                record(7027, &detections),
                record(1016, &motions),
            ]
            .concat(),
        );
    }
    let read: Read = |b, s| s7k::read_from(Path::new("a.s7k"), b, s).expect("bytes");
    spoil("s7k", &[seed], read, true);
}

#[test]
fn pos_mv_survives() {
    let mut seed = vec![];
    for k in 0..60 {
        let mut out = Out::new(false);
        out.raw(b"$GRP")
            .u16(102)
            .u16(134)
            .f64(f64::from(k))
            .zeros(16)
            .u8(1)
            .u8(0);
        out.f64(43.5).f64(-70.25).f64(-20.5).zeros(80);
        let words = out
            .data
            .as_chunks::<2>()
            .0
            .iter()
            .map(|w| u16::from_le_bytes(*w));
        let sum = words.fold(u16::from_le_bytes(*b"$#"), u16::wrapping_add);
        out.u16(sum.wrapping_neg()).raw(b"$#");
        seed.extend(out.data);
    }
    let read: Read = |b, s| pos_mv::read_from(Path::new("a.000"), b, s).expect("bytes");
    spoil("pos-mv", &[seed], read, true);
}

#[test]
fn gsf_survives() {
    let mut seed = Out::new(true);
    seed.u32(12).u32(1).raw(b"GSF-v03.06\0\0");
    for _ in 0..60 {
        seed.u32(56).u32(2).u32(1_000_000_000).zeros(52);
        seed.u32(20)
            .u32(12)
            .u32(1_000_000_000)
            .u32(0)
            .u16(1)
            .zeros(10);
    }
    let mut seeds = vec![seed.data];
    seeds.extend(real("gsf/GSF3_08_test_file.gsf"));
    let read: Read = |b, s| gsf::read_from(Path::new("a.gsf"), b, s).expect("bytes");
    spoil("gsf", &seeds, read, false);
}

#[test]
fn every_format_of_the_table_is_spoilt_here() {
    let names: Vec<&str> = RECORDERS.iter().map(|r| r.name).collect();
    let here = [
        "kongsberg-all",
        "kmall",
        "s7k",
        "xtf",
        "gsf",
        "novatel",
        "pos-mv",
    ];
    assert_eq!(names, here, "add a test to this file for a new format");
}
