//! The patent's cosine rules for the signs of the angles, against turns of known sign, for all facings of the planes.

use boresight::geometry::rotation;
use boresight::procedures::pool::config::Variant;
use boresight::procedures::pool::sequential::{Normals, angle_vector_rad};
use nalgebra::Vector3;

const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
const SIGNS: [f64; 2] = [1.0, -1.0];

/// The multibeam's normal when a turn of `sign * 0.01` about `axis` would correct it into `scanner`.
fn seen(scanner: &Vector3<f64>, axis: &Vector3<f64>, sign: f64) -> Vector3<f64> {
    rotation::exp(&(axis * (-0.01 * sign))) * scanner
}

/// Whether the multibeam's cosine with `reference` is smaller than the scanner's.
fn smaller(multibeam: &Vector3<f64>, scanner: &Vector3<f64>, reference: &Vector3<f64>) -> bool {
    multibeam.dot(reference) < scanner.dot(reference)
}

/// Whether a rule "smaller cosine means `sign_if_smaller`" gives the right sign for turns of both signs.
fn rule_holds(
    scanner: &Vector3<f64>,
    axis: &Vector3<f64>,
    reference: &Vector3<f64>,
    sign_if_smaller: f64,
) -> bool {
    SIGNS.iter().all(|sign| {
        let is_smaller = smaller(&seen(scanner, axis, *sign), scanner, reference);
        let given = if is_smaller {
            sign_if_smaller
        } else {
            -sign_if_smaller
        };
        given == *sign
    })
}

/// \[0025\]: a smaller cosine between n2 and (0, 0, 1) means a positive roll; \[0113\]: a negative one.
#[test]
fn roll_0025_is_right_and_0113_wrong_for_normals_towards_the_boat() {
    for x in SIGNS {
        let n2 = Vector3::new(x, 0.0, 0.0);
        let towards_the_boat = x < 0.0;
        assert_eq!(
            rule_holds(&n2, &Vector3::y(), &Vector3::z(), 1.0),
            towards_the_boat,
            "[0025] {x}"
        );
        assert_eq!(
            rule_holds(&n2, &Vector3::y(), &Vector3::z(), -1.0),
            !towards_the_boat,
            "[0113] {x}"
        );
    }
}

/// \[0027\] and \[0115\]: a smaller cosine between n3 and the scanner's n2 means a negative yaw.
#[test]
fn yaw_0027_and_0115_are_right_only_where_n3_looks_towards_minus_y() {
    let n2 = -Vector3::x();
    for x in SIGNS {
        for y in SIGNS {
            let n3 = Vector3::new(x * HALF, y * HALF, 0.0);
            assert_eq!(rule_holds(&n3, &Vector3::z(), &n2, -1.0), y < 0.0, "{n3}");
        }
    }
}

/// \[0029\] and \[0117\]: a smaller cosine between n4 and the scanner's n1 means a positive pitch.
#[test]
fn pitch_0029_and_0117_are_right_with_n2_x_n1_and_wrong_with_n1_x_n2() {
    let n2 = -Vector3::x();
    for x in SIGNS {
        for y in SIGNS {
            let n1 = Vector3::new(x * HALF, y * HALF, 0.0);
            let n4 = n1.cross(&n2).normalize();
            assert!(!rule_holds(&n4, &Vector3::x(), &n1, 1.0), "n1 x n2: {n1}");
            assert!(rule_holds(&-n4, &Vector3::x(), &n1, 1.0), "n2 x n1: {n1}");
        }
    }
}

/// The rule of this program: the component of nM x nL about the axis has the sign of the correction, whatever the facing.
#[test]
fn the_cross_product_is_right_for_every_facing() {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    for (axis, k) in axes.iter().zip(0..) {
        for x in SIGNS {
            for y in SIGNS {
                let upright = [
                    Vector3::new(x * HALF, y * HALF, 0.0),
                    Vector3::new(x, 0.0, 0.0),
                ];
                let level = [Vector3::z() * x, Vector3::z() * y];
                for normal in upright.iter().chain(&level) {
                    if normal.cross(axis).norm() < 0.1 {
                        continue;
                    }
                    for sign in SIGNS {
                        let turn = angle_vector_rad(&seen(normal, axis, sign), normal);
                        assert!(turn[k] * sign > 1e-4, "{axis} {normal} {sign}");
                    }
                }
            }
        }
    }
}

/// \[0029\] and \[0117\] first name P3 for the pitch: P3 does not see pitch by itself (its angle also shows roll and yaw), and
/// \[0020\] defines P4 for it. A pure yaw shows in full at P3 and not at P4.
#[test]
fn p3_for_the_pitch_is_a_slip() {
    let scanner = Normals::new(
        Vector3::new(-HALF, HALF, 0.0),
        -Vector3::x(),
        Vector3::new(-HALF, -HALF, 0.0),
    );
    let yawed = scanner.n.map(|n| seen(&n, &Vector3::z(), 1.0));
    let yawed = Normals::new(yawed[0], yawed[1], yawed[2]);
    let angles = yawed.angles_rad(&scanner);
    assert!((angles[2] - 0.01).abs() < 1e-12 && angles[3] < 1e-12);
    assert!(yawed.correction_rad(&scanner, Variant::Literal).x.abs() < 1e-12);
}
