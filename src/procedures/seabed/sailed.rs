//! A survey that was sailed in a scenario's words, so that the next line can be planned on it.
//!
//! Lines are those that were sailed, straight from their begin to their end; depth, slope and relief are read from the soundings, the boat's
//! motion and the rates of sounder and INS from the records. What comes of it is a prediction, not the survey's own information.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::field::Field;
use super::joint::{JointError, relief};
use super::scene::Scene;
use super::survey::scenario::{Bed, Course, Errors, FurtherHead, Motion, Multibeam, Turn};
use super::survey::{LoadedSeabed, SeabedScenario, TwoArrays};
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::frames::{Ecef, Point, Pose, Target};
use crate::geometry::rotation;
use crate::math;
use crate::stats::{Moments, median};
use crate::survey::sections::Origin;
use crate::units::wrap_angle;

/// Why a survey has no plan.
#[derive(Debug, thiserror::Error)]
pub enum NoPlan {
    /// No relief can be read from it.
    #[error(transparent)]
    Joint(#[from] JointError),
    /// Soundings or poses are missing where they are needed.
    #[error("no line has soundings on the seabed with a position")]
    Nothing,
    /// A depth that no plan is made for.
    #[error("the seabed lies {0:.1} m below the water, expected 0.5 to 1000 m")]
    Depth(f64),
}

/// Soundings that a foreseen survey has at most: its tiles draw a part of them, so that more tell nothing more.
const MOST_SOUNDINGS: f64 = 300_000.0;
/// Fewest beams that they are thinned to.
const FEWEST_BEAMS: f64 = 32.0;
/// Of the beams' angles, the share within the half swath: stray angles are not the swath.
const SWATH_SHARE: f64 = 0.995;
/// Speeds nearer than this share are one.
const ONE_SPEED: f64 = 0.2;

/// The survey as a scenario, and what was read, in words.
///
/// # Errors
/// [`NoPlan`].
pub fn as_scenario(survey: &LoadedSeabed) -> Result<(SeabedScenario, Vec<String>), NoPlan> {
    let (file, scene) = (&survey.file, &survey.scene);
    let seen = relief(scene, &file.joint(1))?;
    let plane = Plane::of(&seen.points_m).ok_or(NoPlan::Nothing)?;
    let depth_m = file.site.water_level_m - plane.height_m;
    if !(0.5..=1000.0).contains(&depth_m) {
        return Err(NoPlan::Depth(depth_m));
    }
    let frame = Moved::to(survey, &plane);
    let bed = plane.bed(depth_m, &seen.field);
    let sailed: Vec<Sailed> = (0..scene.lines.len())
        .filter_map(|k| Sailed::of(scene, k))
        .collect();
    let line: Vec<Course> = sailed.iter().map(|s| frame.course(s)).collect();
    if line.is_empty() {
        return Err(NoPlan::Nothing);
    }
    let duration_s: f64 = sailed.iter().map(|s| s.to_s - s.from_s).sum();
    let mut site = file.site.clone();
    site.origin = frame.origin;
    // the frame's height zero is the water
    site.water_level_m = 0.0;
    let mut trajectory = file.trajectory.clone();
    trajectory.path = Some("trajectory.csv".to_owned());
    (trajectory.accuracies, trajectory.time, trajectory.week) = (None, None, None);
    (trajectory.leap_seconds, trajectory.heights) = (None, "ellipsoid".to_owned());
    trajectory.lever_arm_m = [0.0; 3];
    let mut scenario = SeabedScenario {
        name: file.name.clone(),
        procedure: "seabed".to_owned(),
        format: "csv".to_owned(),
        seed: 1,
        site,
        bed,
        motion: motion(scene, &sailed),
        trajectory_rate_hz: rate_hz(scene),
        trajectory,
        sound_speed_m_s: scene.water.surface_speed_m_s(),
        profile_sigma: file.sound_speed.profile_sigma,
        multibeam: multibeam(survey, duration_s),
        head: further(survey),
        tide: None,
        errors: Errors::default(),
        line,
        seabed: file.seabed.clone(),
        reference: file.reference.clone(),
        verdict: file.verdict.clone(),
    };
    let thinned = thinned(&mut scenario, duration_s);
    let mut notes = vec![said(&scenario, &seen.field, sailed.len())];
    notes.extend(thinned);
    Ok((scenario, notes))
}

/// What was read, in words.
fn said(scenario: &SeabedScenario, field: &Field, lines: usize) -> String {
    let (bed, motion) = (&scenario.bed, &scenario.motion);
    format!(
        "read from the survey: {lines} lines as sailed, taken as straight; {:.1} m of water, slope {:.1} deg towards {:.0} deg, relief {:.3} m over {:.1} m; roll {:.1}, pitch {:.1}, yaw {:.1} deg, heave {:.2} m, every {:.1} s. A prediction, not the survey's own result",
        bed.depth_m,
        bed.slope_deg,
        bed.azimuth_deg,
        field.sigma_m,
        field.length_m,
        motion.roll_deg,
        motion.pitch_deg,
        motion.yaw_deg,
        motion.heave_m,
        motion.period_s
    )
}

/// The plane through the soundings: its height at their middle, and its rise eastwards and northwards.
struct Plane {
    middle_m: Vector2<f64>,
    height_m: f64,
    rise: Vector2<f64>,
}

impl Plane {
    fn of(points_m: &[Vector3<f64>]) -> Option<Self> {
        let mut mean = Moments::new(3);
        points_m.iter().for_each(|p| mean.add(&[p.x, p.y, p.z]));
        let mean = mean.mean()?;
        let middle = Vector3::new(mean[0], mean[1], mean[2]);
        let mut squares = Matrix3::zeros();
        for p in points_m {
            let off = p - middle;
            squares += off * off.transpose();
        }
        let sides = squares.fixed_view::<2, 2>(0, 0).into_owned();
        let rise = sides
            .lu()
            .solve(&squares.fixed_view::<2, 1>(0, 2).into_owned());
        Some(Self {
            middle_m: middle.xy(),
            height_m: middle.z,
            rise: rise.unwrap_or_else(Vector2::zeros),
        })
    }

