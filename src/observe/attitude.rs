//! Roll, pitch and heading over time, without positions.

/// The record of an attitude sensor, columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AttitudeRecord {
    /// Time, seconds, ascending.
    pub time_s: Vec<f64>,
    /// Roll, radians, positive right side down.
    pub roll_rad: Vec<f64>,
    /// Pitch, radians, positive front up.
    pub pitch_rad: Vec<f64>,
    /// Heading, radians, clockwise.
    pub heading_rad: Vec<f64>,
}

impl AttitudeRecord {
    /// From roll, pitch and heading by record, radians.
    #[must_use]
    pub fn from_angles(time_s: Vec<f64>, angles_rad: &[[f64; 3]]) -> Self {
        let column = |i: usize| angles_rad.iter().map(|a| a[i]).collect();
        Self {
            time_s,
            roll_rad: column(0),
            pitch_rad: column(1),
            heading_rad: column(2),
        }
    }

    /// Roll, pitch and heading, radians, a column each.
    #[must_use]
    pub fn columns(&self) -> [&[f64]; 3] {
        [&self.roll_rad, &self.pitch_rad, &self.heading_rad]
    }

    /// Roll, pitch, heading by record, radians.
    pub fn angles_rad(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let level = self.roll_rad.iter().zip(&self.pitch_rad);
        let all = level.zip(&self.heading_rad);
        all.map(|((roll, pitch), heading)| [*roll, *pitch, *heading])
    }
}
