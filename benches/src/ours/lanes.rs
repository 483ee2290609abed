//! Two lanes under the ticket lock. A lane that reports its unit polls in the same hold of the lock and hands
//! the units of other lanes to them, each by one store; a lane without a unit spins on a line of its own.

use std::hint;
use std::sync::Arc;
use std::time;

use red_core::{Action, Capacity, Dag, Instant, ReleaseError, Scheduler, TaskId, UnitId};
use red_sync::{SharedScheduler, TicketLock};

use super::{admit, failed};
use crate::companion::Companion;
use crate::graphs::Body;
use crate::line::Line;
use crate::machine::Machine;
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;

/// What the releasing lane finds on its line when a job has ended, or'ed to the count of jobs. No unit has this
/// bit, and no word comes twice.
const ENDED: u64 = 1 << 63;

struct Lanes<C: Capacity> {
    shared: SharedScheduler<C, TicketLock<Scheduler<C>>, 1, 8>,
    lines: [Line; 2],
    task: TaskId,
    epoch: time::Instant,
    body: Body,
    call: fn(Body, usize),
}

impl<C: Capacity> Lanes<C> {
    fn now(&self) -> Instant {
        Instant::from_nanos(self.epoch.elapsed().as_nanos() as u64)
    }

    /// Hands out what there is to do, from `action` on; the unit of `lane` itself is returned.
    #[inline(always)]
    fn hand_out(
        &self,
        scheduler: &mut Scheduler<C>,
        mut action: Option<Action>,
        lane: usize,
        now: Instant,
    ) -> Option<UnitId> {
        let mut own = None;
        while let Some(next) = action {
            match next {
                Action::Dispatch(next) if next.lane.index() == lane => own = Some(next.unit),
                Action::Dispatch(next) => self.lines[next.lane.index()].store(next.unit.to_bits()),
                Action::Ended(job) => self.lines[0].store(ENDED | job.index),
                _ => {}
            }
            action = scheduler.poll(now);
        }
        own
    }

    /// Releases a job from lane 0.
    fn release(&self) -> Result<Option<UnitId>, ReleaseError> {
        let now = self.now();
        self.shared.with(|scheduler, _| {
            scheduler.release(self.task, now)?;
            let first = scheduler.poll(now);
            Ok(self.hand_out(scheduler, first, 0, now))
        })
    }

    /// Runs a unit on `lane`, and those that follow it there.
    fn run(&self, lane: usize, first: Option<UnitId>) {
        let mut own = first;
        while let Some(unit) = own {
            (self.call)(self.body, unit.node().index());
            let now = self.now();
            own = self.shared.with(|scheduler, _| {
                let next = scheduler.complete_and_poll(unit, now).unwrap_or(None);
                self.hand_out(scheduler, next, lane, now)
            });
        }
    }

    /// Releases a job from lane 0 and takes part until it ended.
    fn once(&self, seen: &mut u64) -> Result<(), NotRun> {
        let mut own = self.release().map_err(failed)?;
        loop {
            self.run(0, own);
            let word = self.lines[0].wait(seen).ok_or_else(NotRun::lane_gone)?;
            if word & ENDED != 0 {
                return Ok(());
            }
            own = Some(UnitId::from_bits(word));
        }
    }
}

pub(super) fn build<C: Capacity>(
    machine: &'static Machine,
    body: Body,
    mut scheduler: Scheduler<C>,
    dag: &Dag<C>,
) -> Result<Runner, NotRun> {
    let task = admit(&mut scheduler, dag)?;
    let lanes = Arc::new(Lanes {
        shared: SharedScheduler::new(scheduler),
        lines: Default::default(),
        task,
        epoch: time::Instant::now(),
        body,
        call: body.behind_pointer(),
    });
    let companion = Companion::spawn(machine, {
        let (lanes, mut seen) = (Arc::clone(&lanes), 0);
        move || {
            lanes.run(1, lanes.lines[1].news(&mut seen).map(UnitId::from_bits));
            hint::spin_loop();
        }
    })?;
    let mut seen = 0;
    Ok(Box::new(move |runs, samples| {
        let mut ended = Ok(());
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    if ended.is_ok() {
                        ended = lanes.once(&mut seen);
                    }
                }
            });
        })?;
        ended
    }))
}
