//! Ctrl-C and SIGTERM as a bell, for a stop in order.

use core::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nix::errno::Errno;
use nix::sys::signal::{SigAction, Signal};

use crate::bell::Bell;
use crate::setup::SetupError;
use crate::sys;

/// What was in force before, and how many hold the handlers now.
static HELD: Mutex<Held> = Mutex::new(Held { holders: 0, previous: None });
static RECEIVED: AtomicI32 = AtomicI32::new(0);
static BELL: Bell = Bell::new();

struct Held {
    holders: usize,
    previous: Option<[(Signal, SigAction); 2]>,
}

fn held() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While one lives, SIGINT and SIGTERM ask for a stop instead of ending the process. Dropping the last one restores
/// what was there before.
///
/// Signal handlers are the process's, so several of these share them and the signal that came: a program that holds
/// one around all of its runs has no gap in which a signal would end it, and a signal in such a gap stops the next
/// run before it begins. It is forgotten when the last one is dropped. A second signal changes nothing; SIGQUIT
/// (Ctrl-\) still ends the process at once.
#[derive(Debug)]
pub struct StopSignals(());

impl StopSignals {
    /// Installs the handlers, unless another one holds them already.
    ///
    /// # Errors
    ///
    /// [`SetupError::System`] if the kernel refuses them.
    pub fn install() -> Result<Self, SetupError> {
        let mut held = held();
        if held.holders == 0 {
            RECEIVED.store(0, Ordering::Relaxed);
            BELL.take();
            held.previous = Some(catch().map_err(|errno| SetupError::System {
                call: "sigaction(SIGINT, SIGTERM)",
                errno,
                fix: "allow sigaction in the seccomp filter of the container",
            })?);
        }
        held.holders += 1;
        Ok(Self(()))
    }

    /// The signal that asked for the stop, if one did.
    #[must_use]
    pub fn requested(&self) -> Option<Signal> {
        // Relaxed: a flag on its own; who waited on the bell has synchronised through it.
        Signal::try_from(RECEIVED.load(Ordering::Relaxed)).ok()
    }

    /// Rung by each signal. One thread at a time may wait on it, and looks at [`StopSignals::requested`] before: the
    /// ring of an earlier signal may have been taken by an earlier waiter.
    #[must_use]
    pub fn bell(&self) -> &'static Bell {
        &BELL
    }
}

impl Drop for StopSignals {
    fn drop(&mut self) {
        let mut held = held();
        held.holders -= 1;
        if held.holders == 0 {
            for (signal, previous) in held.previous.take().iter().flatten() {
                sys::restore(*signal, previous);
            }
        }
    }
}

/// Both handlers, or none.
fn catch() -> Result<[(Signal, SigAction); 2], Errno> {
    let interrupt = sys::catch(Signal::SIGINT)?;
    let terminate = sys::catch(Signal::SIGTERM).inspect_err(|_| sys::restore(Signal::SIGINT, &interrupt))?;
    Ok([(Signal::SIGINT, interrupt), (Signal::SIGTERM, terminate)])
}

/// Called inside the signal handler: async-signal-safe.
pub(crate) fn received(signal: i32) {
    RECEIVED.store(signal, Ordering::Relaxed);
    BELL.ring();
}

#[cfg(test)]
mod tests;
