//! A seabed survey in memory: soundings of several lines, the trajectory in one local frame, the water, and what is known beforehand.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::parameters::{self, Kind, Parameter};
use crate::calibrate::cloud::Beam;
use crate::georef::Layers;
use crate::math;
use crate::observe::{
    ArrayMountings, Extra, ExtraFault, Mounting, SoundSpeedProfile, TideCurve, Trajectory, extra,
};
use crate::stats::median;

/// A-priori noise and drift of the INS, metres, radians, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsNoise {
    /// White position noise per record and axis, metres.
    pub position_m: f64,
    /// Drift of east and north, metres.
    pub position_drift_m: f64,
    /// Drift of the height, metres.
    pub height_drift_m: f64,
    /// Correlation time of the position drift, seconds.
    pub position_correlation_s: f64,
    /// White roll and pitch noise per record, radians.
    pub roll_pitch_rad: f64,
    /// Drift of roll and pitch, radians.
    pub roll_pitch_drift_rad: f64,
    /// Correlation time of the roll and pitch drift, seconds.
    pub roll_pitch_correlation_s: f64,
    /// White heading noise per record, radians.
    pub heading_rad: f64,
    /// Drift of the heading, radians.
    pub heading_drift_rad: f64,
    /// Correlation time of the heading drift, seconds.
    pub heading_correlation_s: f64,
}

/// Standard deviations of the trajectory's drift where a file states them over time; linear between its records, held at the ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriftSigmas {
    /// Time of each record, seconds on the trajectory's clock, not descending.
    pub time_s: Vec<f64>,
    /// East, north, up (metres), turns about the body's x, y, z (radians); empty where [`InsNoise`] holds all along.
    pub components: [Vec<f64>; 6],
}

impl DriftSigmas {
    /// Of one component at a time; nothing where the file states none.
    #[must_use]
    pub fn at(&self, component: usize, time_s: f64) -> Option<f64> {
        let sigmas = &self.components[component];
        let after = self.time_s.partition_point(|t| *t < time_s);
        let (a, b) = (
            after.saturating_sub(1),
            after.min(self.time_s.len().checked_sub(1)?),
        );
        let (begin, end) = (*sigmas.get(a)?, *sigmas.get(b)?);
        let part = (time_s - self.time_s[a]) / (self.time_s[b] - self.time_s[a]);
        Some(if part > 0.0 && part < 1.0 {
            begin + part * (end - begin)
        } else {
            end
        })
    }
}

/// A-priori noise of the sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarNoise {
    /// Range, metres, one sigma.
    pub range_m: f64,
    /// Across-track beam angle at the middle of the swath, radians, one sigma.
    pub angle_rad: f64,
    /// Growth to the outer beams: `sigma = angle (1 + growth (|a| / 60 deg)^3)`.
    pub angle_growth: f64,
}

impl SonarNoise {
    /// Standard deviation of a beam's across-track angle, radians.
    #[must_use]
    pub fn angle_sigma_rad(&self, across_rad: f64) -> f64 {
        let outward = across_rad.abs() / 60f64.to_radians();
        self.angle_rad * (1.0 + self.angle_growth * outward.powi(3))
    }
}

/// One sounding of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sounding {
    /// Which line.
    pub line: u16,
    /// Index of the head, 0 where there is one.
    pub head: u8,
    /// Stamp, seconds.
    pub time_s: f64,
    /// Across-track angle at the transducer, radians, positive to starboard.
    pub across_rad: f64,
    /// Along-track angle at the transducer, radians, positive forward.
    pub along_rad: f64,
    /// One-way travel time, seconds.
    pub one_way_s: f64,
    /// Sound speed at the head that the beam former used, metres per second; 0 where it is the profile's. Used with two arrays only.
    pub head_speed_m_s: f32,
    /// Number of the sounding in the observed file.
    pub row: u32,
    /// Its ping and beam.
    pub beam: Beam,
}

/// A head: how it is mounted as far as that is known beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Its number in the files: a serial number, or what stands in the column `head` of a CSV; 0 where there is only one.
    pub number: u32,
    /// Nominal mounting. Of two arrays: roll of the receive array, the rest of the transmit array; one correction serves both.
    pub nominal: Mounting,
    /// The two arrays, where they stand each on its own.
    pub arrays: Option<ArrayMountings>,
    /// Standard deviations of the lever arm (right, forward, up), metres; 0 holds it. The first head's one upwards is held whatever it is:
    /// it is inseparable from the heights of the lines.
    pub lever_arm_sigma_m: [f64; 3],
}

