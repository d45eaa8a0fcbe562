//! The command-line program; everything it does is in `boresight::cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(boresight::cli::run_code(std::env::args_os()))
}
