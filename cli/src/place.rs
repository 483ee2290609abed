//! Files that a subcommand writes. Every one goes through here: none takes the place of an input, no two have one place, and
//! what is there already is replaced under `--force` only. All of that is said before any work begins.

mod folder;
mod found;
mod whole;

use crate::outcome::Failure;
use crate::regular;
pub(crate) use folder::{Folder, OWN};
use found::Found;
use red_rt::stop::StopSignals;
use red_workload::model::{Body, Node, Workload};
use red_workload::{Source, shown, shown_path};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// `--force`, of every subcommand with an output.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct Force {
    /// Replace outputs that are there already; inputs stay as they are in any case.
    #[arg(long)]
    force: bool,
}

/// What a workload file is called.
const WORKLOAD: &str = "workload file";

/// What tells that a file cannot be written: the input is at fault, or the machine.
type Fault = fn(String) -> Failure;

/// The outputs of a command, each held against its inputs and the outputs before.
pub(crate) struct Places {
    /// What each is, in words, and where.
    inputs: Vec<(String, PathBuf)>,
    taken: Vec<Place>,
    force: bool,
    fault: Fault,
}

/// Where one output goes.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    what: &'static str,
    option: &'static str,
    /// What the option chooses.
    another: &'static str,
    path: PathBuf,
    force: bool,
}

/// The outputs of a command that executes a workload. A place that takes no file is the fault of who named it.
pub(crate) fn beside(source: &Source, force: &Force) -> Places {
    Places::new(force, Failure::Input).but_workload(source)
}

impl Places {
    /// Those of a command without inputs. `fault` tells of a place that takes no file.
    pub(crate) fn new(force: &Force, fault: Fault) -> Self {
        Self { inputs: Vec::new(), taken: Vec::new(), force: force.force, fault }
    }

    /// Those of a command with this input too; `what` is what it is, in words.
    #[must_use]
    pub(crate) fn but(mut self, what: impl Into<String>, path: impl Into<PathBuf>) -> Self {
        self.keep(what, path);
        self
    }

    /// Those of a command with this workload too: its file and those of its bodies are inputs.
    #[must_use]
    pub(crate) fn but_workload(self, source: &Source) -> Self {
        let Workload { tasks, events, .. } = &source.workload;
        let nodes =
            tasks.iter().flat_map(|task| &task.nodes).chain(events.iter().flat_map(|event| &event.add));
        let bodies = nodes.flat_map(Node::parts).filter_map(|(name, part)| match &part.body {
            Body::Onnx { path } | Body::Plugin { path, .. } | Body::Cuda { module: path, .. } => {
                Some((name, path))
            }
            Body::None | Body::Spin { .. } => None,
        });
        bodies.fold(self.but(WORKLOAD, source.path()), |places, (name, path)| {
            places.but(format!("file of the body of `{}`", shown(&name)), source.folder().join(path))
        })
    }

    /// Keeps an input.
    fn keep(&mut self, what: impl Into<String>, path: impl Into<PathBuf>) {
        self.inputs.push((what.into(), path.into()));
    }

    /// The place of an output. `what` is what it is, in words, and `option` chooses another one.
    ///
    /// # Errors
    /// [`Failure::Input`]: it is an input, another output, or there already without `--force`. By `fault`: it takes no file.
    pub(crate) fn add(
        &mut self,
        what: &'static str,
        option: &'static str,
        path: &Path,
    ) -> Result<Place, Failure> {
        self.insert(Place { what, option, another: "name", path: path.to_owned(), force: self.force })
    }

    fn insert(&mut self, place: Place) -> Result<Place, Failure> {
        let Place { what, option, another, path, force } = &place;
        let cannot = |error| (self.fault)(place.cannot(&error));
        let found = found::at(path).map_err(&cannot)?;
        let shown = shown_path(path);
        if let Some((input, _)) = self.inputs.iter().find(|(_, input)| found::is_same(path, input)) {
            return Err(Failure::Input(format!(
                "{option} `{shown}` is the {input} itself, which stays as it is; choose another {another} for the {what}"
            )));
        }
        let shares = |other: &&Place| !found.is_stream() && found::is_same(path, &other.path);
        if let Some(other) = self.taken.iter().find(shares) {
            return Err(Failure::Input(format!(
                "{} `{}` and {option} `{shown}` are one file; give each a file of its own",
                other.option,
                shown_path(&other.path)
            )));
        }
        match found {
            Found::File if !force => {
                return Err(Failure::Input(format!(
                    "the {what} `{shown}` is there already; choose another {another} with {option}, or add `--force` to replace it"
                )));
            }
            Found::File | Found::Nothing => whole::probe(path).map_err(cannot)?,
            Found::Stream(_) => {}
        }
        self.taken.push(place.clone());
        Ok(place)
    }

    /// The place of a log, which grows while others go on: a file, and nothing else.
    ///
    /// # Errors
    /// As for [`Places::add`].
    pub(crate) fn add_log(&mut self, option: &'static str, path: &Path) -> Result<Place, Failure> {
        self.insert_log(Place {
            what: "log",
            option,
            another: "name",
            path: path.to_owned(),
            force: self.force,
        })
    }

    fn insert_log(&mut self, log: Place) -> Result<Place, Failure> {
        let _or_missing = regular::exists(&log.path).map_err(|error| (self.fault)(log.cannot(&error)))?;
        self.insert(log)
    }
}

impl Place {
    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all of it, or leaves what is there as it is. What is no file, such as a pipe, gets it as it comes.
    ///
    /// # Errors
    /// [`Failure::Machine`] with a cure.
    pub(crate) fn write(
        &self,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        // Ctrl-C comes before or after.
        let _held = StopSignals::install().ok();
        let written = match found::at(&self.path) {
            Ok(Found::Stream(stream)) => {
                stream.open(&self.path).and_then(|file| whole::filled(file, fill)).map(drop)
            }
            Ok(_) => whole::put(&self.path, self.force, fill),
            Err(error) => Err(error),
        };
        written.map_err(|error| Failure::Machine(self.cannot(&error)))
    }

    /// The same of a text.
    ///
    /// # Errors
    /// As for [`Place::write`].
    pub(crate) fn write_text(&self, text: &str) -> Result<(), Failure> {
        self.write(|file| file.write_all(text.as_bytes()))
    }

    /// A new and empty file for what is written little by little. What was there under `--force` is gone then.
    ///
    /// # Errors
    /// The file cannot be made.
    pub(crate) fn create(&self) -> io::Result<File> {
        let _or_missing = regular::exists(&self.path)?;
        if self.force && fs::symlink_metadata(&self.path).is_ok() {
            fs::remove_file(&self.path)?;
        }
        File::create_new(&self.path)
    }

    /// Takes a file of [`Place::create`] away again, of which nothing came.
    pub(crate) fn withdraw(&self) {
        let _gone = fs::remove_file(&self.path);
    }

    /// That it cannot be written, and what to do.
    pub(crate) fn cannot(&self, error: &io::Error) -> String {
        let Self { what, option, another, path, .. } = self;
        format!(
            "cannot write the {what} to `{}`: {error}; choose another {another} with {option}, where it can be written",
            shown_path(path)
        )
    }
}

#[cfg(test)]
mod tests;
