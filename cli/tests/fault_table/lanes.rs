//! Runs on real threads that the rows share: a chain of nodes over two pools of one lane each, so that every node is
//! handed from one lane to the other.

use red_core::{
    Capacity, Caps, Config, Dag, Duration, Event, Instant, JobId, Node, Outcome, PoolId, ReleaseError,
    Scheduler, TaskId, Timing, Wcet,
};
use red_rt::control::Control;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::report::RunReport;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Nodes of the task.
pub(crate) const NODES: usize = 4;
pub(crate) type TwoLanes = Caps<1, 8, 64, 2, 2>;
/// Longer than any run: reaching it means that something stands still.
pub(crate) const FAR_NS: u64 = 60_000_000_000;

/// A run.
pub(crate) struct Plan<B> {
    pub(crate) mode: Mode,
    /// Between two releases; `None`: they come from outside.
    pub(crate) period_ns: Option<u64>,
    pub(crate) duration_ns: u64,
    pub(crate) drain_ns: u64,
    /// What a lane does before its first turn.
    pub(crate) begin: fn(usize),
    /// What a node does on a lane.
    pub(crate) body: B,
}

/// What became of it.
pub(crate) struct Told<H> {
    pub(crate) report: RunReport,
    pub(crate) host: H,
    /// Job and node of each execution, in the order of their beginnings.
    pub(crate) ran: Vec<(u64, usize)>,
}

/// Executions in the order of their beginnings; nobody waits to write one down.
struct Ran {
    next: AtomicUsize,
    places: Vec<AtomicU64>,
}

impl Ran {
    fn push(&self, work: &Work) {
        let place = self.next.fetch_add(1, Ordering::Relaxed);
        self.places[place].store(work.job << 8 | work.node.index() as u64, Ordering::Relaxed);
    }

    fn all(&self) -> Vec<(u64, usize)> {
        let ran = self.places.iter().take(self.next.load(Ordering::Relaxed));
        ran.map(|ran| ran.load(Ordering::Relaxed)).map(|ran| (ran >> 8, (ran & 0xff) as usize)).collect()
    }
}

struct Lane<B> {
    number: usize,
    begin: fn(usize),
    body: Arc<B>,
    ran: Arc<Ran>,
}

impl<B: Fn(usize, &Work) -> Result<(), Failed> + Send + Sync> Handler for Lane<B> {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.ran.push(work);
        (self.body)(self.number, work)
    }

    fn begin(&mut self, _origin_ns: u64) {
        (self.begin)(self.number);
    }
}

/// What the host is told of jobs.
#[derive(Default)]
pub(crate) struct Notes {
    /// Those that found room; a machine that is busy may be late for others.
    pub(crate) released: usize,
    pub(crate) refused: usize,
    pub(crate) ended: Vec<Outcome>,
}

impl<C: Capacity> Host<C> for Notes {
    fn released(&mut self, _task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        self.released += usize::from(taken.is_ok());
        self.refused += usize::from(taken.is_err());
    }

    fn ended(&mut self, outcome: &Outcome) {
        self.ended.push(*outcome);
    }

    fn event(&mut self, _event: &Event) {}
}

/// A chain over both pools, each node of so many milliseconds.
pub(crate) fn chain(wcet_ms: u64) -> (Box<Scheduler<TwoLanes>>, TaskId) {
    let mut scheduler = Box::new(Scheduler::<TwoLanes>::new(Config::EDF));
    scheduler.add_pool(1, None).expect("room for two pools");
    let mut dag = Dag::new();
    let node = |n: usize| Node::new(Wcet::from_millis(wcet_ms)).in_pool(PoolId::new(n as u8 % 2));
    let nodes: Vec<_> = (0..NODES).map(|n| dag.add_node(node(n)).expect("room for the nodes")).collect();
    nodes.windows(2).for_each(|edge| dag.add_edge(edge[0], edge[1]).expect("a chain"));
    let timing = Timing::new(Duration::from_secs(50));
    let task = scheduler.add_task(&dag, timing).expect("room for one task");
    (scheduler, task)
}

impl<B: Fn(usize, &Work) -> Result<(), Failed> + Send + Sync + 'static> Plan<B> {
    /// Best effort, for a while, with a release every few milliseconds.
    pub(crate) fn of(body: B) -> Self {
        Self {
            mode: Mode::BestEffort,
            period_ns: Some(5_000_000),
            duration_ns: 400_000_000,
            drain_ns: FAR_NS,
            begin: |_| (),
            body,
        }
    }

    pub(crate) fn run<H: Host<TwoLanes> + 'static>(
        self,
        host: H,
        started: impl FnOnce(Arc<dyn Control<TwoLanes>>, TaskId),
        progress: impl FnMut(u64),
    ) -> Told<H> {
        let (scheduler, task) = chain(1);
        let places = std::iter::repeat_with(|| AtomicU64::new(0)).take(1 << 16).collect();
        let ran = Arc::new(Ran { next: AtomicUsize::new(0), places });
        let (notes, body, begin) = (ran.clone(), Arc::new(self.body), self.begin);
        let setup = Setup {
            scheduler,
            lanes: 2,
            streams: 0,
            mode: self.mode,
            releases: self
                .period_ns
                .map(|period| Releases { task, first_ns: 0, period_ns: Some(period) })
                .into_iter()
                .collect(),
            duration_ns: self.duration_ns,
            drain_ns: self.drain_ns,
            stop: StopBy::Signals,
            tape: None,
            handlers: Arc::new(move |number| {
                Box::new(Lane { number, begin, body: body.clone(), ran: notes.clone() })
            }),
            enclose: Arc::new(|main| main()),
        };
        let (host, report) = run(setup, host, |control| started(control, task), progress).expect("it starts");
        Told { report, host, ran: ran.all() }
    }
}

impl Told<Notes> {
    /// Asserts that no node ran twice, or before the one ahead of it, and that every job that was released has ended.
    pub(crate) fn is_sound(&self) {
        let mut next = BTreeMap::new();
        for &(job, node) in &self.ran {
            let expected = next.entry(job).or_insert(0);
            assert_eq!(node, *expected, "job {job}");
            *expected += 1;
        }
        let mut jobs: Vec<u64> = self.host.ended.iter().map(|outcome| outcome.index).collect();
        jobs.sort_unstable();
        jobs.dedup();
        assert_eq!(
            (jobs.len(), self.host.ended.len()),
            (self.host.released, self.host.released),
            "each job ends once"
        );
    }

    /// Jobs that were given up.
    pub(crate) fn shed(&self) -> usize {
        self.host.ended.iter().filter(|outcome| outcome.shed.is_some()).count()
    }
}
