//! Observations from arrays, with the noise of the sensors in `models/sensors`. Figures of your own system go into the `noise` fields.

use super::{
    Campaign, GeodeticTrajectory, LaserCoordinates, LaserNoise, LaserScan, Mounting, Outside,
    SonarNoise, SoundingRange, Soundings, TrajectoryNoise,
};
use crate::geometry::Ellipsoid;

/// Longest interval of a trajectory that is interpolated unless it is said otherwise, seconds.
const MAX_GAP_S: f64 = 0.5;

impl TrajectoryNoise {
    /// A tactical-grade fibre-optic INS, post-processed: `models/sensors/span-lci.toml`.
    #[must_use]
    pub fn tactical_grade() -> Self {
        Self {
            position_m: 0.002,
            position_drift_m: 0.01,
            drift_correlation_time_s: 60.0,
            roll_pitch_rad: 0.003_f64.to_radians(),
            heading_rad: 0.005_f64.to_radians(),
            heading_drift_rad: 0.0,
        }
    }
}

impl LaserNoise {
    /// A surveying scanner in line-scan mode: `models/sensors/riegl-vz-1000.toml`; georeferenced points 1 cm.
    #[must_use]
    pub fn line_scanner() -> Self {
        Self {
            range_m: 0.005,
            angle_rad: 0.002_f64.to_radians(),
            point_m: 0.01,
        }
    }
}

impl SonarNoise {
    /// A shallow-water multibeam of half a degree beam width: `models/sensors/r2sonic-2024.toml`.
    #[must_use]
    pub fn shallow_water() -> Self {
        Self {
            range_m: 0.01,
            across_rad: 0.06_f64.to_radians(),
            along_rad: 0.0,
        }
    }
}

impl GeodeticTrajectory {
    /// From times (seconds), positions (WGS84 latitude and longitude in radians, ellipsoidal height in metres) and attitudes (roll,
    /// pitch, true heading in radians); noise of [`TrajectoryNoise::tactical_grade`].
    #[must_use]
    pub fn from_arrays(time_s: Vec<f64>, position: &[[f64; 3]], attitude_rad: &[[f64; 3]]) -> Self {
        let [latitude_rad, longitude_rad, height_m] = columns(position);
        let [roll_rad, pitch_rad, heading_rad] = columns(attitude_rad);
        Self {
            ellipsoid: Ellipsoid::Wgs84,
            time_s,
            latitude_rad,
            longitude_rad,
            height_m,
            roll_rad,
            pitch_rad,
            heading_rad,
            velocity_m_s: None,
            noise: TrajectoryNoise::tactical_grade(),
            max_gap_s: MAX_GAP_S,
            outside: Outside::Error,
        }
    }
}

impl LaserScan {
    /// From times (seconds) and points in the scanner's frame (metres); noise of [`LaserNoise::line_scanner`].
    #[must_use]
    pub fn from_arrays(time_s: Vec<f64>, points_m: &[[f64; 3]]) -> Self {
        let [x_m, y_m, z_m] = columns(points_m);
        Self {
            time_s,
            x_m,
            y_m,
            z_m,
            coordinates: LaserCoordinates::Sensor,
            noise: LaserNoise::line_scanner(),
        }
    }
}

impl Soundings {
    /// From times of the pings (seconds), angles across the track (radians, positive to starboard) and slant ranges (metres), one row
    /// per beam; rows of one time are one ping. Noise of [`SonarNoise::shallow_water`].
    #[must_use]
    pub fn from_arrays(time_s: Vec<f64>, across_rad: Vec<f64>, range_m: Vec<f64>) -> Self {
        let (ping, beam) = numbered(&time_s);
        Self {
            along_rad: vec![0.0; across_rad.len()],
            ping,
            beam,
            time_s,
            across_rad,
            range: SoundingRange::Metres(range_m),
            noise: SonarNoise::shallow_water(),
            arrays: None,
            file: None,
        }
    }
}

impl Campaign {
    /// From a trajectory, and scanner and sonar with how each is believed to be mounted. The scanner's mounting counts as free of
    /// error, soundings are ranges, the water level is the target's z = 0.
    #[must_use]
    pub fn new(
        trajectory: GeodeticTrajectory,
        (scanner, laser): (Mounting, LaserScan),
        (sonar, soundings): (Mounting, Soundings),
    ) -> Self {
        Self {
            trajectory,
            laser,
            soundings,
            scanner,
            scanner_sigma: None,
            sonar,
            sound_speed: None,
            water_level_m: 0.0,
        }
    }
}

/// Rows of three as three columns.
fn columns(rows: &[[f64; 3]]) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|k| rows.iter().map(|row| row[k]).collect())
}

/// Ping and beam numbers of rows in order of time.
fn numbered(time_s: &[f64]) -> (Vec<u32>, Vec<u32>) {
    let (mut pings, mut beams) = (vec![], vec![]);
    for (k, time) in time_s.iter().enumerate() {
        let same = k > 0 && time_s[k - 1] == *time;
        let (ping, beam) = match (pings.last(), beams.last()) {
            (Some(ping), Some(beam)) if same => (*ping, beam + 1),
            (Some(ping), _) => (ping + 1, 0),
            (None, _) => (0, 0),
        };
        pings.push(ping);
        beams.push(beam);
    }
    (pings, beams)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_time_are_one_ping() {
        let (ping, beam) = numbered(&[1.0, 1.0, 1.5, 1.5, 1.5, 2.0]);
        assert_eq!(ping, [0, 0, 1, 1, 1, 2]);
        assert_eq!(beam, [0, 1, 0, 1, 2, 0]);
    }

    #[test]
    fn the_noise_is_that_of_the_sensor_files() {
        let figure = |text: &str, key: &str| -> f64 {
            let table: toml::Table = toml::from_str(text).expect("TOML");
            table[key].as_float().expect("a number")
        };
        let ins = include_str!("../../models/sensors/span-lci.toml");
        let noise = TrajectoryNoise::tactical_grade();
        assert_eq!(noise.position_m, figure(ins, "position_sigma_m"));
        assert_eq!(
            noise.position_drift_m,
            figure(ins, "position_drift_sigma_m")
        );
        assert_eq!(
            noise.drift_correlation_time_s,
            figure(ins, "drift_correlation_time_s")
        );
        assert_eq!(
            noise.roll_pitch_rad,
            figure(ins, "roll_pitch_sigma_deg").to_radians()
        );
        assert_eq!(
            noise.heading_rad,
            figure(ins, "heading_sigma_deg").to_radians()
        );
        let lidar = include_str!("../../models/sensors/riegl-vz-1000.toml");
        let noise = LaserNoise::line_scanner();
        assert_eq!(noise.range_m, figure(lidar, "range_sigma_m"));
        assert_eq!(
            noise.angle_rad,
            figure(lidar, "angle_sigma_deg").to_radians()
        );
        let sonar = include_str!("../../models/sensors/r2sonic-2024.toml");
        let noise = SonarNoise::shallow_water();
        assert_eq!(noise.range_m, figure(sonar, "range_sigma_m"));
        assert_eq!(
            noise.across_rad,
            figure(sonar, "angle_sigma_deg").to_radians()
        );
    }
}
