//! Usage errors: as the parser words them, with foreign text escaped and cut.

use crate::output;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use red_workload::shown;
use std::process::ExitCode;

/// Where the parser keeps what the user gave.
const FOREIGN: [ContextKind; 4] = [
    ContextKind::InvalidArg,
    ContextKind::InvalidSubcommand,
    ContextKind::InvalidValue,
    ContextKind::TrailingArg,
];

/// Prints what the parser ended with: help and version on standard output, errors on standard error.
pub(crate) fn report(error: Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // Help is for a terminal and may lose its reader.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    output::note(message(error).trim_end());
    ExitCode::from(2)
}

/// The parser's text. It colours what it quotes and takes colours out again, so foreign text is made harmless before.
fn message(mut error: Error) -> String {
    suggest(&mut error);
    for kind in FOREIGN {
        let Some(ContextValue::String(text)) = error.get(kind) else { continue };
        let harmless = shown(text);
        if harmless != *text {
            error.insert(kind, ContextValue::String(harmless));
            // The parser's tip quotes it once more.
            error.insert(ContextKind::Suggested, ContextValue::None);
        }
    }
    error.render().to_string()
}

/// The parser has no eye for upper and lower case.
fn suggest(error: &mut Error) {
    if let (Some(ContextValue::String(value)), Some(ContextValue::Strings(valid))) =
        (error.get(ContextKind::InvalidValue), error.get(ContextKind::ValidValue))
        && let Some(meant) = valid.iter().find(|valid| valid.eq_ignore_ascii_case(value))
    {
        let meant = ContextValue::String(meant.clone());
        error.insert(ContextKind::SuggestedValue, meant);
    }
}

#[cfg(test)]
mod tests;
