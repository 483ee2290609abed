//! Two lanes over a shared scheduler, as every concurrent host has them: a lane reports, applies what is due, polls
//! until nothing comes, and runs what it was given. What is handed over lies under the lock, and lanes sleep on their
//! bells; seat and waiting lanes have models of their own.

use crate::bell::{Bell, Woken};
use crate::shared::{Request, SharedScheduler};
use crate::{Exclusive, ideal::Ideal};
use loom::cell::UnsafeCell;
use loom::thread;
use red_core::{
    Action, Caps, CompleteError, Config, Dag, Duration, Instant, LaneId, Node, NodeId, Outcome, Scheduler,
    TaskId, Timing, UnitId, Wcet,
};
use std::sync::{Arc, Mutex, PoisonError};

/// One task, five nodes, three jobs, two lanes.
pub type Small = Caps<1, 5, 3, 2>;
/// Lanes of the host.
pub const LANES: usize = 2;
/// Nodes of a graph, by number.
pub type Edges = &'static [(u8, u8)];

/// A unit: which job, which node, and the job's graph.
type Work = (UnitId, usize, u8, Edges);

/// A host, and what is held against it.
#[derive(Debug)]
pub struct Host<L> {
    /// The scheduler.
    pub shared: SharedScheduler<Small, L, 1, 2>,
    /// The only task.
    pub task: TaskId,
    /// Written by each body, read by those of its successors: the checker sees a start that comes too early.
    results: Vec<UnsafeCell<u8>>,
    /// Only touched under the scheduler's lock, so it is none that the checker has to know.
    notes: Mutex<Notes>,
    bells: [Bell; LANES],
    planted: Option<Planted>,
}

/// A fault of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planted {
    /// Lanes ask for work before they report.
    ReportsLate,
    /// The scheduler was told of fewer edges than there are, and nobody looks at what is ready.
    LosesEdges,
}

/// What happened, and what has to.
#[derive(Debug, Default)]
pub struct Notes {
    /// Graphs of the jobs, in the order of their release.
    pub graphs: Vec<Edges>,
    /// The graph of jobs that are released from now on.
    pub graph: Edges,
    /// Nodes that ended, by job.
    pub ended: Vec<Vec<u8>>,
    /// Outcomes of jobs.
    pub outcomes: Vec<Outcome>,
    /// Jobs after which the run is over.
    pub jobs: usize,
    inbox: [Option<Work>; LANES],
    turns: u64,
}

// SAFETY: results are the checker's cells: it says when one is reached by two at once.
unsafe impl<L: Sync> Sync for Host<L> {}
// SAFETY: they go with the host.
unsafe impl<L: Send> Send for Host<L> {}

/// A graph of so many nodes as its edges say; node 0 is in each.
///
/// # Panics
/// If the edges are no graph.
pub fn dag(edges: Edges) -> Dag<Small> {
    let mut dag = Dag::new();
    let nodes = edges.iter().flat_map(|(from, to)| [*from, *to]).max().unwrap_or(0);
    for _ in 0..=nodes {
        dag.add_node(Node::new(Wcet::from_millis(1))).expect("there is room");
    }
    edges.iter().for_each(|(from, to)| dag.add_edge(NodeId::new(*from), NodeId::new(*to)).expect("no cycle"));
    dag
}

impl<L: Exclusive<Scheduler<Small>>> Host<L> {
    /// A host whose task has this graph. The run is over after so many jobs.
    ///
    /// # Panics
    /// If the edges are no graph.
    #[must_use]
    pub fn new(edges: Edges, jobs: usize) -> Self {
        let mut scheduler = Scheduler::new(Config::REDRT.with_lanes(LANES as u8));
        let task =
            scheduler.add_task(&dag(edges), Timing::new(Duration::from_secs(1))).expect("room for one task");
        Self {
            shared: SharedScheduler::new(scheduler),
            task,
            results: (0..3 * 5).map(|_| UnsafeCell::new(0)).collect(),
            notes: Mutex::new(Notes { graph: edges, jobs, ..Notes::default() }),
            bells: Default::default(),
            planted: None,
        }
    }

    /// With a fault.
    #[must_use]
    pub fn planted(self, planted: Planted) -> Self {
        Self { planted: Some(planted), ..self }
    }

    /// Asks for a job from outside, and wakes the lanes.
    ///
    /// # Panics
    /// If the mailbox is full.
    pub fn request(&self) {
        let post = self.shared.producer(0).expect("nobody else posts");
        post.push(Request { task: self.task, at: Instant::ZERO, capture: None }).expect("there is room");
        self.wake();
    }

    /// A turn of somebody who is no lane, or of a lane before its work: `f`, and then the work is handed out.
    pub fn act<R>(&self, f: impl FnOnce(&mut Scheduler<Small>, &mut Notes, Instant) -> R) -> R {
        let result = self.shared.with(|scheduler, _| {
            let mut notes = self.notes();
            notes.turns += 1;
            let now = Instant::from_nanos(notes.turns);
            let result = f(scheduler, &mut notes, now);
            self.hand_out(scheduler, &mut notes, LaneId::new(0), now);
            result
        });
        self.wake();
        result
    }

    /// A lane, until the run is over.
    pub fn lane(&self, me: usize) {
        let mut done = None;
        loop {
            let (mine, is_over, has_news) = self.turn(me, done);
            if has_news {
                self.bells[1 - me].ring();
            }
            done = match mine {
                Some(work) => {
                    self.body(work);
                    Some(work)
                }
                None if is_over => return,
                None => {
                    assert_eq!(self.bells[me].wait(None, 0), Woken::Rung);
                    None
                }
            };
        }
    }

