//! Acoustic rays through a sound-speed profile: layers with a constant gradient, in which every ray is an exact arc.
//!
//! With `p = sin(theta) / c` constant along a ray (Snell) and `c = c1 + g (z - z1)` in a layer, a ray is an arc of radius
//! `1 / (p g)`; its travel time and chord are those of the Poincare half-plane (Lurton, An Introduction to Underwater
//! Acoustics, 2nd ed., section 2.7; Jensen et al., Computational Ocean Acoustics, section 3.3.5). All formulas below are
//! arranged so that they stay exact to rounding for a gradient of zero and for a vertical ray: neither is a special case.

use nalgebra::Vector3;
use thiserror::Error;

use crate::math;
use crate::observe::SoundSpeedProfile;

/// More arcs than any sounding has; a ray that needs them is caught in a channel without moving on.
const MOST_ARCS: usize = 100_000;

/// Why a sounding has no ray.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RayError {
    /// The profile cannot be used.
    #[error("sound-speed profile, row {row}: found {found}, expected {expected}")]
    Profile {
        /// Row, from 0.
        row: usize,
        /// What is there.
        found: String,
        /// What should be there.
        expected: &'static str,
    },
    /// The transducer is not in the water.
    #[error("transducer {height_m:.3} m above the water level")]
    AboveWater {
        /// Height above the water level, metres.
        height_m: f64,
    },
    /// The travel time is not a positive number.
    #[error("two-way travel time {two_way_s} s, expected a positive number")]
    TravelTime {
        /// Time found, seconds.
        two_way_s: f64,
    },
    /// The launch direction is not a number.
    #[error("launch direction is not a number")]
    Direction,
    /// The ray comes to the water surface before its time is over: the echo is a multiple reflection.
    #[error("the ray reaches the surface after {one_way_s:.6} s of {limit_s:.6} s")]
    Surface {
        /// One-way time to the surface, seconds.
        one_way_s: f64,
        /// One-way time of the sounding, seconds.
        limit_s: f64,
    },
    /// The ray runs along a sound channel and does not end.
    #[error("the ray is caught in a sound channel")]
    Caught,
}

/// A layer of linear sound speed, from `top_m` to the top of the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    top_m: f64,
    speed_m_s: f64,
    gradient_per_s: f64,
}

/// A checked profile as layers, from the surface to any depth: above its first and below its last sample the speed is constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    layers: Vec<Layer>,
    /// Whether the uppermost layer goes on above the water.
    open: bool,
}

/// Where a ray ends, seen from its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayEnd {
    /// Horizontal distance, metres, never negative.
    pub horizontal_m: f64,
    /// Descent, metres, positive down.
    pub descent_m: f64,
}

/// A ray on its way: where it is, where it heads, how fast sound is there.
#[derive(Clone, Copy, Debug)]
struct Ray {
    horizontal_m: f64,
    depth_m: f64,
    cosine: f64,
    speed_m_s: f64,
    constant: Constant,
}

/// What does not change along a ray: Snell's `p = sin(theta) / c`, and the launch that fixes |cos| at every speed.
#[derive(Clone, Copy, Debug)]
struct Constant {
    slowness_s_m: f64,
    launch_speed_m_s: f64,
    launch_cosine_squared: f64,
}

impl Constant {
    /// `cos^2` where the speed is `c`: `cos0^2 - p^2 (c - c0)(c + c0)`; negative where the ray does not go.
    fn cosine_squared(&self, c: f64) -> f64 {
        let bend = (c - self.launch_speed_m_s) * (c + self.launch_speed_m_s);
        self.launch_cosine_squared - self.slowness_s_m * self.slowness_s_m * bend
    }
}

