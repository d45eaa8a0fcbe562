//! Unknowns of the caller's own: systematic effects on the soundings that the model does not have.

/// What one unit of an own unknown changes of a sounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// Its height, metres per unit.
    Up,
    /// Its range, metres per unit.
    Range,
    /// Its across-track angle, radians per unit.
    Across,
    /// Its along-track angle, radians per unit.
    Along,
}

/// An unknown of the caller's own: `derivative[k] * value` is added to what was measured of sounding `k`.
///
/// Squat acts on the height by the square of the speed, a slow range clock on the range by the time since the start. A derivative that is
/// itself a noisy measurement (the measured range, say) biases its unknown: it must not err together with the sounding.
#[derive(Clone, Debug, PartialEq)]
pub struct Extra {
    /// What it is called in the result.
    pub name: String,
    /// Unit of its value, for the reader.
    pub unit: String,
    /// What it changes.
    pub acts: Acts,
    /// One number a sounding, in the order of the survey's soundings; NaN where it does not act.
    pub derivative: Vec<f64>,
    /// What is known of it beforehand, one sigma about zero; `None` where nothing is.
    pub prior_sigma: Option<f64>,
}

/// Own unknowns a calibration takes at the most.
pub const MOST_EXTRAS: usize = 12;

impl Extra {
    /// Its derivative at a sounding; `None` where it does not act.
    #[must_use]
    #[inline]
    pub fn at(&self, row: usize) -> Option<f64> {
        self.derivative.get(row).copied().filter(|d| d.is_finite())
    }

    /// What is wrong with it for so many soundings, as what was found and what was expected.
    #[must_use]
    pub fn fault(&self, rows: usize) -> Option<(String, String)> {
        let found = |found: String, expected: String| Some((found, expected));
        if self.derivative.len() != rows {
            let expected = format!("{rows} rows, one a sounding");
            return found(format!("{} rows", self.derivative.len()), expected);
        }
        if let Some(row) = self.derivative.iter().position(|d| d.is_infinite()) {
            let expected = "a number, or NaN where it does not act".to_owned();
            return found(format!("{} in row {row}", self.derivative[row]), expected);
        }
        if !self.derivative.iter().any(|d| d.is_finite() && *d != 0.0) {
            let expected = "a derivative other than zero somewhere".to_owned();
            return found("an effect on no sounding".to_owned(), expected);
        }
        match self.prior_sigma {
            Some(sigma) if !(sigma > 0.0 && sigma.is_finite()) => {
                let expected = "a positive number, or nothing".to_owned();
                found(format!("prior_sigma {sigma}"), expected)
            }
            _ => None,
        }
    }
}

/// An own unknown that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("extra {name}: found {found}, expected {expected}")]
pub struct ExtraFault {
    /// Its name.
    pub name: String,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

/// Refuses own unknowns that cannot be used with so many soundings, or whose name is among those `taken`.
///
/// # Errors
/// [`ExtraFault`], of the first one that cannot be used.
pub fn check(extras: &[Extra], rows: usize, taken: &[&str]) -> Result<(), ExtraFault> {
    let refused = |name: &str, found: String, expected: String| ExtraFault {
        name: name.to_owned(),
        found,
        expected,
    };
    if extras.len() > MOST_EXTRAS {
        let (found, name) = (extras.len().to_string(), &extras[MOST_EXTRAS].name);
        return Err(refused(name, found, format!("at most {MOST_EXTRAS}")));
    }
    let mut taken = taken.to_vec();
    for extra in extras {
        if let Some((found, expected)) = extra.fault(rows) {
            return Err(refused(&extra.name, found, expected));
        }
        if extra.name.trim().is_empty() || taken.contains(&extra.name.as_str()) {
            let expected = format!("a name of its own, none of {}", taken.join(", "));
            let found = format!("\"{}\"", extra.name);
            return Err(refused(&extra.name, found, expected));
        }
        taken.push(&extra.name);
    }
    Ok(())
}
