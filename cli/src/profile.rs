//! `redrt profile`.

use crate::outcome::{Answer, Failure};
use std::path::PathBuf;

/// Measures the bodies of a workload on this machine.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  redrt profile examples/cruise.toml")]
pub(crate) struct Args {
    /// Workload file, TOML or YAML.
    file: PathBuf,
}

/// Ends with a failure: this part is not built yet.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    red_workload::load(&args.file)?;
    Err(Failure::Machine("`redrt profile` is not built yet".to_owned()))
}
