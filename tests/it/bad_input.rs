//! Every bad input of the issue: the message names the file, the place, what was found and what was expected.

use std::path::{Path, PathBuf};

use boresight::formats::Invalid;
use boresight::observe::{LaserCoordinates, LaserNoise};
use boresight::procedures::pool::survey::load;

/// A fault: which fixture, how to spoil its copy, and the pieces of the message that must come.
type Case = (
    &'static str,
    &'static str,
    fn(&Path),
    &'static [&'static str],
);

fn edit(folder: &Path, file: &str, change: impl FnOnce(&str) -> String) {
    let path = folder.join(file);
    let text = std::fs::read_to_string(&path).expect("text");
    let changed = change(&text);
    assert_ne!(text, changed, "nothing changed in {file}");
    std::fs::write(path, changed).expect("write");
}

fn replace(folder: &Path, file: &str, from: &str, to: &str) {
    edit(folder, file, |text| text.replacen(from, to, 1));
}

/// Replaces a field (row from 0 below the header) of a CSV.
fn set(folder: &Path, file: &str, row: usize, field: usize, value: &str) {
    edit(folder, file, |text| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut fields: Vec<&str> = lines[row + 1].split(',').collect();
        fields[field] = value;
        lines[row + 1] = fields.join(",");
        lines.join("\n")
    });
}

fn truncate(folder: &Path, file: &str, keep: usize) {
    let path = folder.join(file);
    let bytes = std::fs::read(&path).expect("bytes");
    assert!(keep < bytes.len());
    std::fs::write(path, &bytes[..keep]).expect("write");
}

fn write(folder: &Path, file: &str, bytes: &[u8]) {
    std::fs::write(folder.join(file), bytes).expect("write");
}

/// Overwrites one double of an SBET.
fn set_sbet(folder: &Path, record: usize, double: usize, value: f64) {
    let path = folder.join("trajectory.out");
    let mut bytes = std::fs::read(&path).expect("bytes");
    let at = record * 136 + double * 8;
    bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    std::fs::write(path, bytes).expect("write");
}

/// Writes `lidar.laz` anew with these times.
fn write_laser(folder: &Path, time_s: &[f64], format: u8) {
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(format).expect("format");
    builder.point_format.is_compressed = true;
    let header = builder.into_header().expect("header");
    let mut writer = las::Writer::from_path(folder.join("lidar.laz"), header).expect("writer");
    for &t in time_s {
        let gps_time = (format != 0).then_some(t);
        let point = las::Point {
            x: 3.0,
            z: 1.0,
            gps_time,
            return_number: 1,
            number_of_returns: 1,
            ..las::Point::default()
        };
        writer.write_point(point).expect("point");
    }
    writer.close().expect("close");
}

