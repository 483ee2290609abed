//! Starting units that share: DynamicMerge at dispatch, and which result a unit writes or reads.

use super::{Scheduler, event::EventKind};
use crate::capacity::Capacity;
use crate::policy::frame_cache::{FrameKey, Output, OutputState};
use crate::policy::merge::{Candidate, join, window_of};
use crate::time::Duration;

impl<C: Capacity> Scheduler<C> {
    /// What else an encoder, a decoder, or any node of a pool with a memory budget starts with.
    #[inline(never)]
    pub(super) fn hold_and_share(&mut self, slot: usize, rank: usize, lane: usize) {
        self.hold(lane, self.node(slot, rank).memory.0);
        let version = self.version(slot);
        if version.encoders.contains(rank) {
            self.share(slot, rank, lane);
        } else if version.decoders.contains(rank) {
            let output = version.encoder_of(rank).map_or(0, |e| self.jobs[slot].place[e]);
            self.lanes[lane].output = u16::from(output);
        }
    }

    /// The unit on a lane needs so many bytes more.
    fn hold(&mut self, lane: usize, bytes: u64) {
        let pool = &mut self.pools[usize::from(self.lanes[lane].pool)];
        if pool.limited {
            self.lanes[lane].memory += bytes;
            pool.used += bytes;
        }
    }

    /// An encoder got a lane: others join its unit, and those of its key that cannot wait for its result.
    fn share(&mut self, slot: usize, rank: usize, lane: usize) {
        let Some(key) = self.frame_key(&self.jobs[slot], rank) else { return };
        let mut places = self.outputs.as_ref().iter().take(usize::from(u8::MAX));
        let place = places.position(|output| output.state == OutputState::Free);
        let l = &mut self.lanes[lane];
        (l.is_encoder, l.output) = (true, place.map_or(0, |place| place as u16 + 1));
        if let Some(place) = place {
            self.outputs[place] = Output::new(key, l.pool, OutputState::Running(lane as u8));
        }
        if let Some(skew) = self.config.merge_skew {
            self.merge(slot, rank, lane, key, skew);
        }
        if self.config.frame_cache && place.is_some() {
            for other in self.slots() {
                if !self.version(other).encoders.and(&self.jobs[other].ready).is_empty() {
                    self.meet_outputs(other);
                    self.requeue(other);
                }
            }
        }
    }

    /// DynamicMerge around the unit's first member.
    fn merge(&mut self, slot: usize, rank: usize, lane: usize, key: FrameKey, skew: Duration) {
        let pool = usize::from(self.lanes[lane].pool);
        let releases = self.slots().filter(|s| self.sharing(*s, pool, key).next().is_some());
        let releases = releases.map(|s| self.jobs[s].release);
        let anchor = window_of(self.jobs[slot].release, skew, &releases);
        let window = anchor..=anchor.saturating_add(skew);
        let mut unit = self.candidate(slot, rank);
        // In dispatch order; each round looks at the next ready encoder after the last: at most jobs * nodes.
        let mut last = None;
        loop {
            let this = &*self;
            let ready = this.slots().filter(|s| window.contains(&this.jobs[*s].release));
            let ready =
                ready.flat_map(|s| this.sharing(s, pool, key).map(move |r| (this.rank_key(s, r), r, s)));
            let next = ready.filter(|c| last.is_none_or(|last| *c > last)).min();
            let Some((_, r, other)) = next else { return };
            last = next;
            let grow = self.node(other, r).memory.0.saturating_sub(self.lanes[lane].memory);
            let fits = self.pools[pool].used.saturating_add(grow) <= self.pools[pool].budget;
            let Some(both) = join(unit, self.candidate(other, r), self.now).filter(|_| fits) else {
                continue;
            };
            unit = both;
            self.hold(lane, grow);
            self.run_on(other, r, lane);
            let l = &mut self.lanes[lane];
            l.members |= 1 << other;
            l.expects = if l.merged { l.expects } else { 0 };
            l.merged = true;
            self.note(EventKind::Started, other, r, lane);
            self.requeue(other);
        }
    }

    /// Ready encoders of a job with this key in this pool.
    fn sharing(&self, slot: usize, pool: usize, key: FrameKey) -> impl Iterator<Item = usize> + '_ {
        let version = self.version(slot);
        let ready = version.encoders.and(&self.jobs[slot].ready).and(&version.in_pool[pool]);
        ready.iter().filter(move |r| self.frame_key(&self.jobs[slot], *r) == Some(key))
    }

    fn candidate(&self, slot: usize, rank: usize) -> Candidate {
        let deadline = self.jobs[slot].deadline.as_nanos().cast_signed();
        let latest_finish = deadline.saturating_sub_unsigned(self.tail_after(slot, rank));
        Candidate { cost: self.expected(slot, rank), latest_finish }
    }
}