impl Head {
    /// Its number in words, such as `head 102`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("head {}", self.number)
    }
}

/// One line: its name and when it was sailed.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name for reports.
    pub name: String,
    /// Begin, seconds.
    pub start_s: f64,
    /// End, seconds.
    pub end_s: f64,
    /// Which cast of the water is its own.
    pub cast: usize,
    /// Height of the water over its level, metres; nothing where the survey has a curve of it.
    pub tide_m: f64,
    /// Standard deviation of the line's height, metres.
    pub height_sigma_m: f64,
}

#[cfg(test)]
impl Line {
    /// A line at sea level for tests of times.
    pub(super) fn between(start_s: f64, end_s: f64) -> Self {
        Self {
            name: "a".to_owned(),
            start_s,
            end_s,
            cast: 0,
            tide_m: 0.0,
            height_sigma_m: 0.03,
        }
    }
}

/// Standard deviations of what is known beforehand; a figure of 0 holds the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Priors {
    /// Range scale.
    pub range_scale: f64,
    /// Scale of the heave channel.
    pub heave_scale: f64,
    /// Lag of the heave channel, seconds.
    pub heave_lag_s: f64,
    /// Relative error of the sound-speed profile at [`REFERENCE_DEPTH_M`].
    pub deep_sound_speed: f64,
}

/// Depth below the transducer at which the error of the profile is stated, metres; it grows linearly from the transducer.
pub const REFERENCE_DEPTH_M: f64 = 20.0;

/// The tide of a survey.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tide {
    /// Height of the water over its level at every moment; without it each line has one height.
    pub curve: Option<TideCurve>,
    /// Whether the trajectory's heights are above the water, so that they lack the tide.
    pub lifts: bool,
}

/// The water: its level in the local frame, the tide and the sound-speed profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// Height of the surface, metres.
    pub level_m: f64,
    /// Height over that level.
    pub tide: Tide,
    /// Casts, at least one: depths below the surface and the sound speed at each.
    pub casts: Vec<SoundSpeedProfile>,
    /// Depth of the transducer, metres, where the profile's error is zero.
    pub transducer_m: f64,
}

impl Water {
    /// The layers of each cast when the profiles are wrong by `error` (relative) at the reference depth.
    ///
    /// `None` where a profile cannot be used.
    #[must_use]
    pub fn layers(&self, error: f64) -> Option<Vec<Layers>> {
        let off = |depth: f64| 1.0 + error * (depth - self.transducer_m) / REFERENCE_DEPTH_M;
        let layers = |cast: &SoundSpeedProfile| {
            let speed = cast.depth_m.iter().zip(&cast.speed_m_s);
            let profile = SoundSpeedProfile {
                depth_m: cast.depth_m.clone(),
                speed_m_s: speed.map(|(depth, c)| c * off(*depth)).collect(),
            };
            Layers::new(&profile).ok()
        };
        self.casts.iter().map(layers).collect()
    }

    /// Sound speed at the top of the first cast, metres per second.
    #[must_use]
    pub fn surface_speed_m_s(&self) -> f64 {
        let first = self.casts.first().and_then(|cast| cast.speed_m_s.first());
        first.copied().unwrap_or(1500.0)
    }
}

/// A survey ready to be calibrated.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Poses of the body in the local frame: east, north, up.
    pub trajectory: Trajectory,
    /// Wave-band heave of each record, metres, see [`wave_heave_m`].
    pub heave_m: Vec<f64>,
    /// What the INS claims.
    pub ins: InsNoise,
    /// How its drift's standard deviations change along the survey, where a file says so.
    pub drift: DriftSigmas,
    /// The lines.
    pub lines: Vec<Line>,
    /// All soundings, line after line, in order of time within each.
    pub soundings: Vec<Sounding>,
    /// The water.
    pub water: Water,
    /// What the sonar claims.
    pub sonar: SonarNoise,
    /// Keys of the noise that nobody stated and that is taken as an ordinary installation's.
    pub assumed: Vec<&'static str>,
    /// The heads, at least one.
    pub heads: Vec<Head>,
    /// What is known beforehand.
    pub priors: Priors,
    /// Unknowns of the caller's own, one derivative for each row of the observed file, see [`Sounding::row`].
    pub extras: Arc<[Extra]>,
}

