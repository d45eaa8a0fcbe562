//! Surveys as their users give them: two cut-downs of simulated surveys, written by other software (`tests/recipes/fixtures.py`).

use std::path::{Path, PathBuf};

use boresight::geometry::Ellipsoid;
use boresight::geometry::utm::Utm;
use boresight::georef::local_trajectory;
use boresight::observe::{
    LaserCoordinates, Outside, PositionInterpolation, SoundSpeed, SoundingRange,
};
use boresight::procedures::pool::survey::{LoadedSurvey, load};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

/// A copy that a test may change.
fn copy(name: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    for entry in std::fs::read_dir(fixture(name)).expect("fixture") {
        let entry = entry.expect("entry");
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).expect("copy");
    }
    folder
}

fn replace(folder: &tempfile::TempDir, file: &str, from: &str, to: &str) {
    let path = folder.path().join(file);
    let text = std::fs::read_to_string(&path).expect("text");
    assert!(text.contains(from), "{file} has no {from}");
    std::fs::write(path, text.replace(from, to)).expect("write");
}

fn survey(folder: &Path) -> LoadedSurvey {
    load(&folder.join("survey.toml")).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_survey_with_a_trajectory_csv() {
    let s = survey(&fixture("csv"));
    assert_eq!(
        (s.counts.trajectory, s.counts.laser, s.counts.soundings),
        (261, 418, 272)
    );
    assert_eq!((s.counts.laser_dropped, s.counts.soundings_dropped), (0, 0));
    let t = &s.campaign.trajectory;
    assert!((t.latitude_rad[0].to_degrees() - 35.9999).abs() < 1e-3 && t.velocity_m_s.is_none());
    assert_eq!(
        (
            t.noise.position_m,
            t.noise.position_drift_m,
            t.noise.drift_correlation_time_s
        ),
        (0.002, 0.005, 60.0)
    );
    assert!(
        (t.noise.heading_rad.to_degrees() - 0.005).abs() < 1e-15
            && t.noise.heading_drift_rad == 0.0
    );
    assert_eq!((t.max_gap_s, t.outside), (1.0, Outside::Error));
    let soundings = &s.campaign.soundings;
    assert_eq!(
        (soundings.time_s[1], soundings.ping[1], soundings.beam[1]),
        (1010.0, 150, 29)
    );
    assert!((soundings.across_rad[1].to_degrees() + 54.02149).abs() < 1e-12);
    assert_eq!(soundings.range.values()[1], 3.44222);
    assert!((soundings.noise.across_rad.to_degrees() - 0.06).abs() < 1e-15);
    assert_eq!(
        (soundings.noise.range_m, soundings.noise.along_rad),
        (0.01, 0.0)
    );
    // as laspy reads the first and the last point
    let laser = &s.campaign.laser;
    assert!((laser.time_s[0] - 1010.01363409).abs() < 1e-8);
    assert!((laser.point(0) - nalgebra::Vector3::new(5.7839, 0.0, -1.8242)).norm() < 1e-9);
    assert!((laser.time_s[417] - 1012.373057644099).abs() < 1e-12);
    assert!((laser.x_m[417] - 5.633).abs() < 1e-9 && (laser.z_m[417] - 0.8327).abs() < 1e-9);
    assert_eq!(laser.coordinates, LaserCoordinates::Sensor);
    let (roll, pitch, heading) = s.campaign.scanner.angles();
    let angles = [roll, pitch, heading].map(f64::to_degrees);
    assert!(
        (angles[0] - 0.3).abs() < 1e-12
            && (angles[1] + 0.2).abs() < 1e-12
            && (angles[2] + 0.5).abs() < 1e-12
    );
    assert_eq!(s.campaign.sonar.lever_arm_m.as_slice(), [0.5, -0.2, -1.6]);
    assert!(s.campaign.scanner_sigma.is_none() && s.campaign.sound_speed.is_none());
    assert!(
        (s.pose.azimuth_rad.to_degrees() - 30.7).abs() < 1e-12 && s.pose.origin.height_m == 15.08
    );
    for plane in ["P1", "P2", "P3", "horizontal"] {
        assert!(s.target.groups.iter().any(|g| g.name == plane), "{plane}");
    }
}

#[test]
fn inputs_are_named_as_written_and_digested() {
    let s = survey(&fixture("csv"));
    let names: Vec<_> = s.inputs.iter().map(|i| i.path.as_str()).collect();
    assert_eq!(
        names,
        [
            "survey.toml",
            "target.toml",
            "trajectory.csv",
            "lidar.laz",
            "multibeam.csv"
        ]
    );
    // sha256sum of the simulated surveys' own file, which the fixture repeats
    assert_eq!(
        s.inputs[0].sha256,
        "aea25d2c71f0a12cd55a76c441c158f23f517b4b4beb56b1fe4bc754623ff2b9"
    );
}

#[test]
fn a_survey_with_an_sbet_whose_velocities_are_those_of_its_positions() {
    let s = survey(&fixture("sbet"));
    assert_eq!(s.counts.trajectory, 160);
    let velocity = s
        .campaign
        .trajectory
        .velocity_m_s
        .as_ref()
        .expect("velocities");
    let local = local_trajectory(&s.campaign.trajectory, &s.pose).trajectory;
    assert_eq!(local.interpolation(), PositionInterpolation::Curved);
    // east and north from the recorded velocity against the positions one second apart
    let (a, b) = (&s.campaign.trajectory, 10);
    let north = (a.latitude_rad[b] - a.latitude_rad[0]) * 6.36e6;
    let east = (a.longitude_rad[b] - a.longitude_rad[0]) * 6.38e6 * a.latitude_rad[0].cos();
    let mean = |axis: usize| (0..=b).map(|k| velocity[k][axis]).sum::<f64>() / 11.0;
    assert!(
        (mean(0) - east).abs() < 0.02 && (mean(1) - north).abs() < 0.02,
        "{east} {north}"
    );
    assert!(east.hypot(north) > 0.3);
}

#[test]
fn a_gap_is_an_error_only_if_an_observation_falls_into_it() {
    let folder = copy("sbet");
    assert_eq!(
        survey(folder.path()).counts.soundings,
        survey(&fixture("sbet")).counts.soundings
    );
    replace(
        &folder,
        "survey.toml",
        "[multibeam]",
        "[multibeam]\ntime_offset_s = 5.0",
    );
    let error = load(&folder.path().join("survey.toml"))
        .expect_err("in the gap")
        .to_string();
    assert!(
        error.contains("multibeam.csv: times: found an observation at 1025.000000 s"),
        "{error}"
    );
    assert!(
        error.contains("in the gap from 1024.990 s to 1045.000 s (max_gap_s is 1)"),
        "{error}"
    );
}

#[test]
fn observations_without_position_are_dropped_and_counted_where_that_is_wanted() {
    let folder = copy("sbet");
    let all = survey(folder.path()).counts.soundings;
    replace(
        &folder,
        "survey.toml",
        "[multibeam]",
        "[multibeam]\ntime_offset_s = 5.0",
    );
    replace(
        &folder,
        "survey.toml",
        "[lidar]",
        "outside = \"drop\"\n[lidar]",
    );
    let s = survey(folder.path());
    let trajectory = &s.campaign.trajectory.time_s;
    let covered =
        |t: f64| (trajectory[0]..=1024.99).contains(&t) || (1045.0..=trajectory[159]).contains(&t);
    assert!(s.campaign.soundings.time_s.iter().all(|t| covered(*t)));
    let expected = s.campaign.soundings.time_s.len();
    assert_eq!(s.counts.soundings, expected);
    assert!(s.counts.soundings_dropped > 0);
    assert_eq!(s.counts.soundings + s.counts.soundings_dropped, all);
    assert_eq!(s.campaign.soundings.range.values().len(), expected);
    assert_eq!(s.campaign.soundings.beam.len(), expected);
    let note = format!(
        "{} of {all} soundings were dropped",
        s.counts.soundings_dropped
    );
    assert!(
        s.notes.iter().any(|n| n.starts_with(&note)),
        "{:?}",
        s.notes
    );
}

#[test]
fn a_wrong_clock_can_be_set_right_by_the_offset_that_the_message_names() {
    let folder = copy("csv");
    replace(
        &folder,
        "survey.toml",
        "[trajectory]",
        "[trajectory]\ntime_offset_s = 604818.0",
    );
    let path = folder.path().join("survey.toml");
    let error = load(&path).expect_err("another week").to_string();
    assert!(
        error.contains("time_offset_s = 604818 would bring it inside"),
        "{error}"
    );
    assert!(error.contains("18 leap seconds"), "{error}");
    for section in ["[lidar]", "[multibeam]"] {
        replace(
            &folder,
            "survey.toml",
            section,
            &format!("{section}\ntime_offset_s = 604818.0"),
        );
    }
    let s = survey(folder.path());
    assert_eq!(s.counts.soundings, 272);
    assert_eq!(s.campaign.soundings.time_s[0], 1010.0 + 604818.0);
}

#[test]
fn travel_times_come_with_a_speed_or_a_profile() {
    let folder = copy("csv");
    replace(&folder, "multibeam.csv", "range_m", "two_way_travel_time_s");
    replace(
        &folder,
        "survey.toml",
        "[multibeam]",
        "[sound_speed]\nspeed_m_s = 1480\n[multibeam]",
    );
    let s = survey(folder.path());
    assert!(matches!(
        s.campaign.soundings.range,
        SoundingRange::TwoWayTravelTime(_)
    ));
    assert_eq!(s.campaign.sound_speed, Some(SoundSpeed::Constant(1480.0)));
    replace(
        &folder,
        "survey.toml",
        "speed_m_s = 1480",
        "profile = \"svp.csv\"",
    );
    std::fs::write(
        folder.path().join("svp.csv"),
        "depth_m,sound_speed_m_s\n0,1480\n5,1482.5\n",
    )
    .expect("write");
    let s = survey(folder.path());
    let Some(SoundSpeed::Profile(profile)) = s.campaign.sound_speed else {
        panic!("no profile")
    };
    assert_eq!(
        (profile.depth_m, profile.speed_m_s),
        (vec![0.0, 5.0], vec![1480.0, 1482.5])
    );
    assert_eq!(s.inputs[5].path, "svp.csv");
}

#[test]
fn georeferenced_points_need_their_frame_and_sigma_only() {
    let folder = copy("csv");
    replace(&folder, "survey.toml", "lidar.laz", "lidar.csv");
    replace(
        &folder,
        "survey.toml",
        "coordinates = \"sensor\"",
        "coordinates = \"utm\"\nutm_zone = \"51N\"\npoint_sigma_m = 0.01",
    );
    for key in [
        "lever_arm_m = [0.4, 0.3, 1.2]\n",
        "mounting_deg = { roll = 0.300000000, pitch = -0.200000000, heading = -0.500000000 }\n",
        "range_sigma_m = 0.005\n",
        "angle_sigma_deg = 0.002\n",
    ] {
        replace(&folder, "survey.toml", key, "");
    }
    std::fs::write(
        folder.path().join("lidar.csv"),
        "time_s,x_m,y_m,z_m\n5,247000.5,3987000.25,17\n",
    )
    .expect("write");
    let s = survey(folder.path());
    assert_eq!(s.campaign.laser.coordinates, LaserCoordinates::Geocentric);
    assert_eq!(s.campaign.laser.noise.point_m, 0.01);
    let zone = Utm::new(Ellipsoid::Wgs84, 51).expect("a zone");
    let place = zone.to_geodetic(247_000.5, 3_987_000.25, 17.0);
    let point = Ellipsoid::Wgs84.to_geocentric(&place.expect("in the zone"));
    assert!((s.campaign.laser.point(0) - point.coordinates).norm() < 1e-8);
}

#[test]
fn every_key_takes_effect() {
    let folder = copy("csv");
    replace(
        &folder,
        "survey.toml",
        "[lidar]",
        "max_gap_s = 0.5\nheading_drift_sigma_deg = 0.01\n[lidar]\nmounting_sigma_deg = [0.01, 0.02, 0.03]\nlever_arm_sigma_m = [0.001, 0.002, 0.003]",
    );
    let path = folder.path().join("survey.toml");
    let more = "along_angle_sigma_deg = 0.2\n[sequential]\nvariant = \"projected\"\nrepeated = true\nthreshold_deg = 0.1\nmax_passes = 7\n\
        [joint]\nplanes = \"fixed\"\ndrift = \"off\"\nkernel = \"geman-mcclure\"\nkernel_width_sigma = 2\ngate_sigma = 6\nlatency = true\nrange_scale = true\nvariance_components = true\n\
        hold = [\"lz\", \"yaw\"]\nprior = { lz_sigma_m = 0.01 }\nmax_sigma_deg = 2\nmax_sigma_m = 1\nsimple = true\n";
    let text = std::fs::read_to_string(&path).expect("text") + more;
    std::fs::write(&path, text).expect("write");
    let s = survey(folder.path());
    let sigma = s.campaign.scanner_sigma.expect("sigma");
    assert!(
        (sigma.rotation_rad.z.to_degrees() - 0.03).abs() < 1e-15 && sigma.lever_arm_m.y == 0.002
    );
    assert_eq!(s.campaign.trajectory.max_gap_s, 0.5);
    assert!((s.campaign.trajectory.noise.heading_drift_rad.to_degrees() - 0.01).abs() < 1e-15);
    assert!((s.campaign.soundings.noise.along_rad.to_degrees() - 0.2).abs() < 1e-15);
    let shown = serde_json::to_value(&s.file).expect("json");
    let joint = serde_json::json!({"planes": "fixed", "drift": "off", "kernel": "geman-mcclure", "kernel_width_sigma": 2.0, "gate_sigma": 6.0,
        "latency": true, "range_scale": true, "variance_components": true, "hold": ["lz", "yaw"], "prior": {"lz_sigma_m": 0.01}, "max_sigma_deg": 2.0, "max_sigma_m": 1.0, "simple": true});
    assert_eq!(shown["joint"], joint);
    let sequential = serde_json::json!({"variant": "projected", "repeated": true, "threshold_deg": 0.1, "max_passes": 7});
    assert_eq!(shown["sequential"], sequential);
}
