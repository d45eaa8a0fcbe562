//! A procedure whose figures are known, for tests.

use nalgebra::DMatrix;

use crate::adjust::Unit;
use crate::calibrate::tried::{Acting, Reason, Said, SoughtParameter, Trial, Tried, TriedPath};
use crate::calibrate::vary::{Point, Setting, VaryError};
use crate::results::SourceDescription;
use crate::stats::normal;
use crate::stats::stream;

/// Two sources of `spread` and twice that on a first parameter, three times and 0 on a second; the joint path claims exactly that for
/// a spread of one, the reference path has twice the error and a bias of 1, and no answer on every tenth seed.
#[derive(Clone, Debug)]
pub(super) struct Toy {
    pub spread: f64,
}

impl Default for Toy {
    fn default() -> Self {
        Self { spread: 1.0 }
    }
}

impl Toy {
    fn error(&self, seed: u64, acting: Acting) -> Vec<f64> {
        let mut random = stream(seed, 7);
        let mut draw = |place| {
            let acts = acting == Acting::All || acting == Acting::Only(place);
            self.spread * normal::draw(&mut random) * f64::from(u8::from(acts))
        };
        let (first, second) = (draw(0), draw(1));
        vec![first + 2.0 * second, 3.0 * first]
    }
}

impl Tried for Toy {
    fn procedure(&self) -> &'static str {
        "toy"
    }

    fn scenario(&self) -> &str {
        "toy"
    }

    fn content(&self) -> Vec<u8> {
        self.spread.to_string().into_bytes()
    }

    fn configuration(&self) -> serde_json::Value {
        serde_json::json!({})
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        let parameter = |(name, unit): (&str, Unit)| SoughtParameter {
            name: name.to_owned(),
            unit,
        };
        [("a", Unit::Radian), ("b", Unit::Metre)]
            .map(parameter)
            .into()
    }

    fn paths(&self) -> Vec<TriedPath> {
        let path = |name| TriedPath {
            name,
            variant: String::new(),
        };
        ["joint", "reference"].map(path).into()
    }

    fn sources(&self) -> Vec<SourceDescription> {
        ["first", "second"]
            .map(|name| SourceDescription {
                source: name.to_owned(),
                title: name.to_owned(),
                ..SourceDescription::default()
            })
            .into()
    }

    fn trial(&self, seed: u64, acting: Acting) -> Trial {
        let error = self.error(seed, acting);
        let reference = Said {
            error: error.iter().map(|e| 2.0 * e + 1.0).collect(),
            covariance: None,
            variance_factor: None,
        };
        let joint = Said {
            error,
            covariance: Some(DMatrix::from_row_slice(2, 2, &[5.0, 3.0, 3.0, 9.0])),
            variance_factor: Some(1.0),
        };
        let tenth = seed.is_multiple_of(10);
        let refused = Err(Reason::new("tenth", &"every tenth seed"));
        Trial {
            seed,
            paths: vec![Ok(joint), if tenth { refused } else { Ok(reference) }],
        }
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        let mut toy = self.clone();
        for (_, setting) in &point.0 {
            if let Setting::Number(spread) = setting {
                toy.spread = *spread;
            }
        }
        Ok(Box::new(toy))
    }
}
