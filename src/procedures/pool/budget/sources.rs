//! The error sources in words: what each is, which scenario keys size it, what it is by default and where that figure is from.

use crate::results::SourceDescription;
use crate::simulate::{Scenario, Source, Sources};
use crate::target::Target;

/// What a reader needs to know of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// As in `[sources]` of a scenario file.
    pub name: &'static str,
    /// For tables and pictures.
    pub title: &'static str,
    /// Distribution, and what shares one draw.
    pub description: &'static str,
    /// Scenario keys that size it.
    pub keys: &'static [&'static str],
    /// One sigma (or fraction) in each key's unit where nothing better is known; empty where a scenario must say.
    pub default: &'static [(&'static str, f64)],
    /// Where the default is from.
    pub reference: &'static str,
}

const INS: &str =
    "models/sensors/span-lci.toml: assumption, tactical-grade fibre-optic INS, post-processed";
const VZ: &str = "models/sensors/riegl-vz-1000.toml: assumption within the maker's accuracy of 8 mm (HELIOS++ scanner list)";
const SONIC: &str =
    "models/sensors/r2sonic-2024.toml: assumption, no public document gives a standard deviation";
const SCENARIO: &str = "no default: the scenario says";

macro_rules! about {
    ($name:literal, $title:literal, $text:literal, $keys:expr, $default:expr, $reference:expr) => {
        About {
            name: $name,
            title: $title,
            description: $text,
            keys: &$keys,
            default: &$default,
            reference: $reference,
        }
    };
}

/// The words for a source.
#[must_use]
pub fn about(source: Source) -> &'static About {
    match source {
        Source::PositionWhite => &POSITION_WHITE,
        Source::PositionDrift => &POSITION_DRIFT,
        Source::RollPitch => &ROLL_PITCH,
        Source::Heading => &HEADING,
        Source::HeadingDrift => &HEADING_DRIFT,
        Source::LaserRange => &LASER_RANGE,
        Source::LaserAngle => &LASER_ANGLE,
        Source::LaserBoresight => &LASER_BORESIGHT,
        Source::LaserLeverArm => &LASER_LEVER_ARM,
        Source::Latency => &LATENCY,
        Source::LatencyJitter => &LATENCY_JITTER,
        Source::SonarRange => &SONAR_RANGE,
        Source::SonarAngle => &SONAR_ANGLE,
        Source::SonarAlongAngle => &SONAR_ALONG_ANGLE,
        Source::SoundSpeed => &SOUND_SPEED,
        Source::SoundSpeedGradient => &SOUND_SPEED_GRADIENT,
        Source::TargetOffsets => &TARGET_OFFSETS,
        Source::TargetFlatness => &TARGET_FLATNESS,
        Source::TargetPose => &TARGET_POSE,
        Source::GrossErrors => &GROSS_ERRORS,
        Source::Clutter => &CLUTTER,
        Source::Multipath => &MULTIPATH,
        Source::Bodies => &BODIES,
    }
}

