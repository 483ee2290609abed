//! A stand-in for `libcuda.so.1`, for tests on machines without a GPU: `driver/stand_in.h` says what it does.
//!
//! It is found by the loader's ordinary search path, so the shim under test is the one that ships. As a process reads that
//! path when it starts, a test that wants it runs once more in a process of its own ([`with`]).
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process, thread};

/// The folder of the stand-in.
pub const DRIVER: &str = env!("OUT_DIR");
/// The folder of one that lacks `cuStreamWaitEvent`, `cuGraphLaunch` and `cuGraphInstantiate`.
pub const LACKING: &str = concat!(env!("OUT_DIR"), "/lacking");

/// Set in the process of a test that has the stand-in.
const INSIDE: &str = "RED_STAND_IN_TEST";

/// One use of the stand-in: its script and its log.
#[derive(Debug)]
pub struct StandIn {
    driver: PathBuf,
    folder: PathBuf,
}

impl StandIn {
    /// With this script.
    ///
    /// # Panics
    /// No files can be written in the folder for temporary ones.
    #[must_use]
    pub fn new(script: &str) -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder = env::temp_dir().join(format!("red-stand-in-{}-{number}", process::id()));
        fs::create_dir_all(&folder).expect("the folder for temporary files takes folders");
        fs::write(folder.join("script"), script).expect("and files");
        Self { driver: DRIVER.into(), folder }
    }

    /// With another driver's folder, such as [`LACKING`].
    #[must_use]
    pub fn driver(mut self, folder: &Path) -> Self {
        folder.clone_into(&mut self.driver);
        self
    }

    /// Has `command` find the stand-in.
    pub fn give<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        let more = env::var("LD_LIBRARY_PATH").unwrap_or_default();
        command.env("LD_LIBRARY_PATH", format!("{}:{more}", self.driver.display()));
        command.env("RED_STAND_IN", self.folder.join("script"));
        command.env("RED_STAND_IN_LOG", self.log_path())
    }

    fn log_path(&self) -> PathBuf {
        self.folder.join("log")
    }

    /// What was called and what ran, line by line.
    #[must_use]
    pub fn log(&self) -> Vec<String> {
        let text = fs::read_to_string(self.log_path()).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }
}

impl Drop for StandIn {
    fn drop(&mut self) {
        let _left_there = fs::remove_dir_all(&self.folder);
    }
}

/// Has a test run with the stand-in: in a process of its own `inside` runs and this answers `None`; in the process that
/// started it, the log.
///
/// # Panics
/// `inside` did.
pub fn with(script: &str, inside: impl FnOnce()) -> Option<Vec<String>> {
    with_driver(Path::new(DRIVER), script, inside)
}

/// As [`with`], with the stand-in of another folder.
///
/// # Panics
/// `inside` did.
pub fn with_driver(driver: &Path, script: &str, inside: impl FnOnce()) -> Option<Vec<String>> {
    let this = thread::current();
    let test = this.name().expect("a test's thread has its name");
    if env::var_os(INSIDE).is_some() {
        inside();
        return None;
    }
    let stand_in = StandIn::new(script).driver(driver);
    let mut again = Command::new(env::current_exe().expect("this program"));
    again.args([test, "--exact", "--nocapture", "--include-ignored"]).env(INSIDE, "1");
    let Output { status, stdout, stderr } = stand_in.give(&mut again).output().expect("it runs again");
    let told = [stdout, stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(status.success() && told.contains("1 passed"), "{status}: {told}");
    Some(stand_in.log())
}
