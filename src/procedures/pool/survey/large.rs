//! The `[large]` section of a pool survey file: that of every procedure, and room for very many soundings.

use std::path::Path;

use crate::adjust::Large;
use crate::calibrate::large::{LargeConfig, MEGABYTE};
use crate::observe::Room;
use crate::survey::limits::limits;
use crate::survey::schema::Kind;
use crate::survey::section::section;

section! {
    #[settings]
    /// Surveys with long trajectories or very many soundings: where the adjustment cuts the chain of their records, and what is kept in memory.
    #[derive(Clone, Debug, PartialEq)]
    pub struct LargePoolConfig {
        /// Records between two cuts; a trajectory of no more is not cut. Figures depend on it by rounding only.
        block_records: u32 = or (65_536), Kind::Count(limits(64.0, 1e9, "64 to 1000000000"));
        /// What the adjustment may keep in memory of the eliminated trajectory, megabytes; if it is more, all of it goes to a file.
        factor_memory_mb: f64 = or (4096.0), Kind::Number(limits(0.0, 1e9, "megabytes from 0 to 1e9"));
        /// What the soundings may take in memory (40 bytes each), megabytes; if it is more, all of them go to a file as they are read.
        observations_memory_mb: f64 = or (4096.0), Kind::Number(limits(0.0, 1e9, "megabytes from 0 to 1e9"));
        /// Folder of both files, seen from this one; the system's folder for temporary files.
        #[serde(skip_serializing_if = "Option::is_none")]
        spill: Option<String> = or (None), Kind::Text;
    }
}

impl LargePoolConfig {
    /// For the engine; `file` is the file that the section stands in.
    #[must_use]
    pub fn engine(&self, file: &Path) -> Large {
        let shared = LargeConfig {
            block_records: self.block_records,
            factor_memory_mb: self.factor_memory_mb,
            spill: self.spill.clone(),
        };
        shared.engine(file)
    }

    /// For soundings, in the engine's folder.
    #[must_use]
    pub fn room(&self, engine: &Large) -> Room {
        Room {
            bytes: (self.observations_memory_mb * MEGABYTE) as u64,
            folder: engine.spill.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_the_engine_s() {
        let file = Path::new("pool/survey.toml");
        assert_eq!(LargePoolConfig::default().engine(file), Large::default());
    }
}
