//! A slow reference scheduler: the specification's rules, recomputed from scratch at every step, each node
//! executing for exactly its WCET.
//!
//! Nothing here is fast or clever. Ready nodes are found by looking at every node of every job, queues are
//! sorted on every pick, levels and paths are recomputed whenever they are asked for.
#![doc = include_str!("oracle/READINGS.md")]

mod alone;
mod band;
mod cache;
mod dispatch;
mod forward;
mod job;
mod keys;
mod lookahead;
mod outcome;
mod rank;
mod releases;
mod shed;

use red_workload::model::Workload;

pub use outcome::{Outcome, Reason, Row, ShedRow, TaskOutcome};

use job::{FrameKey, Job, SubId};
use releases::TaskState;

/// The named configurations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// Whole stages, end-to-end deadlines.
    Edf,
    /// Refined stages, level shares, level gate.
    RedFg,
    /// `RedFg`, re-assigned at each dispatch.
    RedIda,
    /// `RedIda` with merging, precedence gate and the paper's overload rule.
    Red,
    /// Latest start, merging, frame cache, jobs given up as soon as they or others are known to be late.
    Redrt,
    /// `Redrt`, with lanes that wait for a pressing node that is soon ready.
    RedrtLookahead,
}

impl Policy {
    /// All of them, in the order of the paper's table, ours last.
    pub const ALL: [Self; 6] =
        [Self::Edf, Self::RedFg, Self::RedIda, Self::Red, Self::Redrt, Self::RedrtLookahead];

    /// Whether it is ours, with or without lanes that wait.
    pub fn is_ours(self) -> bool {
        matches!(self, Self::Redrt | Self::RedrtLookahead)
    }

    /// Whether stages become encoder and decoders.
    pub fn refines(self) -> bool {
        self != Self::Edf
    }

    /// Whether a node waits for every node of every lower level of its job.
    pub fn gates_levels(self) -> bool {
        matches!(self, Self::RedFg | Self::RedIda)
    }

    /// Whether sub-deadlines are re-assigned at each dispatch.
    pub fn reassigns(self) -> bool {
        matches!(self, Self::RedIda | Self::Red)
    }

    /// Whether ready encoders of one key form a unit.
    pub fn merges(self) -> bool {
        self == Self::Red || self.is_ours()
    }

    /// Whether encoder outputs are kept for later stages.
    pub fn caches(self) -> bool {
        self.is_ours()
    }

    /// Whether the overload monitor ticks.
    pub fn monitors(self) -> bool {
        self == Self::Red
    }

    /// Whether the periodic barrier of the workload holds dispatches.
    pub fn waits_for_grid(self) -> bool {
        matches!(self, Self::Edf | Self::RedFg | Self::RedIda)
    }
}

/// Monitor tick, from instant 0.
pub const TICK_NS: u64 = 5_000_000;
/// Ticks of overload before anything is dropped.
pub const OVERLOAD_TICKS: u32 = 3;
/// Queue length above which a tick may count.
pub const QUEUE_MAX: usize = 8;
/// Utilisation above which a tick may count, in millionths.
pub const UTILISATION_PPM: u128 = 900_000;
/// Widest spread of the releases within a merged unit.
pub const MERGE_WINDOW_NS: u64 = 100_000_000;
/// Jobs in flight beyond which a release is shed, or takes the place of another.
pub const JOBS_IN_FLIGHT: usize = 64;
/// Jobs of a task over which floors remember who was lost.
pub const FLOOR_MEMORY: u64 = 128;
/// One job of so many is a probe.
pub const PROBE_EVERY: u64 = 17;
/// So many jobs tell whether a task only loses.
pub const RECENT_JOBS: u64 = 16;
/// Executions of a node that tell how long it takes.
pub const WINDOW: u32 = 8;
/// Jobs that leave in one look.
pub const LEAVE_AT_MOST: usize = 16;

/// Simulates `workload` over [0, `horizon_ns`) under `policy`, without preemption.
///
/// # Panics
///
/// If the workload breaks a rule that its parser enforces: a cycle, a pool without lanes, a period of zero.
pub fn simulate(workload: &Workload, policy: Policy, horizon_ns: u64) -> Outcome {
    let mut sim = Sim::new(workload, policy, horizon_ns);
    while let Some(now) = sim.next_instant().filter(|&now| now < horizon_ns) {
        sim.step(now);
    }
    sim.into_outcome()
}

/// Something that holds a lane: one sub-job, or encoders merged.
struct Unit {
    pool: usize,
    lane: u32,
    finish: u64,
    memory: u64,
    /// Set where the unit is an encoder.
    key: Option<FrameKey>,
    members: Vec<SubId>,
}

/// An encoder output that is kept.
struct Cached {
    key: FrameKey,
    pool: usize,
    memory: u64,
}

