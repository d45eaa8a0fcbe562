//! Unknowns that the joint path could have and has not: the columns of their score tests (`docs/verdict-measured.md`).
//!
//! | unknown | moves a sounding by |
//! |---|---|
//! | roll, pitch, heading of one line | turn of the body about its own axis, on that line |
//! | place of one line | east, north, on that line |
//! | drift of roll, pitch, heading | the same turn, growing from -1/2 to 1/2 over the survey |
//! | scale of roll, pitch, heading | the same turn, by what the recorded angle differs from the line's mean |
//! | heading | the same turn; beside the yaw only the lever arm tells of it, as far as that is known |
//! | latency of a further head | what the common latency moves it by, of that head's soundings |
//! | scale of the beam angle | `range angle d(ray)/d(angle)` at the adjusted angle |
//! | attitude late | how fast the body's turning moves it |

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::field::Field;
use super::joint::Joint;
use super::model::{Adjusted, Located};
use super::normal::Normal;
use super::scene::{Head, Line, Scene};
use super::states;
use crate::adjust::{Component, Unit};
use crate::calibrate::verdict::doubts::{late_attitude, test_of};
use crate::calibrate::verdict::{Doubt, Doubted};
use crate::geometry::rotation::to_attitude;
use crate::units::wrap_angle;

/// Angles of the boat: name, which component of the trajectory, and its positive sense.
const ANGLES: [(&str, states::Component, f64, &str); 3] = [
    ("roll", states::Component::Roll, 1.0, "starboard down"),
    ("pitch", states::Component::Pitch, 1.0, "bow up"),
    ("heading", states::Component::Heading, -1.0, "clockwise"),
];
/// Columns of one line: the angles, east and north.
const OF_LINE: usize = ANGLES.len() + 2;
/// Columns of the whole survey: the angles' drifts and scales, the heading, the beam angle's scale, the attitude's latency.
const OF_ALL: usize = 2 * ANGLES.len() + 3;

/// Where the columns of the doubts stand among the unknowns, and when the survey was.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubts {
    /// Heads behind the first one.
    further: usize,
    /// First line that has columns: of two lines the first one's own angle is the second one's with the other sign.
    first: usize,
    /// Mean roll, pitch and heading on each line, radians.
    means: Vec<[f64; 3]>,
    middle_s: f64,
    span_s: f64,
}

impl Doubts {
    /// Everything that a survey could tell of.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let (lines, every) = (scene.lines.len(), scene.lines.iter());
        let begin_s = every.clone().fold(f64::INFINITY, |t, l| t.min(l.start_s));
        let end_s = every.fold(f64::NEG_INFINITY, |t, l| t.max(l.end_s));
        Self {
            further: scene.heads.len() - 1,
            first: usize::from(lines == 2),
            means: scene.lines.iter().map(|line| mean(scene, line)).collect(),
            middle_s: 0.5 * (begin_s + end_s),
            span_s: (end_s - begin_s).max(1e-9),
        }
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        OF_LINE * (self.means.len() - self.first) + OF_ALL + self.further
    }

    /// Columns that move the soundings of a head on a line.
    pub fn columns_of(&self, line: usize, head: u8) -> impl Iterator<Item = usize> {
        let own = line.checked_sub(self.first);
        let own = own.map(|place| OF_LINE * place..OF_LINE * (place + 1));
        let behind = self.columns() - self.further;
        let of_head = usize::from(head).checked_sub(1).map(|k| behind + k);
        (own.into_iter().flatten())
            .chain(behind - OF_ALL..behind)
            .chain(of_head)
    }

    /// Every column that moves a sounding of a head on a line, and how.
    pub fn moved(
        &self,
        (line, head): (usize, u8),
        located: &Located,
        adjusted: &Adjusted,
    ) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let turns =
            ANGLES.map(|(_, angle, sense, _)| located.state_column(angle, adjusted) * sense);
        let own = turns.into_iter().chain([Vector3::x(), Vector3::y()]);
        let own = own.take(if line < self.first { 0 } else { OF_LINE });
        let part = (located.time_s - self.middle_s) / self.span_s;
        let drifts = turns.map(|moved| moved * part);
        let swing = swing(&located.rotation, &self.means[line]);
        let scales = [0, 1, 2].map(|k| turns[k] * swing[k]);
        let all = [
            turns[2],
            located.angle_scale_column(adjusted),
            located.attitude_latency_column(adjusted),
        ];
        let late = located.latency_column(adjusted);
        let each = (own.chain(drifts).chain(scales)).chain(all).chain([late]);
        self.columns_of(line, head).zip(each)
    }

    /// What is doubted, in the order of the columns.
    fn list(&self, scene: &Scene, field: &Field) -> Vec<Doubt> {
        let own = scene.lines[self.first..].iter();
        let all = (own.flat_map(|line| of_line(&line.name)))
            .chain(of_all())
            .chain(scene.heads[1..].iter().map(of_head));
        all.map(|doubt| doubt.withdrawing_beyond(certain(field)))
            .collect()
    }
}

