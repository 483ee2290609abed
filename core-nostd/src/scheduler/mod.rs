//! Layer 5: the state machine.
//!
//! Calls may come in any order and number between polls. A sub-job is in one state:
//!
//! ```text
//!              (1)              (5)             (6)
//!   Waiting ---------> Ready ----------> Running -----> Done
//!                      |   ^                |            ^
//!                  (2) |   | (4)            | (7)        |
//!                      v   |                v            |
//!                     Parked            Suspended        |
//!                      |                                 |
//!                      +---------------------------------+
//!                                     (3)
//! (1) its last predecessor ended          (5) `poll` gives it a lane
//! (2) its encoder key is running, or its  (6) `complete`
//!     level is not open yet               (7) preempted; it is ready again with what it has done
//! (3) the running encoder ended: a hit    A job that ends takes all its sub-jobs with it; a lane whose
//! (4) the level opened, or the running    unit lost every member stays busy until the host reports it.
//!     encoder's unit failed
//! ```
//!
//! | call | time bound |
//! |---|---|
//! | `release` | O(nodes) |
//! | `complete`, `poll` | O(successors + log jobs); with encoders O(jobs * encoders) |
//! | `poll` when a job may be lost, at ticks, and under re-assignment | O(jobs * (nodes + edges)) |
//! | `poll`, for a start where nodes may have to wait for others | O(jobs * nodes * (jobs + tasks) * lanes^2 * nodes^2), with memory budgets `lanes` times that |
//! | `poll`, or any call at a later instant without one, when the outlook may have become worse | 67 + jobs forward schedules, each O(jobs * nodes * (jobs + lanes)) |
//! | `commit` | O(nodes log nodes + edges) |

pub(crate) mod action;
mod admit;
mod ahead;
mod coming;
pub(crate) mod complete;
mod demand;
mod dispatch;
pub(crate) mod edit;
pub(crate) mod event;
mod forward;
mod jobs;
mod lookahead;
mod memory;
mod merging;
mod monitor;
mod outlook;
mod outputs;
mod overload;
mod owed;
pub(crate) mod pools;
mod preempt;
mod pressure;
pub(crate) mod release;
mod spread;
mod standing;
mod standstill;
pub(crate) mod status;
pub(crate) mod tasks;
mod ticks;
pub(crate) mod units;
mod urgency;
mod version;
pub(crate) mod warning;

use crate::capacity::{Capacity, Empty};
use crate::config::{Config, Reassign};
use crate::graph::node_set::{bits, those};
use crate::policy::frame_cache::Output;
use crate::time::{Duration, Instant};
use action::Outcome;
use core::hint::cold_path;
use core::ops::Range;
use event::Record;
use jobs::Job;
use monitor::Monitor;
use pools::Pool;
use status::Counters;
use tasks::Task;
use units::{Beside, Lane};

/// A tick is at most this long: 146 years.
const LONGEST_TICK: Duration = Duration::from_nanos(1 << 62);

