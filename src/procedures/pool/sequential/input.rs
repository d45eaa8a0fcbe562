//! What the reference path is given: sums over the soundings on each face, and the scanner's planes.

use nalgebra::{Matrix3, Vector3};

use super::SequentialError;
use crate::geometry::{PlaneFit, PlaneMoments, rotation};

/// Fewest soundings on a plane.
const LEAST_SOUNDINGS: usize = 20;
/// Smallest singular value of a mean rotation that still is one attitude (a spread of about 45 deg).
const LEAST_LENGTH: f64 = 0.70;

/// Sums over the soundings of one face or role: all that the path needs of them. Parts merge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceSoundings {
    moments: PlaneMoments,
    attitudes: Matrix3<f64>,
}

impl FaceSoundings {
    /// Adds a sounding at `point_m` (target frame, metres), taken with attitude `R_b^t`.
    pub fn add(&mut self, point_m: &Vector3<f64>, target_from_body: &Matrix3<f64>) {
        self.moments.add(point_m);
        self.attitudes += target_from_body;
    }

    /// Adds the soundings of another part.
    pub fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        self.attitudes += other.attitudes;
    }

    /// Number of soundings.
    #[must_use]
    pub fn count(&self) -> usize {
        self.moments.count()
    }

    /// Mean position (target frame, metres) of enough soundings.
    ///
    /// # Errors
    /// [`SequentialError::TooFewSoundings`] on `plane`.
    pub fn mean_m(&self, plane: &'static str) -> Result<Vector3<f64>, SequentialError> {
        self.moments
            .centroid_m()
            .filter(|_| self.count() >= LEAST_SOUNDINGS)
            .ok_or(SequentialError::TooFewSoundings {
                plane,
                found: self.count(),
                expected: LEAST_SOUNDINGS,
            })
    }

    /// Least-squares plane (\[0051\]-\[0088\]) with its normal to the side of `direction`.
    ///
    /// # Errors
    /// [`SequentialError`] when the soundings on `plane` are too few or span no plane.
    pub fn plane(
        &self,
        plane: &'static str,
        direction: &Vector3<f64>,
    ) -> Result<PlaneFit, SequentialError> {
        self.mean_m(plane)?;
        let fit = self.moments.fit();
        fit.map(|f| f.towards(direction))
            .map_err(|source| SequentialError::NoPlane { plane, source })
    }

    /// Mean attitude `R_b^t` of the soundings: the rotation nearest to the mean matrix.
    ///
    /// # Errors
    /// [`SequentialError::ContraryHeadings`] when their attitudes have no meaningful mean.
    pub fn mean_attitude(&self, plane: &'static str) -> Result<Matrix3<f64>, SequentialError> {
        let mean = self.attitudes / self.count().max(1) as f64;
        let length = mean.singular_values().min();
        if length >= LEAST_LENGTH {
            Ok(rotation::orthonormalised(&mean))
        } else {
            Err(SequentialError::ContraryHeadings { plane, length })
        }
    }
}

/// Soundings on one horizontal face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HorizontalSoundings {
    /// Design height of the face, target frame, metres.
    pub design_height_m: f64,
    /// The soundings.
    pub soundings: FaceSoundings,
}

/// Soundings on the target under one mounting, all passes pooled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoleSoundings {
    /// On the inclined faces at -Y.
    pub p1: FaceSoundings,
    /// On the wall.
    pub p2: FaceSoundings,
    /// On the inclined faces at +Y.
    pub p3: FaceSoundings,
    /// On each horizontal face; faces without soundings may be left out.
    pub horizontal: Vec<HorizontalSoundings>,
}

impl RoleSoundings {
    /// All soundings on upright planes together.
    #[must_use]
    pub fn upright(&self) -> FaceSoundings {
        let mut all = self.p1;
        all.merge(&self.p2);
        all.merge(&self.p3);
        all
    }

    /// All soundings on horizontal faces together.
    #[must_use]
    pub fn level(&self) -> FaceSoundings {
        let mut all = FaceSoundings::default();
        self.horizontal.iter().for_each(|h| all.merge(&h.soundings));
        all
    }
}

/// Returns on one horizontal face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HorizontalReturns {
    /// Index of the face in the target.
    pub face: usize,
    /// Design height of the face, target frame, metres.
    pub design_height_m: f64,
    /// Mean height of its returns, target frame, metres.
    pub mean_height_m: f64,
    /// Number of returns.
    pub count: usize,
}

/// The scanner's side, the truth of the reference path; target frame, normals towards the boat.
#[derive(Clone, Debug, PartialEq)]
pub struct ScannerPlanes {
    /// Inclined faces at -Y.
    pub p1: PlaneFit,
    /// The wall.
    pub p2: PlaneFit,
    /// Inclined faces at +Y.
    pub p3: PlaneFit,
    /// Mean X of the wall's returns above the water, metres.
    pub wall_mean_x_m: f64,
    /// Horizontal faces above the water.
    pub horizontal: Vec<HorizontalReturns>,
}
