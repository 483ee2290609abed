//! The runtime: owns the shared scheduler and the lanes; starts them, watches them, stops them.

use crate::allocations;
use crate::clock::now_ns;
use crate::handler::Handler;
use crate::lane::{Lane, NOBODY};
use crate::pi_lock::PiLock;
use crate::report::{LaneFigures, RunReport};
use crate::seat::Seat;
use crate::setup::{self, Fifo, SetupError, best_effort, prefault_stack};
use crate::shared::Shared;
use crate::sleeper::Sleeper;
use crate::stop::StopSignals;
use crate::timeline::{Host, Releases, Timeline};
use crate::watchdog::{Slot, Watchdog};
use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use red_core::sync::{Exclusive, TicketLock};
use red_core::{Capacity, Instant, Request, Scheduler, SharedScheduler, TaskId};
use std::io;
use std::sync::{Arc, Condvar, Mutex, mpsc};
use std::thread;
use std::time::Duration;

/// How long an idle lane spins before it sleeps, where it has its CPU to itself: twice a wake-up.
const SPIN_NS: u64 = 30_000;

/// How the lanes run.
#[derive(Clone, Debug)]
pub enum Mode {
    /// SCHED_FIFO at this priority, memory locked, lane `i` alone on CPU `cpus[i]`.
    RealTime {
        /// 1 to 98; the watchdog runs one above.
        priority: u8,
        /// A CPU for each lane.
        cpus: Vec<usize>,
    },
    /// Ordinary threads that share CPUs: no spinning, a priority-inheriting lock, no promise.
    BestEffort,
}

/// Makes the handler of a lane, also for a spare.
pub type Handlers = dyn Fn(usize) -> Box<dyn Handler> + Send + Sync;
/// Runs a lane's main function, on this or another thread, and returns when it has ended. Inference engines that
/// compute on threads of their own want lanes inside of those.
pub type Enclose = dyn Fn(Box<dyn FnOnce() + Send>) + Send + Sync;

/// What to run.
pub struct Setup<C: Capacity> {
    /// With its tasks admitted.
    pub scheduler: Box<Scheduler<C>>,
    /// Lanes over all pools.
    pub lanes: usize,
    /// How they run.
    pub mode: Mode,
    /// Releases by the clock.
    pub releases: Vec<Releases>,
    /// No release from then on; the run then drains.
    pub duration_ns: u64,
    /// At most so long.
    pub drain_ns: u64,
    /// The bodies.
    pub handlers: Arc<Handlers>,
    /// Around a lane's main.
    pub enclose: Arc<Enclose>,
}

/// A run that goes on: what other threads may ask of it.
pub trait Control: Send + Sync {
    /// Releases a job from outside of the lanes; `false` if the mailbox is full or the run is over. Wait-free
    /// but for the other users of the same producer number.
    fn release(&self, producer: usize, task: TaskId) -> bool;
}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>> + Send + Sync> Control for Shared<C, H, L> {
    fn release(&self, producer: usize, task: TaskId) -> bool {
        if self.stopping.load(Ordering::Acquire) {
            return false;
        }
        let Some(post) = self.scheduler.producer(producer) else { return false };
        let request = Request { task, at: Instant::from_nanos(self.now()), capture: None };
        let posted = post.push(request).is_ok();
        self.knock();
        posted
    }
}

/// Runs until the duration ended and the jobs drained, or a signal came. `progress` is called about ten times a
/// second on the calling thread, with the nanoseconds since the start. Returns the host and the figures.
///
/// # Errors
/// [`SetupError`] of whatever right or resource is missing; nothing ran then.
pub fn run<C: Capacity, H: Host<C> + 'static>(
    setup: Setup<C>,
    host: H,
    started: impl FnOnce(Arc<dyn Control>),
    progress: impl FnMut(u64),
) -> Result<(H, RunReport), SetupError> {
    match setup.mode {
        Mode::RealTime { .. } => run_with::<C, H, TicketLock<Scheduler<C>>>(setup, host, started, progress),
        Mode::BestEffort => {
            // Asked for once here, so that the lock itself cannot fail later.
            drop(PiLock::new(())?);
            run_with::<C, H, PiLock<Scheduler<C>>>(setup, host, started, progress)
        }
    }
}

