//! embassy-executor in deadline order: one task per node, polled by hand on the calling thread.

use std::cell::{Cell, OnceCell};
use std::future::{Future, poll_fn};
use std::ptr;
use std::task::{Poll, Waker};

use embassy_executor::Metadata;
use embassy_executor::raw::{Executor, TaskStorage};

use crate::graphs::{Body, Graph};
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;

/// The executor's request to be polled. It needs no answer: the runner polls until the run is done.
// Sound because the executor declares exactly this symbol, and nothing else in this program defines it.
#[unsafe(export_name = "__pender")]
fn pender(_context: *mut ()) {}

struct Node {
    left: Cell<u32>,
    waker: OnceCell<Waker>,
}

struct Run {
    graph: Graph,
    nodes: Vec<Node>,
    completed: Cell<usize>,
    body: Body,
}

impl Run {
    #[inline(always)]
    fn wake(&self, node: u32) {
        if let Some(waker) = self.nodes[node as usize].waker.get() {
            waker.wake_by_ref();
        }
    }

    /// Releases the graph and polls until it is done. A poll runs at least one woken task.
    fn once(&self, executor: &'static Executor, roots: &[u32]) {
        self.completed.set(0);
        for (node, &indegree) in self.nodes.iter().zip(&self.graph.indegree) {
            node.left.set(indegree);
        }
        for &root in roots {
            self.wake(root);
        }
        let mut polls = 0..self.nodes.len();
        while self.completed.get() < self.nodes.len() && polls.next().is_some() {
            poll(executor);
        }
    }

    /// The task of one node, over all runs.
    async fn node(&self, node: usize) {
        let own = &self.nodes[node];
        Metadata::for_current_task().await.set_deadline(self.graph.deadline(node));
        poll_fn(|context| {
            own.waker.get_or_init(|| context.waker().clone());
            Poll::Ready(())
        })
        .await;
        loop {
            poll_fn(|_| if own.left.get() == 0 { Poll::Ready(()) } else { Poll::Pending }).await;
            self.body.run(node);
            // Not ready again before the next release sets the count.
            own.left.set(u32::MAX);
            for &successor in &self.graph.successors[node] {
                let left = &self.nodes[successor as usize].left;
                left.set(left.get() - 1);
                if left.get() == 0 {
                    self.wake(successor);
                }
            }
            self.completed.set(self.completed.get() + 1);
        }
    }
}

fn spawn<F: Future + 'static>(executor: &'static Executor, task: impl FnOnce() -> F) -> Result<(), NotRun> {
    let storage: &'static TaskStorage<F> = Box::leak(Box::new(TaskStorage::new()));
    let token = storage.spawn(task).map_err(|error| NotRun::Failed(format!("embassy task: {error:?}")))?;
    executor.spawner().spawn(token);
    Ok(())
}

fn poll(executor: &'static Executor) {
    // SAFETY: called only from the runner, which no task and no pender calls, so never reentrantly.
    unsafe { executor.poll() };
}

/// Runs the graph on the calling thread. Executor and tasks are leaked: embassy wants them for ever.
pub(crate) fn build(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let executor: &'static Executor = Box::leak(Box::new(Executor::new(ptr::null_mut())));
    let nodes =
        (0..setup.graph.nodes()).map(|_| Node { left: Cell::new(1), waker: OnceCell::new() }).collect();
    let run: &'static Run = Box::leak(Box::new(Run {
        graph: setup.graph.clone(),
        nodes,
        completed: Cell::new(0),
        body: setup.body,
    }));
    for node in 0..setup.graph.nodes() {
        spawn(executor, move || run.node(node))?;
    }
    // Each task leaves its waker and then waits for its first release.
    poll(executor);
    let roots = setup.graph.roots();
    Ok(Box::new(move |runs, samples| {
        fill(samples, || (0..runs).for_each(|_| run.once(executor, &roots)));
        if run.completed.get() < run.nodes.len() {
            return Err(NotRun::Failed("embassy left a task that was woken".to_owned()));
        }
        Ok(())
    }))
}
