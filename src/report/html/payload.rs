//! The data inside the page: result, headline, conventions and the samples packed as base64 of 32-bit floats.

use crate::report::conventions::{Convention, conventions};
use crate::report::headline;
use crate::results::{
    FaceSample, FaceStatistics, PerPath, PoolResult, ReportSamples, SoundingSample, Truth,
};
use serde::Serialize;

/// Everything that the page's scripts read.
#[derive(Serialize)]
pub struct Payload<'a> {
    title: &'a str,
    headline: String,
    significance: f64,
    result: &'a PoolResult,
    conventions: Vec<Convention>,
    faces: &'a [FaceSample],
    water_level_m: Option<f64>,
    trajectory_m: &'a [Vec<[f64; 3]>],
    face_statistics: &'a [FaceStatistics],
    truth: Option<Truth>,
    soundings: Soundings,
    returns: Returns,
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

impl<'a> Payload<'a> {
    /// Refers to `result` and `samples`, packs the points.
    pub fn new(result: &'a PoolResult, samples: &'a ReportSamples) -> Self {
        Self {
            title: &samples.title,
            headline: headline(result),
            significance: crate::report::SIGNIFICANCE,
            result,
            conventions: table(result),
            faces: &samples.faces,
            water_level_m: samples.water_level_m,
            trajectory_m: &samples.trajectory_m,
            face_statistics: &samples.face_statistics,
            truth: samples.truth,
            soundings: soundings(&samples.soundings),
            returns: returns(samples),
        }
    }
}

/// Of the deciding solution, and only when it may be used.
fn table(result: &PoolResult) -> Vec<Convention> {
    let s = &result.solutions;
    let deciding = s
        .joint
        .as_ref()
        .map(|joint| &joint.estimate)
        .or(s.sequential.as_ref().map(|s| &s.estimate));
    deciding
        .filter(|_| result.usable)
        .map(conventions)
        .unwrap_or_default()
}

fn soundings(all: &[SoundingSample]) -> Soundings {
    Soundings {
        count: all.len(),
        nominal: Packed::points(all.iter().map(|s| Some(s.nominal_m))),
        position: PerPath {
            sequential: points_if_any(all, |s| s.position_m.sequential),
            joint: points_if_any(all, |s| s.position_m.joint),
            joint_simple: points_if_any(all, |s| s.position_m.joint_simple),
        },
        nominal_residual: Packed::values(all.iter().map(|s| s.nominal_residual_m)),
        residual: PerPath {
            sequential: values_if_any(all, |s| s.residual_m.sequential),
            joint: values_if_any(all, |s| s.residual_m.joint),
            joint_simple: values_if_any(all, |s| s.residual_m.joint_simple),
        },
        face: Packed::faces(all.iter().map(|s| s.face)),
        used: Packed::flags(all.iter().map(|s| s.used)),
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