    fn bed(&self, depth_m: f64, field: &Field) -> Bed {
        let fall = -self.rise;
        Bed {
            depth_m,
            slope_deg: math::atan2(fall.norm(), 1.0).to_degrees().min(45.0),
            azimuth_deg: math::atan2(fall.x, fall.y).to_degrees().rem_euclid(360.0),
            relief_m: field.sigma_m,
            length_m: field.length_m,
            ripple_m: 0.0,
            ripple_length_m: 3.0,
            boulders_per_ha: 0.0,
        }
    }
}

/// The scenario's frame: its origin is the middle of the soundings at the water's level.
struct Moved {
    origin: Origin,
    to_own: Pose<Target, Ecef>,
    from_survey: Pose<Ecef, Target>,
}

impl Moved {
    fn to(survey: &LoadedSeabed, plane: &Plane) -> Self {
        let site = &survey.file.site;
        let pose = TargetPose {
            ellipsoid: site.ellipsoid,
            origin: site.origin.geodetic(),
            azimuth_rad: 0.0,
        };
        let from_survey = pose.ecef_from_target();
        let middle = Vector3::new(plane.middle_m.x, plane.middle_m.y, site.water_level_m);
        let origin = pose
            .ellipsoid
            .to_geodetic(&(from_survey * Point::new(middle)));
        let own = TargetPose { origin, ..pose };
        Self {
            origin: Origin {
                latitude_deg: origin.latitude_rad.to_degrees(),
                longitude_deg: origin.longitude_rad.to_degrees(),
                height_m: origin.height_m,
            },
            to_own: own.ecef_from_target().inverse(),
            from_survey,
        }
    }

