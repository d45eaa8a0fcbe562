//! A seabed scenario: the bed, the boat, what goes wrong, the truth, the lines.

use std::path::Path;

use super::super::config::SeabedConfig;
use super::super::parameters::{self, Parameter};
use super::super::reference::ReferenceConfig;
use super::file::{
    GROWTH, PLACE, SIGMA_DEG, SIGMA_M, SIGMA_M_OR_NONE, SiteSection, TrajectorySection,
};
use crate::calibrate::verdict::VerdictConfig;
use crate::math;
use crate::observe::ArrayMountings;
use crate::observe::tide::one_period_m;
use crate::simulate::Sectors;
use crate::survey::document::Document;
use crate::survey::limits::{ABOVE, DURATION, Limits, SPEED, TURN, limits};
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::typed;
use crate::survey::schema::{self, Kind};
use crate::survey::section::section;
use crate::survey::sections::MountingAngles;

/// The built-in scenario.
pub const DEMO: &str = include_str!("../../../../models/scenarios/seabed.toml");

const METRES: Limits = limits(0.0, 100.0, "metres from 0 to 100");
const LENGTH: Limits = limits(ABOVE, 1e4, "metres above 0 and up to 10000");
const DEGREES: Limits = limits(-30.0, 30.0, "degrees from -30 to 30");
const MOTION: Limits = limits(0.0, 30.0, "degrees from 0 to 30");
const RATE: Limits = limits(ABOVE, 1000.0, "a rate above 0 and up to 1000 Hz");
const SECONDS: Limits = limits(-10.0, 10.0, "seconds from -10 to 10");
const RELATIVE: Limits = limits(-0.5, 0.5, "a number from -0.5 to 0.5");
const POINT: Limits = limits(-1e5, 1e5, "metres from -100000 to 100000");

section! {
    /// A scenario file.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SeabedScenario {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// `seabed`.
        procedure: String = required, Kind::OneOf(&["seabed"]);
        /// How the survey is written: as CSV files, or as a recorder's files, one of each line.
        format: String = or ("csv".to_owned()), Kind::OneOf(&["csv", "all", "kmall"]);
        /// Seed of the random numbers.
        seed: u64 = or (1), Kind::Count(limits(0.0, 1e15, "0 to 1e15"));
        /// The frame, as in a survey file.
        site: SiteSection = required, Kind::Table(SiteSection::KEYS);
        /// The seabed.
        bed: Bed = required, Kind::Table(Bed::KEYS);
        /// The boat in the waves.
        motion: Motion = required, Kind::Table(Motion::KEYS);
        /// What the INS claims and really does; `path` is the file that is written.
        trajectory: TrajectorySection = required, Kind::Table(TrajectorySection::KEYS);
        /// Records of the trajectory per second.
        trajectory_rate_hz: f64 = required, Kind::Number(RATE);
        /// Sound speed, one figure, metres per second.
        sound_speed_m_s: f64 = required, Kind::Number(SPEED);
        /// What the survey claims of its profile: relative error 20 m below the transducer, one sigma.
        profile_sigma: f64 = or (0.002), Kind::Number(limits(0.0, 0.1, "a number from 0 to 0.1"));
        /// The sonar.
        multibeam: Multibeam = required, Kind::Table(Multibeam::KEYS);
        /// A further head of a sounder that has several; the first one has the keys of `[multibeam]`.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        head: Vec<FurtherHead> = or (vec![]), Kind::Tables(FurtherHead::KEYS);
        /// A tide, written as a curve beside the survey.
        #[serde(skip_serializing_if = "Option::is_none")]
        tide: Option<SimulatedTide> = or (None), Kind::Table(SimulatedTide::KEYS);
        /// What is wrong besides noise.
        errors: Errors = or (Errors::default()), Kind::Table(Errors::KEYS);
        /// The lines.
        line: Vec<Course> = required, Kind::Tables(Course::KEYS);
        /// Settings of the joint path.
        seabed: SeabedConfig = or (SeabedConfig::default()), Kind::Table(SeabedConfig::KEYS);
        /// Settings of the reference path.
        reference: ReferenceConfig = or (ReferenceConfig::default()), Kind::Table(ReferenceConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
    }
}

