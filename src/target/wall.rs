//! The patent's wall: geometry as the interface description defines it.

use nalgebra::Vector3;

use super::face::{Face, Outline, Role};
use super::model::{TargetError, WallModel};
use super::{DesignOffset, PlaneGroup, Target};

/// Index of each group in [`Target::groups`] of a wall.
const P1: usize = 0;
const P2: usize = 1;
const P3: usize = 2;
const HORIZONTAL: usize = 3;
const SIDE: usize = 4;

pub(super) fn build(model: &WallModel) -> Result<Target, TargetError> {
    let faults = faults(model);
    if !faults.is_empty() {
        return Err(TargetError { faults });
    }
    let mut builder = Builder::new(model);
    builder.wall_piece(
        "wall",
        -0.5 * model.wall_length_m,
        0.5 * model.wall_length_m,
        -0.5 * model.wall_height_m,
        0.5 * model.wall_height_m,
    );
    builder.column(-1.0, model.first_block_minus_y_m);
    builder.column(1.0, model.first_block_plus_y_m);
    Ok(builder.target)
}

fn faults(m: &WallModel) -> Vec<String> {
    let mut faults = vec![];
    let mut length = |key: &str, value: f64| {
        if !(value > 0.0 && value < 1000.0) {
            faults.push(format!(
                "{key} = {value}, expected more than 0 and less than 1000 m"
            ));
        }
    };
    length("wall_length_m", m.wall_length_m);
    length("wall_height_m", m.wall_height_m);
    length("block_leg_m", m.block_leg_m);
    length("block_height_m", m.block_height_m);
    for (key, value) in [
        ("coplanarity_sigma_m", m.coplanarity_sigma_m),
        ("height_sigma_m", m.height_sigma_m),
    ] {
        if !(0.0..=0.5).contains(&value) {
            faults.push(format!("{key} = {value}, expected 0 to 0.5 m"));
        }
    }
    for (key, value) in [
        ("first_block_minus_y_m", m.first_block_minus_y_m),
        ("first_block_plus_y_m", m.first_block_plus_y_m),
    ] {
        if !(value >= -0.5 * m.wall_height_m - 1e-9) {
            faults.push(format!(
                "{key} = {value}, expected at least -wall_height_m/2 = {}",
                -0.5 * m.wall_height_m
            ));
        }
    }
    if faults.is_empty() {
        faults.extend(too_many_blocks(m));
    }
    faults
}

/// Blocks of a column; more are a slip of the pen that costs memory and time.
const MOST_BLOCKS: f64 = 100.0;

fn too_many_blocks(m: &WallModel) -> Option<String> {
    let lowest_m = m.first_block_minus_y_m.min(m.first_block_plus_y_m);
    let blocks = (0.5 * m.wall_height_m - lowest_m) / (2.0 * m.block_height_m);
    (blocks > MOST_BLOCKS).then(|| {
        format!(
            "block_height_m = {}, which makes {blocks:.0} blocks in a column, expected at most {MOST_BLOCKS} blocks",
            m.block_height_m
        )
    })
}

struct Builder<'a> {
    model: &'a WallModel,
    target: Target,
}

