//! What a robot team writes by hand: worker threads around a mutex, a heap in deadline order and two condition
//! variables. The thread that releases a run sleeps until it is done.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::graphs::{Body, Graph};
use crate::measure::{Runner, timed};
use crate::not_run::NotRun;
use crate::peers::Setup;

struct State {
    left: Vec<u32>,
    ready: BinaryHeap<Reverse<(u64, u32)>>,
    remaining: usize,
    /// Workers asleep: a wake of nobody would still be a system call.
    idle: usize,
    stopping: bool,
}

struct Executor {
    graph: Graph,
    body: Body,
    call: fn(Body, usize),
    state: Mutex<State>,
    work: Condvar,
    done: Condvar,
}

impl Executor {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, state: &mut State, node: u32) {
        state.ready.push(Reverse((self.graph.deadline(node as usize), node)));
        if state.idle > 0 {
            self.work.notify_one();
        }
    }

    fn worker(&self) {
        let mut state = self.lock();
        while !state.stopping {
            let Some(Reverse((_, node))) = state.ready.pop() else {
                state.idle += 1;
                state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.idle -= 1;
                continue;
            };
            drop(state);
            (self.call)(self.body, node as usize);
            state = self.lock();
            for &successor in &self.graph.successors[node as usize] {
                state.left[successor as usize] -= 1;
                if state.left[successor as usize] == 0 {
                    self.push(&mut state, successor);
                }
            }
            state.remaining -= 1;
            if state.remaining == 0 {
                self.done.notify_one();
            }
        }
    }

    fn run(&self, roots: &[u32]) {
        let mut state = self.lock();
        state.left.copy_from_slice(&self.graph.indegree);
        state.remaining = self.graph.nodes();
        for &root in roots {
            self.push(&mut state, root);
        }
        let running = |state: &mut State| state.remaining > 0;
        drop(self.done.wait_while(state, running).unwrap_or_else(PoisonError::into_inner));
    }
}

/// Ends the workers with the runner.
struct Stop(Arc<Executor>);

impl Drop for Stop {
    fn drop(&mut self) {
        self.0.lock().stopping = true;
        self.0.work.notify_all();
    }
}

/// Starts one worker per lane, beside the calling thread on lane 0.
pub(crate) fn build(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let graph = setup.graph.clone();
    let roots = graph.roots();
    let executor = Arc::new(Executor {
        state: Mutex::new(State {
            left: graph.indegree.clone(),
            ready: BinaryHeap::with_capacity(graph.nodes()),
            remaining: 0,
            idle: 0,
            stopping: false,
        }),
        graph,
        body: setup.body,
        call: setup.body.behind_pointer(),
        work: Condvar::new(),
        done: Condvar::new(),
    });
    for lane in 1..=setup.lanes {
        let (executor, machine) = (Arc::clone(&executor), setup.machine);
        thread::spawn(move || {
            // Unpinned it still works, on whatever CPU it inherited.
            let _ = machine.become_lane(lane);
            executor.worker();
        });
    }
    let stop = Stop(executor);
    Ok(timed(move |runs| (0..runs).for_each(|_| stop.0.run(&roots))))
}
