//! Recorder files of real instruments, read from the folder that `BORESIGHT_DATA` names; without it every test says that it is
//! skipped. The files are other people's and not in the project; `docs/formats.md` names them.

use std::path::PathBuf;

use boresight::formats::kongsberg_all;
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
    };
    let inner = against_own_solution(&recorded, inner).expect("comparable");
    assert!(inner.rms_m.x > found.rms_m.x && inner.rms_m.y > found.rms_m.y);
}

/// Each sign, and each thing that must not be done twice, makes the agreement worse: the check sees them.
#[test]
fn the_em2040c_line_tells_wrong_readings_from_right_ones() {
    let Some(path) = real(YOLLA) else { return };
    let mut recorded = Recorded::default();
    kongsberg_all::read(&path, &mut recorded).expect("readable");
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
