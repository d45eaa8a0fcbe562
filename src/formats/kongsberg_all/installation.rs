//! The installation record (`I`, `i`): `KEY=value,` with angles in degrees and offsets forward, starboard, down in metres.

use nalgebra::Vector3;

use crate::formats::recorder::{Array, Installation, Mounted, Role};
use crate::observe::Mounting;
use crate::units::radians;

/// Most keys that are kept.
const MOST_KEYS: usize = 1000;

/// How the transducers are arranged (key STC).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrangement {
    /// S1 transmits, S2 receives.
    Separate,
    /// S1 is a head that does both.
    OneHead,
    /// S1 and S2 are heads that do both.
    TwoHeads,
    /// S1 transmits, S2 and S3 receive.
    TwoReceivers,
    /// S0 and S1 transmit, S2 and S3 receive.
    TwoOfEach,
}

/// Serial numbers of the first and the second head.
#[derive(Clone, Copy, Debug)]
pub struct Heads {
    /// Of the datagram's header.
    pub first: u32,
    /// Of its body.
    pub second: u32,
}

/// From the record's text.
#[must_use]
pub fn installation(time_s: f64, text: &str, model: u16, heads: Heads) -> Installation {
    let mut record = Installation {
        time_s,
        fields: fields(text),
        attitude_is_turned: true,
        ..Installation::default()
    };
    record.water_line_m = number(&record, "WLZ").map(|down| -down);
    record.arrays = arrays(&record, arrangement(&record, model), model, heads);
    record.motion_sensors = motion_sensors(&record);
    record.position_sensors = position_sensors(&record);
    record
}

fn fields(text: &str) -> Vec<(String, String)> {
    text.split(',')
        .filter_map(|field| field.split_once('='))
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()))
        .take(MOST_KEYS)
        .collect()
}

fn value<'r>(record: &'r Installation, key: &str) -> Option<&'r str> {
    let found = record.fields.iter().find(|(k, _)| k == key)?;
    Some(&found.1)
}

fn number(record: &Installation, key: &str) -> Option<f64> {
    value(record, key)?
        .parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
}

fn arrangement(record: &Installation, model: u16) -> Arrangement {
    match value(record, "STC") {
        Some("0") => Arrangement::Separate,
        Some("1") => Arrangement::OneHead,
        Some("2") => Arrangement::TwoHeads,
        Some("3") => Arrangement::TwoReceivers,
        Some("4") => Arrangement::TwoOfEach,
        _ if matches!(model, 2045 | 3000 | 3002 | 3020) => one_or_two_heads(record),
        _ => Arrangement::Separate,
    }
}

/// A model whose heads do both, without the key that says how many there are.
fn one_or_two_heads(record: &Installation) -> Arrangement {
    if number(record, "S2X").is_some() {
        Arrangement::TwoHeads
    } else {
        Arrangement::OneHead
    }
}

fn arrays(record: &Installation, how: Arrangement, model: u16, heads: Heads) -> Vec<Array> {
    let (first, second) = (heads.first, heads.second);
    let places: &[(&str, Role, u32)] = match how {
        Arrangement::Separate => &[("S1", Role::Transmit, 0), ("S2", Role::Receive, 0)],
        Arrangement::OneHead => &[("S1", Role::Both, 0)],
        Arrangement::TwoHeads => &[("S1", Role::Both, first), ("S2", Role::Both, second)],
        Arrangement::TwoReceivers => &[
            ("S1", Role::Transmit, 0),
            ("S2", Role::Receive, first),
            ("S3", Role::Receive, second),
        ],
        Arrangement::TwoOfEach => &[
            ("S0", Role::Transmit, first),
            ("S1", Role::Transmit, second),
            ("S2", Role::Receive, first),
            ("S3", Role::Receive, second),
        ],
    };
    let found = |place: &(&str, Role, u32)| {
        Some(Array {
            mounted: mounted(record, place.0)?,
            role: place.1,
            head: place.2,
            inner_m: inner_offsets(model),
        })
    };
    places.iter().filter_map(found).collect()
}

/// Centres of the transmit and the receive elements from the head's centre, right, forward, up (appendix B of the specification).
fn inner_offsets(model: u16) -> [Vector3<f64>; 2] {
    match model {
        2045 => [
            Vector3::new(0.040, 0.0038, 0.006),
            Vector3::new(0.0, -0.0455, 0.006),
        ],
        _ => [Vector3::zeros(); 2],
    }
}

/// The mounting under a two-letter prefix: X, Y, Z and R, P, H (a motion sensor's heading is G).
fn mounted(record: &Installation, prefix: &str) -> Option<Mounted> {
    let of = |letter: &str| number(record, &format!("{prefix}{letter}"));
    let arm_m = Vector3::new(of("Y")?, of("X")?, -of("Z")?);
    let angle = |letter: &str| radians(of(letter).unwrap_or(0.0));
    let heading = if of("H").is_some() { "H" } else { "G" };
    Some(Mounted {
        name: prefix.to_owned(),
        mounting: Mounting::from_angles(angle("R"), angle("P"), angle(heading), arm_m),
        delay_s: of("D").unwrap_or(0.0),
        active: true,
    })
}

/// The motion sensors; key ARO names the port of the one in use, 2 for MS, 3 for NS. Delays are milliseconds in the file.
fn motion_sensors(record: &Installation) -> Vec<Mounted> {
    let port = value(record, "ARO").unwrap_or("2");
    let sensor = |(prefix, own): &(&str, &str)| {
        let mounted = mounted(record, prefix)?;
        Some(Mounted {
            delay_s: 1e-3 * mounted.delay_s,
            active: port == *own || (!matches!(port, "2" | "3") && *own == "2"),
            ..mounted
        })
    };
    [("MS", "2"), ("NS", "3")]
        .iter()
        .filter_map(sensor)
        .collect()
}

/// The position sensors; key APS names the one in use from 0.
fn position_sensors(record: &Installation) -> Vec<Mounted> {
    let active = value(record, "APS").unwrap_or("0");
    let sensor = |(index, prefix): (usize, &str)| {
        let mounted = mounted(record, prefix)?;
        Some(Mounted {
            active: active == index.to_string(),
            ..mounted
        })
    };
    ["P1", "P2", "P3"]
        .into_iter()
        .enumerate()
        .filter_map(sensor)
        .collect()
}
