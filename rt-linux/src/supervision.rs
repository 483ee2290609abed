//! What a run looks after besides the work of its lanes, about ten times a second on an ordinary thread: a lane that
//! lost its thread gets a spare, a pinned thread is where it was put, and a run that cannot go on gives up.

use crate::placement;
use crate::report::Surrender;
use crate::setup::Fifo;
use crate::shared::Shared;
use crate::threads::{Started, Starter};
use crate::timeline::Host;
use crate::watchdog::Bound;
use nix::errno::Errno;
use nix::unistd::Pid;
use red_core::{Capacity, Scheduler};
use red_sync::Exclusive;
use std::sync::Arc;

/// Threads whose bodies never came back and that a run puts up with: each keeps its stack, and its spare takes another.
const MOST_STUCK: usize = 16;

pub(crate) struct Supervision<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    shared: Arc<Shared<C, H, L>>,
    starter: Starter<Shared<C, H, L>>,
    pub(crate) running: Vec<Started>,
    /// Threads ever started.
    threads: u64,
    /// Those that were replaced and have not ended yet.
    stuck: Vec<Pid>,
    /// Lanes that stay without a thread, a bit each.
    gone: u32,
    pub(crate) threads_died: u64,
    pub(crate) pinned_again: u64,
    pub(crate) gave_up: Option<Surrender>,
}

impl<C, H, L> Supervision<C, H, L>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    pub(crate) fn new(
        shared: Arc<Shared<C, H, L>>,
        starter: Starter<Shared<C, H, L>>,
        running: Vec<Started>,
    ) -> Self {
        let threads = running.len() as u64;
        let (gone, threads_died, pinned_again) = (0, 0, 0);
        let (stuck, gave_up) = (Vec::new(), None);
        Self { shared, starter, running, threads, stuck, gone, threads_died, pinned_again, gave_up }
    }

    /// One look.
    pub(crate) fn look(&mut self) {
        for lane in 0..self.shared.slots.len() {
            let Some(thread) = self.shared.slots[lane].thread().map(Pid::from_raw) else {
                // A spare is on its way, unless it ended before it was one.
                let spare = self.running.iter().rfind(|thread| thread.lane == lane);
                self.gone |= u32::from(spare.is_some_and(Started::never_began)) << lane;
                continue;
            };
            match placement::cpus_of(thread) {
                Err(Errno::ESRCH) => self.bury(lane),
                Ok(cpus) => self.hold(lane, thread, &cpus),
                // Nothing can be said about it.
                Err(_) => {}
            }
        }
        let mut lost = self.shared.spares.take_lost();
        while lost != 0 {
            let lane = lost.trailing_zeros() as usize;
            lost &= lost - 1;
            self.replace(lane);
        }
        if self.lanes_lost() == self.shared.slots.len() as u64 {
            self.gave_up = Some(Surrender::NoLane);
        }
    }

    /// Lanes that stay without a thread.
    pub(crate) fn lanes_lost(&self) -> u64 {
        self.gone.count_ones().into()
    }

    /// The lane's thread has ended though nobody asked it to: its unit fails as that of a body that hangs does, and
    /// what it was to keep falls to the others.
    fn bury(&mut self, lane: usize) {
        let (shared, slot) = (&self.shared, &self.shared.slots[lane]);
        slot.forget();
        shared.waiting.bury(lane);
        self.threads_died += 1;
        // Unless the watchdog has said so already.
        if slot.disarm() == Bound::Kept {
            shared.lose(lane);
        }
    }

    /// A lane that was moved off its CPU, where another may spin for the lock, is put back.
    fn hold(&mut self, lane: usize, thread: Pid, cpus: &[usize]) {
        let Some(Fifo { cpu, .. }) = self.starter.mode.fifo(lane).filter(|fifo| cpus != [fifo.cpu]) else {
            return;
        };
        match placement::pin_thread(thread, cpu) {
            Ok(()) => self.pinned_again += 1,
            // It ended just now.
            Err(Errno::ESRCH) => {}
            Err(_) => self.gave_up = Some(Surrender::CpuGone { lane, cpu }),
        }
    }

    /// Another thread for a lane.
    fn replace(&mut self, lane: usize) {
        let (shared, slot) = (&self.shared, &self.shared.slots[lane]);
        self.stuck.retain(|thread| placement::cpus_of(*thread).is_ok());
        self.stuck.extend(slot.thread().map(Pid::from_raw));
        slot.forget();
        self.threads += 1;
        shared.spares.assign(lane, &shared.waiting.seats[lane], self.threads);
        let may = self.stuck.len() <= MOST_STUCK;
        match may.then(|| self.starter.start(lane, self.threads, None)) {
            Some(Ok(spare)) => self.running.push(spare),
            Some(Err(_)) | None => {
                shared.spares.withdraw(lane);
                self.gone |= 1 << lane;
            }
        }
    }
}
