//! The beam of a sounder whose transmit and receive arrays are mounted, and moving, each on its own.
//!
//! A beam lies on two cones: one about the transmit array's long axis at the time of transmission, one about the receive array's at
//! the time of reception. With `f` the transmit axis (forward) and `s` the receive axis (starboard) in the local frame,
//!
//! ```text
//! f = A(t_tx) M_t e_y,  s = A(t_rx) M_r e_x,   u.f = sin(tilt),  u.s = sin(angle),  |u| = 1
//! q = f.s,  al = (sin c - q sin a) / (1 - q^2),  be = (sin a - q sin c) / (1 - q^2),  w = s x f / |s x f|
//! u = al f + be s - sqrt(1 - al^2 - be^2 - 2 al be q) w
//! ```
//!
//! Two arrays at right angles at one moment give the beam of [`Beam`](super::beam::Beam). Of the two directions on both cones the one
//! below the receive array is taken, so that an array may be built in the other way round.
//!
//! Turning the transmit array about its own long axis, or the receive array about its own, changes nothing: of the six angles of two
//! arrays two are never determined. One correction common to both arrays takes roll from the receive array, pitch from the transmit
//! array and heading from the transmit array.

use crate::math;
use crate::observe::ArrayMountings;
use nalgebra::{Matrix3, Vector3};

/// How the two arrays stand at a beam's two moments: the attitudes and each array's rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrayPair {
    /// Body into local frame at transmission.
    pub attitude_at_transmission: Matrix3<f64>,
    /// Body into local frame at reception.
    pub attitude_at_reception: Matrix3<f64>,
    /// Transmit array into body.
    pub transmitter: Matrix3<f64>,
    /// Receive array into body.
    pub receiver: Matrix3<f64>,
}

/// A unit vector in the local frame and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConePartials {
    /// Direction of the beam in the local frame.
    pub direction: Vector3<f64>,
    /// By tilt and by receive angle, per radian.
    pub angles: [Vector3<f64>; 2],
    /// Columns: by one left perturbation `Exp(delta)` of both mountings in the body (pitch, roll, yaw), per radian.
    pub correction: Matrix3<f64>,
    /// Columns: by a left perturbation of the attitude at transmission, in the local frame, per radian.
    pub attitude_at_transmission: Matrix3<f64>,
    /// Columns: by a left perturbation of the attitude at reception, in the local frame, per radian.
    pub attitude_at_reception: Matrix3<f64>,
}

/// Sound speed that serves where only a share of the arrays' distance hangs on it, metres per second.
const ORDINARY_M_S: f64 = 1500.0;

/// A beam sent at one pose and heard at another: where it begins and where it goes, in the frame of the poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrayAim {
    /// The arrays at the two moments.
    pub pair: ArrayPair,
    /// Half way from the place of transmission to that of reception, metres.
    pub transducer_m: Vector3<f64>,
    /// Direction seen from there.
    pub direction: Vector3<f64>,
    /// From the place of transmission to that of reception, metres.
    apart_m: Vector3<f64>,
    /// Half the way of the sound, metres.
    range_m: f64,
    /// Tilt and receive angle, radians.
    angles_rad: (f64, f64),
}

impl ArrayAim {
    /// The beam of two angles (tilt and receive angle, radians) that takes a way (one-way time in seconds, sound speed at the head in
    /// metres per second or 0), sent and heard at two poses (position, attitude). `None` where no direction has its two angles.
    ///
    /// The sound goes from the transmit array down and up to the receive array; half its time from half way between the two places is
    /// as good as a part in eight of their distance squared over the range.
    #[must_use]
    pub fn new(
        arrays: &ArrayMountings,
        angles_rad: (f64, f64),
        (one_way_s, head_speed_m_s): (f64, f64),
        [sent, heard]: [(Vector3<f64>, Matrix3<f64>); 2],
    ) -> Option<Self> {
        let pair = ArrayPair {
            attitude_at_transmission: sent.1,
            attitude_at_reception: heard.1,
            transmitter: arrays.transmitter.rotation,
            receiver: arrays.receiver.rotation,
        };
        let sender_m = sent.0 + sent.1 * arrays.transmitter.lever_arm_m;
        let listener_m = heard.0 + heard.1 * arrays.receiver.lever_arm_m;
        let apart_m = listener_m - sender_m;
        let range_m = one_way_s
            * if head_speed_m_s > 0.0 {
                head_speed_m_s
            } else {
                ORDINARY_M_S
            };
        Some(Self {
            direction: pair.from_between(angles_rad, &apart_m, range_m)?,
            transducer_m: (sender_m + listener_m) * 0.5,
            pair,
            apart_m,
            range_m,
            angles_rad,
        })
    }

