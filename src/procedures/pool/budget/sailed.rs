//! A survey that was sailed in a scenario's words, passes included, so that it can be planned on.
//!
//! The passes are read from the trajectory: a stretch of soundings without a pause, from where the boat was at its begin to where it was at
//! its end. The boat's motion about its courses becomes one sine per degree of freedom with the observed size and period, a fan of beams
//! or shots the observed angles and rates. What comes of it is a prediction, not the survey's own information: within some per cent.

use nalgebra::{Matrix3, Vector3};

use crate::georef::local_trajectory;
use crate::math;
use crate::observe::{LaserScan, Soundings, Trajectory};
use crate::procedures::pool::survey::LoadedSurvey;
use crate::procedures::pool::survey::claims::claims;
use crate::simulate::Scenario;
use crate::simulate::motion::{MotionModel, Oscillation, Wave};
use crate::simulate::scenario::{Lidar, Multibeam, Pass};

/// Pause between two soundings that ends a pass, seconds.
const PAUSE_S: f64 = 5.0;

/// Way along the wall below which a stretch is no pass, metres.
const SHORT_M: f64 = 1.0;

/// The survey with its passes; `None` where it does not say how its scanner measures, or no pass along the wall is found in it.
#[must_use]
pub fn as_scenario(survey: &LoadedSurvey) -> Option<Scenario> {
    let mut scenario = claims(survey)?;
    let trajectory = local_trajectory(&survey.campaign.trajectory, &survey.pose).trajectory;
    let stretches = stretches(survey.campaign.soundings.times_s());
    let sailed: Vec<Sailed> = stretches
        .iter()
        .filter_map(|&(from_s, to_s)| Sailed::of(&trajectory, from_s, to_s))
        .collect();
    let duration_s: f64 = sailed.iter().map(|s| s.to_s - s.from_s).sum();
    scenario.pass = passes(&sailed);
    scenario.motion = motion(&sailed);
    multibeam(
        &mut scenario.multibeam,
        &survey.campaign.soundings,
        duration_s,
    );
    lidar(&mut scenario.lidar, &survey.campaign.laser, duration_s);
    (!scenario.pass.is_empty()).then_some(scenario)
}

/// Begin and end of each stretch without a pause.
fn stretches(times_s: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = vec![];
    for t in times_s {
        match all.last_mut() {
            Some((_, end)) if t - *end < PAUSE_S => *end = t,
            _ => all.push((t, t)),
        }
    }
    all
}

/// One pass as it was sailed.
struct Sailed {
    from_s: f64,
    to_s: f64,
    time_s: Vec<f64>,
    positions_m: Vec<Vector3<f64>>,
    /// Roll, pitch, heading from the target's +Y axis, degrees.
    attitudes_deg: Vec<[f64; 3]>,
}

impl Sailed {
    /// The records of a stretch; `None` where it is no pass along the wall.
    fn of(trajectory: &Trajectory, from_s: f64, to_s: f64) -> Option<Self> {
        let times = trajectory.times_s();
        let first = times.partition_point(|t| *t < from_s);
        let last = times.partition_point(|t| *t <= to_s);
        if last < first + 2 {
            return None;
        }
        let attitudes = trajectory.attitudes()[first..last].iter();
        let sailed = Self {
            from_s,
            to_s,
            time_s: times[first..last].to_vec(),
            positions_m: trajectory.positions_m()[first..last].to_vec(),
            attitudes_deg: attitudes.map(angles_deg).collect(),
        };
        (sailed.way_m().abs() > SHORT_M).then_some(sailed)
    }

    fn way_m(&self) -> f64 {
        self.positions_m[self.positions_m.len() - 1].y - self.positions_m[0].y
    }

    fn course_deg(&self) -> f64 {
        if self.way_m() < 0.0 { 180.0 } else { 0.0 }
    }

    /// Headings minus course, each from -180 to 180.
    fn crabs_deg(&self) -> Vec<f64> {
        let course = self.course_deg();
        let crab = |a: &[f64; 3]| (a[2] - course + 180.0).rem_euclid(360.0) - 180.0;
        self.attitudes_deg.iter().map(crab).collect()
    }

    fn axis_m(&self, axis: usize) -> Vec<f64> {
        self.positions_m.iter().map(|p| p[axis]).collect()
    }

    fn angle_deg(&self, angle: usize) -> Vec<f64> {
        self.attitudes_deg.iter().map(|a| a[angle]).collect()
    }
}

