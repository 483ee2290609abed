//! Layer 5: the state machine.
//!
//! One value, no clock, no threads. The host tells it what happened (`release`, `complete`, `fail`, `commit`)
//! and asks what to do (`poll`) until the answer is `None`; then it sleeps until `poll_at` or the next event.
//! Calls may come in any order and number between polls.
//!
//! A sub-job is in one state:
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
//! | `commit` | O(nodes log nodes + edges) |

pub(crate) mod action;
pub(crate) mod complete;
mod dispatch;
pub(crate) mod edit;
pub(crate) mod event;
mod jobs;
mod memory;
mod monitor;
mod outlook;
mod outputs;
mod preempt;
pub(crate) mod release;
mod shed;
pub(crate) mod tasks;
pub(crate) mod units;
mod version;

use crate::capacity::{Capacity, Empty};
use crate::config::{Config, Reassign};
use crate::id::{PoolId, SensorId};
use crate::policy::frame_cache::Output;
use crate::ready_queue::{Entry, Rank, ReadyQueue};
use crate::time::{Bytes, Duration, Instant};
use event::Record;
use jobs::Job;
use monitor::Monitor;
use preempt::Suspended;
use tasks::Task;
use units::Lane;

/// Sensors with distinct periods that a scheduler knows.
pub(crate) const SENSORS: usize = 16;

/// The executive: tasks, jobs, lanes and queues in one value of `SIZE` bytes.
///
/// ```
/// use red_core::{Action, Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
/// type Robot = Caps<4, 16, 16>;
/// let mut dag = Dag::<Robot>::new();
/// let camera = dag.add_node(Node::new(Wcet::from_millis(2)))?;
/// let control = dag.add_node(Node::new(Wcet::from_millis(3)))?;
/// dag.add_edge(camera, control)?;
///
/// let mut scheduler = Scheduler::<Robot>::new(Config::REDRT);
/// let cruise = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50)))?;
/// assert!(scheduler.certificate(cruise).expect("admitted").fits());
///
/// let mut now = Instant::ZERO;
/// scheduler.release(cruise, now)?;                           // 1. something happened
/// let mut order = Vec::new();
/// while let Some(action) = scheduler.poll(now) {             // 2. ask until quiet
///     match action {
///         Action::Dispatch(unit) => {                        // 3. do it
///             order.push(unit.unit.node());
///             now = now.saturating_add(Duration::from_millis(1));
///             scheduler.complete(unit.unit, now)?;           // 4. a lane reports
///         }
///         Action::Ended(job) => assert!(job.on_time()),
///         _ => {}
///     }
/// }
/// assert_eq!(order, [camera, control]);
/// assert_eq!(scheduler.poll_at(), None);                     // nothing to wait for
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Scheduler<C: Capacity> {
    config: Config,
    /// Latest time seen; time never goes back.
    now: Instant,
    /// From when on `poll` must look at the outlook of jobs again.
    alarm: Instant,
    /// Start of the monitor's current tick.
    window: Instant,
    /// Pools that may have something to start, a bit each.
    active: u32,
    /// Slots of jobs in flight, and of ended jobs whose outcome was not taken, a bit each.
    in_flight: u64,
    ended: u64,
    /// Whether keys are re-assigned at each dispatch, and whether something happened since they were.
    reassigns: bool,
    stale_keys: bool,
    observes: bool,
    pool_count: u8,
    lane_count: u8,
    task_count: u8,
    /// Units ever dispatched, jobs ever released.
    units: u64,
    releases: u64,
    pools: C::Pools<Pool<C>>,
    lanes: C::Lanes<Lane>,
    jobs: C::Jobs<Job<C>>,
    tasks: C::Tasks<Task<C>>,
    outputs: C::Nodes<Output>,
    suspended: [Suspended; preempt::SUSPENDED],
    sensors: [Duration; SENSORS],
    monitor: Monitor,
    counters: Counters,
    record: Record<C>,
}

/// What happened so far, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Counters {
    /// Units dispatched.
    pub units: u64,
    /// Encoder sub-jobs that completed without executing: members of a unit beyond the first, and hits.
    pub encoder_runs_saved: u64,
    /// Executions beyond the WCET.
    pub overruns: u64,
    /// Calls whose `now` was before an earlier one.
    pub clock_steps_back: u64,
    /// Completions of units whose jobs had been given up.
    pub late_completions: u64,
    /// Results thrown away for memory; their encoders run again.
    pub evictions: u64,
}

