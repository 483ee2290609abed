//! The runtime: owns the shared scheduler and the lanes; starts them, watches them, stops them.

use crate::allocations;
use crate::clock::{now_ns, suspended_ns};
use crate::control::{Control, Needed};
use crate::handler::Handler;
use crate::held_cpus::HeldCpus;
use crate::held_memory::HeldMemory;
use crate::oversight::Oversight;
use crate::panics::keep_of_bodies;
use crate::pi_lock::PiLock;
use crate::report::{LaneFigures, RunReport};
use crate::setup::{self, Fifo, SetupError};
use crate::shared::{Held, Shared, take_requests};
use crate::stop::{StopBy, StopSignals, Stopper};
use crate::supervision::Supervision;
use crate::threads::{NOT_UP, Starter};
use crate::timeline::{Host, Releases, Timeline, tell_warnings};
use crate::watchdog::Watchdog;
use core::sync::atomic::Ordering;
use red_core::{Capacity, Instant, Scheduler};
use red_record::{Recorder, Tape};
use red_sync::{Exclusive, TicketLock};
use std::collections::BTreeSet;
use std::sync::Arc;

/// How long an idle lane spins before it sleeps, where it has its CPU to itself: twice a wake-up.
const SPIN_NS: u64 = 30_000;

/// How the lanes run.
#[derive(Clone, Debug)]
pub enum Mode {
    /// SCHED_FIFO at this priority, memory locked, lane `i` alone on CPU `cpus[i]`.
    RealTime {
        /// 1 to 98; the watchdog runs one above.
        priority: u8,
        /// A CPU of its own for each lane, which no other run of this process has.
        cpus: Vec<usize>,
    },
    /// Ordinary threads that share CPUs: no spinning, a priority-inheriting lock, no promise.
    BestEffort,
}

impl Mode {
    pub(crate) fn fifo(&self, lane: usize) -> Option<Fifo> {
        match self {
            Self::RealTime { priority, cpus } => {
                Some(Fifo { priority: *priority, cpu: cpus.get(lane).copied().unwrap_or(0) })
            }
            Self::BestEffort => None,
        }
    }
}

/// Makes the handler of a lane, also for a spare.
pub type Handlers = dyn Fn(usize) -> Box<dyn Handler> + Send + Sync;
/// Runs a lane's main function, on this or another thread that ends with it, and returns then. Inference engines that
/// compute on threads of their own want lanes inside of those. Whether a lane lives is asked of the kernel, so a thread
/// that goes on without it would look alive.
pub type Enclose = dyn Fn(Box<dyn FnOnce() + Send>) + Send + Sync;

/// What to run.
pub struct Setup<C: Capacity> {
    /// With its tasks admitted.
    pub scheduler: Box<Scheduler<C>>,
    /// Lanes over all pools.
    pub lanes: usize,
    /// Lanes whose handlers have a [`Stream`](crate::stream::Stream), a bit each; pools that dispatch ahead have no others.
    pub streams: u32,
    /// How they run.
    pub mode: Mode,
    /// Releases by the clock.
    pub releases: Vec<Releases>,
    /// No release from then on; the run then drains.
    pub duration_ns: u64,
    /// At most so long.
    pub drain_ns: u64,
    /// Who may stop the run before.
    pub stop: StopBy,
    /// Where every input of the scheduler goes, if the run is recorded; [`run`] drops it at the end.
    pub tape: Option<Tape>,
    /// The bodies.
    pub handlers: Arc<Handlers>,
    /// Around a lane's main.
    pub enclose: Arc<Enclose>,
}

impl<C: Capacity> Setup<C> {
    fn check(&self) -> Result<(), SetupError> {
        let (lanes, of_scheduler) = (self.lanes, self.scheduler.lanes());
        if lanes != of_scheduler {
            return Err(SetupError::OtherLanes { lanes, of_scheduler });
        }
        if self.scheduler.config().preempt {
            return Err(SetupError::Preempts);
        }
        match &self.mode {
            Mode::RealTime { cpus, .. }
                if BTreeSet::from_iter(cpus).len() != lanes || cpus.len() != lanes =>
            {
                Err(SetupError::NotACpuEach { lanes, cpus: cpus.clone() })
            }
            _ => Ok(()),
        }
    }
}

/// Runs until the duration ended and the jobs drained, it was stopped ([`StopBy`]), or it cannot go on
/// ([`Surrender`](crate::report::Surrender)). Every release of the duration is made, late if need be; after a stop or a
/// surrender none is made and no body starts. Bodies that run at the end are waited for, as long as the watchdog gives
/// them. Panics of bodies are in the report; whether they are printed, see [`crate::panics`].
///
/// `started` is called before the first lane does anything, with the clock of the run ticking: what it takes the first
/// jobs wait. `progress` is called about ten times a second on the calling thread, with the nanoseconds since the start.
/// Should they panic, the lanes are stopped first. Returns the host and the figures.
///
/// # Errors
/// [`SetupError`] of whatever right or resource is missing, or does not fit together; nothing ran then.
pub fn run<C: Capacity, H: Host<C> + 'static>(
    setup: Setup<C>,
    host: H,
    started: impl FnOnce(Arc<dyn Control<C>>),
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

