//! Recorder files of real instruments, read from the folder that `BORESIGHT_DATA` names; without it every test says that it is
//! skipped. The files are other people's and not in the project; `docs/recorders.md` says which.

use std::path::PathBuf;

use boresight::formats::{kmall, kongsberg_all, novatel, xtf};
use boresight::geometry::rotation::from_attitude;
use boresight::georef::{ArrayPair, Layers};
use boresight::observe::SoundSpeedProfile;
use boresight::recorders::{Choice, Recorded, against_own_solution};

/// A file of the folder, or `None` with a word on standard error.
fn real(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("BORESIGHT_DATA") else {
        eprintln!("skipped: BORESIGHT_DATA is not set");
        return None;
    };
    let path = PathBuf::from(folder).join(name);
    assert!(path.exists(), "{} is not there", path.display());
    Some(path)
}

const YOLLA: &str = "kongsberg/0001_20140213_052736_Yolla.all";

#[test]
fn the_em2040c_line_agrees_with_its_own_solution() {
    let Some(path) = real(YOLLA) else { return };
    let mut recorded = Recorded::default();
    let summary = kongsberg_all::read(&path, &mut recorded).expect("readable");
    assert!(!summary.losses.any(), "{:?}", summary.losses);
    assert_eq!(recorded.attitude.len(), 1012);
    assert_eq!((recorded.pings.len(), recorded.solutions.len()), (183, 183));
    let found = against_own_solution(&recorded, Choice::default()).expect("comparable");
    assert!(found.pings > 170 && found.beams > 60_000, "{found:?}");
    assert!(found.mean_m.amax() < 0.015, "{found:?}");
    assert!(found.rms_m.amax() < 0.030, "{found:?}");
    let inner = Choice {
        inner_offsets: true,
        ..Choice::default()
    };
    let inner = against_own_solution(&recorded, inner).expect("comparable");
    assert!(inner.rms_m.norm() < found.rms_m.norm());
    assert!(inner.rms_m.z < 0.7 * found.rms_m.z, "{inner:?} {found:?}");
}

/// Each sign, and each thing that must not be done twice, makes the agreement worse: the check sees them.
#[test]
fn the_em2040c_line_tells_wrong_readings_from_right_ones() {
    let Some(path) = real(YOLLA) else { return };
    let mut recorded = Recorded::default();
    kongsberg_all::read(&path, &mut recorded).expect("readable");
    recorded.pings.truncate(30);
    let right = against_own_solution(&recorded, Choice::default()).expect("comparable");
    let rms = |spoil: &dyn Fn(&mut Recorded)| {
        let mut spoilt = recorded.clone();
        spoil(&mut spoilt);
        let found = against_own_solution(&spoilt, Choice::default()).expect("comparable");
        found.rms_m.norm()
    };
    let right = right.rms_m.norm();
    let reversed_tilt = rms(&|r| {
        let sectors = r.pings.iter_mut().flat_map(|p| &mut p.sectors);
        sectors.for_each(|s| s.tilt_rad = -s.tilt_rad);
    });
    let reversed_angle = rms(&|r| {
        let beams = r.pings.iter_mut().flat_map(|p| &mut p.beams);
        beams.for_each(|b| b.angle_rad = -b.angle_rad);
    });
    let turned_again = rms(&|r| {
        for a in &mut r.attitude {
            a.roll_rad += (-0.17f64).to_radians();
            a.pitch_rad += (-0.50f64).to_radians();
        }
    });
    let without_heading = rms(&|r| {
        let arrays = r.installations.iter_mut().flat_map(|i| &mut i.arrays);
        arrays.for_each(|a| a.mounted.mounting.rotation.fill_with_identity());
    });
    assert!(reversed_tilt > 10.0 * right, "{reversed_tilt} {right}");
    assert!(reversed_angle > 10.0 * right, "{reversed_angle} {right}");
    assert!(turned_again > 2.0 * right, "{turned_again} {right}");
    assert!(without_heading > 1.5 * right, "{without_heading} {right}");
}

