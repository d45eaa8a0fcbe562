//! One or two scenario values over ranges: `KEY=from:to:step` or `KEY=a,b,c`.
//!
//! The value is set in the scenario as it took effect, defaults included, and the whole is read as a scenario again: unknown keys and
//! impossible values are refused as in a scenario file.

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;
use toml::{Table, Value};

use crate::results::SweepValue;
use crate::simulate::scenario::complaint;

/// A name that is handier than the scenario's own key: name, key, factor.
pub type Alias = (&'static str, &'static str, f64);

/// Most values of one key.
const MOST: usize = 1000;

/// A key with the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// As the user wrote it: a dotted path in the scenario; `pass.0.x` is of the first pass, `pass.*.x` of every one.
    pub key: String,
    /// The values.
    pub values: Vec<Setting>,
}

impl Vary {
    /// As the user may write it again: `KEY=a,b,c`.
    #[must_use]
    pub fn text(&self) -> String {
        let values: Vec<String> = self.values.iter().map(ToString::to_string).collect();
        format!("{}={}", self.key, values.join(","))
    }
}

/// A value of a varied key.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A number, in the key's unit.
    Number(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A word.
    Text(String),
}

impl Setting {
    /// For `result.json`.
    #[must_use]
    pub fn plain(&self) -> SweepValue {
        match self {
            Self::Number(number) => SweepValue::Number(*number),
            Self::Flag(flag) => SweepValue::Flag(*flag),
            Self::Text(text) => SweepValue::Text(text.clone()),
        }
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => write!(f, "{text}"),
        }
    }
}

/// A point of a sweep: each varied key with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Point(pub Vec<(String, Setting)>);

impl Point {
    /// As the user reads it: `KEY=value, KEY=value`.
    #[must_use]
    pub fn words(&self) -> String {
        let parts: Vec<String> = self.0.iter().map(|(k, v)| format!("{k}={v}")).collect();
        parts.join(", ")
    }

    /// A name for its file of trials.
    #[must_use]
    pub fn file_name(&self) -> String {
        let safe = |c: char| {
            if c.is_alphanumeric() || "._-=,".contains(c) {
                c
            } else {
                '@'
            }
        };
        let parts: Vec<String> = self.0.iter().map(|(k, v)| format!("{k}={v}")).collect();
        format!("vary-{}", parts.join(","))
            .chars()
            .map(safe)
            .collect()
    }
}

/// A sweep cannot be run.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum VaryError {
    /// Not of the form.
    #[error("--vary {given}: found {found}, expected KEY=from:to:step or KEY=a,b,c")]
    Form {
        /// What the user wrote.
        given: String,
        /// What is wrong with it.
        found: String,
    },
    /// No such key.
    #[error("--vary {key}: found {found}, expected {expected}")]
    Key {
        /// As the user wrote it.
        key: String,
        /// What is wrong with it.
        found: String,
        /// What would do.
        expected: String,
    },
    /// No scenario with this value.
    #[error("--vary {point}: {}", faults.join("; "))]
    Value {
        /// Key and value.
        point: String,
        /// One sentence each.
        faults: Vec<String>,
    },
}

impl std::str::FromStr for Vary {
    type Err = VaryError;

    fn from_str(given: &str) -> Result<Self, VaryError> {
        let form = |found: &str| VaryError::Form {
            given: given.to_owned(),
            found: found.to_owned(),
        };
        let (key, values) = given.split_once('=').ok_or_else(|| form("no \"=\""))?;
        let key = key.trim();
        if key.is_empty() || key.split('.').any(str::is_empty) {
            return Err(form("an empty key or part of a key"));
        }
        let values = if values.contains(':') {
            range(values).map_err(|found| form(&found))?
        } else {
            values.split(',').map(setting).collect()
        };
        if values.contains(&Setting::Text(String::new())) {
            return Err(form("an empty value"));
        }
        if values.len() > MOST {
            return Err(form(&format!("{} values, more than {MOST}", values.len())));
        }
        Ok(Self {
            key: key.to_owned(),
            values,
        })
    }
}

fn setting(text: &str) -> Setting {
    let text = text.trim();
    match (text.parse::<f64>(), text.parse()) {
        (Ok(number), _) if number.is_finite() => Setting::Number(number),
        (_, Ok(flag)) => Setting::Flag(flag),
        _ => Setting::Text(text.to_owned()),
    }
}

/// Both ends included where the step meets them.
fn range(text: &str) -> Result<Vec<Setting>, String> {
    let parts: Vec<f64> = text
        .split(':')
        .map(|part| part.trim().parse().map_err(|_| format!("\"{part}\"")))
        .collect::<Result<_, _>>()?;
    let [from, to, step] = parts[..] else {
        return Err(format!("{} numbers", parts.len()));
    };
    let steps = (to - from) / step;
    if !(steps.is_finite() && steps >= 0.0 && step != 0.0) {
        return Err(format!("no way from {from} to {to} in steps of {step}"));
    }
    if steps >= MOST as f64 {
        return Err(format!("more than {MOST} values"));
    }
    let count = (steps + 1e-9).floor() as usize;
    let value = |k: usize| Setting::Number(tidy(from + k as f64 * step));
    Ok((0..=count).map(value).collect())
}

