//! The threads of lanes, the first ones and spares: how they start together, and what they tell when they end.

use crate::allowance::Allowance;
use crate::clock::now_ns;
use crate::control::Needed;
use crate::handler::Handler;
use crate::lane::Lane;
use crate::on_stream::Queue;
use crate::panics::caught;
use crate::preflight::RealTimeBudget;
use crate::report::LaneFigures;
use crate::runtime::{Enclose, Handlers, Mode};
use crate::setup::{Fifo, SetupError, best_effort, prefault_stack};
use crate::shared::Shared;
use crate::sleeper::Sleeper;
use crate::stop::Stopper;
use crate::timeline::Host;
use nix::sys::prctl::set_name;
use nix::unistd::{Pid, gettid};
use red_core::{Capacity, Scheduler};
use red_sync::Exclusive;
use std::ffi::CString;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

/// Bodies are prepared within this time.
const START_BOUND: Duration = Duration::from_secs(60);
/// Between two looks at a lane whose end is waited for.
const STOP_LOOK: Duration = Duration::from_millis(10);
/// A lane that runs no body ends within so many looks.
const STOP_LOOKS: u32 = 200;
/// Stack that a lane touches before real time starts.
const STACK: usize = 256 * 1024;

/// A lane's thread that sets itself up, and then waits to be told to go. Dropped, it ends.
pub(crate) struct Starting<S> {
    pub(crate) lane: usize,
    until: Instant,
    /// What came of its set-up: the kernel's number of it. Closed without, where it panicked.
    verdict: mpsc::Receiver<Result<Pid, SetupError>>,
    /// That number, once it is known.
    id: Option<Pid>,
    go: mpsc::Sender<Go<S>>,
    figures: mpsc::Receiver<LaneFigures>,
}

/// A thread for each lane.
pub(crate) type Lanes<C, H, L> = Vec<Starting<Shared<C, H, L>>>;

/// The run that a thread becomes part of, and its number among the threads of its lane.
struct Go<S> {
    shared: Arc<S>,
    thread: u64,
}

/// A lane's thread that is part of a run.
pub(crate) struct Started {
    pub(crate) lane: usize,
    thread: u64,
    /// What it measured, when it ends. Closed without, where it died.
    figures: mpsc::Receiver<LaneFigures>,
}

/// Starts the threads of lanes, the first ones and spares.
pub(crate) struct Starter {
    pub(crate) handlers: Arc<Handlers>,
    pub(crate) enclose: Arc<Enclose>,
    pub(crate) mode: Mode,
    /// Its bell is rung when a thread is set up, so that a spare need not wait for the next look.
    pub(crate) stopper: Arc<Stopper>,
}

impl Starter {
    pub(crate) fn start<C, H, L>(&self, lane: usize) -> Result<Starting<Shared<C, H, L>>, SetupError>
    where
        C: Capacity,
        H: Host<C> + 'static,
        L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
    {
        let (told, verdict) = mpsc::channel();
        let (go, is_to_go) = mpsc::channel::<Go<Shared<C, H, L>>>();
        let (finished, figures) = mpsc::channel();
        let (handlers, enclose) = (self.handlers.clone(), self.enclose.clone());
        let (fifo, stopper) = (self.mode.fifo(lane), self.stopper.clone());
        let main = move || {
            let _needed = Needed::by_a_run();
            let (handler, verdict) = match set_up(fifo, &*handlers, lane) {
                Ok(handler) => (Some(handler), Ok(gettid())),
                Err(e) => (None, Err(e)),
            };
            let budget = fifo.and_then(|_| RealTimeBudget::of_process(Path::new("/")));
            let allowance =
                budget.zip(fifo).and_then(|(budget, fifo)| Allowance::of_thread(budget, fifo.priority));
            // Large, so before time starts.
            let figures = LaneFigures::new();
            let _told = told.send(verdict);
            stopper.bell().ring();
            let (Some(handler), Ok(Go { shared, thread })) = (handler, is_to_go.recv()) else { return };
            let sleeper = if fifo.is_some() { Sleeper::spinning() } else { Sleeper::yielding() };
            let id = gettid().as_raw().cast_unsigned();
            let queue = Queue::default();
            let mut lane =
                Lane { shared: &shared, number: lane, thread, id, figures, handler, allowance, queue };
            lane.run(sleeper);
            let _told = finished.send(lane.figures);
        };
        let builder = thread::Builder::new().name(format!("red-start-{lane}"));
        let thread = builder.spawn(move || enclose(Box::new(main)));
        let _runs = thread.map_err(|error| SetupError::no_thread("pthread_create(lane)", &error))?;
        Ok(Starting { lane, until: Instant::now() + START_BOUND, verdict, id: None, go, figures })
    }

