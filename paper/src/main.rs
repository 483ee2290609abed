//! Prints docs/paper.md: what `redrt paper --markdown` prints, without all else that the command is built from.

use std::io::{self, IsTerminal, Write};

use red_paper::{EXPERIMENTS, Run, SEEDS, markdown};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = Run { seeds: SEEDS, progress: &|_, _| {}, is_stopped: &|| false };
    let mut tables = Vec::new();
    for experiment in EXPERIMENTS {
        if io::stderr().is_terminal() {
            writeln!(io::stderr(), "{}", experiment.name)?;
        }
        tables.push((experiment.run)(&run)?);
    }
    writeln!(io::stdout(), "{}", markdown::document(&tables, SEEDS))?;
    Ok(())
}
