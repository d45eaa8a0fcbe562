//! A seabed survey file as types.

use super::super::config::{JointSettings, SeabedConfig};
use super::super::reference::ReferenceConfig;
use super::super::scene::{Head, InsNoise, Line, Priors, SonarNoise};
use crate::calibrate::verdict::VerdictConfig;
use crate::formats::Invalid;
use crate::geometry::Ellipsoid;
use crate::observe::ArrayMountings;
use crate::survey::limits::{
    ABOVE, DURATION, ELLIPSOID, HEAD, INVALID, LEAP_S, Limits, OFFSET_S, TIMES, WEEK, limits,
};
use crate::survey::schema::Kind;
use crate::survey::section::section;
use crate::survey::sections::{MountingAngles, Origin};
use crate::units::radians;

pub(crate) const SIGMA_M: Limits = limits(ABOVE, 10.0, "metres above 0 and up to 10");
pub(crate) const SIGMA_M_OR_NONE: Limits = limits(0.0, 10.0, "metres from 0 to 10");
pub(crate) const SIGMA_DEG: Limits = limits(ABOVE, 10.0, "degrees above 0 and up to 10");
pub(crate) const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 10.0, "degrees from 0 to 10");
pub(crate) const PLACE: Limits = limits(-500.0, 500.0, "metres from -500 to 500");
pub(crate) const LEVEL: Limits = limits(-1e3, 1e3, "metres from -1000 to 1000");
pub(crate) const GROWTH: Limits = limits(0.0, 100.0, "a number from 0 to 100");
/// Time scales of a trajectory beside a recorder's soundings.
const TIME: Limits = limits(-1e12, 1e12, "seconds within 1e12");

section! {
    /// A survey file. Written as JSON or TOML again it shows every value as it took effect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SeabedSurveyFile {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// `seabed`.
        procedure: String = required, Kind::OneOf(&["seabed"]);
        /// The frame of the computation.
        site: SiteSection = required, Kind::Table(SiteSection::KEYS);
        /// The INS.
        trajectory: TrajectorySection = required, Kind::Table(TrajectorySection::KEYS);
        /// The water.
        sound_speed: SoundSpeedSection = required, Kind::Table(SoundSpeedSection::KEYS);
        /// The sonar.
        multibeam: MultibeamSection = required, Kind::Table(MultibeamSection::KEYS);
        /// The joint path.
        seabed: SeabedConfig = or (SeabedConfig::default()), Kind::Table(SeabedConfig::KEYS);
        /// The reference path.
        reference: ReferenceConfig = or (ReferenceConfig::default()), Kind::Table(ReferenceConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
        /// The tide over time, instead of `[[line]] tide_m`.
        #[serde(skip_serializing_if = "Option::is_none")]
        tide: Option<TideSection> = or (None), Kind::Table(TideSection::KEYS);
        /// A cast of the water, instead of `[sound_speed] profile`; as many as were taken.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        cast: Vec<CastSection> = or (vec![]), Kind::Tables(CastSection::KEYS);
        /// A further head of a sounder that has several; the first one has the keys of `[multibeam]`.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        head: Vec<HeadSection> = or (vec![]), Kind::Tables(HeadSection::KEYS);
        /// One line; as many as were sailed.
        line: Vec<LineSection> = required, Kind::Tables(LineSection::KEYS);
    }
}

section! {
    /// `[site]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SiteSection {
        /// Ellipsoid of the trajectory's positions.
        ellipsoid: Ellipsoid = or (Ellipsoid::default()), ELLIPSOID;
        /// Origin of the local frame: east, north, up.
        origin: Origin = required, Kind::Table(Origin::KEYS);
        /// Height of the water level in that frame, metres.
        water_level_m: f64 = or (0.0), Kind::Number(LEVEL);
        /// Tide or datum: one offset of each line, metres, one sigma.
        line_height_sigma_m: f64 = or (0.03), Kind::Number(SIGMA_M);
    }
}