impl Layers {
    /// From a profile; depths in metres below the water level.
    ///
    /// # Errors
    /// [`RayError::Profile`] for an empty profile, columns of different length, a depth that does not ascend or is negative,
    /// a speed that is not positive. Whether speeds are plausible for water is the reader's question.
    pub fn new(profile: &SoundSpeedProfile) -> Result<Self, RayError> {
        let (depth, speed) = (&profile.depth_m, &profile.speed_m_s);
        let fault = |row, found: String, expected| RayError::Profile {
            row,
            found,
            expected,
        };
        if depth.is_empty() || depth.len() != speed.len() {
            let found = format!("{} depths and {} speeds", depth.len(), speed.len());
            return Err(fault(0, found, "as many depths as speeds, at least one"));
        }
        for row in 0..depth.len() {
            if !(speed[row] > 0.0 && speed[row].is_finite()) {
                let found = format!("speed {} m/s", speed[row]);
                return Err(fault(row, found, "a positive speed"));
            }
            let above = if row == 0 { -1e-9 } else { depth[row - 1] };
            if !(depth[row] > above && depth[row].is_finite()) {
                let found = format!("depth {} m", depth[row]);
                return Err(fault(row, found, "depths from 0 on, ascending"));
            }
        }
        Ok(Self {
            layers: layers(depth, speed),
            open: false,
        })
    }

    /// The same, but the uppermost layer goes on above the water: a ray that comes to the surface ends where it would in more water. For an
    /// adjustment, whose beams may stand a little off on the way.
    #[must_use]
    pub fn open(self) -> Self {
        Self { open: true, ..self }
    }

    /// Sound speed at a depth, metres per second.
    #[must_use]
    pub fn speed_m_s(&self, depth_m: f64) -> f64 {
        let layer = self.layers[self.layer_at(depth_m, true)];
        layer.speed_m_s + layer.gradient_per_s * (depth_m - layer.top_m)
    }

    /// The layer that a ray at `depth_m` enters going down (or up).
    fn layer_at(&self, depth_m: f64, down: bool) -> usize {
        let count = self
            .layers
            .partition_point(|layer| layer.top_m < depth_m || (down && layer.top_m == depth_m));
        count.saturating_sub(1)
    }

    /// Traces a ray from `depth_m` with the sine and cosine of its angle from the downward vertical (cosine negative: it rises)
    /// for `one_way_s` seconds. Rays may turn inside a layer.
    ///
    /// Exact up to rounding for this profile: better than 1e-9 m over 100 m (measured in `docs/georeferencing.md`).
    ///
    /// # Errors
    /// [`RayError`] when the start is above the water, a figure is not a number, or the ray reaches the surface.
    pub fn trace(
        &self,
        depth_m: f64,
        (sine, cosine): (f64, f64),
        one_way_s: f64,
    ) -> Result<RayEnd, RayError> {
        if !(depth_m >= 0.0) {
            return Err(RayError::AboveWater { height_m: -depth_m });
        }
        if !(one_way_s > 0.0 && one_way_s.is_finite()) {
            let two_way_s = 2.0 * one_way_s;
            return Err(RayError::TravelTime { two_way_s });
        }
        if !(sine >= 0.0 && cosine.is_finite()) {
            return Err(RayError::Direction);
        }
        let speed_m_s = self.speed_m_s(depth_m);
        let mut ray = Ray {
            horizontal_m: 0.0,
            depth_m,
            cosine,
            speed_m_s,
            constant: Constant {
                slowness_s_m: sine / speed_m_s,
                launch_speed_m_s: speed_m_s,
                launch_cosine_squared: cosine * cosine,
            },
        };
        let mut index = self.layer_entered(depth_m, cosine);
        let mut left_s = one_way_s;
        for _ in 0..MOST_ARCS {
            let gradient_per_s = self.layers[index].gradient_per_s;
            let down = ray.heads_down(gradient_per_s);
            let arc = ray.arc(self.edge(index, down), gradient_per_s);
            if arc.time_s >= left_s {
                return Ok(ray.advanced(left_s, gradient_per_s).seen_from(depth_m));
            }
            left_s -= arc.time_s;
            ray = arc.end;
            index = match (arc.crosses, down) {
                (false, _) => index,
                (true, true) => index + 1,
                (true, false) if index > 0 => index - 1,
                (true, false) => {
                    return Err(RayError::Surface {
                        one_way_s: one_way_s - left_s,
                        limit_s: one_way_s,
                    });
                }
            };
        }
        Err(RayError::Caught)
    }

