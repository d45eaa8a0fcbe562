//! Streams as a Kongsberg recorder writes them: `.all` and `.kmall`, for simulators that export what users have.

use std::io::{self, Write};

use nalgebra::{Matrix3, Vector3};

use crate::formats::recorder::{Attitude, Origin, OwnPoint, Ping, Position, Profile, Solution};
use crate::formats::{kmall, kongsberg_all};
use crate::geometry::{Geodetic, rotation};
use crate::math;
use crate::observe::{ArrayMountings, Mounting, PoseSample};
use crate::units::degrees;

/// Unix time at which a simulation's clock is zero: 2024-06-01 00:00 UTC.
pub const EPOCH_S: f64 = 1_717_200_000.0;
/// Model in the files.
const MODEL: u16 = 2040;
/// Serial number of the first head; the others count on.
const SERIAL: u16 = 101;
/// Samples of a datagram of attitude.
const SAMPLES: usize = 100;

/// Which of the two formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kongsberg {
    /// `.all`: attitude turned by the motion sensor's mounting, positions of the antenna.
    All,
    /// `.kmall`: attitude and positions of the motion sensor as it measured.
    Kmall,
}

impl Kongsberg {
    /// The format that a file's ending names.
    #[must_use]
    pub fn of_ending(ending: &str) -> Option<Self> {
        match ending {
            "all" => Some(Self::All),
            "kmall" => Some(Self::Kmall),
            _ => None,
        }
    }

    /// Where the recorder's sensors stand: of `.all` the antenna, of `.kmall` the motion sensor, which is turned as well.
    #[must_use]
    pub fn sensor(self) -> Mounting {
        let degree = 1f64.to_radians();
        match self {
            Self::All => Mounting::from_angles(0.0, 0.0, 0.0, Vector3::new(0.4, -1.0, 3.0)),
            Self::Kmall => Mounting::from_angles(
                0.4 * degree,
                -0.3 * degree,
                1.0 * degree,
                Vector3::new(0.1, 0.2, -0.3),
            ),
        }
    }
}

/// What a sounder knows of a ping beside its points: the body's pose at transmission, its arrays, the height of the water, metres.
pub struct Sounder<'a> {
    /// Pose of the body in the local frame: east, north, up.
    pub pose: &'a PoseSample,
    /// The arrays that sent and heard.
    pub arrays: &'a ArrayMountings,
    /// Height of the water in the same frame, metres.
    pub level_m: f64,
}

impl Kongsberg {
    /// The solution of a ping as this format has it; `points_m` are the ends of its beams in the local frame, nothing where one has none.
    #[must_use]
    pub fn solution(
        self,
        ping: &Ping,
        sounder: &Sounder<'_>,
        points_m: impl IntoIterator<Item = Option<Vector3<f64>>>,
    ) -> Solution {
        let pose = sounder.pose;
        let (_, _, heading_rad) = rotation::to_attitude(&pose.rotation);
        let sender_m = pose.rotation * sounder.arrays.transmitter.lever_arm_m;
        let (origin, begin_m) = match self {
            Self::All => {
                let antenna_m = pose.rotation * self.sensor().lever_arm_m;
                let begin_m = Vector3::new(antenna_m.x, antenna_m.y, sender_m.z);
                (Origin::PositionSensorAndArray, begin_m)
            }
            Self::Kmall => (Origin::ReferencePoint, Vector3::zeros()),
        };
        let turn = right_forward_up(heading_rad);
        let own = |point_m: Option<Vector3<f64>>| {
            let from_begin = point_m.map(|p| turn * (p - pose.position_m - begin_m));
            OwnPoint {
                right_forward_up_m: from_begin.unwrap_or_default(),
                valid: point_m.is_some(),
            }
        };
        Solution {
            time_s: ping.time_s,
            number: ping.number,
            head: ping.head,
            heading_rad,
            array_depth_m: sounder.level_m - pose.position_m.z - sender_m.z,
            water_line_m: 0.0,
            origin,
            points: points_m.into_iter().map(own).collect(),
        }
    }
}

