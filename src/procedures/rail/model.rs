//! The unknowns, and the cut of a light plane through the extruded rail.
//!
//! A point `u` of a profiler's plane lies in the rail frame at `q = D^T A_k (R u + l - v) + c`, of which the rail, endless along y, shows
//! only x and z. `R, l`: mounting; `A_k = Exp(m) Rz(-(h + a_k)) Rx(p_k) B`: attitude of the body at position k, with the table's turns
//! `a_k` (clockwise) and `p_k`, the rail's nominal heading h, the table's tilt and zero m, and the beam's seat B; `v, c`: centre of the
//! table's rotation in the body and in the cross-section; `D`: orientation of the rail in the level frame. Where the lateral axis lies a
//! gap `e` before the vertical one, a turn about it moves the body by `e (Rz - Rz Rx) y` more. At `l - v = 0` this is
//! the cut of an inclined light plane in `docs/rail.md`: `(x, z) = [[R11, R13], [R31, R33]] (s, t) + offset`.

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

use super::observed::Stand;
use super::scene::RailScene;
use crate::adjust::{
    AdjustError, Block, BlockId, ChainModel, ChainState, Component, ParameterSet, Process,
    ProcessKind, Unit,
};
use crate::geometry::rotation;
use crate::observe::Mounting;

/// Visible quantity of the chain that is the error of the turn about the vertical.
pub const TURN_HEADING: usize = 3;
/// The same about the lateral axis.
pub const TURN_PITCH: usize = 4;
/// Parameters sought per profiler: pitch, roll, yaw, lx, lz.
pub const SOUGHT: usize = 5;
/// Their names.
pub const SOUGHT_NAMES: [&str; SOUGHT] = ["pitch", "roll", "yaw", "lx", "lz"];

/// Handles of one profiler's blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MountingBlocks {
    /// Rotation.
    pub rotation: BlockId,
    /// Lever arm x and z.
    pub arm: BlockId,
    /// Lever arm y, along the rail.
    pub along: BlockId,
}

/// Handles of all blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// Profiler by profiler.
    pub mountings: Vec<MountingBlocks>,
    /// Tilt and zero of the table.
    pub level: BlockId,
    /// Seat of the beam.
    pub seat: BlockId,
    /// Orientation of the rail.
    pub rail: BlockId,
    /// Centre of rotation in the body.
    pub pivot_body: BlockId,
    /// Centre of rotation in the cross-section.
    pub pivot_rail: BlockId,
    /// Elements off the standard profile; `None` for a perfect rail.
    pub profile: Option<BlockId>,
    /// Gap between the table's axes; `None` where they meet.
    pub gap: Option<BlockId>,
}

fn diagonal(sigmas: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_iterator(
        sigmas.len(),
        sigmas.iter().map(|s| s * s),
    ))
}

fn metres(name: &str, parts: &[String], value: &[f64]) -> Block {
    let components = parts
        .iter()
        .map(|part| Component::new(part.clone(), Unit::Metre));
    Block::euclidean(name, components.collect(), value)
}

fn known(block: Block, sigmas: &[f64]) -> Block {
    let value = block.value.clone();
    block.with_prior(value, diagonal(sigmas))
}

fn axes(name: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| format!("{name} {axis}"))
}

fn turn(name: &str, parts: &[String; 3], value: &Matrix3<f64>) -> Block {
    Block::rotation(name, [&parts[0], &parts[1], &parts[2]], value)
}

/// Every unknown at its start, with priors where the survey has them.
///
/// # Errors
/// [`AdjustError`] when a prior's sigma is not positive.
pub fn parameters(
    scene: &RailScene,
    start: &[Mounting],
) -> Result<(ParameterSet, Blocks), AdjustError> {
    let mut set = ParameterSet::new();
    let mountings = mounting_blocks(&mut set, scene, start)?;
    let s = &scene.campaign.stand;
    let blocks = Blocks {
        mountings,
        level: set.push(level_block(s))?,
        seat: set.push(known(
            turn("seat of the beam", &axes("seat"), &Matrix3::identity()),
            &[s.seating_sigma_rad; 3],
        ))?,
        rail: set.push(rail_block(s))?,
        pivot_body: set.push(pivot_body_block(s))?,
        pivot_rail: set.push(pivot_rail_block(s))?,
        profile: profile_block(scene)
            .map(|block| set.push(block))
            .transpose()?,
        gap: gap_block(s).map(|block| set.push(block)).transpose()?,
    };
    Ok((set, blocks))
}

