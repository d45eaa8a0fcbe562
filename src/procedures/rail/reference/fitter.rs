//! One profiler's fits: coarse, fine, the sweeps, and the compensation.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::{ReferenceError, SweepStep};
use crate::geometry::curve::Element;
use crate::geometry::{fit2d, hausdorff, rotation};
use crate::math;
use crate::observe::Mounting;
use crate::procedures::rail::config::RailReferenceConfig;
use crate::procedures::rail::icp::{self, Cloud, Rigid};
use crate::procedures::rail::scene::{Position, RailScene};
use crate::units::wrap_angle;

/// Fine transforms in a row at each position.
const FINE_STEPS: usize = 4;
/// Nearer than this a point is never left out, metres: rounding.
const ROUNDING_M: f64 = 1e-9;
/// Points further than so many RMS from the fitted figure are left out once.
const TRIM: f64 = 3.0;
/// Fewest points of a region.
const LEAST: usize = 5;
/// Fewest positions of a sweep.
pub(super) const LEAST_STEPS: usize = 3;
/// Steps of the coarse fit when it only follows the table.
const FOLLOWING_STEPS: u32 = 20;
/// Turns of the nominal mounting that the coarse fit starts from beside the nominal one, degrees.
const START_TURNS_DEG: [f64; 6] = [-15.0, 15.0, -30.0, 30.0, -45.0, 45.0];
/// Shifts that it starts from, each by itself and with the smallest turns, metres.
const START_SHIFT_M: f64 = 0.015;
/// Another start is taken when it brings one point in so many more onto the rail.
const CLEARLY: usize = 10;
/// Positions beside the one fitted that help to choose among the starts.
const OTHER_POSITIONS: usize = 4;
/// Points that the starts are tried with at the most.
const POOLED_POINTS: usize = 300;

/// A profiler's profile with the regions of the side that it sees.
pub(super) struct Fitter<'a> {
    pub(super) scene: &'a RailScene<'a>,
    pub(super) config: &'a RailReferenceConfig,
    pub(super) cloud: &'a Cloud,
    pub(super) profiler: usize,
}

/// Points of both regions after a transform.
pub(super) struct Regions {
    line: (usize, Vec<Vector2<f64>>),
    arc: (usize, Vec<Vector2<f64>>),
}

/// Turns (degrees) and shifts (metres) that the coarse fit starts from beside the nominal mounting.
fn starts() -> impl Iterator<Item = (f64, Vector2<f64>)> {
    let turned = START_TURNS_DEG.map(|turn_deg| (turn_deg, Vector2::zeros()));
    let (x, z) = (Vector2::x() * START_SHIFT_M, Vector2::y() * START_SHIFT_M);
    let shifts = [x, -x, z, -z];
    let shifted = [0.0, -15.0, 15.0].map(|turn_deg| shifts.map(|shift_m| (turn_deg, shift_m)));
    turned.into_iter().chain(shifted.into_iter().flatten())
}

/// One of a position's angles, radians.
type AngleOf = fn(&Position) -> f64;

/// Which angle of the table is swept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    Heading,
    Pitch,
}

impl Axis {
    fn name(self) -> &'static str {
        match self {
            Self::Heading => "the vertical",
            Self::Pitch => "the lateral axis",
        }
    }
}