/// Roll, pitch and heading (clockwise from +Y) of a body in the target frame, degrees.
fn angles_deg(rotation: &Matrix3<f64>) -> [f64; 3] {
    let (right, forward, up) = (rotation.column(0), rotation.column(1), rotation.column(2));
    let roll = math::atan2(-right.z, up.z);
    let pitch = math::asin(forward.z.clamp(-1.0, 1.0));
    let heading = math::atan2(forward.x, forward.y);
    [roll, pitch, heading].map(f64::to_degrees)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Courses in order of time.
fn passes(sailed: &[Sailed]) -> Vec<Pass> {
    let tidy = |v: f64, steps: f64| (v * steps).round() / steps;
    let pass = |(k, s): (usize, &Sailed)| {
        let before = k.checked_sub(1).map(|k| sailed[k].to_s);
        let way_m = s.way_m();
        Pass {
            distance_m: tidy(-mean(&s.axis_m(0)), 100.0),
            from_m: tidy(s.positions_m[0].y, 100.0),
            to_m: tidy(s.positions_m[0].y + way_m, 100.0),
            speed_m_s: tidy(way_m.abs() / (s.to_s - s.from_s), 1000.0),
            crab_deg: tidy(mean(&s.crabs_deg()), 1.0),
            gap_s: before.map_or(0.0, |end| s.from_s - end),
        }
    };
    sailed.iter().enumerate().map(pass).collect()
}

/// What the boat did about its courses, the passes taken together.
fn motion(sailed: &[Sailed]) -> MotionModel {
    let about = |of: &dyn Fn(&Sailed) -> Vec<f64>, with_mean: bool| {
        let series: Vec<(&[f64], Vec<f64>)> =
            sailed.iter().map(|s| (&s.time_s[..], of(s))).collect();
        oscillation(&series, with_mean)
    };
    MotionModel {
        sway: about(&|s| s.axis_m(0), false),
        surge: Oscillation::default(),
        height: about(&|s| s.axis_m(2), true),
        roll: about(&|s| s.angle_deg(0), true),
        pitch: about(&|s| s.angle_deg(1), true),
        heading: about(&Sailed::crabs_deg, false),
    }
}

/// Mean and one sine of the size and period of the values about their mean in each pass.
fn oscillation(series: &[(&[f64], Vec<f64>)], with_mean: bool) -> Oscillation {
    let all: Vec<f64> = series.iter().flat_map(|(_, v)| v.iter().copied()).collect();
    let (mut squares, mut crossings, mut duration_s) = (0.0, 0.0, 0.0);
    for (time_s, values) in series {
        let level = mean(values);
        squares += values.iter().map(|v| (v - level).powi(2)).sum::<f64>();
        let turns = values.windows(2);
        crossings += turns
            .filter(|w| (w[0] - level).signum() != (w[1] - level).signum())
            .count() as f64;
        duration_s += time_s[time_s.len() - 1] - time_s[0];
    }
    let amplitude = (2.0 * squares / all.len().max(1) as f64).sqrt();
    let wave = Wave {
        amplitude,
        period_s: 2.0 * duration_s / f64::max(crossings, 1.0),
        phase_deg: 0.0,
    };
    Oscillation {
        mean: if with_mean { mean(&all) } else { 0.0 },
        wave: if amplitude > 0.0 && wave.period_s > 0.0 {
            vec![wave]
        } else {
            vec![]
        },
    }
}

/// The fan of beams that was recorded.
fn multibeam(sonar: &mut Multibeam, observed: &Soundings, duration_s: f64) {
    let mut pings = 0;
    let mut before = None;
    for k in 0..observed.len() {
        let at = (observed.at_s(k), observed.name(k).0);
        pings += usize::from(before != Some(at));
        before = Some(at);
    }
    sonar.ping_rate_hz = pings.max(1) as f64 / duration_s.max(1e-3);
    sonar.beams = beams(observed.len(), pings);
}

/// Lines and shots that were recorded: a line ends where the angle jumps back.
fn lidar(scanner: &mut Lidar, observed: &LaserScan, duration_s: f64) {
    let angles: Vec<f64> = observed
        .z_m
        .iter()
        .zip(&observed.x_m)
        .map(|(z, x)| math::atan2(*z, *x).to_degrees())
        .collect();
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low >= high {
        return;
    }
    let jumps = angles.windows(2);
    let lines = 1 + jumps
        .filter(|w| (w[1] - w[0]).abs() > 0.3 * (high - low))
        .count();
    (scanner.from_deg, scanner.to_deg) = (low, high);
    scanner.line_rate_hz = lines as f64 / duration_s.max(1e-3);
    scanner.points_per_line = beams(observed.len(), lines);
}

/// Rays of a fan, at least two.
fn beams(rays: usize, fans: usize) -> u32 {
    u32::try_from(rays / fans.max(1)).unwrap_or(u32::MAX).max(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_ends_a_stretch() {
        let times = [0.0, 1.0, 2.0, 20.0, 21.0];
        assert_eq!(stretches(times.into_iter()), [(0.0, 2.0), (20.0, 21.0)]);
    }

    /// A sine of amplitude 2 and period 4 s about 7 is found again.
    #[test]
    fn size_and_period_of_a_sine_are_found() {
        let times: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.01).collect();
        let sine = |t: &f64| 7.0 + 2.0 * math::sin(std::f64::consts::TAU * t / 4.0 + 0.3);
        let values: Vec<f64> = times.iter().map(sine).collect();
        let found = oscillation(&[(&times, values)], true);
        assert!((found.mean - 7.0).abs() < 1e-3, "{found:?}");
        assert!((found.wave[0].amplitude - 2.0).abs() < 1e-3, "{found:?}");
        assert!((found.wave[0].period_s - 4.0).abs() < 0.25, "{found:?}");
    }

    #[test]
    fn angles_of_a_rotation_are_the_boat_s() {
        let rotation = crate::geometry::rotation::from_attitude(0.1, -0.2, 0.5);
        let found = angles_deg(&rotation).map(f64::to_radians);
        for (found, expected) in found.iter().zip([0.1, -0.2, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}
