//! How long does it take to read a file of 100 000 rows into columns, apart from the disk?
//!
//! `cargo bench --bench read`. Items are rows; a million soundings a second on one core is the least that is wanted.

#![allow(
    clippy::disallowed_methods,
    reason = "no result of the program hangs on these"
)]

use std::io::Cursor;
use std::path::Path;

use boresight::formats::Invalid;
use boresight::formats::las::PointColumns;
use boresight::formats::recorder::{BeamSample, OwnPoint, Ping, Sector, Sink, Solution, table};
use boresight::formats::{
    kmall, kongsberg_all, las, laser_csv, sbet, soundings_csv, trajectory_csv,
};
use boresight::recorders::observed::Observed;
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const ROWS: usize = 100_000;

fn main() {
    divan::main();
}

/// A cheap even spread over 0 to 1.
fn spread(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_895).fract()
}

fn soundings() -> Vec<u8> {
    let header = "time_s,ping,beam,across_angle_deg,along_angle_deg,range_m\n".to_owned();
    let row = |k: usize| {
        let (ping, beam) = (k / 256, k % 256);
        let (time_s, across) = (
            1000.0 + ping as f64 / 15.0,
            -70.0 + beam as f64 * 140.0 / 255.0,
        );
        format!(
            "{time_s:.6},{ping},{beam},{across:.5},0.0,{:.5}\n",
            3.0 + spread(k)
        )
    };
    (0..ROWS)
        .map(row)
        .fold(header, |text, row| text + &row)
        .into_bytes()
}

fn trajectory() -> Vec<u8> {
    let header =
        "time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg\n".to_owned();
    let row = |k: usize| {
        let (time_s, s) = (1000.0 + k as f64 * 0.01, spread(k));
        let latitude = 36.0 + s * 1e-5;
        format!(
            "{time_s},{latitude:.12},120.123456789012,{:.6},{s:.8},{s:.8},{:.8}\n",
            15.0 + s,
            31.0 + s
        )
    };
    (0..ROWS)
        .map(row)
        .fold(header, |text, row| text + &row)
        .into_bytes()
}

fn sbet_records() -> Vec<u8> {
    let record = |k: usize| sbet::raw::Record {
        time_s: 1000.0 + k as f64 * 0.01,
        latitude_rad: 0.6,
        longitude_rad: 2.0,
        wander_rad: 0.02,
        ..sbet::raw::Record::default()
    };
    (0..ROWS).flat_map(|k| record(k).to_bytes()).collect()
}

/// A scanner's fan: time, x, z.
fn fan() -> [Vec<f64>; 3] {
    let angle = |k: usize| -0.5 + (k % 1000) as f64 * 1e-3;
    let time_s = (0..ROWS).map(|k| 1000.0 + k as f64 * 1e-5).collect();
    let x = (0..ROWS)
        .map(|k| 5.0 * angle(k).cos() + 0.005 * spread(k))
        .collect();
    let z = (0..ROWS).map(|k| 5.0 * angle(k).sin()).collect();
    [time_s, x, z]
}

fn points(compressed: bool) -> Vec<u8> {
    let [time_s, x_m, z_m] = fan();
    let y_m = vec![0.0; ROWS];
    let columns = PointColumns {
        time_s: &time_s,
        x_m: &x_m,
        y_m: &y_m,
        z_m: &z_m,
        point_source_id: &[],
    };
    las::write_to(&columns, compressed, None).unwrap_or_default()
}

fn laser() -> Vec<u8> {
    let [time_s, x, z] = fan();
    let row = |k: usize| format!("{},{:.5},0,{:.5}\n", time_s[k], x[k], z[k]);
    (0..ROWS)
        .map(row)
        .fold("time_s,x_m,y_m,z_m\n".to_owned(), |text, row| text + &row)
        .into_bytes()
}

/// Times a reader; a reader that fails, or finds another number of rows, ends the bench.
fn measure(bencher: Bencher<'_, '_>, bytes: &[u8], read: impl Fn(&Path, &[u8]) -> usize + Sync) {
    let file = Path::new("bench");
    assert_eq!(read(file, bytes), ROWS);
    bencher
        .counter(ItemsCount::new(ROWS))
        .counter(BytesCount::of_slice(bytes))
        .bench(|| read(file, bytes));
}

#[divan::bench]
fn soundings_from_csv(bencher: Bencher<'_, '_>) {
    measure(bencher, &soundings(), |file, bytes| {
        soundings_csv::read_from(file, bytes, bytes.len() as u64, Invalid::Error)
            .map_or(0, |r| r.len())
    });
}

