//! Transmit sectors of a swath.

/// Sectors of equal width, each tilted and sent against the one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sectors {
    /// How many, at least one.
    pub count: u32,
    /// Tilt from one to the next, degrees; the swath's middle is not tilted.
    pub tilt_deg: f64,
    /// Delay from one to the next, seconds.
    pub delay_s: f64,
}

impl Sectors {
    /// Tilt (radians) and delay (seconds) of one of them.
    #[must_use]
    pub fn sector(&self, number: u32) -> (f64, f64) {
        let from_middle = f64::from(number) - 0.5 * f64::from(self.count - 1);
        (
            (from_middle * self.tilt_deg).to_radians(),
            f64::from(number) * self.delay_s,
        )
    }

    /// The one in which a beam lies; `part` goes from 0 to 1 over the swath.
    #[must_use]
    pub fn of_beam(&self, part: f64) -> u32 {
        ((part * f64::from(self.count)) as u32).min(self.count - 1)
    }
}