/// Without the rounding error of the steps: twelve significant digits.
fn tidy(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Every point of the sweep: of two keys every pair, the first varying slowest.
#[must_use]
pub fn points(vary: &[Vary]) -> Vec<Point> {
    let mut all = vec![Point(vec![])];
    for v in vary {
        let longer = |point: &Point| {
            v.values
                .iter()
                .map(|value| with(point, &v.key, value))
                .collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.retain(|point| !point.0.is_empty());
    all
}

fn with(point: &Point, key: &str, value: &Setting) -> Point {
    let mut longer = point.clone();
    longer.0.push((key.to_owned(), value.clone()));
    longer
}

/// The scenario at a point; `aliases` are its handier names and `check` lists what is wrong with its values.
///
/// # Errors
/// [`VaryError`]: a key that no scenario has (with the nearest known one), or a value that makes it impossible.
pub fn at<S: Serialize + DeserializeOwned>(
    scenario: &S,
    point: &Point,
    aliases: &[Alias],
    check: impl Fn(&S) -> Vec<String>,
) -> Result<S, VaryError> {
    let value_error = |faults| VaryError::Value {
        point: point.words(),
        faults,
    };
    let tree = Table::try_from(scenario).map_err(|e| value_error(vec![e.to_string()]))?;
    let mut tree = Value::Table(tree);
    for (key, setting) in &point.0 {
        let (path, value) = resolved(key, setting, aliases);
        let misfit = |(found, expected)| VaryError::Key {
            key: key.clone(),
            found,
            expected,
        };
        set(&mut tree, &path.split('.').collect::<Vec<_>>(), &value).map_err(misfit)?;
    }
    let read =
        S::deserialize(tree).map_err(|e| value_error(vec![complaint(e.message().trim())]))?;
    match check(&read) {
        faults if faults.is_empty() => Ok(read),
        faults => Err(value_error(faults)),
    }
}

/// The scenario's own key and the TOML value.
fn resolved(key: &str, setting: &Setting, aliases: &[Alias]) -> (String, Value) {
    let alias = aliases.iter().find(|(name, ..)| *name == key);
    let path = alias.map_or(key, |(_, path, _)| path).to_owned();
    let value = match setting {
        Setting::Number(number) => {
            toml_number(number * alias.map_or(1.0, |(_, _, factor)| *factor))
        }
        Setting::Flag(flag) => Value::Boolean(*flag),
        Setting::Text(text) => Value::String(text.clone()),
    };
    (path, value)
}

/// Whole numbers as integers, which a key for a float takes as well.
fn toml_number(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 {
        Value::Integer(number as i64)
    } else {
        Value::Float(number)
    }
}

/// Found and expected.
type Misfit = (String, String);

/// Sets every place that the path names. A name that a table does not have is added: the scenario's reader judges it.
fn set(tree: &mut Value, path: &[&str], value: &Value) -> Result<(), Misfit> {
    let Some((first, rest)) = path.split_first() else {
        if tree.is_table() || tree.is_array() {
            let found = format!("a {}", tree.type_str());
            return Err((found, "the key of a single value".to_owned()));
        }
        *tree = value.clone();
        return Ok(());
    };
    match tree {
        Value::Table(table) => {
            let empty = if rest.is_empty() {
                Value::Boolean(false)
            } else {
                Value::Table(Table::new())
            };
            let below = table.entry((*first).to_owned()).or_insert(empty);
            set(below, rest, value)
        }
        Value::Array(list) if *first == "*" => {
            list.iter_mut().try_for_each(|item| set(item, rest, value))
        }
        Value::Array(list) => {
            let length = list.len();
            let item = first.parse().ok().and_then(|k: usize| list.get_mut(k));
            let expected = match length {
                0 => "a key that is not empty in this scenario".to_owned(),
                n => format!("\"*\" or an index from 0 to {}", n - 1),
            };
            let item = item.ok_or_else(|| (format!("\"{first}\""), expected))?;
            set(item, rest, value)
        }
        _ => Err((
            format!("\"{first}\" below a single value"),
            "a key of the scenario".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{DEMO, Scenario, Source};

    const ALIASES: [Alias; 1] = [("multibeam.tilt_deg", "multibeam.mounting_deg.roll", -1.0)];

    fn demo() -> Scenario {
        Scenario::from_toml(DEMO).expect("the demo")
    }

    fn swept(vary: &[&str]) -> Result<Vec<(Point, Scenario)>, VaryError> {
        let vary: Vec<Vary> = vary.iter().map(|v| v.parse()).collect::<Result<_, _>>()?;
        let found = points(&vary).into_iter().map(|point| {
            let scenario = at(&demo(), &point, &ALIASES, Scenario::check)?;
            Ok((point, scenario))
        });
        found.collect()
    }

    fn fault(vary: &[&str]) -> String {
        swept(vary).expect_err("a fault").to_string()
    }

    fn numbers(text: &str) -> Vec<f64> {
        let vary: Vary = text.parse().expect("a sweep");
        let number = |s: &Setting| match s {
            Setting::Number(n) => *n,
            other => panic!("{other}"),
        };
        vary.values.iter().map(number).collect()
    }

    #[test]
    fn ranges_include_both_ends_and_have_no_rounding_noise() {
        assert_eq!(
            numbers("a.b=20:60:5"),
            [20., 25., 30., 35., 40., 45., 50., 55., 60.]
        );
        assert_eq!(numbers("a=0.1:0.5:0.1"), [0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!(numbers("a=3:-3:-2"), [3.0, 1.0, -1.0, -3.0]);
        assert_eq!(numbers("a=1:2:0.3"), [1.0, 1.3, 1.6, 1.9]);
        assert_eq!(numbers("a=2:2:1"), [2.0]);
        assert_eq!(numbers("a=0.001, 1e-2,5"), [0.001, 0.01, 5.0]);
    }

    #[test]
    fn what_is_no_sweep_is_said() {
        for (text, expected) in [
            ("multibeam.beams", "no \"=\""),
            ("=3", "an empty key"),
            ("a..b=3", "an empty key"),
            ("a=1:2", "2 numbers"),
            ("a=1:x:2", "\"x\""),
            ("a=1:2:-1", "no way from 1 to 2 in steps of -1"),
            ("a=1:2:0", "no way"),
            ("a=0:1:1e-9", "more than 1000"),
            ("a=1,,2", "an empty value"),
        ] {
            let message = fault(&[text]);
            assert!(message.contains(expected), "{text}: {message}");
            assert!(message.contains("expected KEY=from:to:step"), "{message}");
        }
    }

    #[test]
    fn values_are_set_where_the_key_says() {
        let found = swept(&["multibeam.beams=64,128", "pass.*.distance_m=5:7:1"]).expect("points");
        assert_eq!(found.len(), 6);
        let (point, scenario) = &found[5];
        assert_eq!(
            point.0[1],
            ("pass.*.distance_m".into(), Setting::Number(7.0))
        );
        assert_eq!(scenario.multibeam.beams, 128);
        assert!(scenario.pass.iter().all(|p| p.distance_m == 7.0));
        let mut expected = demo();
        expected.multibeam.beams = 64;
        for pass in &mut expected.pass {
            pass.distance_m = 5.0;
        }
        assert_eq!(found[0].1, expected, "nothing else changes");
    }

    #[test]
    fn indices_switches_words_and_aliases() {
        let at = |text: &str| swept(&[text]).expect(text)[0].1.clone();
        let first = at("pass.0.distance_m=9.5");
        assert_eq!(first.pass[0].distance_m, 9.5);
        assert_eq!(first.pass[1..], demo().pass[1..]);
        let switched = at("sources.position_drift=0.5");
        assert_eq!(switched.sources.factor(Source::PositionDrift), 0.5);
        assert_eq!(
            at("multibeam.tilt_deg=30").multibeam.mounting_deg.roll,
            -30.0
        );
        assert_eq!(
            at("lidar.mounting_sigma_deg.2=0.1")
                .lidar
                .mounting_sigma_deg[2],
            0.1
        );
        assert!(at("trajectory.velocity=true").trajectory.velocity);
        let floor = at("basin.floor_m=-9");
        assert_eq!(floor.basin.floor_m, Some(-9.0));
    }

    #[test]
    fn unknown_keys_come_with_the_nearest_one_and_impossible_values_with_their_limits() {
        for (text, expected) in [
            ("multibem.beams=64", "nearest known one is \"multibeam\""),
            ("multibeam.beam=64", "nearest known one is \"beams\""),
            (
                "sources.position_drit=1",
                "nearest known one is \"position_drift\"",
            ),
            (
                "pass.9.distance_m=4",
                "found \"9\", expected \"*\" or an index",
            ),
            ("pass.first.distance_m=4", "found \"first\""),
            ("multibeam.beams.x=4", "below a single value"),
            ("multibeam.mounting_deg=4", "found a table"),
            (
                "multibeam.beams=1",
                "multibeam.beams = 1, expected 2 to 30000",
            ),
            ("multibeam.beams=1.5", "1.5"),
            ("multibeam.range_sigma_m=large", "large"),
            ("pass.0.speed_m_s=-1", "pass[0].speed_m_s = -1"),
        ] {
            let message = fault(&[text]);
            assert!(message.contains(expected), "{text}: {message}");
            assert!(message.starts_with("--vary "), "{message}");
        }
    }

    #[test]
    fn a_point_s_file_name_stays_in_its_folder() {
        let found = swept(&["pass.*.distance_m=6"]).expect("points");
        assert_eq!(found[0].0.file_name(), "vary-pass.@.distance_m=6");
        let point = Point(vec![("a".into(), Setting::Text("../x".into()))]);
        assert_eq!(point.file_name(), "vary-a=..@x");
    }
}
