//! From range and beam angles to the sounding's vector in the sonar frame, with its derivatives (`docs/conventions.md`).

use crate::math;
use nalgebra::{Matrix3, Vector3};

/// One sounding's polar observation after refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Slant range r, metres.
    pub range_m: f64,
    /// Across-track angle a, radians, positive to starboard.
    pub across_rad: f64,
    /// Along-track angle c, radians, elevation out of the across plane, positive forward.
    pub along_rad: f64,
}

/// `u` and its derivatives with respect to range, across and along angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamPartials {
    /// The vector u in the sonar frame, metres.
    pub vector_m: Vector3<f64>,
    /// Columns: du/dr (unitless), du/da, du/dc (metres per radian).
    pub jacobian: Matrix3<f64>,
}

impl Beam {
    /// The beam whose vector is `u_m` (metres, sensor frame): the inverse of [`Self::vector_m`].
    #[must_use]
    pub fn from_vector(u_m: &Vector3<f64>) -> Self {
        let flat = math::hypot(u_m.x, u_m.z);
        Self {
            range_m: math::hypot(flat, u_m.y),
            across_rad: math::atan2(u_m.x, -u_m.z),
            along_rad: math::atan2(u_m.y, flat),
        }
    }

    /// `u = r (sin a cos c, sin c, -cos a cos c)`.
    #[must_use]
    pub fn vector_m(&self) -> Vector3<f64> {
        let (sa, ca) = math::sin_cos(self.across_rad);
        let (sc, cc) = math::sin_cos(self.along_rad);
        Vector3::new(sa * cc, sc, -ca * cc) * self.range_m
    }

    /// `u` together with its derivatives.
    #[must_use]
    pub fn partials(&self) -> BeamPartials {
        self.resolved().partials()
    }

    /// The beam by sines and cosines of its angles.
    #[must_use]
    pub fn resolved(&self) -> ResolvedBeam {
        ResolvedBeam {
            range_m: self.range_m,
            across: math::sin_cos(self.across_rad),
            along: math::sin_cos(self.along_rad),
        }
    }
}

/// A beam by sines and cosines: moving it by small angles costs no trigonometric function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolvedBeam {
    range_m: f64,
    across: (f64, f64),
    along: (f64, f64),
}

impl ResolvedBeam {
    /// The beam with range (metres), across and along angle (radians) changed by `correction`.
    #[must_use]
    pub fn moved(&self, correction: &Vector3<f64>) -> Self {
        Self {
            range_m: self.range_m + correction.x,
            across: turned(self.across, correction.y),
            along: turned(self.along, correction.z),
        }
    }

    /// `u` together with its derivatives.
    #[must_use]
    pub fn partials(&self) -> BeamPartials {
        let ((sa, ca), (sc, cc)) = (self.across, self.along);
        let direction = Vector3::new(sa * cc, sc, -ca * cc);
        let across = Vector3::new(ca * cc, 0.0, sa * cc) * self.range_m;
        let along = Vector3::new(-sa * sc, cc, ca * sc) * self.range_m;
        BeamPartials {
            vector_m: direction * self.range_m,
            jacobian: Matrix3::from_columns(&[direction, across, along]),
        }
    }
}

/// Sine and cosine of an angle changed by `by` radians; by series, exact to rounding, where the change is small.
fn turned((sine, cosine): (f64, f64), by: f64) -> (f64, f64) {
    let (s, c) = if by.abs() < 0.02 {
        let q = by * by;
        (
            by * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0))),
            1.0 - 0.5 * q * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))),
        )
    } else {
        math::sin_cos(by)
    };
    (sine * c + cosine * s, cosine * c - sine * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        let beam = Beam {
            range_m: 7.0,
            across_rad: -0.7,
            along_rad: 0.2,
        };
        let partials = beam.partials();
        let step = 1e-6;
        for (column, bump) in [(step, 0.0, 0.0), (0.0, step, 0.0), (0.0, 0.0, step)]
            .into_iter()
            .enumerate()
        {
            let shifted = |sign: f64| Beam {
                range_m: beam.range_m + sign * bump.0,
                across_rad: beam.across_rad + sign * bump.1,
                along_rad: beam.along_rad + sign * bump.2,
            };
            let difference = (shifted(1.0).vector_m() - shifted(-1.0).vector_m()) / (2.0 * step);
            assert!((difference - partials.jacobian.column(column)).norm() < 1e-8);
        }
    }

    #[test]
    fn a_moved_beam_is_the_beam_moved() {
        let beam = Beam {
            range_m: 7.0,
            across_rad: -0.7,
            along_rad: 0.2,
        };
        for by in [1e-4, -0.0199, 0.0201, 0.3] {
            let moved = Beam {
                range_m: 7.5,
                across_rad: -0.7 + by,
                along_rad: 0.2 - by,
            };
            let found = beam
                .resolved()
                .moved(&Vector3::new(0.5, by, -by))
                .partials();
            assert!((found.vector_m - moved.vector_m()).norm() < 4e-15);
            assert!((found.jacobian - moved.partials().jacobian).norm() < 8e-15);
        }
    }

    #[test]
    fn a_beam_returns_from_its_vector() {
        for (across_rad, along_rad) in [(0.0, 0.0), (1.1, -0.3), (-2.0, 0.4), (1.8, 0.0)] {
            let beam = Beam {
                range_m: 8.0,
                across_rad,
                along_rad,
            };
            let back = Beam::from_vector(&beam.vector_m());
            assert!((back.range_m - 8.0).abs() < 1e-14);
            assert!((back.across_rad - across_rad).abs() < 1e-15);
            assert!((back.along_rad - along_rad).abs() < 1e-15);
        }
    }

    #[test]
    fn a_beam_to_starboard_points_right_and_a_zero_beam_down() {
        let right = Beam {
            range_m: 1.0,
            across_rad: 1.0,
            along_rad: 0.0,
        };
        assert!(right.vector_m().x > 0.8);
        let down = Beam {
            range_m: 2.0,
            across_rad: 0.0,
            along_rad: 0.0,
        };
        assert_eq!(down.vector_m(), Vector3::new(0.0, 0.0, -2.0));
        let forward = Beam {
            range_m: 1.0,
            across_rad: 0.0,
            along_rad: 0.3,
        };
        assert!(forward.vector_m().y > 0.2);
    }
}