    fn course(&self, sailed: &Sailed) -> Course {
        let place = |p: &Vector3<f64>| {
            let own = self.to_own * (self.from_survey * Point::<Target>::new(*p));
            let tidy = |x: f64| (100.0 * x).round() / 100.0;
            [tidy(own.coordinates.x), tidy(own.coordinates.y)]
        };
        let speed = sailed.way_m() / (sailed.to_s - sailed.from_s);
        Course {
            name: sailed.name.clone(),
            from_m: place(&sailed.from_m),
            to_m: place(&sailed.to_m),
            speed_m_s: (100.0 * speed).round().max(1.0) / 100.0,
        }
    }
}

/// One line as it was sailed.
struct Sailed {
    name: String,
    from_s: f64,
    to_s: f64,
    from_m: Vector3<f64>,
    to_m: Vector3<f64>,
    rows: std::ops::Range<usize>,
}

impl Sailed {
    /// From its first to its last sounding that has a pose; `None` where the boat made no way.
    fn of(scene: &Scene, line: usize) -> Option<Self> {
        let own = scene
            .soundings
            .iter()
            .filter(|s| usize::from(s.line) == line);
        let posed = own
            .map(|s| s.time_s)
            .filter(|t| scene.trajectory.pose_at(*t).is_ok());
        let (from_s, to_s) = posed.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| {
            (a.min(t), b.max(t))
        });
        let place = |t: f64| scene.trajectory.pose_at(t).ok().map(|pose| pose.position_m);
        let times = scene.trajectory.times_s();
        let sailed = Self {
            name: scene.lines[line].name.clone(),
            from_s,
            to_s,
            from_m: place(from_s)?,
            to_m: place(to_s)?,
            rows: times.partition_point(|t| *t < from_s)..times.partition_point(|t| *t <= to_s),
        };
        (to_s > from_s && sailed.way_m() > 1.0 && sailed.rows.len() > 2).then_some(sailed)
    }

    fn way_m(&self) -> f64 {
        (self.to_m - self.from_m).xy().norm()
    }
}

/// Standard deviations about the mean of each line, and the typical period: twice the time over the roll's zero crossings.
fn motion(scene: &Scene, sailed: &[Sailed]) -> Motion {
    let mut squares = [0.0; 4];
    let (mut count, mut crossings, mut duration_s) = (0.0, 0.0, 0.0);
    for line in sailed {
        let way = line.to_m - line.from_m;
        let course = math::atan2(way.x, way.y);
        let of = |k: usize| {
            let (roll, pitch, heading) = rotation::to_attitude(&scene.trajectory.attitudes()[k]);
            [roll, pitch, wrap_angle(heading - course), scene.heave_m[k]]
        };
        let all: Vec<[f64; 4]> = line.rows.clone().map(of).collect();
        let n = all.len() as f64;
        let mean: [f64; 4] = std::array::from_fn(|c| all.iter().map(|a| a[c]).sum::<f64>() / n);
        for a in &all {
            for (c, square) in squares.iter_mut().enumerate() {
                *square += (a[c] - mean[c]).powi(2);
            }
        }
        let up = |a: &[f64; 4]| a[3] > mean[3];
        crossings += all.windows(2).filter(|w| up(&w[0]) != up(&w[1])).count() as f64;
        (count, duration_s) = (count + n, duration_s + line.to_s - line.from_s);
    }
    let [roll, pitch, yaw, heave_m] = squares.map(|s| (s / f64::max(count, 1.0)).sqrt());
    let degrees = |angle: f64| angle.to_degrees().min(30.0);
    Motion {
        roll_deg: degrees(roll),
        pitch_deg: degrees(pitch),
        yaw_deg: degrees(yaw),
        heave_m,
        period_s: (2.0 * duration_s / f64::max(crossings, 1.0)).clamp(1.0, 30.0),
    }
}

