//! Rays against solutions that are not ours: numerical integration (`tests/recipes/rays.py`), circles, reciprocity.

use boresight::geometry::rotation;
use boresight::georef::{Beam, Launch, Layers, RayError, Water, georeference};
use boresight::observe::{Mounting, PoseSample, SoundSpeed, SoundSpeedProfile};
use nalgebra::Vector3;
use proptest::prelude::*;
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn profile(value: &Value) -> SoundSpeedProfile {
    let column = |name: &str| {
        value[name]
            .as_array()
            .expect("a column")
            .iter()
            .map(number)
            .collect()
    };
    SoundSpeedProfile {
        depth_m: column("depth_m"),
        speed_m_s: column("speed_m_s"),
    }
}

fn of(depth_m: &[f64], speed_m_s: &[f64]) -> SoundSpeedProfile {
    SoundSpeedProfile {
        depth_m: depth_m.to_vec(),
        speed_m_s: speed_m_s.to_vec(),
    }
}

fn angle(degrees: f64) -> (f64, f64) {
    degrees.to_radians().sin_cos()
}

#[test]
fn rays_agree_with_numerical_integration() {
    let reference: Value =
        serde_json::from_str(include_str!("../reference/rays.json")).expect("JSON");
    let (mut worst_m, mut surfaced) = (0.0f64, 0);
    for row in reference["rays"].as_array().expect("rays") {
        let name = row["profile"].as_str().expect("a name");
        let layers = Layers::new(&profile(&reference["profiles"][name])).expect("a profile");
        let launch = angle(number(&row["launch_deg"]));
        let traced = layers.trace(number(&row["depth_m"]), launch, number(&row["one_way_s"]));
        if row["end"].is_null() {
            assert!(
                matches!(traced, Err(RayError::Surface { .. })),
                "{row}: {traced:?}"
            );
            surfaced += 1;
            continue;
        }
        let end = traced.unwrap_or_else(|fault| panic!("{row}: {fault}"));
        let dx = end.horizontal_m - number(&row["end"]["horizontal_m"]);
        let dz = end.descent_m - number(&row["end"]["descent_m"]);
        worst_m = worst_m.max(dx.hypot(dz));
        assert!(dx.hypot(dz) < 1e-9, "{row}: off by {dx:e}, {dz:e} m");
    }
    assert!(surfaced >= 3);
    println!("largest distance from the numerical integration: {worst_m:.1e} m");
}

/// In one layer the ray is a circle about the depth where the extrapolated speed is zero; the angle is that of the closed form.
#[test]
fn a_linear_gradient_gives_a_circle() {
    let (c0, g) = (1450.0, 0.5);
    let layers = Layers::new(&of(&[0.0, 1000.0], &[c0, c0 + g * 1000.0])).expect("a profile");
    let begin_m = 30.0;
    for degrees in [1.0, 30.0, 60.0, 80.0, 86.0, 89.0] {
        let theta = f64::to_radians(degrees);
        let speed = c0 + g * begin_m;
        let radius = speed / (g * theta.sin());
        let centre = (radius * theta.cos(), -c0 / g - begin_m);
        for time_s in [0.001, 0.02, 0.2] {
            let end = layers
                .trace(begin_m, theta.sin_cos(), time_s)
                .expect("in the water");
            let distance = (end.horizontal_m - centre.0).hypot(end.descent_m - centre.1);
            assert!(
                (distance - radius).abs() < 1e-14 * radius.max(1e5),
                "{degrees} {time_s}"
            );
            let turned = 2.0 * ((0.5 * theta).tan() * (g * time_s).exp()).atan();
            let closed = radius * (theta.cos() - turned.cos());
            assert!(
                (end.horizontal_m - closed).abs() < 2e-9,
                "{degrees} {time_s}"
            );
        }
    }
}

