//! Bounds of plain sense: how large a correction may be, and how much of the data must take part.

use super::VerdictConfig;
use crate::results::{Finding, Severity};

/// A mounting's correction: its name, the turn in radians and the move of the lever arm in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// Name of the sensor in words ("the sounder").
    pub name: String,
    /// Angle of the correction, radians.
    pub turn_rad: f64,
    /// Length of the lever arm's correction, metres.
    pub arm_m: f64,
}

/// A correction that is too large to be one.
#[must_use]
pub fn size(correction: &Correction, config: &VerdictConfig) -> Option<Finding> {
    let turn_deg = correction.turn_rad.to_degrees();
    let (far, off) = (
        turn_deg > config.max_correction_deg,
        correction.arm_m > config.max_correction_m,
    );
    (far || off).then(|| {
        Finding::new(
            "size",
            Severity::Withdraws,
            format!(
                "the mounting of {} would be corrected by {turn_deg:.1} deg{}",
                correction.name,
                arm(correction.arm_m)
            ),
            format!("{} deg and {} m", config.max_correction_deg, config.max_correction_m),
            "nominal values in another frame or unit, or a wrong fit; enter better nominal values where they really are that far off",
        )
    })
}

fn arm(arm_m: f64) -> String {
    if arm_m > 0.0 {
        format!(" and its lever arm by {arm_m:.2} m")
    } else {
        String::new()
    }
}

/// A sensor's observations that could have been used, and those that were.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// Name in words ("soundings near the target").
    pub name: String,
    /// How many could have been.
    pub candidates: usize,
    /// How many were.
    pub used: usize,
}

impl Share {
    /// Used by candidates; one where there is no candidate.
    #[must_use]
    pub fn value(&self) -> f64 {
        if self.candidates == 0 {
            1.0
        } else {
            self.used as f64 / self.candidates as f64
        }
    }
}

/// A share that is too small: below the least one there is no result, below the good one something to look at.
#[must_use]
pub fn share(share: &Share, config: &VerdictConfig) -> Option<Finding> {
    let value = share.value();
    let severity = match value {
        v if v < config.least_share => Severity::Withdraws,
        v if v < config.good_share => Severity::Finding,
        _ => return None,
    };
    Some(Finding::new(
        "share",
        severity,
        format!(
            "{:.0} % of {} {} fit ({} of {})",
            100.0 * value,
            share.candidates,
            share.name,
            share.used,
            share.candidates
        ),
        format!(
            "no result below {:.0} %, worth a look below {:.0} %",
            100.0 * config.least_share,
            100.0 * config.good_share
        ),
        "something else stands there, or a sign, unit or clock is wrong",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrections_have_a_size() {
        let config = VerdictConfig::default();
        let mut correction = Correction {
            name: "the sounder".to_owned(),
            turn_rad: 0.1,
            arm_m: 0.3,
        };
        assert_eq!(size(&correction, &config), None);
        correction.arm_m = 0.6;
        assert!(size(&correction, &config).unwrap().seen.contains("0.60 m"));
        (correction.arm_m, correction.turn_rad) = (0.3, 0.2);
        assert!(size(&correction, &config).is_some());
    }

    #[test]
    fn shares_have_two_limits() {
        let config = VerdictConfig::default();
        let of = |used| {
            share(
                &Share {
                    name: "fixes".to_owned(),
                    candidates: 100,
                    used,
                },
                &config,
            )
        };
        assert_eq!(of(85), None);
        assert_eq!(of(70).unwrap().severity, Severity::Finding);
        assert_eq!(of(40).unwrap().severity, Severity::Withdraws);
    }
}
