//! RANSAC on points of a wall, an inclined face, a floor and clutter.

use boresight::geometry::ransac::{
    ExpectedNormal, ExpectedOffset, PlaneSearch, RansacError, find_plane, find_planes,
};
use boresight::stats;
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

const SIGMA_M: f64 = 0.01;

/// `of_wall` points on x = 3, `of_face` on a face at 45 deg, `clutter` anywhere in the box.
fn scene(seed: u64, of_wall: usize, of_face: usize, clutter: usize) -> Vec<Vector3<f64>> {
    let mut random = stats::stream(seed, 7);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut points = vec![];
    for k in 0..of_wall + of_face + clutter {
        let e: f64 = StandardNormal.sample(&mut random);
        let (a, z) = (
            random.random_range(-1.0..1.0),
            random.random_range(-2.0..2.0),
        );
        points.push(if k < of_wall {
            Vector3::new(3.0 + SIGMA_M * e, 4.0 * a, z)
        } else if k < of_wall + of_face {
            Vector3::new(2.0, -5.0, 0.0)
                + Vector3::new(half, half, 0.0) * a
                + Vector3::new(-half, half, 0.0) * (SIGMA_M * e)
                + Vector3::z() * z
        } else {
            Vector3::new(random.random_range(-3.0..5.0), 6.0 * a, z)
        });
    }
    points
}

#[test]
fn seventy_percent_outliers_among_a_hundred_thousand() {
    for seed in 1..=20 {
        let points = scene(seed, 30_000, 0, 70_000);
        let found = find_plane(
            &points,
            &PlaneSearch {
                seed,
                ..PlaneSearch::default()
            },
        )
        .expect("the wall");
        let plane = found.fit.plane.towards(&-Vector3::x());
        let off = plane.distance_m(&Vector3::new(3.0, 0.0, 0.0));
        // 2 % of the clutter lies within the tolerance, evenly on both sides
        assert!(off.abs() < 0.001, "seed {seed}: {off} m");
        assert!(
            (plane.normal + Vector3::x()).norm() < 0.001,
            "seed {seed}: {}",
            plane.normal
        );
        let of_wall = found.inliers.iter().filter(|k| **k < 30_000).count();
        assert!(of_wall > 29_800, "seed {seed}: {of_wall}");
    }
}

#[test]
fn same_seed_same_plane() {
    let points = scene(1, 3000, 1000, 5000);
    let search = PlaneSearch::default();
    assert_eq!(find_plane(&points, &search), find_plane(&points, &search));
}

#[test]
fn constraints_choose_the_smaller_plane() {
    let points = scene(2, 20_000, 1500, 10_000);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let normal = Vector3::new(-half, half, 0.0);
    let search = PlaneSearch {
        normal: Some(ExpectedNormal {
            normal,
            within_rad: 0.2,
        }),
        ..PlaneSearch::default()
    };
    let found = find_plane(&points, &search).expect("the inclined face");
    assert!(
        (found.fit.plane.normal - normal).norm() < 0.005,
        "{}",
        found.fit.plane.normal
    );
    assert!(
        found
            .inliers
            .iter()
            .filter(|k| (20_000..21_500).contains(*k))
            .count()
            > 1450
    );
    let at = Vector3::new(2.0, -5.0, 0.0);
    let with_offset = |low_m, high_m| PlaneSearch {
        offset: Some(ExpectedOffset {
            at_m: at,
            low_m,
            high_m,
        }),
        ..search
    };
    assert!(find_plane(&points, &with_offset(-0.1, 0.1)).is_ok());
    // the plane is 1 m behind this place along its normal
    let shifted = PlaneSearch {
        offset: Some(ExpectedOffset {
            at_m: at + normal,
            low_m: -1.1,
            high_m: -0.9,
        }),
        ..search
    };
    assert!(find_plane(&points, &shifted).is_ok());
    let elsewhere = find_plane(
        &points,
        &PlaneSearch {
            least_inliers: 1000,
            ..with_offset(0.3, 0.8)
        },
    );
    assert!(matches!(elsewhere, Err(RansacError::NoConsensus { .. })));
}

#[test]
fn planes_come_one_after_the_other_without_sharing_points() {
    let points = scene(3, 10_000, 4000, 2000);
    let planes = find_planes(
        &points,
        &PlaneSearch {
            least_inliers: 1000,
            ..PlaneSearch::default()
        },
        5,
    );
    assert_eq!(planes.len(), 2);
    assert!(planes[0].fit.plane.normal.x.abs() > 0.999);
    assert!((planes[1].fit.plane.normal.x.abs() - std::f64::consts::FRAC_1_SQRT_2).abs() < 0.01);
    assert!(
        planes[0]
            .inliers
            .iter()
            .all(|k| planes[1].inliers.binary_search(k).is_err())
    );
}

#[test]
fn no_plane_in_clutter_and_none_among_two_points() {
    let search = PlaneSearch {
        least_inliers: 1000,
        ..PlaneSearch::default()
    };
    let clutter = find_plane(&scene(4, 0, 0, 5000), &search);
    assert!(
        matches!(clutter, Err(RansacError::NoConsensus { points: 5000, .. })),
        "{clutter:?}"
    );
    let two = find_plane(&[Vector3::zeros(), Vector3::x()], &search);
    assert_eq!(
        two,
        Err(RansacError::TooFew {
            found: 2,
            expected: 1000
        })
    );
}
