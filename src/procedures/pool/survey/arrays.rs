//! A survey whose observations are in memory instead of files.

use std::path::Path;

use super::file::SurveyFile;
use super::load::{Counts, LoadedSurvey, Observed, notes, parse_survey, parse_target, placed};
use super::observations::{laser_problem, to_geocentric};
use crate::formats::{LaserRecords, SoundingRecords};
use crate::observe::{
    Campaign, GeodeticTrajectory, LaserScan, SoundSpeed, SoundingRange, Soundings,
};
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::keep;

/// Observations and target in memory.
#[derive(Clone, Debug)]
pub struct Arrays {
    /// The INS trajectory.
    pub trajectory: GeodeticTrajectory,
    /// The laser returns.
    pub laser: LaserScan,
    /// The soundings.
    pub soundings: Soundings,
    /// Sound speed, needed by travel times.
    pub sound_speed: Option<SoundSpeed>,
    /// The text of the target file.
    pub target: String,
}

impl LoadedSurvey {
    /// A survey from a survey file's text (mountings, frames, pose of the target, limits of the trajectory, configuration) and
    /// observations in memory. The noise that counts is that of the observations; the noise in the text, and its paths, are for the
    /// record. UTM coordinates of returns become geocentric ones. No file is read, and [`LoadedSurvey::inputs`] is empty.
    ///
    /// # Errors
    /// [`SurveyError`] with everything that is wrong, by the names `survey`, `target`, `trajectory`, `laser`, `soundings` and
    /// `sound_speed` instead of files.
    pub fn from_arrays(text: &str, arrays: Arrays) -> Result<Self, SurveyError> {
        let mut problems = vec![];
        let file = keep(&mut problems, parse_survey(Path::new("survey"), text, None));
        let target = keep(
            &mut problems,
            parse_target(Path::new("target"), &arrays.target),
        );
        problems.extend(faults(&arrays));
        let (Some(file), Some((target_model, target))) = (file, target) else {
            return Err(SurveyError { problems });
        };
        none_of(problems)?;
        let (campaign, counts) = campaign(&file, arrays)?;
        Ok(Self {
            pose: file.target.pose(),
            notes: notes(&counts, &campaign),
            file,
            campaign,
            target_model,
            target,
            inputs: vec![],
            counts,
            recorders: vec![],
        })
    }
}

/// The observations that the trajectory covers, or what is wrong with their times.
fn campaign(file: &SurveyFile, arrays: Arrays) -> Result<(Campaign, Counts), SurveyError> {
    let Arrays {
        mut trajectory,
        laser,
        soundings,
        sound_speed,
        ..
    } = arrays;
    trajectory.ellipsoid = file.target.ellipsoid;
    trajectory.max_gap_s = file.trajectory.max_gap_s;
    trajectory.outside = file.trajectory.outside.into();
    let (laser_noise, sonar_noise) = (laser.noise, soundings.noise);
    let mut laser = LaserRecords {
        time_s: laser.time_s,
        x_m: laser.x_m,
        y_m: laser.y_m,
        z_m: laser.z_m,
        notes: vec![],
    };
    let soundings = SoundingRecords {
        time_s: soundings.time_s,
        ping: soundings.ping,
        beam: soundings.beam,
        across_rad: soundings.across_rad,
        along_rad: soundings.along_rad,
        range: soundings.range,
        arrays: None,
        head: vec![],
        notes: vec![],
    };
    let of_laser = Path::new("laser");
    let problems = Vec::from_iter(laser_problem(of_laser, &laser, file.lidar.coordinates));
    if let Some(zone) = file.lidar.zone().filter(|_| problems.is_empty()) {
        to_geocentric(of_laser, &mut laser, file.target.ellipsoid, zone)?;
    }
    let observed = Observed {
        trajectory,
        laser,
        laser_noise,
        soundings,
        streamed: None,
        sonar_noise,
        sound_speed,
    };
    placed(file, [of_laser, Path::new("soundings")], observed, problems)
}

/// What a column may hold.
struct Column<'a> {
    of: &'static str,
    name: &'static str,
    values: &'a [f64],
    fits: fn(f64) -> bool,
    expected: &'static str,
}