    /// What happened.
    ///
    /// # Panics
    /// If a job was forgotten, or is not what its graph says.
    pub fn check(&self) {
        self.shared.with(|scheduler, _| {
            let notes = self.notes();
            assert_eq!(
                (notes.outcomes.len(), scheduler.jobs_in_flight()),
                (notes.jobs, 0),
                "a job was forgotten"
            );
            assert_eq!(
                (scheduler.running_units(), scheduler.ready_sub_jobs()),
                (0, 0),
                "a unit was forgotten"
            );
            for (job, outcome) in notes.outcomes.iter().enumerate() {
                assert!(notes.outcomes[..job].iter().all(|o| o.index != outcome.index), "a job ended twice");
                if outcome.shed.is_none() {
                    let mut ended = notes.ended[outcome.index as usize].clone();
                    ended.sort_unstable();
                    assert_eq!(ended, nodes(notes.graphs[outcome.index as usize]), "nodes of one version");
                }
            }
        });
    }

    /// Reports, takes requests and work. What this lane runs, whether the run is over, and whether that or work is
    /// news to another lane.
    fn turn(&self, me: usize, done: Option<Work>) -> (Option<Work>, bool, bool) {
        self.shared.with(|scheduler, requests| {
            let mut notes = self.notes();
            notes.turns += 1;
            let now = Instant::from_nanos(notes.turns);
            if self.planted != Some(Planted::ReportsLate) {
                report(scheduler, &mut notes, done, now);
            }
            while let Some(request) = requests.next() {
                scheduler.release_at(request.task, request.at, request.capture, now).expect("there is room");
                let graph = notes.graph;
                notes.graphs.push(graph);
                notes.ended.push(Vec::new());
            }
            self.hand_out(scheduler, &mut notes, LaneId::new(me as u8), now);
            if self.planted == Some(Planted::ReportsLate) {
                report(scheduler, &mut notes, done, now);
            }
            // M2: no ready node waits beside an idle lane.
            let is_idle = scheduler.running_units() < LANES;
            assert!(!is_idle || scheduler.ready_sub_jobs() == 0, "a ready node waits beside an idle lane");
            // M3, and nothing forgotten: what is ready by the graphs is ready, or runs.
            let by_graph: usize = (0..notes.graphs.len()).map(|job| notes.begun_or_ready(job)).sum();
            let in_flight = scheduler.running_units() + scheduler.ready_sub_jobs();
            let is_seen = self.planted == Some(Planted::LosesEdges) || !notes.outcomes.is_empty();
            assert!(
                is_seen || by_graph == in_flight,
                "ready by the graph: {by_graph}, in flight: {in_flight}"
            );
            let (mine, is_over) = (notes.inbox[me].take(), notes.outcomes.len() == notes.jobs);
            (mine, is_over, is_over || notes.inbox.iter().any(Option::is_some))
        })
    }

    fn hand_out(&self, scheduler: &mut Scheduler<Small>, notes: &mut Notes, lane: LaneId, now: Instant) {
        while let Some(action) = scheduler.poll_on(lane, now) {
            match action {
                Action::Dispatch(dispatch) => {
                    let unit = scheduler.unit(dispatch.unit).expect("it was just given out").first;
                    let place = &mut notes.inbox[dispatch.lane.index()];
                    assert_eq!(*place, None, "a lane was given two units");
                    let job = unit.index as usize;
                    *place = Some((dispatch.unit, job, unit.node.index() as u8, notes.graphs[job]));
                }
                Action::Ended(outcome) => notes.outcomes.push(outcome),
                _ => {}
            }
        }
    }

    /// Runs a node: reads what its predecessors wrote, and writes its own, once.
    fn body(&self, (_, job, node, graph): Work) {
        let result = |node: u8| &self.results[job * 5 + usize::from(node)];
        for (from, _) in graph.iter().filter(|(_, to)| *to == node) {
            // SAFETY: by Lemma 1 the predecessor has ended; the checker says if not.
            result(*from)
                .with(|value| assert_eq!(unsafe { *value }, 1, "started before a predecessor ended"));
        }
        // SAFETY: nobody else runs this node of this job; the checker says if so.
        let before = result(node).with_mut(|value| unsafe { value.replace(1) });
        assert_eq!(before, 0, "started twice");
    }

    fn wake(&self) {
        self.bells.iter().for_each(Bell::ring);
    }

    fn notes(&self) -> std::sync::MutexGuard<'_, Notes> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Notes {
    /// Nodes of a job that may run by its graph and have not been reported.
    fn begun_or_ready(&self, job: usize) -> usize {
        let (graph, ended) = (self.graphs[job], &self.ended[job]);
        let may_run = |node: &u8| graph.iter().all(|(from, to)| to != node || ended.contains(from));
        nodes(graph).iter().filter(|node| !ended.contains(node) && may_run(node)).count()
    }
}

fn report(scheduler: &mut Scheduler<Small>, notes: &mut Notes, done: Option<Work>, now: Instant) {
    if let Some((unit, job, node, _)) = done {
        match scheduler.complete(unit, now) {
            Ok(()) => notes.ended[job].push(node),
            Err(refused) => assert_ne!(refused, CompleteError::NotRunning),
        }
    }
}

fn nodes(edges: Edges) -> Vec<u8> {
    let mut nodes: Vec<u8> = edges.iter().flat_map(|(from, to)| [*from, *to]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Starts lane 0; the caller is the rest.
pub fn start<L>(host: &Arc<Host<L>>, lane: usize) -> thread::JoinHandle<()>
where
    L: Exclusive<Scheduler<Small>> + Send + Sync + 'static,
{
    let host = host.clone();
    thread::spawn(move || host.lane(lane))
}

/// A host over the checker's lock.
pub type IdealHost = Host<Ideal<Scheduler<Small>>>;
