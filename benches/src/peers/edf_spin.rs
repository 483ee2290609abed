//! The 40-line EDF shared by two pinned lanes behind one test-and-test-and-set spin lock.

use std::hint;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use spin::mutex::SpinMutex;

use crate::companion::Companion;
use crate::graphs::Body;
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;
use crate::peers::edf::{Plan, State};

struct Shared {
    plan: Plan,
    state: SpinMutex<State>,
    /// Nodes of this run that have not completed; on it the releasing lane waits without taking the lock.
    left: AtomicUsize,
    body: Body,
    call: fn(Body, usize),
}

impl Shared {
    /// Runs ready nodes until there is none; each completion and the choice of the next node share one hold of
    /// the lock.
    fn drain(&self) {
        let mut next = self.state.lock().next();
        while let Some(node) = next {
            (self.call)(self.body, node);
            let mut state = self.state.lock();
            state.complete(&self.plan, node);
            next = state.next();
            drop(state);
            self.left.fetch_sub(1, Ordering::Release);
        }
        hint::spin_loop();
    }
}

/// Runs the graph on the calling thread and on one companion.
pub(crate) fn build(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let plan = Plan::new(setup.graph);
    let shared = Arc::new(Shared {
        state: SpinMutex::new(plan.state()),
        plan,
        left: AtomicUsize::new(0),
        body: setup.body,
        call: setup.body.behind_pointer(),
    });
    let nodes = setup.graph.nodes();
    let companion = Companion::spawn(setup.machine, {
        let shared = Arc::clone(&shared);
        move || shared.drain()
    })?;
    Ok(Box::new(move |runs, samples| {
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    shared.left.store(nodes, Ordering::Relaxed);
                    shared.state.lock().release(&shared.plan);
                    // Ends without a limit of its own: what the companion does not complete, this lane does,
                    // and a node that the companion has begun it completes.
                    while shared.left.load(Ordering::Acquire) != 0 {
                        shared.drain();
                    }
                }
            });
        })
    }))
}