/// Records a second of the trajectory, at most a hundred: the drift's knots are a second apart.
fn rate_hz(scene: &Scene) -> f64 {
    let times = scene.trajectory.times_s();
    let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let step_s = median(&mut steps).unwrap_or(0.05);
    (1.0 / step_s.max(1e-6)).clamp(1.0, 100.0)
}

fn multibeam(survey: &LoadedSeabed, duration_s: f64) -> Multibeam {
    let (file, scene) = (&survey.file, &survey.scene);
    let m = &file.multibeam;
    let first = scene.soundings.iter().filter(|s| s.head == 0);
    let mut pings: Vec<(u16, u32)> = first.clone().map(|s| (s.line, s.beam.ping)).collect();
    pings.sort_unstable();
    pings.dedup();
    let mut angles_deg: Vec<f64> = first.map(|s| s.across_rad.abs().to_degrees()).collect();
    angles_deg.sort_by(f64::total_cmp);
    let at = (SWATH_SHARE * angles_deg.len() as f64) as usize;
    let seen_deg = angles_deg
        .get(at)
        .or(angles_deg.last())
        .map_or(60.0, |a| *a);
    // a survey file of a scenario uses all but the outermost two degrees
    let half_deg = seen_deg.min(m.max_angle_deg + 2.0).clamp(1.0, 80.0);
    let beams = angles_deg.len() as f64 / pings.len().max(1) as f64;
    let inside = (half_deg / seen_deg.max(1.0)).min(1.0);
    let arrays = scene.heads[0].arrays.as_ref().map(|_| TwoArrays {
        receiver_mounting_deg: m.receiver_mounting_deg,
        receiver_offset_m: receiver_offset_m(m.lever_arm_m, m.receiver_lever_arm_m),
        ..TwoArrays::default()
    });
    Multibeam {
        lever_arm_m: m.lever_arm_m,
        lever_arm_sigma_m: m.lever_arm_sigma_m,
        mounting_deg: m.mounting_deg,
        correction_deg: Turn::default(),
        range_sigma_m: m.range_sigma_m,
        angle_sigma_deg: m.angle_sigma_deg,
        angle_sigma_growth: m.angle_sigma_growth,
        ping_rate_hz: pings.len().max(1) as f64 / duration_s.max(1.0),
        beams: ((beams * inside).round() as u32).clamp(2, 4096),
        half_swath_deg: half_deg,
        arrays,
    }
}

/// The receive array from the transmit array, metres; nothing between them where one arm is stated for both.
fn receiver_offset_m(arm_m: [f64; 3], receiver_arm_m: Option<[f64; 3]>) -> [f64; 3] {
    let receiver_arm_m = receiver_arm_m.unwrap_or(arm_m);
    std::array::from_fn(|k| receiver_arm_m[k] - arm_m[k])
}

fn further(survey: &LoadedSeabed) -> Vec<FurtherHead> {
    let one = |h: &super::survey::file::HeadSection| FurtherHead {
        lever_arm_m: h.lever_arm_m,
        lever_arm_sigma_m: h.lever_arm_sigma_m,
        mounting_deg: h.mounting_deg,
        correction_deg: Turn::default(),
        latency_s: 0.0,
        receiver_mounting_deg: h.receiver_mounting_deg,
        receiver_offset_m: receiver_offset_m(h.lever_arm_m, h.receiver_lever_arm_m),
    };
    survey.file.head.iter().map(one).collect()
}