section! {
    /// `[trajectory]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TrajectorySection {
        /// Path of the trajectory: an SBET, a NovAtel log, POS MV groups or a CSV with the columns `time_s`, `latitude_deg`, `longitude_deg`, `height_m`, `roll_deg`,
        /// `pitch_deg`, `heading_deg`. With recorder files it may be left out: then their own navigation is used.
        path: Option<String> = or (None), Kind::Text;
        /// Accuracies of an SBET (SMRMSG). They become the drift sigmas that are not given, each moment with its own.
        accuracies: Option<String> = or (None), Kind::Text;
        /// What the times of `path` are where the soundings are a recorder's (UTC): the same, on the GPS scale, or seconds of the week or
        /// of the day on either.
        time: Option<String> = or (None), TIMES;
        /// GPS week of seconds of the week; without it the week of the soundings.
        week: Option<u32> = or (None), WEEK;
        /// GPS minus UTC, seconds; without it that of the soundings' date.
        leap_seconds: Option<f64> = or (None), LEAP_S;
        /// Place of the point that `path` gives the positions of, in the body (right, forward, up), metres.
        lever_arm_m: [f64; 3] = or ([0.0; 3]), Kind::Triple(PLACE);
        /// Of a recorder's own navigation: heights above the ellipsoid, or the heave above the water level, the tide left to the lines.
        heights: String = or ("ellipsoid".to_owned()), Kind::OneOf(&["ellipsoid", "heave"]);
        /// White noise of the position per record and axis, metres.
        position_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Drift of east and north, metres.
        position_drift_sigma_m: f64 = required, Kind::Number(SIGMA_M_OR_NONE);
        /// Drift of the height, metres.
        height_drift_sigma_m: f64 = required, Kind::Number(SIGMA_M_OR_NONE);
        /// Correlation time of both, seconds.
        drift_correlation_time_s: f64 = required, Kind::Number(DURATION);
        /// White noise of roll and pitch per record, degrees.
        roll_pitch_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Drift of roll and pitch, degrees.
        roll_pitch_drift_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Its correlation time, seconds.
        roll_pitch_correlation_time_s: f64 = or (120.0), Kind::Number(DURATION);
        /// White noise of the heading per record, degrees.
        heading_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Drift of the heading, degrees.
        heading_drift_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Its correlation time, seconds.
        heading_correlation_time_s: f64 = or (120.0), Kind::Number(DURATION);
        /// Longest interval that is interpolated, seconds; soundings in a longer one are dropped.
        max_gap_s: f64 = or (1.0), Kind::Number(DURATION);
        /// Rows with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
}

impl TrajectorySection {
    /// Whether heights are the heave's, above the water level.
    #[must_use]
    pub fn above_water(&self) -> bool {
        self.heights == "heave"
    }
}

section! {
    /// `[sound_speed]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SoundSpeedSection {
        /// Path of the profile. With recorder files it may be left out: then every line has the last of their casts before it.
        profile: Option<String> = or (None), Kind::Text;
        /// Relative error of the profile 20 m below the transducer, growing linearly from there, one sigma; 0 holds it.
        profile_sigma: f64 = or (0.0), Kind::Number(limits(0.0, 0.1, "a number from 0 to 0.1"));
        /// Sound speed of a line between two casts, at the line's middle: of the cast nearest in time, or interpolated between the two.
        between: String = or ("interpolated".to_owned()), Kind::OneOf(&["interpolated", "nearest"]);
    }
}

section! {
    /// `[tide]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TideSection {
        /// Path of the curve: a CSV of `time_s` (seconds on the trajectory's clock, UTC beside recorder files, or ISO 8601) and `height_m` over
        /// `[site] water_level_m`, linear between rows at most an hour apart. Heights from the heave are lifted by it moment by moment; of heights
        /// above the ellipsoid only the depth of the transducer in the profile follows it.
        path: String = required, Kind::Text;
        /// Added to its times, seconds: where its clock is another, or local time.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
    }
}

section! {
    /// `[[cast]]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct CastSection {
        /// Path of the profile.
        path: String = required, Kind::Text;
        /// When it was taken, seconds on the trajectory's clock.
        time_s: f64 = required, Kind::Number(TIME);
    }
}