impl Scene {
    /// Median depth of the transducer over the soundings, metres, 0 above the water.
    #[must_use]
    pub fn transducer_depth_m(&self) -> f64 {
        self.median_depth_m().unwrap_or(0.0).max(0.0)
    }

    /// Median depth of the transducer over the soundings, metres, negative above the water; nothing without a pose.
    #[must_use]
    pub fn median_depth_m(&self) -> Option<f64> {
        let step = self.soundings.len().div_ceil(2000).max(1);
        let depth = |s: &Sounding| {
            let pose = self.trajectory.pose_at(s.time_s).ok()?;
            let line = usize::from(s.line);
            let level_m = self.water.level_m + self.tide_m(line, s.time_s);
            let nominal = &self.heads[usize::from(s.head)].nominal;
            let transducer = pose.position_m + pose.rotation * nominal.lever_arm_m;
            Some(level_m - transducer.z - self.lift_m(line, s.time_s))
        };
        let some = self.soundings.iter().step_by(step);
        median(&mut some.filter_map(depth).collect::<Vec<f64>>())
    }

    /// The same survey with unknowns of the caller's own, of a file with so many soundings.
    ///
    /// # Errors
    /// [`ExtraFault`] for one that cannot be used, or whose name another parameter has.
    pub fn with_extras(&self, extras: &Arc<[Extra]>, rows: usize) -> Result<Self, ExtraFault> {
        let all: Vec<String> = self.parameters().iter().map(Parameter::name).collect();
        let in_words = all.iter().map(|name| name.replace('_', " "));
        let mut taken: Vec<String> = all.iter().cloned().chain(in_words).collect();
        taken.sort_unstable();
        taken.dedup();
        let taken: Vec<&str> = taken.iter().map(String::as_str).collect();
        extra::check(extras, rows, &taken)?;
        Ok(Self {
            extras: Arc::clone(extras),
            ..self.clone()
        })
    }

    /// The parameters of the survey, in their order.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let numbers: Vec<u32> = self.heads.iter().map(|head| head.number).collect();
        let own = parameters::of_extras(&self.extras);
        parameters::list(&numbers).into_iter().chain(own).collect()
    }

    /// Standard deviation of what is known of a parameter beforehand; 0 where nothing is, or where it is held.
    #[must_use]
    pub fn prior_sigma(&self, parameter: &Parameter) -> f64 {
        let p = &self.priors;
        let of_arm = |axis: usize| {
            let arm = |head: usize| self.heads.get(head).map(|h| h.lever_arm_sigma_m[axis]);
            let own = arm(usize::from(parameter.head.unwrap_or(0))).unwrap_or(0.0);
            // what the first one's is off by goes into the heights of the lines, and with them into what the others lie above it
            match axis {
                2 if own > 0.0 => math::hypot(own, arm(0).unwrap_or(0.0)),
                _ => own,
            }
        };
        match parameter.kind {
            Kind::Pitch | Kind::Roll | Kind::Yaw | Kind::Latency => 0.0,
            Kind::RangeScale => p.range_scale,
            Kind::HeaveScale => p.heave_scale,
            Kind::HeaveLag => p.heave_lag_s,
            Kind::ArmRight => of_arm(0),
            Kind::ArmForward => of_arm(1),
            Kind::ArmUp => of_arm(2),
            Kind::DeepSoundSpeed => p.deep_sound_speed,
            Kind::Own => {
                let extra = parameter.own().and_then(|place| self.extras.get(place));
                extra.and_then(|extra| extra.prior_sigma).unwrap_or(0.0)
            }
        }
    }

    /// Height of the water over its level on a line at a time, metres.
    #[must_use]
    pub fn tide_m(&self, line: usize, time_s: f64) -> f64 {
        let of_line = || self.lines[line].tide_m;
        let curve = self.water.tide.curve.as_ref();
        curve.map_or_else(of_line, |curve| curve.at(time_s))
    }

    /// What the trajectory's heights lack on a line at a time, metres: the tide, where they are heights above the water.
    #[must_use]
    pub fn lift_m(&self, line: usize, time_s: f64) -> f64 {
        match self.water.tide.lifts {
            true => self.tide_m(line, time_s),
            false => 0.0,
        }
    }

    /// The strip of seabed that a sounding is of: one head's on one line. Strips are told apart wherever surfaces are, for heads that are
    /// not calibrated yet see different ones.
    #[must_use]
    pub fn strip(&self, sounding: &Sounding) -> u32 {
        u32::from(sounding.line) * self.heads.len() as u32 + u32::from(sounding.head)
    }

    /// Angle of a beam from the vertical of the boat, radians, positive to starboard: of several heads, which look to different sides, with
    /// the nominal roll of its own; of one head the angle against its axis.
    #[must_use]
    pub fn abeam_rad(&self, sounding: &Sounding) -> f64 {
        if self.heads.len() == 1 {
            return sounding.across_rad;
        }
        sounding.across_rad - self.heads[usize::from(sounding.head)].nominal.angles().0
    }

    /// Angle of sounding `k` from the axis of its head, radians, as its neighbours in the ping tell it: linear in the beam's number between
    /// them, or on from the last two. What takes part is chosen by this angle, for a choice by the beam's own keeps, of a beam that points
    /// at the limit, those whose noise turns them inwards. The beam's own where its ping has fewer than two others.
    #[must_use]
    pub fn aside_rad(&self, k: usize) -> f64 {
        let own = &self.soundings[k];
        let neighbour = |by: isize| {
            let other = self.soundings.get(k.checked_add_signed(by)?)?;
            let strip = |s: &Sounding| (s.line, s.head, s.beam.ping);
            let beam = |s: &Sounding| f64::from(s.beam.beam);
            let apart = beam(other) - beam(own);
            (strip(other) == strip(own) && apart != 0.0).then_some((apart, other.across_rad))
        };
        let through = |near: Option<(f64, f64)>, far: Option<(f64, f64)>| {
            let ((near, near_rad), (far, far_rad)) = (near?, far?);
            let slope = (far_rad - near_rad) / (far - near);
            slope.is_finite().then_some(near_rad - slope * near)
        };
        through(neighbour(-1), neighbour(1))
            .or_else(|| through(neighbour(-1), neighbour(-2)))
            .or_else(|| through(neighbour(1), neighbour(2)))
            .unwrap_or(own.across_rad)
    }

    /// Median depth of the soundings below the transducer at the nominal mounting, metres; 0 without soundings.
    #[must_use]
    pub fn typical_depth_m(&self) -> f64 {
        let speed = self.water.surface_speed_m_s();
        let step = (self.soundings.len() / 5000).max(1);
        let rolls: Vec<f64> = self.heads.iter().map(|h| -h.nominal.angles().0).collect();
        let depth = |s: &Sounding| {
            s.one_way_s * speed * math::cos(s.across_rad + rolls[usize::from(s.head)])
        };
        let mut depths: Vec<f64> = self.soundings.iter().step_by(step).map(depth).collect();
        median(&mut depths).unwrap_or(0.0)
    }
}

