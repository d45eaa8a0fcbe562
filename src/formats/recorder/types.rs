//! What recorders say, in our frame and units: x right, y forward, z up; radians, metres, seconds; beam angles to starboard.

use nalgebra::Vector3;

use crate::observe::Mounting;

/// Receives what a file says, in the order of the file. Every method does nothing unless it is written.
pub trait Sink {
    /// The installation record.
    fn installation(&mut self, _: &Installation) {}
    /// A sample of attitude.
    fn attitude(&mut self, _: &Attitude) {}
    /// A heading that came without roll and pitch.
    fn heading(&mut self, _: &Heading) {}
    /// A position.
    fn position(&mut self, _: &Position) {}
    /// A height of the water level.
    fn water_height(&mut self, _: &WaterHeight) {}
    /// A sound-speed profile.
    fn profile(&mut self, _: &Profile) {}
    /// A ping as it was received: angles and times.
    fn ping(&mut self, _: &Ping) {}
    /// The sounder's own solution of a ping.
    fn solution(&mut self, _: &Solution) {}
}

/// Attitude at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Time, seconds.
    pub time_s: f64,
    /// Roll, radians, positive starboard down.
    pub roll_rad: f64,
    /// Pitch, radians, positive bow up.
    pub pitch_rad: f64,
    /// Heading, radians, clockwise from north.
    pub heading_rad: Option<f64>,
    /// Heave, metres, positive up.
    pub heave_m: Option<f64>,
    /// Number of the sensor, 0 where there is only one.
    pub sensor: u8,
    /// Whether the recorder used another sensor than this one.
    pub passive: bool,
}

/// Heading at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heading {
    /// Time, seconds.
    pub time_s: f64,
    /// Heading, radians, clockwise from north.
    pub heading_rad: f64,
}

/// Position at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position {
    /// Time, seconds.
    pub time_s: f64,
    /// Geodetic latitude, radians.
    pub latitude_rad: f64,
    /// Longitude, radians.
    pub longitude_rad: f64,
    /// Height above the ellipsoid, metres, where the file says it.
    pub height_m: Option<f64>,
    /// Number of the sensor, 0 where there is only one.
    pub sensor: u8,
    /// Whether the recorder used another sensor than this one.
    pub passive: bool,
    /// Whether it is the position of the vessel's reference point, not of the sensor.
    pub at_reference: bool,
}

/// Height of the water level as the recorder works it out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterHeight {
    /// Time, seconds.
    pub time_s: f64,
    /// Height of the water level above the positioning system's vertical datum, metres.
    pub height_m: f64,
}

/// A sound-speed profile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// When it was taken, seconds.
    pub time_s: f64,
    /// Depth below the water line, metres.
    pub depth_m: Vec<f64>,
    /// Sound speed, metres per second.
    pub speed_m_s: Vec<f64>,
}

/// A transmit sector of a ping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sector {
    /// Tilt of the transmitted cone, radians, positive forward.
    pub tilt_rad: f64,
    /// Time from the ping's time to the middle of this sector's pulse, seconds.
    pub delay_s: f64,
    /// Frequency, hertz.
    pub frequency_hz: f64,
    /// Transmit array, from 0.
    pub array: u8,
}

/// A beam of a ping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeamSample {
    /// Number of the beam in its ping, from 0.
    pub number: u32,
    /// Index into the ping's sectors.
    pub sector: u16,
    /// Whether the sounder holds it valid.
    pub valid: bool,
    /// Angle against the receive array, radians, positive to starboard.
    pub angle_rad: f64,
    /// Two-way travel time, seconds.
    pub two_way_s: f64,
}

/// A ping as it was received.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ping {
    /// Time of the first sector's transmission, seconds.
    pub time_s: f64,
    /// Number of the ping.
    pub number: u32,
    /// Serial number of the head, or its index.
    pub head: u32,
    /// Sound speed at the head that the beam former used, metres per second.
    pub head_speed_m_s: f64,
    /// Sectors.
    pub sectors: Vec<Sector>,
    /// Beams.
    pub beams: Vec<BeamSample>,
}