/// What the one kmall ping does not say, and the test therefore fits: pitch and heading of the transmit array, roll and heading of the
/// receive array (against the vessel's heading), the arrays' place right and forward, and a factor of the sound speed.
type Unsaid = nalgebra::SVector<f64, 7>;

/// Our points of a ping in right, forward, up of the vessel's heading.
fn points(recorded: &Recorded, unsaid: &Unsaid) -> Vec<nalgebra::Vector3<f64>> {
    let (ping, own) = (&recorded.pings[0], &recorded.solutions[0]);
    let pair = ArrayPair {
        attitude_at_transmission: nalgebra::Matrix3::identity(),
        attitude_at_reception: nalgebra::Matrix3::identity(),
        transmitter: from_attitude(0.0, unsaid[0], unsaid[1]),
        receiver: from_attitude(unsaid[2], 0.0, unsaid[3]),
    };
    let water = Layers::new(&SoundSpeedProfile {
        depth_m: vec![0.0],
        speed_m_s: vec![ping.head_speed_m_s * (1.0 + unsaid[6])],
    })
    .expect("a profile");
    let array_m =
        nalgebra::Vector3::new(unsaid[4], unsaid[5], own.water_line_m - own.array_depth_m);
    let both = ping.beams.iter().zip(&own.points);
    both.filter(|(beam, point)| beam.valid && point.valid)
        .map(|(beam, _)| {
            let sector = &ping.sectors[usize::from(beam.sector)];
            let direction = pair
                .direction(sector.tilt_rad, beam.angle_rad)
                .expect("a beam");
            let launch = (direction, ping.head_speed_m_s);
            let chord = water.chord(own.array_depth_m, launch, 0.5 * beam.two_way_s);
            array_m + chord.expect("a ray")
        })
        .collect()
}

fn differences(recorded: &Recorded, unsaid: &Unsaid) -> Vec<nalgebra::Vector3<f64>> {
    let theirs = recorded.solutions[0].points.iter();
    let valid = theirs.filter(|p| p.valid).map(|p| p.right_forward_up_m);
    let ours = points(recorded, unsaid);
    ours.iter().zip(valid).map(|(a, b)| a - b).collect()
}

/// Gauss-Newton with differences for derivatives.
fn fitted(recorded: &Recorded) -> Vec<nalgebra::Vector3<f64>> {
    let mut unsaid = Unsaid::zeros();
    for _ in 0..8 {
        let now = differences(recorded, &unsaid);
        let mut normal = nalgebra::SMatrix::<f64, 7, 7>::zeros();
        let mut right = Unsaid::zeros();
        let slopes: Vec<Vec<nalgebra::Vector3<f64>>> = (0..7)
            .map(|k| {
                let mut moved = unsaid;
                moved[k] += 1e-6;
                let then = differences(recorded, &moved);
                then.iter().zip(&now).map(|(a, b)| (a - b) / 1e-6).collect()
            })
            .collect();
        for (beam, difference) in now.iter().enumerate() {
            for i in 0..7 {
                right[i] -= slopes[i][beam].dot(difference);
                for j in 0..7 {
                    normal[(i, j)] += slopes[i][beam].dot(&slopes[j][beam]);
                }
            }
        }
        unsaid += normal.lu().solve(&right).expect("determined");
    }
    differences(recorded, &unsaid)
}

fn rms(differences: &[nalgebra::Vector3<f64>]) -> nalgebra::Vector3<f64> {
    let squares = differences.iter().map(|d| d.component_mul(d));
    let sum: nalgebra::Vector3<f64> = squares.sum();
    (sum / differences.len() as f64).map(f64::sqrt)
}