#[rustfmt::skip]
const CASES: &[Case] = &[
    ("missing survey", "csv", |f| std::fs::remove_file(f.join("survey.toml")).expect("remove"),
        &["survey.toml: no such file"]),
    ("empty survey", "csv", |f| write(f, "survey.toml", b" \n"),
        &["survey.toml: whole file: found an empty file, expected TOML"]),
    ("no TOML", "csv", |f| replace(f, "survey.toml", "azimuth_deg =", "azimuth_deg"),
        &["survey.toml: line 8", "expected TOML"]),
    ("not UTF-8", "csv", |f| write(f, "survey.toml", b"name = \"\xff\""),
        &["survey.toml: byte 8: found bytes that are not UTF-8"]),
    ("missing trajectory", "csv", |f| std::fs::remove_file(f.join("trajectory.csv")).expect("remove"),
        &["survey.toml: line 12, [trajectory] path: found \"trajectory.csv\", no such file, expected a file, its path"]),
    ("a folder", "csv", |f| replace(f, "survey.toml", "lidar.laz", "../"),
        &["survey.toml: line 20, [lidar] path: found \"../\", a folder"]),
    ("unknown key", "csv", |f| replace(f, "survey.toml", "azimuth_deg", "azimut_deg"),
        &["survey.toml: line 8, [target] azimut_deg: found an unknown key, expected", "(nearest: azimuth_deg)", "line 4, [target] azimuth_deg: found nothing, expected degrees from -360 to 360"]),
    ("key in another unit", "csv", |f| replace(f, "survey.toml", "position_sigma_m = 0.002", "position_sigma_mm = 2"),
        &["[trajectory] position_sigma_mm: found an unknown key", "(nearest: position_sigma_m)"]),
    ("unknown section", "csv", |f| replace(f, "survey.toml", "[lidar]", "[laser]\n[lidar]"),
        &["line 19, laser: found an", "unknown key", "target, trajectory, lidar, multibeam"]),
    ("mistyped section", "csv", |f| replace(f, "survey.toml", "[lidar]", "[lidr]\n[lidar]"),
        &["line 19, lidr: found an", "unknown key", "(nearest: lidar)"]),
    ("two keys at once", "csv", |f| { replace(f, "survey.toml", "azimuth_deg = 30.7", "azimuth_deg = \"30.7\""); replace(f, "survey.toml", "range_sigma_m = 0.01", "range_sigma_m = -1"); },
        &["line 8, [target] azimuth_deg: found \"30.7\", expected degrees", "line 31, [multibeam] range_sigma_m: found -1, expected metres above 0 and up to 1 (is it in millimetres?)"]),
    ("lever arm in millimetres", "csv", |f| replace(f, "survey.toml", "[0.5, -0.2, -1.6]", "[500, -200, -1600]"),
        &["[multibeam] lever_arm_m: found [500, -200, -1600], expected three numbers, each metres from -100 to 100"]),
    ("not a number", "csv", |f| replace(f, "survey.toml", "height_m = 15.08", "height_m = nan"),
        &["line 7, [target] origin.height_m: found nan, expected metres from -12000 to 12000"]),
    ("missing mounting angle", "csv", |f| replace(f, "survey.toml", "roll = -45.000000000, ", ""),
        &["line 30, [multibeam] mounting_deg.roll: found nothing"]),
    ("latitude in the survey", "csv", |f| replace(f, "survey.toml", "latitude_deg = 35.9", "latitude_deg = 95.9"),
        &["[target] origin.latitude_deg: found 95.9", "expected degrees from -90 to 90"]),
    ("word of no list", "csv", |f| replace(f, "survey.toml", "[lidar]", "[joint]\nkernel = \"hubert\"\nhold = [\"lw\"]\n[lidar]"),
        &["[joint] kernel: found \"hubert\", expected one of", "(nearest: \"huber\")", "[joint] hold: found [\"lw\"], expected a list of \"pitch\""]),
    ("another procedure's survey", "csv", |f| replace(f, "survey.toml", "\"pool\"", "\"seabed\""),
        &["survey.toml: line 2, procedure: found \"seabed\", another procedure's survey, expected \"pool\""]),
    ("UTM without zone", "csv", |f| replace(f, "survey.toml", "\"sensor\"", "\"utm\""),
        &["[lidar] utm_zone: found nothing, expected this key with coordinates = \"utm\"", "[lidar] point_sigma_m: found nothing"]),
    ("half a scanner calibration", "csv", |f| replace(f, "survey.toml", "[multibeam]", "lever_arm_sigma_m = [0.001, 0.001, 0.001]\n[multibeam]"),
        &["[lidar] mounting_sigma_deg: found nothing, expected it beside lever_arm_sigma_m"]),
    ("two sound speeds", "csv", |f| replace(f, "survey.toml", "[lidar]", "[sound_speed]\nspeed_m_s = 1500\nprofile = \"multibeam.csv\"\n[lidar]"),
        &["sound_speed: found both speed_m_s and profile, expected one of them"]),
    ("sound speed in km/s", "csv", |f| replace(f, "survey.toml", "[lidar]", "[sound_speed]\nspeed_m_s = 1.48\n[lidar]"),
        &["[sound_speed] speed_m_s: found 1.48, expected a sound speed from 1300 to 1700 m/s"]),
    ("extension", "csv", |f| { write(f, "trajectory.dat", b"x"); replace(f, "survey.toml", "trajectory.csv", "trajectory.dat"); },
        &["trajectory.dat: whole file: found extension \"dat\", some text, expected one of .csv (trajectory CSV), .out or .sbet (SBET)"]),
    ("target key", "csv", |f| replace(f, "target.toml", "block_leg_m", "block_legs_m"),
        &["target.toml: line 5, block_legs_m: found an unknown key", "(nearest: block_leg_m)", "block_leg_m: found nothing"]),
    ("target kind", "csv", |f| replace(f, "target.toml", "pool-wall", "wall"),
        &["target.toml: line 2, kind: found \"wall\", expected one of \"pool-wall\", \"faces\" (nearest: \"pool-wall\")"]),
    ("impossible target", "csv", |f| replace(f, "target.toml", "first_block_minus_y_m = -2.7", "first_block_minus_y_m = -3.7"),
        &["target.toml: dimensions: found first_block_minus_y_m = -3.7, expected at least"]),
    ("empty trajectory", "csv", |f| write(f, "trajectory.csv", b""),
        &["trajectory.csv: whole file: found an empty file, expected a header line with time_s,latitude_deg"]),
    ("header only", "csv", |f| { edit(f, "multibeam.csv", |t| { t.lines().next().expect("header").to_owned() }) },
        &["multibeam.csv: whole file: found a header line and nothing else, expected at least one row"]),
    ("missing column", "csv", |f| replace(f, "trajectory.csv", "heading_deg", "headin_deg"),
        &["trajectory.csv: line 1, column heading_deg: found", "(nearest column: headin_deg), expected a column heading_deg"]),
    ("no range column", "csv", |f| replace(f, "multibeam.csv", "range_m", "ranges_m"),
        &["multibeam.csv: line 1, column range_m or two_way_travel_time_s: found", "(nearest column: ranges_m)"]),
    ("column twice", "csv", |f| replace(f, "trajectory.csv", "roll_deg", "pitch_deg"),
        &["trajectory.csv: line 1, column "]),
    ("no header", "csv", |f| { edit(f, "multibeam.csv", |t| { t.split_once('\n').expect("lines").1.to_owned() }) },
        &["multibeam.csv: line 1, column time_s: found", "(numbers instead of column names)"]),
    ("no separators", "csv", |f| edit(f, "multibeam.csv", |t| t.replace(',', "|")),
        &["multibeam.csv: line 1, column time_s: found", "expected a column time_s"]),
    ("short row", "csv", |f| edit(f, "trajectory.csv", |t| t[..t.len() - 40].to_owned()),
        &["trajectory.csv: line 262: found", "fields", "expected 7 as in the header"]),
    ("NaN", "csv", |f| set(f, "trajectory.csv", 5, 3, "NaN"),
        &["trajectory.csv: line 7, column height_m: found \"NaN\", expected an ellipsoidal height"]),
    ("infinite time", "csv", |f| set(f, "multibeam.csv", 0, 0, "inf"),
        &["multibeam.csv: line 2, column time_s: found \"inf\", expected a finite number"]),
    ("no number", "csv", |f| set(f, "multibeam.csv", 3, 5, "3.4m"),
        &["multibeam.csv: line 5, column range_m: found \"3.4m\", expected a range above 0 m and up to 20000 m (is it in millimetres?)"]),
    ("no whole number", "csv", |f| set(f, "multibeam.csv", 3, 2, "1.5"),
        &["multibeam.csv: line 5, column beam: found \"1.5\", expected a whole number"]),
    ("range of zero", "csv", |f| set(f, "multibeam.csv", 3, 5, "0.0"),
        &["multibeam.csv: line 5, column range_m: found \"0.0\", expected a range above 0 m"]),
    ("range of 21 km", "csv", |f| set(f, "multibeam.csv", 3, 5, "21000"),
        &["multibeam.csv: line 5, column range_m: found \"21000\""]),
    ("latitude", "csv", |f| set(f, "trajectory.csv", 9, 1, "90.1"),
        &["trajectory.csv: line 11, column latitude_deg: found \"90.1\", expected a latitude from -90 to 90 deg"]),
    ("unsorted", "csv", |f| set(f, "trajectory.csv", 9, 0, "1009.95"),
        &["trajectory.csv: line 11, column time_s: found 1009.95 after", "expected strictly ascending times"]),
    ("duplicate", "csv", |f| set(f, "trajectory.csv", 9, 0, "1009.98"),
        &["trajectory.csv: line 11, column time_s: found 1009.98 a second time, expected strictly ascending times"]),
    ("descending soundings", "csv", |f| set(f, "multibeam.csv", 20, 0, "1009.99"),
        &["multibeam.csv: line 22, column time_s: found 1009.99 after", "expected ascending times"]),
    ("positions in radians", "csv", |f| edit(f, "trajectory.csv", radian_positions),
        &["trajectory.csv: first record, latitude and longitude: found 0.628", "which are radians, expected degrees"]),
    ("angles in radians", "csv", |f| write(f, "multibeam.csv", radian_swath().as_bytes()),
        &["multibeam.csv: line", "column across_angle_deg: found angles within 1.222 over pings of up to 64 beams, which are radians, expected degrees"]),
    ("travel times without speed", "csv", |f| replace(f, "multibeam.csv", "range_m", "two_way_travel_time_s"),
        &["multibeam.csv: column two_way_travel_time_s: found travel times, expected a section [sound_speed]"]),
    ("milliseconds", "csv", |f| { replace(f, "multibeam.csv", "range_m", "two_way_travel_time_s"); set(f, "multibeam.csv", 0, 5, "35.2"); },
        &["multibeam.csv: line 2, column two_way_travel_time_s: found \"35.2\"", "seconds, not milliseconds"]),
    ("profile upwards", "csv", |f| { write(f, "p.csv", b"depth_m,sound_speed_m_s\n0,1480\n-2,1481\n"); replace(f, "survey.toml", "[lidar]", "[sound_speed]\nprofile = \"p.csv\"\n[lidar]"); },
        &["p.csv: line 3, column depth_m: found \"-2\", expected a depth from 0 to 12000 m, positive down"]),
    ("empty SBET", "sbet", |f| write(f, "trajectory.out", b""),
        &["trajectory.out: whole file: found an empty file, expected records of 136 bytes"]),
    ("truncated SBET", "sbet", |f| truncate(f, "trajectory.out", 136 * 100 + 40),
        &["trajectory.out: record 100 (byte 13600): found 40 bytes before the end of the file, expected 136: the file is truncated"]),
    ("unsorted SBET", "sbet", |f| set_sbet(f, 7, 0, 1.0),
        &["trajectory.out: record 7 (byte 952): found time 1 after", "expected strictly ascending times"]),
    ("SBET in degrees", "sbet", |f| set_sbet(f, 3, 1, 36.0),
        &["trajectory.out: record 3 (byte 408): found latitude = 36, expected radians within pi/2"]),
    ("NaN in SBET", "sbet", |f| set_sbet(f, 3, 9, f64::NAN),
        &["trajectory.out: record 3 (byte 408): found platform heading = NaN"]),
    ("empty LAZ", "csv", |f| write(f, "lidar.laz", b""),
        &["lidar.laz: whole file: found an empty file, expected a LAS or LAZ file"]),
    ("no LAZ", "csv", |f| write(f, "lidar.laz", b"PK\x03\x04 a zip file"),
        &["lidar.laz: byte 0: found \"PK??\", expected \"LASF\""]),
    ("truncated LAZ", "csv", |f| truncate(f, "lidar.laz", 3000),
        &["lidar.laz: byte", "in a file of 3000 bytes, expected all of it: the file is truncated"]),
    ("LAZ cut within its header", "csv", |f| truncate(f, "lidar.laz", 300),
        &["lidar.laz: byte 0: found the header up to byte 375 in a file of 300 bytes"]),
    ("LAZ without time", "csv", |f| write_laser(f, &[1010.0], 0),
        &["lidar.laz: header: found point format 0, which has no GPS time, expected a point format with GPS time"]),
    ("LAZ without points", "csv", |f| write_laser(f, &[], 6),
        &["lidar.laz: header: found 0 points, expected at least one point"]),
    ("a time that is none in a LAZ", "csv", |f| write_laser(f, &[1010.0, f64::NAN], 6),
        &["lidar.laz: point 1: found time NaN, expected a finite time"]),
    ("wrong frame", "csv", |f| replace(f, "survey.toml", "\"sensor\"", "\"geocentric\"\npoint_sigma_m = 0.01"),
        &["lidar.laz: return 1: found x, y, z = 5.78", "expected 6300 to 6500 km from the earth's centre"]),
    ("no overlap", "csv", |f| replace(f, "survey.toml", "[multibeam]", "[multibeam]\ntime_offset_s = 1000"),
        &["multibeam.csv: times: found times from 2010.000 s to 2012", "expected an overlap with the trajectory, 1009.900 s to 1012.500 s"]),
    ("another week", "csv", |f| replace(f, "survey.toml", "[multibeam]", "[multibeam]\ntime_offset_s = 1209600"),
        &["multibeam.csv: times: found", "time_offset_s = -1209600 would bring it inside, which is whole GPS weeks"]),
    ("Unix time", "csv", |f| replace(f, "survey.toml", "[multibeam]", "[multibeam]\ntime_offset_s = 1425945582"),
        &["multibeam.csv: times: found", "would bring it inside", "UTC"]),
    ("leap seconds", "csv", |f| replace(f, "survey.toml", "[multibeam]", "[multibeam]\ntime_offset_s = -18"),
        &["multibeam.csv: times: found", "time_offset_s = 18 would bring it inside, which is the leap seconds between GPS and UTC"]),
    ("partly outside", "csv", |f| replace(f, "survey.toml", "[multibeam]", "[multibeam]\ntime_offset_s = 1"),
        &["multibeam.csv: times: found an observation at ", "outside the trajectory, 1009.900 s to 1012.500 s", "more without a position; all 98 lie up to 0.833 s after the end of a stretch of the trajectory: the sensor's time stamps look late by 0.833 s", "expected a position for every observation, or outside = \"drop\""]),
    ("two files at once", "csv", |f| { set(f, "trajectory.csv", 0, 1, "x"); set(f, "multibeam.csv", 0, 5, "y"); truncate(f, "lidar.laz", 3000); },
        &["trajectory.csv: line 2", "multibeam.csv: line 2", "lidar.laz: byte"]),
];