/// What a lane's thread tells when it ends.
type Finished = (usize, LaneFigures);

/// Lanes set themselves up before time starts, and wait here for it.
enum Gate<T> {
    Closed,
    Open(T),
    Cancelled,
}

/// Starts the threads of lanes, the first ones and spares.
struct Starter<S> {
    gate: Arc<(Mutex<Gate<Arc<S>>>, Condvar)>,
    finished: mpsc::Sender<Finished>,
    handlers: Arc<Handlers>,
    enclose: Arc<Enclose>,
    mode: Mode,
}

impl<C, H, L> Starter<Shared<C, H, L>>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    fn start(
        &self,
        number: usize,
        thread: u64,
        ready: Option<mpsc::Sender<Result<(), SetupError>>>,
    ) -> io::Result<()> {
        let (gate, finished) = (self.gate.clone(), self.finished.clone());
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
            let (Some(handler), Some(shared)) = (handler, open(&gate)) else { return };
            shared.slots[number].adopt();
            let sleeper = if fifo.is_some() { Sleeper::spinning() } else { Sleeper::yielding() };
            let figures = LaneFigures::new();
            let mut lane = Lane { shared: &shared, number, thread, fifo, figures, sleeper, handler };
            lane.run();
            let _told = finished.send((number, lane.figures));
        };
        let started = thread::Builder::new().name(format!("red-lane-{number}"));
        started.spawn(move || enclose(Box::new(main))).map(drop)
    }

    fn let_through(&self, gate: Gate<Arc<Shared<C, H, L>>>) {
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
    fifo.map_or_else(best_effort, Fifo::apply)?;
    prefault_stack(STACK)?;
    let mut handler = handlers(number);
    handler.prepare();
    Ok(handler)
}

impl Mode {
    fn fifo(&self, lane: usize) -> Option<Fifo> {
        match self {
            Self::RealTime { priority, cpus } => {
                Some(Fifo { priority: *priority, cpu: cpus.get(lane).copied().unwrap_or(0) })
            }
            Self::BestEffort => None,
        }
    }
}