#[test]
fn the_kmall_ping_agrees_with_its_own_solution() {
    let Some(path) = real("kmall/MRZ_versionF.kmall") else {
        return;
    };
    let mut recorded = Recorded::default();
    let summary = kmall::read(&path, &mut recorded).expect("readable");
    assert!(!summary.losses.any(), "{:?}", summary.losses);
    let ping = &recorded.pings[0];
    assert_eq!((ping.sectors.len(), ping.beams.len()), (3, 400));
    let left = rms(&fitted(&recorded));
    eprintln!("kmall ping: rms right, forward, up {left:?} m");
    assert!(left.amax() < 0.015, "{left:?}");
    let mut reversed = recorded.clone();
    let sectors = reversed.pings.iter_mut().flat_map(|p| &mut p.sectors);
    sectors.for_each(|s| s.tilt_rad = -s.tilt_rad);
    assert!(rms(&fitted(&reversed)).amax() > 0.05);
}

#[test]
fn the_r2sonic_line_is_read_and_its_roll_belongs_to_its_angles() {
    let Some(path) = real("r2sonic/0009-150708-R2Testing-0001.xtf") else {
        return;
    };
    let mut recorded = Recorded::default();
    let summary = xtf::read(&path, &mut recorded).expect("readable");
    assert!(!summary.losses.any(), "{:?}", summary.losses);
    assert!(summary.device.starts_with("R2Sonic 2026"));
    assert_eq!((recorded.pings.len(), recorded.attitude.len()), (923, 1203));
    assert_eq!(recorded.positions.len(), 1204);
    assert!(recorded.pings.iter().all(|p| p.beams.len() == 256));
    let track = recorded.attitude_over_time(1.0);
    let slopes = |sign: f64| -> Vec<f64> {
        let pings = recorded.pings.iter().filter_map(|ping| {
            let pose = track.pose_at(ping.time_s).ok()?;
            let roll_rad = sign * boresight::geometry::rotation::to_attitude(&pose.rotation).0;
            Some(slope_of_the_bed(ping, roll_rad))
        });
        pings.collect()
    };
    let spread = |slopes: Vec<f64>| {
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        let squares = slopes.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>();
        (squares / slopes.len() as f64).sqrt()
    };
    let (applied, reversed, none) = (
        spread(slopes(1.0)),
        spread(slopes(-1.0)),
        spread(slopes(0.0)),
    );
    eprintln!("slope of the bed, spread: {applied} with roll, {none} without, {reversed} reversed");
    assert!(applied < 0.5 * none && none < reversed);
}

/// Slope to starboard of a line through a ping's points, every beam turned by the roll.
fn slope_of_the_bed(ping: &boresight::formats::recorder::Ping, roll_rad: f64) -> f64 {
    let points = ping
        .beams
        .iter()
        .filter(|b| b.valid && b.angle_rad.abs() < 0.8)
        .map(|b| {
            // starboard down turns a beam to starboard towards the vertical
            let (sin, cos) = (b.angle_rad - roll_rad).sin_cos();
            let range_m = 0.5 * ping.head_speed_m_s * b.two_way_s;
            (range_m * sin, -range_m * cos)
        });
    let (mut n, mut x, mut z, mut xx, mut xz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (across, up) in points {
        n += 1.0;
        x += across;
        z += up;
        xx += across * across;
        xz += across * up;
    }
    (n * xz - x * z) / (n * xx - x * x)
}

#[test]
fn the_novatel_logs_are_read_message_by_message() {
    let Some(path) = real("novatel/ins2.gps") else {
        return;
    };
    let mut recorded = Recorded::default();
    let summary = novatel::read(&path, &mut recorded).expect("readable");
    assert_eq!(summary.losses.bad_checksums, 0);
    assert_eq!(
        (summary.records["INSPVAS"], summary.records["INSPVAX"]),
        (62, 6)
    );
    assert_eq!(
        summary.losses.not_good, 68,
        "the antenna stands still: not aligned yet"
    );
    assert!(recorded.positions.is_empty() && recorded.attitude.is_empty());
    let Some(all) = real("novatel/advanceddecoder_alllogs.BIN") else {
        return;
    };
    let summary = novatel::read(&all, &mut Recorded::default()).expect("readable");
    // somebody's transfer made CR LF of each LF in this file: its damaged messages fail their checksum, the others are all found
    assert_eq!(summary.losses.bad_checksums, 78, "{:?}", summary.losses);
    assert_eq!(summary.records.values().sum::<u64>(), 563);
}
