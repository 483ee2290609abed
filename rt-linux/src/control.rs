//! A run that goes on, as threads that are no lanes see it: they release, stop, and have errands run.

use crate::errands::Undone;
use crate::placement;
use crate::shared::{DEPTH, PRODUCERS, Shared};
use crate::timeline::Host;
use core::cell::Cell;
use core::fmt;
use core::sync::atomic::{AtomicUsize, Ordering};
use nix::errno::Errno;
use nix::unistd::Pid;
use red_core::{Capacity, Instant, Scheduler, TaskId};
use red_record::Recorder;
use red_sync::{Exclusive, Post, Request};
use std::process;
use std::sync::PoisonError;

/// What is to be done under the scheduler's lock, once. It gets the scheduler and the time of the run, and leaves what
/// it finds in what it has captured.
///
/// All lanes may wait for it: it has to be short and bounded, and must not allocate, free, wait or log. It may change
/// graphs, add and remove tasks, release, and look at everything; the host is not told of what it releases.
pub type Errand<C> = Box<dyn for<'a> FnMut(&mut Recorder<'a, C>, Instant) + Send>;

/// An errand on its way to a lane and back.
pub(crate) struct Letter<C: Capacity> {
    pub(crate) errand: Errand<C>,
    /// What it said when it panicked.
    pub(crate) panic: Option<String>,
}

/// A run that goes on: what other threads may ask of it. It may be kept after the end, and then refuses.
pub trait Control<C: Capacity>: Send + Sync {
    /// Releases a job from outside of the lanes, with the frame that it reads, as in [`Scheduler::release_at`]. From
    /// any thread, also from a node's body. A stop that comes later drops what no lane came to, as it does with jobs.
    /// Requests of one thread are taken in their order, as long as at most eight threads of the process ever release;
    /// of more, one that meets another in the middle of its call may find its next request taken first.
    ///
    /// Time bound: wait-free; one system call if a lane has to be woken.
    ///
    /// # Errors
    /// [`Refused`]; nothing is released then.
    fn release(&self, task: TaskId, capture: Option<u64>) -> Result<(), Refused>;

    /// Has `errand` run once by the next lane that has a turn, and returns it. What it changed is dispatched in the
    /// same turn. When this returns, the errand does not run and will not, whatever it returns.
    ///
    /// Time bound: none; it sleeps until a lane comes, which is at the end of a body if all are busy, or until the run
    /// ends, and before that until the threads that asked earlier are done.
    ///
    /// Lanes begin after `started` has returned ([`run`](crate::runtime::run)). A body must not wait for another thread
    /// that asks, either: where its lane is the only one, its bound passes.
    ///
    /// # Errors
    /// [`AskError`]. The errand was dropped on this thread then, unless it was lost.
    fn ask(&self, errand: Errand<C>) -> Result<Errand<C>, AskError>;

    /// Ends the run in order: nothing is released any more and no lane takes another unit, bodies that run are waited
    /// for. Again, or after the end, it changes nothing. From any thread, a node's body, an errand, or a signal
    /// handler: async-signal-safe and wait-free.
    fn stop(&self);

    /// Nanoseconds since the start of the run.
    fn now_ns(&self) -> u64;

    /// The start of the run, in nanoseconds of `CLOCK_MONOTONIC`.
    fn origin_ns(&self) -> u64;
}

/// A release was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// The thread's mailbox is full: no lane came to its last requests. The caller erred, or the machine is too slow:
    /// release less often.
    Full,
    /// All mailboxes are being posted to at this very moment: nobody erred. Try again.
    Busy,
    /// The duration is over or a stop was asked for.
    Over,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the mailbox is full, because no lane came to it; release less often",
            Self::Busy => "all mailboxes are being posted to at this moment; try again",
            Self::Over => "the duration is over, or a stop was asked for",
        })
    }
}

impl core::error::Error for Refused {}

