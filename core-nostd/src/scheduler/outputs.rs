//! Encoders: one execution for many sub-jobs. Merging at dispatch, waiting for a running key, hits, and how long
//! a result lives.

use super::Scheduler;
use super::bits;
use super::complete::CompleteError;
use super::event::EventKind;
use crate::capacity::{Capacity, Empty};
use crate::config::Gate;
use crate::graph::{NodeSet, Role};
use crate::id::{NodeId, UnitId};
use crate::policy::frame_cache::{CaptureSource, FrameKey, Output, OutputState};

impl<C: Capacity> Scheduler<C> {
    /// What a job's encoder computes, if the rank is one.
    pub(super) fn frame_key(&self, slot: usize, rank: usize) -> Option<FrameKey> {
        let Role::SharedEncoder(frame) = self.node(slot, rank).role else { return None };
        let job = &self.jobs[slot];
        Some(match (job.source, frame.sensor) {
            (CaptureSource::Job, Some(sensor)) => {
                let period = self.sensors[sensor.index()].as_nanos().max(1);
                FrameKey::new(frame, CaptureSource::Sensor, job.release.as_nanos() / period)
            }
            (source, _) => FrameKey::new(frame, source, job.capture),
        })
    }

    /// The result with this key, running or kept.
    pub(super) fn find_output(&self, key: FrameKey) -> Option<(usize, OutputState)> {
        let found =
            |o: &Output| !matches!(o.state, OutputState::Free | OutputState::Draining) && o.key() == key;
        let place = self.outputs.as_ref().iter().position(found)?;
        Some((place, self.outputs[place].state))
    }

    /// Ready encoders of a job whose result is there are hits; those whose key is running are parked.
    #[inline(never)]
    pub(super) fn meet_outputs(&mut self, slot: usize) {
        if !self.config.frame_cache {
            return;
        }
        // Each round takes one encoder out of the ready set: at most C::NODES rounds.
        loop {
            let version = self.version(slot);
            let ready = version.encoders.and(&self.jobs[slot].ready);
            let met = ready.iter().find_map(|e| {
                let key = self.frame_key(slot, e)?;
                self.find_output(key).map(|(place, state)| (e, place, state))
            });
            let Some((e, place, state)) = met else { return };
            self.jobs[slot].ready.remove(e);
            if matches!(state, OutputState::Running(_)) {
                self.jobs[slot].parked.insert(e);
                continue;
            }
            let job = &mut self.jobs[slot];
            job.started = true;
            job.place[e] = place as u8 + 1;
            self.counters.encoder_runs_saved += 1;
            self.note(EventKind::Hit, slot, e, 0);
            self.settle_one(slot, e);
        }
    }

    /// A unit with an encoder, or one that lost or gained members, ended.
    #[inline(never)]
    pub(super) fn complete_shared(&mut self, lane: usize) -> Result<(), CompleteError> {
        let l = self.lanes[lane];
        let output = usize::from(l.output).checked_sub(1).filter(|_| l.is_encoder);
        self.free(lane);
        self.lanes[lane].merged = false;
        self.lanes[lane].is_encoder = false;
        if let Some(place) = output {
            let bytes = if self.config.frame_cache { l.memory } else { 0 };
            let kept = &mut self.outputs[place];
            kept.state = OutputState::Kept;
            kept.bytes = bytes;
            self.pools[usize::from(l.pool)].used += bytes;
        }
        let mut first = true;
        for slot in bits(l.members) {
            // Each round takes one rank out of the running set.
            while let Some(rank) = { self.ranks_on(slot, lane).next() } {
                if l.is_encoder {
                    self.jobs[slot].place[rank] = output.map_or(0, |place| place as u8 + 1);
                }
                // A merged unit took the longest of its members: no sample of an execution alone.
                if l.merged {
                    self.counters.encoder_runs_saved += u64::from(!first);
                    self.note(EventKind::Completed, slot, rank, lane);
                    self.jobs[slot].running.remove(rank);
                    self.settle_node(slot, rank);
                } else {
                    let node = NodeId::new(self.version(slot).order[rank]);
                    self.done(slot, rank, node, lane);
                }
                first = false;
            }
            if self.in_flight >> slot & 1 != 0 {
                self.changed(slot);
            }
        }
        if let Some(place) = output {
            self.wake_parked(self.outputs[place].key());
            self.keep_or_free(place);
        } else {
            self.stop_reading(l.output);
        }
        if l.members == 0 {
            self.counters.late_completions += 1;
            self.age_keys();
            return Err(CompleteError::Late);
        }
        Ok(())
    }

