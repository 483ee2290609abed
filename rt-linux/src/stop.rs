//! Who may stop a run in order: Ctrl-C and SIGTERM as a bell, and the caller.

use core::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nix::errno::Errno;
use nix::sys::signal::{SigAction, Signal};

use crate::bell::Bell;
use crate::report::Stopped;
use crate::setup::SetupError;
use crate::sys;

/// What was in force before, and how many hold the handlers now.
static HELD: Mutex<Held> = Mutex::new(Held { holders: 0, previous: None });
static RECEIVED: AtomicI32 = AtomicI32::new(0);
static BELL: Bell = Bell::new();

/// Who may stop a run before its time is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopBy {
    /// SIGINT and SIGTERM, whose handlers the run installs ([`StopSignals`]), and [`Control::stop`]. For a program that
    /// is its run; panics of bodies are kept from being printed ([`crate::panics`]).
    ///
    /// [`Control::stop`]: crate::control::Control::stop
    Signals,
    /// [`Control::stop`] alone: no signal handler and no panic hook is installed or touched. For a library in the
    /// process of somebody else.
    ///
    /// [`Control::stop`]: crate::control::Control::stop
    Caller,
}

/// What the control thread of a run sleeps on, and whether the run is to end.
#[derive(Debug)]
pub(crate) struct Stopper {
    /// Of the signal handlers, if the run has them: they know no other.
    of_signals: Option<&'static Bell>,
    own: Bell,
    is_asked: AtomicBool,
}

impl Stopper {
    pub(crate) fn new(signals: Option<&StopSignals>) -> Self {
        let of_signals = signals.map(StopSignals::bell);
        Self { of_signals, own: Bell::new(), is_asked: AtomicBool::new(false) }
    }

    /// Wakes the control thread for a stop. Async-signal-safe and wait-free.
    pub(crate) fn ask(&self) {
        // Relaxed: the ring publishes it.
        self.is_asked.store(true, Ordering::Relaxed);
        self.bell().ring();
    }

    /// Rung by whoever has something for the control thread, which alone waits on it.
    pub(crate) fn bell(&self) -> &Bell {
        self.of_signals.unwrap_or(&self.own)
    }

    /// Who asked for the stop, if somebody did.
    pub(crate) fn stopped(&self) -> Option<Stopped> {
        let signal = self.of_signals.and_then(|_| received_signal());
        let caller = self.is_asked.load(Ordering::Relaxed).then_some(Stopped::Caller);
        signal.map(|signal| Stopped::Signal(signal.as_str())).or(caller)
    }
}

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
        received_signal()
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

fn received_signal() -> Option<Signal> {
    // Relaxed: a flag on its own; who waited on the bell has synchronised through it.
    Signal::try_from(RECEIVED.load(Ordering::Relaxed)).ok()
}

/// Called inside the signal handler: async-signal-safe.
pub(crate) fn received(signal: i32) {
    RECEIVED.store(signal, Ordering::Relaxed);
    BELL.ring();
}

#[cfg(test)]
mod tests;
