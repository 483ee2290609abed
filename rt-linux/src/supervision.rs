//! What a run looks after besides the work of its lanes, about ten times a second on an ordinary thread: a lane that
//! lost its thread gets a spare, a pinned thread is where it was put, and a run that cannot go on gives up.

use crate::placement;
use crate::report::{LaneFigures, Surrender};
use crate::setup::Fifo;
use crate::shared::Shared;
use crate::threads::{Lanes, Started, Starter};
use crate::timeline::Host;
use crate::watchdog::Bound;
use core::mem;
use core::sync::atomic::Ordering;
use nix::errno::Errno;
use nix::unistd::Pid;
use red_core::{Capacity, Scheduler};
use red_sync::Exclusive;
use std::sync::Arc;

/// Threads that a run puts up with losing, to bodies that never come back or for good: each keeps its stack, and its
/// spare takes another.
const MOST_LOST: u64 = 16;

pub(crate) struct Supervision<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    shared: Arc<Shared<C, H, L>>,
    starter: Starter,
    running: Vec<Started>,
    /// Spares that set themselves up.
    spares: Lanes<C, H, L>,
    /// Threads that ever became part of the run.
    threads: u64,
    /// Those that were replaced and have not ended yet.
    stuck: Vec<Pid>,
    /// Lanes that stay without a thread, a bit each.
    gone: u32,
    pub(crate) threads_died: u64,
    pub(crate) pinned_again: u64,
    pub(crate) gave_up: Option<Surrender>,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Supervision<C, H, L> {
    /// Lets the lanes go.
    pub(crate) fn new(shared: Arc<Shared<C, H, L>>, starter: Starter, lanes: Lanes<C, H, L>) -> Self {
        let threads = lanes.len() as u64;
        let running = lanes.into_iter().map(|lane| lane.go(&shared, 0)).collect();
        let (gone, threads_died, pinned_again) = (0, 0, 0);
        let (spares, stuck, gave_up) = (Vec::new(), Vec::new(), None);
        Self { shared, starter, running, spares, threads, stuck, gone, threads_died, pinned_again, gave_up }
    }

    /// Asks all lanes to leave and waits for them: what they measured, with their numbers.
    pub(crate) fn end(&mut self) -> Vec<(usize, LaneFigures)> {
        self.shared.end();
        let shared = &self.shared;
        let ended = self.running.drain(..).filter_map(|thread| Some((thread.lane, thread.end(shared)?)));
        ended.collect()
    }

    /// Lanes that stay without a thread.
    pub(crate) fn lanes_lost(&self) -> u64 {
        (self.gone | self.shared.left.load(Ordering::Relaxed)).count_ones().into()
    }
}

/// A panic of who runs it leaves no lane behind.
impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Drop for Supervision<C, H, L> {
    fn drop(&mut self) {
        self.end();
    }
}

impl<C, H, L> Supervision<C, H, L>
where
    C: Capacity,
    H: Host<C> + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    /// One look.
    pub(crate) fn look(&mut self) {
        for lane in 0..self.shared.slots.len() {
            // Without one, a spare is on its way.
            let Some(thread) = self.shared.slots[lane].thread().map(Pid::from_raw) else { continue };
            match placement::cpus_of(thread) {
                // One that was asked to leave may have done so. The kernel tells of its end after that.
                Err(Errno::ESRCH) if !self.shared.waiting.is_stopping() => self.bury(lane),
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
        self.let_in();
        if self.lanes_lost() == self.shared.slots.len() as u64 {
            self.gave_up = Some(Surrender::NoLane);
        }
    }

    /// The lane's thread has ended: what it was to keep falls to the others. If nobody asked it to, its unit fails as
    /// that of a body that hangs does.
    fn bury(&mut self, lane: usize) {
        let (shared, slot) = (&self.shared, &self.shared.slots[lane]);
        slot.forget();
        shared.waiting.bury(lane);
        // Otherwise its body came back beyond its bound, which the watchdog says.
        if slot.reset() == Bound::Kept {
            self.threads_died += 1;
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
        let slot = &self.shared.slots[lane];
        self.stuck.retain(|thread| placement::cpus_of(*thread).is_ok());
        self.stuck.extend(slot.thread().map(Pid::from_raw));
        slot.forget();
        let may = self.stuck.len() as u64 + self.threads_died <= MOST_LOST;
        match may.then(|| self.starter.start(lane)) {
            Some(Ok(spare)) => self.spares.push(spare),
            Some(Err(_)) | None => self.gone |= 1 << lane,
        }
    }

    /// Spares that are set up take their lanes.
    fn let_in(&mut self) {
        for mut spare in mem::take(&mut self.spares) {
            let (shared, lane) = (&self.shared, spare.lane);
            match spare.verdict() {
                None => self.spares.push(spare),
                Some(Err(_)) => self.gone |= 1 << lane,
                Some(Ok(())) => {
                    shared.spares.assign(lane, &shared.waiting.seats[lane], self.threads);
                    self.running.push(spare.go(shared, self.threads));
                    self.threads += 1;
                }
            }
        }
    }
}
