//! One scheduler for many lanes, the paper's global synchronizer. Lanes take the lock; everybody else
//! posts a request into a mailbox of its own, and the next lane that has the lock applies it. So all inputs have
//! one total order, that of the lock.

use crate::{Exclusive, Mailbox, Post};
use red_core::{Capacity, Instant, Scheduler, TaskId};

/// A release, asked for from outside of the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request {
    /// Whose job.
    pub task: TaskId,
    /// When it was released.
    pub at: Instant,
    /// The frame that it reads; `None` as in `release_at`.
    pub capture: Option<u64>,
}

/// A scheduler behind a lock, with mailboxes for `PRODUCERS` threads that are not lanes, `DEPTH` requests each.
///
/// ```
/// use red_core::{Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
/// use red_sync::{Request, SharedScheduler, TicketLock};
/// let mut dag = Dag::<Caps<1, 8, 4>>::new();
/// dag.add_node(Node::new(Wcet::from_millis(2)))?;
/// let mut scheduler = Scheduler::new(Config::REDRT);
/// let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50)))?;
/// let shared = SharedScheduler::<_, TicketLock<_>, 1, 8>::new(scheduler);
/// let camera = shared.producer(0).expect("free");            // a thread that is no lane
/// camera.push(Request { task, at: Instant::ZERO, capture: None }).expect("not full");
/// let first = shared.with(|scheduler, requests| {            // a lane
///     while let Some(r) = requests.next() {
///         scheduler.release_at(r.task, r.at, r.capture, Instant::ZERO).expect("room");
///     }
///     scheduler.poll(Instant::ZERO)
/// });
/// assert!(first.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SharedScheduler<C: Capacity, L, const PRODUCERS: usize, const DEPTH: usize> {
    lock: L,
    mailboxes: [Mailbox<Request, DEPTH>; PRODUCERS],
    capacity: core::marker::PhantomData<C>,
}

/// Takes requests out of all mailboxes, producer by producer.
#[derive(Debug)]
pub struct Requests<'a, const DEPTH: usize> {
    mailboxes: &'a [Mailbox<Request, DEPTH>],
    taken: usize,
}

impl<const DEPTH: usize> Requests<'_, DEPTH> {
    /// The next request. Who keeps posting cannot keep a lane: at most `DEPTH` are taken from each box.
    #[expect(clippy::should_implement_trait, reason = "the mailboxes are emptied, not iterated over")]
    pub fn next(&mut self) -> Option<Request> {
        loop {
            let (first, rest) = self.mailboxes.split_first()?;
            if self.taken < DEPTH
                && let Some(request) = first.pop()
            {
                self.taken += 1;
                return Some(request);
            }
            *self = Self { mailboxes: rest, taken: 0 };
        }
    }
}

impl<C: Capacity, L: Exclusive<Scheduler<C>>, const P: usize, const D: usize> SharedScheduler<C, L, P, D> {
    /// Shares a scheduler.
    pub fn new(scheduler: Scheduler<C>) -> Self {
        Self {
            lock: L::new(scheduler),
            mailboxes: core::array::from_fn(|_| Mailbox::new()),
            capacity: core::marker::PhantomData,
        }
    }

    /// The mailbox of a producer; `None` if there is no such one, or somebody has it.
    pub fn producer(&self, number: usize) -> Option<Post<'_, Request, D>> {
        self.mailboxes.get(number)?.claim()
    }

    /// Runs `f` alone with the scheduler and the requests that arrived.
    #[inline]
    pub fn with<R>(&self, f: impl FnOnce(&mut Scheduler<C>, &mut Requests<'_, D>) -> R) -> R {
        self.lock.with(|scheduler| f(scheduler, &mut Requests { mailboxes: &self.mailboxes, taken: 0 }))
    }
}

#[cfg(test)]
mod tests;
