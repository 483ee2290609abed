//! A frame released by a thread that is no lane: a request in the mailbox, and a ring for the lane, which spins.

use std::hint;
use std::sync::Arc;
use std::time;

use red_core::{Action, Capacity, Config, Instant, PoolId, Scheduler, TaskId};
use red_sync::{Request, SharedScheduler, TicketLock};

use super::{admit, dag};
use crate::companion::Companion;
use crate::graphs::Body;
use crate::line::Line;
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;

struct Frame<C: Capacity> {
    shared: SharedScheduler<C, TicketLock<Scheduler<C>>, 1, 8>,
    /// The count of frames, by the releasing thread when it posted one and by the lane when it has ended.
    bell: Line,
    ended: Line,
    task: TaskId,
    epoch: time::Instant,
    body: Body,
    call: fn(Body, usize),
}

impl<C: Capacity> Frame<C> {
    fn now(&self) -> Instant {
        Instant::from_nanos(self.epoch.elapsed().as_nanos() as u64)
    }

    /// The lane: takes what was requested when its bell rang, and runs until the job has ended.
    fn lane(&self, seen: &mut u64) {
        hint::spin_loop();
        let Some(frame) = self.bell.news(seen) else { return };
        let now = self.now();
        let mut action = self.shared.with(|scheduler, requests| {
            while let Some(request) = requests.next() {
                // A refused release leaves the releasing thread without an answer, and that is reported.
                let _ = scheduler.release_at(request.task, request.at, request.capture, now);
            }
            scheduler.poll(now)
        });
        while let Some(Action::Dispatch(next)) = action {
            (self.call)(self.body, next.unit.node().index());
            let now = self.now();
            action =
                self.shared.with(|scheduler, _| scheduler.complete_and_poll(next.unit, now).unwrap_or(None));
        }
        if action.is_some() {
            self.ended.store(frame);
        }
    }

    fn once(&self, seen: &mut u64) -> Result<(), NotRun> {
        let request = Request { task: self.task, at: self.now(), capture: None };
        let posted = self.shared.producer(0).is_some_and(|post| post.push(request).is_ok());
        self.bell.store(*seen + 1);
        let ended = self.ended.wait(seen);
        if posted && ended.is_some() { Ok(()) } else { Err(NotRun::lane_gone()) }
    }
}

pub(super) fn build<C: Capacity>(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let mut scheduler = Scheduler::<C>::new(Config::REDRT);
    let task = admit(&mut scheduler, &dag(setup.graph, |_| PoolId::new(0))?)?;
    let frame = Arc::new(Frame {
        shared: SharedScheduler::new(scheduler),
        bell: Line::default(),
        ended: Line::default(),
        task,
        epoch: time::Instant::now(),
        body: setup.body,
        call: setup.body.behind_pointer(),
    });
    let companion = Companion::spawn(setup.machine, {
        let (frame, mut seen) = (Arc::clone(&frame), 0);
        move || frame.lane(&mut seen)
    })?;
    let mut seen = 0;
    Ok(Box::new(move |runs, samples| {
        let mut ended = Ok(());
        companion.beside(|| {
            fill(samples, || {
                for _ in 0..runs {
                    if ended.is_ok() {
                        ended = frame.once(&mut seen);
                    }
                }
            });
        })?;
        ended
    }))
}