    /// Starts every lane; either all are set up, or none goes on.
    pub(crate) fn start_all<C, H, L>(&self, lanes: usize) -> Result<Lanes<C, H, L>, SetupError>
    where
        C: Capacity,
        H: Host<C> + 'static,
        L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
    {
        let mut starting = (0..lanes).map(|lane| self.start(lane)).collect::<Result<Vec<_>, _>>()?;
        for thread in &mut starting {
            let left = thread.until.saturating_duration_since(Instant::now());
            thread.id = Some(thread.verdict.recv_timeout(left).unwrap_or(Err(NOT_UP))?);
        }
        Ok(starting)
    }
}

impl<S> Starting<S> {
    /// What came of its set-up, once that is known; it is also where it takes longer than [`START_BOUND`].
    pub(crate) fn verdict(&mut self) -> Option<Result<(), SetupError>> {
        match self.verdict.try_recv() {
            Ok(verdict) => Some(verdict.map(|id| self.id = Some(id))),
            Err(TryRecvError::Empty) if Instant::now() < self.until => None,
            Err(_) => Some(Err(NOT_UP)),
        }
    }
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Starting<Shared<C, H, L>> {
    /// Lets it take its lane, as the thread of this number. It was set up.
    pub(crate) fn go(self, shared: &Arc<Shared<C, H, L>>, thread: u64) -> Started {
        let slot = &shared.slots[self.lane];
        // Here and not by the thread itself, which may be killed before it comes to that.
        slot.adopt_thread(self.id.map_or(0, Pid::as_raw));
        // A spare's still shows the body that hung.
        let _of_that_body = slot.reset();
        let _there = self.go.send(Go { shared: shared.clone(), thread });
        Started { lane: self.lane, thread, figures: self.figures }
    }
}

/// Everything that needs rights, faults pages or allocates.
fn set_up(fifo: Option<Fifo>, handlers: &Handlers, number: usize) -> Result<Box<dyn Handler>, SetupError> {
    // Whatever thread the host runs a lane on: its name is what `top` and a trace of the kernel show.
    if let Ok(name) = CString::new(format!("red-lane-{number}")) {
        let _only_a_name = set_name(&name);
    }
    fifo.map_or_else(best_effort, Fifo::apply)?;
    prefault_stack(STACK)?;
    // What it keeps for the thread is there before real time starts.
    let _nothing = caught(|| ());
    let mut handler = handlers(number);
    handler.prepare();
    Ok(handler)
}

impl Started {
    /// Waits for its end, as long as it may take: a body until its bound, within which the watchdog finds it, and what
    /// is no body for [`STOP_LOOKS`]. Who takes longer tells nothing and ends with the process.
    pub(crate) fn end<C: Capacity, H, L: Exclusive<Scheduler<C>>>(
        &self,
        shared: &Shared<C, H, L>,
    ) -> Option<LaneFigures> {
        let mut looks = 0;
        while looks < STOP_LOOKS {
            match self.figures.recv_timeout(STOP_LOOK) {
                Ok(figures) => return Some(figures),
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {
                    let (seat, slot) = (&shared.waiting.seats[self.lane], &shared.slots[self.lane]);
                    if !seat.is_of(self.thread) || slot.has_passed() {
                        return None;
                    }
                    let is_running = slot.deadline().is_some_and(|deadline| deadline > now_ns());
                    looks = if is_running { 0 } else { looks + 1 };
                }
            }
        }
        None
    }
}

/// A lane did not come up: it panicked, which was printed, or takes too long.
pub(crate) const NOT_UP: SetupError = SetupError::System {
    call: "start of a lane",
    errno: nix::errno::Errno::ETIMEDOUT,
    fix: "see the message above; a body that needs more than 60 s to load is too slow to start",
};

#[cfg(test)]
mod tests;