const POSITION_WHITE: About = about!(
    "position_white",
    "INS position, white",
    "normal, per record and axis",
    ["trajectory.position_sigma_m"],
    [("position_sigma_m", 0.002)],
    INS
);
const POSITION_DRIFT: About = about!(
    "position_drift",
    "INS position, drift",
    "first-order Gauss-Markov per axis, continuous over all passes",
    [
        "trajectory.position_drift_sigma_m",
        "trajectory.drift_correlation_time_s"
    ],
    [
        ("position_drift_sigma_m", 0.01),
        ("drift_correlation_time_s", 60.0)
    ],
    INS
);
const ROLL_PITCH: About = about!(
    "roll_pitch",
    "INS roll and pitch, white",
    "normal, per record",
    ["trajectory.roll_pitch_sigma_deg"],
    [("roll_pitch_sigma_deg", 0.003)],
    INS
);
const HEADING: About = about!(
    "heading",
    "INS heading, white",
    "normal, per record",
    ["trajectory.heading_sigma_deg"],
    [("heading_sigma_deg", 0.005)],
    INS
);
const HEADING_DRIFT: About = about!(
    "heading_drift",
    "INS heading, slow",
    "first-order Gauss-Markov with the drift's correlation time",
    [
        "trajectory.heading_drift_sigma_deg",
        "trajectory.drift_correlation_time_s"
    ],
    [("heading_drift_sigma_deg", 0.0)],
    INS
);
const LASER_RANGE: About = about!(
    "laser_range",
    "laser range",
    "normal, per return",
    ["lidar.range_sigma_m"],
    [("range_sigma_m", 0.005)],
    VZ
);
const LASER_ANGLE: About = about!(
    "laser_angle",
    "laser angle",
    "normal, per return, in the scanner's plane",
    ["lidar.angle_sigma_deg"],
    [("angle_sigma_deg", 0.002)],
    "models/sensors/riegl-vz-1000.toml: assumption, no public figure was found"
);
const LASER_BORESIGHT: About = about!(
    "laser_boresight",
    "laser boresight",
    "normal about each body axis, once per survey, plus a constant where the scenario gives one",
    ["lidar.mounting_sigma_deg", "lidar.mounting_error_deg"],
    [],
    SCENARIO
);
const LASER_LEVER_ARM: About = about!(
    "laser_lever_arm",
    "laser lever arm",
    "normal along each body axis, once per survey, plus a constant where the scenario gives one",
    ["lidar.lever_arm_sigma_m", "lidar.lever_arm_error_m"],
    [],
    SCENARIO
);
const LATENCY: About = about!(
    "latency",
    "multibeam latency",
    "normal, once per survey, plus a constant where the scenario gives one",
    ["truth.latency_s", "truth.latency_sigma_s"],
    [],
    SCENARIO
);
const LATENCY_JITTER: About = about!(
    "latency_jitter",
    "multibeam stamp jitter",
    "normal, per ping",
    ["truth.latency_jitter_s"],
    [],
    SCENARIO
);
const SONAR_RANGE: About = about!(
    "sonar_range",
    "multibeam range",
    "normal, per beam",
    ["multibeam.range_sigma_m"],
    [("range_sigma_m", 0.01)],
    SONIC
);
const SONAR_ANGLE: About = about!(
    "sonar_angle",
    "multibeam angle across",
    "normal, per beam, growing outwards by outer_beam_factor",
    ["multibeam.angle_sigma_deg", "multibeam.outer_beam_factor"],
    [("angle_sigma_deg", 0.06), ("outer_beam_factor", 1.0)],
    SONIC
);
const SONAR_ALONG_ANGLE: About = about!(
    "sonar_along_angle",
    "multibeam angle along",
    "normal, per beam",
    ["multibeam.along_angle_sigma_deg"],
    [],
    SCENARIO
);
const SOUND_SPEED: About = about!(
    "sound_speed",
    "sound speed, constant",
    "a scale of all ranges: normal, once per survey, plus a constant where the scenario gives one",
    ["truth.range_scale", "truth.range_scale_sigma"],
    [],
    SCENARIO
);
const SOUND_SPEED_GRADIENT: About = about!(
    "sound_speed_gradient",
    "sound speed, gradient",
    "over depth: normal, once per survey, plus a constant where the scenario gives one",
    [
        "sound_speed.gradient_error_1_s",
        "sound_speed.gradient_sigma_1_s"
    ],
    [],
    SCENARIO
);
const TARGET_OFFSETS: About = about!(
    "target_offsets",
    "target dimensions",
    "normal, each face off its design position, once per survey",
    [
        "target.model.coplanarity_sigma_m",
        "target.model.height_sigma_m"
    ],
    [],
    SCENARIO
);
const TARGET_FLATNESS: About = about!(
    "target_flatness",
    "target flatness",
    "normal along the face's normal, per observation",
    ["target.roughness_sigma_m"],
    [],
    SCENARIO
);
const TARGET_POSE: About = about!(
    "target_pose",
    "target pose as stated",
    "constant, plus normal once per survey where the scenario gives a sigma; refined from the laser points",
    [
        "target.prior_offset_m",
        "target.prior_turn_deg",
        "target.prior_offset_sigma_m",
        "target.prior_turn_sigma_deg"
    ],
    [],
    SCENARIO
);
const GROSS_ERRORS: About = about!(
    "gross_errors",
    "gross errors",
    "a share of the soundings, uniform within the largest error",
    ["disturbance.gross_fraction", "disturbance.gross_range_m"],
    [],
    SCENARIO
);
const CLUTTER: About = about!(
    "clutter",
    "clutter",
    "a share of soundings and returns, uniform along the beam before the target",
    [
        "disturbance.sonar_clutter_fraction",
        "disturbance.laser_clutter_fraction"
    ],
    [],
    SCENARIO
);
const MULTIPATH: About = about!(
    "multipath",
    "multipath",
    "a share of soundings and returns, late by a uniform delay",
    [
        "disturbance.multipath_fraction",
        "disturbance.multipath_delay_m"
    ],
    [],
    SCENARIO
);
const BODIES: About = about!(
    "bodies",
    "obstacles in the way",
    "solid boxes at rest or moving; not random",
    ["disturbance.body"],
    [],
    SCENARIO
);

