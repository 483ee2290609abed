//! *Claim.* With four lanes and two releasers over one scheduler, random graphs and edits, every job runs the nodes of
//! one version of its graph, each once and after its predecessors; no ready node waits beside an idle lane; none is
//! forgotten.
//!
//! *Threads.* Seven: four lanes, two releasers, one editor.
//! *Bound.* Some thousands of random schedules, of a seed that is printed; `SHUTTLE_SEED` gives another.
//! *Sources.* `sync/src/shared.rs`
#![cfg(not(loom))]

use red_core::{
    Action, Caps, Config, Dag, Duration, Instant, LaneId, Node, NodeId, Scheduler, ShedReason, TaskId,
    Timing, UnitId, Wcet,
};
use red_sync::{Exclusive, Request, SharedScheduler};
use shuttle::rand::{Rng, thread_rng};
use shuttle::scheduler::RandomScheduler;
use shuttle::sync::{Condvar, Mutex};
use shuttle::{Config as Exploration, Runner, thread};
use std::sync::Arc;

const LANES: usize = 4;
const RELEASERS: usize = 2;
const JOBS_EACH: usize = 2;
const EDITS: usize = 2;
const NODES: usize = 8;
const SCHEDULES: usize = 3_000;
const SEED: u64 = 0x5EED;

type Four = Caps<1, NODES, 8, LANES>;

/// Shuttle's lock in the place of the real one.
struct Lock<T>(Mutex<T>);

impl<T> Exclusive<T> for Lock<T> {
    fn new(value: T) -> Self {
        Self(Mutex::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        f(&mut self.0.lock().expect("nobody panics under the lock"))
    }
}

struct Host {
    shared: SharedScheduler<Four, Lock<Scheduler<Four>>, RELEASERS, 8>,
    notes: Mutex<Notes>,
    changed: Condvar,
}

struct Notes {
    /// The newest graph, and that of each job.
    graph: Dag<Four>,
    jobs: Vec<Job>,
    ended: usize,
    inbox: [Option<(UnitId, usize, NodeId)>; LANES],
    /// Requests that were posted and not taken, so that no lane sleeps beside one.
    posted: usize,
    now: u64,
}

struct Job {
    graph: Dag<Four>,
    begun: Vec<NodeId>,
    done: Vec<NodeId>,
}

/// A graph whose edges go upwards, each with a chance of one half.
fn random_graph() -> Dag<Four> {
    let mut random = thread_rng();
    let mut dag = Dag::new();
    let nodes: Vec<NodeId> = (0..random.gen_range(2..=5))
        .map(|_| dag.add_node(Node::new(Wcet::from_millis(random.gen_range(1..5)))).expect("there is room"))
        .collect();
    for (at, to) in nodes.iter().enumerate() {
        for from in nodes[..at].iter().filter(|_| random.gen_bool(0.5)) {
            dag.add_edge(*from, *to).expect("upwards");
        }
    }
    dag
}

impl Host {
    fn turn(&self, me: usize, done: Option<(UnitId, usize, NodeId)>) -> Option<(UnitId, usize, NodeId)> {
        self.shared.with(|scheduler, requests| {
            let mut notes = self.notes.lock().expect("nobody panics");
            notes.now += 1;
            let now = Instant::from_nanos(notes.now);
            if let Some((unit, job, node)) = done {
                scheduler.complete(unit, now).expect("it ran");
                notes.jobs[job].done.push(node);
            }
            while let Some(request) = requests.next() {
                notes.posted -= 1;
                scheduler.release_at(request.task, request.at, request.capture, now).expect("there is room");
                let graph = notes.graph;
                notes.jobs.push(Job { graph, begun: Vec::new(), done: Vec::new() });
            }
            while let Some(action) = scheduler.poll_on(LaneId::new(me as u8), now) {
                match action {
                    Action::Dispatch(dispatch) => {
                        let unit = scheduler.unit(dispatch.unit).expect("just given out").first;
                        let place = &mut notes.inbox[dispatch.lane.index()];
                        assert!(place.is_none(), "a lane was given two units");
                        *place = Some((dispatch.unit, unit.index as usize, unit.node));
                    }
                    Action::Ended(outcome) => {
                        assert_eq!(outcome.shed, None::<ShedReason>, "nothing is given up here");
                        let job = &notes.jobs[outcome.index as usize];
                        assert_eq!(job.done.len(), job.graph.len(), "nodes of one version, each once");
                        notes.ended += 1;
                    }
                    _ => {}
                }
            }
            let is_idle = scheduler.running_units() < LANES;
            assert!(!is_idle || scheduler.ready_sub_jobs() == 0, "a ready node waits beside an idle lane");
            self.changed.notify_all();
            notes.inbox[me].take()
        })
    }

