//! Whether this machine grants real time.

use red_rt::placement::{choose_cpus, usable_cpus};
use red_rt::setup::{Fifo, SetupError, lock_memory};
use std::env;
use std::thread;

/// Of the lanes, as `redrt run` has them.
pub(crate) const PRIORITY: u8 = 70;

/// How many CPUs there are for lanes in real time: one stays free, so that the machine stays usable. The memory of this
/// process is locked from then on.
pub(crate) fn granted() -> Result<usize, SetupError> {
    let usable = usable_cpus()?;
    let cpu = choose_cpus(1, &usable)?[0];
    // Asked for on a thread of its own, so that this one stays as it is.
    let asked = thread::spawn(move || Fifo { priority: PRIORITY, cpu }.apply().and_then(|()| lock_memory()));
    asked.join().unwrap_or(Ok(()))?;
    Ok(usable.len().saturating_sub(1).max(1))
}

/// What is missing, with a fix for this program.
pub(crate) fn told(error: &SetupError) -> String {
    let program =
        env::current_exe().map_or_else(|_| "red-soak".to_owned(), |path| path.display().to_string());
    error.to_string().replace("$(which redrt)", &program)
}