/// Roll, pitch and heading of an attitude over their means, radians.
fn swing(rotation: &Matrix3<f64>, means: &[f64; 3]) -> [f64; 3] {
    let (roll, pitch, heading) = to_attitude(rotation);
    let heading = wrap_angle(heading - means[2]);
    [roll - means[0], pitch - means[1], heading]
}

/// Mean roll, pitch and heading of the records on a line, radians; of none where it has none.
fn mean(scene: &Scene, line: &Line) -> [f64; 3] {
    let record = &scene.trajectory;
    let before = |end_s: f64| record.times_s().partition_point(|t| *t < end_s);
    let (first, end) = (before(line.start_s), before(line.end_s));
    let attitudes = &record.attitudes()[first..end.max(first)];
    let Some(about) = attitudes.first() else {
        return [0.0; 3];
    };
    let from = [0.0, 0.0, to_attitude(about).2];
    let sum = attitudes.iter().fold([0.0; 3], |sum, attitude| {
        let swing = swing(attitude, &from);
        [0, 1, 2].map(|k| sum[k] + swing[k])
    });
    [0, 1, 2].map(|k| from[k] + sum[k] / attitudes.len() as f64)
}

/// A solution's system with the columns of the doubts, the states eliminated.
pub struct System {
    doubts: Doubts,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Weighted squares and redundancy.
    misfit: (f64, f64),
}

impl System {
    /// Of normal equations with these columns; nothing where the states cannot be eliminated.
    #[must_use]
    pub fn of(doubts: Doubts, normal: Normal) -> Option<Self> {
        let misfit = (normal.omega, normal.freedom);
        let (information, score) = normal.without_states()?;
        Some(Self {
            doubts,
            information,
            gradient: -score,
            misfit,
        })
    }

    /// Tests all doubts of the solution that it belongs to.
    #[must_use]
    pub fn tested(&self, scene: &Scene, found: &Joint) -> Doubted {
        let named = found.reported().filter(|k| found.sought[*k]);
        let parameters: Vec<_> = named.map(|k| (found.parameters[k].name(), k)).collect();
        let system = (&self.information, &self.gradient);
        let doubts = self.doubts.list(scene, &found.field);
        test_of(
            system,
            &doubts,
            &|k| found.sigma(k),
            &parameters,
            self.misfit,
        )
    }
}

/// Chi-square up to which a doubt is a finding only: the first where the soundings tell that their noise is as claimed, the other elsewhere.
///
/// Over right surveys whose noise is as claimed the statistics scatter as chi-square, those of the headings a third wider: the largest of some
/// 3000 on Matern, power-law, wavy and bouldered ground was 18 (`docs/verdict-measured.md`). Where 1 cm of white noise was claimed of an INS that had 4 mm,
/// and was believed, the sonar's noise came out half as large as it was and one line's place had 49 without being off.
const CERTAIN: [f64; 2] = [25.0, 50.0];

