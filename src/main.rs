//! The command-line program; everything it does is in `boresight::cli`.

fn main() -> std::process::ExitCode {
    boresight::cli::main()
}
