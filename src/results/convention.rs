//! A mounting in the sense of another program.

use serde::{Deserialize, Serialize};

/// One program's table entry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Convention {
    /// The mounting, by its name among the solution's mountings.
    pub mounting: String,
    /// Program and the place where the numbers go.
    pub software: String,
    /// Its axes.
    pub axes: String,
    /// Lever arm from the INS centre to the sensor, metres, by the program's field names.
    pub lever_arm_m: Vec<ConventionField>,
    /// Mounting angles, degrees, by the program's field names and in its order.
    pub angles_deg: Vec<ConventionField>,
    /// Signs and order of rotations, and what is left out.
    pub remark: String,
    /// Public documents that settle it.
    pub sources: Vec<String>,
}

/// A number to type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConventionField {
    /// The field's name in the program.
    pub name: String,
    /// The number; `None` where no public document settles it.
    pub value: Option<f64>,
    /// Meaning of a positive value.
    pub positive: String,
}
