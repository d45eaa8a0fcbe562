//! Why the reference path cannot run.

use thiserror::Error;

use crate::geometry::PlaneError;

/// A fault of the input that no pass can mend.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SequentialError {
    /// A plane has too few soundings.
    #[error("reference path: {found} soundings on {plane}, expected at least {expected}")]
    TooFewSoundings {
        /// "P1", "P2", "P3" or "the horizontal faces".
        plane: &'static str,
        /// Soundings found.
        found: usize,
        /// Soundings needed.
        expected: usize,
    },
    /// The target has no such face, or the scanner did not see enough of it for a plane.
    #[error(
        "reference path: the scanner gives no plane {plane} (no such face above the water, or fewer than 30 returns on it), expected one to compare the soundings with"
    )]
    NoScannerPlane {
        /// "P1", "P2" or "P3".
        plane: &'static str,
    },
    /// The scanner saw no horizontal face.
    #[error(
        "reference path: the scanner has no returns on horizontal faces, expected at least one face for the height offset"
    )]
    NoHorizontalReturns,
    /// The soundings of a face do not span it.
    #[error("reference path: soundings on {plane}: {source}")]
    NoPlane {
        /// "P1", "P2" or "P3".
        plane: &'static str,
        /// What the fit says.
        source: PlaneError,
    },
    /// One mean attitude cannot stand for soundings taken on contrary headings.
    #[error(
        "reference path: soundings on {plane} were taken on contrary headings (their mean attitude has length {length:.2}, expected at least 0.70); the patent's procedure needs passes in one direction"
    )]
    ContraryHeadings {
        /// Planes concerned.
        plane: &'static str,
        /// Smallest singular value of the mean rotation matrix, 1 for equal attitudes.
        length: f64,
    },
    /// P1 gives no Y.
    #[error(
        "reference path: the {sensor}'s P1 is parallel to Y (normal's y component {found:.3}), expected an inclined face"
    )]
    ParallelToY {
        /// "scanner" or "multibeam".
        sensor: &'static str,
        /// Component of the unit normal along Y.
        found: f64,
    },
}
