//! A survey plan as plain serialisable data: `plan.json`.
//!
//! Angles in degrees, lengths in metres, as the names say. What cannot be determined is `None` (`null` in the file), never NaN.

use serde::{Deserialize, Serialize};

use super::{BudgetParameter, Figures, Software, SweepValue};

/// Version of [`PlanResult`]'s form.
pub const PLAN_FORMAT_VERSION: u32 = 2;

/// `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanResult {
    /// [`PLAN_FORMAT_VERSION`].
    pub format_version: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Digest of its content, the seed apart.
    pub scenario_sha256: String,
    /// The program that made the plan.
    pub software: Software,
    /// The command that makes it again.
    pub command: String,
    /// What the next pass should make smallest.
    pub criterion: PlanCriterion,
    /// The parameters; every list of standard deviations is in their order and units.
    pub parameters: Vec<BudgetParameter>,
    /// Standard deviations wanted.
    pub wanted: Figures,
    /// Passes that are already sailed.
    pub sailed: Vec<PlannedPass>,
    /// Standard deviations with those; `None` where nothing is sailed.
    pub sailed_standard_deviation: Option<Figures>,
    /// Passes to choose from.
    pub candidates: Vec<PlanCandidate>,
    /// The passes to sail, in order; ends when everything wanted is reached.
    pub chosen: Vec<PlanStep>,
    /// Most passes that were allowed to be added.
    pub most: u64,
    /// Passes to add until everything wanted is reached; `None` where the most that was allowed does not do.
    pub passes_needed: Option<u64>,
    /// Standard deviations that no number of these passes goes below.
    pub floor: Option<Figures>,
    /// Parameters whose floor lies above what is wanted.
    pub unreachable: Vec<String>,
    /// Outlines of the target's faces from above: polygons of (Y along the wall, X through the wall away from the boat), metres.
    pub faces_from_above_m: Vec<Vec<[f64; 2]>>,
    /// Scenario values compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variations: Option<PlanVariations>,
    /// Sentences that the reader should know.
    pub notes: Vec<String>,
}

/// What the next pass should make smallest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanCriterion {
    /// The determinant of the covariance: the volume of the error ellipsoid.
    D,
    /// The sum of the variances, each in units of the wanted standard deviation.
    A,
}

impl PlanCriterion {
    /// In words.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::D => "D-optimal (volume of the error ellipsoid)",
            Self::A => "A-optimal (sum of the variances in units of what is wanted)",
        }
    }
}

/// A straight course along the wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedPass {
    /// What tells it from the others.
    pub name: String,
    /// Distance of the INS from the wall's front face.
    pub distance_m: f64,
    /// Y where it begins.
    pub from_m: f64,
    /// Y where it ends.
    pub to_m: f64,
    /// Speed over ground.
    pub speed_m_s: f64,
    /// Heading minus course.
    pub crab_deg: f64,
    /// Latitude and longitude where it begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begin_deg: Option<[f64; 2]>,
    /// Latitude and longitude where it ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_deg: Option<[f64; 2]>,
}

impl PlannedPass {
    /// How long it takes, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        (self.to_m - self.from_m).abs() / self.speed_m_s
    }
}

/// A pass to choose from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanCandidate {
    /// The pass.
    pub pass: PlannedPass,
    /// Soundings that would be tied to the target.
    pub soundings: u64,
    /// Laser returns that would be tied to it.
    pub returns: u64,
    /// Standard deviations if it were sailed next.
    pub standard_deviation_if_next: Option<Figures>,
    /// Why it tells nothing, or empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub refusal: String,
}

/// One pass of the greedy choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanStep {
    /// Index of the candidate, from 0.
    pub candidate: u64,
    /// Its name.
    pub name: String,
    /// Standard deviations with it and all before.
    pub standard_deviation: Figures,
}

/// Predicted standard deviations of the scenario's own passes at several values of one or two of its keys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanVariations {
    /// The varied keys, one or two.
    pub keys: Vec<String>,
    /// The points; of two keys the first varies slowest.
    pub points: Vec<PlanVariation>,
}

/// A point of [`PlanVariations`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanVariation {
    /// Value of each key, in the key's unit.
    pub values: Vec<SweepValue>,
    /// Standard deviations of all passes of the scenario together.
    pub standard_deviation: Option<Figures>,
    /// Why there is none, or empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub refusal: String,
}