    fn lane(&self, me: usize) {
        let mut done = None;
        loop {
            let mine = self.turn(me, done.take());
            let mut notes = self.notes.lock().expect("nobody panics");
            if let Some((_, job, node)) = mine {
                let job = &mut notes.jobs[job];
                assert!(!job.begun.contains(&node), "started twice");
                let is_early = job.graph.nodes().any(|from| {
                    job.graph.successors(from).contains(node.index()) && !job.done.contains(&from)
                });
                assert!(!is_early, "started before a predecessor ended");
                job.begun.push(node);
                done = mine;
                continue;
            }
            while notes.inbox[me].is_none() && notes.posted == 0 {
                if notes.ended == RELEASERS * JOBS_EACH {
                    return;
                }
                notes = self.changed.wait(notes).expect("nobody panics");
            }
        }
    }

    fn release(&self, number: usize, task: TaskId) {
        let post = self.shared.producer(number).expect("nobody else posts");
        for _ in 0..JOBS_EACH {
            thread::yield_now();
            let mut notes = self.notes.lock().expect("nobody panics");
            post.push(Request { task, at: Instant::ZERO, capture: None }).expect("there is room");
            notes.posted += 1;
            drop(notes);
            self.changed.notify_all();
        }
    }

    /// Adds a node behind another, or takes one away. A third version has to wait; then nothing happens.
    fn edit(&self, task: TaskId) {
        self.shared.with(|scheduler, _| {
            let mut notes = self.notes.lock().expect("nobody panics");
            let now = Instant::from_nanos(notes.now);
            let mut edit = scheduler.edit(task).expect("the task is there");
            let nodes: Vec<NodeId> = edit.nodes().collect();
            let node = nodes[thread_rng().gen_range(0..nodes.len())];
            let is_changed = if thread_rng().gen_bool(0.5) && nodes.len() > 1 {
                edit.remove_node(node)
            } else {
                let new = edit.add_node(Node::new(Wcet::from_millis(1)));
                new.is_ok_and(|new| edit.add_edge(node, new).is_ok())
            };
            if is_changed && scheduler.commit(&edit, now).is_ok() {
                notes.graph = edit;
            }
        });
    }
}

fn run(forgets_an_edge: bool) {
    let graph = random_graph();
    let mut scheduler = Scheduler::new(Config::EDF.with_lanes(LANES as u8));
    let task = scheduler.add_task(&graph, Timing::new(Duration::from_secs(1))).expect("room for one task");
    let mut known = graph;
    if forgets_an_edge {
        // What is held against the scheduler has an edge more than it was told of.
        let nodes: Vec<NodeId> = known.nodes().collect();
        let _is_new = known.add_edge(nodes[0], nodes[nodes.len() - 1]);
    }
    let notes = Notes { graph: known, jobs: Vec::new(), ended: 0, inbox: [None; LANES], posted: 0, now: 0 };
    let host = Arc::new(Host {
        shared: SharedScheduler::new(scheduler),
        notes: Mutex::new(notes),
        changed: Condvar::new(),
    });
    let mut threads: Vec<_> = (0..LANES)
        .map(|lane| {
            let host = host.clone();
            thread::spawn(move || host.lane(lane))
        })
        .collect();
    threads.extend((0..RELEASERS).map(|number| {
        let host = host.clone();
        thread::spawn(move || host.release(number, task))
    }));
    if !forgets_an_edge {
        (0..EDITS).for_each(|_| {
            host.edit(task);
            thread::yield_now();
        });
    }
    threads.into_iter().for_each(|thread| thread.join().expect("it ends"));
    assert_eq!(host.notes.lock().expect("nobody panics").ended, RELEASERS * JOBS_EACH, "a job was forgotten");
}

fn explore(schedules: usize, claim: impl Fn() + Send + Sync + 'static) {
    let seed = std::env::var("SHUTTLE_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(SEED);
    println!("{schedules} schedules of seed {seed}");
    Runner::new(RandomScheduler::new_from_seed(seed, schedules), Exploration::new()).run(claim);
}

#[test]
fn four_lanes_run_random_graphs_while_they_are_edited() {
    explore(SCHEDULES, || run(false));
}

#[test]
#[should_panic(expected = "started before a predecessor ended")]
fn a_graph_without_an_edge_is_caught() {
    explore(SCHEDULES, || run(true));
}
