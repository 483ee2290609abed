//! Usage errors: as the parser words them, with foreign text escaped and cut.

use crate::output;
use clap::error::{Error, ErrorKind};
use std::process::ExitCode;

/// Longest piece of an argument in a message, in characters.
const SHOWN_CHARACTERS: usize = 64;
/// Longest message, in characters.
const MESSAGE_CHARACTERS: usize = 2_000;

/// Prints what the parser ended with: help and version on standard output, errors on standard error.
pub(crate) fn report(error: &Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // Help is for a terminal and may lose its reader.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let arguments: Vec<String> =
        std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect();
    output::note(message(&error.render().to_string(), &arguments).trim_end());
    ExitCode::from(2)
}

/// The parser's text, in which it quotes arguments or their parts after `=`.
fn message(text: &str, arguments: &[String]) -> String {
    let mut foreign: Vec<&str> =
        arguments.iter().flat_map(|argument| argument.split('=').chain([&**argument])).collect();
    foreign.retain(|part| shown(part) != *part);
    foreign.sort_unstable_by_key(|part| std::cmp::Reverse(part.len()));
    let text = foreign.iter().fold(text.to_owned(), |text, part| text.replace(part, &shown(part)));
    text.chars().take(MESSAGE_CHARACTERS).collect()
}

fn shown(foreign: &str) -> String {
    let escaped: String = foreign
        .chars()
        .map(|c| if matches!(c, '"' | '\'') { c.to_string() } else { c.escape_debug().to_string() })
        .collect();
    if escaped.chars().count() <= SHOWN_CHARACTERS {
        return escaped;
    }
    escaped.chars().take(SHOWN_CHARACTERS - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests;
