//! One hand-off from lane to lane: half of a round trip between two pinned threads.

use std::hint;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::companion::Companion;
use crate::machine::Machine;
use crate::measure::{Entry, Runner, fill};
use crate::not_run::NotRun;

/// A way to hand over. A run is one round trip: two hand-offs.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    pub(crate) ours: bool,
    pub(crate) build: fn(&'static Machine) -> Result<Runner, NotRun>,
}

impl Contestant {
    /// This contestant at the start line.
    pub(crate) fn enter(&self, machine: &'static Machine) -> Entry {
        Entry { name: self.name.to_owned(), ours: self.ours, runner: (self.build)(machine) }
    }
}

/// The reference: nothing but a flag.
pub(crate) const BARE_FLAG: &str = "bare flag";

/// Ways to hand over that are measured.
pub(crate) const CONTESTANTS: &[Contestant] =
    &[Contestant { name: BARE_FLAG, ours: false, build: bare_flag }];

/// Longest spin for one answer, in turns: about a second. Only a thread that is gone takes that long.
const TURNS: u32 = 20_000_000;

/// One flag per direction, each on a pair of cache lines of its own, because the prefetcher fetches pairs.
#[repr(align(128))]
#[derive(Default)]
struct Line(AtomicU32);

#[derive(Default)]
struct Flags {
    there: Line,
    back: Line,
    lost: AtomicBool,
}

impl Flags {
    fn round_trip(&self, turn: u32) {
        self.there.0.store(turn, Ordering::Release);
        for _ in 0..TURNS {
            if self.back.0.load(Ordering::Acquire) == turn {
                return;
            }
            hint::spin_loop();
        }
        self.lost.store(true, Ordering::Relaxed);
    }

    fn answer(&self) {
        let turn = self.there.0.load(Ordering::Acquire);
        if turn != self.back.0.load(Ordering::Relaxed) {
            self.back.0.store(turn, Ordering::Release);
        }
        hint::spin_loop();
    }
}

fn bare_flag(machine: &'static Machine) -> Result<Runner, NotRun> {
    let flags = Arc::new(Flags::default());
    let companion = Companion::spawn(machine, {
        let flags = Arc::clone(&flags);
        move || flags.answer()
    })?;
    let mut turn = 0u32;
    Ok(Box::new(move |runs, samples| {
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    if !flags.lost.load(Ordering::Relaxed) {
                        turn = turn.wrapping_add(1);
                        flags.round_trip(turn);
                    }
                }
            });
        })?;
        if flags.lost.load(Ordering::Relaxed) {
            return Err(NotRun::Failed("the other lane did not answer a flag".to_owned()));
        }
        Ok(())
    }))
}
