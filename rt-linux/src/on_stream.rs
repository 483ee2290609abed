//! A lane whose handler has a stream: it gives units to it, waits for the oldest, and gives more meanwhile.
//!
//! *How it waits.* It asks again and again for as long as an idle lane spins. After that a lane in real time, which has its
//! CPU to itself, asks every [`SHORT_NS`]; one that shares CPUs has itself called by the driver, whose thread is ordinary
//! and takes several times as long.

use crate::allocations::arm;
use crate::bell::{Bell, Woken};
use crate::clock::now_ns;
use crate::handler::{Failed, Work};
use crate::lane::Lane;
use crate::panics::{BodyPanic, caught};
use crate::report::{LaneFigures, StreamHang};
use crate::stream::{Progress, Stream, Submitted};
use crate::stream_seat::{Ahead, StreamSeat};
use crate::timeline::Host;
use crate::watchdog::Bound;
use red_core::{Capacity, PoolId, Scheduler, UnitId};
use red_sync::Exclusive;
use std::sync::Arc;

/// Between two looks of a lane that has itself called: a ring may get lost with the device.
const LOOK_NS: u64 = 5_000_000;
/// Bound of what a stream runs, as of a body: so many times its WCET, and a fixed part.
const BOUND_TIMES: u64 = 10;
const BOUND_PLUS_NS: u64 = 100_000_000;

/// What a lane has taken and not reported.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// The oldest first: one that counts as started, one behind it, and one more where others reported the first.
    units: [Option<Entry>; 3],
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    ahead: Ahead,
    state: Submitted,
}

impl Queue {
    fn push(&mut self, ahead: Ahead) {
        if let Some(free) = self.units.iter_mut().find(|place| place.is_none()) {
            *free = Some(Entry { ahead, state: Submitted::NotYet });
        }
    }

    fn has_room(&self) -> bool {
        self.units[2].is_none()
    }

    fn pop(&mut self) {
        self.units.rotate_left(1);
        self.units[2] = None;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.units[0].is_none()
    }

    /// All that is in it.
    pub(crate) fn units(&self) -> impl Iterator<Item = UnitId> + '_ {
        self.units.iter().flatten().map(|entry| entry.ahead.work.unit)
    }

    /// Gives the stream what can be given, in its order.
    fn submit(&mut self, stream: &mut dyn Stream, figures: &mut LaneFigures) {
        for entry in self.units.iter_mut().flatten() {
            if entry.state == Submitted::NotYet {
                let (work, after) = (entry.ahead.work, entry.ahead.after());
                // What a body takes is its own.
                arm(false);
                let submitted = caught(|| stream.submit(&work, after));
                entry.state = submitted.unwrap_or_else(|message| {
                    let Work { task, node, job, .. } = work;
                    figures.panicked(BodyPanic { task: task.index(), node, job, message });
                    Submitted::Failed
                });
                arm(true);
            }
            if entry.state == Submitted::NotYet {
                return;
            }
        }
    }
}

/// Why a lane leaves its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leaves {
    /// A unit does not come to its end.
    Hangs,
    /// What it runs on is gone.
    Lost,
}