/// East, north, up into right, forward, up of a heading.
fn right_forward_up(heading_rad: f64) -> Matrix3<f64> {
    let (sin, cos) = math::sin_cos(heading_rad);
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// A record of the sensor whose motion is recorded: its attitude (level to sensor) and place, and the heave of the body, metres.
#[must_use]
pub fn motion(
    time_s: f64,
    attitude: &Matrix3<f64>,
    place: &Geodetic,
    heave_m: f64,
) -> (Attitude, Position) {
    let (roll_rad, pitch_rad, heading_rad) = rotation::to_attitude(attitude);
    let attitude = Attitude {
        time_s,
        roll_rad,
        pitch_rad,
        heading_rad: Some(heading_rad),
        heave_m: Some(heave_m),
        sensor: 1,
        passive: false,
    };
    let position = Position {
        time_s,
        latitude_rad: place.latitude_rad,
        longitude_rad: place.longitude_rad,
        height_m: Some(place.height_m),
        sensor: 1,
        passive: false,
        at_reference: false,
    };
    (attitude, position)
}

/// What one file holds.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    /// Time of the installation record, seconds.
    pub begin_s: f64,
    /// Mountings of each head.
    pub arrays: &'a [ArrayMountings],
    /// The sensor of [`Self::motion`].
    pub sensor: &'a Mounting,
    /// The sound-speed profile.
    pub cast: Profile,
    /// Attitude and position of the sensor, in order of time.
    pub motion: Vec<(Attitude, Position)>,
    /// Pings and the sounder's own solution of each, in order of time; heads are numbered from 1.
    pub pings: Vec<(Ping, Solution)>,
}

impl Recording<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// Those of the output.
    pub fn write(&self, format: Kongsberg, out: &mut impl Write) -> io::Result<()> {
        match format {
            Kongsberg::All => self.all(out),
            Kongsberg::Kmall => self.kmall(out),
        }
    }

    fn all(&self, out: &mut impl Write) -> io::Result<()> {
        let mut w = kongsberg_all::write::Writer::new(out, MODEL, SERIAL);
        let second = self.arrays.get(1).map_or(0, |_| SERIAL + 1);
        w.installation(self.begin_s, &self.all_text(), second)?;
        w.profile(&self.cast)?;
        for part in self.motion.chunks(SAMPLES) {
            let samples: Vec<Attitude> = part.iter().map(|m| m.0).collect();
            w.attitude(&samples)?;
            for (attitude, position) in part {
                w.position(position, attitude.heading_rad.unwrap_or(0.0))?;
            }
        }
        for (ping, solution) in &self.pings {
            w.head(SERIAL + ping.head as u16 - 1);
            w.ping(ping)?;
            w.solution(solution, ping.head_speed_m_s)?;
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
        let [x, y, z, ..] = forward_starboard_down(self.sensor);
        let heads = match self.arrays {
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

    fn kmall(&self, out: &mut impl Write) -> io::Result<()> {
        let mut w = kmall::write::Writer::new(out, MODEL);
        w.installation(self.begin_s, &self.kmall_text())?;
        w.profile(&self.cast)?;
        for part in self.motion.chunks(SAMPLES) {
            let samples: Vec<_> = part.iter().map(|(a, p)| (*a, Some(*p))).collect();
            w.motion(&samples)?;
        }
        for (ping, solution) in &self.pings {
            w.ping(ping, solution)?;
        }
        Ok(())
    }

    fn kmall_text(&self) -> String {
        let group = |name: &str, mounting: &Mounting, more: &str| {
            let [x, y, z, r, p, h] = forward_starboard_down(mounting);
            format!("{name}:X={x:.4};Y={y:.4};Z={z:.4};R={r:.4};P={p:.4};H={h:.4};{more},\n")
        };
        let each = |of: fn(&ArrayMountings) -> &Mounting, name: &str, serial: usize| -> String {
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
            group("ATTI_1", self.sensor, "D=0.000;U=ACTIVE"),
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