/// The sources that act in a scenario: those with a size and a factor above 0, in the order of their streams.
///
/// Association errors have no draw of their own: they are what all sources together do to the ties, and are found by trials in which
/// every observation is tied to the face that it truly struck.
#[must_use]
pub fn acting(scenario: &Scenario) -> Vec<Source> {
    let acts = |s: &Source| scenario.sources.factor(*s) > 0.0 && has_size(scenario, *s);
    Source::ALL.into_iter().filter(acts).collect()
}

/// The scenario with one of its sources alone, with the factor that the scenario gives it.
#[must_use]
pub fn alone(scenario: &Scenario, source: Source) -> Scenario {
    let factor = scenario.sources.factor(source);
    Scenario {
        sources: Sources::none().with(source, factor),
        ..scenario.clone()
    }
}

/// The scenario without any error: what remains is the method's own.
#[must_use]
pub fn nothing(scenario: &Scenario) -> Scenario {
    Scenario {
        sources: Sources::none(),
        ..scenario.clone()
    }
}

fn has_size(scenario: &Scenario, source: Source) -> bool {
    let any = |values: &[f64]| values.iter().any(|v| *v != 0.0);
    let (ins, lidar, sonar) = (&scenario.trajectory, &scenario.lidar, &scenario.multibeam);
    let (truth, d, target) = (&scenario.truth, &scenario.disturbance, &scenario.target);
    match source {
        Source::PositionWhite => any(&[ins.position_sigma_m]),
        Source::PositionDrift => any(&[ins.position_drift_sigma_m]),
        Source::RollPitch => any(&[ins.roll_pitch_sigma_deg]),
        Source::Heading => any(&[ins.heading_sigma_deg]),
        Source::HeadingDrift => any(&[ins.heading_drift_sigma_deg]),
        Source::Latency => any(&[truth.latency_s, truth.latency_sigma_s]),
        Source::LatencyJitter => any(&[truth.latency_jitter_s]),
        Source::LaserRange => any(&[lidar.range_sigma_m]),
        Source::LaserAngle => any(&[lidar.angle_sigma_deg]),
        Source::LaserBoresight => {
            let e = lidar.mounting_error_deg;
            any(&lidar.mounting_sigma_deg) || any(&[e.pitch, e.roll, e.yaw])
        }
        Source::LaserLeverArm => any(&lidar.lever_arm_sigma_m) || any(&lidar.lever_arm_error_m),
        Source::SonarRange => any(&[sonar.range_sigma_m]),
        Source::SonarAngle => any(&[sonar.angle_sigma_deg]),
        Source::SonarAlongAngle => any(&[sonar.along_angle_sigma_deg]),
        Source::SoundSpeed => any(&[truth.range_scale, truth.range_scale_sigma]),
        Source::SoundSpeedGradient => scenario
            .sound_speed
            .as_ref()
            .is_some_and(|w| any(&[w.gradient_error_1_s, w.gradient_sigma_1_s])),
        Source::TargetOffsets => Target::from_model(&target.model)
            .is_ok_and(|t| t.offsets.iter().any(|o| o.sigma_m > 0.0)),
        Source::TargetFlatness => any(&[target.roughness_sigma_m]),
        Source::TargetPose => {
            let random = [target.prior_offset_sigma_m, target.prior_turn_sigma_deg];
            any(&target.prior_offset_m) || any(&[target.prior_turn_deg]) || any(&random)
        }
        Source::GrossErrors => any(&[d.gross_fraction]) && any(&[d.gross_range_m]),
        Source::Clutter => any(&[d.sonar_clutter_fraction, d.laser_clutter_fraction]),
        Source::Multipath => any(&[d.multipath_fraction]) && any(&[d.multipath_delay_m]),
        Source::Bodies => !d.body.is_empty(),
    }
}

