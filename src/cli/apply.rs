use super::Ending;
use super::args::Apply;
use super::error::CliError;
use super::talk::Talk;
pub fn run(_args: &Apply, _talk: &Talk) -> Result<Ending, CliError> { Ok(Ending::Usable) }
