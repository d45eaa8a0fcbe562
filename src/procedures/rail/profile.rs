//! Standard rail profiles: a plane curve of named lines and arcs, extruded along the rail.
//!
//! Rail frame: x right across the rail, y along it, z up; the origin is on top of the head. The curve is travelled from the left
//! foot over the head to the right foot.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::geometry::curve::{Element, Nearest, nearest};

/// CHN60, as in `models/rails/chn60.toml`.
pub const CHN60: &str = include_str!("../../../models/rails/chn60.toml");
/// UIC 60 (60E1), as in `models/rails/uic60.toml`.
pub const UIC60: &str = include_str!("../../../models/rails/uic60.toml");

/// A rail model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailModel {
    /// Name for reports.
    pub name: String,
    /// Whether the curve is one half, from the middle of the head's top to the right foot, to be mirrored.
    #[serde(default)]
    pub symmetric: bool,
    /// Name of the straight elements that the reference path takes its line from (patent: the 1:20 segment).
    pub line_region: String,
    /// Name of the arcs that the reference path takes its circle from (patent: the R20 arc of the web).
    pub arc_region: String,
    /// Where the curve begins, (x, z), millimetres.
    pub start_mm: [f64; 2],
    /// The elements, each from the end of the one before.
    pub element: Vec<ElementModel>,
}

/// An element of a rail model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementModel {
    /// Name, such as `web R20`.
    pub name: String,
    /// Where it ends, (x, z), millimetres.
    pub to_mm: [f64; 2],
    /// Radius of an arc, millimetres: positive where the rail bulges, negative where it is hollow; none for a straight line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
}

/// What makes a rail model impossible; every fault at once.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("rail model: {}", faults.join("; "))]
pub struct RailError {
    /// One sentence each.
    pub faults: Vec<String>,
}

/// A rail's cross-section, ready to be measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct RailProfile {
    /// Name for reports.
    pub name: String,
    /// The curve, metres.
    pub elements: Vec<Element>,
    /// Name of each element; of a symmetric rail with the side.
    pub names: Vec<String>,
    /// Elements of the straight region, one per side.
    pub line_region: Vec<usize>,
    /// Elements of the arc region, one per side.
    pub arc_region: Vec<usize>,
}

fn metres(mm: [f64; 2]) -> Vector2<f64> {
    Vector2::from(mm) * 1e-3
}

impl RailModel {
    /// Parses a model file's text.
    ///
    /// # Errors
    /// Those of the TOML reader.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    fn faults(&self) -> Vec<String> {
        let mut faults = vec![];
        let finite = |p: [f64; 2]| p.iter().all(|v| v.is_finite() && v.abs() < 1e4);
        let mut before = self.start_mm;
        if !finite(before) {
            faults.push(format!(
                "start_mm: found {before:?}, expected two numbers within 10000"
            ));
        }
        for (k, e) in self.element.iter().enumerate() {
            let place = format!("element {} ({})", k + 1, e.name);
            if !finite(e.to_mm) || e.to_mm == before {
                let expected = "a point within 10000 away from the one before";
                faults.push(format!(
                    "{place}: to_mm: found {:?}, expected {expected}",
                    e.to_mm
                ));
            }
            let chord = (metres(e.to_mm) - metres(before)).norm() * 1e3;
            if let Some(r) = e.radius_mm
                && !(2.0 * r.abs() > chord)
            {
                let expected = format!("more than half the {chord} mm between its ends");
                faults.push(format!(
                    "{place}: radius_mm: found {r}, expected {expected}"
                ));
            }
            before = e.to_mm;
        }
        faults.extend(self.region_fault("line_region", &self.line_region, false));
        faults.extend(self.region_fault("arc_region", &self.arc_region, true));
        if self.symmetric && self.start_mm[0] != 0.0 {
            let x = self.start_mm[0];
            faults.push(format!(
                "start_mm: found x {x}, expected 0 in a symmetric rail"
            ));
        }
        faults
    }

    fn region_fault(&self, key: &str, name: &str, arc: bool) -> Option<String> {
        let mut named = self.element.iter().filter(|e| e.name == name);
        if named.any(|e| e.radius_mm.is_some() == arc) {
            return None;
        }
        let kind = if arc { "an arc" } else { "a straight element" };
        Some(format!(
            "{key}: found \"{name}\", expected the name of {kind}"
        ))
    }
}

impl RailProfile {
    /// Builds the curve; a symmetric half is mirrored.
    ///
    /// # Errors
    /// [`RailError`] with every fault.
    pub fn from_model(model: &RailModel) -> Result<Self, RailError> {
        let faults = model.faults();
        if !faults.is_empty() {
            return Err(RailError { faults });
        }
        let mut half = vec![];
        let mut from = metres(model.start_mm);
        for e in &model.element {
            let to = metres(e.to_mm);
            let straight = Some(Element::Line { from, to });
            let built = e
                .radius_mm
                .map_or(straight, |r| Element::arc(from, to, r * 1e-3));
            if let Some(element) = built {
                half.push((e.name.clone(), element));
            }
            from = to;
        }
        let named = if model.symmetric {
            mirrored(half)
        } else {
            half
        };
        let (names, elements): (Vec<_>, Vec<_>) = named.into_iter().unzip();
        let region = |name: &str| {
            let is = |k: &usize| {
                names[*k] == name
                    || names[*k]
                        .strip_suffix(SIDES.0)
                        .or(names[*k].strip_suffix(SIDES.1))
                        == Some(name)
            };
            (0..names.len()).filter(is).collect()
        };
        Ok(Self {
            name: model.name.clone(),
            line_region: region(&model.line_region),
            arc_region: region(&model.arc_region),
            elements,
            names,
        })
    }

