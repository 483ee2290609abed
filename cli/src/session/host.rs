//! What happens under the scheduler's lock during a run: graph edits, and notes into tables that are large enough
//! before real time starts.

use super::drift::Costs;
use super::faults::Faults;
use red_core::{
    Capacity, CommitError, Duration, Event, EventKind, Instant, JobId, Outcome, ReleaseError, TaskId, Warning,
};
use red_record::Recorder;
use red_rt::timeline::Host;
use red_workload::build::{self, Change};
use red_workload::metrics::TaskLog;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counters that the live view reads while the run goes on.
#[derive(Debug)]
pub(crate) struct Live {
    /// Jobs released.
    pub(crate) released: AtomicU64,
    /// Jobs that completed by their deadlines.
    pub(crate) on_time: AtomicU64,
    /// Jobs that completed late or were given up.
    pub(crate) missed: AtomicU64,
    /// Jobs that were given up.
    pub(crate) shed: AtomicU64,
    /// Results that were taken instead of computed.
    pub(crate) saved: AtomicU64,
    /// The node whose cost drifted last: (task << 8 | node) + 1, 0 for none.
    pub(crate) drifted: AtomicU64,
    /// What each lane runs, likewise, 0 when idle.
    pub(crate) lanes: Vec<AtomicU64>,
}

impl Live {
    /// All zero.
    #[must_use]
    pub(crate) fn new(lanes: usize) -> Arc<Self> {
        let zero = || AtomicU64::new(0);
        let lanes = (0..lanes).map(|_| zero()).collect();
        Arc::new(Self {
            released: zero(),
            on_time: zero(),
            missed: zero(),
            shed: zero(),
            saved: zero(),
            drifted: zero(),
            lanes,
        })
    }
}

/// How many standstills are kept, for the trace.
const STANDSTILLS: usize = 1024;

/// The tables of a run.
#[derive(Debug)]
pub(crate) struct Notes {
    /// Jobs of each task.
    pub(crate) logs: Vec<TaskLog>,
    /// Events for the trace; empty where none was asked for.
    pub(crate) events: Vec<Event>,
    /// Standstills: from when until when, in nanoseconds since the start of the run; the first ones.
    pub(crate) standstills: Vec<(u64, u64)>,
    /// Jobs and events that found no room.
    pub(crate) dropped: u64,
    /// Bodies that failed.
    pub(crate) faults: Faults,
    /// What nodes take, and took.
    pub(crate) costs: Costs,
    tasks: Vec<TaskId>,
    deadlines_ns: Vec<u64>,
    /// Each with its number in the plan.
    changes: VecDeque<(u32, Change)>,
    /// When edits were last looked at.
    looked_at: Option<Instant>,
    live: Arc<Live>,
}

impl Notes {
    /// Room for `jobs` jobs of each task and `events` events.
    #[must_use]
    pub(crate) fn new(
        tasks: Vec<TaskId>,
        deadlines_ns: Vec<u64>,
        changes: Vec<Change>,
        jobs: &[usize],
        events: usize,
        costs: Costs,
        live: Arc<Live>,
    ) -> Self {
        Self {
            logs: jobs.iter().map(|jobs| TaskLog::with_capacity(*jobs)).collect(),
            events: Vec::with_capacity(events),
            standstills: Vec::with_capacity(STANDSTILLS),
            dropped: 0,
            faults: Faults::new(live.lanes.len()),
            costs,
            tasks,
            deadlines_ns,
            changes: (0..).zip(changes).collect(),
            looked_at: None,
            live,
        }
    }
}

fn add(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}

impl<C: Capacity> Host<C> for Notes {
    /// Edits that wait for a version to drain are tried at every turn anyway: the clock brings only later ones.
    fn next_at(&self) -> Option<u64> {
        let later = |change: &&Change| self.looked_at.is_none_or(|looked| change.at > looked);
        self.changes.iter().map(|(_, change)| change).find(later).map(|change| change.at.as_nanos())
    }

    fn due(&mut self, scheduler: &mut Recorder<'_, C>, now: Instant) {
        self.looked_at = Some(now);
        // Edits of one task keep their order; one that is held back holds back only those of its own task.
        let (mut held, mut i) = (0u64, 0);
        while let Some((number, change)) = self.changes.get(i).filter(|(_, change)| change.at <= now) {
            let task = change.task;
            if held >> task & 1 == 0 {
                let apply = |scheduler: &mut _| build::apply(scheduler, change, self.tasks[task], now);
                if scheduler.edit(*number, now, apply) != Err(CommitError::Busy) {
                    // Dropping it would give memory back inside the run.
                    std::mem::forget(self.changes.remove(i));
                    continue;
                }
                held |= 1 << task;
            }
            i += 1;
        }
    }

    fn released(&mut self, task: usize, release: Instant, taken: Result<JobId, ReleaseError>) {
        if taken.is_err_and(|error| error != ReleaseError::Full) {
            return;
        }
        add(&self.live.released);
        let Some(log) = self.logs.get_mut(task).filter(|log| log.has_room()) else {
            self.dropped += 1;
            return;
        };
        let deadline = release.as_nanos().saturating_add(self.deadlines_ns[task]);
        if taken.is_ok() {
            log.released(release.as_nanos(), deadline);
        } else {
            log.refused(release.as_nanos(), deadline);
            add(&self.live.missed);
            add(&self.live.shed);
        }
    }

    fn ended(&mut self, outcome: &Outcome) {
        if let Some(log) = self.logs.get_mut(outcome.task.index()) {
            log.ended(outcome);
        }
        add(if outcome.on_time() { &self.live.on_time } else { &self.live.missed });
        if outcome.shed.is_some() {
            add(&self.live.shed);
        }
    }

    fn stood_still(&mut self, time: Duration, now: Instant) {
        self.costs.stood_still(time, now);
        if self.standstills.len() < self.standstills.capacity() {
            self.standstills.push((now.as_nanos().saturating_sub(time.as_nanos()), now.as_nanos()));
        }
    }

    fn warned(&mut self, warning: &Warning, now: Instant) {
        if let Some(log) = self.logs.get_mut(warning.task.index()) {
            log.warned(warning.index, now.as_nanos());
        }
    }

    fn event(&mut self, event: &Event) {
        self.faults.event(event);
        self.live.drifted.store(self.costs.event(event), Ordering::Relaxed);
        let lane = || self.live.lanes.get(event.lane.index());
        match event.kind {
            EventKind::Hit => add(&self.live.saved),
            EventKind::Started => {
                let what = (event.task.index() as u64) << 8 | event.node.index() as u64;
                lane().into_iter().for_each(|l| l.store(what + 1, Ordering::Relaxed));
            }
            EventKind::Completed => lane().into_iter().for_each(|l| l.store(0, Ordering::Relaxed)),
            _ => {}
        }
        if self.events.len() < self.events.capacity() {
            self.events.push(*event);
        } else if self.events.capacity() > 0 {
            self.dropped += 1;
        }
    }
}

#[cfg(test)]
mod tests;
