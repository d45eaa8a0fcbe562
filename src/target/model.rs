//! What a target file says (`kind = "pool-wall"` or `kind = "faces"`, see interface description).

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::face::{Face, Outline, Role};
use super::{DesignOffset, PlaneGroup, Target};

/// A target file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum TargetModel {
    /// The patent's wall with two staggered columns of blocks.
    #[serde(rename = "pool-wall")]
    PoolWall(WallModel),
    /// Free-form faces.
    #[serde(rename = "faces")]
    Faces {
        /// The faces.
        face: Vec<FaceModel>,
    },
}

/// Dimensions of the patent's wall (\[0095\]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallModel {
    /// a: free wall between the columns, metres.
    pub wall_length_m: f64,
    /// b: height of the wall, metres.
    pub wall_height_m: f64,
    /// c: short sides of the triangular blocks, metres.
    pub block_leg_m: f64,
    /// e: height of a block and of the space between two, metres.
    pub block_height_m: f64,
    /// Underside of the lowest block of the column at -Y, metres.
    pub first_block_minus_y_m: f64,
    /// Underside of the lowest block of the column at +Y, metres.
    pub first_block_plus_y_m: f64,
    /// Each inclined face off its column's common plane, along its normal, metres, one sigma.
    #[serde(default)]
    pub coplanarity_sigma_m: f64,
    /// Each horizontal face off its design height, metres, one sigma.
    #[serde(default)]
    pub height_sigma_m: f64,
}

#[cfg(test)]
impl WallModel {
    /// The wall that tests look at, built.
    pub(crate) fn of_tests() -> Target {
        let wall = Self {
            wall_length_m: 8.0,
            wall_height_m: 6.0,
            block_leg_m: 1.5,
            block_height_m: 0.6,
            first_block_minus_y_m: -2.7,
            first_block_plus_y_m: -2.1,
            coplanarity_sigma_m: 0.0,
            height_sigma_m: 0.0,
        };
        Target::from_model(&TargetModel::PoolWall(wall)).expect("a wall")
    }
}

/// A free-form face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaceModel {
    /// Unique name.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// Vertices, target frame, metres, counter-clockwise seen from the sensors.
    pub vertices_m: Vec<[f64; 3]>,
    /// Faces with the same id share one plane exactly.
    #[serde(default)]
    pub plane: Option<String>,
    /// Standard deviation of the face off its design position along its normal, metres.
    #[serde(default)]
    pub offset_sigma_m: f64,
}

/// What is wrong with a target model; every fault at once.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", faults.join("; "))]
pub struct TargetError {
    /// One sentence each: key, found, expected.
    pub faults: Vec<String>,
}

/// Faces of one role (or, for "other", of one plane id) share a plane when their normals are parallel to this.
const PARALLEL_RAD: f64 = 1e-6;

pub(super) fn build_faces(models: &[FaceModel]) -> Result<Target, TargetError> {
    let mut faults = face_faults(models);
    if let Some(fault) = too_many(models) {
        return Err(TargetError {
            faults: vec![fault],
        });
    }
    let mut target = Target {
        faces: vec![],
        groups: vec![],
        offsets: vec![],
    };
    for model in models {
        let vertices = model.vertices_m.iter().map(|v| Vector3::from(*v)).collect();
        match Outline::new(vertices) {
            Some(outline) if outline.warp_m() <= 1e-6 => add_face(&mut target, model, outline),
            Some(outline) => faults.push(format!(
                "face \"{}\": vertices are {:.4} m off their common plane, expected at most 0.000001 m",
                model.name,
                outline.warp_m()
            )),
            None => faults.push(format!(
                "face \"{}\": {} vertices that span no plane, expected at least three that do",
                model.name,
                model.vertices_m.len()
            )),
        }
    }
    faults.extend(shared_plane_faults(&target, models));
    if faults.is_empty() {
        Ok(target)
    } else {
        Err(TargetError { faults })
    }
}

/// Faces of a target, and corners of all of them; more cost memory and time that no pool is worth.
const MOST: (usize, usize) = (1000, 20_000);