impl Column<'_> {
    /// Its length, or its first value that cannot be.
    fn fault(&self, rows: usize) -> Option<Problem> {
        let problem = |place: String, found: String, expected: &str| {
            Some(Problem::new(Path::new(self.of), place, found, expected))
        };
        if self.values.len() != rows {
            let found = format!("{} rows", self.values.len());
            let expected = format!("{rows} rows, as many as time_s");
            return problem(self.name.to_owned(), found, &expected);
        }
        let row = self.values.iter().position(|v| !(self.fits)(*v))?;
        let place = format!("{}, row {row}", self.name);
        problem(place, self.values[row].to_string(), self.expected)
    }
}

/// Everything that is wrong with the columns, one fault a column.
fn faults(arrays: &Arrays) -> Vec<Problem> {
    let mut problems = trajectory_faults(&arrays.trajectory);
    problems.extend(laser_faults(&arrays.laser));
    problems.extend(sounding_faults(&arrays.soundings));
    problems.extend(speed_faults(arrays));
    problems
}

fn finite(value: f64) -> bool {
    value.is_finite()
}

fn right_angle(value: f64) -> bool {
    value.abs() <= std::f64::consts::FRAC_PI_2
}

/// A turn and a rounding error, so that 360 degrees in radians pass.
fn turn(value: f64) -> bool {
    value.abs() <= std::f64::consts::TAU + 1e-9
}

fn trajectory_faults(t: &GeodeticTrajectory) -> Vec<Problem> {
    const OF: &str = "trajectory";
    const ANGLE: &str = "radians from -2 pi to 2 pi (are they degrees?)";
    let column = |name, values, fits, expected| Column {
        of: OF,
        name,
        values,
        fits,
        expected,
    };
    let height: fn(f64) -> bool = |v| v.abs() <= 12_000.0;
    let columns = [
        column(
            "latitude_rad",
            &t.latitude_rad[..],
            right_angle,
            "radians from -pi/2 to pi/2 (are they degrees?)",
        ),
        column("longitude_rad", &t.longitude_rad, turn, ANGLE),
        column(
            "height_m",
            &t.height_m,
            height,
            "metres from -12000 to 12000",
        ),
        column("roll_rad", &t.roll_rad, turn, ANGLE),
        column("pitch_rad", &t.pitch_rad, turn, ANGLE),
        column("heading_rad", &t.heading_rad, turn, ANGLE),
    ];
    let rows = t.time_s.len();
    let mut problems = Vec::from_iter(time_fault(OF, &t.time_s, true));
    if rows < 2 {
        let found = format!("{rows} record{}", if rows == 1 { "" } else { "s" });
        problems.push(Problem::new(
            Path::new(OF),
            "time_s",
            found,
            "at least two records",
        ));
    }
    problems.extend(columns.iter().filter_map(|c| c.fault(rows)));
    if let Some(velocity) = &t.velocity_m_s {
        problems.extend(velocity_fault(velocity, rows));
    }
    problems
}

fn velocity_fault(velocity: &[[f64; 3]], rows: usize) -> Option<Problem> {
    let problem = |place: String, found: String, expected: String| {
        Some(Problem::new(
            Path::new("trajectory"),
            place,
            found,
            expected,
        ))
    };
    if velocity.len() != rows {
        let expected = format!("{rows} rows, as many as time_s");
        return problem(
            "velocity_m_s".to_owned(),
            format!("{} rows", velocity.len()),
            expected,
        );
    }
    let row = velocity
        .iter()
        .position(|v| v.iter().any(|v| !(v.abs() < 1000.0)))?;
    let found = format!("{:?}", velocity[row]);
    problem(
        format!("velocity_m_s, row {row}"),
        found,
        "m/s within 1000".to_owned(),
    )
}

fn laser_faults(l: &LaserScan) -> Vec<Problem> {
    const OF: &str = "laser";
    let rows = l.time_s.len();
    let mut problems = Vec::from_iter(time_fault(OF, &l.time_s, false));
    for (name, values) in [("x_m", &l.x_m), ("y_m", &l.y_m), ("z_m", &l.z_m)] {
        let column = Column {
            of: OF,
            name,
            values,
            fits: finite,
            expected: "metres",
        };
        problems.extend(column.fault(rows));
    }
    problems
}