section! {
    /// `[multibeam]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct MultibeamSection {
        /// Path of the soundings: a recorder's file, a folder of recorder files, or a CSV with the columns `time_s`, `ping`, `beam`,
        /// `across_angle_deg`, `along_angle_deg` and `range_m` or `two_way_travel_time_s`.
        path: Option<String> = or (None), Kind::Text;
        /// Several recorder files instead.
        paths: Vec<String> = or (vec![]), Kind::Texts;
        /// Number of the first head: its serial number in recorder files, in a CSV what stands in the column `head`. Without `[[head]]` it is
        /// the only one that is calibrated, where the files have more.
        head: Option<u32> = or (None), HEAD;
        /// Lever arm in the body (right, forward, up), metres.
        lever_arm_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// Its standard deviations, metres. The vertical one cannot be separated from the heights of the lines and is held.
        lever_arm_sigma_m: [f64; 3] = or ([0.005, 0.005, 0.01]), Kind::Triple(SIGMA_M_OR_NONE);
        /// Nominal mounting angles, degrees.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Lever arm of the receive array, where it is not that of the transmit array.
        receiver_lever_arm_m: Option<[f64; 3]> = or (None), Kind::Triple(PLACE);
        /// Nominal mounting angles of the receive array, where they are not those of the transmit array. Both get one correction.
        receiver_mounting_deg: Option<MountingAngles> = or (None), Kind::Table(MountingAngles::KEYS);
        /// Range noise, metres, one sigma.
        range_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Across-track angle noise at the middle of the swath, degrees, one sigma.
        angle_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Its growth to the outer beams: sigma (1 + growth (|a| / 60 deg)^3).
        angle_sigma_growth: f64 = or (0.0), Kind::Number(GROWTH);
        /// Soundings further out are not used, degrees; by the angles of the beams beside them in the ping, so that noise does not choose.
        max_angle_deg: f64 = or (65.0), Kind::Number(limits(5.0, 90.0, "degrees from 5 to 90"));
        /// Rows of a CSV with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
}

section! {
    /// `[[head]]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct HeadSection {
        /// Its serial number in recorder files, in a CSV what stands in the column `head`.
        number: u32 = required, HEAD;
        /// Lever arm in the body (right, forward, up), metres.
        lever_arm_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// Its standard deviations, metres. The height over the first head is sought, as well as both are known upwards.
        lever_arm_sigma_m: [f64; 3] = or ([0.005, 0.005, 0.01]), Kind::Triple(SIGMA_M_OR_NONE);
        /// Nominal mounting angles, degrees.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Lever arm of its receive array, where it is not that of the transmit array.
        receiver_lever_arm_m: Option<[f64; 3]> = or (None), Kind::Triple(PLACE);
        /// Nominal mounting angles of its receive array, where they are not those of the transmit array. Both get one correction.
        receiver_mounting_deg: Option<MountingAngles> = or (None), Kind::Table(MountingAngles::KEYS);
    }
}

section! {
    /// `[[line]]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct LineSection {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// Recorder files that are this line, instead of start and end.
        files: Vec<String> = or (vec![]), Kind::Texts;
        /// Start, seconds on the trajectory's clock.
        start_s: f64 = required, Kind::Number(TIME);
        /// End, seconds.
        end_s: f64 = required, Kind::Number(TIME);
        /// Tide: the water's height over `[site] water_level_m` on this line, metres. Heights from the heave are lifted by it.
        tide_m: f64 = or (0.0), Kind::Number(limits(-50.0, 50.0, "metres from -50 to 50"));
        /// Tide or datum: how well the heights of this line are known, metres, one sigma; without it `[site] line_height_sigma_m`.
        datum_sigma_m: Option<f64> = or (None), Kind::Number(SIGMA_M);
    }
}

/// Where a head sits: transmit and receive array, as far as that differs.
struct Place {
    number: u32,
    arm_m: ([f64; 3], Option<[f64; 3]>),
    angles: (MountingAngles, Option<MountingAngles>),
    sigma_m: [f64; 3],
}

