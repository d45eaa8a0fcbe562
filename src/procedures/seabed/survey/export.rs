//! A simulated survey as a Kongsberg recorder would have written it: one file of each line, and a survey file that names them.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::super::model::{Locator, Values};
use super::super::scene::{Arrays, Scene};
use super::super::simulate::{Record, Shot, Simulated};
use super::super::states::States;
use super::load::scene_of;
use super::scenario::SeabedScenario;
use super::write;
use crate::formats::recorder::{
    Attitude, BeamSample, Origin, OwnPoint, Ping, Position, Profile, Sector, Solution,
};
use crate::formats::{FormatError, kmall, kongsberg_all, whole};
use crate::geometry::ellipsoid::{TargetPose, ecef_from_level};
use crate::geometry::{Ecef, Point, Pose, Target, rotation};
use crate::math;
use crate::observe::{Mounting, SoundSpeedProfile};
use crate::units::degrees;

/// Unix time at which a simulation's clock is zero: 2024-06-01 00:00 UTC.
const EPOCH_S: f64 = 1_717_200_000.0;
/// Model in the files.
const MODEL: u16 = 2040;
/// Serial number of the first head; the others count on.
const SERIAL: u16 = 101;
/// Samples of a datagram of attitude.
const SAMPLES: usize = 100;

/// Where the recorder's sensors stand: of `.all` the antenna, of `.kmall` the motion sensor, which is turned as well.
fn sensor(format: &str) -> Mounting {
    let degree = 1f64.to_radians();
    match format {
        "all" => Mounting::from_angles(0.0, 0.0, 0.0, Vector3::new(0.4, -1.0, 3.0)),
        _ => Mounting::from_angles(
            0.4 * degree,
            -0.3 * degree,
            1.0 * degree,
            Vector3::new(0.1, 0.2, -0.3),
        ),
    }
}

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
            match scenario.format.as_str() {
                "all" => export.all(number, out),
                _ => export.kmall(number, out),
            }
        })?;
    }
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
            table.retain(|key, _| !keys.iter().any(|k| **k == *key));
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
    arrays: Vec<Arrays>,
    profile: SoundSpeedProfile,
    head_speed_m_s: f64,
    sensor: Mounting,
    frame: Pose<Ecef, Target>,
    scenario: &'a SeabedScenario,
    scene: Scene,
}

