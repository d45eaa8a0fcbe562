//! The normal equations: one dense block of each tile, and all blocks with the priors.
//!
//! A tile's information is `N = J' P J` with posterior slopes in J, its score `s = -J' alpha` minus the trace term. A shift that all lines
//! of a tile share moves no likelihood but counts in `J' P J`; six columns of common shift, stretch and shear take it out.

use crate::math::dense::product;
use crate::math::skyline::Skyline;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};

use super::doubts::Doubts;
use super::field::{Collocation, Field, Noise, Points};
use super::model::{Adjusted, Located, Locator};
use super::parameters::{KINDS, Parameter};
use super::scene::Scene;
use super::states::{Component, States};
use super::tiles::Tile;

/// Which part of the derivatives of the parameters counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Both.
    All,
    /// What they move sideways: information from the relief.
    Relief,
    /// What they lift: information from the boat's motion.
    Motion,
}

/// What is sought in a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Sought {
    /// Which parameters, in the order of [`Scene::parameters`].
    pub parameters: Vec<bool>,
    /// Whether the trajectory's states are.
    pub states: bool,
    /// Factor on the variance of all noise.
    pub inflation: f64,
    /// Length over which common shifts of a tile change, metres.
    pub warp_m: f64,
    /// How well they are known beforehand, metres.
    pub warp_sigma_m: f64,
    /// Further unknowns, for their score tests.
    pub doubts: Option<Doubts>,
}

impl Sought {
    /// How many parameters there are, sought or not.
    fn count(&self) -> usize {
        self.parameters.len()
    }

    /// Places of the caller's own unknowns that are sought.
    pub(super) fn own<'a>(&'a self, scene: &Scene) -> impl Iterator<Item = usize> + use<'a> {
        (self.count() - scene.extras.len()..self.count()).filter(|k| self.parameters[*k])
    }

    /// Number of the first state: behind the parameters and what is doubted.
    fn first_state(&self) -> usize {
        self.count() + self.doubts.as_ref().map_or(0, Doubts::columns)
    }
}

/// One tile in the normal equations.
#[derive(Clone, Debug)]
pub struct Block {
    /// Numbers of its unknowns: parameters from 0, what is doubted behind them, states behind that.
    pub unknowns: Vec<usize>,
    /// Information, without what a common warp takes.
    pub information: DMatrix<f64>,
    /// Score.
    pub score: DVector<f64>,
    /// `z' P z`.
    pub omega: f64,
    /// Soundings minus 3.
    pub freedom: usize,
    /// Standardised residual of each sounding that took part.
    pub standardised: Vec<(u32, f64)>,
}

/// The soundings of a tile on the seabed.
pub struct Placed {
    /// Their numbers.
    pub numbers: Vec<u32>,
    /// Where they struck.
    pub located: Vec<Located>,
    /// About the tile's centre, with their noise.
    pub points: Points,
    across_m2: Vec<f64>,
    along: Vec<f64>,
}

impl Placed {
    /// Places those members of a tile that are `alive`.
    #[must_use]
    pub fn new(scene: &Scene, locator: &Locator<'_>, tile: &Tile, alive: &[bool]) -> Self {
        let members = tile.members.iter().filter(|k| alive[**k as usize]);
        let found = members.filter_map(|k| Some((*k, locator.locate(*k as usize)?)));
        let (numbers, located): (Vec<u32>, Vec<Located>) = found.unzip();
        let at_m: Vec<Vector3<f64>> = located.iter().map(|l| l.point_m - tile.centre_m).collect();
        let mut points = Points {
            at_m,
            noise: vec![],
        };
        let plane = points.plane();
        let normal = Vector3::new(-plane.y, -plane.z, 1.0);
        let mut placed = Self {
            numbers,
            located,
            points: Points::default(),
            across_m2: vec![],
            along: vec![],
        };
        for (number, located) in placed.numbers.iter().zip(&placed.located) {
            let along = normal.dot(&located.ray_m) / located.range_m;
            let across_m = normal.dot(&located.sideways) * located.range_m;
            let angle = (scene.sonar).angle_sigma_rad(scene.aside_rad(*number as usize));
            let ins = &scene.ins;
            let arm_m = located.range_m * located.sine;
            points.noise.push(Noise {
                sonar_m2: (along * scene.sonar.range_m).powi(2) + (across_m * angle).powi(2),
                ins_m2: 2.0 / 3.0 * (ins.position_m.powi(2) + (ins.roll_pitch_rad * arm_m).powi(2)),
            });
            placed.across_m2.push(across_m * angle * angle);
            placed.along.push(along);
        }
        placed.points = points;
        placed
    }

