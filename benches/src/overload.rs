//! A look at the forward schedule: what it costs to know that nobody will be late, beside one look at each node.

use std::hint::black_box;

use red_core::{Capacity, Caps, Config, Dag, Duration, Instant, LaneId, Node, Scheduler, Timing, Wcet};

use crate::measure::{Entry, Runner, timed};
use crate::not_run::NotRun;
use crate::ours;

type Few = Caps<1, 8, 8, 4, 2>;
type Many = Caps<1, 16, 64, 4, 2>;

/// The reference: every node of every job, read once.
pub(crate) const READ_ONCE: &str = "each read once";
const MS: u64 = 1_000_000;

/// Both, of 8 jobs of 8 nodes.
pub(crate) fn few() -> Vec<Entry> {
    field::<Few>()
}

/// Both, of 64 jobs of 16 nodes.
pub(crate) fn many() -> Vec<Entry> {
    field::<Many>()
}

fn field<C: Capacity>() -> Vec<Entry> {
    vec![
        Entry { name: READ_ONCE.to_owned(), ours: false, runner: chain::<C>().map(read_once) },
        Entry { name: "RED".to_owned(), ours: true, runner: chain::<C>().and_then(|dag| look(&dag)) },
    ]
}

/// As many nodes as the capacity has, of 1 ms each, one after the other.
fn chain<C: Capacity>() -> Result<Dag<C>, NotRun> {
    let mut dag = Dag::new();
    let mut last = None;
    for _ in 0..C::NODES {
        let node = dag.add_node(Node::new(Wcet::from_nanos(MS))).map_err(ours::failed)?;
        if let Some(last) = last.replace(node) {
            dag.add_edge(last, node).map_err(ours::failed)?;
        }
    }
    Ok(dag)
}

fn read_once<C: Capacity>(dag: Dag<C>) -> Runner {
    timed(move |runs| {
        for _ in 0..runs * C::JOBS {
            let cost = dag.nodes().map(|id| dag.node(id).map_or(0, red_core::Node::cost)).sum::<u64>();
            black_box(cost);
        }
    })
}

/// Two lanes have work for all of the time that there is, so that no bound short of a schedule says that it fits. A lane of
/// another pool that goes and comes has everything looked at again.
fn look<C: Capacity>(dag: &Dag<C>) -> Result<Runner, NotRun> {
    let mut scheduler = Box::new(Scheduler::<C>::new(Config::REDRT.with_lanes(2)));
    scheduler.add_pool(1, None).map_err(ours::failed)?;
    let work = C::JOBS as u64 * C::NODES as u64 * MS / 2;
    let due = Timing::new(Duration::from_nanos(work + C::NODES as u64 * MS / 2));
    let task = scheduler.add_task(dag, due).map_err(ours::failed)?;
    for _ in 0..C::JOBS {
        scheduler.release(task, Instant::ZERO).map_err(ours::failed)?;
    }
    while scheduler.poll(Instant::ZERO).is_some() {}
    let idle = LaneId::new(2);
    Ok(Box::new(move |runs, samples| {
        crate::measure::fill(samples, || {
            for _ in 0..runs {
                black_box(scheduler.retire_lane(idle) && scheduler.restore_lane(idle));
                black_box(scheduler.poll(Instant::ZERO));
            }
        });
        let whole = scheduler.jobs_in_flight() == C::JOBS;
        if whole { Ok(()) } else { Err(NotRun::Failed("RED gave up a job that could be in time".to_owned())) }
    }))
}
