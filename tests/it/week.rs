//! A survey over Saturday midnight: the seconds of the GPS week fall to zero in every file, and are counted on.

use std::path::Path;

use boresight::formats::week::WEEK_S;
use boresight::procedures::pool::survey::{LoadedSurvey, load, scenario, write_survey};
use boresight::simulate::{DEMO, Simulated, simulate};

/// A thinned survey with the week's end in its middle, its files named so.
fn survey(trajectory: &str, lidar: &str) -> (scenario::ScenarioFile, Simulated) {
    let mut file = scenario::from_text(Path::new("demo.toml"), DEMO).expect("the demo");
    let thinned = &mut file.scenario;
    (thinned.multibeam.beams, thinned.lidar.points_per_line) = (16, 20);
    (file.trajectory, file.lidar) = (trajectory.to_owned(), lidar.to_owned());
    thinned.trajectory.velocity = true;
    let mut survey = simulate(&file.scenario, 1).expect("a survey");
    let times = &survey.campaign.trajectory.time_s;
    let shift_s = WEEK_S - times[times.len() / 2].round();
    each_time(&mut survey, |time_s| time_s + shift_s);
    (file, survey)
}

fn each_time(survey: &mut Simulated, change: impl Fn(f64) -> f64) {
    let campaign = &mut survey.campaign;
    let columns = [
        &mut campaign.trajectory.time_s,
        &mut campaign.laser.time_s,
        &mut campaign.soundings.time_s,
    ];
    for time_s in columns.into_iter().flatten() {
        *time_s = change(*time_s);
    }
}

fn loaded(file: &scenario::ScenarioFile, survey: &Simulated) -> LoadedSurvey {
    let folder = tempfile::tempdir().expect("a folder");
    write_survey(folder.path(), file, survey).expect("written");
    load(&folder.path().join("survey.toml")).expect("loaded")
}

#[test]
fn a_survey_goes_on_past_the_end_of_the_week() {
    for (trajectory, lidar) in [
        ("trajectory.csv", "lidar.csv"),
        ("trajectory.sbet", "lidar.laz"),
    ] {
        let (file, mut survey) = survey(trajectory, lidar);
        let counted_on = loaded(&file, &survey);
        each_time(&mut survey, |time_s| time_s.rem_euclid(WEEK_S));
        let fallen = loaded(&file, &survey);
        // times written with nine decimals or as doubles of 1e-10 s
        let same = |a: &[f64], b: &[f64]| {
            assert_eq!(a.len(), b.len());
            assert!(
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-9),
                "{trajectory} {lidar}"
            );
        };
        let (a, b) = (&counted_on.campaign, &fallen.campaign);
        same(&a.trajectory.time_s, &b.trajectory.time_s);
        same(&a.laser.time_s, &b.laser.time_s);
        same(&a.soundings.time_s, &b.soundings.time_s);
        assert!(fallen.notes[0].contains("GPS week"), "{:?}", fallen.notes);
    }
}
