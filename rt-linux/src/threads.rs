//! The threads of lanes, the first ones and spares: how they start together, and what they tell when they end.

use crate::handler::Handler;
use crate::lane::Lane;
use crate::report::LaneFigures;
use crate::runtime::{Enclose, Handlers, Mode};
use crate::setup::{Fifo, SetupError, best_effort, prefault_stack};
use crate::shared::Shared;
use crate::sleeper::Sleeper;
use crate::timeline::Host;
use nix::sys::prctl::set_name;
use red_core::{Capacity, Scheduler};
use red_sync::Exclusive;
use std::ffi::CString;
use std::io;
use std::sync::mpsc::{self, RecvTimeoutError, TryRecvError};
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::Duration;

/// Bodies are prepared within this time.
const START_BOUND: Duration = Duration::from_secs(60);
/// Between two looks at a lane whose end is waited for.
const STOP_LOOK: Duration = Duration::from_millis(10);
/// A lane that runs no body ends within so many looks.
const STOP_LOOKS: u32 = 200;
/// Stack that a lane touches before real time starts.
const STACK: usize = 256 * 1024;

/// A lane's thread that was started.
pub(crate) struct Started {
    pub(crate) lane: usize,
    thread: u64,
    /// What it measured, when it ends. Closed without, where it never came to run.
    figures: mpsc::Receiver<LaneFigures>,
}

/// Lanes set themselves up before time starts, and wait here for it.
pub(crate) enum Gate<T> {
    Closed,
    Open(T),
    Cancelled,
}

/// Starts the threads of lanes, the first ones and spares.
pub(crate) struct Starter<S> {
    gate: Arc<(Mutex<Gate<Arc<S>>>, Condvar)>,
    handlers: Arc<Handlers>,
    enclose: Arc<Enclose>,
    pub(crate) mode: Mode,
}

impl<C, H, L> Starter<Shared<C, H, L>>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    pub(crate) fn new(handlers: Arc<Handlers>, enclose: Arc<Enclose>, mode: Mode) -> Self {
        Self { gate: Arc::new((Mutex::new(Gate::Closed), Condvar::new())), handlers, enclose, mode }
    }

    pub(crate) fn start(
        &self,
        number: usize,
        thread: u64,
        ready: Option<mpsc::Sender<Result<(), SetupError>>>,
    ) -> io::Result<Started> {
        let (finished, is_finished) = mpsc::channel();
        let gate = self.gate.clone();
        let (handlers, enclose) = (self.handlers.clone(), self.enclose.clone());
        let fifo = self.mode.fifo(number);
        let main = move || {
            let handler = set_up(fifo, &*handlers, number);
            let (handler, verdict) = match handler {
                Ok(handler) => (Some(handler), Ok(())),
                Err(e) => (None, Err(e)),
            };
            if let Some(ready) = ready {
                // The starter waits for every lane.
                let _told = ready.send(verdict);
            }
            // Large, so before time starts.
            let figures = LaneFigures::new();
            let (Some(handler), Some(shared)) = (handler, open(&gate)) else { return };
            shared.slots[number].adopt();
            // A spare's still shows the body that hung.
            let _bound = shared.slots[number].disarm();
            let sleeper = if fifo.is_some() { Sleeper::spinning() } else { Sleeper::yielding() };
            let mut lane = Lane { shared: &shared, number, thread, figures, handler };
            lane.run(sleeper);
            let _told = finished.send(lane.figures);
        };
        let builder = thread::Builder::new().name(format!("red-start-{number}"));
        builder.spawn(move || enclose(Box::new(main)))?;
        Ok(Started { lane: number, thread, figures: is_finished })
    }

    pub(crate) fn let_through(&self, gate: Gate<Arc<Shared<C, H, L>>>) {
        if let Ok(mut state) = self.gate.0.lock() {
            *state = gate;
        }
        self.gate.1.notify_all();
    }
}

/// Waits for the gate.
fn open<S>(gate: &(Mutex<Gate<Arc<S>>>, Condvar)) -> Option<Arc<S>> {
    let mut state = gate.0.lock().ok()?;
    loop {
        match &*state {
            Gate::Open(shared) => return Some(shared.clone()),
            Gate::Cancelled => return None,
            Gate::Closed => state = gate.1.wait(state).ok()?,
        }
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
    let mut handler = handlers(number);
    handler.prepare();
    Ok(handler)
}

impl Started {
    /// Whether a thread that has not adopted its lane's slot never will.
    pub(crate) fn never_began(&self) -> bool {
        matches!(self.figures.try_recv(), Err(TryRecvError::Disconnected))
    }

    /// Waits for its end, as long as it may take: a body until the watchdog finds it beyond its bound, and what is no
    /// body for [`STOP_LOOKS`]. Who takes longer tells nothing and ends with the process.
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
                    looks = if slot.deadline().is_some() { 0 } else { looks + 1 };
                }
            }
        }
        None
    }
}

/// Starts every lane; either all are set up, or none goes on.
pub(crate) fn start_all<C, H, L>(
    starter: &Starter<Shared<C, H, L>>,
    lanes: usize,
) -> Result<Vec<Started>, SetupError>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    let (ready, is_ready) = mpsc::channel();
    let all = || {
        let started = (0..lanes).map(|number| starter.start(number, 0, Some(ready.clone())));
        let started: Vec<Started> = started.collect::<io::Result<_>>().map_err(|e| no_thread(&e))?;
        (0..lanes).try_for_each(|_| is_ready.recv_timeout(START_BOUND).unwrap_or(Err(NO_HOST)))?;
        Ok(started)
    };
    all().inspect_err(|_| starter.let_through(Gate::Cancelled))
}

/// A lane did not come up, or the host was taken: neither happens without a failure that was printed before.
pub(crate) const NO_HOST: SetupError = SetupError::System {
    call: "start of a lane",
    errno: nix::errno::Errno::ETIMEDOUT,
    fix: "see the message above; a body that needs more than 60 s to load is too slow to start",
};

fn no_thread(error: &io::Error) -> SetupError {
    SetupError::System {
        call: "pthread_create(lane)",
        errno: nix::errno::Errno::from_raw(error.raw_os_error().unwrap_or_default()),
        fix: "raise the limit of processes (ulimit -u) or free memory",
    }
}
