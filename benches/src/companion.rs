//! The second lane of a measurement: a pinned thread that spins while samples are taken and sleeps otherwise.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::machine::Machine;
use crate::not_run::NotRun;

/// Longest time that a companion spins for one call of [`Companion::beside`], and that its caller then waits.
const SPIN_LIMIT: Duration = Duration::from_secs(10);

/// A thread on the CPU of lane 1.
pub(crate) struct Companion {
    begin: Sender<()>,
    left: Receiver<()>,
    open: Arc<AtomicBool>,
}

impl Companion {
    /// Starts the thread, asleep. It calls `step` again and again during [`Self::beside`]; a step must be short.
    ///
    /// # Errors
    ///
    /// There is no second CPU, or the thread could not be moved to it.
    pub(crate) fn spawn(
        machine: &'static Machine,
        mut step: impl FnMut() + Send + 'static,
    ) -> Result<Self, NotRun> {
        machine.has_lanes(2)?;
        let (begin, begun) = channel::<()>();
        let (leave, left) = channel();
        let open = Arc::new(AtomicBool::new(false));
        let companion = Self { begin, left, open: Arc::clone(&open) };
        thread::spawn(move || {
            if machine.become_lane(1).is_err() || leave.send(()).is_err() {
                return;
            }
            while begun.recv().is_ok() {
                let start = Instant::now();
                while open.load(Ordering::Acquire) && start.elapsed() < SPIN_LIMIT {
                    for _ in 0..64 {
                        step();
                    }
                }
                if leave.send(()).is_err() {
                    return;
                }
            }
        });
        // A new thread begins on the CPU of its parent, where it would wait behind a parent that spins.
        companion.wait()?;
        Ok(companion)
    }

    fn wait(&self) -> Result<(), NotRun> {
        let silent = |_| NotRun::Failed("the thread of lane 1 did not answer".to_owned());
        self.left.recv_timeout(SPIN_LIMIT).map_err(silent)
    }

    /// Runs `work` while the companion spins; on return the companion sleeps.
    ///
    /// # Errors
    ///
    /// The companion has ended or did not stop.
    pub(crate) fn beside<R>(&self, work: impl FnOnce() -> R) -> Result<R, NotRun> {
        self.open.store(true, Ordering::Release);
        self.begin.send(()).map_err(|_| NotRun::Failed("the thread of lane 1 has ended".to_owned()))?;
        let result = work();
        self.open.store(false, Ordering::Release);
        self.wait()?;
        Ok(result)
    }
}