/// The parameters sought first, profiler by profiler, then the lever arms along the rail.
fn mounting_blocks(
    set: &mut ParameterSet,
    scene: &RailScene,
    start: &[Mounting],
) -> Result<Vec<MountingBlocks>, AdjustError> {
    let profilers = &scene.campaign.profilers;
    let mut sought = vec![];
    for (profiler, mounting) in profilers.iter().zip(start) {
        let name = |part: &str| format!("{} {part}", profiler.name);
        let three = ["pitch", "roll", "yaw"].map(name);
        let rotation = turn(&name("rotation"), &three, &mounting.rotation);
        let rotation = set.push(rotation.sought())?;
        let arm = [mounting.lever_arm_m.x, mounting.lever_arm_m.z];
        let arm = metres(&name("lever arm"), &["lx", "lz"].map(name), &arm);
        sought.push((rotation, set.push(arm.sought())?));
    }
    let mut all = vec![];
    for ((rotation, arm), profiler) in sought.into_iter().zip(profilers) {
        let name = [format!("{} ly", profiler.name)];
        let block = metres(&name[0], &name, &[profiler.nominal.lever_arm_m.y]);
        let along = set.push(known(block, &[profiler.along_sigma_m]))?;
        all.push(MountingBlocks {
            rotation,
            arm,
            along,
        });
    }
    Ok(all)
}

fn level_block(s: &Stand) -> Block {
    let parts = ["table tilt x", "table tilt y", "table zero"].map(str::to_owned);
    let sigmas = [s.level_sigma_rad, s.level_sigma_rad, s.zero_sigma_rad];
    known(turn("table level", &parts, &Matrix3::identity()), &sigmas)
}

fn rail_block(s: &Stand) -> Block {
    let (name, [roll, pitch, heading]) = ("rail orientation", s.rail_attitude_rad);
    let nominal = rotation::from_attitude(roll, pitch, heading);
    let sigmas = s.rail_attitude_sigma_rad;
    known(turn(name, &axes(name), &nominal), sigmas.as_slice())
}

fn pivot_body_block(s: &Stand) -> Block {
    let name = "pivot in the body";
    let block = metres(name, &axes(name), s.pivot_body_m.as_slice());
    known(block, &[s.pivot_body_sigma_m; 3])
}

fn pivot_rail_block(s: &Stand) -> Block {
    let parts = ["pivot at the rail x", "pivot at the rail z"].map(str::to_owned);
    let block = metres("pivot at the rail", &parts, s.pivot_rail_m.as_slice());
    known(block, &[s.pivot_rail_sigma_m; 2])
}

fn gap_block(s: &Stand) -> Option<Block> {
    let name = "gap between the table's axes";
    let sigma = s.axes_gap_sigma_m;
    (sigma > 0.0).then(|| known(metres(name, &[name.to_owned()], &[0.0]), &[sigma]))
}

fn profile_block(scene: &RailScene) -> Option<Block> {
    let sigma = scene.campaign.stand.profile_sigma_m;
    let names: Vec<String> = scene
        .rail
        .names
        .iter()
        .map(|n| format!("rail {n}"))
        .collect();
    let zeros = vec![0.0; names.len()];
    (sigma > 0.0).then(|| {
        known(
            metres("rail profile", &names, &zeros),
            &vec![sigma; names.len()],
        )
    })
}