section! {
    /// `[bed]`: a slope with a random field on it.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Bed {
        /// Depth at the origin, metres.
        depth_m: f64 = required, Kind::Number(limits(0.5, 1000.0, "metres from 0.5 to 1000"));
        /// Slope, degrees, falling towards `azimuth_deg`.
        slope_deg: f64 = or (0.0), Kind::Number(limits(-45.0, 45.0, "degrees from -45 to 45"));
        /// Where the slope falls to, degrees from north.
        azimuth_deg: f64 = or (0.0), Kind::Number(TURN);
        /// Standard deviation of the relief, metres.
        relief_m: f64 = required, Kind::Number(METRES);
        /// Its correlation length, metres.
        length_m: f64 = required, Kind::Number(LENGTH);
        /// Amplitude of ripples, metres.
        ripple_m: f64 = or (0.0), Kind::Number(METRES);
        /// Their length, metres.
        ripple_length_m: f64 = or (3.0), Kind::Number(LENGTH);
        /// Boulders per hectare, each a hump of half a metre to a metre across.
        boulders_per_ha: f64 = or (0.0), Kind::Number(limits(0.0, 1000.0, "0 to 1000"));
    }
}

section! {
    /// `[motion]`: standard deviations about the mean and the typical period.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Motion {
        /// Roll, degrees.
        roll_deg: f64 = required, Kind::Number(MOTION);
        /// Pitch, degrees.
        pitch_deg: f64 = required, Kind::Number(MOTION);
        /// Yaw about the course, degrees.
        yaw_deg: f64 = required, Kind::Number(MOTION);
        /// Heave, metres.
        heave_m: f64 = required, Kind::Number(METRES);
        /// Typical period, seconds.
        period_s: f64 = required, Kind::Number(DURATION);
    }
}

section! {
    /// `[multibeam]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Multibeam {
        /// True lever arm, metres.
        lever_arm_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// What the survey says of its lever arm: the true one plus a normal error of these sigmas, metres.
        lever_arm_sigma_m: [f64; 3] = or ([0.005, 0.005, 0.01]), Kind::Triple(SIGMA_M_OR_NONE);
        /// Nominal mounting angles, degrees.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Truth: correction of the mounting about the body axes, degrees.
        correction_deg: Turn = required, Kind::Table(Turn::KEYS);
        /// Range noise, metres.
        range_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Angle noise at the middle, degrees.
        angle_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Its growth outwards.
        angle_sigma_growth: f64 = or (0.0), Kind::Number(GROWTH);
        /// Pings per second.
        ping_rate_hz: f64 = required, Kind::Number(RATE);
        /// Beams of a ping.
        beams: u32 = required, Kind::Count(limits(2.0, 4096.0, "2 to 4096"));
        /// Half the swath, degrees.
        half_swath_deg: f64 = required, Kind::Number(limits(1.0, 80.0, "degrees from 1 to 80"));
        /// A transmit and a receive array instead of one head: what is sent at one moment is heard at another. Recorder files have it
        /// always.
        arrays: Option<TwoArrays> = or (None), Kind::Table(TwoArrays::KEYS);
    }
}

section! {
    /// `[[head]]`: a further head; what it does not say it has of the first one.
    #[derive(Clone, Debug, PartialEq)]
    pub struct FurtherHead {
        /// True lever arm, metres.
        lever_arm_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// What the survey says of its lever arm: the true one plus a normal error of these sigmas, metres.
        lever_arm_sigma_m: [f64; 3] = or ([0.005, 0.005, 0.01]), Kind::Triple(SIGMA_M_OR_NONE);
        /// Nominal mounting angles, degrees.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Truth: correction of the mounting about the body axes, degrees.
        correction_deg: Turn = required, Kind::Table(Turn::KEYS);
        /// Its stamps are late by more than the first one's, seconds.
        latency_s: f64 = or (0.0), Kind::Number(SECONDS);
        /// Nominal mounting angles of its receive array, degrees; those of its transmit array where they are not given.
        receiver_mounting_deg: Option<MountingAngles> = or (None), Kind::Table(MountingAngles::KEYS);
        /// From its transmit to its receive array in the body, metres.
        receiver_offset_m: [f64; 3] = or ([0.0; 3]), Kind::Triple(PLACE);
    }
}

