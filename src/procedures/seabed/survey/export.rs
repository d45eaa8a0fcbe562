//! A simulated survey as a Kongsberg recorder would have written it: one file of each line, and a survey file that names them.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use nalgebra::Vector3;

use super::super::model::{Locator, Values};
use super::super::scene::Scene;
use super::super::simulate::{Record, Shot, Simulated};
use super::super::states::States;
use super::load::scene_of;
use super::scenario::SeabedScenario;
use super::write;
use crate::formats::recorder::{Attitude, BeamSample, Ping, Position, Profile, Sector, Solution};
use crate::formats::{FormatError, whole};
use crate::geometry::ellipsoid::{TargetPose, ecef_from_level};
use crate::geometry::{Ecef, Point, Pose, Target};
use crate::observe::{ArrayMountings, Mounting, SoundSpeedProfile};
use crate::recorders::recording::{self, EPOCH_S, Kongsberg, Recording, Sounder};

/// Names of the lines' files.
fn names(scenario: &SeabedScenario, survey: &Simulated) -> Vec<String> {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name = |(k, line): (usize, &super::super::scene::Line)| {
        let of: String = line.name.chars().map(safe).collect();
        format!("{:04}_{of}.{}", k + 1, scenario.format)
    };
    survey.lines.iter().enumerate().map(name).collect()
}

/// Writes the files and the survey file into a folder, which exists.
///
/// # Errors
/// [`FormatError`] for a file that cannot be written.
pub fn write(
    folder: &Path,
    scenario: &SeabedScenario,
    survey: &Simulated,
) -> Result<(), FormatError> {
    let export = Export::new(scenario, survey);
    let names = names(scenario, survey);
    for (number, name) in names.iter().enumerate() {
        let path = folder.join(name);
        whole::write_whole(&path, |out: &mut BufWriter<&mut File>| {
            export.recording(number).write(export.format, out)
        })?;
    }
    write::write_tide(folder, scenario, survey, EPOCH_S)?;
    let path = folder.join("survey.toml");
    let text = survey_text(scenario, survey, &names)
        .map_err(|error| FormatError::unwritable(&path, &error))?;
    whole::write_whole(&path, |out| out.write_all(text.as_bytes()))
}

/// What the surveyor adds to the files: sigmas and settings.
fn survey_text(
    scenario: &SeabedScenario,
    survey: &Simulated,
    names: &[String],
) -> Result<String, toml::ser::Error> {
    let mut root = toml::Table::try_from(write::survey_file(scenario, survey))?;
    root.remove("line");
    root.remove("head");
    let heave = scenario.trajectory.above_water();
    let without: [(&str, &[&str]); 4] = [
        ("site", &["origin", "water_level_m"]),
        ("trajectory", &["path", "lever_arm_m", "heights"]),
        ("sound_speed", &["profile"]),
        (
            "multibeam",
            &[
                "path",
                "head",
                "lever_arm_m",
                "mounting_deg",
                "receiver_lever_arm_m",
                "receiver_mounting_deg",
            ],
        ),
    ];
    for (section, keys) in without {
        let table = root.get_mut(section).and_then(toml::Value::as_table_mut);
        if let Some(table) = table {
            let kept = |key: &str| heave && key == "heights";
            table.retain(|key, _| kept(key) || !keys.iter().any(|k| **k == *key));
            if section == "multibeam" {
                table.insert("paths".to_owned(), names.to_vec().into());
            }
        }
    }
    toml::to_string(&root)
}

/// A simulated survey on its way into files.
struct Export<'a> {
    survey: &'a Simulated,
    /// Of each head.
    arrays: Vec<ArrayMountings>,
    profile: SoundSpeedProfile,
    head_speed_m_s: f64,
    sensor: Mounting,
    format: Kongsberg,
    frame: Pose<Ecef, Target>,
    scenario: &'a SeabedScenario,
    scene: Scene,
}

impl<'a> Export<'a> {
    fn new(scenario: &'a SeabedScenario, survey: &'a Simulated) -> Self {
        let format = Kongsberg::of_ending(&scenario.format).unwrap_or(Kongsberg::Kmall);
        let file = write::survey_file(scenario, survey);
        let profile = write::profile(scenario, survey);
        let trajectory = write::trajectory(scenario, survey);
        let observed = write::soundings(scenario, &survey.shots);
        let scene = scene_of(
            &file,
            &trajectory,
            std::slice::from_ref(&profile),
            write::tide(scenario, survey, 0.0),
            &observed,
        );
        let pose = TargetPose {
            ellipsoid: scenario.site.ellipsoid,
            origin: scenario.site.origin.geodetic(),
            azimuth_rad: 0.0,
        };
        Self {
            survey,
            arrays: scenario
                .heads()
                .iter()
                .zip(&survey.lever_arms_m)
                .map(|(head, arm_m)| head.arrays(*arm_m))
                .collect(),
            profile,
            head_speed_m_s: scenario.sound_speed_m_s,
            sensor: format.sensor(),
            format,
            frame: pose.ecef_from_target(),
            scenario,
            scene,
        }
    }

