//! Every source of a scenario through the pulls of one path: values, sigmas and factors from the scenario.

use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3, Vector6};

use super::analytic::{PathBudget, Prediction};
use super::influence::{Seen, View, independent};
use super::records::Records;
use crate::adjust::{Kernel, ParameterSet};
use crate::observe::{Campaign, Mounting};
use crate::procedures::pool::Scene;
use crate::procedures::pool::influence::Pulls;
use crate::procedures::pool::joint::JointOutcome;
use crate::simulate::scenario::Turn;
use crate::simulate::{Scenario, Source};
use crate::stats::normal_means;

/// What a kernel makes of normal noise: the part of the weight that counts, `beta = E psi'`, and by how much the noise exceeds
/// what that weight makes of it, `E psi^2 / (s beta)^2` (Huber & Ronchetti 2009, eq. 3.13).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tail {
    /// Part of a condition's weight that counts.
    pub part: f64,
    /// Excess of the noise.
    pub inflation: f64,
}

impl Tail {
    /// For residuals that are `s` sigmas wide, by the midpoint rule over six of their own standard deviations.
    fn of(kernel: Kernel, s: f64) -> Self {
        if s < 1e-6 || kernel.is_least_squares() {
            return Self {
                part: 1.0,
                inflation: 1.0,
            };
        }
        let figures = |z| [kernel.slope(s * z), kernel.influence(s * z).powi(2)];
        let [part, square] = normal_means(6.0, 24_000, figures);
        Self {
            part,
            inflation: square / (s * part).powi(2),
        }
    }
}

/// What a scenario's sources do to one scene.
pub(super) struct Budget<'a> {
    pub scenario: &'a Scenario,
    /// Free of errors.
    pub scene: &'a Scene<'a>,
    /// True mounting of the multibeam.
    pub truth: Mounting,
    /// By face.
    pub normals: Vec<Option<Vector3<f64>>>,
}

