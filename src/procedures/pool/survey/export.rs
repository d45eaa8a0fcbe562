//! The soundings of a simulated survey as a Kongsberg recorder would have written them, with attitude, positions, a cast and the
//! installation record, and with the solution that a sounder makes of them by its installation values.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use nalgebra::Vector3;

use crate::formats::recorder::{Attitude, BeamSample, Ping, Position, Profile, Sector, Solution};
use crate::formats::{FormatError, whole};
use crate::geometry::ellipsoid::{Geodetic, TargetPose, ecef_from_level};
use crate::geometry::rotation;
use crate::georef::{ArrayAim, Water, local_trajectory};
use crate::observe::{GeodeticTrajectory, Mounting, PoseSample, SoundSpeed, Soundings, Trajectory};
use crate::recorders::recording::{self, EPOCH_S, Kongsberg, Recording, Sounder};
use crate::simulate::Simulated;

/// Depth to which a cast of one speed goes, metres.
const DEEPEST_M: f64 = 100.0;

/// Writes the file; nothing where the survey is not of two arrays.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub(super) fn write(path: &Path, format: Kongsberg, survey: &Simulated) -> Result<(), FormatError> {
    let soundings = &survey.campaign.soundings;
    let Some(arrays) = &soundings.arrays else {
        return Ok(());
    };
    let sensor = format.sensor();
    let begin_s = EPOCH_S + soundings.time_s.first().copied().unwrap_or(0.0) - 10.0;
    let export = Export::new(format, survey);
    let recording = Recording {
        begin_s,
        arrays: &[arrays.mountings],
        sensor: &sensor,
        cast: cast(begin_s - 60.0, survey.campaign.sound_speed.as_ref()),
        motion: motion(&survey.campaign.trajectory, &sensor, export.level_m),
        pings: export.pings(),
    };
    whole::write_whole(path, |out: &mut BufWriter<&mut File>| {
        recording.write(format, out)
    })
}

fn cast(time_s: f64, speed: Option<&SoundSpeed>) -> Profile {
    let (depth_m, speed_m_s) = match speed {
        Some(SoundSpeed::Profile(p)) => (p.depth_m.clone(), p.speed_m_s.clone()),
        Some(SoundSpeed::Constant(c)) => (vec![0.0, DEEPEST_M], vec![*c; 2]),
        None => (vec![0.0, DEEPEST_M], vec![1500.0; 2]),
    };
    Profile {
        time_s: time_s.floor(),
        depth_m,
        speed_m_s,
    }
}

/// Attitude and position of a sensor at every record of the body; heave over the water, whose height above the ellipsoid is `level_m`.
fn motion(
    trajectory: &GeodeticTrajectory,
    sensor: &Mounting,
    level_m: f64,
) -> Vec<(Attitude, Position)> {
    let t = trajectory;
    let one = |k: usize| {
        let body = Geodetic {
            latitude_rad: t.latitude_rad[k],
            longitude_rad: t.longitude_rad[k],
            height_m: t.height_m[k],
        };
        let attitude = rotation::from_attitude(t.roll_rad[k], t.pitch_rad[k], t.heading_rad[k]);
        let mut place = t.ellipsoid.to_geocentric(&body);
        place.coordinates += ecef_from_level(&body).matrix * (attitude * sensor.lever_arm_m);
        let place = t.ellipsoid.to_geodetic(&place);
        let turned = attitude * sensor.rotation;
        recording::motion(
            EPOCH_S + t.time_s[k],
            &turned,
            &place,
            body.height_m - level_m,
        )
    };
    (0..t.time_s.len()).map(one).collect()
}

/// The soundings on their way into pings, and what the sounder knows to solve them.
struct Export<'s> {
    soundings: &'s Soundings,
    format: Kongsberg,
    /// East, north, up from the target's believed origin.
    trajectory: Trajectory,
    water: Option<Water>,
    /// Height of the water above the ellipsoid, metres.
    level_m: f64,
    /// The same in the local frame.
    local_level_m: f64,
}