impl<'a> Export<'a> {
    fn new(scenario: &'a SeabedScenario, survey: &'a Simulated) -> Self {
        let file = write::survey_file(scenario, survey);
        let profile = write::profile(scenario, survey);
        let trajectory = write::trajectory(scenario, survey);
        let observed = write::soundings(scenario, &survey.shots);
        let scene = scene_of(
            &file,
            &trajectory,
            std::slice::from_ref(&profile),
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
            sensor: sensor(&scenario.format),
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
        let (roll_rad, pitch_rad, heading_rad) = rotation::to_attitude(&level.tr_mul(&turned));
        let time_s = EPOCH_S + record.time_s;
        let heave_m = record.position_m.z - self.scenario.site.water_level_m;
        (
            Attitude {
                time_s,
                roll_rad,
                pitch_rad,
                heading_rad: Some(heading_rad),
                heave_m: Some(heave_m),
                sensor: 1,
                passive: false,
            },
            Position {
                time_s,
                latitude_rad: geodetic.latitude_rad,
                longitude_rad: geodetic.longitude_rad,
                height_m: Some(geodetic.height_m),
                sensor: 1,
                passive: false,
                at_reference: false,
            },
        )
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
        let two = self.scenario.two_arrays().unwrap_or_default();
        let sector = |k: u32| {
            let (tilt_rad, delay_s) = two.sector(k);
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
            sectors: (0..two.sectors).map(sector).collect(),
            beams: shots.iter().enumerate().map(beam).collect(),
        };
        let arrays = &self.arrays[usize::from(first.head)];
        let solution = self.solution((&ping, arrays), first.time_s, points)?;
        Some((ping, solution))
    }

    fn solution(
        &self,
        (ping, arrays): (&Ping, &Arrays),
        time_s: f64,
        points: &[Option<Vector3<f64>>],
    ) -> Option<Solution> {
        let pose = self.scene.trajectory.pose_at(time_s).ok()?;
        let (_, _, heading_rad) = rotation::to_attitude(&pose.rotation);
        let sender_m = pose.rotation * arrays.transmitter.lever_arm_m;
        let (origin, begin_m) = if self.scenario.format == "all" {
            let antenna_m = pose.rotation * self.sensor.lever_arm_m;
            let begin_m = Vector3::new(antenna_m.x, antenna_m.y, sender_m.z);
            (Origin::PositionSensorAndArray, begin_m)
        } else {
            (Origin::ReferencePoint, Vector3::zeros())
        };
        let turn = turned(heading_rad);
        let own = |point: &Option<Vector3<f64>>| {
            let from_begin = point.map(|p| turn * (p - pose.position_m - begin_m));
            OwnPoint {
                right_forward_up_m: from_begin.unwrap_or_default(),
                valid: point.is_some(),
            }
        };
        Some(Solution {
            time_s: ping.time_s,
            number: ping.number,
            head: ping.head,
            heading_rad,
            array_depth_m: self.scene.water.level_m - pose.position_m.z - sender_m.z,
            water_line_m: 0.0,
            origin,
            points: points.iter().map(own).collect(),
        })
    }

    fn all(&self, number: usize, out: &mut impl Write) -> std::io::Result<()> {
        let mut w = kongsberg_all::write::Writer::new(out, MODEL, SERIAL);
        let second = self.arrays.get(1).map_or(0, |_| SERIAL + 1);
        w.installation(self.begin_s(number), &self.all_text(), second)?;
        w.profile(&self.cast(number))?;
        let motion: Vec<_> = self
            .records(number)
            .iter()
            .map(|r| self.motion(r))
            .collect();
        for part in motion.chunks(SAMPLES) {
            let samples: Vec<Attitude> = part.iter().map(|m| m.0).collect();
            w.attitude(&samples)?;
            for (attitude, position) in part {
                w.position(position, attitude.heading_rad.unwrap_or(0.0))?;
            }
        }
        for (ping, solution) in self.pings(number) {
            w.head(SERIAL + ping.head as u16 - 1);
            w.ping(&ping)?;
            w.solution(&solution, ping.head_speed_m_s)?;
        }
        Ok(())
    }

    fn all_text(&self) -> String {
        let array = |prefix: &str, mounting: &Mounting| {
            let [x, y, z, r, p, h] = forward_starboard_down(mounting);
            format!(
                "{prefix}X={x:.4},{prefix}Y={y:.4},{prefix}Z={z:.4},{prefix}R={r:.4},{prefix}P={p:.4},{prefix}H={h:.4},"
            )
        };
        let [x, y, z, ..] = forward_starboard_down(&self.sensor);
        let heads = match self.arrays.as_slice() {
            [first, second] => format!(
                "STC=4,{}{}{}{}",
                array("S0", &first.transmitter),
                array("S1", &second.transmitter),
                array("S2", &first.receiver),
                array("S3", &second.receiver),
            ),
            all => {
                let each = all.iter().map(|arrays| {
                    array("S1", &arrays.transmitter) + &array("S2", &arrays.receiver)
                });
                format!("STC=0,{}", each.collect::<String>())
            }
        };
        format!(
            "WLZ=0.00,{heads}P1M=0,P1T=0,P1X={x:.4},P1Y={y:.4},P1Z={z:.4},P1D=0.0,MSX=0.00,MSY=0.00,MSZ=0.00,MSR=0.00,MSP=0.00,MSG=0.00,MSD=0,APS=0,ARO=2,",
        )
    }

    fn kmall(&self, number: usize, out: &mut impl Write) -> std::io::Result<()> {
        let mut w = kmall::write::Writer::new(out, MODEL);
        w.installation(self.begin_s(number), &self.kmall_text())?;
        w.profile(&self.cast(number))?;
        let motion: Vec<_> = self
            .records(number)
            .iter()
            .map(|r| self.motion(r))
            .collect();
        for part in motion.chunks(SAMPLES) {
            let samples: Vec<_> = part.iter().map(|(a, p)| (*a, Some(*p))).collect();
            w.motion(&samples)?;
        }
        for (ping, solution) in self.pings(number) {
            w.ping(&ping, &solution)?;
        }
        Ok(())
    }

    fn kmall_text(&self) -> String {
        let group = |name: &str, mounting: &Mounting, more: &str| {
            let [x, y, z, r, p, h] = forward_starboard_down(mounting);
            format!("{name}:X={x:.4};Y={y:.4};Z={z:.4};R={r:.4};P={p:.4};H={h:.4};{more},\n")
        };
        let each = |of: fn(&Arrays) -> &Mounting, name: &str, serial: usize| -> String {
            let heads = self.arrays.iter().enumerate();
            heads
                .map(|(k, arrays)| {
                    let number = format!("N={}", serial + 2 * k);
                    group(&format!("TRAI_{name}{}", k + 1), of(arrays), &number)
                })
                .collect()
        };
        let transmitters = each(|a| &a.transmitter, "TX", 101);
        let receivers = each(|a| &a.receiver, "RX", 102);
        format!(
            "OSCV:Empty,EMXV:EM{MODEL},\n{transmitters}{receivers}{}EMXI:SSNL=System;SWLZ=0.0000,\n",
            group("ATTI_1", &self.sensor, "D=0.000;U=ACTIVE"),
        )
    }
}

/// Offsets forward, starboard, down (metres) and roll, pitch, heading (degrees) as Kongsberg writes them.
fn forward_starboard_down(mounting: &Mounting) -> [f64; 6] {
    let arm = mounting.lever_arm_m;
    let (roll, pitch, heading) = mounting.angles();
    [
        arm.y,
        arm.x,
        -arm.z,
        degrees(roll),
        degrees(pitch),
        degrees(heading),
    ]
    .map(|v| v + 0.0)
}

/// East, north, up into right, forward, up of a heading.
fn turned(heading_rad: f64) -> Matrix3<f64> {
    let (sin, cos) = math::sin_cos(heading_rad);
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}
