//! What is written is read back, and real files are read as their own companions say.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use boresight::formats::Invalid;
use boresight::formats::las::PointColumns;
use boresight::formats::{
    self, FaultKind, las, laser_csv, sbet, sound_speed_csv, soundings_csv, trajectory_csv,
};
use boresight::geometry::Ellipsoid;
use boresight::observe::{
    GeodeticTrajectory, LaserCoordinates, LaserNoise, LaserScan, Outside, SonarNoise,
    SoundSpeedProfile, SoundingRange, Soundings, TrajectoryNoise,
};
use proptest::prelude::*;

fn trajectory(rows: &[[f64; 7]], velocity: Option<Vec<[f64; 3]>>) -> GeodeticTrajectory {
    let column = |k: usize| rows.iter().map(|r| r[k]).collect::<Vec<_>>();
    GeodeticTrajectory {
        ellipsoid: Ellipsoid::Wgs84,
        time_s: (0..rows.len())
            .map(|k| 400_000.1 + 0.01 * k as f64)
            .collect(),
        latitude_rad: column(1),
        longitude_rad: column(2),
        height_m: column(3),
        roll_rad: column(4),
        pitch_rad: column(5),
        heading_rad: column(6),
        velocity_m_s: velocity,
        noise: TrajectoryNoise {
            position_m: 0.0,
            position_drift_m: 0.0,
            drift_correlation_time_s: 60.0,
            roll_pitch_rad: 0.0,
            heading_rad: 0.0,
            heading_drift_rad: 0.0,
        },
        max_gap_s: 1.0,
        outside: Outside::Error,
    }
}

fn close(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() <= tolerance)
}

fn turn_close(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.iter().zip(b).all(|(x, y)| {
        let d = (x - y).rem_euclid(TAU);
        d.min(TAU - d) <= tolerance
    })
}

