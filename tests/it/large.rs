//! Cuts of the trajectory change figures by rounding alone, and a file in place of memory changes nothing.

use std::path::{Path, PathBuf};

use boresight::calibrate::cloud::SensorModel;
use boresight::files::spill::Spill;
use boresight::observe::{Room, Sounding, SoundingWriter, Soundings};
use boresight::procedures::pool::apply::cloud;
use boresight::procedures::pool::survey::{load, scenario, write_survey};
use boresight::simulate::{DEMO, simulate};
use boresight::watch::Unwatched;
use boresight::{Loaded, Settings};
use serde_json::Value;

/// A thinned demo in a folder, with this `[large]` section.
fn survey(folder: &Path, large: &str) -> PathBuf {
    let mut file = scenario::from_text(Path::new("demo.toml"), DEMO).expect("the demo");
    let thinned = &mut file.scenario;
    (thinned.multibeam.beams, thinned.lidar.points_per_line) = (16, 20);
    let survey = simulate(&file.scenario, 1).expect("a survey");
    write_survey(folder, &file, &survey).expect("written");
    let path = folder.join("survey.toml");
    let text = std::fs::read_to_string(&path).expect("read");
    std::fs::write(&path, format!("{text}\n[large]\n{large}\n")).expect("written");
    path
}

/// The result of a thinned demo with this `[large]` section.
fn result(large: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let path = survey(folder.path(), large);
    let found = boresight::calibrate(&path).expect("calibrated").result;
    assert!(found.usable);
    let mut all = serde_json::to_value(found).expect("JSON");
    let object = all.as_object_mut().expect("an object");
    for differs in ["inputs", "configuration"] {
        assert!(object.remove(differs).is_some(), "{differs}");
    }
    all
}

/// Largest difference of two numbers at the same place, as a part of the larger; where either is no number they must be the same.
fn apart(a: &Value, b: &Value, place: &str) -> (f64, String) {
    let worse = |x: (f64, String), y: (f64, String)| if y.0 > x.0 { y } else { x };
    let none = || (0.0, place.to_owned());
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert!(a.keys().eq(b.keys()), "{place}");
            let each = a
                .iter()
                .map(|(key, a)| apart(a, &b[key], &format!("{place}.{key}")));
            each.fold(none(), worse)
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            let each = a.iter().zip(b).enumerate();
            let each = each.map(|(i, (a, b))| apart(a, b, &format!("{place}[{i}]")));
            each.fold(none(), worse)
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a double"), b.as_f64().expect("a double"));
            let size = a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
            ((a - b).abs() / size, place.to_owned())
        }
        _ => {
            assert_eq!(a, b, "{place}");
            none()
        }
    }
}

#[test]
fn cuts_change_figures_by_rounding_and_a_file_changes_nothing() {
    let mut whole = result("");
    let mut cut = result("block_records = 100");
    let spilled = result("block_records = 100\nfactor_memory_mb = 0");
    assert_eq!(cut, spilled);
    assert_eq!(whole, result("factor_memory_mb = 0\nspill = \".\""));
    // score tests go down to a millionth of a suspect's information, and lose as many digits
    for (part, limit) in [("verdict", 1e-8), ("solutions", 1e-9)] {
        let take = |from: &mut Value| from.as_object_mut().and_then(|all| all.remove(part));
        let (a, b) = (take(&mut whole).expect(part), take(&mut cut).expect(part));
        let (largest, place) = apart(&a, &b, part);
        println!("{largest:e} at {place}");
        assert!(largest > 0.0, "the survey was not cut");
        assert!(largest < limit, "{largest:e} at {place}");
    }
    let (largest, place) = apart(&whole, &cut, "");
    assert!(largest < 1e-9, "{largest:e} at {place}");
}

/// Of soundings in a file nothing differs: not the result, not what is said of it beforehand, not the points.
#[test]
fn soundings_in_a_file_change_nothing() {
    let whole = result("");
    for kept in [
        "observations_memory_mb = 0",
        "observations_memory_mb = 0\nfactor_memory_mb = 0\nspill = \".\"",
    ] {
        assert_eq!(whole, result(kept), "{kept}");
    }
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let [memory, file] = ["", "observations_memory_mb = 0"];
    let paths = [
        survey(folders[0].path(), memory),
        survey(folders[1].path(), file),
    ];
    let said = |path: &PathBuf| boresight::check(path).expect("checked");
    let (a, b) = (said(&paths[0]), said(&paths[1]));
    assert_eq!((a.text, a.json), (b.text, b.json));
    let [a, b] = paths.map(|path| load(&path).expect("a survey"));
    assert!(a.campaign.soundings.file.is_none() && b.campaign.soundings.file.is_some());
    let model = SensorModel::plain(a.campaign.sonar);
    let points = |survey| {
        let cloud = cloud(survey, &model).expect("points");
        let chunks = cloud.chunks.map(|chunk| chunk.expect("readable"));
        chunks.flatten().collect::<Vec<_>>()
    };
    assert_eq!(points(&a), points(&b));
}

