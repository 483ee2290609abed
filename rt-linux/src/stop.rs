//! Ctrl-C and SIGTERM as a bell, for a stop in order.

use core::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use nix::errno::Errno;
use nix::sys::signal::{SigAction, Signal};

use crate::bell::Bell;
use crate::setup::SetupError;
use crate::sys;

static INSTALLED: AtomicBool = AtomicBool::new(false);
static RECEIVED: AtomicI32 = AtomicI32::new(0);
static BELL: Bell = Bell::new();

/// While it lives, SIGINT and SIGTERM ask for a stop instead of ending the process. Dropping it restores what
/// was there before.
///
/// There is one per process, because signal handlers are the process's. A second signal changes nothing;
/// SIGQUIT (Ctrl-\) still ends the process at once.
#[derive(Debug)]
pub struct StopSignals {
    previous: [(Signal, SigAction); 2],
}

impl StopSignals {
    /// Installs the handlers.
    ///
    /// # Errors
    ///
    /// [`SetupError::System`] with `EBUSY` if they are installed already.
    pub fn install() -> Result<Self, SetupError> {
        let failed = |errno, fix| SetupError::System { call: "sigaction(SIGINT, SIGTERM)", errno, fix };
        // Acquire and Release: partners of each other, so that a later owner sees the handlers restored.
        if INSTALLED.swap(true, Ordering::Acquire) {
            return Err(failed(Errno::EBUSY, "drop the first StopSignals before installing a second"));
        }
        RECEIVED.store(0, Ordering::Relaxed);
        BELL.take();
        let install = || -> Result<Self, Errno> {
            let interrupt = sys::catch(Signal::SIGINT)?;
            let terminate =
                sys::catch(Signal::SIGTERM).inspect_err(|_| sys::restore(Signal::SIGINT, &interrupt))?;
            Ok(Self { previous: [(Signal::SIGINT, interrupt), (Signal::SIGTERM, terminate)] })
        };
        install().map_err(|errno| {
            INSTALLED.store(false, Ordering::Release);
            failed(errno, "allow sigaction in the seccomp filter of the container")
        })
    }

    /// The signal that asked for the stop, if one did.
    #[must_use]
    pub fn requested(&self) -> Option<Signal> {
        // Relaxed: a flag on its own; who waited on the bell has synchronised through it.
        Signal::try_from(RECEIVED.load(Ordering::Relaxed)).ok()
    }

    /// Rung by each signal. One thread may wait on it.
    #[must_use]
    pub fn bell(&self) -> &'static Bell {
        &BELL
    }
}

impl Drop for StopSignals {
    fn drop(&mut self) {
        for (signal, previous) in &self.previous {
            sys::restore(*signal, previous);
        }
        INSTALLED.store(false, Ordering::Release);
    }
}

/// Called inside the signal handler: async-signal-safe.
pub(crate) fn received(signal: i32) {
    RECEIVED.store(signal, Ordering::Relaxed);
    BELL.ring();
}

#[cfg(test)]
mod tests;