    /// How far the point lies from half way between the arrays, in shares of half the way of the sound: the ellipsoid about both arrays.
    ///
    /// Two arrays a quarter of a metre apart are up to a millimetre off at eight metres without it.
    #[must_use]
    pub fn stretch(&self) -> f64 {
        let square = self.range_m * self.range_m;
        let along_m = 0.5 * self.apart_m.dot(&self.direction);
        let apart = 0.25 * self.apart_m.norm_squared();
        let squared = (square - apart) / (square - along_m * along_m);
        if squared > 0.0 { squared.sqrt() } else { 1.0 }
    }

    /// Columns: the direction's derivative by one left perturbation `Exp(delta)` of both mountings' rotations in the body (pitch, roll,
    /// yaw), per radian, the arrays' places held. `None` where the two axes and the beam lie in one plane.
    ///
    /// By the implicit function: with `r` from half way between, `s` and `h` the places of transmission and reception from there,
    /// `(r - s).f = |r - s| sin(tilt)` and `(r - h).g = |r - h| sin(angle)`, and `r` keeps its length.
    #[must_use]
    pub fn by_turn(&self) -> Option<Matrix3<f64>> {
        let (f, g) = self.pair.axes();
        let ray_m = self.direction * self.range_m;
        let (from_sender, from_listener) = (ray_m + self.apart_m * 0.5, ray_m - self.apart_m * 0.5);
        let (sin_tilt, sin_angle) = (math::sin(self.angles_rad.0), math::sin(self.angles_rad.1));
        let rows = Matrix3::from_rows(&[
            (f - from_sender.normalize() * sin_tilt).transpose(),
            (g - from_listener.normalize() * sin_angle).transpose(),
            self.direction.transpose(),
        ]);
        let by_sent = self
            .pair
            .attitude_at_transmission
            .tr_mul(&f.cross(&from_sender));
        let by_heard = self
            .pair
            .attitude_at_reception
            .tr_mul(&g.cross(&from_listener));
        let right = Matrix3::from_rows(&[
            -by_sent.transpose(),
            -by_heard.transpose(),
            Vector3::zeros().transpose(),
        ]);
        Some(rows.try_inverse()? * right / self.range_m)
    }
}

impl ArrayPair {
    /// The long axes in the local frame: transmit (forward) and receive (starboard).
    #[must_use]
    pub fn axes(&self) -> (Vector3<f64>, Vector3<f64>) {
        let transmit = self.transmitter.column(1);
        let receive = self.receiver.column(0);
        (
            self.attitude_at_transmission * transmit,
            self.attitude_at_reception * receive,
        )
    }

    /// The beam of a tilt (radians, positive forward) and a receive angle (radians, positive to starboard), in the local frame.
    ///
    /// `None` when no direction below the arrays has these two angles, or the axes are parallel.
    #[must_use]
    pub fn direction(&self, tilt_rad: f64, angle_rad: f64) -> Option<Vector3<f64>> {
        self.of_sines(math::sin(tilt_rad), math::sin(angle_rad))
    }