fn run_with<C, H, L>(
    setup: Setup<C>,
    host: H,
    started: impl FnOnce(Arc<dyn Control>),
    mut progress: impl FnMut(u64),
) -> Result<(H, RunReport), SetupError>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    let signals = StopSignals::install()?;
    let Setup { scheduler, lanes, mode, releases, duration_ns, drain_ns, handlers, enclose } = setup;
    let realtime = matches!(mode, Mode::RealTime { .. });
    setup::malloc_for_real_time()?;
    if realtime {
        setup::lock_memory()?;
    }
    // Held to the end of the run; a machine without the device idles as deep as it likes, which doctor tells.
    let _awake = realtime.then(setup::hold_cpu_dma_latency);
    let allocations_before = allocations::counted();
    let (finished, is_finished) = mpsc::channel();
    let gate = Arc::new((Mutex::new(Gate::Closed), Condvar::new()));
    let starter = Starter::<Shared<C, H, L>> { gate, finished, handlers, enclose, mode };
    start_all(&starter, lanes)?;

    let slots: Arc<[Slot]> = (0..lanes).map(|_| Slot::new()).collect();
    let shared = Arc::new(Shared::<C, H, L> {
        scheduler: SharedScheduler::new(*scheduler),
        host: TicketLock::new((Timeline::new(&releases, duration_ns), Some(host))),
        seats: (0..lanes).map(|_| Seat::default()).collect(),
        slots: slots.clone(),
        stopping: AtomicBool::new(false),
        knock: AtomicBool::new(false),
        idle: AtomicU32::new(0),
        keeper: AtomicU32::new(NOBODY),
        wake_at: AtomicU64::new(u64::MAX),
        jobs: AtomicU32::new(0),
        origin_ns: now_ns(),
        spin_ns: if realtime { SPIN_NS } else { 0 },
        hung: AtomicU64::new(0),
        lost: AtomicU32::new(0),
        spared: AtomicU32::new(0),
    });
    let watched = shared.clone();
    let above = starter.mode.fifo(0).map(|f| Fifo { priority: f.priority + 1, ..f });
    let watchdog = Watchdog::start(slots, above, move |lane, _expiry| {
        watched.hung.fetch_add(1, Ordering::Relaxed);
        watched.seats[lane].overdue.store(true, Ordering::Release);
        // Some lane fails the job; where none is left, the spare does it.
        watched.lost.fetch_or(1 << lane, Ordering::AcqRel);
        watched.knock();
    });
    let watchdog = watchdog.inspect_err(|_| starter.let_through(Gate::Cancelled))?;
    started(shared.clone());
    starter.let_through(Gate::Open(shared.clone()));

    let mut threads = lanes as u64;
    let mut lanes_lost = 0;
    loop {
        let _woken = signals.bell().wait(Some(now_ns() + PROGRESS_NS), 0);
        let now = shared.now();
        progress(now);
        let mut lost = shared.lost.swap(0, Ordering::AcqRel);
        while lost != 0 {
            let lane = lost.trailing_zeros() as usize;
            lost &= lost - 1;
            threads += 1;
            shared.seats[lane].threads.store(threads, Ordering::Release);
            // Before its first turn, which retires the lane for the hung body and then takes it over.
            shared.spared.fetch_or(1 << lane, Ordering::AcqRel);
            if starter.start(lane, threads, None).is_err() {
                shared.spared.fetch_and(!(1 << lane), Ordering::AcqRel);
                lanes_lost += 1;
            }
        }
        let drained = now >= duration_ns && shared.jobs.load(Ordering::Relaxed) == 0;
        if signals.requested().is_some() || drained || now >= duration_ns.saturating_add(drain_ns) {
            break;
        }
    }
    shared.stopping.store(true, Ordering::Release);
    shared.seats.iter().for_each(|seat| seat.bell.ring());
    // A thread whose body never returns does not report; it ends with the process.
    let hung = shared.hung.load(Ordering::Relaxed);
    let mut total = LaneFigures::new();
    let mut busy_ns = vec![0; lanes];
    for _ in 0..threads.saturating_sub(hung) {
        let Ok((lane, figures)) = is_finished.recv_timeout(STOP_BOUND) else { break };
        busy_ns[lane] += figures.busy_ns;
        total.add(&figures);
    }
    drop(watchdog);
    let report = RunReport {
        realtime,
        overhead_ns_per_unit: total.deciding_ns / total.units.max(1),
        dispatch_ns: total.dispatch_ns,
        page_faults: total.faults,
        allocations: allocations::counted() - allocations_before,
        overruns: total.overruns,
        hung,
        lanes_lost,
        failed: total.failed,
        nodes_missed: total.nodes_missed,
        counters: shared.scheduler.with(|s, _| s.counters()),
        events_dropped: shared.scheduler.with(|s, _| s.events_dropped()),
        busy_ns,
        stopped_by: signals.requested().map(nix::sys::signal::Signal::as_str),
    };
    let host = shared.scheduler.with(|_, _| shared.host.with(|(_, host)| host.take()));
    host.map(|host| (host, report)).ok_or(NO_HOST)
}

/// Starts every lane; either all are set up, or none goes on.
fn start_all<C, H, L>(starter: &Starter<Shared<C, H, L>>, lanes: usize) -> Result<(), SetupError>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    let (ready, is_ready) = mpsc::channel();
    let all = || {
        for number in 0..lanes {
            starter.start(number, 0, Some(ready.clone())).map_err(|e| no_thread(&e))?;
        }
        (0..lanes).try_for_each(|_| is_ready.recv_timeout(START_BOUND).unwrap_or(Err(NO_HOST)))
    };
    all().inspect_err(|_| starter.let_through(Gate::Cancelled))
}

/// Between two looks of the control thread.
const PROGRESS_NS: u64 = 100_000_000;
/// Bodies are prepared within this time.
const START_BOUND: Duration = Duration::from_secs(60);
/// Lanes end within this time after the stop, but for bodies that hang.
const STOP_BOUND: Duration = Duration::from_secs(2);
/// Stack that a lane touches before real time starts.
const STACK: usize = 256 * 1024;

/// A lane did not come up, or the host was taken: neither happens without a failure that was printed before.
const NO_HOST: SetupError = SetupError::System {
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
