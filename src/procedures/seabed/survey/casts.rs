//! Casts that the survey file names: which water each line has.

use std::path::Path;

use super::super::scene::Line;
use super::file::SeabedSurveyFile;
use crate::formats::sound_speed_csv;
use crate::observe::SoundSpeedProfile;
use crate::survey::problem::SurveyError;
use crate::survey::reading::keep;

/// Casts in order of time.
pub(super) type Casts = Vec<(f64, SoundSpeedProfile)>;

/// Reads every `[[cast]]`.
pub(super) fn read(file: &SeabedSurveyFile, folder: &Path) -> Result<Casts, SurveyError> {
    let (mut problems, mut casts) = (vec![], vec![]);
    for cast in &file.cast {
        let profile = sound_speed_csv::read(&folder.join(&cast.path)).map_err(SurveyError::from);
        casts.extend(keep(&mut problems, profile).map(|profile| (cast.time_s, profile)));
    }
    if !problems.is_empty() {
        return Err(SurveyError { problems });
    }
    casts.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(casts)
}

/// The water of each line, and where it comes from, in words.
pub(super) fn of_lines(
    casts: &[(f64, SoundSpeedProfile)],
    lines: &[Line],
    interpolated: bool,
) -> (Vec<SoundSpeedProfile>, Vec<String>) {
    lines
        .iter()
        .map(|line| of_line(casts, line, interpolated))
        .unzip()
}

fn of_line(
    casts: &[(f64, SoundSpeedProfile)],
    line: &Line,
    interpolated: bool,
) -> (SoundSpeedProfile, String) {
    let middle_s = f64::midpoint(line.start_s, line.end_s);
    let after = casts.partition_point(|cast| cast.0 <= middle_s);
    let (before, after) = (after.saturating_sub(1), after.min(casts.len() - 1));
    let span_s = casts[after].0 - casts[before].0;
    let part = if span_s > 0.0 {
        (middle_s - casts[before].0) / span_s
    } else {
        0.0
    };
    if interpolated && span_s > 0.0 {
        let mixed = between(&casts[before].1, &casts[after].1, part);
        let percent = 100.0 * part;
        let words = format!(
            "line \"{}\": water {percent:.0} % of the way from cast {} to cast {}",
            line.name,
            before + 1,
            after + 1
        );
        return (mixed, words);
    }
    let nearest = if part > 0.5 { after } else { before };
    let words = format!("line \"{}\": water of cast {}", line.name, nearest + 1);
    (casts[nearest].1.clone(), words)
}

/// The profile a part of the way from one to another: at every depth of either, to the end of the deeper one; a profile goes on with its
/// last speed.
fn between(before: &SoundSpeedProfile, after: &SoundSpeedProfile, part: f64) -> SoundSpeedProfile {
    let mut depth_m: Vec<f64> = before
        .depth_m
        .iter()
        .chain(&after.depth_m)
        .copied()
        .collect();
    depth_m.sort_by(f64::total_cmp);
    depth_m.dedup();
    let mix = |depth: &f64| {
        let (a, b) = (speed_at(before, *depth), speed_at(after, *depth));
        a + (b - a) * part
    };
    SoundSpeedProfile {
        speed_m_s: depth_m.iter().map(mix).collect(),
        depth_m,
    }
}

fn speed_at(profile: &SoundSpeedProfile, depth_m: f64) -> f64 {
    let (depths, speeds) = (&profile.depth_m, &profile.speed_m_s);
    let below = depths.partition_point(|d| *d <= depth_m);
    if below == 0 || below == depths.len() {
        return speeds[below.saturating_sub(1)];
    }
    let part = (depth_m - depths[below - 1]) / (depths[below] - depths[below - 1]);
    speeds[below - 1] + (speeds[below] - speeds[below - 1]) * part
}

#[cfg(test)]
mod tests {
    use super::*;

    fn casts() -> Casts {
        let profile = |depth_m: &[f64], speed_m_s: &[f64]| SoundSpeedProfile {
            depth_m: depth_m.to_vec(),
            speed_m_s: speed_m_s.to_vec(),
        };
        vec![
            (100.0, profile(&[0.0, 10.0], &[1500.0, 1490.0])),
            (500.0, profile(&[0.0, 20.0], &[1504.0, 1484.0])),
        ]
    }

    #[test]
    fn between_two_casts_the_water_is_between_them() {
        let (water, words) = of_line(&casts(), &Line::between(150.0, 250.0), true);
        assert_eq!(water.depth_m, [0.0, 10.0, 20.0]);
        // a quarter of the way: 1500 to 1504, 1490 to 1494, 1490 (its last) to 1484
        assert_eq!(water.speed_m_s, [1501.0, 1491.0, 1488.5]);
        assert!(words.contains("25 %"), "{words}");
    }

    #[test]
    fn nearest_is_nearest_and_beyond_the_casts_the_last_one_holds() {
        let (all, interpolated) = (casts(), [false, true]);
        assert_eq!(
            of_line(&all, &Line::between(150.0, 250.0), false).0,
            all[0].1
        );
        assert_eq!(
            of_line(&all, &Line::between(350.0, 450.0), false).0,
            all[1].1
        );
        for interpolated in interpolated {
            assert_eq!(
                of_line(&all, &Line::between(0.0, 50.0), interpolated).0,
                all[0].1
            );
            assert_eq!(
                of_line(&all, &Line::between(600.0, 700.0), interpolated).0,
                all[1].1
            );
        }
    }
}