/// The source's figures in a scenario: each key with its value, as a reader would look it up.
#[must_use]
pub fn size(scenario: &Scenario, source: Source) -> Vec<(&'static str, String)> {
    let Ok(tree) = toml::Table::try_from(scenario) else {
        return vec![];
    };
    let value = |key: &&'static str| {
        let mut parts = key.split('.');
        let first = tree.get(parts.next()?)?;
        let found = parts.try_fold(first, |value, part| value.get(part))?;
        Some((*key, found.to_string()))
    };
    about(source).keys.iter().filter_map(value).collect()
}

/// A source as a result has it, with its size in the scenario.
#[must_use]
pub fn described(scenario: &Scenario, source: Source) -> SourceDescription {
    let about = about(source);
    let owned = |(key, value): (&str, String)| (key.to_owned(), value);
    let default = |(key, value): &(&str, f64)| ((*key).to_owned(), *value);
    SourceDescription {
        source: about.name.to_owned(),
        title: about.title.to_owned(),
        description: about.description.to_owned(),
        size: size(scenario, source).into_iter().map(owned).collect(),
        default: about.default.iter().map(default).collect(),
        reference: about.reference.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::DEMO;

    fn demo() -> Scenario {
        Scenario::from_toml(DEMO).expect("the demo")
    }

    #[test]
    fn every_source_has_its_own_name_as_scenario_files_know_it() {
        for source in Source::ALL {
            let name = serde_json::to_value(source).expect("a name");
            assert_eq!(name.as_str(), Some(about(source).name));
        }
    }

    /// The defaults in the table are those of the sensors' files.
    #[test]
    fn defaults_stand_in_models() {
        let files = [
            (
                "span-lci",
                include_str!("../../../../models/sensors/span-lci.toml"),
            ),
            (
                "riegl-vz-1000",
                include_str!("../../../../models/sensors/riegl-vz-1000.toml"),
            ),
            (
                "r2sonic-2024",
                include_str!("../../../../models/sensors/r2sonic-2024.toml"),
            ),
        ];
        let mut seen = 0;
        for source in Source::ALL {
            let about = about(source);
            let file = files
                .iter()
                .find(|(name, _)| about.reference.contains(name));
            assert_eq!(file.is_some(), !about.default.is_empty(), "{source:?}");
            for (key, value) in about.default {
                let table: toml::Table = file.expect("a file").1.parse().expect("TOML");
                let found = table.get(*key).and_then(toml::Value::as_float);
                assert_eq!(found, Some(*value), "{source:?} {key}");
                seen += 1;
            }
        }
        assert_eq!(seen, 11);
    }

    #[test]
    fn keys_are_those_of_a_scenario() {
        let mut scenario = demo();
        scenario.sound_speed =
            Some(toml::from_str("speed_m_s = 1500.0\ngradient_sigma_1_s = 0.1").expect("water"));
        for source in Source::ALL {
            assert_eq!(
                size(&scenario, source).len(),
                about(source).keys.len(),
                "{source:?}"
            );
        }
        let drift = size(&scenario, Source::PositionDrift);
        let sigma = scenario.trajectory.position_drift_sigma_m;
        assert_eq!(
            drift[0],
            ("trajectory.position_drift_sigma_m", sigma.to_string())
        );
    }

    #[test]
    fn a_source_acts_when_it_has_a_size_and_is_not_switched_off() {
        let mut scenario = demo();
        assert!(acting(&scenario).contains(&Source::PositionDrift));
        assert!(!acting(&scenario).contains(&Source::HeadingDrift));
        scenario.trajectory.heading_drift_sigma_deg = 0.01;
        assert!(acting(&scenario).contains(&Source::HeadingDrift));
        scenario.sources = scenario.sources.with(Source::PositionDrift, 0.0);
        assert!(!acting(&scenario).contains(&Source::PositionDrift));
        assert_eq!(acting(&nothing(&scenario)), vec![]);
        assert_eq!(
            acting(&alone(&scenario, Source::SonarRange)),
            vec![Source::SonarRange]
        );
    }

    #[test]
    fn alone_keeps_the_scenario_s_factor() {
        let mut scenario = demo();
        scenario.sources = scenario.sources.with(Source::SonarRange, 2.5);
        let alone = alone(&scenario, Source::SonarRange);
        assert_eq!(alone.sources.factor(Source::SonarRange), 2.5);
        assert_eq!(alone.sources.factor(Source::SonarAngle), 0.0);
    }
}