struct Sim<'a> {
    workload: &'a Workload,
    policy: Policy,
    horizon: u64,
    /// The last instant that was processed.
    now: Option<u64>,
    tasks: Vec<TaskState>,
    /// Jobs in flight, in order of release, tasks in file order.
    jobs: Vec<Job>,
    running: Vec<Unit>,
    cached: Vec<Cached>,
    /// Consecutive ticks of overload.
    over: u32,
    /// Whether a job came or a result was thrown away since the last look at who will be late.
    look_due: bool,
    /// Until when there is pressure in each pool, that instant excluded (8.10).
    pressure_until: Vec<i128>,
    /// Where the last look found pressure.
    pressed: Vec<bool>,
    /// When a dispatch that waits for the grid happens.
    barrier: Option<u64>,
    /// When a pool that left a lane idle looks again.
    wake: Option<u64>,
    /// How many units overtook each head that did not fit into memory.
    overtaken: Vec<(SubId, u32)>,
    /// Executions that the next tick may see: pool, start, finish.
    executions: Vec<(usize, u64, u64)>,
    outcome: Outcome,
}

impl<'a> Sim<'a> {
    fn new(workload: &'a Workload, policy: Policy, horizon: u64) -> Self {
        Sim {
            workload,
            policy,
            horizon,
            now: None,
            tasks: workload.tasks.iter().map(|task| TaskState::new(task, policy)).collect(),
            jobs: Vec::new(),
            running: Vec::new(),
            cached: Vec::new(),
            over: 0,
            look_due: false,
            pressure_until: vec![0; workload.pools.len()],
            pressed: vec![false; workload.pools.len()],
            barrier: None,
            wake: None,
            overtaken: Vec::new(),
            executions: Vec::new(),
            outcome: Outcome::new(workload),
        }
    }

    /// The next instant at which anything happens.
    fn next_instant(&self) -> Option<u64> {
        let after = |instant: &u64| self.now.is_none_or(|now| *instant > now);
        let finishes = self.running.iter().map(|unit| unit.finish);
        let releases = (0..self.tasks.len()).filter_map(|task| self.next_release(task));
        let events = self.workload.events.iter().map(|event| event.at_ns);
        let tick = self.policy.monitors().then(|| self.now.map_or(0, |now| (now / TICK_NS + 1) * TICK_NS));
        finishes
            .chain(releases)
            .chain(events)
            .chain(tick)
            .chain(self.barrier)
            .chain(self.wake)
            .filter(after)
            .min()
    }

    /// One instant: all its events, then the lanes, again while something ends at once.
    fn step(&mut self, now: u64) {
        self.now = Some(now);
        let mut first = true;
        loop {
            let ended = self.complete(now);
            let edited = self.edit(now);
            let released = first && self.release(now);
            // Who was waited for is later than it was to be.
            self.look_due |= released || self.wake.is_some_and(|wake| wake <= now);
            let tick = first && self.policy.monitors() && now.is_multiple_of(TICK_NS);
            if tick {
                self.observe(now);
            }
            let before = self.jobs.len();
            self.shed(now, tick);
            let shed = self.jobs.len() < before;
            // A pool that left a lane idle looks again when something happened, or when it said.
            if ended || edited || released || shed || self.wake.is_none_or(|wake| wake <= now) {
                self.dispatch(now);
            }
            // A start threw a result away.
            while self.look_due {
                self.shed(now, false);
                self.dispatch(now);
            }
            first = false;
            if self.running.iter().all(|unit| unit.finish > now) {
                return;
            }
        }
    }

    /// Applies the completions of this instant, by pool, then lane; whether there are any.
    fn complete(&mut self, now: u64) -> bool {
        let (mut ended, running): (Vec<Unit>, Vec<Unit>) =
            self.running.drain(..).partition(|unit| unit.finish == now);
        self.running = running;
        let any = !ended.is_empty();
        ended.sort_by_key(|unit| (unit.pool, unit.lane));
        for unit in ended {
            let mut living = 0;
            for &(task, index, node) in &unit.members {
                if let Some(job) = self.job_mut(task, index) {
                    job.state[node] = job::State::Done;
                    living += 1;
                    let (version, name) = (job.version, job.graph.nodes[node].name.clone());
                    if unit.members.len() == 1 {
                        self.tasks[task].executed(version, &name);
                    }
                }
            }
            if let Some(key) = unit.key {
                self.outcome.encoder_runs_saved += living.max(1) - 1;
                if self.policy.caches() {
                    self.cached.push(Cached { key, pool: unit.pool, memory: unit.memory });
                }
            }
        }
        self.settle(now);
        any
    }

    /// After nodes became done or jobs appeared: cache hits, ended jobs, outputs that nobody needs.
    fn settle(&mut self, now: u64) {
        self.hit(now);
        let (ended, living): (Vec<Job>, Vec<Job>) = self.jobs.drain(..).partition(Job::is_complete);
        self.jobs = living;
        for job in ended {
            self.outcome.end(&job, now);
        }
        self.drop_unused();
    }

    fn job_mut(&mut self, task: usize, index: u64) -> Option<&mut Job> {
        self.jobs.iter_mut().find(|job| job.task == task && job.index == index)
    }

    fn job(&self, task: usize, index: u64) -> Option<&Job> {
        self.jobs.iter().find(|job| job.task == task && job.index == index)
    }
}

#[cfg(test)]
mod tests;
