//! The lanes of a runtime, from the call that starts them on: a stop that comes before they do waits for them.
//!
//! *Rule.* Of the starting thread that brings the lanes and of who stops meanwhile, the second to change the word does it.

use core::sync::atomic::{AtomicU8, Ordering};
use red_core::Capacity;
use red_rt::control::Control;
use std::sync::{Arc, OnceLock};

const IDLE: u8 = 0;
const STARTING: u8 = 1;
/// By who could not reach the lanes yet.
const STOPPED: u8 = 2;
const THERE: u8 = 3;

pub(crate) struct Lanes<C: Capacity> {
    word: AtomicU8,
    control: OnceLock<Arc<dyn Control<C>>>,
}

impl<C: Capacity> Lanes<C> {
    pub(crate) const fn new() -> Self {
        Self { word: AtomicU8::new(IDLE), control: OnceLock::new() }
    }

    /// Somebody starts them: [`Self::come`] or [`Self::fail`] follows. One thread at a time.
    pub(crate) fn begin(&self) {
        self.word.store(STARTING, Ordering::Relaxed);
    }

    /// They are there, and did not begin anything yet.
    pub(crate) fn come(&self, control: Arc<dyn Control<C>>) {
        let control = self.control.get_or_init(|| control);
        // Release: pairs with the Acquire in `stop`, so that the lanes are there.
        if self.word.swap(THERE, Ordering::Release) == STOPPED {
            control.stop();
        }
    }

    /// They do not come.
    pub(crate) fn fail(&self) {
        self.word.store(IDLE, Ordering::Relaxed);
    }

    /// The lanes that are there.
    pub(crate) fn get(&self) -> Option<&dyn Control<C>> {
        self.control.get().map(AsRef::as_ref)
    }

    /// Asks them to end; whether somebody started them. Async-signal-safe and wait-free.
    pub(crate) fn stop(&self) -> bool {
        // Acquire: pairs with the Release in `come`.
        match self.word.compare_exchange(STARTING, STOPPED, Ordering::Relaxed, Ordering::Acquire) {
            Ok(_) | Err(STOPPED) => true,
            Err(THERE) => {
                self.get().into_iter().for_each(Control::stop);
                true
            }
            Err(_) => false,
        }
    }
}

#[cfg(test)]
mod tests;