impl Budget<'_> {
    fn factor(&self, source: Source) -> f64 {
        self.scenario.sources.factor(source)
    }

    fn view<'v>(&'v self, pulls: &'v Pulls) -> View<'v> {
        View::new(self.scene, self.truth, &self.normals, pulls)
    }

    /// Per group of observations: what the kernel makes of them, from the mean ratio of true to claimed variance.
    pub(super) fn tail(&self, pulls: &Pulls, kernel: Kernel) -> [Tail; 2] {
        let (view, noise) = (self.view(pulls), self.noise());
        let claims = &self.scene.campaign;
        let sonar = claims.soundings.noise;
        let claimed_sounding = |s: &Seen| {
            let sigmas = Vector3::new(sonar.range_m, sonar.across_rad, sonar.along_rad);
            s.gain.component_mul(&sigmas).norm_squared()
        };
        let claimed_return = |s: &Seen| {
            let sigmas = Vector3::new(
                claims.laser.noise.range_m,
                claims.laser.noise.angle_rad,
                0.0,
            );
            s.gain.component_mul(&sigmas).norm_squared()
        };
        let width = |seen: &[Seen], truth: &[NoiseOf], claimed: &dyn Fn(&Seen) -> f64| {
            let one = |s: &Seen| truth.iter().map(|n| n.sigma(s).powi(2)).sum::<f64>() / claimed(s);
            (seen.iter().map(one).sum::<f64>() / seen.len().max(1) as f64).sqrt()
        };
        let (soundings, returns) = noise.split_at(SOUNDING_SOURCES);
        [
            Tail::of(kernel, width(&view.soundings, soundings, &claimed_sounding)),
            Tail::of(kernel, width(&view.returns, returns, &claimed_return)),
        ]
    }

    /// Noise that is independent from observation to observation, as it really acts: of the soundings, then of the returns.
    fn noise(&self) -> [NoiseOf; 7] {
        let (m, lidar) = (&self.scenario.multibeam, &self.scenario.lidar);
        let of = |source, sigma: f64| NoiseOf {
            source,
            sigma: sigma * self.factor(source),
            growth: 0.0,
            edge_rad: 1.0,
        };
        let rough = of(
            Source::TargetFlatness,
            self.scenario.target.roughness_sigma_m,
        );
        [
            of(Source::SonarRange, m.range_sigma_m),
            NoiseOf {
                growth: m.outer_beam_factor - 1.0,
                edge_rad: m.from_deg.abs().max(m.to_deg.abs()).to_radians(),
                ..of(Source::SonarAngle, m.angle_sigma_deg.to_radians())
            },
            of(
                Source::SonarAlongAngle,
                m.along_angle_sigma_deg.to_radians(),
            ),
            rough,
            of(Source::LaserRange, lidar.range_sigma_m),
            of(Source::LaserAngle, lidar.angle_sigma_deg.to_radians()),
            rough,
        ]
    }

    /// Budget of a path; `inflation` of the independent noise of soundings and returns.
    pub(super) fn path(
        &self,
        pulls: &Pulls,
        inflation: [f64; 2],
        method_bias: Vector6<f64>,
    ) -> PathBudget {
        let view = self.view(pulls);
        let records = view.by_record();
        let predict = |source: Source| (source, self.predict(source, &view, &records, inflation));
        let sources: Vec<_> = Source::ALL.into_iter().map(predict).collect();
        let mut total = (method_bias, Matrix6::zeros());
        for (_, prediction) in &sources {
            if let Prediction::Linear { bias, covariance } = prediction {
                total.0 += bias;
                total.1 += covariance;
            }
        }
        PathBudget {
            sources,
            method_bias,
            bias: total.0,
            covariance: total.1,
        }
    }

    fn predict(
        &self,
        source: Source,
        view: &View,
        records: &Records,
        inflation: [f64; 2],
    ) -> Prediction {
        let (ins, factor) = (&self.scenario.trajectory, self.factor(source));
        let tau_s = ins.drift_correlation_time_s;
        let white = |sigma: f64, unit: Matrix6<f64>| noise(unit * (sigma * factor).powi(2));
        match source {
            Source::PositionWhite => white(ins.position_sigma_m, records.white_position()),
            Source::PositionDrift => {
                white(ins.position_drift_sigma_m, records.position_drift(tau_s))
            }
            Source::RollPitch => {
                white(ins.roll_pitch_sigma_deg.to_radians(), records.white_level())
            }
            Source::Heading => white(ins.heading_sigma_deg.to_radians(), records.white_heading()),
            Source::HeadingDrift => {
                let sigma = ins.heading_drift_sigma_deg.to_radians();
                white(sigma, records.heading_drift(tau_s))
            }
            Source::LatencyJitter => {
                noise(view.jitter(self.scenario.truth.latency_jitter_s * factor))
            }
            Source::LaserRange
            | Source::LaserAngle
            | Source::SonarRange
            | Source::SonarAngle
            | Source::SonarAlongAngle
            | Source::TargetFlatness => noise(self.independent(source, view, inflation)),
            Source::TargetPose => noise(Matrix6::zeros()),
            Source::GrossErrors | Source::Clutter | Source::Multipath | Source::Bodies => {
                self.disturbance(source)
            }
            _ => self.constant(source, view),
        }
    }

    fn independent(&self, source: Source, view: &View, inflation: [f64; 2]) -> Matrix6<f64> {
        let all = self.noise();
        let (soundings, returns) = all.split_at(SOUNDING_SOURCES);
        let sum = |seen: &[Seen], noise: &[NoiseOf], inflation: f64| {
            let of_source = noise.iter().filter(|n| n.source == source && n.sigma > 0.0);
            let one = |n: &NoiseOf| independent(seen, |s| n.sigma(s)) * inflation;
            of_source.map(one).sum::<Matrix6<f64>>()
        };
        sum(&view.soundings, soundings, inflation[0]) + sum(&view.returns, returns, inflation[1])
    }

    /// Errors that are one number for the whole survey: a given value, and a random part.
    fn constant(&self, source: Source, view: &View) -> Prediction {
        let (factor, truth) = (self.factor(source), &self.scenario.truth);
        let one = |direction: Vector6<f64>, value: f64, sigma: f64| Prediction::Linear {
            bias: direction * (value * factor),
            covariance: direction * direction.transpose() * (sigma * factor).powi(2),
        };
        let three = |directions: Matrix6x3<f64>, value: Vector3<f64>, sigma: Vector3<f64>| {
            let scaled = directions * Matrix3::from_diagonal(&(sigma * factor));
            Prediction::Linear {
                bias: directions * (value * factor),
                covariance: scaled * scaled.transpose(),
            }
        };
        let lidar = &self.scenario.lidar;
        match source {
            Source::Latency => {
                let sigma = view.latency_sigma(truth.latency_sigma_s * factor);
                Prediction::Linear {
                    bias: view.latency(truth.latency_s * factor),
                    covariance: sigma * sigma.transpose(),
                }
            }
            Source::SoundSpeed => one(
                view.range_scale(),
                truth.range_scale,
                truth.range_scale_sigma,
            ),
            Source::SoundSpeedGradient => {
                let water = self.scenario.sound_speed.as_ref();
                let (value, sigma) =
                    water.map_or((0.0, 0.0), |w| (w.gradient_error_1_s, w.gradient_sigma_1_s));
                if value == 0.0 && sigma == 0.0 {
                    return noise(Matrix6::zeros());
                }
                one(view.gradient(), value, sigma)
            }
            Source::LaserBoresight => three(
                view.scanner_turn(),
                turn_rad(&lidar.mounting_error_deg),
                Vector3::from(lidar.mounting_sigma_deg).map(f64::to_radians),
            ),
            Source::LaserLeverArm => three(
                view.scanner_arm(),
                Vector3::from(lidar.lever_arm_error_m),
                Vector3::from(lidar.lever_arm_sigma_m),
            ),
            Source::TargetOffsets => {
                let offsets = self.scene.target.offsets.iter().zip(view.offsets());
                let each = offsets.map(|(o, d)| d * d.transpose() * (o.sigma_m * factor).powi(2));
                noise(each.sum())
            }
            _ => NO_DERIVATIVE,
        }
    }

    /// Whether something acts that has no derivative.
    fn disturbance(&self, source: Source) -> Prediction {
        let d = &self.scenario.disturbance;
        let acts = match source {
            Source::GrossErrors => d.gross_fraction,
            Source::Clutter => d.sonar_clutter_fraction.max(d.laser_clutter_fraction),
            Source::Multipath => d.multipath_fraction,
            _ => d.body.len() as f64,
        };
        if acts * self.factor(source) > 0.0 {
            NO_DERIVATIVE
        } else {
            noise(Matrix6::zeros())
        }
    }

    /// The observations with the noise that really acts in place of the noise claimed.
    pub(super) fn true_noise(&self, claimed: &Campaign) -> Campaign {
        let mut campaign = claimed.clone();
        let t = &mut campaign.trajectory.noise;
        t.position_m *= self.factor(Source::PositionWhite);
        t.position_drift_m *= self.factor(Source::PositionDrift);
        t.roll_pitch_rad *= self.factor(Source::RollPitch);
        t.heading_rad *= self.factor(Source::Heading);
        t.heading_drift_rad *= self.factor(Source::HeadingDrift);
        let s = &mut campaign.soundings.noise;
        s.range_m *= self.factor(Source::SonarRange);
        s.across_rad *= self.factor(Source::SonarAngle);
        s.along_rad *= self.factor(Source::SonarAlongAngle);
        let l = &mut campaign.laser.noise;
        l.range_m *= self.factor(Source::LaserRange);
        l.angle_rad *= self.factor(Source::LaserAngle);
        campaign
    }

    /// The joint path's parameters with priors as wide as what really acts.
    pub(super) fn true_priors(&self, joint: &JointOutcome) -> ParameterSet {
        let mut x = joint.solution.estimate.parameters.clone();
        let mut scale = |id, source| {
            if let Some(prior) = &mut x.block_mut(id).prior {
                let factor = self.factor(source).max(1e-6);
                prior.covariance = &prior.covariance * (factor * factor);
            }
        };
        if let Some(scanner) = joint.blocks.scanner {
            scale(scanner.rotation, Source::LaserBoresight);
            scale(scanner.lever_arm, Source::LaserLeverArm);
        }
        let mut done = vec![];
        for id in joint.blocks.faces.iter().flatten().filter_map(|f| f.offset) {
            if !done.contains(&id) {
                scale(id, Source::TargetOffsets);
                done.push(id);
            }
        }
        x
    }
}

