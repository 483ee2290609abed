//! Bodies that sleep or spin for a part of their WCET, and now and then go wrong.

use crate::death::end_this_thread;
use red_rt::handler::{Failed, Handler, Work};
use red_tests::rng::Rng;
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// A body of this WCET at most hangs: past the bound of 10 times the WCET and 100 ms.
const HANGS_NS: u64 = 1_000_000;
const HANG: Duration = Duration::from_millis(140);
/// Threads that die in a workload: each keeps what it owns for ever.
const MOST_DEATHS: u64 = 3;

/// What the bodies of a workload did.
#[derive(Debug, Default)]
pub(crate) struct Tried {
    pub(crate) ran: AtomicU64,
    pub(crate) failed: AtomicU64,
    pub(crate) panicked: AtomicU64,
    pub(crate) died: AtomicU64,
    /// Task, job and node of each body that began.
    begun: Mutex<HashSet<(usize, u64, usize)>>,
    /// One that began a second time.
    twice: Mutex<Option<Work>>,
}

impl Tried {
    /// A body that was run twice for one sub-job.
    pub(crate) fn twice(&self) -> Option<Work> {
        *self.twice.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn may_die(&self) -> bool {
        let more = |died| (died < MOST_DEATHS).then_some(died + 1);
        self.died.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).is_ok()
    }

    fn begins(&self, work: &Work) {
        self.ran.fetch_add(1, Ordering::Relaxed);
        let name = (work.task, work.job, work.node.index());
        if !self.begun.lock().unwrap_or_else(PoisonError::into_inner).insert(name) {
            self.twice.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(*work);
        }
    }
}

/// The bodies as one lane runs them.
pub(crate) struct Bodies {
    pub(crate) seed: u64,
    pub(crate) tried: Arc<Tried>,
    /// Whether they keep their CPU.
    pub(crate) spins: bool,
    /// Whether threads die in them.
    pub(crate) dies: bool,
}

impl Bodies {
    fn pass(&self, time: Duration) {
        if !self.spins {
            return thread::sleep(time);
        }
        let until = Instant::now() + time;
        while Instant::now() < until {
            std::hint::spin_loop();
        }
    }
}

impl Handler for Bodies {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        let tried = &*self.tried;
        tried.begins(work);
        let node = (work.task as u64) << 8 | work.node.index() as u64;
        let mut rng = Rng::new(self.seed ^ work.job.rotate_left(20) ^ node.rotate_left(48));
        let took = Duration::from_nanos(work.wcet_ns * rng.within(0, 90) / 100);
        match rng.within(0, 1_999) {
            0..3 => {
                tried.failed.fetch_add(1, Ordering::Relaxed);
                return Err(Failed);
            }
            3..6 => {
                tried.panicked.fetch_add(1, Ordering::Relaxed);
                panic!("planted");
            }
            6..9 if work.wcet_ns < HANGS_NS => self.pass(HANG),
            9..19 if self.dies && tried.may_die() => end_this_thread(),
            _ => self.pass(took),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
