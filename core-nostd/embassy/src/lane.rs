//! A lane: takes a unit, stands in line by its sub-deadline, runs its body, reports.

use core::fmt;
use core::future::poll_fn;
use core::task::Poll;

use embassy_executor::Metadata;
use red_core::{Capacity, Empty, LaneId, Unit, UnitId};

use crate::clock;
use crate::dispatcher::{AT_ONCE, Dispatcher};
use crate::handler::Handler;

/// A body failed: the jobs of its unit are given up with the reason `fault`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault;

/// A lane was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LaneError {
    /// The capacity has no such lane.
    Unknown,
    /// Another task runs it.
    Taken,
}

impl fmt::Display for LaneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "The capacity has no such lane.",
            Self::Taken => "Another task runs this lane.",
        })
    }
}

impl core::error::Error for LaneError {}

impl<C: Capacity, const DEPTH: usize> Dispatcher<C, DEPTH> {
    /// Runs the units of a lane for ever; it returns only if the lane is refused. To be awaited by a task of embassy
    /// of its own, whose deadline it sets.
    ///
    /// A body that waits, for a transfer or an accelerator, lets others run. One that computes keeps the executor:
    /// nodes are what the scheduler may order, so a long body is better several nodes.
    pub async fn run_lane<B>(&'static self, lane: LaneId, mut body: impl FnMut(Unit) -> B) -> LaneError
    where
        B: Future<Output = Result<(), Fault>>,
    {
        let own = Metadata::for_current_task().await;
        own.set_deadline(AT_ONCE);
        if let Err(refused) = self.register(lane).await {
            return refused;
        }
        loop {
            let (id, unit) = self.take_unit(lane).await;
            let Some(unit) = unit else {
                // Its jobs were given up meanwhile; only the lane has to come back.
                self.report(id, Ok(()));
                continue;
            };
            own.set_deadline(clock::deadline_ticks(unit.first.sub_deadline));
            give_way().await;
            let ended = body(unit).await;
            own.set_deadline(AT_ONCE);
            self.report(id, ended);
        }
    }

    async fn register(&self, lane: LaneId) -> Result<(), LaneError> {
        poll_fn(|context| {
            Poll::Ready(self.lock(|board| match board.lanes.as_mut().get_mut(lane.index()) {
                None => Err(LaneError::Unknown),
                Some(handler) if handler.is_there() => Err(LaneError::Taken),
                Some(handler) => {
                    *handler = Handler::current(context);
                    Ok(())
                }
            }))
        })
        .await
    }

    /// The unit that the dispatcher left for this lane, and what it is unless its jobs are gone.
    async fn take_unit(&self, lane: LaneId) -> (UnitId, Option<Unit>) {
        poll_fn(|_| {
            self.lock(|board| {
                let unit = core::mem::replace(&mut board.seats[lane.index()], UnitId::EMPTY);
                let is_there = unit != UnitId::EMPTY;
                if is_there { Poll::Ready((unit, board.scheduler.unit(unit))) } else { Poll::Pending }
            })
        })
        .await
    }

    fn report(&self, unit: UnitId, ended: Result<(), Fault>) {
        self.with(|scheduler| {
            // `Late` is the end of a unit whose jobs were given up: its lane is free again.
            let _lane_is_free = match ended {
                Ok(()) => scheduler.complete(unit, clock::now()),
                Err(Fault) => scheduler.fail(unit, clock::now()),
            };
        });
    }
}

/// Back into embassy's queue, to be polled again when no task of an earlier deadline is woken.
async fn give_way() {
    let mut gave = false;
    poll_fn(|context| {
        if gave {
            return Poll::Ready(());
        }
        gave = true;
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}