/// A pool: lanes, a memory budget, and the jobs that have something ready for it.
#[derive(Clone, Copy, Debug)]
struct Pool<C: Capacity> {
    /// Free lanes, by global number.
    free: u32,
    /// All its lanes, by global number.
    lanes: u32,
    /// The job that ran last (slot plus one) is not queued: it is compared with the queue's head instead.
    current: u8,
    limited: bool,
    /// Lane time of its completed units; lane time used up to the current tick's start, and in the tick before.
    busy: u64,
    mark: u64,
    tick_busy: u64,
    /// Memory budget, and bytes held by running units and kept results.
    budget: u64,
    used: u64,
    queue: ReadyQueue<Rank, C::Jobs<Entry<Rank>>, C::Jobs<u16>>,
}

impl<C: Capacity> Empty for Pool<C> {
    const EMPTY: Self = Self {
        free: 0,
        lanes: 0,
        current: 0,
        limited: false,
        busy: 0,
        mark: 0,
        tick_busy: 0,
        budget: 0,
        used: 0,
        queue: ReadyQueue::EMPTY,
    };
}

/// A pool could not be added. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PoolError {
    /// A pool needs at least one lane.
    NoLane,
    /// More pools or lanes than the capacity.
    Full,
}

/// A sensor could not be added. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SensorError {
    /// A period is at least one nanosecond.
    ZeroPeriod,
    /// More than 16 distinct periods.
    Full,
}