    /// Observations moved onto the tile's plane: the share of the relief along the ray, the share of the noise in range and angle.
    fn adjusted(&self, scene: &Scene, factor: f64, found: &Collocation, k: usize) -> Adjusted {
        let noise = factor * self.along[k] * scene.sonar.range_m.powi(2) * found.alpha[k];
        Adjusted {
            range_m: -found.relief[k] / self.along[k] - noise,
            across_rad: -factor * self.across_m2[k] * found.alpha[k],
        }
    }
}

/// Columns of common shift, stretch and shear.
const WARPS: usize = 6;

/// The block of a tile; `None` where too few soundings are left or the matrices are singular.
#[must_use]
pub fn block(
    locator: &Locator<'_>,
    placed: &Placed,
    field: &Field,
    sought: &Sought,
    part: Part,
) -> Option<Block> {
    let rows = Rows::new(locator, placed, field, sought, part)?;
    let (information, score) = rows.without_warps()?;
    let standardised = |k: usize| (placed.numbers[k], rows.found.standardised(k));
    Some(Block {
        information,
        score,
        omega: rows.found.omega,
        freedom: placed.numbers.len() - 3,
        standardised: (0..placed.numbers.len()).map(standardised).collect(),
        unknowns: rows.unknowns,
    })
}

impl Part {
    fn of(self, column: Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::All => column,
            Self::Relief => Vector3::new(column.x, column.y, 0.0),
            Self::Motion => Vector3::new(0.0, 0.0, column.z),
        }
    }
}

/// Calls `take` with every state that acts on a sounding of the tile; only heights of lines when no states are sought.
fn each_state(
    scene: &Scene,
    states: &States,
    placed: &Placed,
    k: usize,
    sought: &Sought,
    mut take: impl FnMut(Component, usize, f64),
) {
    let line = usize::from(scene.soundings[placed.numbers[k] as usize].line);
    states.each_share(line, placed.located[k].time_s, |share| {
        if sought.states || share.component == Component::LineHeight {
            take(share.component, share.state, share.weight);
        }
    });
}

