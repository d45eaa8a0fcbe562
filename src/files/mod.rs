//! Files on the disk, with nothing of the user's lost: written whole or not at all, several together, never over a file that the
//! program did not write.
//!
//! | module | what |
//! |---|---|
//! | `gate` | what becomes of files that are not done when the program is interrupted |
//! | [`temporary`] | names of their own beside the target, found and removed when a run was killed |
//! | [`whole`] | one file whole or not at all, several files together, and whether a folder can be written at all |
//! | [`marker`] | what the program itself wrote into a folder; a folder of files made together and never over others |
//! | [`spill`] | a file without name for what exceeds memory |
//! | [`wire`] | numbers as bytes for another process, and back |
//! | [`inputs`] | whether a path names one of these files |

mod gate;
pub mod inputs;
pub mod marker;
pub mod spill;
pub mod temporary;
pub mod whole;
pub mod wire;

pub use gate::abandon;
pub use inputs::{Overwrites, none_is};
pub use marker::{FolderError, Ours, made_together};
pub use whole::{WriteError, land, tried, write_bytes, write_whole};
