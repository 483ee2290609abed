//! The dispatcher: takes letters, asks the scheduler, hands units to lanes, sleeps.

use core::cell::RefCell;
use core::fmt;
use core::future::poll_fn;
use core::task::Poll;

use critical_section::Mutex;
use embassy_executor::Metadata;
use red_core::{Action, Capacity, Config, Empty, Instant, Outcome, Scheduler, TaskId, UnitId};
use red_sync::Mailbox;

use crate::clock;
use crate::handler::Handler;

/// Deadline of who schedules: before all bodies.
pub(crate) const AT_ONCE: u64 = 0;

/// A scheduler whose lanes are tasks of embassy, with room for `DEPTH` releases by interrupts that the dispatcher has
/// not seen yet. See the crate.
pub struct Dispatcher<C: Capacity, const DEPTH: usize = 16> {
    letters: Mailbox<Letter, DEPTH>,
    board: Mutex<RefCell<Board<C>>>,
}

/// A release, asked for from outside. Plain numbers, so that an empty mailbox is all zero.
struct Letter {
    task: TaskId,
    at: Instant,
}

/// What dispatcher and lanes share.
pub(crate) struct Board<C: Capacity> {
    pub(crate) scheduler: Scheduler<C>,
    /// What each lane was given and has not taken yet.
    pub(crate) seats: C::Lanes<UnitId>,
    pub(crate) lanes: C::Lanes<Handler>,
    dispatcher: Handler,
    lost_releases: u32,
}

/// A release could not be posted. It is counted in [`Dispatcher::lost_releases`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PostError {
    /// The dispatcher has not taken the last `DEPTH` releases yet: it needs a larger `DEPTH`, or bodies that give way
    /// sooner.
    Full,
}

impl fmt::Display for PostError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("The dispatcher has not taken the last releases yet: give it a larger DEPTH, or bodies that give way sooner.")
    }
}

impl core::error::Error for PostError {}

impl<C: Capacity, const DEPTH: usize> Dispatcher<C, DEPTH> {
    /// Bytes of a dispatcher: scheduler, mailbox and what lanes share.
    pub const SIZE: usize = size_of::<Self>();

    /// A dispatcher without lanes. All its bits are 0, so that a `static` lies in `.bss`: this is why the
    /// configuration comes later.
    #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
    pub const fn new() -> Self {
        let board = Board {
            scheduler: Scheduler::EMPTY,
            seats: Empty::EMPTY,
            lanes: Empty::EMPTY,
            dispatcher: Handler::EMPTY,
            lost_releases: 0,
        };
        Self { letters: Mailbox::new(), board: Mutex::new(RefCell::new(board)) }
    }

    /// Sets the scheduler up, before tasks are added; everything it held is forgotten. Nobody can take a lane from a
    /// body here, so `preempt` is off.
    pub fn configure(&self, config: Config) {
        self.lock(|board| board.scheduler.configure(Config { preempt: false, ..config }));
    }

    /// Runs `f` with the scheduler, in a critical section: to add pools and tasks, to edit, to ask. Not from inside
    /// another call of this.
    pub fn with<R>(&self, f: impl FnOnce(&mut Scheduler<C>) -> R) -> R {
        self.lock(|board| {
            let answer = f(&mut board.scheduler);
            // Something may have changed that it has to look at.
            board.dispatcher.wake();
            answer
        })
    }

    /// Releases a job of `task` now; from interrupts and from tasks. Time bound: O(1), one letter and one wake.
    ///
    /// # Errors
    /// [`PostError::Full`].
    pub fn release_from_interrupt(&self, task: TaskId) -> Result<(), PostError> {
        let letter = Letter { task, at: clock::now() };
        self.lock(|board| {
            // Inside a critical section nobody else has the post.
            let posted = self.letters.claim().is_some_and(|post| post.push(letter).is_ok());
            if !posted {
                board.lost_releases = board.lost_releases.saturating_add(1);
                return Err(PostError::Full);
            }
            board.dispatcher.wake();
            Ok(())
        })
    }

    /// Releases that found no place, in the mailbox or in the scheduler.
    pub fn lost_releases(&self) -> u32 {
        self.lock(|board| board.lost_releases)
    }

    /// Dispatches for ever; `ended` sees how each job ended. To be awaited by one task of embassy alone.
    pub async fn run(&'static self, mut ended: impl FnMut(&Outcome)) -> ! {
        Metadata::for_current_task().await.set_deadline(AT_ONCE);
        poll_fn(|context| {
            self.lock(|board| board.dispatcher = Handler::current(context));
            Poll::Ready(())
        })
        .await;
        loop {
            self.take_letters(&mut ended);
            while let Some(outcome) = self.dispatch() {
                ended(&outcome);
            }
            self.sleep().await;
        }
    }

    pub(crate) fn lock<R>(&self, f: impl FnOnce(&mut Board<C>) -> R) -> R {
        critical_section::with(|cs| f(&mut self.board.borrow_ref_mut(cs)))
    }

    /// Applies what was posted: at most `DEPTH` letters, so that who keeps posting cannot keep the dispatcher.
    fn take_letters(&self, ended: &mut impl FnMut(&Outcome)) {
        for _ in 0..DEPTH {
            let Some(Letter { task, at }) = self.letters.pop() else { return };
            let outcome = self.lock(|board| {
                let released = board.scheduler.release_at(task, at, None, clock::now());
                board.lost_releases = board.lost_releases.saturating_add(u32::from(released.is_err()));
                // Of a job whose place it took: the next release may take another's.
                board.scheduler.take_outcome()
            });
            outcome.iter().for_each(&mut *ended);
        }
    }

    /// Hands out units until nothing is left to do, or a job ended. One critical section each: interrupts come between.
    fn dispatch(&self) -> Option<Outcome> {
        loop {
            let action = self.lock(|board| {
                let action = board.scheduler.poll(clock::now());
                if let Some(Action::Dispatch(started)) = action {
                    let lane = started.lane.index();
                    board.seats[lane] = started.unit;
                    board.lanes[lane].wake();
                }
                action
            });
            if let Action::Ended(outcome) = action? {
                return Some(outcome);
            }
        }
    }

    /// Until somebody wakes the dispatcher, or its time comes. Who wakes it while it works has it run once more.
    async fn sleep(&self) {
        let mut slept = false;
        poll_fn(|context| {
            if slept {
                return Poll::Ready(());
            }
            slept = true;
            if let Some(at) = self.lock(|board| board.scheduler.poll_at()) {
                embassy_time_driver::schedule_wake(clock::ticks_until(at), context.waker());
            }
            Poll::Pending
        })
        .await;
    }
}

impl<C: Capacity, const DEPTH: usize> fmt::Debug for Dispatcher<C, DEPTH> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Dispatcher").finish_non_exhaustive()
    }
}