/// An errand was not run, or not to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AskError {
    /// The calling thread is one that the run needs, which could wait for itself: a lane, also inside of a body or an
    /// errand, or the one that called [`run`](crate::runtime::run). The caller erred: ask from another thread.
    OnLane,
    /// The run has ended, or ended before a lane took the errand, which was not begun.
    Over,
    /// The errand panicked with these words, and may be half done. Its author erred.
    Panicked(String),
    /// The thread of a lane was killed in the middle of the errand. The scheduler's lock went with it: end the process,
    /// where the C library has not done so, which lets nobody wait for a lock of the dead.
    Lost,
}

impl fmt::Display for AskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnLane => {
                f.write_str("a lane, or the thread that runs the run, asked; ask from another thread")
            }
            Self::Over => f.write_str("the run ended before a lane took the errand"),
            Self::Panicked(said) => write!(f, "the errand panicked: {said}"),
            Self::Lost => f.write_str("a lane's thread was killed in the errand; end the process"),
        }
    }
}

impl core::error::Error for AskError {}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>> + Send + Sync> Control<C> for Shared<C, H, L> {
    fn release(&self, task: TaskId, capture: Option<u64>) -> Result<(), Refused> {
        let post = self.place().ok_or(Refused::Busy)?;
        // Asked with the place in hand, so that the end of the run can wait for it.
        let now = self.waiting.now();
        if now >= self.until_ns || self.waiting.is_stopping() {
            return Err(Refused::Over);
        }
        let posted = post.push(Request { task, at: Instant::from_nanos(now), capture });
        // Who is woken may be on this CPU, and post as well.
        drop(post);
        self.waiting.knock();
        posted.map_err(|_| Refused::Full)
    }

    fn ask(&self, errand: Errand<C>) -> Result<Errand<C>, AskError> {
        if Needed::is_this_thread() {
            return Err(AskError::OnLane);
        }
        let _turn = self.askers.lock().unwrap_or_else(PoisonError::into_inner);
        let letter = Letter { errand, panic: None };
        let has_ended =
            |thread: u32| placement::cpus_of(Pid::from_raw(thread.cast_signed())).err() == Some(Errno::ESRCH);
        match self.errands.ask(letter, || self.waiting.knock(), has_ended) {
            Ok(Letter { errand, panic: None }) => Ok(errand),
            Ok(Letter { panic: Some(said), .. }) => Err(AskError::Panicked(said)),
            Err(Undone::Over(_)) => Err(AskError::Over),
            Err(Undone::Lost) => Err(AskError::Lost),
        }
    }

    fn stop(&self) {
        // A signal may come between a failed call and the look at errno.
        let errno = Errno::last_raw();
        self.end();
        self.stopper.ask();
        Errno::set_raw(errno);
    }

    fn now_ns(&self) -> u64 {
        self.waiting.now()
    }

    fn origin_ns(&self) -> u64 {
        self.waiting.origin_ns()
    }
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Shared<C, H, L> {
    /// The first mailbox that nobody posts to, from the calling thread's own on: a thread that lost its CPU in the
    /// middle keeps its place.
    fn place(&self) -> Option<Post<'_, Request, DEPTH>> {
        let own = OWN_PLACE.with(|own| *own);
        { 0..PRODUCERS }.find_map(|other| self.scheduler.producer((own + other) % PRODUCERS))
    }
}

/// The next thread that releases posts here.
static NEXT_PLACE: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// A place of its own for each of the first threads, so that their requests stay in order.
    static OWN_PLACE: usize = NEXT_PLACE.fetch_add(1, Ordering::Relaxed) % PRODUCERS;
    /// The process of which a run needs this thread. A child of `fork` has the thread and not the run.
    static NEEDED_BY: Cell<Option<u32>> = const { Cell::new(None) };
}

/// While it lives, the calling thread is one without which a run does not go on, so it waits for no lane.
pub(crate) struct Needed(Option<u32>);

impl Needed {
    pub(crate) fn by_a_run() -> Self {
        Self(NEEDED_BY.replace(Some(process::id())))
    }

    fn is_this_thread() -> bool {
        NEEDED_BY.get() == Some(process::id())
    }
}

impl Drop for Needed {
    fn drop(&mut self) {
        NEEDED_BY.set(self.0);
    }
}

#[cfg(test)]
mod tests;
