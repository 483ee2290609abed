//! Encoders: one execution for many sub-jobs. Waiting for a running key, hits, and how long a result lives.

use super::{
    Scheduler, bits, complete::CompleteError, event::EventKind, jobs::Job, outlook::Case, units::Lane,
};
use crate::capacity::{Capacity, Empty};
use crate::config::Gate;
use crate::graph::{NodeSet, Role};
use crate::id::NodeId;
use crate::policy::frame_cache::{CaptureSource, FrameKey, Output, OutputState};

impl<C: Capacity> Scheduler<C> {
    /// What a job's encoder computes, if the rank is one.
    pub(super) fn frame_key(&self, job: &Job<C>, rank: usize) -> Option<FrameKey> {
        let Role::SharedEncoder(frame) = self.node_of(job, rank).role else { return None };
        Some(match (job.source, frame.sensor) {
            (CaptureSource::Job, Some(sensor)) => {
                let period = self.sensors[sensor.index()].as_nanos().max(1);
                FrameKey::new(frame, CaptureSource::Sensor, job.release.as_nanos() / period)
            }
            (source, _) => FrameKey::new(frame, source, job.capture),
        })
    }

    /// The result that an encoder would take instead of running, and where it is.
    pub(super) fn output_of(&self, job: &Job<C>, rank: usize) -> Option<(usize, OutputState)> {
        let key = self.frame_key(job, rank).filter(|_| self.config.frame_cache)?;
        let is_there = |o: &Output| matches!(o.state, OutputState::Running(_) | OutputState::Kept);
        let place = self.outputs.as_ref().iter().position(|o| is_there(o) && o.key() == key)?;
        Some((place, self.outputs[place].state))
    }

    /// Ready encoders of a job whose result is there are hits; those whose key is running are parked.
    #[inline(never)]
    pub(super) fn meet_outputs(&mut self, slot: usize) {
        // Each round takes one encoder out of the ready set: at most C::NODES rounds.
        loop {
            let ready = self.version(slot).encoders.and(&self.jobs[slot].ready);
            let met = ready.iter().find_map(|e| Some((e, self.output_of(&self.jobs[slot], e)?)));
            let Some((e, (place, state))) = met else { return };
            let job = &mut self.jobs[slot];
            job.ready.remove(e);
            if state != OutputState::Kept {
                job.parked.insert(e);
                continue;
            }
            job.started = true;
            job.place[e] = place as u8 + 1;
            self.counters.encoder_runs_saved += 1;
            self.note(EventKind::Hit, slot, e, 0);
            self.settle_one(slot, e);
            // An encoder without decoders leaves nobody who would free it.
            self.keep_or_free(place);
        }
    }

    /// A unit with an encoder, or one that lost or gained members, ended.
    #[inline(never)]
    pub(super) fn complete_shared(&mut self, lane: usize) -> Result<(), CompleteError> {
        let l = self.vacate(lane);
        let written = usize::from(l.output).checked_sub(1).filter(|_| l.is_encoder);
        if let Some(place) = written {
            let bytes = if self.config.frame_cache { l.memory } else { 0 };
            (self.outputs[place].state, self.outputs[place].bytes) = (OutputState::Kept, bytes);
            self.pools[usize::from(l.pool)].used += bytes;
        }
        let mut is_first = true;
        for slot in bits(l.members) {
            // Each round takes one rank out of the running set.
            while let Some(rank) = { self.ranks_on(slot, lane).next() } {
                if l.is_encoder {
                    self.jobs[slot].place[rank] = l.output as u8;
                }
                let node = NodeId::new(self.version(slot).order[rank]);
                self.counters.encoder_runs_saved += u64::from(l.merged && !is_first);
                self.done(slot, rank, node, lane, !l.merged);
                is_first = false;
            }
            if self.in_flight >> slot & 1 != 0 {
                self.changed(slot);
            }
        }
        if let Some(place) = written {
            self.wake_parked(self.outputs[place].key());
            self.keep_or_free(place);
        } else {
            self.stop_reading(l.output);
        }
        self.keep_promises();
        self.was_wanted(l.members)
    }

    /// The unit on a lane will never deliver its result: encoders that waited for it are ready again.
    pub(super) fn lose_output(&mut self, place: usize) {
        self.outputs[place].state = OutputState::Free;
        self.wake_parked(self.outputs[place].key());
        self.worsened();
    }

