//! Cuts of the trajectory change figures by rounding alone, and a file in place of memory changes nothing.

use std::path::Path;

use boresight::procedures::pool::survey::{scenario, write_survey};
use boresight::simulate::{DEMO, simulate};
use serde_json::Value;

/// The result of a thinned demo with this `[large]` section.
fn result(large: &str) -> Value {
    let mut file = scenario::from_text(Path::new("demo.toml"), DEMO).expect("the demo");
    let thinned = &mut file.scenario;
    (thinned.multibeam.beams, thinned.lidar.points_per_line) = (16, 20);
    let folder = tempfile::tempdir().expect("a folder");
    let survey = simulate(&file.scenario, 1).expect("a survey");
    write_survey(folder.path(), &file, &survey).expect("written");
    let path = folder.path().join("survey.toml");
    let text = std::fs::read_to_string(&path).expect("read");
    std::fs::write(&path, format!("{text}\n[large]\n{large}\n")).expect("written");
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