fn certain(field: &Field) -> f64 {
    CERTAIN[usize::from(field.noise_is_as_claimed() != Some(true))]
}

fn of_line(name: &str) -> Vec<Doubt> {
    let angle = |(angle, _, _, sense): (&str, states::Component, f64, &str)| {
        Doubt::single(
            &format!("{angle}_of_line"),
            &format!("the {angle} of line {name} differs from that of the other lines ({sense})"),
            Unit::Radian,
            &format!("check whether the sounder or the INS moved before or during line {name}, or the INS had not settled; leave the line out, or calibrate the lines before and after it separately"),
        )
        .or_untold(&format!("sail another line like {name}: in its direction, where it lies"))
    };
    let place = Doubt::several(
        "position_of_line",
        &format!("line {name} lies beside the others"),
        ["east", "north"]
            .map(|side| Component::new(side, Unit::Metre))
            .to_vec(),
        "check the position's fix type and datum on that line, and position_drift_sigma_m of [trajectory]; leave the line out",
    );
    ANGLES.map(angle).into_iter().chain([place]).collect()
}

fn of_all() -> Vec<Doubt> {
    let drift = |(angle, _, _, sense): (&str, states::Component, f64, &str)| {
        Doubt::single(
            &format!("{angle}_drift"),
            &format!("the {angle} drifts over the survey, {sense} from start to end"),
            Unit::Radian,
            "check whether the INS had settled and was well aided; if it drifts like this, state its drift in [trajectory]",
        )
    };
    let scales = Doubt::several(
        "attitude_scale",
        "the recorded roll, pitch or heading does not match the boat's motion",
        ANGLES
            .map(|(angle, _, _, _)| Component::new(format!("{angle} scale"), Unit::One))
            .to_vec(),
        "check signs and unit of roll, pitch and heading (-200 % is a wrong sign, -100 % one that is missing)",
    );
    let heading = Doubt::single(
        "heading_offset",
        "the headings are turned, clockwise",
        Unit::Radian,
        "check that the heading is from true north (not grid or magnetic north), and the lever arm; both show together",
    );
    let scale = Doubt::single(
        "beam_angle_scale",
        "the beam angles look too narrow",
        Unit::One,
        "check the sound speed at the head and the unit and sense of the beam angles",
    );
    ANGLES
        .map(drift)
        .into_iter()
        .chain([scales, heading, scale, late_attitude()])
        .collect()
}

