//! Bent rays by integrating the ray equation, so that nothing is shared with the calibration's closed form.

use crate::math;
use crate::observe::SoundSpeedProfile;
use crate::simulate::refraction::speed_and_gradient;

/// Steps of the fourth-order Runge-Kutta method along a ray.
const STEPS: usize = 400;
/// Shots at the most; a handful is usual.
const MOST_SHOTS: usize = 40;

/// A ray that arrives: angle from the downward vertical at the transducer (rad) and one-way time (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrival {
    pub(super) angle_rad: f64,
    pub(super) time_s: f64,
}

/// Horizontal distance, depth, angle.
type State = [f64; 3];

/// `dx/dt = c sin a`, `dz/dt = c cos a`, `da/dt = c' sin a` (Snell's law differentiated).
fn rate(water: &SoundSpeedProfile, state: &State) -> State {
    let (speed, gradient) = speed_and_gradient(water, state[1]);
    let (sine, cosine) = math::sin_cos(state[2]);
    [speed * sine, speed * cosine, gradient * sine]
}

fn plus(state: &State, rate: &State, by: f64) -> State {
    [0, 1, 2].map(|i| state[i] + by * rate[i])
}

fn shoot(water: &SoundSpeedProfile, depth_m: f64, aim: &Arrival) -> State {
    let step = aim.time_s / STEPS as f64;
    let mut state = [0.0, depth_m, aim.angle_rad];
    for _ in 0..STEPS {
        let k1 = rate(water, &state);
        let k2 = rate(water, &plus(&state, &k1, 0.5 * step));
        let k3 = rate(water, &plus(&state, &k2, 0.5 * step));
        let k4 = rate(water, &plus(&state, &k3, step));
        state = [0, 1, 2].map(|i| state[i] + step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    state
}

/// The ray from a depth to a horizontal distance and a descent, metres.
pub(super) fn arrival(
    water: &SoundSpeedProfile,
    depth_m: f64,
    horizontal_m: f64,
    descent_m: f64,
) -> Arrival {
    let range_m = math::hypot(horizontal_m, descent_m);
    let (speed, _) = speed_and_gradient(water, depth_m);
    let mut aim = Arrival {
        angle_rad: math::atan2(horizontal_m, descent_m),
        time_s: range_m / speed,
    };
    let (along_x, along_z) = (horizontal_m / range_m, descent_m / range_m);
    for _ in 0..MOST_SHOTS {
        let end = shoot(water, depth_m, &aim);
        let miss = (horizontal_m - end[0], depth_m + descent_m - end[1]);
        aim.angle_rad += (miss.0 * along_z - miss.1 * along_x) / range_m;
        aim.time_s *= 1.0 + (miss.0 * along_x + miss.1 * along_z) / range_m;
        if math::hypot(miss.0, miss.1) < 1e-12 * range_m {
            break;
        }
    }
    aim
}