impl<'s> Export<'s> {
    fn new(format: Kongsberg, survey: &'s Simulated) -> Self {
        let campaign = &survey.campaign;
        let pose = TargetPose {
            azimuth_rad: 0.0,
            ..survey.prior
        };
        let speed = campaign.sound_speed.as_ref();
        Self {
            soundings: &campaign.soundings,
            format,
            trajectory: local_trajectory(&campaign.trajectory, &pose).trajectory,
            water: speed.and_then(|speed| Water::new(speed, campaign.water_level_m).ok()),
            level_m: pose.origin.height_m + campaign.water_level_m,
            local_level_m: campaign.water_level_m,
        }
    }

    fn pings(&self) -> Vec<(Ping, Solution)> {
        let rows: Vec<usize> = (0..self.soundings.len()).collect();
        let number = |k: usize| self.soundings.ping[k];
        let pings = rows.chunk_by(|a, b| number(*a) == number(*b));
        pings.filter_map(|rows| self.ping(rows)).collect()
    }

    fn ping(&self, rows: &[usize]) -> Option<(Ping, Solution)> {
        let s = self.soundings;
        let first = *rows.first()?;
        let time_s = s.time_s[first];
        let mut sectors: Vec<Sector> = vec![];
        let mut sector_of = |k: usize| {
            let own = Sector {
                tilt_rad: s.along_rad[k],
                delay_s: s.time_s[k] - time_s,
                frequency_hz: 3e5,
                array: 0,
            };
            let known = sectors.iter().position(|sector| *sector == own);
            known.unwrap_or_else(|| {
                sectors.push(own);
                sectors.len() - 1
            }) as u16
        };
        let beams = rows.iter().map(|&k| BeamSample {
            number: s.beam[k],
            sector: sector_of(k),
            valid: true,
            angle_rad: s.across_rad[k],
            two_way_s: s.range.values()[k],
        });
        let beams = beams.collect();
        let head_speed = s.arrays.as_ref()?.head_speed_m_s[first];
        let ping = Ping {
            time_s: EPOCH_S + time_s,
            number: s.ping[first],
            head: 1,
            head_speed_m_s: f64::from(head_speed),
            sectors,
            beams,
        };
        let solution = self.solution(&ping, rows)?;
        Some((ping, solution))
    }

    fn solution(&self, ping: &Ping, rows: &[usize]) -> Option<Solution> {
        let arrays = self.soundings.arrays.as_ref()?;
        let pose = self.trajectory.pose_at(ping.time_s - EPOCH_S).ok()?;
        let sounder = Sounder {
            pose: &pose,
            arrays: &arrays.mountings,
            level_m: self.local_level_m,
        };
        let points_m = rows.iter().map(|k| self.point(*k));
        Some(self.format.solution(ping, &sounder, points_m))
    }

    /// Where sounding `k` struck by the installation values.
    fn point(&self, k: usize) -> Option<Vector3<f64>> {
        let s = self.soundings;
        let arrays = s.arrays.as_ref()?;
        let two_way_s = s.range.values()[k];
        let at = |time_s: f64| {
            let PoseSample {
                position_m,
                rotation,
                ..
            } = self.trajectory.pose_at(time_s).ok()?;
            Some((position_m, rotation))
        };
        let way = (0.5 * two_way_s, f64::from(arrays.head_speed_m_s[k]));
        let aim = ArrayAim::new(
            &arrays.mountings,
            (s.along_rad[k], s.across_rad[k]),
            way,
            [at(s.time_s[k])?, at(s.time_s[k] + two_way_s)?],
        )?;
        let launch = (aim.direction, way.1);
        let water = self.water.as_ref()?;
        let chord = water.chord(aim.transducer_m.z, launch, way.0).ok()?;
        Some(aim.transducer_m + chord)
    }
}
