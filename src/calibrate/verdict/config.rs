//! The `[verdict]` section of a survey file.

use crate::survey::limits::{ABOVE, Limits, WIDTH, limits};
use crate::survey::schema::{Key, Kind};
use crate::survey::section::section;

/// Codes of the findings that `accept` may name.
pub const CODES: &[&str] = &[
    "latency",
    "range_scale",
    "range_offset",
    "beam_angle_scale",
    "sound_speed_gradient",
    "laser_latency",
    "laser_range_offset",
    "scanner_mounting",
    "attitude_scale",
    "attitude_latency",
    "attitude_offset",
    "heading_offset",
    "mounting_of_pass",
    "datum_of_pass",
    "roll_of_line",
    "pitch_of_line",
    "heading_of_line",
    "position_of_line",
    "roll_drift",
    "pitch_drift",
    "heading_drift",
    "latency_of_head",
    "face_offset",
    "prior",
    "variance_factor",
    "noise",
    "trajectory",
    "pass",
    "face",
    "size",
    "share",
    "axes_gap",
    "ins_attitude",
    "rail_element",
    "table",
    "attitude",
    "heading_scale",
    "beacon",
    "beacon_position",
    "transducer_position",
    "sign_of_scanner_roll",
    "sign_of_scanner_pitch",
    "sign_of_scanner_heading",
    "sign_of_ins_roll",
    "sign_of_ins_pitch",
    "sign_of_ins_heading",
];

impl VerdictConfig {
    /// The keys of a procedure that has findings of its own: `codes` are all that its `accept` may name.
    #[must_use]
    pub const fn accepting(codes: &'static [&'static str]) -> [Key; VerdictConfig::KEYS.len()] {
        let mut keys = [Self::KEYS[0]; VerdictConfig::KEYS.len()];
        let mut k = 1;
        while k < keys.len() {
            keys[k] = Self::KEYS[k];
            k += 1;
        }
        keys[0].kind = Kind::Words(codes);
        keys
    }
}

const VARIANCE: Limits = limits(ABOVE, 1e6, "a factor above 0 and up to 1000000");
const SHARE: Limits = limits(0.0, 1.0, "a share from 0 to 1");

section! {
    #[settings]
    /// Limits of the verdict, and findings that the surveyor accepts.
    #[derive(Clone, Debug, PartialEq)]
    pub struct VerdictConfig {
        /// Codes of findings that do not take "usable" away.
        accept: Vec<String> = or (vec![]), Kind::Words(CODES);
        /// Smallest variance factor that is accepted.
        least_variance_factor: f64 = or (0.75), Kind::Number(VARIANCE);
        /// Largest one.
        most_variance_factor: f64 = or (1.25), Kind::Number(VARIANCE);
        /// A correction of the mounting beyond this is suspicious, degrees.
        max_correction_deg: f64 = or (10.0), Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180"));
        /// A correction of the lever arm beyond this is suspicious, metres.
        max_correction_m: f64 = or (0.5), Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000"));
        /// A prior that moves by more of its own standard deviations contradicts the data.
        max_prior_sigmas: f64 = or (5.0), Kind::Number(WIDTH);
        /// Below this share of used observations the result is not usable.
        least_share: f64 = or (0.5), Kind::Number(SHARE);
        /// Below this share a finding says so.
        good_share: f64 = or (0.8), Kind::Number(SHARE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_procedure_with_findings_of_its_own_keeps_every_other_key() {
        const OWN: [Key; VerdictConfig::KEYS.len()] = VerdictConfig::accepting(&["twist"]);
        assert!(matches!(OWN[0].kind, Kind::Words(["twist"])));
        let names = |keys: &[Key]| keys.iter().map(|key| key.name).collect::<Vec<_>>();
        assert_eq!(names(&OWN), names(VerdictConfig::KEYS));
    }

    #[test]
    fn the_page_of_the_verdict_says_what_to_do_on_every_finding() {
        let page = include_str!("../../../docs/verdict.md");
        for code in CODES {
            let row = page
                .lines()
                .filter(|line| line.starts_with('|'))
                .find(|line| line.contains(&format!("`{code}` *")));
            assert!(row.is_some(), "docs/verdict.md has no row of `{code}` *");
        }
    }
}