/// Latitude and longitude as radians.
fn radian_positions(text: &str) -> String {
    let row = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        for field in &mut fields[1..3] {
            *field = field
                .parse::<f64>()
                .expect("number")
                .to_radians()
                .to_string();
        }
        fields.join(",")
    };
    let (header, rows) = text.split_once('\n').expect("lines");
    let rows: Vec<_> = rows.lines().map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

/// A ping of 64 beams over +-70 deg, in radians.
fn radian_swath() -> String {
    let rows: Vec<_> = (0..64)
        .map(|beam| {
            format!(
                "1010.5,7,{beam},{},0,4.2",
                (-70.0 + f64::from(beam) * 140.0 / 63.0).to_radians()
            )
        })
        .collect();
    format!(
        "time_s,ping,beam,across_angle_deg,along_angle_deg,range_m\n{}\n",
        rows.join("\n")
    )
}

fn copy(name: &str) -> tempfile::TempDir {
    let fixture: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name);
    let folder = tempfile::tempdir().expect("folder");
    for entry in std::fs::read_dir(fixture).expect("fixture") {
        let entry = entry.expect("entry");
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).expect("copy");
    }
    folder
}

#[test]
fn every_bad_input_is_named_with_file_place_found_and_expected() {
    let mut failures = vec![];
    for (name, fixture, spoil, pieces) in CASES {
        let folder = copy(fixture);
        spoil(folder.path());
        let files = std::fs::read_dir(folder.path()).expect("list").count();
        match load(&folder.path().join("survey.toml")) {
            Ok(_) => failures.push(format!("{name}: no error")),
            Err(error) => {
                let message = error.to_string();
                for piece in pieces.iter().filter(|p| !message.contains(**p)) {
                    failures.push(format!("{name}: \"{piece}\" is not in:\n{message}"));
                }
                let complete = |line: &str| {
                    line.ends_with(": no such file")
                        || line.contains(": found ") && line.contains(", expected ")
                };
                if !message.lines().all(complete) {
                    failures.push(format!("{name}: incomplete line in:\n{message}"));
                }
            }
        }
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("list").count(),
            files
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn the_fixtures_themselves_are_good() {
    for name in ["csv", "sbet"] {
        let folder = copy(name);
        load(&folder.path().join("survey.toml")).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

/// Spoils a few rows of each file: a beam without a range, an INS that lost its fix, a return that was none.
fn spoil_a_few(folder: &Path) {
    for row in [3, 70, 150] {
        set(folder, "multibeam.csv", row, 5, "NaN");
    }
    set(folder, "trajectory.csv", 40, 1, "");
}

#[test]
fn rows_that_cannot_be_are_counted_or_left_out() {
    let folder = copy("csv");
    let survey = folder.path().join("survey.toml");
    let good = load(&survey).expect("good").campaign;
    spoil_a_few(folder.path());
    let said = load(&survey).expect_err("faulty rows").to_string();
    assert!(
        said.contains("multibeam.csv: whole file: found 3 faulty rows of "),
        "{said}"
    );
    assert!(
        said.contains("trajectory.csv: whole file: found 1 faulty row of "),
        "{said}"
    );
    let shown = said.lines().filter(|l| l.contains("multibeam.csv: line "));
    assert_eq!(shown.count(), 3, "{said}");

    for section in ["[multibeam]", "[trajectory]"] {
        replace(
            folder.path(),
            "survey.toml",
            section,
            &format!("{section}\ninvalid = \"drop\""),
        );
    }
    let read = load(&survey).expect("a few may be missing");
    assert_eq!(
        read.campaign.soundings.time_s.len(),
        good.soundings.time_s.len() - 3
    );
    assert_eq!(
        read.campaign.trajectory.time_s.len(),
        good.trajectory.time_s.len() - 1
    );
    let kept = |k: &usize| ![3, 70, 150].contains(k);
    let beams: Vec<u32> = (0..good.soundings.beam.len())
        .filter(kept)
        .map(|k| good.soundings.beam[k])
        .collect();
    assert_eq!(
        read.campaign.soundings.beam, beams,
        "the other rows stay together"
    );
    let notes = read.notes.join("\n");
    assert!(
        notes.contains("multibeam.csv: 3 of ") && notes.contains("trajectory.csv: 1 of "),
        "{notes}"
    );
}

#[test]
fn a_return_at_the_scanner_itself_is_none() {
    let folder = copy("csv");
    let mut laser =
        boresight::formats::read_laser(&folder.path().join("lidar.laz"), Invalid::Error)
            .expect("good");
    let returns = laser.len();
    laser.x_m[7] = 0.0;
    (laser.y_m[7], laser.z_m[7]) = (0.0, 0.0);
    let scan = laser.into_scan(
        LaserCoordinates::Sensor,
        LaserNoise {
            range_m: 0.01,
            angle_rad: 1e-4,
            point_m: 0.0,
        },
    );
    let path = folder.path().join("lidar.csv");
    boresight::formats::laser_csv::write(&path, &scan).expect("written");
    boresight::formats::las::write(&folder.path().join("spoilt.laz"), &scan).expect("written");
    for name in ["lidar.csv", "spoilt.laz"] {
        let path = folder.path().join(name);
        let said = boresight::formats::read_laser(&path, Invalid::Error)
            .expect_err("no return")
            .to_string();
        assert!(said.contains("found 0,0,0, expected a return"), "{said}");
        let read = boresight::formats::read_laser(&path, Invalid::Drop).expect("the others");
        assert_eq!(read.len(), returns - 1);
        assert!(read.notes[0].contains("left out"), "{:?}", read.notes);
    }
}