    /// The same where the two arrays stand apart: the direction seen from half way between them to the point that both see.
    ///
    /// The transmit array's cone begins at the transmit array, the receive array's at the receive array: an array a quarter of a metre
    /// before the other moves the point an eighth of a metre along, which a single origin takes for pitch. `apart_m` leads from the
    /// place of transmission to that of reception, `range_m` is half the way of the sound. `None` as [`Self::direction`].
    #[must_use]
    pub fn from_between(
        &self,
        (tilt_rad, angle_rad): (f64, f64),
        apart_m: &Vector3<f64>,
        range_m: f64,
    ) -> Option<Vector3<f64>> {
        let (f, s) = self.axes();
        let (sender_m, listener_m) = (apart_m * -0.5, apart_m * 0.5);
        let mut u = self.direction(tilt_rad, angle_rad)?;
        for _ in 0..3 {
            let ray_m = u * range_m;
            let seen = |from_m: &Vector3<f64>, sine: f64, axis: &Vector3<f64>| {
                ((ray_m - from_m).norm() * sine + from_m.dot(axis)) / range_m
            };
            let tilt = seen(&sender_m, math::sin(tilt_rad), &f);
            let angle = seen(&listener_m, math::sin(angle_rad), &s);
            u = self.of_sines(tilt, angle)?;
        }
        Some(u)
    }

    /// The direction whose parts along the two axes are these.
    fn of_sines(&self, sin_tilt: f64, sin_angle: f64) -> Option<Vector3<f64>> {
        let (f, s) = self.axes();
        let q = f.dot(&s);
        let up = self.above(s.cross(&f));
        let square = up.norm_squared();
        let along = (sin_tilt - q * sin_angle) / square;
        let across = (sin_angle - q * sin_tilt) / square;
        let root = 1.0 - along * along - across * across - 2.0 * along * across * q;
        if !(root > 0.0 && square > 1e-6) {
            return None;
        }
        Some(f * along + s * across - up * (root / square).sqrt())
    }

    /// The normal of both axes on the side that the receive array has its back to.
    fn above(&self, normal: Vector3<f64>) -> Vector3<f64> {
        let back = self.attitude_at_reception * self.receiver.column(2);
        normal * back.dot(&normal).signum()
    }

    /// [`Self::direction`] with its derivatives, by the implicit function: `f.du`, `s.du` and `u.du` are known.
    #[must_use]
    pub fn partials(&self, tilt_rad: f64, angle_rad: f64) -> Option<ConePartials> {
        let u = self.direction(tilt_rad, angle_rad)?;
        self.partials_at(u, tilt_rad, angle_rad)
    }