prop_compose! {
    fn row()(lat in -1.5..1.5f64, lon in -3.1..3.1f64, h in -100.0..9000.0f64, r in -1.0..1.0f64, p in -1.0..1.0f64, hd in -3.1..3.1f64) -> [f64; 7] {
        [0.0, lat, lon, h, r, p, hd]
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn trajectory_csv_returns(rows in prop::collection::vec(row(), 1..20), v in prop::array::uniform3(-20.0..20.0f64), with in any::<bool>()) {
        let given = trajectory(&rows, with.then(|| vec![v; rows.len()]));
        let mut bytes = vec![];
        trajectory_csv::write_to(&mut bytes, &given).expect("write");
        let back = trajectory_csv::read_from(Path::new("t.csv"), &bytes[..], bytes.len() as u64, Invalid::Error).expect("read");
        prop_assert_eq!(&back.time_s, &given.time_s);
        // half a unit of the last digit: 5e-13 deg, and 5e-9 deg for the attitude
        prop_assert!(close(&back.latitude_rad, &given.latitude_rad, 1e-14) && close(&back.longitude_rad, &given.longitude_rad, 1e-14));
        prop_assert!(close(&back.height_m, &given.height_m, 5.1e-7));
        prop_assert!(close(&back.roll_rad, &given.roll_rad, 1e-10) && close(&back.pitch_rad, &given.pitch_rad, 1e-10));
        prop_assert!(close(&back.heading_rad, &given.heading_rad, 1e-10));
        prop_assert_eq!(back.velocity_m_s.is_some(), with);
        let same = back.velocity_m_s.unwrap_or_default().iter().all(|b| close(b, &v, 5.1e-7));
        prop_assert!(same);
    }

    #[test]
    fn sbet_returns_through_any_wander(rows in prop::collection::vec(row(), 1..20), v in prop::array::uniform3(-20.0..20.0f64), wander in -3.0..3.0f64) {
        let given = trajectory(&rows, Some(vec![v; rows.len()]));
        let mut bytes = vec![];
        sbet::write_to(&mut bytes, &given, wander).expect("write");
        prop_assert_eq!(bytes.len(), 136 * rows.len());
        let back = sbet::read_from(Path::new("t.out"), &bytes[..], bytes.len() as u64, Invalid::Error).expect("read");
        prop_assert_eq!(&back.time_s, &given.time_s);
        prop_assert_eq!(&back.latitude_rad, &given.latitude_rad);
        prop_assert_eq!(&back.pitch_rad, &given.pitch_rad);
        prop_assert!(turn_close(&back.heading_rad, &given.heading_rad, 1e-14));
        let same = back.velocity_m_s.expect("velocity").iter().all(|b| close(b, &v, 1e-13));
        prop_assert!(same);
    }

    #[test]
    fn laser_points_return(points in prop::collection::vec(prop::array::uniform3(-150.0..150.0f64), 1..300), far in any::<bool>(), compressed in any::<bool>()) {
        let shift = if far { 3.4e6 } else { 0.0 };
        let column = |k: usize| points.iter().map(|p| p[k] + shift).collect::<Vec<_>>();
        let time_s: Vec<f64> = (0..points.len()).map(|k| 1000.0 + k as f64 / 7.0).collect();
        let scan = LaserScan {
            time_s,
            x_m: column(0),
            y_m: column(1),
            z_m: column(2),
            coordinates: LaserCoordinates::Sensor,
            noise: LaserNoise { range_m: 0.0, angle_rad: 0.0, point_m: 0.0 },
        };
        let columns = PointColumns { time_s: &scan.time_s, x_m: &scan.x_m, y_m: &scan.y_m, z_m: &scan.z_m, point_source_id: &[] };
        let bytes = las::write_to(&columns, compressed, None).expect("write");
        let size = bytes.len() as u64;
        let back = las::read_from(Path::new("l.laz"), std::io::Cursor::new(bytes), size, Invalid::Error).expect("read");
        prop_assert_eq!(&back.time_s, &scan.time_s);
        prop_assert!(close(&back.x_m, &scan.x_m, 5.1e-5) && close(&back.y_m, &scan.y_m, 5.1e-5) && close(&back.z_m, &scan.z_m, 5.1e-5));
        let mut text = vec![];
        laser_csv::write_to(&mut text, &scan).expect("write");
        let back = laser_csv::read_from(Path::new("l.csv"), &text[..], text.len() as u64, Invalid::Error).expect("read");
        prop_assert_eq!(&back.time_s, &scan.time_s);
        prop_assert!(close(&back.x_m, &scan.x_m, 5.1e-6) && close(&back.z_m, &scan.z_m, 5.1e-6));
    }

    #[test]
    fn soundings_return(rows in prop::collection::vec((-1.5..1.5f64, -0.5..0.5f64, 0.1..20.0f64), 1..100), times in any::<bool>()) {
        let range: Vec<f64> = rows.iter().map(|r| r.2).collect();
        let given = Soundings {
            time_s: (0..rows.len()).map(|k| 0.1 * k as f64).collect(),
            ping: (0..rows.len() as u32).collect(),
            beam: vec![3; rows.len()],
            across_rad: rows.iter().map(|r| r.0).collect(),
            along_rad: rows.iter().map(|r| r.1).collect(),
            range: if times { SoundingRange::TwoWayTravelTime(range) } else { SoundingRange::Metres(range) },
            noise: SonarNoise { range_m: 0.0, across_rad: 0.0, along_rad: 0.0 },
            arrays: None,
            file: None,
        };
        let mut bytes = vec![];
        soundings_csv::write_to(&mut bytes, &given).expect("write");
        let back = soundings_csv::read_from(Path::new("s.csv"), &bytes[..], bytes.len() as u64, Invalid::Error).expect("read");
        prop_assert_eq!((&back.time_s, &back.ping, &back.beam), (&given.time_s, &given.ping, &given.beam));
        prop_assert!(close(&back.across_rad, &given.across_rad, 1e-9) && close(&back.along_rad, &given.along_rad, 1e-9));
        prop_assert_eq!(matches!(back.range, SoundingRange::TwoWayTravelTime(_)), times);
        let half_digit = if times { 5.1e-10 } else { 5.1e-7 };
        prop_assert!(close(back.range.values(), given.range.values(), half_digit));
    }
}

#[test]
fn files_are_written_whole_and_twice_the_same() {
    let folder = tempfile::tempdir().expect("folder");
    let scan = LaserScan {
        time_s: vec![1.0, 2.0],
        x_m: vec![4.0, 5.0],
        y_m: vec![0.0; 2],
        z_m: vec![1.0, -1.0],
        coordinates: LaserCoordinates::Sensor,
        noise: LaserNoise {
            range_m: 0.0,
            angle_rad: 0.0,
            point_m: 0.0,
        },
    };
    let paths = ["a.laz", "b.laz", "c.las"].map(|name| folder.path().join(name));
    for path in &paths {
        las::write(path, &scan).expect("write");
    }
    let bytes = paths.clone().map(|path| std::fs::read(path).expect("read"));
    assert_eq!(bytes[0], bytes[1]);
    assert_ne!(bytes[0], bytes[2]);
    assert_eq!(
        formats::read_laser(&paths[2], Invalid::Error)
            .expect("las")
            .x_m,
        [4.0, 5.0]
    );
    let nowhere = folder.path().join("missing/l.laz");
    assert_eq!(
        las::write(&nowhere, &scan).expect_err("no folder").kind,
        FaultKind::Unwritable
    );
}

#[test]
fn an_sbet_needs_velocities() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("t.sbet");
    let error = sbet::write(&path, &trajectory(&[[0.0; 7]], None), 0.0).expect_err("no velocity");
    assert!(error.to_string().contains("without velocities") && !path.exists());
}

