//! Where the boat truly is: a straight course with waves about it, a smooth function of time.

use crate::math;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::scenario::Pass;

/// One sine of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wave {
    /// Amplitude, metres or degrees as the motion has it.
    pub amplitude: f64,
    /// Period, seconds.
    pub period_s: f64,
    /// Phase at the begin of the first pass, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// Mean and waves of one degree of freedom, metres or degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oscillation {
    /// Mean value.
    #[serde(default)]
    pub mean: f64,
    /// Sines about it.
    #[serde(default)]
    pub wave: Vec<Wave>,
}

/// Motion of the INS about the course: lengths in metres, angles in degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionModel {
    /// Towards the target (+X).
    #[serde(default)]
    pub sway: Oscillation,
    /// Along the wall (+Y).
    #[serde(default)]
    pub surge: Oscillation,
    /// Height of the INS in the target frame.
    #[serde(default)]
    pub height: Oscillation,
    /// Roll, positive starboard down.
    #[serde(default)]
    pub roll: Oscillation,
    /// Pitch, positive bow up.
    #[serde(default)]
    pub pitch: Oscillation,
    /// Heading about the course and its crab angle.
    #[serde(default)]
    pub heading: Oscillation,
}

/// True pose of the body in the target frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPose {
    /// INS centre, metres.
    pub position_m: Vector3<f64>,
    /// Body into target frame.
    pub rotation: Matrix3<f64>,
}

/// A sine ready for evaluation: amplitude in metres or radians, angular rate, phase.
#[derive(Clone, Copy, Debug)]
struct Sine {
    amplitude: f64,
    rate: f64,
    phase: f64,
}

#[derive(Clone, Debug)]
struct Sines {
    mean: f64,
    sines: Vec<Sine>,
}

impl Sines {
    fn new(model: &Oscillation, unit: f64) -> Self {
        let sine = |w: &Wave| Sine {
            amplitude: w.amplitude * unit,
            rate: std::f64::consts::TAU / w.period_s,
            phase: w.phase_deg.to_radians(),
        };
        Self {
            mean: model.mean * unit,
            sines: model.wave.iter().map(sine).collect(),
        }
    }

    fn at(&self, time_s: f64) -> f64 {
        let sum = |x: f64, s: &Sine| x + s.amplitude * math::sin(s.rate * time_s + s.phase);
        self.sines.iter().fold(self.mean, sum)
    }

    fn rate_at(&self, time_s: f64) -> f64 {
        let sum =
            |x: f64, s: &Sine| x + s.amplitude * s.rate * math::cos(s.rate * time_s + s.phase);
        self.sines.iter().fold(0.0, sum)
    }

    fn fastest(&self) -> f64 {
        self.sines
            .iter()
            .map(|s| (s.amplitude * s.rate).abs())
            .sum()
    }
}

/// One pass in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Begin, seconds.
    pub begin_s: f64,
    /// End, seconds.
    pub end_s: f64,
    x_m: f64,
    from_m: f64,
    velocity_m_s: f64,
    heading_rad: f64,
}

/// The boat's true motion.
#[derive(Clone, Debug)]
pub struct Motion {
    start_s: f64,
    legs: Vec<Leg>,
    /// Sway, surge, height.
    shift: [Sines; 3],
    /// Roll, pitch, heading.
    turn: [Sines; 3],
}

impl Motion {
    /// The motion along these passes, the first of which begins at `start_s`.
    #[must_use]
    pub fn new(model: &MotionModel, passes: &[Pass], start_s: f64) -> Self {
        let (metre, degree) = (1.0, 1.0_f64.to_radians());
        Self {
            start_s,
            legs: legs(passes, start_s),
            shift: [&model.sway, &model.surge, &model.height].map(|m| Sines::new(m, metre)),
            turn: [&model.roll, &model.pitch, &model.heading].map(|m| Sines::new(m, degree)),
        }
    }

    /// The passes in time.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// True pose at a time (seconds) on a pass.
    #[must_use]
    pub fn pose(&self, leg: &Leg, time_s: f64) -> BodyPose {
        let t = time_s - self.start_s;
        let y = leg.from_m + leg.velocity_m_s * (time_s - leg.begin_s);
        let [sway, surge, height] = [0, 1, 2].map(|k| self.shift[k].at(t));
        let [roll, pitch, heading] = [0, 1, 2].map(|k| self.turn[k].at(t));
        BodyPose {
            position_m: Vector3::new(leg.x_m + sway, y + surge, height),
            rotation: attitude(roll, pitch, leg.heading_rad + heading),
        }
    }

    /// True velocity (target frame, metres per second) at a time on a pass.
    #[must_use]
    pub fn velocity(&self, leg: &Leg, time_s: f64) -> Vector3<f64> {
        let [sway, surge, height] = [0, 1, 2].map(|k| self.shift[k].rate_at(time_s - self.start_s));
        Vector3::new(sway, leg.velocity_m_s + surge, height)
    }

    /// Bounds of speed (metres per second) and turning rate (radians per second) on a pass.
    #[must_use]
    pub fn bounds(&self, leg: &Leg) -> (f64, f64) {
        let sum = |sines: &[Sines; 3]| sines.iter().map(Sines::fastest).sum::<f64>();
        (leg.velocity_m_s.abs() + sum(&self.shift), sum(&self.turn))
    }
}

fn legs(passes: &[Pass], start_s: f64) -> Vec<Leg> {
    let mut begin_s = start_s;
    passes
        .iter()
        .enumerate()
        .map(|(k, pass)| {
            if k > 0 {
                begin_s += pass.gap_s;
            }
            let way_m = pass.to_m - pass.from_m;
            let course: f64 = if way_m < 0.0 { 180.0 } else { 0.0 };
            let leg = Leg {
                begin_s,
                end_s: begin_s + way_m.abs() / pass.speed_m_s,
                x_m: -pass.distance_m,
                from_m: pass.from_m,
                velocity_m_s: pass.speed_m_s * way_m.signum(),
                heading_rad: (course + pass.crab_deg).to_radians(),
            };
            begin_s = leg.end_s;
            leg
        })
        .collect()
}

/// Body into target for a heading that counts clockwise from the target's +Y axis: turn about y by roll, then about x by pitch,
/// then about z by minus heading (written out here so that the simulator does not share the estimator's rotations).
#[must_use]
pub(super) fn attitude(roll_rad: f64, pitch_rad: f64, heading_rad: f64) -> Matrix3<f64> {
    let (s, c) = math::sin_cos(roll_rad);
    let about_y = Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
    let (s, c) = math::sin_cos(pitch_rad);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
    let (s, c) = math::sin_cos(heading_rad);
    let about_minus_z = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
    about_minus_z * (about_x * about_y)
}
