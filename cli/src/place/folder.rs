//! A folder of files whose names are fixed.

use super::{Force, Place, Places};
use crate::outcome::Failure;
use red_workload::shown_path;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The folder of `redrt demo` and `redrt paper real`, whose files are theirs: they are written anew each time.
pub(crate) const OWN: &str = "redrt-demo";

/// The option that names it.
const OPTION: &str = "--out";

/// Places for files in one folder.
pub(crate) struct Folder {
    path: PathBuf,
    /// Of the command; what is outside of the folder goes through them too.
    pub(crate) places: Places,
    replaces: bool,
}

impl Folder {
    /// Makes the folder if it is not there. In one of another name than [`OWN`], files are replaced under `--force` only.
    ///
    /// # Errors
    /// [`Failure::Input`]: a file is in its way. [`Failure::Machine`]: it cannot be made.
    pub(crate) fn open(path: &Path, force: &Force) -> Result<Self, Failure> {
        fs::create_dir_all(path).map_err(|e| {
            let path = shown_path(path);
            let why = format!("cannot make the folder `{path}`: {e}; choose another folder with {OPTION}");
            match e.kind() {
                ErrorKind::AlreadyExists | ErrorKind::NotADirectory => Failure::Input(why),
                _ => Failure::Machine(why),
            }
        })?;
        let places = Places::new(force, Failure::Machine);
        Ok(Self { path: path.to_owned(), places, replaces: force.force || path == Path::new(OWN) })
    }

    /// The place of a file in it.
    ///
    /// # Errors
    /// As for [`Places::add`].
    pub(crate) fn add(&mut self, what: &'static str, name: &str) -> Result<Place, Failure> {
        self.places.insert(self.place(what, name))
    }

    /// The place of a log in it.
    ///
    /// # Errors
    /// As for [`Places::add_log`].
    pub(crate) fn add_log(&mut self, name: &str) -> Result<Place, Failure> {
        self.places.insert_log(self.place("log", name))
    }

    /// The place of a file that always has the same content; none where it is there and stays.
    ///
    /// # Errors
    /// As for [`Places::add`].
    pub(crate) fn add_constant(
        &mut self,
        what: &'static str,
        name: &str,
        content: &[u8],
    ) -> Result<Option<Place>, Failure> {
        let path = self.path.join(name);
        let has_its_size = |found: fs::Metadata| found.is_file() && found.len() == content.len() as u64;
        if fs::metadata(&path).is_ok_and(has_its_size) && fs::read(&path).is_ok_and(|found| found == content)
        {
            self.places.keep(what, path);
            return Ok(None);
        }
        self.add(what, name).map(Some)
    }

    fn place(&self, what: &'static str, name: &str) -> Place {
        let path = self.path.join(name);
        Place { what, option: OPTION, another: "folder", path, force: self.replaces }
    }
}
