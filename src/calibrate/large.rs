//! The `[large]` section of a survey file.

use std::path::Path;

use crate::adjust::Large;
use crate::survey::limits::limits;
use crate::survey::schema::Kind;
use crate::survey::section::section;

/// Bytes of a megabyte.
pub(crate) const MEGABYTE: f64 = 1e6;

section! {
    #[settings]
    /// Surveys with long trajectories: where the adjustment cuts the chain of their records, and what it keeps in memory.
    #[derive(Clone, Debug, PartialEq)]
    pub struct LargeConfig {
        /// Records between two cuts; a trajectory of no more is not cut. Figures depend on it by rounding only.
        block_records: u32 = or (65_536), Kind::Count(limits(64.0, 1e9, "64 to 1000000000"));
        /// What the adjustment may keep in memory of the eliminated trajectory, megabytes; if it is more, all of it goes to a file.
        factor_memory_mb: f64 = or (4096.0), Kind::Number(limits(0.0, 1e9, "megabytes from 0 to 1e9"));
        /// Folder of that file, seen from this one; the system's folder for temporary files.
        #[serde(skip_serializing_if = "Option::is_none")]
        spill: Option<String> = or (None), Kind::Text;
    }
}

impl LargeConfig {
    /// For the engine; `file` is the file that the section stands in.
    #[must_use]
    pub fn engine(&self, file: &Path) -> Large {
        let folder = file.parent().unwrap_or(Path::new(""));
        Large {
            block_records: self.block_records as usize,
            factor_memory: (self.factor_memory_mb * MEGABYTE) as u64,
            spill: self.spill.as_ref().map(|spill| folder.join(spill)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_the_engine_s() {
        let file = Path::new("folder/survey.toml");
        assert_eq!(LargeConfig::default().engine(file), Large::default());
    }

    #[test]
    fn the_folder_is_seen_from_the_file() {
        let given: LargeConfig =
            toml::from_str("factor_memory_mb = 0.5\nspill = \"scratch\"").unwrap();
        let large = given.engine(Path::new("folder/survey.toml"));
        assert_eq!(large.factor_memory, 500_000);
        assert_eq!(large.spill.as_deref(), Some(Path::new("folder/scratch")));
    }
}