    /// The straight line from a transducer at `depth_m` to where the ray ends that leaves it in `direction` (unit vector, z up) for
    /// `one_way_s` seconds, metres.
    ///
    /// The sounder formed its beam with `head_speed_m_s`, the speed measured at the head: `p = sin(theta) / head_speed_m_s` is what it
    /// knows of the ray, whatever the profile says of that depth. With the profile's own speed instead, outer beams are wrong.
    ///
    /// # Errors
    /// As [`Self::trace`]; [`RayError::Direction`] also where no ray of that `p` can leave into the profile.
    pub fn chord(
        &self,
        depth_m: f64,
        (direction, head_speed_m_s): (Vector3<f64>, f64),
        one_way_s: f64,
    ) -> Result<Vector3<f64>, RayError> {
        let flat = math::hypot(direction.x, direction.y);
        let sine = flat * self.speed_m_s(depth_m.max(0.0)) / head_speed_m_s;
        if !(sine < 1.0) {
            return Err(RayError::Direction);
        }
        let cosine = (1.0 - sine * sine).sqrt().copysign(-direction.z);
        let end = self.trace(depth_m, (sine, cosine), one_way_s)?;
        let stretch = if flat > 0.0 {
            end.horizontal_m / flat
        } else {
            0.0
        };
        Ok(Vector3::new(
            direction.x * stretch,
            direction.y * stretch,
            -end.descent_m,
        ))
    }

    /// The layer of a ray's first arc; a horizontal ray between two layers bends into the one that is slower.
    fn layer_entered(&self, depth_m: f64, cosine: f64) -> usize {
        let below = self.layer_at(depth_m, true);
        let down = Ray::bends_down(cosine, self.layers[below].gradient_per_s);
        if down {
            below
        } else {
            self.layer_at(depth_m, false)
        }
    }

    /// Depth and speed where a ray leaves the layer downwards or upwards.
    fn edge(&self, index: usize, down: bool) -> (f64, f64) {
        if !down && index == 0 && self.open {
            return (f64::NEG_INFINITY, self.layers[index].speed_m_s);
        }
        if !down {
            return (self.layers[index].top_m, self.layers[index].speed_m_s);
        }
        self.layers
            .get(index + 1)
            .map_or((f64::INFINITY, self.layers[index].speed_m_s), |below| {
                (below.top_m, below.speed_m_s)
            })
    }
}

/// Layers between the samples, one of constant speed above the first sample and one below the last.
fn layers(depth: &[f64], speed: &[f64]) -> Vec<Layer> {
    let mut layers = Vec::with_capacity(depth.len() + 1);
    if depth[0] > 0.0 {
        layers.push(Layer {
            top_m: 0.0,
            speed_m_s: speed[0],
            gradient_per_s: 0.0,
        });
    }
    for k in 0..depth.len() {
        let gradient_per_s = if k + 1 < depth.len() {
            (speed[k + 1] - speed[k]) / (depth[k + 1] - depth[k])
        } else {
            0.0
        };
        layers.push(Layer {
            top_m: depth[k].max(0.0),
            speed_m_s: speed[k],
            gradient_per_s,
        });
    }
    layers
}

/// One arc of a ray: how long it takes, where it ends, and whether it ends at the layer's edge.
#[derive(Clone, Copy, Debug)]
struct Arc {
    time_s: f64,
    end: Ray,
    crosses: bool,
}

impl Ray {
    fn bends_down(cosine: f64, gradient_per_s: f64) -> bool {
        cosine > 0.0 || (cosine == 0.0 && gradient_per_s < 0.0)
    }

    /// Whether the ray goes down; a horizontal one bends to the slower side.
    fn heads_down(&self, gradient_per_s: f64) -> bool {
        Self::bends_down(self.cosine, gradient_per_s)
    }

