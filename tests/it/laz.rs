//! Our decoder of LAZ against the `las` crate's writer: every point format, with and without extra bytes, chunks fixed; and files
//! that no decoder may fall over.

use std::io::Cursor;
use std::path::Path;

use boresight::formats::Invalid;
use boresight::formats::{self, FormatError, LaserRecords};

/// A small generator, so that the points are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
}

/// Points whose every field changes now and then, times in several sequences.
fn points(format: ::las::point::Format, count: usize) -> Vec<::las::Point> {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d ^ u64::from(format.to_u8().unwrap_or(0)));
    let (mut x, mut y, mut z, mut t) = (10.0, -20.0, 3.0, 1000.0);
    let mut point = ::las::Point::default();
    (0..count)
        .map(|_| {
            let r = numbers.next();
            x += (r % 200) as f64 * 0.001 - 0.09;
            y += ((r >> 8) % 50) as f64 * 0.001;
            z += ((r >> 20) % 9) as f64 * 0.001;
            match r % 40 {
                0..20 => t += 0.000_1,
                20..30 => t += (r % 600) as f64 * 0.001,
                30 => t += 5000.0,
                31 => t = (r % 604_800) as f64,
                _ => {}
            }
            if r.is_multiple_of(3) {
                let returns = 1 + (r >> 12) as u8 % 5;
                point.number_of_returns = returns;
                point.return_number = 1 + (r >> 16) as u8 % returns;
                point.intensity = (r >> 24) as u16;
                point.user_data = (r >> 9) as u8 % 5;
            }
            if r.is_multiple_of(5) {
                point.point_source_id = (r >> 30) as u16 % 4;
                point.scanner_channel = if format.is_extended {
                    (r >> 33) as u8 % 4
                } else {
                    0
                };
            }
            (point.x, point.y, point.z) = (x, y, z);
            point.gps_time = format.has_gps_time.then_some(t);
            point.color = format
                .has_color
                .then(|| ::las::Color::new(r as u16, (r >> 7) as u16, 300));
            point.nir = format.has_nir.then_some((r >> 40) as u16);
            point.extra_bytes = vec![(r >> 50) as u8; format.extra_bytes.into()];
            point.clone()
        })
        .collect()
}

/// The bytes of a file of these points.
fn written(points: &[::las::Point], format: ::las::point::Format, minor: u8) -> Vec<u8> {
    let mut builder = ::las::Builder::from((1, minor));
    builder.point_format = format;
    let header = builder.into_header().expect("a header");
    let mut writer = ::las::Writer::new(Cursor::new(Vec::new()), header).expect("a writer");
    for point in points {
        writer.write_point(point.clone()).expect("a point");
    }
    writer.into_inner().expect("the bytes").into_inner()
}

fn read(bytes: &[u8]) -> Result<LaserRecords, FormatError> {
    formats::las::read_from(
        Path::new("some/file"),
        Cursor::new(bytes.to_vec()),
        bytes.len() as u64,
        Invalid::Error,
    )
}

/// Formats with a time that the crate can write compressed.
const FORMATS: [u8; 5] = [1, 3, 6, 7, 8];

#[test]
fn every_point_format_is_read_as_it_was_written() {
    for number in FORMATS {
        for extra in [0, 5] {
            for compressed in [false, true] {
                let mut format = ::las::point::Format::new(number).expect("a format");
                format.extra_bytes = extra;
                format.is_compressed = compressed;
                let points = points(format, 3000);
                let minor = if number < 6 { 2 } else { 4 };
                let found = read(&written(&points, format, minor)).expect("a good file");
                let mut wanted: Vec<(f64, i64)> = points
                    .iter()
                    .map(|p| (p.gps_time.expect("a time"), (p.x * 1e3).round() as i64))
                    .collect();
                // the reader sorts by time, and keeps the order of the file within one
                wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
                let found: Vec<(f64, i64)> = found
                    .time_s
                    .iter()
                    .zip(&found.x_m)
                    .map(|(t, x)| (*t, (x * 1e3).round() as i64))
                    .collect();
                assert_eq!(found, wanted, "format {number}, {extra} extra bytes");
            }
        }
    }
}

/// Mutants of both kinds of compression: an error with a place or points, never a panic; the stack of a small thread is enough.
#[test]
fn damaged_points_are_refused_on_a_small_stack() {
    let mutate = || {
        for number in [1, 6] {
            let mut format = ::las::point::Format::new(number).expect("a format");
            format.is_compressed = true;
            let good = written(
                &points(format, 1500),
                format,
                if number < 6 { 2 } else { 4 },
            );
            let mut numbers = Numbers(7);
            let mut refused = 0;
            for _ in 0..300 {
                let mut bytes = good.clone();
                for _ in 0..1 + numbers.next() % 4 {
                    let at = numbers.next() as usize % bytes.len();
                    bytes[at] = numbers.next() as u8;
                }
                if let Err(error) = read(&bytes) {
                    assert!(error.to_string().starts_with("some/file: "), "{error}");
                    refused += 1;
                }
            }
            assert!(refused > 100, "only {refused} of 300 mutants refused");
        }
    };
    let thread = std::thread::Builder::new().stack_size(256 << 10);
    thread
        .spawn(mutate)
        .expect("a thread")
        .join()
        .expect("no panic");
}

/// LAS 1.4 counts in its long field; writers leave stale values in the short one.
#[test]
fn the_long_count_counts() {
    let format = ::las::point::Format::new(6).expect("a format");
    let mut bytes = written(&points(format, 500), format, 4);
    bytes[107..111].copy_from_slice(&100u32.to_le_bytes());
    assert_eq!(read(&bytes).expect("a good file").len(), 500);
}

/// A header may claim anything; room is made for what the file can hold.
#[test]
fn a_count_beyond_the_bytes_is_refused() {
    let mut format = ::las::point::Format::new(6).expect("a format");
    format.is_compressed = true;
    let mut bytes = written(&points(format, 500), format, 4);
    bytes[247..255].copy_from_slice(&(1u64 << 35).to_le_bytes());
    let error = read(&bytes).expect_err("a damaged header");
    assert!(error.found.contains("compressed bytes"), "{error}");
}
