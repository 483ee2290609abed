//! Encoders in a forward schedule: one run for all of a key.

use super::course::{Course, Going};
use crate::capacity::Capacity;
use crate::policy::frame_cache::FrameKey;
use crate::scheduler::bits;

impl<C: Capacity> Course<'_, C> {
    /// Does something to each encoder of a key that has not started, and brings its job's heads up to date.
    pub(super) fn each_of(&mut self, key: FrameKey, mut act: impl FnMut(&mut Going<C>, usize)) {
        let s = self.scheduler;
        for slot in bits(self.group) {
            let mut is_changed = false;
            for encoder in s.version(slot).encoders.without(&self.jobs[slot].gone).iter() {
                if s.frame_key(&s.jobs[slot], encoder) == Some(key) {
                    act(&mut self.jobs[slot], encoder);
                    is_changed = true;
                }
            }
            if is_changed {
                self.requeue(slot);
            }
        }
    }

    /// Ready encoders of a job whose result is there are done, those whose result is being computed wait.
    pub(super) fn serve(&mut self, slot: usize) {
        // Each round takes an encoder out of the ready set: at most as many rounds as nodes.
        while self.shares {
            let going = &mut self.jobs[slot];
            let mut met = going.served;
            met.extend(&going.held);
            let Some(encoder) = going.ready.first_in(&met) else { break };
            going.ready.remove(encoder);
            if going.served.contains(encoder) {
                going.gone.insert(encoder);
                self.settle(slot, encoder);
            }
        }
        self.requeue(slot);
    }
}
