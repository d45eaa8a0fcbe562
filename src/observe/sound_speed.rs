//! Sound speed: one figure, or a profile over depth.

/// The speed of sound in the water.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundSpeed {
    /// One speed everywhere, metres per second.
    Constant(f64),
    /// A measured profile; rays bend.
    Profile(SoundSpeedProfile),
}

/// A sound-speed profile: layers with a linear gradient between the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundSpeedProfile {
    /// Depth below the water level, metres, ascending.
    pub depth_m: Vec<f64>,
    /// Sound speed at each depth, metres per second.
    pub speed_m_s: Vec<f64>,
}
