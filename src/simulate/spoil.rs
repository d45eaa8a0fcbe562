//! Observations that are no observations of the target: gross errors, clutter, late reflections.

use super::scenario::Scenario;
use super::sources::Source;
use super::switches::Draws;

/// Clutter is not nearer to the sensor than this, metres.
const NEAREST_M: f64 = 0.5;

/// What a sensor takes for the echo of a shot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taken {
    /// Range, metres.
    pub(super) range_m: f64,
    /// Whether it is the echo of the surface that the shot hit, and no gross error, clutter or late reflection.
    pub(super) own: bool,
}

/// Draws for every shot of one sensor, whether it hit or not, so that a shot's fate depends on nothing but its place.
pub(super) struct Spoiler {
    gross: (f64, f64),
    clutter: f64,
    late: (f64, f64),
    roughness_m: f64,
    draws: [Draws; 4],
    first_row: u64,
}

impl Spoiler {
    /// For a sensor whose rows of the random streams begin at `first_row`; `gross` is fraction and largest error (metres).
    pub(super) fn new(
        scenario: &Scenario,
        clutter: f64,
        gross: (f64, f64),
        seed: u64,
        first_row: u64,
    ) -> Self {
        let draws = |source| Draws::new(seed, source, &scenario.sources);
        let d = &scenario.disturbance;
        let sources = [
            Source::GrossErrors,
            Source::Clutter,
            Source::Multipath,
            Source::TargetFlatness,
        ];
        Self {
            gross,
            clutter,
            late: (d.multipath_fraction, d.multipath_delay_m),
            roughness_m: scenario.target.roughness_sigma_m,
            draws: sources.map(draws),
            first_row,
        }
    }

    /// Goes to the beginning of a ping or scan line.
    pub(super) fn seek(&mut self, row: u64) {
        for draws in &mut self.draws {
            draws.seek(self.first_row + row);
        }
    }

    /// What the sensor takes for the echo: of the surface it hit (range and cosine), or of something else.
    pub(super) fn spoil(&mut self, echo: Option<(f64, f64)>, max_range_m: f64) -> Option<Taken> {
        let [gross, clutter, late, rough] = &mut self.draws;
        let error = chance(gross, self.gross.0).map(|u| (2.0 * u - 1.0) * self.gross.1);
        let before = chance(clutter, self.clutter);
        let delay = chance(late, self.late.0).map(|u| u * self.late.1);
        let rough_m = if self.roughness_m > 0.0 {
            rough.normal(self.roughness_m)
        } else {
            0.0
        };
        let range_m = echo.map(|(range_m, cosine)| range_m + rough_m / cosine.max(0.05));
        if let Some(part) = before {
            let far_m = range_m.unwrap_or(max_range_m).max(NEAREST_M);
            return Some(Taken {
                range_m: NEAREST_M + part * (far_m - NEAREST_M),
                own: false,
            });
        }
        let wrong = delay.or(error);
        range_m.map(|r| Taken {
            range_m: r + wrong.unwrap_or(0.0),
            own: wrong.is_none(),
        })
    }
}

/// With this probability (scaled by the source's factor) a second uniform number; draws two numbers whatever happens.
fn chance(draws: &mut Draws, fraction: f64) -> Option<f64> {
    if fraction == 0.0 {
        return None;
    }
    let (lot, value) = (draws.uniform(), draws.uniform());
    (lot < fraction * draws.factor()).then_some(value)
}
