//! Ray casting against hits worked out by hand, and the culling against casting at everything.

use boresight::observe::Mounting;
use boresight::simulate::fan::{Fan, SensorPose, Slack};
use boresight::simulate::motion::Motion;
use boresight::simulate::scenario::BodyModel;
use boresight::simulate::scene::{Ray, Scene, Surface};
use boresight::simulate::{DEMO, START_S, Scenario};
use boresight::target::Target;
use nalgebra::Vector3;

fn scenario() -> Scenario {
    Scenario::from_toml(DEMO).expect("the embedded scenario")
}

fn scene_of(scenario: &Scenario) -> (Target, Scene) {
    let target = Target::from_model(&scenario.target.model).expect("a target");
    let exact = vec![0.0; target.offsets.len()];
    let scene = Scene::new(scenario, &target, &exact, START_S);
    (target, scene)
}

fn hit(scenario: &Scenario, from: [f64; 3], to: [f64; 3]) -> (f64, f64, String) {
    let (target, scene) = scene_of(scenario);
    let (from, to) = (Vector3::from(from), Vector3::from(to));
    let ray = Ray {
        origin_m: from,
        direction: (to - from).normalize(),
    };
    let hit = scene.nearest_of_all(&ray, START_S).expect("a hit");
    let name = match hit.surface {
        Surface::Face(k) => target.faces[k].name.clone(),
        other => format!("{other:?}"),
    };
    (hit.range_m, hit.cosine, name)
}

/// a = 8, c = 3, e = 1, first blocks at -3.8 (-Y) and -2.8 (+Y): corners by hand.
#[test]
fn rays_end_where_the_hand_says() {
    let s = scenario();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // square onto the wall
    let (range, cosine, name) = hit(&s, [-6.0, 1.0, 0.5], [0.0, 1.0, 0.5]);
    assert!((range - 6.0).abs() < 1e-12 && (cosine - 1.0).abs() < 1e-12 && name == "wall");
    // straight along +X at y = -5: 1 m outside the column's begin, so the 45 deg face stands at x = -1
    let (range, cosine, name) = hit(&s, [-6.0, -5.0, -3.3], [0.0, -5.0, -3.3]);
    assert!((range - 5.0).abs() < 1e-12 && (cosine - half).abs() < 1e-12);
    assert_eq!(name, "-Y block 1 inclined");
    // between two blocks of that column: -2.8 to -1.8, the wall behind
    let (range, _, name) = hit(&s, [-6.0, -5.0, -2.3], [0.0, -5.0, -2.3]);
    assert!(
        (range - 6.0).abs() < 1e-12 && name.starts_with("wall -Y"),
        "{name}"
    );
    // steeply down onto the top of the lowest block at +Y (z = -1.8), 0.5 m inside its outer edge
    let (range, cosine, name) = hit(&s, [-1.5, 6.5, -1.0], [-1.5, 6.5, -4.0]);
    assert!((range - 0.8).abs() < 1e-12 && (cosine - 1.0).abs() < 1e-12);
    assert_eq!(name, "+Y block 1 top");
    // beside that block, the floor
    let (range, _, name) = hit(&s, [-6.0, 0.0, -1.0], [-6.0, 0.0, -4.0]);
    assert!((range - 3.5).abs() < 1e-12 && name == "Floor");
    // from below, an underside
    let (range, _, name) = hit(&s, [-1.0, 6.0, -3.5], [-1.0, 6.0, 0.0]);
    assert!(
        (range - 0.7).abs() < 1e-12 && name == "+Y block 1 underside",
        "{name}"
    );
}

#[test]
fn a_moving_box_hides_the_wall_while_it_is_there() {
    let mut s = scenario();
    s.disturbance.body = vec![BodyModel {
        size_m: [1.0, 2.0, 1.0],
        centre_m: [-2.0, 0.0, 1.0],
        velocity_m_s: [0.0, 1.0, 0.0],
        time_s: 0.0,
    }];
    let (_, scene) = scene_of(&s);
    let ray = Ray {
        origin_m: Vector3::new(-6.0, 0.0, 1.0),
        direction: Vector3::x(),
    };
    let range = |time| {
        scene
            .nearest_of_all(&ray, START_S + time)
            .expect("a hit")
            .range_m
    };
    assert!((range(0.0) - 3.5).abs() < 1e-12);
    assert!((range(0.99) - 3.5).abs() < 1e-12);
    assert!((range(1.01) - 6.0).abs() < 1e-12);
}

/// With and without culling the same ray meets the same surface, while the sensor moves within its slack.
#[test]
fn candidates_miss_nothing() {
    let mut s = scenario();
    s.disturbance.body = vec![BodyModel {
        size_m: [0.4, 0.4, 1.5],
        centre_m: [-2.0, -3.0, 1.0],
        velocity_m_s: [0.0, 0.5, 0.0],
        time_s: 0.0,
    }];
    let (_, scene) = scene_of(&s);
    let scene = scene.without_floor();
    let motion = Motion::new(&s.motion, &s.pass, START_S);
    let mounting = Mounting::from_angles(0.01, -0.02, 0.03, Vector3::new(0.4, 0.3, 1.2));
    let fan = Fan::new(-1.5, 1.2, 181);
    let (half_s, mut found, mut hits) = (0.05, vec![], 0);
    for leg in motion.legs() {
        let (speed, rate) = motion.bounds(leg);
        let slack = Slack {
            moved_m: (speed + rate * mounting.lever_arm_m.norm()) * half_s,
            turned_rad: rate * half_s,
            time_s: half_s,
        };
        for step in 1..100 {
            let middle = leg.begin_s + 0.24 * f64::from(step);
            let pose = SensorPose::new(&motion.pose(leg, middle), &mounting);
            fan.candidates(&scene, &pose, middle, &slack, &mut found);
            for ray in 0..fan.len() {
                let time = middle + half_s * (2.0 * ray as f64 / 180.0 - 1.0);
                let pose = SensorPose::new(&motion.pose(leg, time), &mounting);
                let cast = pose.ray(fan.direction(ray));
                let covering = found.iter().filter(|c| c.first <= ray && ray <= c.last);
                let culled = scene.nearest(&cast, time, covering.map(|c| c.surface));
                let all = scene.nearest_of_all(&cast, time);
                assert_eq!(culled, all);
                hits += usize::from(all.is_some());
            }
        }
    }
    assert!(hits > 5000, "{hits}");
}