    /// A profile that ships with the program: `chn60` or `uic60`.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        Self::from_model(&built_in_model(name)?).ok()
    }

    /// The nearest element to a point of the cross-section.
    #[must_use]
    pub fn nearest(&self, p: &Vector2<f64>) -> Option<Nearest> {
        nearest(&self.elements, p)
    }
}

/// Names of the rails that ship with the program.
pub const BUILT_IN: [&str; 2] = ["chn60", "uic60"];

/// A model that ships with the program, see [`BUILT_IN`].
#[must_use]
pub fn built_in_model(name: &str) -> Option<RailModel> {
    let text = match name {
        "chn60" => CHN60,
        "uic60" => UIC60,
        _ => return None,
    };
    RailModel::from_toml(text).ok()
}

/// Endings of the names of a symmetric rail's elements.
const SIDES: (&str, &str) = (", left", ", right");

/// The left half, mirrored and travelled the other way, then the right half.
fn mirrored(half: Vec<(String, Element)>) -> Vec<(String, Element)> {
    let flip = |p: Vector2<f64>| Vector2::new(-p.x, p.y);
    let other = |element: &Element| match *element {
        Element::Line { from, to } => Element::Line {
            from: flip(to),
            to: flip(from),
        },
        Element::Arc {
            centre,
            radius_m,
            convex,
            from,
            to,
        } => Element::Arc {
            centre: flip(centre),
            radius_m,
            convex,
            from: flip(to),
            to: flip(from),
        },
    };
    let left = half
        .iter()
        .rev()
        .map(|(name, e)| (format!("{name}{}", SIDES.0), other(e)));
    let left: Vec<_> = left.collect();
    let right = half
        .into_iter()
        .map(|(name, e)| (format!("{name}{}", SIDES.1), e));
    left.into_iter().chain(right).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Area of the section by Green's theorem, closed along the base.
    fn area_m2(profile: &RailProfile) -> f64 {
        let outline: Vec<_> = profile
            .elements
            .iter()
            .flat_map(|e| e.samples(2e-5))
            .collect();
        let next = outline.iter().cycle().skip(1);
        0.5 * outline
            .iter()
            .zip(next)
            .map(|(a, b)| b.x * a.y - a.x * b.y)
            .sum::<f64>()
    }

    /// Height, foot and area as published: CHN60 176, 150, 77.45 cm2 (GB/T 2585); 60E1 172, 150, 76.70 cm2 (EN 13674-1). The radii that
    /// were assumed may move the area by one per cent.
    #[test]
    fn sections_have_the_published_size() {
        for (name, height, area) in [("chn60", 0.176, 77.45e-4), ("uic60", 0.172, 76.70e-4)] {
            let profile = RailProfile::built_in(name).expect("a profile");
            let points: Vec<_> = profile
                .elements
                .iter()
                .flat_map(|e| [e.from(), e.to()])
                .collect();
            let low = points.iter().map(|p| p.y).fold(0.0, f64::min);
            let wide = points.iter().map(|p| p.x).fold(0.0, f64::max);
            assert_relative_eq!(-low, height, epsilon = 1e-8);
            assert_relative_eq!(wide, 0.075, epsilon = 1e-8);
            assert_relative_eq!(area_m2(&profile), area, max_relative = 0.01);
            assert_eq!(
                (profile.line_region.len(), profile.arc_region.len()),
                (2, 2)
            );
        }
    }

    /// Every joint is tangent to the rounding of the coordinates: 1e-6 mm over the shortest element.
    #[test]
    fn elements_join_without_gap_and_kink() {
        for name in ["chn60", "uic60"] {
            let profile = RailProfile::built_in(name).expect("a profile");
            for (k, pair) in profile.elements.windows(2).enumerate() {
                assert!((pair[0].to() - pair[1].from()).norm() < 1e-12);
                let turn = pair[0].tangent(1.0).dot(&pair[1].tangent(0.0));
                let sine = (1.0 - turn * turn).max(0.0).sqrt();
                assert!(
                    sine < 1e-6 && turn > 0.0,
                    "{name}, {}: {sine}",
                    profile.names[k]
                );
            }
        }
    }

    /// The flank stands at 1:20 and 70.8 mm apart where it begins (CHN60).
    #[test]
    fn the_flank_is_where_the_drawing_has_it() {
        let profile = RailProfile::built_in("chn60").expect("a profile");
        let right = profile.elements[profile.line_region[1]];
        let d = right.to() - right.from();
        assert_relative_eq!(d.x / d.y, -0.05, epsilon = 1e-7);
        assert_relative_eq!(right.from().x, 0.0354, epsilon = 1e-9);
    }

    #[test]
    fn impossible_models_are_refused_with_every_fault() {
        let mut model = built_in_model("chn60").expect("a model");
        model.line_region = "web R20".to_owned();
        model.element[0].radius_mm = Some(1.0);
        let error = RailProfile::from_model(&model).expect_err("two faults");
        assert_eq!(error.faults.len(), 2, "{error}");
    }
}
