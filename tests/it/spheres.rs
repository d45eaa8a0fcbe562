//! Real shipborne laser points (CIDCO `LidarToolkit`, spheres and targets in port): their stored coordinates must follow from the
//! stored scanner vectors, attitude, platform position, lever arm and boresight through our georeferencing.
//!
//! The data are not part of the project: `BORESIGHT_DATA` names the folder that holds `spheres/`.

use std::path::{Path, PathBuf};

use boresight::geometry::{Axes, rotation};
use boresight::georef::georeference;
use boresight::observe::{Mounting, PoseSample};
use nalgebra::Vector3;

/// Little-endian doubles per point: 0-2 georeferenced, 3 time, 4-6 scanner vector, 7-9 its sigmas, 10-12 roll, pitch, heading,
/// 13-15 their uncertainty, 16-18 platform, 19-21 its uncertainty.
const COLUMNS: usize = 22;

/// The source's axes: x forward, y left, z up, with the level axes to match. Its rotation is `Rz(-heading) Ry(pitch) Rx(roll)`:
/// heading clockwise as ours, pitch positive bow down, so that only the pitch changes its sign.
const SOURCE: Axes = Axes::ForwardLeftUp;

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = ["passage_1", "passage_2"]
        .iter()
        .flat_map(|passage| std::fs::read_dir(folder.join(passage)).expect("a passage"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_none())
        .collect();
    found.sort();
    found
}

fn points(path: &Path) -> Vec<[f64; COLUMNS]> {
    let bytes = std::fs::read(path).expect("a readable file");
    assert_eq!(bytes.len() % (8 * COLUMNS), 0, "{}", path.display());
    bytes
        .chunks_exact(8 * COLUMNS)
        .map(|record| {
            std::array::from_fn(|k| {
                let double = record[8 * k..8 * k + 8].try_into().expect("eight bytes");
                f64::from_le_bytes(double)
            })
        })
        .collect()
}

fn mounting() -> Mounting {
    let (roll, pitch, heading) = (0.4395f64, -1.8681f64, 0.3992f64);
    Mounting::from_angles(
        roll.to_radians(),
        -pitch.to_radians(),
        heading.to_radians(),
        SOURCE.vector(&Vector3::new(-0.185596, 0.037658, 2.419063)),
    )
}

fn distance_m(point: &[f64; COLUMNS], mounting: &Mounting) -> f64 {
    let triple = |k: usize| Vector3::new(point[k], point[k + 1], point[k + 2]);
    let pose = PoseSample {
        position_m: SOURCE.vector(&triple(16)),
        rotation: rotation::from_attitude(point[10], -point[11], point[12]),
        record: 0,
        weight_before: 1.0,
    };
    let ours = georeference(&pose, mounting, &SOURCE.vector(&triple(4)));
    (SOURCE.vector_back(&ours) - triple(0)).norm()
}

#[test]
fn stored_coordinates_follow_from_stored_observations() {
    let Some(folder) = std::env::var_os("BORESIGHT_DATA") else {
        println!("skipped: BORESIGHT_DATA is not set");
        return;
    };
    let files = files(&Path::new(&folder).join("spheres"));
    assert_eq!(files.len(), 16);
    let all: Vec<_> = files.iter().flat_map(|path| points(path)).collect();
    let worst_m = all.iter().fold(0.0, |worst: f64, point| {
        let distance = distance_m(point, &mounting());
        assert!(distance < 1e-9, "{distance:e} m at {:.6} s", point[3]);
        worst.max(distance)
    });
    println!(
        "{} points of {} files, largest distance {worst_m:.1e} m",
        all.len(),
        files.len()
    );
    let tilted = mounting().corrected(&Vector3::new(1e-9, 0.0, 0.0), &Vector3::zeros());
    assert!(all.iter().any(|point| distance_m(point, &tilted) > 1e-9));
}