#[divan::bench]
fn trajectory_from_csv(bencher: Bencher<'_, '_>) {
    measure(bencher, &trajectory(), |file, bytes| {
        trajectory_csv::read_from(file, bytes, bytes.len() as u64, Invalid::Error)
            .map_or(0, |r| r.len())
    });
}

#[divan::bench]
fn trajectory_from_sbet(bencher: Bencher<'_, '_>) {
    measure(bencher, &sbet_records(), |file, bytes| {
        sbet::read_from(file, bytes, bytes.len() as u64, Invalid::Error).map_or(0, |r| r.len())
    });
}

#[divan::bench]
fn laser_from_csv(bencher: Bencher<'_, '_>) {
    measure(bencher, &laser(), |file, bytes| {
        laser_csv::read_from(file, bytes, bytes.len() as u64, Invalid::Error).map_or(0, |r| r.len())
    });
}

#[divan::bench(args = [true, false])]
fn laser_from_las(bencher: Bencher<'_, '_>, compressed: bool) {
    measure(bencher, &points(compressed), |file, bytes| {
        let size = bytes.len() as u64;
        las::read_from(file, Cursor::new(bytes.to_vec()), size, Invalid::Error)
            .map_or(0, |r| r.len())
    });
}

/// Pings of 250 beams in three sectors, as many as make [`ROWS`].
fn pings() -> impl Iterator<Item = Ping> {
    const BEAMS: usize = 250;
    let sector = |tilt_rad: f64| Sector {
        tilt_rad,
        ..Sector::default()
    };
    (0..ROWS / BEAMS).map(move |ping| Ping {
        time_s: 345_600.0 + 0.1 * ping as f64,
        number: ping as u32,
        head: 1,
        head_speed_m_s: 1485.0,
        sectors: [-0.01, 0.0, 0.01].map(sector).to_vec(),
        beams: (0..BEAMS)
            .map(|beam| BeamSample {
                number: beam as u32,
                sector: (beam * 3 / BEAMS) as u16,
                angle_rad: (beam as f64 / BEAMS as f64 - 0.5) * 2.0,
                two_way_s: 0.04 + 0.01 * spread(ping * BEAMS + beam),
                valid: true,
            })
            .collect(),
    })
}

/// Times the decoding of a recorder's file into the columns that a survey keeps.
fn recorder(bencher: Bencher<'_, '_>, extension: &str, bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join(format!("bench.{extension}"));
    std::fs::write(&file, bytes).expect("written");
    measure(bencher, bytes, |_, _| {
        let mut observed = Observed::default();
        let read = observed.read(&file);
        read.map_or(0, |()| observed.soundings.time_s.len())
    });
}

#[divan::bench]
fn pings_from_all(bencher: Bencher<'_, '_>) {
    recorder(bencher, "all", &all());
}

#[divan::bench]
fn pings_from_kmall(bencher: Bencher<'_, '_>) {
    recorder(bencher, "kmall", &kmall());
}

/// Counts the beams that a decoder hands over, and keeps nothing.
#[derive(Default)]
struct Counted(usize);

impl Sink for Counted {
    fn ping(&mut self, ping: &Ping) {
        self.0 += ping.beams.len();
    }
}

/// Times the decoder alone over a file of some hundred megabytes, with one record in memory at a time.
fn decoder(bencher: Bencher<'_, '_>, extension: &str, bytes: &[u8], times: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join(format!("long.{extension}"));
    std::fs::write(&file, bytes.repeat(times)).expect("written");
    let decode = || {
        let mut counted = Counted::default();
        table::read(&file, &mut counted).map_or(0, |_| counted.0)
    };
    assert_eq!(decode(), times * ROWS);
    bencher
        .counter(ItemsCount::new(times * ROWS))
        .counter(BytesCount::new(times * bytes.len()))
        .bench(decode);
}

#[divan::bench(sample_count = 10)]
fn decoder_of_all(bencher: Bencher<'_, '_>) {
    decoder(bencher, "all", &all(), 64);
}

#[divan::bench(sample_count = 10)]
fn decoder_of_kmall(bencher: Bencher<'_, '_>) {
    decoder(bencher, "kmall", &kmall(), 8);
}

fn all() -> Vec<u8> {
    let mut writer = kongsberg_all::write::Writer::new(vec![], 2040, 1);
    for ping in pings() {
        writer.ping(&ping).expect("written");
    }
    writer.into_inner()
}

fn kmall() -> Vec<u8> {
    let mut writer = kmall::write::Writer::new(vec![], 2040);
    for ping in pings() {
        let own = Solution {
            time_s: ping.time_s,
            number: ping.number,
            head: ping.head,
            points: vec![OwnPoint::default(); ping.beams.len()],
            ..Solution::default()
        };
        writer.ping(&ping, &own).expect("written");
    }
    writer.into_inner()
}
