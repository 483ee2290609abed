//! The log of a run: begun before real time starts, closed after it.

use super::{Options, Robot, SessionError};
use crate::regular;
use red_record::{Header, Tape, Totals, Writer};
use red_rt::runtime::Mode;
use red_workload::{Format, Source, shown_path};
use std::path::{Path, PathBuf};

/// A log that is being written.
pub(crate) struct Recording {
    path: PathBuf,
    writer: Writer,
}

/// A log that is closed.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub(crate) totals: Totals,
    path: PathBuf,
    failed: Option<std::io::Error>,
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
        };
        let (writer, tape) =
            Writer::start(path, &header).map_err(|e| SessionError::Record(no_log(path, &e)))?;
        Ok(Some((Self { path: path.to_owned(), writer }, tape)))
    }

    /// Waits for the last byte; the run has ended.
    pub(super) fn finish(self) -> Recorded {
        let (totals, failed) = self.writer.finish();
        Recorded { totals, path: self.path, failed }
    }
}

impl Recorded {
    /// What became of it, in words.
    pub(crate) fn words(&self) -> String {
        let (Totals { entries, dropped, bytes }, path) = (self.totals, shown_path(&self.path));
        let why = match &self.failed {
            Some(e) => format!("{e}"),
            None => "the disk did not keep up".to_owned(),
        };
        match dropped {
            0 if self.failed.is_none() => {
                format!("log: {path} ({entries} inputs, {bytes} bytes; `redrt replay` feeds them again)")
            }
            _ => format!(
                "log: {path} has the first {entries} inputs; {dropped} more were dropped ({why}), so it cannot be \
                 replayed; record to a larger or faster disk"
            ),
        }
    }
}

pub(crate) fn no_log(path: &Path, error: &std::io::Error) -> String {
    format!(
        "cannot write the log to `{}`: {error}; expected a file in a folder that takes it",
        shown_path(path)
    )
}