#[test]
fn a_profile_returns() {
    let given = SoundSpeedProfile {
        depth_m: vec![0.0, 0.1, 7.25],
        speed_m_s: vec![1480.0, 1480.3, 1479.9],
    };
    let mut bytes = vec![];
    sound_speed_csv::write_to(&mut bytes, &given).expect("write");
    let back = sound_speed_csv::read_from(Path::new("p.csv"), &bytes[..], bytes.len() as u64)
        .expect("read");
    assert_eq!(back, given);
}

#[test]
fn columns_come_in_any_order_with_extras_spaces_quotes_and_dos_lines() {
    let text = "\u{feff}Heading_deg, note ,time_s,latitude_deg,longitude_deg,height_m,pitch_deg,roll_deg\r\n\
                90,\"a, b\", 1.5 ,36,120,15,-2,\"3\"\r\n91,,2.5,36,120,15,-2,3\r\n";
    let back = trajectory_csv::read_from(
        Path::new("t.csv"),
        text.as_bytes(),
        text.len() as u64,
        Invalid::Error,
    )
    .expect("read");
    assert_eq!(back.time_s, [1.5, 2.5]);
    assert!((back.heading_rad[0].to_degrees() - 90.0).abs() < 1e-12);
    assert!(
        (back.roll_rad[0].to_degrees() - 3.0).abs() < 1e-12
            && (back.pitch_rad[0].to_degrees() + 2.0).abs() < 1e-12
    );
}

/// A boat that sails a steady course; headings in the file are `heading(course_deg)`.
fn sailing(course_deg: f64, heading: impl Fn(f64) -> f64) -> Result<(), formats::FormatError> {
    let mut text =
        "time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg\n".to_owned();
    let (sin, cos) = course_deg.to_radians().sin_cos();
    for k in 0..50 {
        let step = f64::from(k) * 1e-5;
        text += &format!(
            "{k},{},{},0,0,0,{}\n",
            36.0 + step * cos,
            120.0 + step * sin / 36.0_f64.to_radians().cos(),
            heading(course_deg)
        );
    }
    trajectory_csv::read_from(
        Path::new("t.csv"),
        text.as_bytes(),
        text.len() as u64,
        Invalid::Error,
    )
    .map(|_| ())
}

#[test]
fn headings_in_radians_are_refused_and_small_headings_are_not() {
    let error = sailing(100.0, f64::to_radians).expect_err("radians");
    assert_eq!(error.kind, FaultKind::WrongUnit);
    assert!(
        error.to_string().contains("t.csv: line")
            && error.to_string().contains("column heading_deg"),
        "{error}"
    );
    sailing(100.0, |c| c).expect("degrees");
    sailing(3.0, |c| c).expect("a small heading");
    sailing(183.0, |_| 3.0).expect("astern on a small heading");
}

fn real(file: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("BORESIGHT_DATA") else {
        println!("skipped: BORESIGHT_DATA is not set");
        return None;
    };
    Some(Path::new(&folder).join(file))
}

#[test]
fn a_real_sbet_says_the_same_of_positions_and_velocities() {
    let Some(path) = real("sbet/sbet.out") else {
        return;
    };
    let records = formats::read_trajectory(&path, Invalid::Error).expect("a real SBET");
    assert_eq!(records.len(), 200);
    let velocity = records.velocity_m_s.as_ref().expect("velocities");
    // differenced positions on WGS84 radii; east and north agree with the wander frame's x and west y only with this reading
    let (k, n) = (0, 199);
    let dt = records.time_s[n] - records.time_s[k];
    let latitude = records.latitude_rad[k];
    let (e2, a) = (0.00669438, 6378137.0);
    let w = (1.0 - e2 * latitude.sin().powi(2)).sqrt();
    let height = records.height_m[k];
    let north = (records.latitude_rad[n] - latitude) * (a * (1.0 - e2) / w.powi(3) + height) / dt;
    let east =
        (records.longitude_rad[n] - records.longitude_rad[k]) * (a / w + height) * latitude.cos()
            / dt;
    let mean = |axis: usize| velocity.iter().map(|v| v[axis]).sum::<f64>() / 200.0;
    assert!(
        (mean(1) - north).abs() < 0.02 && (mean(0) - east).abs() < 0.02,
        "{} {north} {} {east}",
        mean(1),
        mean(0)
    );
    assert!((north + 102.6).abs() < 0.1 && (east - 40.68).abs() < 0.1);
}

