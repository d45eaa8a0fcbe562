//! Calibration targets as faces: the patent's wall with two staggered columns of blocks, and free-form faces.

pub mod face;
pub mod model;
mod wall;

pub use face::{Face, Outline, Role};
pub use model::{FaceModel, TargetError, TargetModel, WallModel};

use nalgebra::Vector3;

/// Faces that lie in parallel planes and share one unknown plane in the adjustment.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneGroup {
    /// Name for reports: "P1", "P2", "P3", "horizontal", or the plane id of a free-form face.
    pub name: String,
    /// Role of its faces.
    pub role: Role,
    /// Design unit normal, target frame; for horizontal faces it points up whichever way a face looks.
    pub normal: Vector3<f64>,
}

/// Offset of one or more faces from their group's plane, along the group's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignOffset {
    /// Name for reports.
    pub name: String,
    /// Design value, metres.
    pub value_m: f64,
    /// Standard deviation of the real offset about the design, metres; 0 for exact.
    pub sigma_m: f64,
}

/// A calibration target in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Every face, obstacles included.
    pub faces: Vec<Face>,
    /// The planes that faces share.
    pub groups: Vec<PlaneGroup>,
    /// The design offsets that faces share.
    pub offsets: Vec<DesignOffset>,
}

impl Target {
    /// Builds the faces of a model.
    ///
    /// # Errors
    /// [`TargetError`] naming every impossible dimension.
    pub fn from_model(model: &TargetModel) -> Result<Self, TargetError> {
        match model {
            TargetModel::PoolWall(wall) => wall::build(wall),
            TargetModel::Faces { face } => model::build_faces(face),
        }
    }

    /// Design offset (metres) of face `f` along its group's normal.
    #[must_use]
    pub fn design_offset_m(&self, face: usize) -> f64 {
        self.offsets[self.faces[face].offset].value_m
    }

    /// The group's index with this role, the first if there are several.
    #[must_use]
    pub fn group_of_role(&self, role: Role) -> Option<usize> {
        self.groups.iter().position(|g| g.role == role)
    }

    /// Largest distance of a vertex from the origin, metres.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.faces
            .iter()
            .flat_map(|f| f.outline.vertices_m.iter())
            .map(Vector3::norm)
            .fold(0.0, f64::max)
    }
}
