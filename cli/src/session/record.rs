//! The log of a run: begun before real time starts, closed after it.

use super::{Options, Robot, SessionError};
use crate::outcome::Failure;
use crate::progress;
use crate::regular;
use red_record::{Header, StartError, Tape, Totals, Writer};
use red_rt::runtime::Mode;
use red_workload::{Format, Source, shown_path};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A log that is being written.
pub(crate) struct Recording {
    path: PathBuf,
    writer: Writer,
}

/// A log that is closed.
#[derive(Debug)]
pub(crate) struct ClosedLog {
    totals: Totals,
    path: PathBuf,
    failed: Option<std::io::Error>,
}

/// A log in numbers, as `run --json` prints it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LogSummary {
    /// Inputs in the log.
    inputs: u64,
    /// Inputs that are not in the log, all of them after those that are.
    dropped: u64,
    /// Bytes of the file.
    bytes: u64,
    /// Why the log cannot be replayed, if it cannot.
    failed: Option<String>,
}

impl Recording {
    /// Begins the log that was asked for.
    pub(super) fn start(
        source: &Source,
        options: &Options<'_>,
        mode: &Mode,
    ) -> Result<Option<(Self, Tape)>, SessionError> {
        let Some(path) = options.record else { return Ok(None) };
        regular::exists(path).map_err(|e| SessionError::Record(no_log(path, &e)))?;
        let header = Header {
            program: concat!("redrt ", env!("CARGO_PKG_VERSION")).to_owned(),
            capacities: Header::capacities_of::<Robot>(),
            policy: options.policy.name().to_owned(),
            duration_ns: options.duration_ns,
            realtime: matches!(mode, Mode::RealTime { .. }),
            file: source.path().to_string_lossy().into_owned(),
            format: match source.format {
                Format::Toml => "toml",
                Format::Yaml => "yaml",
            }
            .to_owned(),
            workload: source.text().to_owned(),
            config: None,
        };
        let (writer, tape) = Writer::start(path, &header).map_err(|e| not_begun(path, e))?;
        Ok(Some((Self { path: path.to_owned(), writer }, tape)))
    }

    /// Waits for the last byte; the run has ended. On a slow disk that takes a while.
    pub(super) fn finish(self) -> ClosedLog {
        let (totals, failed) = progress::during("writing the log", || self.writer.finish());
        ClosedLog { totals, path: self.path, failed }
    }
}

impl ClosedLog {
    pub(super) fn summary(&self) -> LogSummary {
        let Totals { entries, dropped, bytes, .. } = self.totals;
        LogSummary { inputs: entries, dropped, bytes, failed: self.why() }
    }

    /// Why it cannot be replayed, if it cannot.
    fn why(&self) -> Option<String> {
        let cut = self.totals.cut?;
        Some(match &self.failed {
            Some(e) => format!("{cut}: {e}"),
            None => cut.to_string(),
        })
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// What became of it, in words.
    pub(crate) fn words(&self) -> String {
        let (Totals { entries, dropped, bytes, cut }, path) = (self.totals, shown_path(&self.path));
        match (self.why(), cut) {
            (Some(why), Some(cut)) => format!(
                "log: {path} has the first {entries} inputs; {dropped} more were dropped ({why}), so it cannot be \
                 replayed to the end; {}",
                cut.cure()
            ),
            _ => format!("log: {path} ({entries} inputs, {bytes} bytes; `redrt replay` feeds them again)"),
        }
    }

    /// A log that cannot be replayed was asked for in vain.
    ///
    /// # Errors
    /// [`Failure::Machine`] with the reason.
    pub(crate) fn is_whole(&self) -> Result<(), Failure> {
        match self.why() {
            Some(why) => Err(Failure::Machine(format!("`{}` is not whole: {why}", shown_path(&self.path)))),
            None => Ok(()),
        }
    }
}

/// The place is the user's, threads are the machine's.
fn not_begun(path: &Path, error: StartError) -> SessionError {
    match error {
        StartError::File(e) => SessionError::Record(no_log(path, &e)),
        thread => SessionError::Recorder(thread),
    }
}

pub(crate) fn no_log(path: &Path, error: &std::io::Error) -> String {
    format!(
        "cannot write the log to `{}`: {error}; expected a file in a folder that takes it",
        shown_path(path)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_place_is_the_users_fault_and_a_thread_the_machines() {
        let error = |of: fn(Error) -> StartError| {
            not_begun(Path::new("a.redlog"), of(Error::from(ErrorKind::WouldBlock)))
        };
        assert_eq!(error(StartError::File).exit_code(), 2);
        let thread = error(StartError::Thread);
        assert!(thread.exit_code() == 3 && thread.to_string().contains("ulimit -u"), "{thread}");
    }
}
