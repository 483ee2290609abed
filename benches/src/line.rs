//! A word on cache lines of its own: how threads of a measurement signal to each other.

use std::hint;
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest spin for one signal, in turns: about a second. Only a thread that is gone takes that long.
const TURNS: u32 = 20_000_000;

/// A word on a pair of cache lines of its own, because the prefetcher fetches pairs. 0 is no signal.
#[repr(align(128))]
#[derive(Default)]
pub(crate) struct Line(AtomicU64);

impl Line {
    pub(crate) fn store(&self, word: u64) {
        self.0.store(word, Ordering::Release);
    }

    pub(crate) fn load(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }

    /// Takes the signal, if there is one. Nobody may store between one signal and its being taken.
    #[inline(always)]
    pub(crate) fn take(&self) -> Option<u64> {
        let word = self.load();
        if word == 0 {
            return None;
        }
        self.0.store(0, Ordering::Relaxed);
        Some(word)
    }

    /// Spins until `seen` answers; `None` when the other thread is gone.
    #[inline(always)]
    pub(crate) fn spin<R>(&self, seen: impl Fn(&Self) -> Option<R>) -> Option<R> {
        for _ in 0..TURNS {
            if let Some(answer) = seen(self) {
                return Some(answer);
            }
            hint::spin_loop();
        }
        None
    }
}
