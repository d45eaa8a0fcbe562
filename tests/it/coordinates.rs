//! The same laser returns in every frame that `coordinates` may name lead to the same calibration, on a long track too.

use std::path::Path;

use boresight::formats::laser_csv;
use boresight::geometry::{Point, utm::Utm};
use boresight::georef::{georeference, local_trajectory};
use boresight::observe::LaserScan;
use boresight::procedures::pool::survey::{LoadedSurvey, load, scenario, write_survey};
use boresight::procedures::pool::{
    JointConfig, Method, PoolInput, Scene, SequentialConfig, calibrate,
};
use boresight::simulate::{DEMO, Simulated, simulate};
use nalgebra::Vector3;

const FRAMES: [&str; 4] = ["sensor", "target", "geocentric", "utm"];

/// A survey whose boat came from behind the wall: the first records see every face from the wrong side.
fn simulated(folder: &Path) -> Simulated {
    let mut file = scenario::from_text(Path::new("demo.toml"), DEMO).expect("the demo");
    (
        file.scenario.multibeam.beams,
        file.scenario.lidar.points_per_line,
    ) = (48, 40);
    file.lidar = "lidar.csv".to_owned();
    let mut survey = simulate(&file.scenario, 1).expect("a survey");
    came_from_behind(&mut survey);
    write_survey(folder, &file, &survey).expect("written");
    survey
}

/// Two records long before the first, behind the wall.
fn came_from_behind(survey: &mut Simulated) {
    let ahead = survey.prior.ecef_from_target() * Point::new(Vector3::new(60.0, 0.0, 0.0));
    let trajectory = &mut survey.campaign.trajectory;
    let place = trajectory.ellipsoid.to_geodetic(&ahead);
    let first_s = trajectory.time_s[0];
    for time_s in [first_s - 100.0, first_s - 100.5] {
        trajectory.time_s.insert(0, time_s);
        trajectory.latitude_rad.insert(0, place.latitude_rad);
        trajectory.longitude_rad.insert(0, place.longitude_rad);
        trajectory.height_m.insert(0, place.height_m);
        for angles in [
            &mut trajectory.roll_rad,
            &mut trajectory.pitch_rad,
            &mut trajectory.heading_rad,
        ] {
            angles.insert(0, angles[0]);
        }
    }
}

/// The returns in the believed target frame, then in the wanted one.
fn georeferenced(survey: &Simulated, frame: &str) -> LaserScan {
    let (campaign, pose) = (&survey.campaign, &survey.prior);
    let local = local_trajectory(&campaign.trajectory, pose).trajectory;
    let zone = Utm::new(pose.ellipsoid, Utm::zone_of(&pose.origin)).expect("a zone");
    let mut scan = campaign.laser.clone();
    for k in 0..scan.len() {
        let seen = local.pose_at(scan.time_s[k]).expect("a pose");
        let point = georeference(&seen, &campaign.scanner, &scan.point(k));
        let geocentric = pose.ecef_from_target() * Point::new(point);
        let wanted = match frame {
            "target" => point,
            "geocentric" => geocentric.coordinates,
            "utm" => {
                let place = pose.ellipsoid.to_geodetic(&geocentric);
                let (east, north) = zone.from_geodetic(&place).expect("in the zone");
                Vector3::new(east, north, place.height_m)
            }
            _ => scan.point(k),
        };
        (scan.x_m[k], scan.y_m[k], scan.z_m[k]) = (wanted.x, wanted.y, wanted.z);
    }
    scan
}

/// The survey with its returns in another frame, as its reader gives it.
fn loaded(folder: &Path, survey: &Simulated, frame: &str) -> LoadedSurvey {
    laser_csv::write(&folder.join("lidar.csv"), &georeferenced(survey, frame)).expect("written");
    let path = folder.join("survey.toml");
    let text = std::fs::read_to_string(&path).expect("text");
    let mut table: toml::Table = text.parse().expect("TOML");
    let lidar = table["lidar"].as_table_mut().expect("a section");
    lidar.insert("coordinates".to_owned(), frame.into());
    if frame != "sensor" {
        lidar.insert("point_sigma_m".to_owned(), 0.005.into());
    }
    if frame == "utm" {
        let zone = Utm::zone_of(&survey.prior.origin);
        lidar.insert("utm_zone".to_owned(), i64::from(zone).into());
    }
    std::fs::write(&path, table.to_string()).expect("written");
    load(&path).unwrap_or_else(|error| panic!("{frame}: {error}"))
}

#[test]
fn returns_of_every_frame_lie_on_the_target_and_are_seen_from_the_boat() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated(folder.path());
    for frame in FRAMES {
        let read = loaded(folder.path(), &survey, frame);
        let scene = Scene::prepare(&read.campaign, &read.target, &read.pose).expect("a scene");
        assert!(scene.laser_fit > 0.8, "{frame}: {}", scene.laser_fit);
        let from_the_boat = (0..read.campaign.laser.len())
            .filter_map(|j| scene.laser_point(j))
            .all(|(_, ray)| ray.x > 0.0);
        assert!(from_the_boat, "{frame}: rays from behind the wall");
    }
}

#[test]
fn every_frame_of_the_returns_calibrates_to_the_truth() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated(folder.path());
    for frame in FRAMES {
        let read = loaded(folder.path(), &survey, frame);
        let input = PoolInput {
            campaign: &read.campaign,
            target: &read.target,
            prior: &read.pose,
            method: Method::Joint,
            sequential: &SequentialConfig::default(),
            joint: &JointConfig::default(),
            seed: 1,
            extras: &[],
        };
        let outcome = calibrate(&input, &boresight::watch::Unwatched)
            .unwrap_or_else(|e| panic!("{frame}: {e}"));
        let found = outcome.joint.unwrap_or_else(|| panic!("{frame}: refused"));
        let off_m = (found.mounting.lever_arm_m - survey.truth.lever_arm()).norm();
        assert!(off_m < 0.02, "{frame}: {off_m} m off");
    }
}
