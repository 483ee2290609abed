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
/// Bodies that hang in a workload. With the threads that die they stay far below what a run gives up at.
const MOST_HANGS: u64 = 3;

/// What the bodies of a workload did.
#[derive(Debug, Default)]
pub(crate) struct Tried {
    pub(crate) ran: AtomicU64,
    pub(crate) failed: AtomicU64,
    pub(crate) panicked: AtomicU64,
    pub(crate) died: AtomicU64,
    hung: AtomicU64,
    /// Bodies that failed or panicked, by the thread.
    wrong: Mutex<Vec<Arc<AtomicU64>>>,
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

    /// Bodies that failed or panicked and of which nobody tells, at most, where so many threads were lost.
    pub(crate) fn untold(&self, threads: u64) -> u64 {
        let by_thread = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        let mut by_thread: Vec<u64> = by_thread.iter().map(|wrong| wrong.load(Ordering::Relaxed)).collect();
        by_thread.sort_unstable();
        by_thread.iter().rev().zip(0..threads).map(|(wrong, _)| wrong).sum()
    }

    fn may_die(&self) -> bool {
        is_one_more(&self.died, MOST_DEATHS)
    }

    fn may_hang(&self) -> bool {
        is_one_more(&self.hung, MOST_HANGS)
    }

    fn begins(&self, work: &Work) {
        self.ran.fetch_add(1, Ordering::Relaxed);
        let name = (work.task.index(), work.job, work.node.index());
        if !self.begun.lock().unwrap_or_else(PoisonError::into_inner).insert(name) {
            self.twice.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(*work);
        }
    }
}

/// Counts, up to a bound: whether there was room for one more.
fn is_one_more(count: &AtomicU64, most: u64) -> bool {
    let more = |count| (count < most).then_some(count + 1);
    count.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).is_ok()
}

/// The bodies as one thread of a lane runs them.
pub(crate) struct Bodies {
    seed: u64,
    tried: Arc<Tried>,
    /// Whether they keep their CPU.
    spins: bool,
    /// Whether threads die in them.
    dies: bool,
    /// Those of this thread that failed or panicked.
    wrong: Arc<AtomicU64>,
}

impl Bodies {
    /// For a thread that begins.
    pub(crate) fn of(seed: u64, tried: Arc<Tried>, spins: bool, dies: bool) -> Self {
        let wrong = Arc::<AtomicU64>::default();
        tried.wrong.lock().unwrap_or_else(PoisonError::into_inner).push(wrong.clone());
        Self { seed, tried, spins, dies, wrong }
    }

    fn goes_wrong(&self, how: &AtomicU64) {
        how.fetch_add(1, Ordering::Relaxed);
        self.wrong.fetch_add(1, Ordering::Relaxed);
    }

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
        let node = (work.task.index() as u64) << 8 | work.node.index() as u64;
        let mut rng = Rng::new(self.seed ^ work.job.rotate_left(20) ^ node.rotate_left(48));
        let took = Duration::from_nanos(work.wcet_ns * rng.within(0, 90) / 100);
        match rng.within(0, 1_999) {
            0..3 => {
                self.goes_wrong(&tried.failed);
                return Err(Failed);
            }
            3..6 => {
                self.goes_wrong(&tried.panicked);
                panic!("planted");
            }
            6..9 if work.wcet_ns < HANGS_NS && tried.may_hang() => self.pass(HANG),
            9..19 if self.dies && tried.may_die() => end_this_thread(),
            _ => self.pass(took),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
