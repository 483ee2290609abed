//! What a watcher of the event record knows of jobs in flight: no sub-job starts before its predecessors ended, none
//! starts twice, and a job that ended is whole.

use std::collections::BTreeMap;

use red_core::{Dag, Event, EventKind, NodeId, Scheduler, TaskId};

use super::Small;

#[derive(Debug)]
struct Job {
    dag: Dag<Small>,
    running: u64,
    done: u64,
}

/// Jobs in flight by task and index.
#[derive(Debug, Default)]
pub(super) struct Jobs(BTreeMap<(TaskId, u64), Job>);

impl Jobs {
    pub(super) fn in_flight(&self) -> usize {
        self.0.len()
    }

    /// Takes one event; at a release the task's graph is what `scheduler` has.
    pub(super) fn see(&mut self, event: &Event, scheduler: &Scheduler<Small>) {
        let key = (event.task, event.job);
        match event.kind {
            EventKind::Released => {
                let dag = scheduler.edit(event.task).expect("the task is there");
                assert!(self.0.insert(key, Job { dag, running: 0, done: 0 }).is_none(), "{event:?} twice");
                return;
            }
            EventKind::Refused | EventKind::Edited => return,
            _ => {}
        }
        let job = self.0.get_mut(&key).unwrap_or_else(|| panic!("{event:?} of no job"));
        let bit = 1 << event.node.index();
        match event.kind {
            EventKind::Started => {
                assert!(
                    job.may_start(event.node),
                    "{event:?} before its predecessors ended, or twice: {job:?}"
                );
                job.running |= bit;
            }
            EventKind::Preempted => {
                assert!(job.running & bit != 0, "{event:?} does not run");
                job.running &= !bit;
            }
            EventKind::Completed => {
                assert!(job.running & bit != 0, "{event:?} does not run");
                job.running &= !bit;
                job.done |= bit;
            }
            EventKind::Hit => {
                assert!(job.may_start(event.node), "{event:?} too early: {job:?}");
                job.done |= bit;
            }
            EventKind::Evicted => {
                assert!(job.done & bit != 0, "{event:?} was not there");
                job.done &= !bit;
            }
            EventKind::Ended => {
                let whole = job.dag.nodes().all(|node| job.done >> node.index() & 1 != 0);
                assert!(whole && job.running == 0, "{event:?} with nodes left: {job:?}");
                self.0.remove(&key);
            }
            EventKind::Shed(_) => _ = self.0.remove(&key),
            _ => {}
        }
    }
}

impl Job {
    fn may_start(&self, node: NodeId) -> bool {
        let ended = |other: NodeId| {
            !self.dag.successors(other).contains(node.index()) || self.done >> other.index() & 1 != 0
        };
        let bit = 1 << node.index();
        self.dag.contains(node) && (self.running | self.done) & bit == 0 && self.dag.nodes().all(ended)
    }
}