fn too_many(models: &[FaceModel]) -> Option<String> {
    let corners: usize = models.iter().map(|m| m.vertices_m.len()).sum();
    (models.len() > MOST.0 || corners > MOST.1).then(|| {
        format!(
            "face: found {} with {corners} vertices, expected at most {} faces and {} vertices",
            models.len(),
            MOST.0,
            MOST.1
        )
    })
}

fn face_faults(models: &[FaceModel]) -> Vec<String> {
    let mut faults = vec![];
    if models.is_empty() {
        faults.push("no [[face]], expected at least one".to_owned());
    }
    for (k, model) in models.iter().enumerate() {
        if models[..k].iter().any(|m| m.name == model.name) {
            faults.push(format!(
                "face name \"{}\" found twice, expected unique names",
                model.name
            ));
        }
        if !(model.offset_sigma_m >= 0.0 && model.offset_sigma_m < 1.0) {
            faults.push(format!(
                "face \"{}\": offset_sigma_m = {}, expected 0 to 1 m",
                model.name, model.offset_sigma_m
            ));
        }
        if model.vertices_m.iter().flatten().any(|c| !c.is_finite()) {
            faults.push(format!("face \"{}\": a vertex is not a number", model.name));
        }
    }
    faults
}

fn add_face(target: &mut Target, model: &FaceModel, outline: Outline) {
    let upright = if model.role == Role::Horizontal {
        outline.normal * outline.normal.z.signum()
    } else {
        outline.normal
    };
    let group = find_group(target, model, &upright).unwrap_or_else(|| {
        let name = match model.role {
            Role::P1 => "P1".to_owned(),
            Role::P2 => "P2".to_owned(),
            Role::P3 => "P3".to_owned(),
            Role::Horizontal => "horizontal".to_owned(),
            Role::Other | Role::Obstacle => {
                model.plane.clone().unwrap_or_else(|| model.name.clone())
            }
        };
        target.groups.push(PlaneGroup {
            name,
            role: model.role,
            normal: upright,
        });
        target.groups.len() - 1
    });
    let normal = target.groups[group].normal;
    let value_m = outline.vertices_m[0].dot(&normal);
    let offset_name = model.plane.clone().unwrap_or_else(|| model.name.clone());
    let shared = model.plane.as_ref().and_then(|id| {
        target
            .faces
            .iter()
            .find(|f| f.group == group && target.offsets[f.offset].name == *id)
            .map(|f| f.offset)
    });
    let offset = shared.unwrap_or_else(|| {
        target.offsets.push(DesignOffset {
            name: offset_name,
            value_m,
            sigma_m: model.offset_sigma_m,
        });
        target.offsets.len() - 1
    });
    let facing = outline.normal.dot(&normal).signum();
    target.faces.push(Face {
        name: model.name.clone(),
        role: model.role,
        outline,
        group,
        facing,
        offset,
    });
}

fn find_group(target: &Target, model: &FaceModel, normal: &Vector3<f64>) -> Option<usize> {
    let named = model.plane.as_deref().unwrap_or(&model.name);
    target.groups.iter().position(|g| {
        let same = if matches!(model.role, Role::Other | Role::Obstacle) {
            g.name == named
        } else {
            true
        };
        g.role == model.role
            && same
            && g.normal.cross(normal).norm() < PARALLEL_RAD
            && g.normal.dot(normal) > 0.0
    })
}

/// Faces that claim one plane must lie in one.
fn shared_plane_faults(target: &Target, models: &[FaceModel]) -> Vec<String> {
    let mut faults = vec![];
    for (k, model) in models.iter().enumerate() {
        let Some(id) = &model.plane else { continue };
        let Some(first) = models[..k].iter().find(|m| m.plane.as_ref() == Some(id)) else {
            continue;
        };
        let face = |name: &str| target.faces.iter().find(|f| f.name == name);
        let (Some(a), Some(b)) = (face(&first.name), face(&model.name)) else {
            continue;
        };
        let gap = (b.outline.vertices_m[0] - a.outline.vertices_m[0])
            .dot(&a.outline.normal)
            .abs();
        if gap > 1e-6 || a.outline.normal.cross(&b.outline.normal).norm() > PARALLEL_RAD {
            faults.push(format!(
                "faces \"{}\" and \"{}\" name plane \"{id}\" but lie in different planes ({gap:.4} m apart)",
                first.name, model.name
            ));
        }
    }
    faults
}
