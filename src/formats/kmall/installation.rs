//! The installation record (`#IIP`): groups `NAME:key=value;...`, offsets forward, starboard, down in metres, angles in degrees.

use nalgebra::Vector3;

use crate::formats::recorder::{Array, Installation, Mounted, Role};
use crate::observe::Mounting;
use crate::units::radians;

/// Most fields that are kept.
const MOST_FIELDS: usize = 1000;

/// From the record's text.
#[must_use]
pub fn installation(time_s: f64, text: &str) -> Installation {
    let fields = fields(text);
    let groups = group_names(&fields);
    let mut record = Installation {
        time_s,
        fields,
        ..Installation::default()
    };
    record.water_line_m = number(&record, "EMXI", "SWLZ").map(|down| -down);
    for group in &groups {
        if let Some(array) = array(&record, group) {
            record.arrays.push(array);
        }
        if group.starts_with("ATTI_") {
            let sensor = mounted(&record, group, "");
            record.motion_sensors.extend(sensor);
        }
        if group.starts_with("POSI_") {
            let sensor = mounted(&record, group, "");
            record.position_sensors.extend(sensor);
        }
    }
    one_transmitter_serves_all(&mut record.arrays);
    record
}

/// Fields as `group.key` and value. A field without a group name belongs to the group before.
fn fields(text: &str) -> Vec<(String, String)> {
    let mut group = "";
    let mut found = vec![];
    for item in text.split([',', ';', '\n']) {
        let rest = match item.split_once(':') {
            Some((name, rest)) if !name.contains('=') => {
                group = name.trim();
                rest
            }
            _ => item,
        };
        if let Some((key, value)) = rest.split_once('=') {
            found.push((format!("{group}.{}", key.trim()), value.trim().to_owned()));
        }
        if found.len() >= MOST_FIELDS {
            break;
        }
    }
    found
}

fn group_names(fields: &[(String, String)]) -> Vec<String> {
    let mut names: Vec<String> = vec![];
    for (key, _) in fields {
        let name = key.split('.').next().unwrap_or_default();
        if !names.iter().any(|n| n == name) {
            names.push(name.to_owned());
        }
    }
    names
}

fn value<'r>(record: &'r Installation, group: &str, key: &str) -> Option<&'r str> {
    let wanted = |k: &str| k.strip_prefix(group).and_then(|k| k.strip_prefix('.')) == Some(key);
    let found = record.fields.iter().find(|(k, _)| wanted(k))?;
    Some(&found.1)
}

fn number(record: &Installation, group: &str, key: &str) -> Option<f64> {
    value(record, group, key)?
        .parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
}

/// An array of the groups `TRAI_TX1`, `TRAI_RX1` or `TRAI_HD1` (a head that holds both).
fn array(record: &Installation, group: &str) -> Option<Array> {
    let name = group.strip_prefix("TRAI_")?;
    let (role, inner) = match name.get(..2)? {
        "TX" => (Role::Transmit, ["I", "I"]),
        "RX" => (Role::Receive, ["I", "I"]),
        "HD" => (Role::Both, ["IT", "IR"]),
        _ => return None,
    };
    Some(Array {
        mounted: mounted(record, group, "")?,
        role,
        head: name[2..].parse().ok()?,
        inner_m: inner.map(|prefix| offset(record, group, prefix).unwrap_or_default()),
    })
}

/// An offset under a prefix of its keys, right, forward, up.
fn offset(record: &Installation, group: &str, prefix: &str) -> Option<Vector3<f64>> {
    let of = |letter: &str| number(record, group, &format!("{prefix}{letter}"));
    Some(Vector3::new(of("Y")?, of("X")?, -of("Z")?))
}

fn mounted(record: &Installation, group: &str, prefix: &str) -> Option<Mounted> {
    let arm_m = offset(record, group, prefix)?;
    let angle = |key: &str| radians(number(record, group, key).unwrap_or(0.0));
    Some(Mounted {
        name: group.to_owned(),
        mounting: Mounting::from_angles(angle("R"), angle("P"), angle("H"), arm_m),
        delay_s: number(record, group, "D").unwrap_or(0.0),
        active: value(record, group, "U").is_none_or(|used| used == "ACTIVE"),
    })
}

/// A single transmit array serves every head.
fn one_transmitter_serves_all(arrays: &mut [Array]) {
    let mut transmitters = arrays.iter_mut().filter(|a| a.role == Role::Transmit);
    if let (Some(only), None) = (transmitters.next(), transmitters.next()) {
        only.head = 0;
    }
}