#[test]
fn a_real_las_that_is_not_in_order_is_sorted_with_a_note() {
    let Some(path) = real("sbet/points.las") else {
        return;
    };
    let records = formats::read_laser(&path, Invalid::Error).expect("swaths of several lines");
    assert!(records.time_s.is_sorted());
    let sorted = |note: &String| note.contains("not in order of time");
    assert!(records.notes.iter().any(sorted), "{:?}", records.notes);
}

#[cfg(not(feature = "parquet"))]
#[test]
fn parquet_left_out_of_the_program_is_said() {
    let path = Path::new("profiles.PARQUET");
    let error = boresight::procedures::rail::formats::read_profiles(path, 2).expect_err("a fault");
    assert_eq!(error.kind, FaultKind::UnknownFormat);
    assert!(error.to_string().contains("--features parquet"), "{error}");
}

/// Bytes that no reader may take for a file of its own: nothing, noise, text, a header without rows.
fn damaged_contents() -> Vec<(&'static str, Vec<u8>)> {
    let noise = (0..4096u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8);
    vec![
        ("nothing", vec![]),
        ("one byte", b"x".to_vec()),
        ("noise", noise.collect()),
        ("words", b"no,such,columns\n1,2,3\n".to_vec()),
        ("zeros", vec![0; 1000]),
    ]
}

#[test]
fn no_reader_of_the_table_takes_what_is_no_file_of_its_own() {
    let folder = tempfile::tempdir().expect("folder");
    for format in crate::common::formats() {
        for extension in format.extensions {
            for (what, bytes) in damaged_contents() {
                let path = folder.path().join(format!("file.{extension}"));
                std::fs::write(&path, [format.magic, &bytes].concat()).expect("written");
                for reader in format.readers {
                    let error = reader.probe(&path);
                    let error = error.expect_err(&format!("{} took {what}", format.name));
                    assert_eq!(*error.file, *path, "{error}");
                    assert!(
                        !error.found.is_empty() && !error.expected.is_empty(),
                        "{error}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_reader_of_the_table_names_a_missing_file_and_a_folder() {
    let folder = tempfile::tempdir().expect("folder");
    let missing = folder.path().join("missing.csv");
    for format in crate::common::formats() {
        for reader in format.readers {
            for path in [folder.path(), &missing] {
                let error = reader.probe(path).expect_err("no file");
                let kinds = [FaultKind::Unreadable, FaultKind::UnknownFormat];
                assert!(kinds.contains(&error.kind), "{}: {error}", format.name);
            }
        }
    }
}

#[test]
fn a_stream_and_an_extension_lead_to_one_format() {
    let all = crate::common::formats();
    for (k, format) in all.iter().enumerate() {
        assert!(!format.readers.is_empty() && !format.extensions.is_empty());
        for other in &all[k + 1..] {
            let same_stream = format
                .readers
                .iter()
                .any(|a| other.readers.iter().any(|b| a.stream() == b.stream()));
            let same_end = format
                .extensions
                .iter()
                .any(|e| other.extensions.contains(e));
            let both = format!("{} and {}", format.name, other.name);
            assert!(!(same_stream && same_end), "{both}");
        }
    }
}

#[test]
fn an_unknown_extension_is_told_by_the_content_or_answered_with_the_table() {
    let folder = tempfile::tempdir().expect("folder");
    let cloud = folder.path().join("cloud.laz");
    let scan = LaserScan {
        time_s: vec![1.0],
        x_m: vec![2.0],
        y_m: vec![3.0],
        z_m: vec![4.0],
        coordinates: LaserCoordinates::Sensor,
        noise: LaserNoise {
            range_m: 0.0,
            angle_rad: 0.0,
            point_m: 0.0,
        },
    };
    las::write(&cloud, &scan).expect("written");
    let renamed = folder.path().join("cloud.points");
    std::fs::copy(&cloud, &renamed).expect("copied");
    assert_eq!(
        formats::read_laser(&renamed, Invalid::Error)
            .expect("a LAZ")
            .time_s,
        [1.0]
    );
    let error = formats::read_trajectory(&renamed, Invalid::Error).expect_err("no trajectory");
    assert_eq!(error.kind, FaultKind::UnknownFormat);
    let said = error.to_string();
    for part in ["a file of format LAS, LAZ", ".out or .sbet (SBET)"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn the_page_of_formats_is_the_table() {
    let page = include_str!("../../docs/formats.md");
    let table = formats::registry::markdown(crate::common::formats().into_iter());
    assert!(
        page.contains(&table),
        "docs/formats.md should hold\n{table}"
    );
}