fn sounding_faults(s: &Soundings) -> Vec<Problem> {
    const OF: &str = "soundings";
    const RADIANS: &str = "radians (are they degrees?)";
    let (name, fits, expected): (_, fn(f64) -> bool, _) = match &s.range {
        SoundingRange::Metres(_) => (
            "range_m",
            |v| v > 0.0 && v <= 20_000.0,
            "a range above 0 m and up to 20000 m (is it in millimetres?)",
        ),
        SoundingRange::TwoWayTravelTime(_) => (
            "travel_time_s",
            |v| v > 0.0 && v <= 30.0,
            "a two-way travel time above 0 s and up to 30 s (seconds, not milliseconds)",
        ),
    };
    let half_turn: fn(f64) -> bool = |v| v.abs() <= std::f64::consts::PI + 1e-9;
    let column = |name, values, fits, expected| Column {
        of: OF,
        name,
        values,
        fits,
        expected,
    };
    let columns = [
        column("across_rad", &s.across_rad[..], half_turn, RADIANS),
        column("along_rad", &s.along_rad, right_angle, RADIANS),
        column(name, s.range.values(), fits, expected),
    ];
    let rows = s.time_s.len();
    let mut problems = Vec::from_iter(time_fault(OF, &s.time_s, false));
    problems.extend(columns.iter().filter_map(|c| c.fault(rows)));
    for (name, values) in [("ping", &s.ping), ("beam", &s.beam)] {
        if values.len() != rows {
            let found = format!("{} rows", values.len());
            let expected = format!("{rows} rows, as many as time_s");
            problems.push(Problem::new(Path::new(OF), name, found, expected));
        }
    }
    problems
}

/// The first time that is no number or comes before the one above it; `strictly` also one that equals it.
fn time_fault(of: &'static str, time_s: &[f64], strictly: bool) -> Option<Problem> {
    let rises = |k: usize| {
        let (before, now) = (time_s[k - 1], time_s[k]);
        if strictly {
            now > before
        } else {
            now >= before
        }
    };
    let wrong = |k: usize| !finite(time_s[k]) || (k > 0 && !rises(k));
    let row = (0..time_s.len()).find(|&k| wrong(k))?;
    let expected = match (finite(time_s[row]), strictly) {
        (false, _) => "seconds".to_owned(),
        (true, true) => format!("a time after that of the row before, {}", time_s[row - 1]),
        (true, false) => format!(
            "a time not before that of the row before, {}",
            time_s[row - 1]
        ),
    };
    let place = format!("time_s, row {row}");
    Some(Problem::new(
        Path::new(of),
        place,
        time_s[row].to_string(),
        expected,
    ))
}

