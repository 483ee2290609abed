//! Standard output and standard error, either of which may be closed at any time.

use crate::outcome::Failure;
use serde::Serialize;
use std::io::{self, Write};

/// Longest message, in characters.
const MESSAGE_CHARACTERS: usize = 2_000;

/// Prints one JSON object and a line feed.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value)
        .map_err(|error| Failure::Machine(format!("cannot write the answer as JSON: {error}")))?;
    line(&text)
}

/// Prints a text and a line feed.
pub(crate) fn line(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        // The reader has seen enough, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::Machine(format!(
            "cannot write to standard output: {error}; send it to a place that takes it"
        ))),
    }
}

/// Tells something on standard error. Where nobody listens, nobody misses it.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{}", cut(text));
}

fn cut(text: &str) -> &str {
    text.char_indices().nth(MESSAGE_CHARACTERS).map_or(text, |(end, _)| &text[..end])
}

#[cfg(test)]
mod tests;