impl<'a> Builder<'a> {
    fn new(model: &'a WallModel) -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let group = |name: &str, role, normal| PlaneGroup {
            name: name.to_owned(),
            role,
            normal,
        };
        let groups = vec![
            group("P1", Role::P1, Vector3::new(-half, half, 0.0)),
            group("P2", Role::P2, -Vector3::x()),
            group("P3", Role::P3, Vector3::new(-half, -half, 0.0)),
            group("horizontal", Role::Horizontal, Vector3::z()),
            group("side", Role::Obstacle, Vector3::y()),
        ];
        Self {
            model,
            target: Target {
                faces: vec![],
                groups,
                offsets: vec![],
            },
        }
    }

    /// Adds the polygon as a face that looks along `outward`, in whichever order the corners come.
    fn add(
        &mut self,
        name: String,
        group: usize,
        sigma_m: f64,
        outward: Vector3<f64>,
        corners: &[[f64; 3]],
    ) {
        let mut corners: Vec<Vector3<f64>> = corners.iter().map(|c| Vector3::from(*c)).collect();
        if Outline::new(corners.clone()).is_some_and(|o| o.normal.dot(&outward) < 0.0) {
            corners.reverse();
        }
        let Some(outline) = Outline::new(corners) else {
            return;
        };
        let PlaneGroup { role, normal, .. } = self.target.groups[group];
        let value_m = outline.vertices_m[0].dot(&normal);
        let offset = self.offset(&name, group, sigma_m, value_m);
        let facing = outline.normal.dot(&normal).signum();
        self.target.faces.push(Face {
            name,
            role,
            outline,
            group,
            facing,
            offset,
        });
    }

    /// Upright faces without tolerance share their group's offset; every other face has its own.
    fn offset(&mut self, face: &str, group: usize, sigma_m: f64, value_m: f64) -> usize {
        let shares = sigma_m == 0.0 && group != HORIZONTAL && group != SIDE;
        let name = if shares {
            &self.target.groups[group].name
        } else {
            face
        };
        let found = self
            .target
            .offsets
            .iter()
            .position(|o| shares && o.name == *name);
        found.unwrap_or_else(|| {
            self.target.offsets.push(DesignOffset {
                name: name.to_owned(),
                value_m,
                sigma_m,
            });
            self.target.offsets.len() - 1
        })
    }

    /// A rectangle of the wall's front face, x = 0.
    fn wall_piece(&mut self, name: &str, y0: f64, y1: f64, z0: f64, z1: f64) {
        if z1 - z0 > 1e-9 {
            let corners = [[0.0, y0, z0], [0.0, y1, z0], [0.0, y1, z1], [0.0, y0, z1]];
            self.add(name.to_owned(), P2, 0.0, -Vector3::x(), &corners);
        }
    }

    /// One column of blocks: undersides at first + 2 j e while the top is within the wall.
    fn column(&mut self, side: f64, first: f64) {
        let m = self.model;
        let (inner, outer) = (0.5 * m.wall_length_m, 0.5 * m.wall_length_m + m.block_leg_m);
        let (low, high) = (
            (side * inner).min(side * outer),
            (side * inner).max(side * outer),
        );
        let label = if side < 0.0 { "-Y" } else { "+Y" };
        let mut below = -0.5 * m.wall_height_m;
        let mut count = 0;
        while first + (2 * count) as f64 * m.block_height_m + m.block_height_m
            <= 0.5 * m.wall_height_m + 1e-9
        {
            let under = first + (2 * count) as f64 * m.block_height_m;
            count += 1;
            self.wall_piece(
                &format!("wall {label} below block {count}"),
                low,
                high,
                below,
                under,
            );
            self.block(&format!("{label} block {count}"), side, under);
            below = under + m.block_height_m;
        }
        self.wall_piece(
            &format!("wall {label} above the blocks"),
            low,
            high,
            below,
            0.5 * m.wall_height_m,
        );
    }

    fn block(&mut self, name: &str, side: f64, under: f64) {
        let m = self.model;
        let (c, top) = (m.block_leg_m, under + m.block_height_m);
        let (inner, outer) = (
            side * 0.5 * m.wall_length_m,
            side * (0.5 * m.wall_length_m + c),
        );
        let group = if side < 0.0 { P1 } else { P3 };
        let out = self.target.groups[group].normal;
        let face = [
            [0.0, inner, under],
            [0.0, inner, top],
            [-c, outer, top],
            [-c, outer, under],
        ];
        self.add(
            format!("{name} inclined"),
            group,
            m.coplanarity_sigma_m,
            out,
            &face,
        );
        let triangle = |z: f64| [[0.0, inner, z], [0.0, outer, z], [-c, outer, z]];
        self.add(
            format!("{name} top"),
            HORIZONTAL,
            m.height_sigma_m,
            Vector3::z(),
            &triangle(top),
        );
        self.add(
            format!("{name} underside"),
            HORIZONTAL,
            m.height_sigma_m,
            -Vector3::z(),
            &triangle(under),
        );
        let flank = [
            [0.0, outer, under],
            [0.0, outer, top],
            [-c, outer, top],
            [-c, outer, under],
        ];
        self.add(
            format!("{name} side"),
            SIDE,
            0.0,
            Vector3::y() * side,
            &flank,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::target::TargetModel;

    #[test]
    fn every_face_looks_outward() {
        let target = WallModel::of_tests();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for face in &target.faces {
            let expected = match (
                face.role,
                face.name.ends_with("top"),
                face.name.starts_with("-Y"),
            ) {
                (Role::P1, ..) => Vector3::new(-half, half, 0.0),
                (Role::P2, ..) => -Vector3::x(),
                (Role::P3, ..) => Vector3::new(-half, -half, 0.0),
                (Role::Horizontal, true, _) => Vector3::z(),
                (Role::Horizontal, false, _) => -Vector3::z(),
                (Role::Obstacle, _, true) => -Vector3::y(),
                _ => Vector3::y(),
            };
            assert!(
                (face.outline.normal - expected).norm() < 1e-12,
                "{}: {:?}",
                face.name,
                face.outline.normal
            );
            assert!(
                (face.facing * target.groups[face.group].normal - expected).norm() < 1e-12,
                "{}",
                face.name
            );
        }
    }

    #[test]
    fn blocks_stand_at_first_plus_two_j_e_and_none_is_clipped() {
        let target = WallModel::of_tests();
        let tops: Vec<f64> = target
            .faces
            .iter()
            .filter(|f| f.name.starts_with("+Y") && f.name.ends_with("top"))
            .map(|f| f.outline.vertices_m[0].z)
            .collect();
        assert_eq!(tops.len(), 4);
        for (j, top) in tops.iter().enumerate() {
            assert!((top - (-2.1 + 1.2 * j as f64 + 0.6)).abs() < 1e-12);
        }
        // the wall with its gaps and the blocks' footprints fill the front
        let front: f64 = target
            .faces
            .iter()
            .filter(|f| f.role == Role::P2)
            .map(|f| f.outline.area_m2())
            .sum();
        let hidden = (4.0 + 5.0) * 1.5 * 0.6;
        assert!((front - (11.0 * 6.0 - hidden)).abs() < 1e-9, "{front}");
    }

    #[test]
    fn faces_without_tolerance_share_one_offset_and_faces_with_do_not() {
        let exact = WallModel::of_tests();
        let offsets = |t: &Target, role: Role| {
            let mut o: Vec<usize> = t
                .faces
                .iter()
                .filter(|f| f.role == role)
                .map(|f| f.offset)
                .collect();
            o.dedup();
            o.len()
        };
        assert_eq!(
            (
                offsets(&exact, Role::P1),
                offsets(&exact, Role::P2),
                offsets(&exact, Role::P3)
            ),
            (1, 1, 1)
        );
        assert_eq!(offsets(&exact, Role::Horizontal), 18);
    }

    #[test]
    fn impossible_dimensions_are_all_listed() {
        let model = WallModel {
            wall_length_m: -1.0,
            wall_height_m: 0.0,
            block_leg_m: f64::NAN,
            block_height_m: 1.0,
            first_block_minus_y_m: 0.0,
            first_block_plus_y_m: 0.0,
            coplanarity_sigma_m: 2.0,
            height_sigma_m: 0.0,
        };
        let error = Target::from_model(&TargetModel::PoolWall(model)).expect_err("impossible");
        assert_eq!(error.faults.len(), 4);
    }
}