    /// The derivatives at a direction of these two angles, or near one: for [`Self::from_between`] as good as the arrays' distance over
    /// the range.
    #[must_use]
    pub fn partials_at(
        &self,
        u: Vector3<f64>,
        tilt_rad: f64,
        angle_rad: f64,
    ) -> Option<ConePartials> {
        let (f, s) = self.axes();
        let rows = Matrix3::from_rows(&[f.transpose(), s.transpose(), u.transpose()]);
        let solved = rows.try_inverse()?;
        let (by_f, by_s) = (solved.column(0), solved.column(1));
        let transmission = by_f * f.cross(&u).transpose() * -1.0;
        let reception = by_s * s.cross(&u).transpose() * -1.0;
        Some(ConePartials {
            direction: u,
            angles: [by_f * math::cos(tilt_rad), by_s * math::cos(angle_rad)],
            correction: transmission * self.attitude_at_transmission
                + reception * self.attitude_at_reception,
            attitude_at_transmission: transmission,
            attitude_at_reception: reception,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation::{exp, from_attitude};
    use crate::georef::beam::Beam;
    use crate::observe::Mounting;

    fn pair() -> ArrayPair {
        ArrayPair {
            attitude_at_transmission: from_attitude(0.06, -0.03, 1.1),
            attitude_at_reception: from_attitude(0.05, -0.02, 1.105),
            transmitter: from_attitude(0.02, 0.01, -0.007),
            receiver: from_attitude(-0.03, 0.015, 0.004),
        }
    }

    fn slope(f: impl Fn(f64) -> Vector3<f64>) -> Vector3<f64> {
        (f(1e-6) - f(-1e-6)) / 2e-6
    }

    #[test]
    fn the_direction_lies_on_both_cones_and_points_down() {
        let pair = pair();
        let (f, s) = pair.axes();
        for (tilt, angle) in [(0.0, 0.0), (0.1, -1.1), (-0.3, 0.9)] {
            let u = pair.direction(tilt, angle).expect("a beam");
            assert!((u.norm() - 1.0).abs() < 1e-14);
            assert!((u.dot(&f) - math::sin(tilt)).abs() < 1e-14);
            assert!((u.dot(&s) - math::sin(angle)).abs() < 1e-14);
            assert!(u.z < 0.0);
        }
    }

    #[test]
    fn one_head_at_one_moment_is_the_plain_beam() {
        let attitude = from_attitude(0.06, -0.03, 1.1);
        let mounting = from_attitude(0.3, 0.01, -0.2);
        let pair = ArrayPair {
            attitude_at_transmission: attitude,
            attitude_at_reception: attitude,
            transmitter: mounting,
            receiver: mounting,
        };
        let (tilt, angle) = (0.2, -0.8);
        let u = mounting.tr_mul(&attitude.tr_mul(&pair.direction(tilt, angle).expect("a beam")));
        let beam = Beam::from_vector(&u);
        assert!((beam.along_rad - tilt).abs() < 1e-14);
        assert!((u.x - math::sin(angle)).abs() < 1e-14);
    }

    /// A point, its angles from two places apart and the way of the sound: the direction from half way between leads back to it.
    #[test]
    fn arrays_apart_see_one_point() {
        let pair = pair();
        let (f, s) = pair.axes();
        let point = Vector3::new(6.0, -1.0, -9.0);
        let apart = Vector3::new(0.3, -0.5, 0.1);
        let (to_sender, to_listener) = (point + apart * 0.5, point - apart * 0.5);
        let tilt = math::asin(to_sender.dot(&f) / to_sender.norm());
        let angle = math::asin(to_listener.dot(&s) / to_listener.norm());
        let range = 0.5 * (to_sender.norm() + to_listener.norm());
        let u = pair
            .from_between((tilt, angle), &apart, range)
            .expect("a beam");
        let together = pair.direction(tilt, angle).expect("a beam");
        assert!((u * range - point).norm() < 0.006, "{}", u * range);
        assert!((together * range - point).norm() > 0.2);
    }

    /// Built in the other way round, an array has its angles the other way round, and the beam still goes down.
    #[test]
    fn an_array_turned_round_gives_the_same_beam_by_the_opposite_angle() {
        let pair = pair();
        let round = from_attitude(0.0, 0.0, std::f64::consts::PI);
        let (tilt, angle) = (0.12, -0.9);
        let u = pair.direction(tilt, angle).expect("a beam");
        let (transmitter, receiver) = (pair.transmitter * round, pair.receiver * round);
        let sender = ArrayPair {
            transmitter,
            ..pair
        };
        let listener = ArrayPair { receiver, ..pair };
        let of = |p: ArrayPair, t: f64, a: f64| p.direction(t, a).expect("a beam");
        assert!((of(sender, -tilt, angle) - u).norm() < 1e-14);
        assert!((of(listener, tilt, -angle) - u).norm() < 1e-14);
    }

    #[test]
    fn two_angles_that_no_direction_has_are_refused() {
        assert_eq!(pair().direction(1.0, 1.0), None);
        assert_eq!(pair().direction(f64::NAN, 0.0), None);
        let parallel = ArrayPair {
            receiver: from_attitude(0.0, 0.0, -std::f64::consts::FRAC_PI_2),
            transmitter: Matrix3::identity(),
            attitude_at_transmission: Matrix3::identity(),
            attitude_at_reception: Matrix3::identity(),
        };
        assert_eq!(parallel.direction(0.0, 0.0), None);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (pair, tilt, angle) = (pair(), 0.12, -0.9);
        let partials = pair.partials(tilt, angle).expect("a beam");
        let at = |p: ArrayPair, t: f64, a: f64| p.direction(t, a).expect("a beam");
        let by_tilt = slope(|d| at(pair, tilt + d, angle));
        let by_angle = slope(|d| at(pair, tilt, angle + d));
        assert!((by_tilt - partials.angles[0]).norm() < 1e-8);
        assert!((by_angle - partials.angles[1]).norm() < 1e-8);
        for axis in 0..3 {
            let turn = |d: f64| exp(&Vector3::ith(axis, d));
            let common = slope(|d| {
                let (transmitter, receiver) = (turn(d) * pair.transmitter, turn(d) * pair.receiver);
                at(
                    ArrayPair {
                        transmitter,
                        receiver,
                        ..pair
                    },
                    tilt,
                    angle,
                )
            });
            assert!((common - partials.correction.column(axis)).norm() < 1e-8);
            let sent = slope(|d| {
                let attitude_at_transmission = turn(d) * pair.attitude_at_transmission;
                at(
                    ArrayPair {
                        attitude_at_transmission,
                        ..pair
                    },
                    tilt,
                    angle,
                )
            });
            assert!((sent - partials.attitude_at_transmission.column(axis)).norm() < 1e-8);
            let heard = slope(|d| {
                let attitude_at_reception = turn(d) * pair.attitude_at_reception;
                at(
                    ArrayPair {
                        attitude_at_reception,
                        ..pair
                    },
                    tilt,
                    angle,
                )
            });
            assert!((heard - partials.attitude_at_reception.column(axis)).norm() < 1e-8);
        }
    }

    /// With both arrays 0.6 m apart at 14 m, where a turn of the whole beam is off by 2 %.
    #[test]
    fn the_turn_of_two_arrays_apart_agrees_with_differences() {
        let mounted = |angles: [f64; 3], arm: [f64; 3]| {
            Mounting::from_angles(angles[0], angles[1], angles[2], arm.into())
        };
        let arrays = ArrayMountings {
            transmitter: mounted([0.02, 0.01, -0.007], [0.2, 1.5, -1.0]),
            receiver: mounted([-0.03, 0.015, 0.004], [0.5, 1.0, -0.9]),
        };
        let sent = (Vector3::new(3.0, 1.0, 0.2), from_attitude(0.06, -0.03, 1.1));
        let heard = (
            Vector3::new(3.01, 1.02, 0.2),
            from_attitude(0.05, -0.02, 1.105),
        );
        let (angles, way) = ((0.12, -0.9), (0.0095, 1480.0));
        let at = |turn: Matrix3<f64>| {
            let turned = ArrayMountings {
                transmitter: arrays.transmitter.turned(&turn),
                receiver: arrays.receiver.turned(&turn),
            };
            ArrayAim::new(&turned, angles, way, [sent, heard]).expect("a beam")
        };
        let found = at(Matrix3::identity()).by_turn().expect("a turn");
        for axis in 0..3 {
            let due = slope(|d| at(exp(&Vector3::ith(axis, d))).direction);
            // three rounds of `from_between` leave a part in a million
            assert!((due - found.column(axis)).norm() < 1e-5, "{axis}: {due}");
        }
    }

    /// The ways from one array to the point and on to the other add up to the way of the sound.
    #[test]
    fn the_point_lies_on_the_ellipsoid_about_both_arrays() {
        let mounted = |arm: [f64; 3]| Mounting::from_angles(0.0, 0.0, 0.0, arm.into());
        let arrays = ArrayMountings {
            transmitter: mounted([0.0, 0.5, 0.0]),
            receiver: mounted([0.2, -0.1, 0.1]),
        };
        let pose = (Vector3::zeros(), Matrix3::identity());
        let (angles, range_m) = ((0.1, 0.7), 6.0);
        let way = (range_m / 1480.0, 1480.0);
        let aim = ArrayAim::new(&arrays, angles, way, [pose, pose]).expect("a beam");
        let at = |stretch: f64| aim.transducer_m + aim.direction * (range_m * stretch);
        let way_m = |point: Vector3<f64>| {
            let to = |array: &Mounting| (point - array.lever_arm_m).norm();
            to(&arrays.transmitter) + to(&arrays.receiver)
        };
        assert!((way_m(at(aim.stretch())) - 12.0).abs() < 1e-12);
        assert!((way_m(at(1.0)) - 12.0).abs() > 0.01);
    }

    #[test]
    fn an_array_may_turn_about_its_own_axis_unseen() {
        let pair = pair();
        let (tilt, angle) = (0.12, -0.9);
        let u = pair.direction(tilt, angle).expect("a beam");
        let own_roll = exp(&(pair.transmitter.column(1) * 0.1));
        let own_pitch = exp(&(pair.receiver.column(0) * 0.1));
        let turned = ArrayPair {
            transmitter: own_roll * pair.transmitter,
            receiver: own_pitch * pair.receiver,
            ..pair
        };
        assert!((turned.direction(tilt, angle).expect("a beam") - u).norm() < 1e-14);
    }
}
