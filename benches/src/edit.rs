//! An edit of a live graph: what its commit costs, beside one look at each node and each edge of it.

use std::hint::black_box;
use std::time::{Duration, Instant as Clock};

use red_core::{Caps, Config, Dag, Instant, PoolId, Scheduler};

use crate::graphs::Graph;
use crate::measure::{Entry, Runner, timed};
use crate::not_run::NotRun;
use crate::ours;

type Edited = Caps<1, 256, 1, 1, 1, 4>;

/// The reference: every node and every edge, read once.
pub(crate) const READ_ONCE: &str = "each read once";

/// Both, at the start line.
pub(crate) fn field(graph: &Graph) -> Vec<Entry> {
    let dag = || ours::dag::<Edited>(graph, |_| PoolId::new(0));
    vec![
        Entry { name: READ_ONCE.to_owned(), ours: false, runner: dag().map(read_once) },
        Entry { name: "RED".to_owned(), ours: true, runner: dag().and_then(|dag| commit(&dag)) },
    ]
}

fn read_once(dag: Dag<Edited>) -> Runner {
    timed(move |runs| {
        for _ in 0..runs {
            let mut sum = 0;
            for id in dag.nodes() {
                sum += dag.node(id).map_or(0, red_core::Node::cost);
                dag.successors(id).each(|successor| sum += successor as u64);
            }
            black_box(sum);
        }
    })
}

/// Each edit begins from the graph of the one before, so that it is made anew for each commit; that is not timed.
fn commit(dag: &Dag<Edited>) -> Result<Runner, NotRun> {
    let mut scheduler = Box::new(Scheduler::<Edited>::new(Config::REDRT));
    let task = ours::admit(&mut scheduler, dag)?;
    Ok(Box::new(move |runs, samples| {
        for sample in samples {
            let mut spent = Duration::ZERO;
            for _ in 0..runs {
                let edit =
                    scheduler.edit(task).ok_or_else(|| NotRun::Failed("RED lost a task".to_owned()))?;
                let start = Clock::now();
                let proof = scheduler.commit(&edit, Instant::ZERO).map_err(ours::failed)?;
                spent += start.elapsed();
                let _ = black_box(proof);
            }
            *sample = spent.as_nanos() as u64;
        }
        Ok(())
    }))
}