    /// The arc to the layer's edge, or, for a ray that turns before it, back to its own depth.
    fn arc(&self, (edge_m, edge_speed_m_s): (f64, f64), gradient_per_s: f64) -> Arc {
        let squared = self.constant.cosine_squared(edge_speed_m_s);
        if edge_m.is_infinite() || (squared <= 0.0 && gradient_per_s == 0.0) {
            return self.endless();
        }
        if squared <= 0.0 {
            return self.turned(gradient_per_s);
        }
        let fall = edge_m - self.depth_m;
        let cosine = squared.sqrt().copysign(self.cosine_sign(fall));
        let sines = self.constant.slowness_s_m * (self.speed_m_s + edge_speed_m_s);
        let along = fall * sines / (self.cosine + cosine);
        let squared_s = (along * along + fall * fall) / (self.speed_m_s * edge_speed_m_s);
        Arc {
            time_s: half_plane_time(squared_s, gradient_per_s),
            end: Self {
                horizontal_m: self.horizontal_m + along,
                depth_m: edge_m,
                cosine,
                speed_m_s: edge_speed_m_s,
                constant: self.constant,
            },
            crosses: true,
        }
    }

    fn sine(&self) -> f64 {
        self.constant.slowness_s_m * self.speed_m_s
    }

    /// The side a ray leaves to: its own, or for a horizontal one that of the edge.
    fn cosine_sign(&self, fall: f64) -> f64 {
        if self.cosine == 0.0 {
            fall
        } else {
            self.cosine
        }
    }

    /// No edge ahead.
    fn endless(&self) -> Arc {
        Arc {
            time_s: f64::INFINITY,
            end: *self,
            crosses: false,
        }
    }

    /// The arc through the turning point back to the same depth: `t = 2 artanh(|cos|) / |g|`, `x = 2 c |cos| / (|g| sin)`.
    fn turned(&self, gradient_per_s: f64) -> Arc {
        let steep = self.cosine.abs() / gradient_per_s.abs();
        Arc {
            time_s: 2.0 * math::atanh(self.cosine.abs()) / gradient_per_s.abs(),
            end: Self {
                horizontal_m: self.horizontal_m + 2.0 * self.speed_m_s * steep / self.sine(),
                cosine: -self.cosine,
                ..*self
            },
            crosses: false,
        }
    }

    /// Where the ray is after `time_s` within a layer: with `u = tan(theta / 2)`, `u(t) = u exp(g t)`, on the chord at the mean angle.
    /// `(1 + u^2)` is multiplied through, so that an upward ray has no pole.
    fn advanced(&self, time_s: f64, gradient_per_s: f64) -> Self {
        let growth = math::exp_m1(gradient_per_s * time_s);
        let reach_m = if gradient_per_s == 0.0 {
            self.speed_m_s * time_s
        } else {
            self.speed_m_s * growth / gradient_per_s
        };
        let spread = 1.0 + 0.5 * growth * (1.0 - self.cosine);
        let half_turn = 0.5 * self.sine() * growth / spread;
        let cosine = 1.0 / math::hypot(half_turn, 1.0);
        let sine = half_turn * cosine;
        let chord = reach_m / spread * cosine;
        Self {
            horizontal_m: self.horizontal_m + chord * (self.sine() * cosine + self.cosine * sine),
            depth_m: self.depth_m + chord * (self.cosine * cosine - self.sine() * sine),
            ..*self
        }
    }

    fn seen_from(&self, begin_m: f64) -> RayEnd {
        RayEnd {
            horizontal_m: self.horizontal_m,
            descent_m: self.depth_m - begin_m,
        }
    }
}

/// Travel time over a chord in the half-plane metric: `(2 / g) arsinh(g s / 2)`, `s^2` the chord's over the product of the end speeds.
fn half_plane_time(squared_s: f64, gradient_per_s: f64) -> f64 {
    let squared = 0.25 * gradient_per_s * gradient_per_s * squared_s;
    let s = squared_s.sqrt();
    if squared < 1e-3 {
        // arsinh(h) / h; the next term is below half a rounding here
        let tail = 3.0 / 40.0 - squared * (15.0 / 336.0 - squared * (105.0 / 3456.0));
        return s * (1.0 - squared * (1.0 / 6.0 - squared * tail));
    }
    let half = squared.sqrt();
    math::asinh(half) / half * s
}