crate::capacity::stored! {
    /// The executive: tasks, jobs, lanes and queues in one value of `SIZE` bytes.
    ///
    /// ```
    /// use red_core::{Action, Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
    /// let mut dag = Dag::<Caps<4, 16, 16>>::new();
    /// let camera = dag.add_node(Node::new(Wcet::from_millis(2)))?;
    /// let control = dag.add_node(Node::new(Wcet::from_millis(3)))?;
    /// dag.add_edge(camera, control)?;
    /// let mut scheduler = Scheduler::new(Config::REDRT);
    /// let cruise = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50)))?;
    /// assert!(scheduler.certificate(cruise).expect("admitted").fits());
    ///
    /// let (mut now, mut order) = (Instant::ZERO, Vec::new());
    /// scheduler.release(cruise, now)?;                           // 1. something happened: tell it
    /// loop {
    ///     let mut running = None;
    ///     while let Some(action) = scheduler.poll(now) {         // 2. ask
    ///         match action {                                     // 3. carry it out
    ///             Action::Dispatch(d) => running = Some(d.unit),
    ///             Action::Ended(job) => assert!(job.on_time()),
    ///             _ => {}
    ///         }
    ///     }                                                      // 4. ask again until `None`
    ///     let Some(unit) = running else { break };
    ///     order.push(unit.node());
    ///     now = now.saturating_add(Duration::from_millis(1));    // 5. sleep until something happens
    ///     scheduler.complete(unit, now)?;                        // 6. go to 1: the lane reports
    /// }
    /// assert_eq!(order, [camera, control]);
    /// assert_eq!(scheduler.poll_at(), None);                     // nothing to wait for
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug)]
    #[repr(C)] // What every call touches lies together, in this order.
    pub struct Scheduler<C: Capacity> {
        config: Config,
        /// Latest time seen; time never goes back.
        now: Instant,
        /// From when on `poll` must look at the outlook of jobs again.
        alarm: Instant,
        /// The last tick that was counted. Under rules that count none, an instant at most a tick before now, and a tick less one
        /// before it where a look is due: what is later is no fast call.
        window: Instant,
        /// Pools that may have something to start, a bit each.
        active: u32,
        /// Lanes on which a unit waits, a bit each.
        promised: u32,
        /// Pools that were lost, a bit each.
        lost: u32,
        /// Slots of jobs in flight, and of ended jobs whose outcome was not taken, a bit each.
        in_flight: u64,
        ended: u64,
        /// Slots whose warning was not taken, a bit each.
        warnings: u64,
        /// Whether keys are re-assigned at each dispatch, and whether something happened since they were.
        reassigns: bool,
        stale_keys: bool,
        /// What the configuration says, looked up once: which keys move, and whether executions are samples.
        residual: bool,
        observes: bool,
        pool_count: u8,
        lane_count: u8,
        counters: Counters,
        /// Jobs ever released.
        releases: u64,
        pools: C::Pools<Pool<C>>,
        lanes: C::Lanes<Lane>,
        jobs: C::Jobs<Job<C>>,
        tasks: C::Tasks<Task<C>>,
        outputs: C::Nodes<Output>,
        beside: C::Lanes<Beside>,
        sensors: C::Nodes<Duration>,
        /// How a job ended whose place another took, until that is taken. It was given up; one that was not is nobody.
        displaced: Outcome,
        monitor: Monitor,
        record: Record<C>,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Bytes of one scheduler, the event record included.
    pub const SIZE: usize = size_of::<Self>();

    /// Bytes of the event record in it.
    pub const RECORD_SIZE: usize = size_of::<Record<C>>();

    /// A scheduler with one pool of `config.lanes` lanes, at most the capacity's, at least one.
    pub fn new(config: Config) -> Self {
        let mut new = Self::EMPTY;
        new.configure(config);
        new
    }

    /// Sets up a scheduler in place, such as a `static`; everything it held is forgotten.
    pub fn configure(&mut self, config: Config) {
        const { assert!(C::TASKS * C::NODES * C::JOBS * C::LANES * C::POOLS > 0, "capacities are in range") };
        *self = Self::EMPTY;
        self.config = config;
        self.observes = config.observes();
        self.residual = config.residual();
        self.reassigns = self.residual && config.reassign == Reassign::OnDispatch;
        (self.alarm, self.monitor.wake) = (Instant::MAX, Instant::MAX);
        // So that what is later than a window is never before it.
        self.config.overload.tick = config.overload.tick.min(LONGEST_TICK);
        self.begin_ticks();
        self.record.open();
        let lanes = config.lanes.clamp(1, C::LANES as u8);
        // One to LANES lanes in the first of at least one pool: there is room.
        let _first = self.add_pool(lanes, config.memory);
    }

    /// Slots of jobs in flight.
    fn slots(&self) -> impl Iterator<Item = usize> + Clone + use<C> {
        bits(self.in_flight)
    }

    fn pool_numbers(&self) -> Range<usize> {
        0..self.pool_count.into()
    }

    /// A pool may have something to start. With one pool the whole word is stored: adding a constant bit compiles
    /// to a byte store, and the load of the word soon after it would wait for the store to finish.
    fn activate(&mut self, pool: usize) {
        self.active = if C::POOLS == 1 { 1 } else { self.active | 1 << pool };
    }

    /// After an event or a start, if a pool holds its head back: all pools.
    fn reopen(&mut self) {
        if self.monitor.wake < Instant::MAX {
            if self.now >= self.monitor.wake {
                // Who waited is later than it was to be.
                self.delayed();
            }
            self.monitor.wake = Instant::MAX;
            self.activate_all();
        }
    }

    fn activate_all(&mut self) {
        self.active = ((1u64 << self.pool_count) - 1) as u32;
    }

    /// Holds time: a step back is counted and the latest time kept. At the first event of a new tick it counts those
    /// before it; after an instant at which a look became due that nobody polled for, it looks.
    #[inline(always)]
    fn advance(&mut self, now: Instant) -> Instant {
        let into = now.as_nanos().wrapping_sub(self.window.as_nanos());
        if into >= self.config.overload.tick.as_nanos() {
            return self.enter_tick(now);
        }
        if now < self.now {
            cold_path();
            self.counters.clock_steps_back += 1;
            return self.now;
        }
        self.now = now;
        now
    }
}

#[cfg(test)]
mod tests;