/// A ray turning in its layer comes back to its depth after `2 artanh(cos) / g`.
#[test]
fn a_turning_ray_returns_to_its_depth() {
    let layers = Layers::new(&of(&[0.0, 50.0], &[1450.0, 1475.0])).expect("a profile");
    let theta = f64::to_radians(86.0);
    let time_s = 2.0 * theta.cos().atanh() / 0.5;
    let speed = 1450.0 + 0.5 * 20.0;
    for late in [-1e-9, 1e-9] {
        let end = layers
            .trace(20.0, theta.sin_cos(), time_s + late)
            .expect("in the water");
        assert!((end.descent_m + late * speed * theta.cos()).abs() < 1e-9);
    }
}

#[test]
fn tiny_gradients_join_the_straight_line() {
    for gradient in [0.0, 1e-16, 1e-13, 1e-10, 1e-7] {
        let speeds = [1500.0, 1500.0 + 10.0 * gradient, 1500.0 + 20.0 * gradient];
        let layers = Layers::new(&of(&[0.0, 10.0, 20.0], &speeds)).expect("a profile");
        for degrees in [0.0, 1e-7, 45.0, 89.0, 91.0, 135.0, 180.0] {
            let (sine, cosine) = angle(degrees);
            let end = layers
                .trace(9.0, (sine, cosine), 0.005)
                .expect("in the water");
            let away = (end.horizontal_m - 7.5 * sine).hypot(end.descent_m - 7.5 * cosine);
            assert!(
                away < 1e-12 + 1e-1 * gradient,
                "{gradient} {degrees}: {away:e}"
            );
        }
    }
}

#[test]
fn the_surface_ends_a_ray_and_says_when() {
    let layers = Layers::new(&of(&[0.0, 5.0], &[1480.0, 1480.0])).expect("a profile");
    match layers.trace(3.0, angle(120.0), 0.1) {
        Err(RayError::Surface { one_way_s, limit_s }) => {
            assert!((one_way_s - 6.0 / 1480.0).abs() < 1e-12 && limit_s == 0.1);
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        layers.trace(0.0, angle(90.5), 0.01),
        Err(RayError::Surface { .. })
    ));
    assert!(layers.trace(0.0, angle(90.0), 0.01).is_ok());
    assert!(matches!(
        layers.trace(-0.2, angle(10.0), 0.01),
        Err(RayError::AboveWater { height_m }) if height_m == 0.2
    ));
    assert!(layers.trace(1.0, angle(10.0), f64::NAN).is_err());
    assert!(layers.trace(1.0, (f64::NAN, 1.0), 0.1).is_err());
    assert!(layers.trace(1.0, angle(10.0), -0.1).is_err());
}

#[test]
fn a_profile_that_cannot_be_used_is_refused_by_row() {
    for (depths, speeds, bad) in [
        (vec![], vec![], 0),
        (vec![0.0, 1.0], vec![1500.0], 0),
        (vec![0.0, 2.0, 2.0], vec![1500.0; 3], 2),
        (vec![0.0, f64::NAN], vec![1500.0; 2], 1),
        (vec![-1.0, 3.0], vec![1500.0; 2], 0),
        (vec![0.0, 1.0], vec![1500.0, 0.0], 1),
    ] {
        let fault = Layers::new(&of(&depths, &speeds));
        assert!(
            matches!(fault, Err(RayError::Profile { row, .. }) if row == bad),
            "{fault:?}"
        );
    }
}

fn pose() -> PoseSample {
    PoseSample {
        position_m: Vector3::new(-6.0, 1.5, 1.2),
        rotation: rotation::from_attitude(0.05, -0.03, 1.3),
        record: 0,
        weight_before: 1.0,
    }
}

fn mounting() -> Mounting {
    Mounting::from_angles(-0.7, 0.02, 0.01, Vector3::new(0.3, -0.1, -1.9))
}

#[test]
fn a_constant_speed_keeps_the_angles() {
    let water = Water::new(&SoundSpeed::Constant(1480.0), 0.0).expect("a speed");
    let launch = Launch {
        across_rad: -0.4,
        along_rad: 0.1,
        two_way_s: 0.01,
    };
    let beam = water
        .refract(&launch, &pose(), &mounting())
        .expect("a beam");
    let straight = Beam {
        range_m: 7.4,
        across_rad: -0.4,
        along_rad: 0.1,
    };
    assert!((beam.range_m - straight.range_m).abs() < 1e-15);
    assert_eq!(
        (beam.across_rad, beam.along_rad),
        (straight.across_rad, straight.along_rad)
    );
}