crate::error::messages! {
    PoolError {
        NoLane => "a pool needs at least one lane",
        Full => "more pools or lanes than the capacity; use larger LANES or POOLS",
    }
    SensorError {
        ZeroPeriod => "a sensor's period is at least 1 ns",
        Full => "more than 16 distinct sensor periods",
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Bytes of one scheduler, the event record included.
    pub const SIZE: usize = size_of::<Self>();

    /// Bytes of the event record in it.
    pub const RECORD_SIZE: usize = size_of::<Record<C>>();

    /// A scheduler with one pool of `config.lanes` lanes, at most the capacity's, at least one.
    #[must_use]
    pub fn new(config: Config) -> Self {
        let mut new = Self::EMPTY;
        new.configure(config);
        new
    }

    /// Sets up a scheduler in place, such as a `static`; everything it held is forgotten.
    pub fn configure(&mut self, config: Config) {
        const { assert!(C::NODES * C::JOBS * C::LANES * C::POOLS > 0, "capacities are in range") };
        *self = Self::EMPTY;
        self.config = config;
        self.observes = config.observes();
        self.reassigns = config.residual() && config.reassign == Reassign::OnDispatch;
        self.alarm = Instant::MAX;
        let lanes = config.lanes.clamp(1, C::LANES as u8);
        // One to LANES lanes in the first of at least one pool: there is room.
        let _first = self.add_pool(lanes, config.memory);
    }

    /// Adds a pool of `lanes` lanes after the others.
    ///
    /// # Errors
    /// [`PoolError`].
    pub fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
        if lanes == 0 {
            return Err(PoolError::NoLane);
        }
        let first = self.lane_count;
        let end = first.checked_add(lanes).ok_or(PoolError::Full)?;
        if usize::from(end) > C::LANES || usize::from(self.pool_count) >= C::POOLS {
            return Err(PoolError::Full);
        }
        let pool = usize::from(self.pool_count);
        let mask = ((1u64 << end) - (1u64 << first)) as u32;
        let budget = memory.map_or(u64::MAX, |m| m.0);
        self.pools[pool] = Pool { free: mask, lanes: mask, limited: memory.is_some(), budget, ..Pool::EMPTY };
        for lane in first..end {
            self.lanes[usize::from(lane)].pool = pool as u8;
        }
        self.lane_count = end;
        self.pool_count += 1;
        Ok(PoolId::new(pool as u8))
    }

    /// Makes a sensor known; jobs released between two captures share the earlier one. Sensors of equal
    /// period are one: the frame's name tells them apart.
    ///
    /// # Errors
    /// [`SensorError`].
    pub fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError> {
        if period == Duration::ZERO {
            return Err(SensorError::ZeroPeriod);
        }
        let place = self.sensors.iter().position(|p| *p == period || *p == Duration::ZERO);
        let place = place.ok_or(SensorError::Full)?;
        self.sensors[place] = period;
        Ok(SensorId::new(place as u8))
    }

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// What happened so far, in numbers.
    #[must_use]
    pub fn counters(&self) -> Counters {
        Counters { units: self.units, ..self.counters }
    }

    /// Jobs in flight.
    #[must_use]
    pub const fn jobs_in_flight(&self) -> usize {
        self.in_flight.count_ones() as usize
    }

    /// Sub-jobs that are ready and wait for a lane.
    #[must_use]
    pub fn ready_sub_jobs(&self) -> usize {
        self.slots().map(|slot| self.jobs[slot].ready.len()).sum()
    }

    /// Units that run, whether or not their jobs still want them.
    #[must_use]
    pub fn running_units(&self) -> usize {
        (0..usize::from(self.lane_count)).filter(|l| self.lanes[*l].is_busy()).count()
    }

    /// Bytes that running units and kept results hold of a pool.
    #[must_use]
    pub fn memory_used(&self, pool: PoolId) -> Bytes {
        Bytes(if pool.index() < C::POOLS { self.pools[pool.index()].used } else { 0 })
    }

    /// Whether a pool has both a free lane and a sub-job that waits for one.
    #[must_use]
    pub fn can_dispatch(&self) -> bool {
        let waits = |pool: usize| self.slots().any(|slot| self.head_of(slot, pool).is_some());
        (0..usize::from(self.pool_count)).any(|pool| self.pools[pool].free != 0 && waits(pool))
    }

    /// When `poll` has something to decide even if nothing happens. May change after every other call.
    #[must_use]
    pub fn poll_at(&self) -> Option<Instant> {
        (self.in_flight != 0 && self.monitor.wake < Instant::MAX).then_some(self.monitor.wake)
    }

    /// Takes the oldest event of the record.
    pub fn take_event(&mut self) -> Option<event::Event> {
        self.record.take()
    }

    /// Events that the record had to drop because nobody took them; exact.
    #[must_use]
    pub const fn events_dropped(&self) -> u64 {
        self.record.dropped()
    }

    /// Slots of jobs in flight.
    fn slots(&self) -> impl Iterator<Item = usize> + Clone + use<C> {
        bits(self.in_flight)
    }

    /// Holds time: a step back is counted and the latest time kept. At the first event of a new tick it takes
    /// the busy time at the tick's start.
    #[inline(always)]
    fn advance(&mut self, now: Instant) -> Instant {
        let into = now.as_nanos().wrapping_sub(self.window.as_nanos());
        if into >= self.config.overload.tick.as_nanos() {
            return self.enter_tick(now);
        }
        if now < self.now {
            self.counters.clock_steps_back += 1;
            return self.now;
        }
        self.now = now;
        now
    }
}

/// Numbers of the bits that are set, lowest first.
fn bits(mut mask: u64) -> impl Iterator<Item = usize> + Clone {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            bit
        })
    })
}

impl<C: Capacity> Empty for Scheduler<C> {
    const EMPTY: Self = Self {
        config: Config::EMPTY,
        now: Instant::ZERO,
        alarm: Instant::ZERO,
        window: Instant::ZERO,
        active: 0,
        in_flight: 0,
        ended: 0,
        reassigns: false,
        stale_keys: false,
        observes: false,
        pool_count: 0,
        lane_count: 0,
        task_count: 0,
        units: 0,
        releases: 0,
        pools: <C::Pools<Pool<C>>>::EMPTY,
        lanes: <C::Lanes<Lane>>::EMPTY,
        jobs: <C::Jobs<Job<C>>>::EMPTY,
        tasks: <C::Tasks<Task<C>>>::EMPTY,
        outputs: <C::Nodes<Output>>::EMPTY,
        suspended: [Suspended::EMPTY; preempt::SUSPENDED],
        sensors: [Duration::ZERO; SENSORS],
        monitor: Monitor::EMPTY,
        counters: Counters {
            units: 0,
            encoder_runs_saved: 0,
            overruns: 0,
            clock_steps_back: 0,
            late_completions: 0,
            evictions: 0,
        },
        record: Record::EMPTY,
    };
}

#[cfg(test)]
mod tests;