/// Fewer beams and pings where there are more soundings than a plan needs; says so.
fn thinned(scenario: &mut SeabedScenario, duration_s: f64) -> Option<String> {
    let m = &mut scenario.multibeam;
    let heads = (1 + scenario.head.len()) as f64;
    let all = heads * f64::from(m.beams) * m.ping_rate_hz * duration_s;
    if all <= MOST_SOUNDINGS {
        return None;
    }
    let share = MOST_SOUNDINGS / all;
    let beams = (f64::from(m.beams) * share.sqrt()).max(FEWEST_BEAMS.min(f64::from(m.beams)));
    m.ping_rate_hz *= share * f64::from(m.beams) / beams.round();
    m.beams = beams.round() as u32;
    Some(format!(
        "planned with {} beams and {:.2} pings a second in place of all {all:.0} soundings: tiles use a part of them anyway",
        m.beams, m.ping_rate_hz
    ))
}

/// The speeds of lines, those that are nearly one taken together.
#[must_use]
pub fn speeds_m_s(lines: &[Course]) -> Vec<f64> {
    let mut all: Vec<f64> = lines.iter().map(|line| line.speed_m_s).collect();
    all.sort_by(f64::total_cmp);
    let near = |a: &f64, b: &f64| b / a < 1.0 + ONE_SPEED;
    let groups = all.chunk_by(near);
    let mean = |group: &[f64]| group.iter().sum::<f64>() / group.len() as f64;
    groups
        .map(|group| (10.0 * mean(group)).round().max(1.0) / 10.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::seabed::simulate::{Acts, simulate};
    use crate::procedures::seabed::survey::load::load;
    use crate::procedures::seabed::survey::parse_scenario as parse;
    use crate::procedures::seabed::survey::write::write;
    use std::path::Path;

    const THIN: &str = include_str!("../../../models/scenarios/seabed-thin.toml");

    /// A survey of this scenario, read as sailed; and the scenario.
    fn read(text: &str) -> [SeabedScenario; 2] {
        let scenario = parse(Path::new("s.toml"), text).expect("a scenario");
        let folder = tempfile::tempdir().expect("a folder");
        let survey = simulate(&scenario, 1, Acts::ALL);
        write(folder.path(), &scenario, &survey).expect("written");
        let survey = load(&folder.path().join("survey.toml")).expect("a survey");
        let (read, _) = as_scenario(&survey).expect("a scenario");
        [read, scenario]
    }

    fn near(what: &str, found: f64, due: f64, by: f64) {
        assert!((found - due).abs() <= by, "{what}: {found}, {due} sailed");
    }

    /// A survey states the arm that was taped: 5 mm of standard deviation.
    fn near_arm(found: [f64; 3], due: [f64; 3]) {
        for k in 0..3 {
            near("lever arm", found[k], due[k], 4.5 * 0.005);
        }
    }

    /// What was put in comes out, each within what a survey of five minutes tells: a wave of 5 s comes 60 times, so that its size is known to
    /// a tenth; a roll that is 0.9 deg off on three lines northwards and one southwards leans the bed by 0.45 deg; relief and its length as
    /// the field of single lines has them, which noise and twenty tiles a line make uncertain by a factor.
    #[test]
    fn a_survey_is_read_as_the_scenario_that_it_was_made_from() {
        let [read, sailed] = read(THIN);
        let (bed, due) = (&read.bed, &sailed.bed);
        // the middle of the soundings, 9 m east and 75 m north of the origin
        let lower_m = 0.0699 * (9.0 * 0.866 + 75.0 * 0.5);
        near("depth", bed.depth_m, due.depth_m + lower_m, 0.5);
        near("slope", bed.slope_deg, due.slope_deg, 0.6);
        near("azimuth", bed.azimuth_deg, due.azimuth_deg, 10.0);
        near("relief", math::ln(bed.relief_m / due.relief_m), 0.0, 0.7);
        near(
            "its length",
            math::ln(bed.length_m / due.length_m),
            0.0,
            0.7,
        );
        let (motion, due) = (&read.motion, &sailed.motion);
        for (what, found, due) in [
            ("roll", motion.roll_deg, due.roll_deg),
            ("pitch", motion.pitch_deg, due.pitch_deg),
            ("yaw", motion.yaw_deg, due.yaw_deg),
            ("heave", motion.heave_m, due.heave_m),
            ("period", motion.period_s, due.period_s),
        ] {
            near(what, found, due, 0.2 * due);
        }
        near("rate", read.trajectory_rate_hz, 20.0, 0.01);
        let (sonar, due) = (&read.multibeam, &sailed.multibeam);
        near("pings", sonar.ping_rate_hz, due.ping_rate_hz, 0.03);
        near("beams", sonar.beams.into(), due.beams.into(), 1.0);
        near("swath", sonar.half_swath_deg, due.half_swath_deg, 1.0);
        near_arm(sonar.lever_arm_m, due.lever_arm_m);
        assert_eq!((sonar.arrays.is_none(), read.head.len()), (true, 0));
        assert_eq!(read.line.len(), sailed.line.len());
        for (found, due) in read.line.iter().zip(&sailed.line) {
            assert_eq!(found.name, due.name);
            near("speed", found.speed_m_s, due.speed_m_s, 0.02);
            // about the middle of the soundings; a line is told from its first to its last ping, which lie in it
            let pings_m = 2.0 * due.speed_m_s / sailed.multibeam.ping_rate_hz;
            let way = |line: &Course| [0, 1].map(|k| line.to_m[k] - line.from_m[k]);
            near("east", way(found)[0], way(due)[0], 0.2);
            near("north", way(found)[1], way(due)[1], pings_m);
        }
        let apart = |of: &SeabedScenario| of.line[1].to_m[0] - of.line[0].from_m[0];
        near("lines apart", apart(&read), apart(&sailed), 0.2);
        assert_eq!(speeds_m_s(&read.line), [2.0, 3.5]);
    }

    #[test]
    fn two_arrays_and_two_heads_stay_where_they_are() {
        let nominal = "mounting_deg = { roll = 0.0, pitch = 0.0, heading = 0.0 }";
        let arrays = "mounting_deg = { roll = -0.8, pitch = 1.1, heading = 0.3 }
arrays = { receiver_mounting_deg = { roll = 1.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 1 }";
        let [read_as, sailed] = read(&THIN.replace(nominal, arrays));
        let of = |s: &SeabedScenario| s.multibeam.arrays.expect("two arrays");
        let (found, due) = (of(&read_as), of(&sailed));
        assert_eq!(found.receiver_mounting_deg, due.receiver_mounting_deg);
        for k in 0..3 {
            near(
                "arm",
                found.receiver_offset_m[k],
                due.receiver_offset_m[k],
                1e-9,
            );
        }
        let dual = include_str!("../../../models/scenarios/seabed-dual.toml");
        let [found, due] = read(dual);
        assert_eq!(found.head.len(), 1);
        assert_eq!(found.head[0].mounting_deg, due.head[0].mounting_deg);
        near_arm(found.head[0].lever_arm_m, due.head[0].lever_arm_m);
        near(
            "beams of a head",
            found.multibeam.beams.into(),
            due.multibeam.beams.into(),
            1.0,
        );
    }

    /// 3 million soundings are thinned to 300 000, beams and pings alike, and that is said.
    #[test]
    fn a_dense_survey_is_thinned() {
        let mut scenario = parse(Path::new("s.toml"), THIN).expect("a scenario");
        (scenario.multibeam.beams, scenario.multibeam.ping_rate_hz) = (400, 25.0);
        let said = thinned(&mut scenario, 300.0).expect("thinned");
        let m = &scenario.multibeam;
        let left = f64::from(m.beams) * m.ping_rate_hz * 300.0;
        near("left", left, MOST_SOUNDINGS, 1.0);
        near("beams", m.beams.into(), 400.0 * 0.1f64.sqrt(), 0.5);
        assert!(said.contains("all 3000000 soundings"), "{said}");
        let mut few = parse(Path::new("s.toml"), THIN).expect("a scenario");
        assert!(thinned(&mut few, 300.0).is_none());
    }
}