/// How the oldest unit of a lane's stream ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) unit: UnitId,
    pub(crate) pool: PoolId,
    pub(crate) ok: bool,
    pub(crate) end: u64,
    /// Nothing may be given to the stream any more.
    pub(crate) leaves: Option<Leaves>,
    /// Whether the lane is still this thread's: a handler that did not come back in time has lost it.
    pub(crate) is_kept: bool,
}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>>> Lane<'_, C, H, L> {
    /// The lane's own place for units ahead, if its handler has a stream.
    pub(crate) fn stream_seat(&self) -> Option<Arc<StreamSeat>> {
        self.shared.waiting.streams.get(self.number).cloned().flatten()
    }

    /// Waits for the unit that was dispatched now, or the oldest that was given ahead. `None`: there is none.
    pub(crate) fn execute_on_stream(&mut self, dispatched: Option<&Work>) -> Option<Ended> {
        let (seat, shared) = (self.stream_seat()?, self.shared);
        let Self { handler, queue, figures, number, .. } = self;
        let stream = handler.stream()?;
        if let Some(work) = dispatched {
            figures.dispatched(shared.waiting.now().saturating_sub(work.since_ns));
            queue.push(Ahead::at_once(*work));
        }
        take_ahead(queue, &seat, figures, shared.waiting.now());
        let Ahead { work, wait_ns, .. } = queue.units[0]?.ahead;
        figures.units += 1;
        let (mut start, begin) = (None, shared.waiting.now());
        let within = |wcet_ns: u64| wcet_ns.saturating_mul(BOUND_TIMES).saturating_add(BOUND_PLUS_NS);
        let bound_ns = within(work.wcet_ns).saturating_add(within(wait_ns));
        let bound = begin.saturating_add(bound_ns);
        let stood_before = shared.standstills.total_ns();
        // The handler's calls are the host's, and may hang as bodies do.
        let patience_ns = bound_ns.saturating_mul(2).saturating_add(BOUND_PLUS_NS);
        let armed = shared.watched(*number, begin, patience_ns);
        let spin_until = begin.saturating_add(shared.waiting.spin_ns());
        let mut called = false;
        let (ok, mut leaves) = loop {
            if shared.slots[*number].has_passed() {
                // The lane is another thread's, which takes what is handed from now on.
                break (false, None);
            }
            take_ahead(queue, &seat, figures, shared.waiting.now());
            queue.submit(stream, figures);
            let now = shared.waiting.now();
            let progress = match queue.units[0]?.state {
                Submitted::Given => stream.look(),
                Submitted::NotYet => Progress::Waits,
                Submitted::Failed => Progress::Done(Err(Failed)),
            };
            match progress {
                Progress::Done(result) => break (result.is_ok(), None),
                Progress::Runs if start.is_none() => start = Some(now),
                _ => {}
            }
            if now >= bound.saturating_add(shared.standstills.total_ns() - stood_before) {
                stream.quarantine();
                let (task, node, job) = (work.task.index(), work.node, work.job);
                figures.stream_hangs.push(StreamHang { lane: *number, task, node, job });
                break (false, Some(Leaves::Hangs));
            }
            if now < spin_until {
                core::hint::spin_loop();
                continue;
            }
            let is_given = queue.units[0]?.state == Submitted::Given;
            if is_given && !called && shared.waiting.spin_ns() == 0 {
                called = stream.call(&seat).is_ok();
                // It may have ended before the call.
                continue;
            }
            let until = now_ns().saturating_add(if called { LOOK_NS } else { SHORT_NS });
            let _woken = sleep(&seat.bell, || queue.has_room() && seat.is_handed(), until);
        };
        if !ok && stream.is_lost() {
            leaves = Some(Leaves::Lost);
        }
        queue.pop();
        let end = shared.waiting.now();
        let took = end.saturating_sub(start.unwrap_or(end));
        figures.nodes_missed += u64::from(end > work.sub_deadline_ns);
        figures.busy_ns += took;
        figures.overruns += u64::from(took > work.wcet_ns);
        figures.failed += u64::from(!ok);
        let is_kept = shared.slots[*number].disarm(armed) == Bound::Kept;
        Some(Ended { unit: work.unit, pool: work.pool, ok, end, leaves, is_kept })
    }
}

/// Between two looks where nobody rings.
const SHORT_NS: u64 = 20_000;

fn sleep(bell: &Bell, ready: impl Fn() -> bool, until: u64) -> Woken {
    bell.wait_for(ready, Some(until), 0)
}

fn take_ahead(queue: &mut Queue, seat: &StreamSeat, figures: &mut LaneFigures, now: u64) {
    while queue.has_room()
        && let Some(ahead) = seat.take()
    {
        figures.dispatched(now.saturating_sub(ahead.work.since_ns));
        queue.push(ahead);
    }
}