/// The unknowns that a tile touches, ascending.
fn unknowns(scene: &Scene, states: &States, placed: &Placed, sought: &Sought) -> Vec<usize> {
    let count = sought.count();
    let mut all: Vec<usize> = (0..count).filter(|k| sought.parameters[*k]).collect();
    for k in 0..placed.numbers.len() {
        each_state(scene, states, placed, k, sought, |_, state, weight| {
            if weight > 0.0 {
                all.push(sought.first_state() + state);
            }
        });
        if let Some(doubts) = &sought.doubts {
            let sounding = &scene.soundings[placed.numbers[k] as usize];
            let line = usize::from(sounding.line);
            all.extend(
                doubts
                    .columns_of(line, sounding.head)
                    .map(|column| count + column),
            );
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// The Jacobian of a tile with its trace terms; behind the unknowns stand the columns of the warps.
pub(super) struct Rows {
    /// Numbers of the unknowns, ascending.
    pub unknowns: Vec<usize>,
    /// The collocation.
    pub found: Collocation,
    /// How far each observation is adjusted.
    pub adjusted: Vec<Adjusted>,
    jacobian: DMatrix<f64>,
    trace: DVector<f64>,
    /// Information on each warp beforehand.
    warp_prior: f64,
}

impl Rows {
    /// Of a tile; `None` where too few soundings are left or the matrices are singular.
    pub fn new(
        locator: &Locator<'_>,
        placed: &Placed,
        field: &Field,
        sought: &Sought,
        part: Part,
    ) -> Option<Self> {
        if placed.numbers.len() < 6 {
            return None;
        }
        let mut points = placed.points.clone();
        for noise in &mut points.noise {
            noise.sonar_m2 *= sought.inflation;
            noise.ins_m2 *= sought.inflation;
        }
        let found = points.collocate(field)?;
        let unknowns = unknowns(locator.scene, locator.states, placed, sought);
        let factor = field.noise_factor * field.noise_factor * sought.inflation;
        let count = placed.numbers.len();
        let adjusted = |k| placed.adjusted(locator.scene, factor, &found, k);
        let columns = unknowns.len() + WARPS;
        let parameters = locator.scene.parameters();
        let mut rows = Self {
            adjusted: (0..count).map(adjusted).collect(),
            jacobian: DMatrix::zeros(count, columns),
            trace: DVector::zeros(columns),
            warp_prior: sought.warp_sigma_m.powi(-2),
            unknowns,
            found,
        };
        for k in 0..count {
            rows.set_parameters(locator, placed, (&parameters, part), k);
            rows.set_states(locator, placed, sought, k);
            if let Some(doubts) = &sought.doubts {
                rows.set_doubts(locator.scene, placed, (doubts, parameters.len()), k);
            }
            rows.set_warps(k, &(points.at_m[k].xy() / sought.warp_m));
        }
        rows.without_plane(placed)?;
        Some(rows)
    }

    /// Takes out of every column what a plane under the adjusted soundings takes up: `J - A (W' A)^-1 W' J`, `W = C^-1 F`, A the plane's
    /// columns at the adjusted places.
    ///
    /// Relief and noise move a sounding along and across its ray, sideways as well as upwards, so the plane's own columns F move with its
    /// height. `alpha` is orthogonal to F and therefore not to a plane through the adjusted places: left in, a column that tilts the whole
    /// tile would have a score whose mean is not zero.
    fn without_plane(&mut self, placed: &Placed) -> Option<()> {
        let weighted = &self.found.weighted;
        let at = |k: usize| {
            placed.points.at_m[k].xy() + placed.located[k].moved_by(&self.adjusted[k]).xy()
        };
        let plane = DMatrix::from_fn(self.adjusted.len(), 3, |k, c| match c {
            0 => 1.0,
            c => at(k)[c - 1],
        });
        let taken = (weighted.tr_mul(&plane).lu()).solve(&weighted.tr_mul(&self.jacobian))?;
        self.jacobian -= plane * taken;
        Some(())
    }

    fn set_parameters(
        &mut self,
        locator: &Locator<'_>,
        placed: &Placed,
        (parameters, part): (&[Parameter], Part),
        k: usize,
    ) {
        let (located, adjusted) = (&placed.located[k], self.adjusted[k]);
        let deep_m = locator.deep_m(placed.numbers[k] as usize, located, &adjusted);
        let columns: [Vector3<f64>; KINDS] = located.columns(&adjusted, deep_m);
        let sounding = &locator.scene.soundings[placed.numbers[k] as usize];
        let moved = |parameter: &Parameter| match parameter.own() {
            Some(own) => located.own_column(&locator.scene.extras[own], sounding.row, &adjusted),
            None => columns[parameter.kind as usize],
        };
        for c in 0..self.unknowns.partition_point(|u| *u < parameters.len()) {
            let parameter = &parameters[self.unknowns[c]];
            if parameter.acts_on(sounding.head) {
                self.set(k, c, &part.of(moved(parameter)));
            }
        }
    }

    fn set_states(&mut self, locator: &Locator<'_>, placed: &Placed, sought: &Sought, k: usize) {
        let adjusted = self.adjusted[k];
        let (scene, states) = (locator.scene, locator.states);
        each_state(
            scene,
            states,
            placed,
            k,
            sought,
            |component, state, weight| {
                if let Ok(c) = self.unknowns.binary_search(&(sought.first_state() + state)) {
                    let moved = placed.located[k].state_column(component, &adjusted);
                    self.set(k, c, &(moved * weight));
                }
            },
        );
    }

    fn set_doubts(
        &mut self,
        scene: &Scene,
        placed: &Placed,
        (doubts, behind): (&Doubts, usize),
        k: usize,
    ) {
        let sounding = &scene.soundings[placed.numbers[k] as usize];
        let (line, adjusted) = (usize::from(sounding.line), self.adjusted[k]);
        for (column, moved) in doubts.moved((line, sounding.head), &placed.located[k], &adjusted) {
            if let Ok(c) = self.unknowns.binary_search(&(behind + column)) {
                self.set(k, c, &moved);
            }
        }
    }

    /// Adds that the unknown of column `c` moves sounding `k` by `moved`.
    fn set(&mut self, k: usize, c: usize, moved: &Vector3<f64>) {
        let trace = &self.found.trace[k];
        self.jacobian[(k, c)] += self.off_bed_m(k, moved);
        self.trace[c] += trace.x * moved.x + trace.y * moved.y;
    }

    /// How far sounding `k` leaves the bed when it moves by `moved`.
    pub fn off_bed_m(&self, k: usize, moved: &Vector3<f64>) -> f64 {
        let slope = &self.found.slopes[k];
        moved.z - slope.x * moved.x - slope.y * moved.y
    }

    fn set_warps(&mut self, k: usize, place: &Vector2<f64>) {
        let first = self.unknowns.len();
        for (c, g) in [1.0, place.x, place.y].into_iter().enumerate() {
            self.set(k, first + 2 * c, &Vector3::new(g, 0.0, 0.0));
            self.set(k, first + 2 * c + 1, &Vector3::new(0.0, g, 0.0));
        }
    }

    /// What takes the warps out of the unknowns: unknowns by warps.
    fn eliminating(&self, weighted: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let kept = self.unknowns.len();
        let warps = self.jacobian.columns(kept, WARPS);
        let prior = DMatrix::identity(WARPS, WARPS) * self.warp_prior;
        let normal = warps.tr_mul(&weighted.columns(kept, WARPS)) + prior;
        let coupling = warps.tr_mul(&weighted.columns(0, kept));
        Some(normal.cholesky()?.solve(&coupling).transpose())
    }

    /// Information and score of the unknowns after the warps are eliminated.
    fn without_warps(&self) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let kept = self.unknowns.len();
        let weighted = product(&self.found.precision, &self.jacobian);
        let normal = self.jacobian.tr_mul(&weighted);
        let score = -(self.jacobian.tr_mul(&self.found.alpha) + &self.trace);
        let eliminating = self.eliminating(&weighted)?;
        let coupling = normal.view((kept, 0), (WARPS, kept));
        let information = normal.view((0, 0), (kept, kept)) - product(&eliminating, &coupling);
        let reduced = score.rows(0, kept) - &eliminating * score.rows(kept, WARPS);
        Some((information, reduced))
    }

    /// How the score of the unknowns falls as each sounding's height grows: soundings by unknowns.
    pub fn pulls(&self) -> Option<DMatrix<f64>> {
        let kept = self.unknowns.len();
        let weighted = product(&self.found.precision, &self.jacobian);
        let eliminating = self.eliminating(&weighted)?;
        let warps = weighted.columns(kept, WARPS);
        Some(weighted.columns(0, kept) - product(&warps, &eliminating.transpose()))
    }
}

/// Information over what the other unknowns leave of it, beyond which it is rounding that is left.
const NOTHING_LEFT: f64 = 1e12;

/// All blocks and priors together.
#[derive(Clone, Debug)]
pub struct Normal {
    information: Skyline,
    score: Vec<f64>,
    parameters: usize,
    first_state: usize,
    /// Sum of squares of residuals, priors included.
    pub omega: f64,
    /// Degrees of freedom of `omega`.
    pub freedom: f64,
}

/// The step, and the rows of the inverse that belong to the parameters.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Change of every unknown.
    pub step: Vec<f64>,
    /// Rows of the inverse: parameters by unknowns.
    pub inverse: Vec<Vec<f64>>,
}

impl Solved {
    /// Covariance of two parameters.
    #[must_use]
    pub fn covariance(&self, a: usize, b: usize) -> f64 {
        self.inverse[a][b]
    }

    /// Standard deviation of a parameter.
    #[must_use]
    pub fn sigma(&self, parameter: usize) -> f64 {
        self.inverse[parameter][parameter].max(0.0).sqrt()
    }
}

/// Information of the parameters' priors; 0 where there is none.
#[must_use]
pub fn prior_information(scene: &Scene) -> Vec<f64> {
    let of = |sigma: f64| if sigma > 0.0 { sigma.powi(-2) } else { 0.0 };
    let parameters = scene.parameters();
    let each = parameters.iter().map(|p| of(scene.prior_sigma(p)));
    each.collect()
}

impl Normal {
    /// Sums the blocks in their order and adds the priors at the current distances from nominal.
    #[must_use]
    pub fn new(
        scene: &Scene,
        states: &States,
        blocks: &[Block],
        sought: &Sought,
        from_nominal: &[f64],
        state_values: &[f64],
    ) -> Self {
        let first = sought.first_state();
        let size = first + states.len();
        let mut groups: Vec<Vec<usize>> = blocks.iter().map(|b| b.unknowns.clone()).collect();
        states.each_information(|row, column, _| groups.push(vec![first + row, first + column]));
        let mut normal = Self {
            information: Skyline::new(size, first, groups.iter().map(Vec::as_slice)),
            score: vec![0.0; size],
            parameters: sought.count(),
            first_state: first,
            omega: 0.0,
            freedom: 0.0,
        };
        for block in blocks {
            normal.add(block);
        }
        normal.add_parameter_priors(scene, sought, from_nominal);
        normal.add_state_priors(states, state_values);
        normal
    }

    fn add(&mut self, block: &Block) {
        for (a, row) in block.unknowns.iter().enumerate() {
            self.score[*row] += block.score[a];
            for (b, column) in block.unknowns.iter().enumerate().take(a + 1) {
                self.information
                    .add(*row, *column, block.information[(a, b)]);
            }
        }
        self.omega += block.omega;
        self.freedom += block.freedom as f64;
    }

    fn add_parameter_priors(&mut self, scene: &Scene, sought: &Sought, from_nominal: &[f64]) {
        for (k, information) in prior_information(scene).into_iter().enumerate() {
            if !sought.parameters[k] {
                self.information.add(k, k, 1.0);
                continue;
            }
            self.information.add(k, k, information);
            self.score[k] -= information * from_nominal[k];
            self.omega += information * from_nominal[k] * from_nominal[k];
            if information == 0.0 {
                self.freedom -= 1.0;
            }
        }
    }

    fn add_state_priors(&mut self, states: &States, values: &[f64]) {
        let (information, score) = (&mut self.information, &mut self.score);
        let first = self.first_state;
        let mut omega = 0.0;
        states.each_information(|row, column, value| {
            information.add(first + row, first + column, value);
            score[first + row] -= value * values[column];
            omega += value * values[row] * values[column];
            if row != column {
                score[first + column] -= value * values[row];
                omega += value * values[row] * values[column];
            }
        });
        self.omega += omega;
    }

    /// Information and score of the parameters and of what is doubted, the states eliminated.
    #[must_use]
    pub fn without_states(self) -> Option<(DMatrix<f64>, DVector<f64>)> {
        self.information.reduced(self.first_state, &self.score)
    }

    /// Whether the other unknowns leave nothing of a parameter's information but rounding.
    #[must_use]
    pub fn is_taken_up(&self, parameter: usize, solved: &Solved) -> bool {
        let left = solved.covariance(parameter, parameter) * self.information.diagonal(parameter);
        !(left < NOTHING_LEFT)
    }

    /// Solves for the step; `None` where the matrix is not positive definite or the step is not a number.
    #[must_use]
    pub fn solve(&self) -> Option<Solved> {
        let unit = |k: usize| {
            let mut unit = vec![0.0; self.score.len()];
            unit[k] = 1.0;
            unit
        };
        let right: Vec<Vec<f64>> = std::iter::once(self.score.clone())
            .chain((0..self.parameters).map(unit))
            .collect();
        let mut solutions = self.information.clone().solve(&right)?.into_iter();
        let step = solutions.next()?;
        let finite = step.iter().all(|x| x.is_finite());
        finite.then(|| Solved {
            step,
            inverse: solutions.collect(),
        })
    }
}

/// Covariance from the scatter of the tiles' scores instead of the model: `N^-1 (sum s s' + priors) N^-1`, its diagonal.
#[must_use]
pub fn sandwich_variances(
    scene: &Scene,
    states: &States,
    blocks: &[Block],
    solved: &Solved,
) -> Vec<f64> {
    let count = solved.inverse.len();
    let mut variances = vec![0.0; count];
    let dot = |p: usize, unknowns: &[usize], score: &DVector<f64>| -> f64 {
        let each = unknowns.iter().zip(score.iter());
        each.map(|(u, s)| solved.inverse[p][*u] * s).sum()
    };
    let prior = prior_information(scene);
    for (p, variance) in variances.iter_mut().enumerate() {
        for block in blocks {
            *variance += dot(p, &block.unknowns, &block.score).powi(2);
        }
        for (k, information) in prior.iter().enumerate() {
            *variance += information * solved.inverse[p][k].powi(2);
        }
        states.each_information(|row, column, value| {
            let (a, b) = (count + row, count + column);
            let both = if row == column { 1.0 } else { 2.0 };
            *variance += both * value * solved.inverse[p][a] * solved.inverse[p][b];
        });
    }
    variances
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::seabed::joint::WARP_SIGMA_M;
    use crate::procedures::seabed::model::Values;
    use crate::procedures::seabed::tiles::Cell;

    /// The soundings within 3.5 m of every 150th, east and north.
    fn tiles(locator: &Locator<'_>) -> Vec<Tile> {
        let count = locator.scene.soundings.len();
        let at: Vec<Vector3<f64>> = (0..count)
            .filter_map(|k| Some(locator.locate(k)?.point_m))
            .collect();
        assert_eq!(at.len(), count);
        let about = |middle: usize| {
            let near = |k: &u32| (at[*k as usize] - at[middle]).xy().amax() < 3.5;
            Tile {
                cell: Cell { east: 0, north: 0 },
                centre_m: Vector3::new(at[middle].x, at[middle].y, 0.0),
                members: (0..count as u32).filter(near).collect(),
                strips: 2,
            }
        };
        let all = (0..count).step_by(150).map(about);
        all.filter(|tile| tile.members.len() > 30).collect()
    }

    /// On waves a field without direction would have the ground stretched or shrunk, which is no news of any unknown.
    #[test]
    fn a_stretch_of_waves_tells_nothing() {
        let waves = "[bed]\nripple_m = 0.4\nripple_length_m = 14.0";
        let scene = Scene::thin(|text| text.replace("[bed]", waves));
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        let values = Values::nominal(&scene, &states);
        let locator = Locator::new(&scene, &states, &values).expect("a profile");
        let parameters = scene.parameters();
        let sought = Sought {
            parameters: (0..parameters.len()).map(|k| k == 0).collect(),
            states: false,
            inflation: 1.0,
            warp_m: 4.0,
            warp_sigma_m: WARP_SIGMA_M[1],
            doubts: None,
        };
        let field = Field {
            sigma_m: 1.0,
            length_m: 20.0,
            noise_factor: 1.0,
        };
        let (mut held, mut left) = (0.0, 0.0);
        for tile in tiles(&locator) {
            let alive = vec![true; scene.soundings.len()];
            let placed = Placed::new(&scene, &locator, &tile, &alive);
            let mut rows = Rows::new(&locator, &placed, &field, &sought, Part::All).expect("rows");
            // a stretch by one unit to the east in the place of the first unknown
            let east = rows.unknowns.len() + 2;
            let stretch = rows.jacobian.column(east) * 4.0;
            rows.jacobian.set_column(0, &stretch);
            rows.trace[0] = 4.0 * rows.trace[east];
            held += (stretch.dot(&rows.found.alpha) + rows.trace[0]).abs();
            left += rows.without_warps().expect("a score").1[0].abs();
        }
        assert!(left < 0.01 * held, "{left} of {held}");
    }
}