/// Travel times without a sound speed, or a profile that no ray can follow.
fn speed_faults(arrays: &Arrays) -> Vec<Problem> {
    const OF: &str = "sound_speed";
    let problem = |place: &str, found: String, expected: &str| {
        vec![Problem::new(Path::new(OF), place, found, expected)]
    };
    let speed = |v: f64| (1000.0..=2000.0).contains(&v);
    match (&arrays.sound_speed, &arrays.soundings.range) {
        (None, SoundingRange::TwoWayTravelTime(_)) => {
            let expected = "a speed or a profile, as the soundings are travel times";
            problem("whole argument", "nothing".to_owned(), expected)
        }
        (Some(SoundSpeed::Constant(v)), _) if !speed(*v) => {
            problem("whole argument", v.to_string(), "1000 to 2000 m/s")
        }
        (Some(SoundSpeed::Profile(p)), _) => {
            let rises = p.depth_m.windows(2).all(|w| w[1] > w[0]);
            if p.depth_m.len() != p.speed_m_s.len() || p.depth_m.is_empty() {
                let found = format!(
                    "{} depths and {} speeds",
                    p.depth_m.len(),
                    p.speed_m_s.len()
                );
                return problem("profile", found, "as many of each, at least one");
            }
            if !rises || !p.depth_m.iter().all(|d| (0.0..=12_000.0).contains(d)) {
                return problem(
                    "depth_m",
                    "depths that do not rise".to_owned(),
                    "metres from 0 to 12000, each above the one before",
                );
            }
            match p.speed_m_s.iter().position(|v| !speed(*v)) {
                Some(row) => problem(
                    &format!("speed_m_s, row {row}"),
                    p.speed_m_s[row].to_string(),
                    "1000 to 2000 m/s",
                ),
                None => vec![],
            }
        }
        _ => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::pool::survey::scenario::from_text;
    use crate::procedures::pool::survey::{load, write_survey};
    use crate::simulate::{DEMO, simulate};

    /// A small survey as files, read again, with the texts of its survey and target file.
    fn from_files() -> (LoadedSurvey, String, String) {
        let mut file = from_text(Path::new("demo"), DEMO).expect("the demo");
        (
            file.scenario.multibeam.beams,
            file.scenario.lidar.points_per_line,
        ) = (16, 20);
        let survey = simulate(&file.scenario, 1).expect("a survey");
        let folder = tempfile::tempdir().expect("folder");
        write_survey(folder.path(), &file, &survey).expect("written");
        let text = |name| std::fs::read_to_string(folder.path().join(name)).expect("text");
        let read = load(&folder.path().join("survey.toml")).expect("readable");
        (read, text("survey.toml"), text("target.toml"))
    }

    fn arrays(read: &LoadedSurvey, target: &str) -> Arrays {
        let c = read.campaign.clone();
        Arrays {
            trajectory: c.trajectory,
            laser: c.laser,
            soundings: c.soundings,
            sound_speed: c.sound_speed,
            target: target.to_owned(),
        }
    }

    #[test]
    fn a_survey_from_arrays_is_the_one_from_files() {
        let (read, text, target) = from_files();
        let made = LoadedSurvey::from_arrays(&text, arrays(&read, &target)).expect("a survey");
        assert_eq!(made.campaign.trajectory, read.campaign.trajectory);
        assert_eq!(made.campaign.laser, read.campaign.laser);
        assert_eq!(made.campaign.soundings, read.campaign.soundings);
        assert_eq!(made.campaign.sonar, read.campaign.sonar);
        assert_eq!(
            (made.file, made.counts, made.pose),
            (read.file, read.counts, read.pose)
        );
        assert!(made.inputs.is_empty());
    }

    #[test]
    fn every_fault_of_every_column_is_named_at_once() {
        let (read, text, target) = from_files();
        let mut wrong = arrays(&read, &target);
        wrong.trajectory.roll_rad.pop();
        wrong.trajectory.time_s[3] = wrong.trajectory.time_s[2];
        wrong.laser.x_m[7] = f64::NAN;
        wrong.soundings.across_rad[5] = 45.0;
        wrong.soundings.beam.pop();
        let text = format!("{text}\n[joint]\nlatncy = true\n");
        let error = LoadedSurvey::from_arrays(&text, wrong)
            .expect_err("refused")
            .to_string();
        for part in [
            "latency",
            "trajectory: roll_rad: found",
            "trajectory: time_s, row 3: found",
            "laser: x_m, row 7: found NaN",
            "soundings: across_rad, row 5: found 45, expected radians",
            "soundings: beam: found",
        ] {
            assert!(error.contains(part), "{part}\n{error}");
        }
    }

    #[test]
    fn travel_times_need_a_sound_speed() {
        let (read, text, target) = from_files();
        let mut wrong = arrays(&read, &target);
        let seconds = wrong
            .soundings
            .range
            .values()
            .iter()
            .map(|r| r / 750.0)
            .collect();
        wrong.soundings.range = SoundingRange::TwoWayTravelTime(seconds);
        wrong.sound_speed = None;
        let error = LoadedSurvey::from_arrays(&text, wrong.clone()).expect_err("refused");
        assert!(
            error
                .to_string()
                .contains("as the soundings are travel times"),
            "{error}"
        );
        wrong.sound_speed = Some(SoundSpeed::Constant(15.0));
        let error = LoadedSurvey::from_arrays(&text, wrong).expect_err("refused");
        assert!(
            error
                .to_string()
                .contains("found 15, expected 1000 to 2000"),
            "{error}"
        );
    }
}