/// The table's angle errors as states, one epoch per position and one to close the last interval.
///
/// # Errors
/// [`AdjustError::BadChain`] when the positions are not in order.
pub fn chain(scene: &RailScene) -> Result<ChainModel, AdjustError> {
    let table = &scene.campaign.table;
    let times: Vec<f64> = table
        .from_s
        .iter()
        .chain(table.to_s.last())
        .copied()
        .collect();
    let process = |component| Process {
        component,
        sigma: scene.campaign.stand.table_sigma_rad,
        kind: ProcessKind::White,
    };
    ChainModel::new(times, vec![process(TURN_HEADING), process(TURN_PITCH)])
}

impl Blocks {
    /// Mounting of a profiler.
    #[must_use]
    pub fn mounting(&self, x: &ParameterSet, profiler: usize) -> Mounting {
        let b = &self.mountings[profiler];
        let (arm, along) = (x.euclidean(b.arm), x.euclidean(b.along)[0]);
        Mounting {
            rotation: x.rotation(b.rotation),
            lever_arm_m: Vector3::new(arm[0], along, arm[1]),
        }
    }

    /// Columns of the parameters sought.
    #[must_use]
    pub fn sought(&self) -> usize {
        SOUGHT * self.mountings.len()
    }
}

/// The stand at one position.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Body into level.
    pub body: Matrix3<f64>,
    /// Everything before the beam's seat: seat frame into level.
    pub table: Matrix3<f64>,
    /// Seat of the beam.
    pub seat: Matrix3<f64>,
    /// Axis of a growing turn about the vertical (clockwise), level frame.
    pub heading_axis: Vector3<f64>,
    /// Axis of a growing turn about the lateral axis, level frame.
    pub pitch_axis: Vector3<f64>,
    /// Rail into level.
    pub rail: Matrix3<f64>,
    /// Centre of rotation in the body, metres.
    pub pivot_body_m: Vector3<f64>,
    /// Centre of rotation in the cross-section, metres.
    pub pivot_rail_m: Vector2<f64>,
    /// How far the lateral axis lies before the vertical one, metres.
    pub gap_m: f64,
}

impl Turned {
    /// The stand at a position under parameters and table errors.
    #[must_use]
    pub fn at(
        scene: &RailScene,
        blocks: &Blocks,
        x: &ParameterSet,
        states: Option<&ChainState>,
        position: usize,
    ) -> Self {
        let error = states.map_or([0.0; 6], |s| s.between(position as u32, 1.0, 0.0));
        let p = &scene.positions[position];
        let heading =
            scene.campaign.stand.rail_attitude_rad[2] + p.heading_rad + error[TURN_HEADING];
        let (level, seat) = (x.rotation(blocks.level), x.rotation(blocks.seat));
        let upright = level * rotation::exp(&(-heading * Vector3::z()));
        let table = upright * rotation::exp(&((p.pitch_rad + error[TURN_PITCH]) * Vector3::x()));
        let section = x.euclidean(blocks.pivot_rail);
        Self {
            body: table * seat,
            heading_axis: -level.column(2),
            pitch_axis: upright.column(0).into_owned(),
            table,
            seat,
            rail: x.rotation(blocks.rail),
            pivot_body_m: Vector3::from_column_slice(x.euclidean(blocks.pivot_body)),
            pivot_rail_m: Vector2::new(section[0], section[1]),
            gap_m: blocks.gap.map_or(0.0, |id| x.euclidean(id)[0]),
        }
    }

    /// What a metre of gap between the table's axes moves the body by, level frame: `(Rz - Rz Rx) y`.
    #[must_use]
    pub fn by_gap(&self) -> Vector3<f64> {
        self.pitch_axis.cross(&self.heading_axis) - self.table.column(1)
    }

    /// A point of the body, given from the centre of rotation, from the table's vertical axis: level frame, metres.
    #[must_use]
    pub fn place_m(&self, arm_m: &Vector3<f64>) -> Vector3<f64> {
        self.body * arm_m + self.by_gap() * self.gap_m
    }

    /// A point of the body in the rail's cross-section (x, z), metres.
    #[must_use]
    pub fn section(&self, body_m: &Vector3<f64>) -> Vector2<f64> {
        let q = self.rail.transpose() * self.place_m(&(body_m - self.pivot_body_m));
        Vector2::new(q.x, q.z) + self.pivot_rail_m
    }
}
