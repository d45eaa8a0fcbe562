//! How a long chain is worked on: where it is cut, and where its factor is kept.

use std::path::PathBuf;

/// How a long chain is worked on. The cuts change results by rounding alone, what is kept where does not change them at all.
#[derive(Debug, Clone, PartialEq)]
pub struct Large {
    /// Intervals of the chain between two cuts, at least two. A chain of no more is not cut.
    pub block_records: usize,
    /// Size up to which the chain's factor stays in memory (bytes); a larger one is written to a file without name.
    pub factor_memory: u64,
    /// Folder of that file; that of the system's temporary files where there is none.
    pub spill: Option<PathBuf>,
}

impl Default for Large {
    fn default() -> Self {
        Large {
            block_records: 65_536,
            factor_memory: 4_096_000_000,
            spill: None,
        }
    }
}