/// A further head's own clock.
fn of_head(head: &Head) -> Doubt {
    let number = head.number;
    Doubt::single(
        "latency_of_head",
        &format!("the time stamps of head {number} look later than those of the first head"),
        Unit::Second,
        &format!(
            "check that both heads stamp by one clock, and what delay the recorder adds to head {number}; calibrate each head by itself"
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation::exp;
    use crate::observe::Trajectory;
    use crate::procedures::seabed::model::{Locator, Values};

    /// The scene with the unknown of a column at `by`: of line 2's own, or of the whole survey's.
    fn spoiled(scene: &Scene, doubts: &Doubts, (own, column): (bool, usize), by: f64) -> Scene {
        let own = own.then(|| scene.lines[1].clone());
        let turn = |time_s: f64, attitude: &Matrix3<f64>| match (&own, column) {
            (Some(_), 0..3) => (column, by),
            (None, 0..3) => (column, by * (time_s - doubts.middle_s) / doubts.span_s),
            (None, 3..6) => (
                column - 3,
                by * swing(attitude, &doubts.means[1])[column - 3],
            ),
            (None, 6) => (2, by),
            _ => (0, 0.0),
        };
        let shift = match (&own, column) {
            (Some(_), 3) => Vector3::new(by, 0.0, 0.0),
            (Some(_), 4) => Vector3::new(0.0, by, 0.0),
            _ => Vector3::zeros(),
        };
        let axes = [Vector3::y(), Vector3::x(), -Vector3::z()];
        let record = &scene.trajectory;
        let (mut positions, mut attitudes) = (vec![], vec![]);
        for (k, time_s) in record.times_s().iter().copied().enumerate() {
            let on = (own.as_ref()).is_none_or(|l| (l.start_s..=l.end_s).contains(&time_s));
            let (axis, angle) = turn(time_s, &record.attitudes()[k]);
            let part = f64::from(u8::from(on));
            positions.push(record.positions_m()[k] + shift * part);
            let seen = if own.is_none() && column == 8 {
                let later = record.pose_at(time_s + by);
                later.map_or(record.attitudes()[k], |pose| pose.rotation)
            } else {
                record.attitudes()[k]
            };
            attitudes.push(seen * exp(&(axes[axis] * angle * part)));
        }
        let mut spoiled = scene.clone();
        let times = record.times_s().to_vec();
        spoiled.trajectory = Trajectory::new(times, positions, attitudes, None, f64::INFINITY);
        if own.is_none() && column == 7 {
            for sounding in &mut spoiled.soundings {
                sounding.across_rad *= 1.0 + by;
            }
        }
        spoiled
    }

    /// Angles that were recorded with the other sign have a scale of -2 about the mean of the line.
    #[test]
    fn a_line_s_mean_is_that_of_its_records() {
        let scene = Scene::thin(str::to_owned);
        let doubts = Doubts::of(&scene);
        for (line, means) in scene.lines.iter().zip(&doubts.means) {
            let record = &scene.trajectory;
            let on = |t: &f64| (line.start_s..line.end_s).contains(t);
            let all = record.times_s().iter().zip(record.attitudes());
            let swings: Vec<_> = all
                .filter(|(t, _)| on(t))
                .map(|(_, a)| swing(a, means))
                .collect();
            assert!(swings.len() > 100);
            for k in 0..3 {
                let (sum, largest) = swings.iter().fold((0.0, 0.0), |(sum, largest), s| {
                    (sum + s[k], f64::max(largest, s[k].abs()))
                });
                assert!(f64::abs(sum) < 1e-9, "{k}: {sum}");
                // motions of 1 to 2 deg (rms), and no turn over north or south among them
                assert!((0.01..0.15).contains(&largest), "{k}: {largest}");
            }
        }
    }

    /// A column is how far a sounding moves when the trajectory, or its beam angle, is changed by the unknown.
    #[test]
    fn columns_are_what_soundings_move_by() {
        let scene = Scene::thin(str::to_owned);
        let doubts = Doubts::of(&scene);
        let states = states::States::new(&scene.lines, &scene.ins, &scene.drift);
        let values = Values::nominal(&scene, &states);
        let at = |scene: &Scene, k: usize| {
            let locator = Locator::new(scene, &states, &values).expect("a profile");
            locator.locate(k).expect("a point")
        };
        let middle = scene.lines[1].start_s + 20.0;
        let first = scene.soundings.partition_point(|s| s.time_s < middle);
        for k in (first..first + 30).step_by(7) {
            let located = at(&scene, k);
            for (column, moved) in doubts.moved((1, 0), &located, &Adjusted::default()) {
                // the columns of line 2, then those of all lines
                let all = doubts.columns() - OF_ALL;
                let which = match column.checked_sub(all) {
                    Some(k) => (false, k),
                    None => (true, column - OF_LINE),
                };
                let by = 1e-4;
                let found = at(&spoiled(&scene, &doubts, which, by), k).point_m - located.point_m;
                let off = (found / by - moved).norm();
                assert!(
                    off < 2e-3 * located.range_m,
                    "{column}: {off} {found} {moved}"
                );
            }
        }
    }
}
