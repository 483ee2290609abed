//! Other programs: run where one can see them, or for their output.

use std::ffi::OsStr;
use std::fmt;
use std::io::{self, BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};

use crate::report::Tally;

/// Why a step failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A program could not be started.
    Start { command: String, reason: io::Error },
    /// A program ended with another status than 0.
    Status { command: String, status: ExitStatus, tally: Tally },
    /// A tool is missing and cannot be had without asking.
    Missing { what: &'static str, install: String },
    /// A file could not be read or written.
    File { path: String, reason: io::Error },
    /// A folder for what is installed cannot be written.
    Unwritable { path: String, reason: io::Error },
    /// The workspace is not as the step wants it.
    Wrong(String),
}

impl Failure {
    /// Of a file, with why it cannot be read or written.
    pub(crate) fn of_file(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |reason| Self::File { path: path.display().to_string(), reason }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start { command, reason } => write!(f, "cannot start `{command}`: {reason}"),
            Self::Status { command, status, .. } => write!(f, "`{command}`: {status}"),
            Self::Missing { what, install } => write!(f, "{what} is missing; install it with: {install}"),
            Self::File { path, reason } => write!(f, "{path}: {reason}"),
            Self::Unwritable { path, reason } => {
                write!(f, "cannot write below {path}: {reason}; give a --prefix that you may write to")
            }
            Self::Wrong(what) => f.write_str(what),
        }
    }
}

/// A program about to run.
pub(crate) struct Run(Command);

impl Run {
    pub(crate) fn new(program: &OsStr, folder: &Path) -> Self {
        let mut command = Command::new(program);
        command.current_dir(folder).stdin(Stdio::null());
        Self(command)
    }

    pub(crate) fn args(mut self, arguments: &[impl AsRef<OsStr>]) -> Self {
        self.0.args(arguments);
        self
    }

    pub(crate) fn env(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.0.env(name, value);
        self
    }

    /// In another folder.
    pub(crate) fn at(mut self, folder: &Path) -> Self {
        self.0.current_dir(folder);
        self
    }

    /// What it writes, to its standard error and then to its standard output, and whether it succeeded.
    ///
    /// # Errors
    /// It cannot be started.
    pub(crate) fn all_text(mut self) -> Result<(String, bool), Failure> {
        let command = self.line();
        let output = self.0.output().map_err(|reason| Failure::Start { command, reason })?;
        let text = [output.stderr, output.stdout].concat();
        Ok((String::from_utf8_lossy(&text).into_owned(), output.status.success()))
    }

    /// As [`Self::all_text`], of a program that has to succeed.
    ///
    /// # Errors
    /// It cannot be started, or it fails; then it is printed what it wrote.
    pub(crate) fn text(self) -> Result<String, Failure> {
        let command = self.line();
        say!("$ {command}");
        match self.all_text()? {
            (text, true) => Ok(text),
            (text, false) => {
                complain!("{text}");
                Err(Failure::Wrong(format!("`{command}` failed")))
            }
        }
    }

    /// Runs it for all to see, and counts the tests that it reports.
    ///
    /// # Errors
    /// It cannot be started, or it fails; then the tests that it reported are in the failure.
    pub(crate) fn stream(self) -> Result<Tally, Failure> {
        let command = self.line();
        let mut tally = Tally::default();
        let status = self.observe(|line| {
            say!("{line}");
            tally.read(line);
        })?;
        if status.success() { Ok(tally) } else { Err(Failure::Status { command, status, tally }) }
    }

    /// Becomes it: signals reach it alone, and its exit status is ours. Comes back if it cannot be started.
    pub(crate) fn replace(mut self) -> Failure {
        let command = self.line();
        say!("$ {command}");
        Failure::Start { command, reason: self.0.exec() }
    }

    /// Runs it, and gives each line of its standard output to `read`. How it ended is for the caller to judge.
    ///
    /// # Errors
    /// It cannot be started.
    pub(crate) fn observe(mut self, mut read: impl FnMut(&str)) -> Result<ExitStatus, Failure> {
        let command = self.line();
        say!("$ {command}");
        let start = |reason| Failure::Start { command: command.clone(), reason };
        let mut child = self.0.stdout(Stdio::piped()).spawn().map_err(start)?;
        if let Some(output) = child.stdout.take() {
            for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
                read(&String::from_utf8_lossy(&line));
            }
        }
        child.wait().map_err(start)
    }

    /// Its standard output; what it says besides is nobody's business.
    ///
    /// # Errors
    /// It cannot be started, or it fails.
    pub(crate) fn output(mut self) -> Result<String, Failure> {
        self.0.stderr(Stdio::null());
        self.capture()
    }

    /// Its standard output; what it says besides is for all to see.
    ///
    /// # Errors
    /// It cannot be started, or it fails.
    pub(crate) fn capture(self) -> Result<String, Failure> {
        self.bytes().map(|bytes| String::from_utf8_lossy(&bytes).trim().into())
    }

    /// Its standard output, as it is.
    ///
    /// # Errors
    /// It cannot be started, or it fails.
    pub(crate) fn bytes(mut self) -> Result<Vec<u8>, Failure> {
        let command = self.line();
        match self.0.output() {
            Err(reason) => Err(Failure::Start { command, reason }),
            Ok(output) if output.status.success() => Ok(output.stdout),
            Ok(output) => Err(Failure::Status { command, status: output.status, tally: Tally::default() }),
        }
    }

    /// What one would type, programs by their name alone.
    pub(crate) fn line(&self) -> String {
        let program = Path::new(self.0.get_program()).file_name().unwrap_or_default();
        let set = self.0.get_envs().filter_map(|(name, value)| {
            value.map(|value| format!("{}={:?}", name.display(), value.display().to_string()))
        });
        let arguments = self.0.get_args().map(|argument| argument.display().to_string());
        set.chain([program.display().to_string()]).chain(arguments).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests;
