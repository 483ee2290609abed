//! The log of a run: begun before real time starts, closed after it.

use super::{Options, Robot, SessionError};
use crate::outcome::Failure;
use crate::place::Place;
use crate::progress;
use red_record::{Header, StartError, Tape, Totals, Writer};
use red_rt::runtime::Mode;
use red_workload::{Format, Source, shown_path};
use serde::Serialize;
use std::path::Path;

/// A log that is being written.
pub(crate) struct Recording {
    place: Place,
    writer: Writer,
}

/// A log that is closed.
#[derive(Debug)]
pub(crate) struct ClosedLog {
    totals: Totals,
    place: Place,
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
        let Some(place) = options.record else { return Ok(None) };
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
        let file = place.create().map_err(|e| SessionError::Record(place.cannot(&e)))?;
        match Writer::start_in(file, &header) {
            Ok((writer, tape)) => Ok(Some((Self { place: place.clone(), writer }, tape))),
            Err(error) => {
                place.withdraw();
                Err(not_begun(place, error))
            }
        }
    }

    /// Waits for the last byte; the run has ended. On a slow disk that takes a while.
    pub(super) fn finish(self) -> ClosedLog {
        let (totals, failed) = progress::during("writing the log", || self.writer.finish());
        ClosedLog { totals, place: self.place, failed }
    }

    /// Takes the log of a run away that did not start.
    pub(super) fn give_up(self) {
        self.place.withdraw();
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
        self.place.path()
    }

    /// Takes it away: nothing ran.
    pub(super) fn withdraw(&self) {
        self.place.withdraw();
    }

    /// What became of it, in words.
    pub(crate) fn words(&self) -> String {
        let (Totals { entries, dropped, bytes, cut }, path) = (self.totals, shown_path(self.path()));
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
            Some(why) => Err(Failure::Machine(format!("`{}` is not whole: {why}", shown_path(self.path())))),
            None => Ok(()),
        }
    }
}

/// The place is the user's, threads are the machine's.
fn not_begun(place: &Place, error: StartError) -> SessionError {
    match error {
        StartError::File(e) => SessionError::Record(place.cannot(&e)),
        thread => SessionError::Recorder(thread),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::place::{Force, Places};
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_place_is_the_users_fault_and_a_thread_the_machines() {
        let path = std::env::temp_dir().join(format!("redrt-record-{}.redlog", std::process::id()));
        let place =
            Places::new(&Force::default(), Failure::Machine).add_log("--record", &path).expect("a folder");
        let error = |of: fn(Error) -> StartError| not_begun(&place, of(Error::from(ErrorKind::WouldBlock)));
        assert_eq!(error(StartError::File).exit_code(), 2);
        let thread = error(StartError::Thread);
        assert!(thread.exit_code() == 3 && thread.to_string().contains("ulimit -u"), "{thread}");
    }
}