impl Place {
    fn head(&self, two: bool) -> Head {
        let (arm_m, angles) = (self.arm_m, self.angles);
        let receiver_arm_m = arm_m.1.unwrap_or(arm_m.0);
        let arrays = ArrayMountings {
            transmitter: angles.0.mounting(arm_m.0),
            receiver: angles.1.unwrap_or(angles.0).mounting(receiver_arm_m),
        };
        Head {
            number: self.number,
            nominal: match two {
                true => arrays.together(),
                false => arrays.transmitter,
            },
            arrays: two.then_some(arrays),
            lever_arm_sigma_m: self.sigma_m,
        }
    }
}

impl LineSection {
    /// Without a tide of its own.
    #[must_use]
    pub fn new(name: String, files: Vec<String>, [start_s, end_s]: [f64; 2]) -> Self {
        Self {
            name,
            files,
            start_s,
            end_s,
            tide_m: 0.0,
            datum_sigma_m: None,
        }
    }
}

impl SeabedSurveyFile {
    /// Settings of the joint path, the widest beam included.
    #[must_use]
    pub fn joint(&self, seed: u64) -> JointSettings {
        JointSettings {
            seabed: self.seabed.clone(),
            max_angle_deg: self.multibeam.max_angle_deg,
            verdict: self.verdict.clone(),
            seed,
        }
    }

    /// The heads, the first one first; of `two` arrays each, or of one that is both.
    #[must_use]
    pub fn heads(&self, two: bool) -> Vec<Head> {
        let m = &self.multibeam;
        let first = Place {
            number: m.head.unwrap_or(0),
            arm_m: (m.lever_arm_m, m.receiver_lever_arm_m),
            angles: (m.mounting_deg, m.receiver_mounting_deg),
            sigma_m: m.lever_arm_sigma_m,
        };
        let further = self.head.iter().map(|h| Place {
            number: h.number,
            arm_m: (h.lever_arm_m, h.receiver_lever_arm_m),
            angles: (h.mounting_deg, h.receiver_mounting_deg),
            sigma_m: h.lever_arm_sigma_m,
        });
        let all = std::iter::once(first).chain(further);
        all.map(|place| place.head(two)).collect()
    }

    /// The numbers of the heads, the first one's first; nothing of a single head without a number.
    #[must_use]
    pub fn head_numbers(&self) -> Vec<u32> {
        let further = self.head.iter().map(|head| head.number);
        self.multibeam.head.into_iter().chain(further).collect()
    }

    /// What the INS claims, in radians.
    #[must_use]
    pub fn ins(&self) -> InsNoise {
        let t = &self.trajectory;
        InsNoise {
            position_m: t.position_sigma_m,
            position_drift_m: t.position_drift_sigma_m,
            height_drift_m: t.height_drift_sigma_m,
            position_correlation_s: t.drift_correlation_time_s,
            roll_pitch_rad: radians(t.roll_pitch_sigma_deg),
            roll_pitch_drift_rad: radians(t.roll_pitch_drift_sigma_deg),
            roll_pitch_correlation_s: t.roll_pitch_correlation_time_s,
            heading_rad: radians(t.heading_sigma_deg),
            heading_drift_rad: radians(t.heading_drift_sigma_deg),
            heading_correlation_s: t.heading_correlation_time_s,
        }
    }

    /// What the sonar claims, in radians.
    #[must_use]
    pub fn sonar(&self) -> SonarNoise {
        let m = &self.multibeam;
        SonarNoise {
            range_m: m.range_sigma_m,
            angle_rad: radians(m.angle_sigma_deg),
            angle_growth: m.angle_sigma_growth,
        }
    }

    /// What is known beforehand.
    #[must_use]
    pub fn priors(&self) -> Priors {
        Priors {
            range_scale: self.seabed.range_scale_sigma,
            heave_scale: self.seabed.heave_scale_sigma,
            heave_lag_s: self.seabed.heave_lag_sigma_s,
            deep_sound_speed: self.sound_speed.profile_sigma,
        }
    }

    /// The lines.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        let one = |l: &LineSection| Line {
            name: l.name.clone(),
            start_s: l.start_s,
            end_s: l.end_s,
            cast: 0,
            tide_m: l.tide_m,
            height_sigma_m: l.datum_sigma_m.unwrap_or(self.site.line_height_sigma_m),
        };
        self.line.iter().map(one).collect()
    }
}
