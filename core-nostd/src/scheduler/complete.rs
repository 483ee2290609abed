//! `complete` and `fail`: what a lane reports.

use super::{Scheduler, action::ShedReason, bits, event::EventKind};
use crate::capacity::{Capacity, Empty};
use crate::config::{Gate, Shed};
use crate::graph::NodeSet;
use crate::id::{NodeId, UnitId};
use crate::time::{Duration, Instant};
use core::hint::cold_path;

crate::error::errors! {
    /// A report was refused. But for `Late` nothing changed but the time, and what a look that was due gave up.
    #[repr(u64)] // A byte would lie within a unit that is answered instead, which is then taken apart and put together.
    pub enum CompleteError {
        /// The unit was reported before, or its lane is another's: the host reported twice.
        Stale,
        /// No such unit was ever dispatched: the host made the handle up.
        NotRunning,
        /// The unit's jobs had been given up meanwhile. It is counted, and its lane is free again.
        Late,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// The unit ended at `now`. All its members complete. Errors: [`CompleteError`].
    #[inline(always)]
    pub fn complete(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        self.advance(now);
        let lane = unit.lane().index();
        if lane >= C::LANES || self.lanes[lane].unit != unit || unit == UnitId::EMPTY {
            return self.complete_ahead(unit);
        }
        let l = &self.lanes[lane];
        let (slot, rank) = (usize::from(l.slot), usize::from(l.rank));
        if l.merged | l.is_encoder | l.leads {
            cold_path();
            return self.complete_shared(lane);
        }
        self.free(lane);
        self.done(slot, rank, unit.node(), lane, true);
        self.changed(slot);
        Ok(())
    }

    /// The unit failed: all its members' jobs are given up with the reason `fault`. Errors: [`CompleteError`].
    pub fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        self.advance(now);
        let Some(lane) = self.lane_of(unit) else { return self.fail_ahead(unit) };
        let l = self.vacate(lane);
        bits(l.members).for_each(|slot| self.end_job(slot, Some(ShedReason::Fault)));
        match usize::from(l.output).checked_sub(1) {
            Some(place) if l.is_encoder => self.lose_output(place),
            _ => self.stop_reading(l.output),
        }
        self.keep_promises();
        self.was_wanted(l.members)
    }

    /// A unit whose jobs had all been given up was late.
    pub(super) fn was_wanted(&mut self, members: u64) -> Result<(), CompleteError> {
        if members != 0 {
            return Ok(());
        }
        self.counters.late_completions += 1;
        self.age_keys();
        Err(CompleteError::Late)
    }

    #[cold]
    pub(super) fn refuse(&self, unit: UnitId) -> CompleteError {
        if unit == UnitId::EMPTY || unit.to_bits() >> 16 > self.counters.units {
            CompleteError::NotRunning
        } else {
            CompleteError::Stale
        }
    }

    /// One running sub-job is done: its successors may become ready, its job may end. It was `alone` unless its
    /// unit had other members, and so took the longest of theirs: no sample of its own execution.
    #[inline(always)]
    pub(super) fn done(&mut self, slot: usize, rank: usize, node: NodeId, lane: usize, alone: bool) {
        self.note_node(EventKind::Completed, slot, node, lane);
        if self.observes & alone {
            self.observe(slot, node, lane);
        }
        self.jobs[slot].running.remove(rank);
        if self.settle_one(slot, rank) {
            // Encoders among its successors may find their results.
            self.meet_outputs(slot);
        }
    }

    /// A sub-job is done, by execution or by a hit. Whether the job goes on and has encoders.
    #[inline(always)]
    pub(super) fn settle_one(&mut self, slot: usize, rank: usize) -> bool {
        let job = &mut self.jobs[slot];
        let version = self.tasks[job.task.index()].version_of(job);
        job.done.insert(rank);
        job.left -= 1;
        version.successors[rank].each(|s| {
            let left = job.waiting_for[s] - 1;
            job.waiting_for[s] = left;
            if left == 0 {
                job.ready.insert(s);
            }
        });
        let is_last = job.left == 0;
        if !version.is_plain {
            cold_path();
            return self.settle_special(slot, rank, is_last);
        }
        if is_last {
            cold_path();
            self.end_job(slot, None);
        }
        false
    }

    /// The rest of `settle_one` in a graph that is not plain.
    #[inline(never)]
    fn settle_special(&mut self, slot: usize, rank: usize, is_last: bool) -> bool {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let (is_decoder, has_encoders) = (version.decoders.contains(rank), !version.encoders.is_empty());
        if job.reruns {
            // After a second end of an encoder: what was done or runs already is not ready.
            let job = &mut self.jobs[slot];
            job.ready = job.ready.without(&job.done).without(&job.running);
        }
        match self.config.gate {
            Gate::Precedence => {}
            Gate::Level => self.open_level(slot),
            Gate::Lookahead => self.reopen(),
        }
        if is_last {
            self.end_job(slot, None);
        }
        if is_decoder {
            self.decoder_done(slot, rank);
        }
        has_encoders && !is_last
    }

    /// Parks ready nodes above the lowest level that is not done, and readies those in it.
    pub(super) fn open_level(&mut self, slot: usize) {
        let job = &self.jobs[slot];
        let version = self.version(slot);
        let open = job.undone(version).iter().map(|r| version.height[r]).min().unwrap_or(0);
        let mut candidates = job.ready;
        candidates.extend(&job.parked);
        let (mut ready, mut parked) = (NodeSet::EMPTY, NodeSet::EMPTY);
        candidates.each(|r| if version.height[r] <= open { ready.insert(r) } else { parked.insert(r) });
        let job = &mut self.jobs[slot];
        job.ready = ready;
        job.parked = parked;
    }

    /// Takes a sample of an execution alone, and counts an overrun.
    #[inline(always)]
    fn observe(&mut self, slot: usize, node: NodeId, lane: usize) {
        let executed = self.executed_on(lane);
        let (t, n) = (self.jobs[slot].task.index(), node.index());
        let is_within = executed <= self.tasks[t].nodes[n].wcet.get();
        let sample = if is_within { executed } else { self.count_overrun(slot, node, lane, executed) };
        let task = &mut self.tasks[t];
        task.samples[n].push(task.shifts[n], sample);
    }

    /// Takes what each unit of a job alone has run for a sample, if that is past its WCET: the job is given up, and the rest is not seen.
    pub(super) fn observe_given_up(&mut self, slot: usize) {
        for rank in self.jobs[slot].running.iter() {
            let lane = usize::from(self.jobs[slot].place[rank]);
            let is_past = self.executed_on(lane) > self.node(slot, rank).wcet.get();
            if self.observes && !self.lanes[lane].merged && is_past {
                self.observe(slot, self.lanes[lane].unit.node(), lane);
            }
        }
    }

    /// Counts an overrun; the sample of it. One slow run proves nothing: it would keep its task out of its lane. So it counts as the WCET
    /// if it is the first, and where estimates decide who goes also if the run before it was shorter than that.
    #[cold]
    fn count_overrun(&mut self, slot: usize, node: NodeId, lane: usize, executed: Duration) -> Duration {
        self.counters.overruns += 1;
        let t = self.jobs[slot].task.index();
        self.tasks[t].overran = true;
        if self.config.shed == Shed::Hopeless {
            // Until it has settled nobody knows what it blocks.
            self.pools.as_mut().iter_mut().for_each(|pool| pool.is_plain = false);
        }
        self.note_node(EventKind::Overran, slot, node, lane);
        let task = &self.tasks[t];
        let (wcet, window) = (task.nodes[node.index()].wcet.get(), &task.samples[node.index()]);
        let is_again = window.ends_with(task.shifts[node.index()], wcet);
        let is_believed = is_again || self.config.shed != Shed::Hopeless && !window.is_empty();
        if is_believed { executed } else { wcet }
    }
}

#[cfg(test)]
mod tests;