    /// Parked encoders of this key look again: hits if the result is kept, ready if it is gone.
    fn wake_parked(&mut self, key: FrameKey) {
        for slot in self.slots() {
            let mut woken = self.version(slot).encoders.and(&self.jobs[slot].parked);
            woken
                .iter()
                .filter(|e| self.frame_key(&self.jobs[slot], *e) != Some(key))
                .for_each(|e| woken.remove(e));
            if woken.is_empty() {
                continue;
            }
            let job = &mut self.jobs[slot];
            job.parked = job.parked.without(&woken);
            job.ready.extend(&woken);
            if self.config.gate == Gate::Level {
                self.open_level(slot);
            }
            self.meet_outputs(slot);
            if self.in_flight >> slot & 1 != 0 {
                self.changed(slot);
            }
        }
    }

    /// After a decoder's end: its encoder's result may have lost its last reader.
    #[inline(never)]
    pub(super) fn decoder_done(&mut self, slot: usize, rank: usize) {
        if let Some(e) = self.version(slot).encoder_of(rank)
            && let Some(place) = usize::from(self.jobs[slot].place[e]).checked_sub(1)
            && !self.has_readers(slot, e)
        {
            self.keep_or_free(place);
        }
    }

    fn has_readers(&self, slot: usize, encoder: usize) -> bool {
        !self.version(slot).decoders_of(encoder).without(&self.jobs[slot].done).is_empty()
    }

    /// An encoder of a job whose decoders still need the result.
    pub(super) fn reader(&self, slot: usize, place: usize) -> Option<usize> {
        let job = &self.jobs[slot];
        let took = |e: &usize| usize::from(job.place[*e]) == place + 1 && self.has_readers(slot, *e);
        self.version(slot).encoders.and(&job.done).iter().find(took)
    }

    /// Encoders of a job that have neither started nor been a hit.
    pub(super) fn open_encoders(&self, slot: usize) -> NodeSet<C> {
        self.version(slot).encoders.without(&self.jobs[slot].done).without(&self.jobs[slot].running)
    }

    /// Frees a result that no uncompleted decoder in flight reads and no encoder of its key could still take.
    fn keep_or_free(&mut self, place: usize) {
        let key = self.outputs[place].key();
        let could_hit =
            |slot| self.open_encoders(slot).iter().any(|e| self.frame_key(&self.jobs[slot], e) == Some(key));
        let is_needed =
            |slot| self.reader(slot, place).is_some() || self.config.frame_cache && could_hit(slot);
        if self.outputs[place].state == OutputState::Kept && !self.slots().any(is_needed) {
            self.free_output(place);
        }
    }

    pub(super) fn free_output(&mut self, place: usize) {
        let state = if self.is_read(place) { OutputState::Draining } else { OutputState::Free };
        self.outputs[place].state = state;
        let Output { pool, bytes, .. } = self.outputs[place];
        self.pools[usize::from(pool)].used -= bytes;
        self.active |= 1 << pool;
    }

    fn is_read(&self, place: usize) -> bool {
        let reads = |l: &Lane| l.is_busy() && !l.is_encoder && usize::from(l.output) == place + 1;
        self.lanes.as_ref().iter().any(reads)
    }

    /// A unit that read a result ended; nobody else may want it.
    pub(super) fn stop_reading(&mut self, output: u16) {
        if let Some(place) = usize::from(output).checked_sub(1)
            && self.outputs[place].state == OutputState::Draining
            && !self.is_read(place)
        {
            self.outputs[place].state = OutputState::Free;
        }
    }

    /// A job was given up: its units lose a member, its suspended sub-jobs and its claims on results go.
    pub(super) fn abandon(&mut self, slot: usize) {
        self.reopen();
        for lane in 0..self.lanes() {
            if !self.lanes[lane].is_busy() || self.lanes[lane].members >> slot & 1 == 0 {
                continue;
            }
            let members = self.lanes[lane].members & !(1 << slot);
            let own = |rank| self.left_of(&self.jobs[slot], slot, rank, Case::Expected);
            let left = self.ranks_on(slot, lane).map(own).fold(0, u64::max);
            let expects = left.saturating_add(self.executed_on(lane).as_nanos());
            let heir = bits(members).find_map(|slot| Some((slot, self.ranks_on(slot, lane).next()?)));
            let l = &mut self.lanes[lane];
            l.expects = if l.merged { l.expects.max(expects) } else { expects };
            (l.members, l.merged) = (members, true);
            if let Some((slot, rank)) = heir {
                (l.slot, l.rank) = (slot as u8, rank as u8);
            }
        }
        self.jobs[slot].running = NodeSet::EMPTY;
        self.break_promises(slot);
        // Its head may have been what did not fit into memory.
        self.active |= self.version(slot).pool_mask;
        self.age_keys();
        self.forget_suspended(slot);
        (0..C::NODES).for_each(|place| self.keep_or_free(place));
    }
}