section! {
    #[settings]
    /// `[multibeam.arrays]`: the transmit array has the lever arm and the mounting of the section above.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TwoArrays {
        /// Nominal mounting angles of the receive array, degrees; those of the transmit array where they are not given.
        receiver_mounting_deg: Option<MountingAngles> = or (None), Kind::Table(MountingAngles::KEYS);
        /// From the transmit to the receive array in the body, metres.
        receiver_offset_m: [f64; 3] = or ([0.0; 3]), Kind::Triple(PLACE);
        /// Transmit sectors of a swath.
        sectors: u32 = or (1), Kind::Count(limits(1.0, 9.0, "1 to 9"));
        /// Tilt from one sector to the next, degrees.
        sector_tilt_deg: f64 = or (0.0), Kind::Number(DEGREES);
        /// Delay from one sector to the next, seconds.
        sector_delay_s: f64 = or (0.0), Kind::Number(limits(0.0, 0.1, "seconds from 0 to 0.1"));
    }
}

impl TwoArrays {
    /// The sectors.
    #[must_use]
    pub fn sectors(&self) -> Sectors {
        Sectors {
            count: self.sectors,
            tilt_deg: self.sector_tilt_deg,
            delay_s: self.sector_delay_s,
        }
    }
}

impl SeabedScenario {
    /// The two arrays, where there are two: recorder files have them always.
    #[must_use]
    pub fn two_arrays(&self) -> Option<TwoArrays> {
        let recorded = (self.format != "csv").then(TwoArrays::default);
        self.multibeam.arrays.or(recorded)
    }

    /// The tide's range, its period, and when high water is, where there is one.
    #[must_use]
    pub fn one_period(&self) -> Option<(f64, f64, f64)> {
        let of = |t: &SimulatedTide| (t.range_m, t.period_s, START_S + t.high_water_s);
        self.tide.as_ref().map(of)
    }

    /// Height of the water over its level at a time, metres.
    #[must_use]
    pub fn tide_m(&self, time_s: f64) -> f64 {
        self.one_period().map_or(0.0, |t| one_period_m(t, time_s))
    }

    /// Every head, the first one first, as a further one is described.
    #[must_use]
    pub fn heads(&self) -> Vec<FurtherHead> {
        let m = &self.multibeam;
        let two = self.two_arrays().unwrap_or_default();
        let first = FurtherHead {
            lever_arm_m: m.lever_arm_m,
            lever_arm_sigma_m: m.lever_arm_sigma_m,
            mounting_deg: m.mounting_deg,
            correction_deg: m.correction_deg,
            latency_s: 0.0,
            receiver_mounting_deg: two.receiver_mounting_deg,
            receiver_offset_m: two.receiver_offset_m,
        };
        std::iter::once(first).chain(self.head.clone()).collect()
    }

    /// The parameters of the survey; its heads are numbered from 1.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let numbers: Vec<u32> = (1..=self.head.len() as u32 + 1).collect();
        parameters::list(&numbers)
    }

    /// How well the survey knows a lever arm's component: of a further head upwards that over the first one.
    #[must_use]
    pub fn arm_sigma_m(&self, head: usize, axis: usize) -> f64 {
        let heads = self.heads();
        let of = |head: usize| heads[head].lever_arm_sigma_m[axis];
        match (head, axis) {
            (0, _) | (_, 0 | 1) => of(head),
            _ => math::hypot(of(head), of(0)),
        }
    }
}

impl FurtherHead {
    /// Nominal mountings of both arrays with this lever arm of the transmit array.
    #[must_use]
    pub fn arrays(&self, lever_arm_m: [f64; 3]) -> ArrayMountings {
        let nominal = self.mounting_deg;
        let receiver = self.receiver_mounting_deg.unwrap_or(nominal);
        let receiver_arm_m = std::array::from_fn(|k| lever_arm_m[k] + self.receiver_offset_m[k]);
        ArrayMountings {
            transmitter: nominal.mounting(lever_arm_m),
            receiver: receiver.mounting(receiver_arm_m),
        }
    }
}

section! {
    /// A rotation about the body axes, degrees.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Turn {
        /// About x.
        pitch: f64 = required, Kind::Number(DEGREES);
        /// About y.
        roll: f64 = required, Kind::Number(DEGREES);
        /// About z.
        yaw: f64 = required, Kind::Number(DEGREES);
    }
}

section! {
    /// `[tide]`: one period, which boat and water really have; the survey gets it as a file, exact at its rows.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SimulatedTide {
        /// From low to high water, metres.
        range_m: f64 = required, Kind::Number(limits(0.0, 20.0, "metres from 0 to 20"));
        /// Its period, seconds.
        period_s: f64 = or (44_714.0), Kind::Number(limits(3600.0, 1e6, "seconds from 3600 to 1000000"));
        /// High water, seconds after the first line's begin.
        high_water_s: f64 = or (0.0), Kind::Number(limits(-1e6, 1e6, "seconds from -1000000 to 1000000"));
        /// Between two rows of the file, seconds.
        step_s: f64 = or (600.0), Kind::Number(limits(1.0, 3600.0, "seconds from 1 to 3600"));
    }
}