const NO_DERIVATIVE: Prediction = Prediction::NotPredicted {
    reason: "it decides which observations are tied or kept, which has no derivative: see the trials",
};

/// A source without mean.
fn noise(covariance: Matrix6<f64>) -> Prediction {
    Prediction::Linear {
        bias: Vector6::zeros(),
        covariance,
    }
}

fn turn_rad(turn: &Turn) -> Vector3<f64> {
    Vector3::new(turn.pitch, turn.roll, turn.yaw).map(f64::to_radians)
}

/// How many of [`Budget::noise`] concern soundings.
const SOUNDING_SOURCES: usize = 4;

/// One independent noise.
#[derive(Clone, Copy, Debug)]
struct NoiseOf {
    source: Source,
    /// Standard deviation, metres or radians.
    sigma: f64,
    /// Growth at the outermost beam, with the square of the angle.
    growth: f64,
    edge_rad: f64,
}

impl NoiseOf {
    /// Standard deviation along the normal, metres.
    fn sigma(&self, seen: &Seen) -> f64 {
        match self.source {
            Source::SonarRange | Source::LaserRange => self.sigma * seen.gain.x,
            Source::SonarAngle => {
                let growth = 1.0 + self.growth * (seen.across_rad / self.edge_rad).powi(2);
                self.sigma * seen.gain.y * growth
            }
            Source::LaserAngle => self.sigma * seen.gain.y,
            Source::SonarAlongAngle => self.sigma * seen.gain.z,
            // roughness is along the normal; it lengthens the ray by 1 / cosine, 20 times at the most
            _ => self.sigma * (seen.gain.x.abs() / seen.gain.x.abs().max(0.05)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal noise under Huber: `beta = 2 Phi(k) - 1`, `E psi^2 = beta - 2 k phi(k) + 2 k^2 (1 - Phi(k))` (k = 2, tables).
    #[test]
    fn the_kernel_acts_as_its_closed_form_says() {
        let found = Tail::of(Kernel::Huber { k: 2.0 }, 1.0);
        let (beta, density, above) = (0.954499736, 0.053990967, 0.022750132);
        let square = beta - 4.0 * density + 8.0 * above;
        assert!((found.part - beta).abs() < 1e-4, "{found:?}");
        assert!(
            (found.inflation - square / (beta * beta)).abs() < 1e-4,
            "{found:?}"
        );
        let none = Tail::of(Kernel::Huber { k: 2.0 }, 0.1);
        assert!((none.part - 1.0).abs() < 1e-9 && (none.inflation - 1.0).abs() < 1e-6);
    }
}