/// A profile of one speed must give the same beam as that speed, through attitude, mounting and back, also upwards.
#[test]
fn a_flat_profile_is_a_constant_speed() {
    let flat = SoundSpeed::Profile(of(&[0.0, 1.0, 4.0], &[1480.0; 3]));
    let water = Water::new(&flat, 0.4).expect("a profile");
    for across_rad in [-1.2, -0.2, 0.0, 0.6, 1.0] {
        let launch = Launch {
            across_rad,
            along_rad: -0.05,
            two_way_s: 0.001,
        };
        let beam = water
            .refract(&launch, &pose(), &mounting())
            .expect("a beam");
        assert!((beam.range_m - 0.74).abs() < 1e-14);
        assert!((beam.across_rad - across_rad).abs() < 1e-14);
        assert!((beam.along_rad + 0.05).abs() < 1e-14);
    }
}

/// Georeferencing the equivalent beam gives the traced end: in the launch's vertical plane, at the traced depth.
#[test]
fn the_equivalent_beam_ends_where_the_ray_ends() {
    let bent = of(&[0.0, 2.0, 6.0], &[1495.0, 1490.0, 1460.0]);
    let level_m = 0.4;
    let water = Water::new(&SoundSpeed::Profile(bent.clone()), level_m).expect("a profile");
    let launch = Launch {
        across_rad: 0.9,
        along_rad: 0.2,
        two_way_s: 0.016,
    };
    let beam = water
        .refract(&launch, &pose(), &mounting())
        .expect("a beam");
    let begin = georeference(&pose(), &mounting(), &Vector3::zeros());
    let end = georeference(&pose(), &mounting(), &beam.vector_m()) - begin;
    let unit = Beam {
        range_m: 1.0,
        across_rad: 0.9,
        along_rad: 0.2,
    };
    let d = georeference(&pose(), &mounting(), &unit.vector_m()) - begin;
    let sine = d.x.hypot(d.y);
    let ray = Layers::new(&bent).expect("a profile");
    let traced = ray
        .trace(level_m - begin.z, (sine, -d.z), 0.008)
        .expect("in the water");
    assert!(
        (end.x * d.y - end.y * d.x).abs() < 1e-13,
        "leaves its vertical plane"
    );
    assert!((end.x.hypot(end.y) - traced.horizontal_m).abs() < 1e-12);
    assert!((end.z + traced.descent_m).abs() < 1e-12);
    let bending = (end - d * beam.range_m).norm();
    assert!(bending > 1e-3, "the profile bends by {bending} m");
}

proptest! {
    /// Reciprocity: sent back from its end against its arrival direction, a ray returns to its begin in the same time.
    #[test]
    fn a_ray_finds_its_way_back(
        speeds in proptest::collection::vec(1440.0..1540.0f64, 8),
        begin_m in 5.0..35.0f64,
        degrees in 0.0..120.0f64,
        time_s in 1e-4..0.03f64,
    ) {
        let depths: Vec<f64> = (0..8).map(|k| f64::from(k) * 5.0).collect();
        let layers = Layers::new(&of(&depths, &speeds)).expect("a profile");
        let launch = angle(degrees);
        let Ok(end) = layers.trace(begin_m, launch, time_s) else { return Ok(()) };
        // arrival direction from Snell; its sign from a slightly longer ray
        let Ok(later) = layers.trace(begin_m, launch, time_s * (1.0 + 1e-6)) else { return Ok(()) };
        let ratio = layers.speed_m_s(begin_m + end.descent_m) / layers.speed_m_s(begin_m);
        let sine = launch.0 * ratio;
        prop_assume!(sine < 0.999);
        let cosine = (1.0 - sine * sine).sqrt().copysign(end.descent_m - later.descent_m);
        let back = layers.trace(begin_m + end.descent_m, (sine, cosine), time_s).expect("the same way");
        prop_assert!((back.descent_m + end.descent_m).abs() < 1e-9);
        prop_assert!((back.horizontal_m - end.horizontal_m).abs() < 1e-9);
    }
}