/// Correlation length of the smoothing that separates waves from slow heights, seconds.
const WAVE_BAND_S: f64 = 5.0;

/// Measured height minus its Gaussian mean over 5 s, record by record, metres; a mean does not reach over a gap of the records.
#[must_use]
pub fn wave_heave_m(trajectory: &Trajectory, max_gap_s: f64) -> Vec<f64> {
    let (time_s, position_m) = (trajectory.times_s(), trajectory.positions_m());
    let pieces = pieces(time_s, max_gap_s);
    let smooth = |piece: std::ops::Range<usize>| {
        let (begin, end) = (piece.start, piece.end);
        piece.map(move |k| {
            position_m[k].z - mean_height_m(time_s, position_m, begin..end, time_s[k])
        })
    };
    pieces.into_iter().flat_map(smooth).collect()
}

/// Gaussian mean of the heights of `piece` about a time; the weights of records off both ends fall away.
fn mean_height_m(
    time_s: &[f64],
    position_m: &[Vector3<f64>],
    piece: std::ops::Range<usize>,
    at_s: f64,
) -> f64 {
    let reach_s = 4.0 * WAVE_BAND_S;
    let first = piece.start + time_s[piece.clone()].partition_point(|t| *t < at_s - reach_s);
    let last = piece.start + time_s[piece].partition_point(|t| *t <= at_s + reach_s);
    let (mut weight, mut sum) = (0.0, 0.0);
    for k in first..last {
        let x = (time_s[k] - at_s) / WAVE_BAND_S;
        let w = math::exp(-0.5 * x * x);
        weight += w;
        sum += w * position_m[k].z;
    }
    sum / weight
}

/// Ranges of records without a gap.
fn pieces(time_s: &[f64], max_gap_s: f64) -> Vec<std::ops::Range<usize>> {
    let (mut pieces, mut begin) = (vec![], 0);
    for k in 1..=time_s.len() {
        if k == time_s.len() || time_s[k] - time_s[k - 1] > max_gap_s {
            pieces.push(begin..k);
            begin = k;
        }
    }
    pieces
}