/// What the own solution's coordinates are counted from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Origin {
    /// Right and forward from the position sensor, up from the transmit array.
    #[default]
    PositionSensorAndArray,
    /// All three from the vessel's reference point.
    ReferencePoint,
}

/// One beam of the sounder's own solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnPoint {
    /// Right, forward, up in the level frame turned to the solution's heading, metres.
    pub right_forward_up_m: Vector3<f64>,
    /// Whether the sounder holds it valid.
    pub valid: bool,
}

/// The sounder's own solution of a ping.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// Time of the ping, seconds.
    pub time_s: f64,
    /// Number of the ping.
    pub number: u32,
    /// Serial number of the head, or its index.
    pub head: u32,
    /// Heading to which it is turned, radians.
    pub heading_rad: f64,
    /// Depth of the transmit array below the water line at transmission, heave included, metres.
    pub array_depth_m: f64,
    /// Height of the water line above the reference point, metres; 0 where the solution does not say it.
    pub water_line_m: f64,
    /// What it is counted from.
    pub origin: Origin,
    /// Beams, in the order of the ping's.
    pub points: Vec<OwnPoint>,
}

/// What an array does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It transmits.
    Transmit,
    /// It receives.
    Receive,
    /// One head that holds both.
    Both,
}

/// An array or a sensor and how it is mounted.
#[derive(Clone, Debug, PartialEq)]
pub struct Mounted {
    /// The file's own name of it.
    pub name: String,
    /// Its mounting.
    pub mounting: Mounting,
    /// Delay of its times, seconds, as the file says it.
    pub delay_s: f64,
    /// Whether the recorder uses it.
    pub active: bool,
}

/// A transmit or receive array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Name and mounting.
    pub mounted: Mounted,
    /// What it does.
    pub role: Role,
    /// Serial number of the head, 0 where it is not known.
    pub head: u32,
    /// Inner offset of the transmit and of the receive part from the mounting's point, metres; used only on demand.
    pub inner_m: [Vector3<f64>; 2],
}

/// An installation record: how everything is mounted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Installation {
    /// When it was written, seconds.
    pub time_s: f64,
    /// The record as keys and values, in its order.
    pub fields: Vec<(String, String)>,
    /// Arrays.
    pub arrays: Vec<Array>,
    /// Motion sensors.
    pub motion_sensors: Vec<Mounted>,
    /// Position sensors.
    pub position_sensors: Vec<Mounted>,
    /// Height of the water line above the reference point, metres.
    pub water_line_m: Option<f64>,
    /// Whether the attitude in the file is already turned by the motion sensor's mounting.
    pub attitude_is_turned: bool,
}

impl Installation {
    /// The array that transmits for a head (any, where heads are not told apart).
    #[must_use]
    pub fn transmitter(&self, head: u32) -> Option<&Array> {
        self.array(head, Role::Transmit)
    }

    /// The array that receives for a head (any, where heads are not told apart).
    #[must_use]
    pub fn receiver(&self, head: u32) -> Option<&Array> {
        self.array(head, Role::Receive)
    }

    fn array(&self, head: u32, role: Role) -> Option<&Array> {
        let fits = |a: &&Array| a.role == role || a.role == Role::Both;
        let all = || self.arrays.iter().filter(fits);
        all()
            .find(|a| a.head == head)
            .or_else(|| all().find(|a| a.head == 0))
            .or_else(|| Some(all().next()?).filter(|_| all().count() == 1))
    }

    /// The motion sensor in use: the first active one.
    #[must_use]
    pub fn motion_sensor(&self) -> Option<&Mounted> {
        self.motion_sensors.iter().find(|m| m.active)
    }

    /// The position sensor in use: the first active one.
    #[must_use]
    pub fn position_sensor(&self) -> Option<&Mounted> {
        self.position_sensors.iter().find(|m| m.active)
    }
}
