//! Traces to standard output.

use std::env;
use std::fmt;
use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

/// `fmt::Write` for something that takes bytes.
struct Text<W>(W);

impl<W: Write> fmt::Write for Text<W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write_all(text.as_bytes()).map_err(|_| fmt::Error)
    }
}

/// Writes what the arguments ask for.
pub(crate) fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let mut out = Text(BufWriter::new(io::stdout().lock()));
    let written = red_traces::run(arguments.iter().map(String::as_str), &mut out);
    if written.is_ok() && out.0.flush().is_ok() {
        return ExitCode::SUCCESS;
    }
    eprintln!("usage: red-traces COUNT [last-lane-first]");
    ExitCode::FAILURE
}