    fn begin_s(&self, number: usize) -> f64 {
        EPOCH_S + self.survey.lines[number].start_s
    }

    /// Records of the trajectory of one line.
    fn records(&self, number: usize) -> Vec<&Record> {
        let line = &self.survey.lines[number];
        let own = |r: &&Record| r.time_s >= line.start_s - 30.0 && r.time_s <= line.end_s + 30.0;
        self.survey.records.iter().filter(own).collect()
    }

    /// Attitude and position of the sensor at a record.
    fn motion(&self, record: &Record) -> (Attitude, Position) {
        let place = record.position_m + record.rotation * self.sensor.lever_arm_m;
        let ecef = self.frame * Point::<Target>::new(place);
        let geodetic = self.scenario.site.ellipsoid.to_geodetic(&ecef);
        let level = ecef_from_level(&geodetic).matrix;
        let turned = self.frame.rotation.matrix * record.rotation * self.sensor.rotation;
        let level_m = self.scenario.site.water_level_m + self.scenario.tide_m(record.time_s);
        let heave_m = record.position_m.z - level_m;
        let time_s = EPOCH_S + record.time_s;
        recording::motion(time_s, &level.tr_mul(&turned), &geodetic, heave_m)
    }

    fn cast(&self, number: usize) -> Profile {
        Profile {
            time_s: (self.begin_s(number) - 60.0).floor(),
            depth_m: self.profile.depth_m.clone(),
            speed_m_s: self.profile.speed_m_s.clone(),
        }
    }

    /// The pings of one line with the solution that a sounder makes of them by its installation values.
    fn pings(&self, number: usize) -> Vec<(Ping, Solution)> {
        let states = States::new(&self.scene.lines, &self.scene.ins, &self.scene.drift);
        let values = Values::nominal(&self.scene, &states);
        let Some(locator) = Locator::new(&self.scene, &states, &values) else {
            return vec![];
        };
        let own = |k: &usize| usize::from(self.scene.soundings[*k].line) == number;
        let all: Vec<usize> = (0..self.scene.soundings.len()).filter(own).collect();
        let shot = |k: usize| &self.survey.shots[self.scene.soundings[k].row as usize];
        let of = |k: usize| (shot(k).head, shot(k).ping);
        let pings = all.chunk_by(|a, b| of(*a) == of(*b));
        let written = pings.filter_map(|rows| {
            let shots: Vec<&Shot> = rows.iter().map(|k| shot(*k)).collect();
            let place = |k: &usize| locator.locate(*k).map(|found| found.point_m);
            let points: Vec<_> = rows.iter().map(place).collect();
            self.ping(&shots, &points)
        });
        let mut written: Vec<(Ping, Solution)> = written.collect();
        // as they were sent, whichever head sent them
        written.sort_by(|a, b| a.0.time_s.total_cmp(&b.0.time_s));
        written
    }

    fn ping(&self, shots: &[&Shot], points: &[Option<Vector3<f64>>]) -> Option<(Ping, Solution)> {
        let first = shots.first()?;
        let sectors = self.scenario.two_arrays().unwrap_or_default().sectors();
        let sector = |k: u32| {
            let (tilt_rad, delay_s) = sectors.sector(k);
            Sector {
                tilt_rad,
                delay_s,
                frequency_hz: 3e5,
                array: 0,
            }
        };
        let beam = |(k, shot): (usize, &&Shot)| BeamSample {
            number: k as u32,
            sector: shot.sector as u16,
            valid: true,
            angle_rad: shot.across_rad,
            two_way_s: shot.two_way_s,
        };
        let ping = Ping {
            time_s: EPOCH_S + first.time_s,
            number: first.ping,
            head: u32::from(first.head) + 1,
            head_speed_m_s: self.head_speed_m_s,
            sectors: (0..sectors.count).map(sector).collect(),
            beams: shots.iter().enumerate().map(beam).collect(),
        };
        let arrays = &self.arrays[usize::from(first.head)];
        let solution = self.solution((&ping, arrays), first.time_s, points)?;
        Some((ping, solution))
    }

    fn solution(
        &self,
        (ping, arrays): (&Ping, &ArrayMountings),
        time_s: f64,
        points: &[Option<Vector3<f64>>],
    ) -> Option<Solution> {
        let mut pose = self.scene.trajectory.pose_at(time_s).ok()?;
        let line = self.scene.lines.iter().position(|l| time_s <= l.end_s)?;
        pose.position_m.z += self.scene.lift_m(line, time_s);
        let sounder = Sounder {
            pose: &pose,
            arrays,
            level_m: self.scene.water.level_m + self.scene.tide_m(line, time_s),
        };
        let points_m = points.iter().copied();
        Some(self.format.solution(ping, &sounder, points_m))
    }

    /// Everything of one line.
    fn recording(&self, number: usize) -> Recording<'_> {
        let records = self.records(number);
        Recording {
            begin_s: self.begin_s(number),
            arrays: &self.arrays,
            sensor: &self.sensor,
            cast: self.cast(number),
            motion: records.iter().map(|r| self.motion(r)).collect(),
            pings: self.pings(number),
        }
    }
}
