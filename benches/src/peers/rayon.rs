//! rayon: a scope per run, one spawn per ready node, work stealing.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::{Scope, ThreadPoolBuilder};

use crate::graphs::{Body, Graph};
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;

struct Run {
    graph: Graph,
    left: Vec<AtomicU32>,
    body: Body,
}

impl Run {
    fn node<'scope>(&'scope self, scope: &Scope<'scope>, node: u32) {
        self.body.run(node as usize);
        for &successor in &self.graph.successors[node as usize] {
            if self.left[successor as usize].fetch_sub(1, Ordering::AcqRel) == 1 {
                scope.spawn(move |scope| self.node(scope, successor));
            }
        }
    }
}

/// Runs the graph in a pool with one pinned thread per lane. All samples of a round are taken inside the pool,
/// so that the cost of entering it is not counted.
pub(crate) fn build(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let machine = setup.machine;
    let pool = ThreadPoolBuilder::new()
        .num_threads(setup.lanes)
        // A thread that cannot be pinned still works, on whatever CPU it inherited.
        .start_handler(move |lane| drop(machine.become_lane(lane)))
        .build()
        .map_err(|error| NotRun::Failed(error.to_string()))?;
    let graph = setup.graph.clone();
    let roots = graph.roots();
    let left = graph.indegree.iter().map(|_| AtomicU32::new(0)).collect();
    let run = Run { graph, left, body: setup.body };
    Ok(Box::new(move |runs, samples| {
        pool.install(|| {
            fill(samples, || {
                for _ in 0..runs {
                    for (left, &indegree) in run.left.iter().zip(&run.graph.indegree) {
                        left.store(indegree, Ordering::Relaxed);
                    }
                    let run = &run;
                    rayon::scope(|scope| {
                        for &root in &roots {
                            scope.spawn(move |scope| run.node(scope, root));
                        }
                    });
                }
            });
        });
        Ok(())
    }))
}
