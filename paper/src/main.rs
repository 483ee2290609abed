//! Prints docs/paper.md: what `redrt paper --markdown` prints, without all else that the command is built from.

use std::io::{self, Write};

use red_paper::{EXPERIMENTS, Run, SEEDS, markdown};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = Run { seeds: SEEDS, progress: &|_, _| {}, is_stopped: &|| false };
    let mut tables = Vec::new();
    for experiment in EXPERIMENTS {
        writeln!(io::stderr(), "{}", experiment.name)?;
        tables.push((experiment.run)(&run)?);
    }
    writeln!(io::stdout(), "{}", markdown::document(&tables, SEEDS))?;
    Ok(())
}