fn run_with<C, H, L>(
    setup: Setup<C>,
    host: H,
    started: impl FnOnce(Arc<dyn Control<C>>),
    mut progress: impl FnMut(u64),
) -> Result<(H, RunReport), SetupError>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    setup.check()?;
    let Setup {
        scheduler,
        lanes,
        streams,
        mode,
        releases,
        duration_ns,
        drain_ns,
        stop,
        tape,
        handlers,
        enclose,
    } = setup;
    let signals = (stop == StopBy::Signals).then(StopSignals::install).transpose()?;
    if signals.is_some() {
        keep_of_bodies();
    }
    let stopper = Arc::new(Stopper::new(signals.as_ref()));
    let _needed = Needed::by_a_run();
    let _held = match &mode {
        Mode::RealTime { cpus, .. } => Some(HeldCpus::hold(cpus)?),
        Mode::BestEffort => None,
    };
    let realtime = matches!(mode, Mode::RealTime { .. });
    // Best effort promises nothing of page faults.
    let _memory = realtime.then(HeldMemory::hold).transpose()?;
    // Held to the end of the run; a machine without the device idles as deep as it likes, which doctor tells.
    let _awake = realtime.then(setup::hold_cpu_dma_latency);
    let (allocations_before, suspended_before) = (allocations::counted(), suspended_ns());
    let starter = Starter { handlers, enclose, mode, stopper: stopper.clone() };
    let starting = starter.start_all::<C, H, L>(lanes)?;

    let held = Held { timeline: Timeline::new(&releases, duration_ns), host: Some(host), tape, stood_ns: 0 };
    let spin_ns = if realtime { SPIN_NS } else { 0 };
    let shared = Shared::<C, H, L>::new(scheduler, held, streams, duration_ns, spin_ns, stopper.clone());
    let above = starter.mode.fifo(0).map(|f| Fifo { priority: f.priority + 1, ..f });
    let watchdog = Watchdog::start(shared.slots.clone(), above, Oversight::of(shared.clone()))?;
    if stopper.stopped().is_some() {
        // It came before the run: no lane begins anything.
        shared.end();
    }
    let _ends = Ends(&shared);
    // The watchdog's thread took a millisecond, of memory that is held: jobs do not wait for that.
    shared.waiting.begin();
    started(shared.clone());

    let mut supervision = Supervision::new(shared.clone(), starter, starting);
    let last_ns = shared.waiting.origin_ns().saturating_add(duration_ns).saturating_add(drain_ns);
    let (mut now, mut is_over) = (0, false);
    while stopper.stopped().is_none() && supervision.gave_up.is_none() && !is_over {
        let _woken = stopper.bell().wait(Some(last_ns.min(now_ns() + PROGRESS_NS)), 0);
        // Before the clock, so that all of it is over at `now`.
        let is_drained = shared.drained.load(Ordering::Relaxed);
        now = shared.waiting.now();
        is_over = is_drained || now >= duration_ns.saturating_add(drain_ns);
        progress(now);
        supervision.look();
    }
    let gave_up = supervision.gave_up;
    let is_in_order = stopper.stopped().is_none() && gave_up.is_none();
    let mut total = LaneFigures::new();
    let mut busy_ns = vec![0; lanes];
    for (lane, figures) in supervision.end() {
        busy_ns[lane] += figures.busy_ns;
        total.add(figures);
    }
    drop(watchdog);
    shared.wait_for_posts();
    let host = shared.scheduler.with(|scheduler, requests| {
        shared.host.with(|held| {
            let (mut host, mut tape) = (held.host.take()?, held.tape.take());
            let scheduler = &mut Recorder::new(scheduler, tape.as_mut());
            if is_in_order {
                // What no lane came to within the bound is told as released, too.
                // Later than what lanes did meanwhile.
                let now = Instant::from_nanos(shared.waiting.now());
                take_requests(scheduler, requests, &mut host, now);
                while stopper.stopped().is_none()
                    && held.timeline.release(scheduler, &mut host, now).is_some()
                {}
                tell_warnings(scheduler, &mut host, now);
                while let Some(event) = scheduler.take_event() {
                    host.event(event);
                }
            }
            scheduler.end(Instant::from_nanos(now));
            Some(host)
        })
    });
    let (standstills, longest_standstill_ns) = shared.standstills.told();
    let report = RunReport {
        realtime,
        overhead_ns_per_unit: total.deciding_ns / total.units.max(1),
        dispatch_ns: total.dispatch_ns,
        page_faults: total.faults,
        allocations: allocations::counted() - allocations_before,
        overruns: total.overruns,
        // Also bodies that ran at the end and did not return.
        hung: shared.hung.load(Ordering::Relaxed),
        lanes_lost: supervision.lanes_lost(),
        streams_left: shared.left.load(Ordering::Relaxed).count_ones().into(),
        threads_died: supervision.threads_died,
        pinned_again: supervision.pinned_again,
        standstills,
        longest_standstill_ns,
        ordinary_ns: total.ordinary_ns,
        suspended_ns: suspended_ns().saturating_sub(suspended_before),
        failed: total.failed,
        panics: total.panics,
        stream_hangs: total.stream_hangs,
        pools_lost: shared.pools_lost.load(Ordering::Relaxed),
        nodes_missed: total.nodes_missed,
        counters: shared.scheduler.with(|s, _| s.counters()),
        events_dropped: shared.scheduler.with(|s, _| s.events_dropped()),
        busy_ns,
        ahead: shared.ahead.load(Ordering::Relaxed),
        // Also while the last releases were made.
        stopped_by: stopper.stopped(),
        gave_up,
    };
    host.map(|host| (host, report)).ok_or(NOT_UP)
}

/// Whatever becomes of the control thread, nobody waits for a lane for ever.
struct Ends<'a, C: Capacity, H, L: Exclusive<Scheduler<C>>>(&'a Shared<C, H, L>);

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Drop for Ends<'_, C, H, L> {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Between two looks of the control thread.
const PROGRESS_NS: u64 = 100_000_000;