/// Of several heads only the soundings of the wanted one go to the file; one head with its number goes there as one without.
#[test]
fn soundings_of_one_head_go_to_the_file() {
    let read = |large: &str, both: bool, wanted: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = survey(folder.path(), large);
        let soundings = folder.path().join("multibeam.csv");
        let text = std::fs::read_to_string(&soundings).expect("read");
        let mut lines = text.lines();
        let mut out = lines.next().expect("a header").to_owned() + ",head\n";
        for (k, line) in lines.enumerate() {
            let head = if both && k % 3 == 1 { 7 } else { 4 };
            out.push_str(&format!("{line},{head}\n"));
        }
        std::fs::write(&soundings, out).expect("written");
        let text = std::fs::read_to_string(&path).expect("read");
        let text = text.replace("[multibeam]", &format!("[multibeam]\n{wanted}"));
        std::fs::write(&path, text).expect("written");
        load(&path)
    };
    let row = |s: &Soundings, k| (s.at_s(k), s.measured(k), s.name(k));
    let file = "observations_memory_mb = 0";
    for (both, wanted) in [(true, "head = 7"), (true, "head = 4"), (false, "")] {
        let [a, b] = ["", file].map(|large| read(large, both, wanted).expect("a survey"));
        let (a, b) = (&a.campaign.soundings, &b.campaign.soundings);
        assert!(a.file.is_none() && b.file.is_some());
        assert!(a.len() == b.len() && a.len() > 1000);
        assert!((0..a.len()).all(|k| row(a, k) == row(b, k)));
    }
    let refused = |wanted| read(file, true, wanted).expect_err("refused").to_string();
    assert!(refused("").contains("soundings of the heads 4, 7"));
    assert!(refused("head = 5").contains("head 5; there are soundings of 4, 7"));
}

/// What was kept in a file and cannot be read again ends every command in a sentence, and leaves nothing behind.
#[cfg(unix)]
#[test]
fn soundings_that_cannot_be_read_again_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = survey(folder.path(), "");
    let mut survey = load(&path).expect("a survey");
    let whole = &survey.campaign.soundings;
    // a device that takes everything and gives nothing back
    let null = std::fs::File::options().write(true).open("/dev/null");
    let spill = Spill::over(null.expect("the device"), "/scratch".to_owned());
    let mut writer = SoundingWriter::over(spill);
    for k in 0..whole.len() {
        let ([across_rad, along_rad, range], (ping, beam)) = (whole.measured(k), whole.name(k));
        let time_s = whole.at_s(k);
        let row = Sounding {
            time_s,
            ping,
            beam,
            across_rad,
            along_rad,
            range,
        };
        writer.push(&row).expect("written");
    }
    let room = Room {
        bytes: 0,
        folder: None,
    };
    survey.campaign.soundings = Soundings {
        file: Some(writer.finish().expect("a file")),
        ..whole.clone().within(&room).expect("a file")
    };
    let model = SensorModel::plain(survey.campaign.sonar);
    let cloud = cloud(&survey, &model).expect("begun");
    let ended: Result<Vec<_>, _> = cloud.chunks.collect();
    let said = ended.expect_err("refused").to_string();
    assert!(
        said.starts_with("soundings: cannot read in /scratch: "),
        "{said}"
    );
    let settings = Settings::default();
    let calibrated = survey.calibrate(&settings, None, &Unwatched);
    let said = calibrated.expect_err("refused").to_string();
    assert!(said.contains("cannot read in /scratch"), "{said}");
}

/// Soundings that the trajectory does not cover leave the file, others keep their place; the clock is shifted.
#[test]
fn soundings_without_a_position_leave_the_file() {
    let read = |large: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = survey(folder.path(), large);
        let text = std::fs::read_to_string(&path).expect("read");
        let text = text
            .replace("[trajectory]", "[trajectory]\noutside = \"drop\"")
            .replace("[multibeam]", "[multibeam]\ntime_offset_s = 5.3");
        std::fs::write(&path, text).expect("written");
        load(&path).expect("a survey")
    };
    let (a, b) = (read(""), read("observations_memory_mb = 0"));
    assert_eq!((a.counts, &a.notes), (b.counts, &b.notes));
    assert!(a.counts.soundings_dropped > 100 && a.counts.soundings > 1000);
    let (a, b) = (&a.campaign.soundings, &b.campaign.soundings);
    let row = |s: &Soundings, k| (s.at_s(k), s.measured(k), s.name(k));
    assert!((0..a.len()).all(|k| row(a, k) == row(b, k)));
}

#[test]
fn a_missing_folder_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = survey(
        folder.path(),
        "observations_memory_mb = 0\nspill = \"nowhere\"",
    );
    let error = load(&path).expect_err("no folder").to_string();
    let place = folder.path().join("nowhere");
    let named = format!("{}: folder for what exceeds memory", place.display());
    assert!(error.starts_with(&named), "{error}");
    assert!(error.contains("[large] observations_memory_mb"), "{error}");
}
