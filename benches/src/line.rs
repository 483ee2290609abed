//! A word on cache lines of its own: how threads of a measurement signal to each other.

use std::hint;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// Longest spin for one signal, in turns: about a second. Only a thread that is gone takes that long.
const TURNS: u32 = 20_000_000;
const TURNS_TO_YIELD: u32 = 4_096;

/// A word on a pair of cache lines of its own, because the prefetcher fetches pairs. Each signal is another word;
/// the first is not 0.
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

    /// The signal, if it is another than `seen`, which becomes it. Taking a signal stores nothing, so the line
    /// changes its owner once per signal.
    #[inline(always)]
    pub(crate) fn news(&self, seen: &mut u64) -> Option<u64> {
        let word = self.load();
        let is_new = word != *seen;
        *seen = word;
        is_new.then_some(word)
    }

    /// Spins until there are news; `None` when the other thread is gone.
    #[inline(always)]
    pub(crate) fn wait(&self, seen: &mut u64) -> Option<u64> {
        for turn in 1..=TURNS {
            if let Some(word) = self.news(seen) {
                return Some(word);
            }
            hint::spin_loop();
            // Nothing measured takes so long; but where both threads have one CPU, the other one needs it.
            if turn.is_multiple_of(TURNS_TO_YIELD) {
                thread::yield_now();
            }
        }
        None
    }
}
