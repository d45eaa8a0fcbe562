//! The pool's own section of the report: the samples, packed as base64 of 32-bit floats, and the scripts that draw them.

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use super::super::run::PoolOutcome;
use super::sample_types::{FaceSample, FaceStatistics, PerPath, ReportSamples, SoundingSample};
use crate::calibrate::truth::{TrueMounting, TrueValues};
use crate::results::{Calibration, DriftSample, Page};
use crate::simulate::Truth;

const SCRIPTS: [&str; 6] = [
    include_str!("../page/draw.js"),
    include_str!("../page/view3d.js"),
    include_str!("../page/maps.js"),
    include_str!("../page/coverage.js"),
    include_str!("../page/residuals.js"),
    include_str!("../page/page.js"),
];

/// What the report of an outcome shows beside its result; `title` names the survey, `truth` is known of a simulated one.
///
/// # Errors
/// None for samples made here; `serde_json` does not promise it.
pub fn page(
    outcome: &PoolOutcome,
    result: &Calibration,
    title: &str,
    truth: Option<&Truth>,
) -> serde_json::Result<Page> {
    let page = packed_page(&super::samples(outcome), title)?;
    Ok(Page {
        against_truth: truth.map(|t| true_values(t).against(&result.solutions)),
        ..page
    })
}

/// The same of samples that are at hand.
///
/// # Errors
/// As [`page`].
pub fn packed_page(samples: &ReportSamples, title: &str) -> serde_json::Result<Page> {
    Ok(Page {
        title: title.to_owned(),
        kind: "calibration of a multibeam's mounting on a pool wall",
        data: serde_json::to_value(Data::new(samples))?,
        scripts: &SCRIPTS,
        tables: vec![],
        against_truth: None,
    })
}

/// The truth by the names of the parameters.
#[must_use]
pub fn true_values(truth: &Truth) -> TrueValues {
    let rotation = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let mounting = TrueMounting {
        prefix: String::new(),
        rotation,
        lever_arm_m: Some(Vector3::from(truth.lever_arm_m)),
    };
    TrueValues {
        mountings: vec![mounting],
        others: vec![
            ("latency", truth.latency_s),
            ("range_scale", truth.range_scale),
        ],
    }
}

/// Everything that the scripts of this folder read.
#[derive(Serialize)]
struct Data<'a> {
    faces: &'a [FaceSample],
    water_level_m: Option<f64>,
    trajectory_m: &'a [Vec<[f64; 3]>],
    face_statistics: &'a [FaceStatistics],
    drift: &'a [DriftSample],
    soundings: Soundings,
    returns: Returns,
}

impl<'a> Data<'a> {
    /// Refers to the samples, packs the points.
    fn new(samples: &'a ReportSamples) -> Self {
        Self {
            faces: &samples.faces,
            water_level_m: samples.water_level_m,
            trajectory_m: &samples.trajectory_m,
            face_statistics: &samples.face_statistics,
            drift: &samples.drift,
            soundings: soundings(&samples.soundings),
            returns: returns(samples),
        }
    }
}

/// Soundings by column; metres; NaN where there is no value, -1 where there is no face.
#[derive(Serialize)]
struct Soundings {
    count: usize,
    nominal: Packed,
    position: PerPath<Packed>,
    nominal_residual: Packed,
    residual: PerPath<Packed>,
    face: Packed,
    used: Packed,
    across_deg: Packed,
    range_m: Packed,
    /// After the first sounding's.
    time_s: Packed,
    stated_sigma_m: Packed,
}

/// Laser returns by column.
#[derive(Serialize)]
struct Returns {
    count: usize,
    position: Packed,
    residual: Packed,
    face: Packed,
    used: Packed,
}

/// Little-endian 32-bit floats in base64.
#[derive(Serialize)]
struct Packed(String);

fn soundings(all: &[SoundingSample]) -> Soundings {
    let begin_s = all.iter().map(|s| s.time_s).fold(f64::INFINITY, f64::min);
    Soundings {
        count: all.len(),
        nominal: Packed::points(all.iter().map(|s| Some(s.nominal_m))),
        position: PerPath {
            reference: points_if_any(all, |s| s.position_m.reference),
            joint: points_if_any(all, |s| s.position_m.joint),
            joint_simple: points_if_any(all, |s| s.position_m.joint_simple),
        },
        nominal_residual: Packed::values(all.iter().map(|s| s.nominal_residual_m)),
        residual: PerPath {
            reference: values_if_any(all, |s| s.residual_m.reference),
            joint: values_if_any(all, |s| s.residual_m.joint),
            joint_simple: values_if_any(all, |s| s.residual_m.joint_simple),
        },
        face: Packed::faces(all.iter().map(|s| s.face)),
        used: Packed::flags(all.iter().map(|s| s.used)),
        across_deg: Packed::values(all.iter().map(|s| Some(s.across_deg))),
        range_m: Packed::values(all.iter().map(|s| Some(s.range_m))),
        time_s: Packed::values(all.iter().map(|s| Some(s.time_s - begin_s))),
        stated_sigma_m: Packed::values(all.iter().map(|s| s.stated_sigma_m)),
    }
}

fn returns(samples: &ReportSamples) -> Returns {
    let all = &samples.returns;
    Returns {
        count: all.len(),
        position: Packed::points(all.iter().map(|r| Some(r.position_m))),
        residual: Packed::values(all.iter().map(|r| r.residual_m)),
        face: Packed::faces(all.iter().map(|r| r.face)),
        used: Packed::flags(all.iter().map(|r| r.used)),
    }
}

fn points_if_any(
    all: &[SoundingSample],
    point: impl Fn(&SoundingSample) -> Option<[f64; 3]>,
) -> Option<Packed> {
    all.iter()
        .any(|s| point(s).is_some())
        .then(|| Packed::points(all.iter().map(point)))
}

fn values_if_any(
    all: &[SoundingSample],
    value: impl Fn(&SoundingSample) -> Option<f64>,
) -> Option<Packed> {
    all.iter()
        .any(|s| value(s).is_some())
        .then(|| Packed::values(all.iter().map(value)))
}

impl Packed {
    fn points(points: impl Iterator<Item = Option<[f64; 3]>>) -> Self {
        Self::pack(points.flat_map(|point| point.unwrap_or([f64::NAN; 3])))
    }

    fn values(values: impl Iterator<Item = Option<f64>>) -> Self {
        Self::pack(values.map(|value| value.unwrap_or(f64::NAN)))
    }

    fn faces(faces: impl Iterator<Item = Option<u32>>) -> Self {
        Self::pack(faces.map(|face| face.map_or(-1.0, f64::from)))
    }

    fn flags(flags: impl Iterator<Item = bool>) -> Self {
        Self::pack(flags.map(|flag| f64::from(u8::from(flag))))
    }

    fn pack(values: impl Iterator<Item = f64>) -> Self {
        let bytes: Vec<u8> = values
            .flat_map(|value| (value as f32).to_le_bytes())
            .collect();
        Self(base64(&bytes))
    }
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let bits = group.iter().enumerate().fold(0_u32, |bits, (place, byte)| {
            bits | u32::from(*byte) << (16 - 8 * place)
        });
        for place in 0..4 {
            let digit = ALPHABET[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place <= group.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4648, section 10.
    #[test]
    fn base64_gives_the_test_vectors_of_its_specification() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in vectors {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn floats_are_packed_as_little_endian_singles() {
        assert_eq!(
            Packed::pack([1.0, -2.5].into_iter()).0,
            base64(&[0, 0, 0x80, 0x3f, 0, 0, 0x20, 0xc0])
        );
    }
}