section! {
    #[settings]
    /// `[errors]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Errors {
        /// Stamps of the soundings are late, seconds.
        latency_s: f64 = or (0.0), Kind::Number(SECONDS);
        /// True range over measured range, minus 1.
        range_scale: f64 = or (0.0), Kind::Number(RELATIVE);
        /// Measured heave over true heave, minus 1.
        heave_scale: f64 = or (0.0), Kind::Number(RELATIVE);
        /// The heave channel is late, seconds.
        heave_lag_s: f64 = or (0.0), Kind::Number(SECONDS);
        /// The profile of the survey over the true one 20 m below the transducer, minus 1, growing linearly from there.
        profile: f64 = or (0.0), Kind::Number(RELATIVE);
        /// Offset of each line's heights (tide, datum), metres, one sigma.
        line_height_m: f64 = or (0.0), Kind::Number(METRES);
        /// Part of the soundings that are gross errors: a third single, a third in clusters of eight, a third in bursts of half a swath.
        gross: f64 = or (0.0), Kind::Number(limits(0.0, 0.6, "a part from 0 to 0.6"));
    }
}

section! {
    /// `[[line]]`: from where to where, east and north of the origin.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Course {
        /// Name.
        name: String = required, Kind::Text;
        /// Begin, metres.
        from_m: [f64; 2] = required, Kind::Pair(POINT);
        /// End, metres.
        to_m: [f64; 2] = required, Kind::Pair(POINT);
        /// Speed, metres per second.
        speed_m_s: f64 = required, Kind::Number(limits(ABOVE, 50.0, "metres per second above 0 and up to 50"));
    }
}

/// Reads a scenario.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong with it.
pub fn parse_scenario(file: &Path, text: &str) -> Result<SeabedScenario, SurveyError> {
    let document = Document::parse(file, text).map_err(|problems| SurveyError { problems })?;
    none_of(schema::check(&document, SeabedScenario::KEYS))?;
    let scenario: SeabedScenario = typed(file, text)?;
    let problem =
        |found: String| Problem::new(file, "scenario", found, "a survey that can be sailed");
    none_of(scenario.faults().into_iter().map(problem).collect())?;
    Ok(scenario)
}

/// When the first line begins, seconds.
pub const START_S: f64 = 1000.0;
/// Most soundings of a simulated survey.
const MOST_SOUNDINGS: f64 = 2e7;
/// Most heads beside the first.
const MOST_FURTHER: usize = 7;
/// Most records of its trajectory.
const MOST_RECORDS: f64 = 5e6;

impl SeabedScenario {
    /// What speaks against simulating it, one sentence each.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let length = |line: &Course| {
            math::hypot(line.to_m[0] - line.from_m[0], line.to_m[1] - line.from_m[1])
        };
        let standing = |line: &&Course| !(length(line) > 0.0);
        let mut faults: Vec<String> = self
            .line
            .iter()
            .filter(standing)
            .map(|line| format!("line \"{}\" has no length", line.name))
            .collect();
        let seconds: f64 = self
            .line
            .iter()
            .map(|line| length(line) / line.speed_m_s)
            .sum();
        let heads = (1 + self.head.len()) as f64;
        let of_ping = heads * f64::from(self.multibeam.beams);
        let soundings = seconds * self.multibeam.ping_rate_hz * of_ping;
        if self.format == "csv" && self.trajectory.above_water() {
            let fault = "heights from the heave in a CSV, which holds those above the ellipsoid";
            faults.push(fault.to_owned());
        }
        if self.format == "all" && self.head.len() > 1 {
            faults.push(format!(
                "{} heads in .all, which knows two",
                self.head.len() + 1
            ));
        }
        if self.head.len() > MOST_FURTHER {
            faults.push(format!(
                "{} further heads, more than {MOST_FURTHER}",
                self.head.len()
            ));
        }
        if soundings > MOST_SOUNDINGS {
            faults.push(format!(
                "{soundings:.0} soundings, more than {MOST_SOUNDINGS}"
            ));
        }
        let records = seconds * self.trajectory_rate_hz;
        if records > MOST_RECORDS {
            faults.push(format!(
                "{records:.0} records of the trajectory, more than {MOST_RECORDS}"
            ));
        }
        faults
    }
}