    /// The unit on `lane` will never deliver its result: encoders that waited for it are ready again.
    pub(super) fn drop_output_of(&mut self, lane: usize) {
        if self.lanes[lane].is_encoder
            && let Some(place) = usize::from(self.lanes[lane].output).checked_sub(1)
        {
            let key = self.outputs[place].key();
            self.outputs[place].state = OutputState::Free;
            self.wake_parked(key);
        }
    }

    /// Parked encoders of this key look again: hits if the result is kept, ready if it is gone.
    fn wake_parked(&mut self, key: FrameKey) {
        for slot in self.slots() {
            let parked = self.version(slot).encoders.and(&self.jobs[slot].parked);
            let mut woken = false;
            for e in parked.iter() {
                if self.frame_key(slot, e) == Some(key) {
                    self.jobs[slot].parked.remove(e);
                    self.jobs[slot].ready.insert(e);
                    woken = true;
                }
            }
            if woken {
                if self.config.gate == Gate::Level {
                    self.open_level(slot);
                }
                self.meet_outputs(slot);
                if self.in_flight >> slot & 1 != 0 {
                    self.changed(slot);
                }
            }
        }
    }

    /// After a decoder's end: its encoder's result may have lost its last reader.
    #[inline(never)]
    pub(super) fn decoder_done(&mut self, slot: usize, rank: usize) {
        let Some(e) = self.version(slot).encoder_of(rank) else { return };
        if self.version(slot).decoders_of(e).without(&self.jobs[slot].done).is_empty()
            && let Some(place) = usize::from(self.jobs[slot].place[e]).checked_sub(1)
        {
            self.keep_or_free(place);
        }
    }

    /// Looks at every result after a job was given up.
    pub(super) fn sweep_outputs(&mut self) {
        for place in 0..C::NODES {
            if self.outputs[place].state == OutputState::Kept {
                self.keep_or_free(place);
            }
        }
    }

    fn keep_or_free(&mut self, place: usize) {
        if self.outputs[place].state == OutputState::Kept && !self.is_needed(place) {
            self.free_output(place);
        }
    }

    pub(super) fn free_output(&mut self, place: usize) {
        let is_read = self.is_read(place);
        let output = &mut self.outputs[place];
        output.state = if is_read { OutputState::Draining } else { OutputState::Free };
        let pool = usize::from(output.pool);
        self.pools[pool].used -= output.bytes;
        self.active |= 1 << pool;
    }

    /// Whether a unit that runs reads the result.
    fn is_read(&self, place: usize) -> bool {
        let reads = |l: usize| {
            let l = &self.lanes[l];
            l.is_busy() && !l.is_encoder && usize::from(l.output) == place + 1
        };
        (0..usize::from(self.lane_count)).any(reads)
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

    /// Whether an uncompleted decoder in flight reads the result, or an encoder of its key could still be a hit.
    fn is_needed(&self, place: usize) -> bool {
        let key = self.outputs[place].key();
        let wanted = |slot: usize| {
            let (job, version) = (&self.jobs[slot], self.version(slot));
            version.encoders.iter().any(|e| {
                if job.done.contains(e) {
                    usize::from(job.place[e]) == place + 1
                        && !version.decoders_of(e).without(&job.done).is_empty()
                } else {
                    self.config.frame_cache
                        && !job.running.contains(e)
                        && self.frame_key(slot, e) == Some(key)
                }
            })
        };
        self.slots().any(wanted)
    }

    /// A job was given up: its units lose a member, its suspended sub-jobs and its claims on results go.
    pub(super) fn abandon(&mut self, slot: usize) {
        for lane in 0..usize::from(self.lane_count) {
            if self.lanes[lane].unit == UnitId::EMPTY || self.lanes[lane].members >> slot & 1 == 0 {
                continue;
            }
            let members = self.lanes[lane].members & !(1 << slot);
            let first = bits(members).next();
            let rank = first.and_then(|s| self.ranks_on(s, lane).next());
            let l = &mut self.lanes[lane];
            l.members = members;
            l.merged = true;
            if let (Some(first), Some(rank)) = (first, rank) {
                l.slot = first as u8;
                l.rank = rank as u8;
            }
        }
        self.jobs[slot].running = NodeSet::EMPTY;
        // Its head may have been what did not fit into memory.
        self.active |= self.version(slot).pool_mask;
        self.age_keys();
        self.forget_suspended(slot);
        self.sweep_outputs();
    }
}