impl Fitter<'_> {
    fn name(&self) -> String {
        self.scene.campaign.profilers[self.profiler].name.clone()
    }

    fn profile(&self, position: usize) -> Vec<Vector2<f64>> {
        let points = self.scene.profile(position, self.profiler);
        points.iter().map(|p| Vector2::new(p.x, p.z)).collect()
    }

    /// Where the nominal mounting puts a profile: turn about the rail's axis and place of the profiler.
    pub(super) fn nominal_transform(&self, position: usize) -> Rigid {
        let (scene, stand) = (self.scene, &self.scene.campaign.stand);
        let nominal = &scene.campaign.profilers[self.profiler].nominal;
        let [roll, pitch, heading] = stand.rail_attitude_rad;
        let body =
            rotation::from_attitude(roll, pitch, heading).transpose() * scene.attitude(position);
        let place = body * (nominal.lever_arm_m - stand.pivot_body_m);
        let r = body * nominal.rotation;
        Rigid {
            roll_rad: math::atan2(-r[(2, 0)], r[(0, 0)]),
            shift_m: Vector2::new(place.x, place.z) + stand.pivot_rail_m,
        }
    }

    /// `T_coarse`.
    pub(super) fn coarse(&self, position: usize) -> Result<Rigid, ReferenceError> {
        let profile = self.profile(position);
        if profile.is_empty() {
            return Err(ReferenceError::NoProfile {
                profiler: self.name(),
            });
        }
        let start = self.best_start(position);
        Ok(icp::fit(self.cloud, &profile, start, self.config.max_steps))
    }

    /// Where the coarse fit of a profile begins: of the nominal mounting turned by several angles about the middle of what it sees, the
    /// one that brings most points of this and a few other positions onto the rail. Half of a rail looks like the other half, and a part
    /// of it like other parts, so that one start may end anywhere.
    fn best_start(&self, position: usize) -> Rigid {
        let others = self
            .scene
            .by_level()
            .into_iter()
            .filter(|k| *k != position)
            .take(OTHER_POSITIONS);
        let pooled: Vec<Vector2<f64>> = std::iter::once(position)
            .chain(others)
            .flat_map(|k| {
                let nominal = self.nominal_transform(k);
                self.profile(k).into_iter().map(move |p| nominal.apply(&p))
            })
            .collect();
        let stride = pooled.len().div_ceil(POOLED_POINTS).max(1);
        let pooled: Vec<_> = pooled.into_iter().step_by(stride).collect();
        let middle = pooled.iter().sum::<Vector2<f64>>() / pooled.len().max(1) as f64;
        let still = Rigid {
            roll_rad: 0.0,
            shift_m: Vector2::zeros(),
        };
        let tried = |(turn_deg, shift_m): (f64, Vector2<f64>)| {
            let start = still.then(f64::to_radians(turn_deg), &middle, &(middle + shift_m));
            let found = icp::fit(self.cloud, &pooled, start, self.config.max_steps);
            (self.on_the_rail(&pooled, &found), found)
        };
        let nominal = tried((0.0, Vector2::zeros()));
        let best = starts().map(tried).fold(nominal, |best, one| {
            let clearly = one.0 > best.0 + best.0 / CLEARLY;
            if clearly { one } else { best }
        });
        let nominal = self.nominal_transform(position);
        Rigid {
            roll_rad: nominal.roll_rad + best.1.roll_rad,
            shift_m: best.1.apply(&nominal.shift_m),
        }
    }

    /// How many points a transform brings onto the rail.
    fn on_the_rail(&self, points: &[Vector2<f64>], transform: &Rigid) -> usize {
        let near = points.iter().filter(|p| {
            let found = self.scene.rail.nearest(&transform.apply(p));
            found.is_some_and(|n| n.inside && n.distance_m <= self.config.region_m)
        });
        near.count()
    }

    /// The position nearest to level at which both regions are seen, with its coarse and fine transforms.
    pub(super) fn level(&self) -> Result<(usize, Rigid, Rigid), ReferenceError> {
        let mut first = None;
        for position in self.scene.by_level() {
            let found = self
                .coarse(position)
                .and_then(|coarse| Ok((coarse, self.fine(position, coarse)?.0)));
            match found {
                Ok((coarse, fine)) => return Ok((position, coarse, fine)),
                Err(error) => first = first.or(Some(error)),
            }
        }
        Err(first.unwrap_or(ReferenceError::NoProfile {
            profiler: self.name(),
        }))
    }

    /// Points near the regions; of the two sides the one with more points.
    fn regions(&self, profile: &[Vector2<f64>], transform: &Rigid) -> Regions {
        let rail = self.scene.rail;
        let mut near = vec![vec![]; rail.elements.len()];
        for p in profile {
            let q = transform.apply(p);
            if let Some(n) = rail.nearest(&q)
                && n.inside
                && n.distance_m <= self.config.region_m
            {
                near[n.element].push(q);
            }
        }
        let mut side = |elements: &[usize]| {
            let most = elements
                .iter()
                .copied()
                .max_by_key(|&e| near[e].len())
                .unwrap_or(0);
            (most, std::mem::take(&mut near[most]))
        };
        Regions {
            line: side(&rail.line_region),
            arc: side(&rail.arc_region),
        }
    }

    fn fault(&self, element: usize, what: &impl ToString) -> ReferenceError {
        ReferenceError::Region {
            profiler: self.name(),
            region: self.scene.rail.names[element].clone(),
            what: what.to_string(),
        }
    }

    /// `T_fine`: the line's angle and the arc's centre brought to the standard's, repeated.
    pub(super) fn fine(
        &self,
        position: usize,
        start: Rigid,
    ) -> Result<(Rigid, Regions), ReferenceError> {
        let profile = self.profile(position);
        let mut transform = start;
        for _ in 0..FINE_STEPS {
            let mut regions = self.regions(&profile, &transform);
            let (line, line_points) = &mut regions.line;
            let (arc, arc_points) = &mut regions.arc;
            for (element, points) in [(*line, &*line_points), (*arc, &*arc_points)] {
                if points.len() < LEAST {
                    let what = format!("{} points, expected at least {LEAST}", points.len());
                    return Err(self.fault(element, &what));
                }
            }
            let turn = line_turn(&self.scene.rail.elements[*line], line_points)
                .map_err(|e| self.fault(*line, &e))?;
            let centre = arc_centre(arc_points).map_err(|e| self.fault(*arc, &e))?;
            let Element::Arc {
                centre: standard, ..
            } = self.scene.rail.elements[*arc]
            else {
                return Err(self.fault(*arc, &"no arc"));
            };
            transform = transform.then(turn, &centre, &standard);
        }
        let regions = self.regions(&profile, &transform);
        Ok((transform, regions))
    }

    /// The Hausdorff distance over the positions that turn about one axis alone, followed outwards from level.
    pub(super) fn sweep(
        &self,
        level: usize,
        start: Rigid,
        axis: Axis,
    ) -> Result<Vec<SweepStep>, ReferenceError> {
        let positions = &self.scene.positions;
        let tolerance = self.config.axis_tolerance_deg.to_radians();
        let (swept, other): (AngleOf, AngleOf) = match axis {
            Axis::Heading => (|p| p.heading_rad, |p| p.pitch_rad),
            Axis::Pitch => (|p| p.pitch_rad, |p| p.heading_rad),
        };
        let mut places: Vec<usize> = (0..positions.len())
            .filter(|&k| other(&positions[k]).abs() <= tolerance && !self.profile(k).is_empty())
            .collect();
        places.sort_by(|a, b| swept(&positions[*a]).total_cmp(&swept(&positions[*b])));
        let range = places.last().map_or(0.0, |b| {
            swept(&positions[*b]) - swept(&positions[places[0]])
        });
        if places.len() < LEAST_STEPS || range <= tolerance {
            let (profiler, found) = (self.name(), places.len());
            return Err(ReferenceError::NoSweep {
                profiler,
                axis: axis.name(),
                found,
            });
        }
        let middle = places.partition_point(|&k| swept(&positions[k]) < swept(&positions[level]));
        let (below, above) = places.split_at(middle);
        let mut steps = self.followed(below.iter().rev(), start, axis);
        steps.reverse();
        steps.extend(self.followed(above.iter(), start, axis));
        let found = steps.len();
        if found < LEAST_STEPS {
            let profiler = self.name();
            return Err(ReferenceError::NoSweep {
                profiler,
                axis: axis.name(),
                found,
            });
        }
        Ok(steps)
    }

    /// Steps of one side; positions at which something hides a region are left out.
    fn followed<'k>(
        &self,
        places: impl Iterator<Item = &'k usize>,
        start: Rigid,
        axis: Axis,
    ) -> Vec<SweepStep> {
        let (mut transform, mut steps) = (start, vec![]);
        for &position in places {
            let near = icp::fit(
                self.cloud,
                &self.profile(position),
                transform,
                FOLLOWING_STEPS,
            );
            let Ok((fine, regions)) = self.fine(position, near) else {
                continue;
            };
            transform = fine;
            steps.push(SweepStep {
                turn_rad: self.turn(position, axis),
                distance_m: self.distance(&regions, axis),
            });
        }
        steps
    }

    /// Heading or pitch of the INS against the rail.
    pub(super) fn turn(&self, position: usize, axis: Axis) -> f64 {
        let rail = self.scene.campaign.stand.rail_attitude_rad;
        let (_, pitch, heading) = rotation::to_attitude(&self.scene.attitude(position));
        match axis {
            Axis::Heading => wrap_angle(heading - rail[2]),
            Axis::Pitch => pitch - rail[1],
        }
    }

    /// Between the measured points of a region and the standard element's points; gross errors are trimmed by the figure's fit.
    fn distance(&self, regions: &Regions, axis: Axis) -> f64 {
        let (element, points) = if axis == Axis::Heading {
            &regions.line
        } else {
            &regions.arc
        };
        let piece = &self.scene.rail.elements[*element];
        let off = |p: &Vector2<f64>| piece.extended(p).distance_m;
        let rms = (points.iter().map(|p| off(p).powi(2)).sum::<f64>() / points.len() as f64).sqrt();
        let kept: Vec<_> = points
            .iter()
            .copied()
            .filter(|p| off(p).abs() <= TRIM * rms + ROUNDING_M)
            .collect();
        hausdorff::distance_m(&kept, &piece.samples(self.config.spacing_m))
    }

    /// The mounting with this rotation that puts the profile's mean point where a transform puts it; along the rail the profiler stays
    /// at its nominal place. A profiler stands tens of centimetres away, so that a tilt of its plane moves the whole profile.
    pub(super) fn placed(
        &self,
        position: usize,
        transform: &Rigid,
        rotation: Matrix3<f64>,
    ) -> Mounting {
        let stand = &self.scene.campaign.stand;
        let nominal = self.scene.campaign.profilers[self.profiler]
            .nominal
            .lever_arm_m;
        let [roll, pitch, heading] = stand.rail_attitude_rad;
        let body = rotation::from_attitude(roll, pitch, heading).transpose()
            * self.scene.attitude(position);
        let profile = self.profile(position);
        let mean = profile.iter().sum::<Vector2<f64>>() / profile.len().max(1) as f64;
        let turned = body * rotation * Vector3::new(mean.x, 0.0, mean.y);
        let along = (body * (nominal - stand.pivot_body_m)).y;
        let section = transform.apply(&mean) - stand.pivot_rail_m;
        let arm = Vector3::new(section.x - turned.x, along, section.y - turned.z);
        Mounting {
            rotation,
            lever_arm_m: body.transpose() * arm + stand.pivot_body_m,
        }
    }

    /// RMS distance of the level profile from the standard profile: as measured under the fine fit, and with lateral and vertical
    /// coordinates multiplied by the cosines of the heading and pitch errors (claim 10) and fitted again.
    pub(super) fn compensated(&self, level: usize, fine: Rigid, mounting: &Mounting) -> (f64, f64) {
        let profile = self.profile(level);
        let (_, pitch, heading) = mounting.angles();
        let (theta, psi) = (
            pitch + self.turn(level, Axis::Pitch),
            heading + self.turn(level, Axis::Heading),
        );
        let compensate = |p: &Vector2<f64>| {
            let q = icp::rolled(fine.roll_rad, p);
            icp::rolled(
                -fine.roll_rad,
                &Vector2::new(q.x * math::cos(psi), q.y * math::cos(theta)),
            )
        };
        let changed: Vec<_> = profile.iter().map(compensate).collect();
        let again = icp::fit(self.cloud, &changed, fine, FOLLOWING_STEPS);
        (self.rms(&profile, &fine), self.rms(&changed, &again))
    }

    fn rms(&self, profile: &[Vector2<f64>], transform: &Rigid) -> f64 {
        let near = profile
            .iter()
            .filter_map(|p| self.scene.rail.nearest(&transform.apply(p)));
        let squares: Vec<f64> = near
            .filter(|n| n.distance_m <= self.config.region_m)
            .map(|n| n.distance_m.powi(2))
            .collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }
}

/// Turn (as roll) that brings the fitted line to the standard one; points off the fit are left out once.
fn line_turn(standard: &Element, points: &mut Vec<Vector2<f64>>) -> Result<f64, fit2d::FitError> {
    let first = fit2d::line(points)?;
    let normal = Vector2::new(-first.direction.y, first.direction.x);
    points.retain(|p| normal.dot(&(p - first.centroid_m)).abs() <= TRIM * first.rms_m + ROUNDING_M);
    let found = fit2d::line(points)?.direction;
    let wanted = standard.tangent(0.5);
    let sense = found.dot(&wanted).signum();
    let sine = sense * (wanted.x * found.y - wanted.y * found.x);
    Ok(math::atan2(sine, (sense * found.dot(&wanted)).abs()))
}

/// Centre of the fitted circle; points off the fit are left out once.
fn arc_centre(points: &mut Vec<Vector2<f64>>) -> Result<Vector2<f64>, fit2d::FitError> {
    let first = fit2d::circle(points)?;
    points.retain(|p| {
        ((p - first.centre_m).norm() - first.radius_m).abs() <= TRIM * first.rms_m + ROUNDING_M
    });
    Ok(fit2d::circle(points)?.centre_m)
}