/// Body axes of an attitude as columns, for derivatives.
pub(super) fn axis(rotation: &Matrix3<f64>, k: usize) -> Vector3<f64> {
    rotation.column(k).into_owned()
}

#[cfg(test)]
impl Scene {
    /// `seabed-thin`, seed 1, its scenario's text changed.
    pub(super) fn thin(changed: impl Fn(&str) -> String) -> Self {
        use super::simulate::{Acts, simulate};
        use super::survey::{parse_scenario, write};
        let text = changed(include_str!("../../../models/scenarios/seabed-thin.toml"));
        let scenario = parse_scenario(std::path::Path::new("thin"), &text).expect("a scenario");
        let survey = simulate(&scenario, 1, Acts::NONE);
        write::scene(&write::survey_file(&scenario, &survey), &scenario, &survey)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The thin survey with beams whose true angles are known: every `spacing` degrees, with noise of 0.1 deg.
    fn scene(spacing_deg: f64) -> (Scene, Vec<f64>) {
        let mut scene = Scene::thin(str::to_owned);
        let mut draws = crate::stats::stream(7, 7);
        let beams = scene.soundings.iter().map(|s| s.beam.beam).max();
        let middle = f64::from(beams.expect("soundings").div_ceil(2));
        let sigma_rad = 0.1f64.to_radians();
        let mut noise = |sounding: &mut Sounding| {
            let true_rad = ((f64::from(sounding.beam.beam) - middle) * spacing_deg).to_radians();
            let off_rad = sigma_rad * crate::stats::normal::draw(&mut draws);
            sounding.across_rad = true_rad + off_rad;
            off_rad
        };
        let off_rad = scene.soundings.iter_mut().map(&mut noise).collect();
        (scene, off_rad)
    }

    /// Beams point at the limit exactly. Those chosen by their neighbours' angles have noise of mean zero within four of its standard
    /// errors; chosen by their own, the outermost beam alone would put it 0.08 deg inwards.
    #[test]
    fn what_is_chosen_by_the_angles_beside_it_has_noise_of_mean_zero() {
        let (scene, off_rad) = scene(3.0);
        let limit_rad = 30f64.to_radians();
        let outermost = |chosen: &dyn Fn(usize) -> f64| {
            let near = |k: &usize| (scene.soundings[*k].across_rad - limit_rad).abs() < 0.01;
            let all = (0..scene.soundings.len()).filter(near);
            let kept: Vec<f64> = all
                .filter(|k| chosen(*k).abs() <= limit_rad)
                .map(|k| off_rad[k])
                .collect();
            let mean = kept.iter().sum::<f64>() / kept.len() as f64;
            (mean, 0.1f64.to_radians() / (kept.len() as f64).sqrt())
        };
        let (mean, error) = outermost(&|k| scene.aside_rad(k));
        assert!(mean.abs() < 4.0 * error, "{mean} {error}");
        let (mean, error) = outermost(&|k| scene.soundings[k].across_rad);
        assert!(mean < -10.0 * error, "{mean} {error}");
    }

    /// The outermost beams go on from the two beside them; a ping of one or two beams has its own angles only.
    #[test]
    fn the_edge_goes_on_and_a_lone_beam_stands_for_itself() {
        let (mut scene, _) = scene(3.0);
        for (k, sounding) in scene.soundings.iter_mut().enumerate() {
            sounding.across_rad = 0.01 * f64::from(sounding.beam.beam);
            // beams 6 and 7 are missing from every other ping: numbers count, not places
            if sounding.beam.ping % 2 == 1 && sounding.beam.beam > 5 {
                sounding.beam.beam += 2;
                sounding.across_rad += 0.02;
            }
            sounding.row = k as u32;
        }
        let first = scene.soundings[0].beam.ping;
        for k in 0..200 {
            let off = scene.aside_rad(k) - scene.soundings[k].across_rad;
            assert!(off.abs() < 1e-12, "{k}: {off}");
        }
        let mut beams = 0;
        scene.soundings.retain(|s| {
            beams += usize::from(s.beam.ping == first);
            s.beam.ping != first || beams <= 2
        });
        scene.soundings[0].across_rad = 0.7;
        assert_eq!(scene.aside_rad(0), 0.7);
    }
}
