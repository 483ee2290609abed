//! One lane on the calling thread. The peers read no clock, so a count of the calls stands in for it.

use std::hint::black_box;

use red_core::{Action, Capacity, Config, Instant, PoolId, Scheduler};

use super::{admit, dag};
use crate::measure::{Runner, fill};
use crate::not_run::NotRun;
use crate::peers::Setup;

pub(super) fn build<C: Capacity>(setup: &Setup<'_>, config: Config) -> Result<Runner, NotRun> {
    let mut scheduler = Box::new(Scheduler::<C>::new(config));
    let task = admit(&mut scheduler, &dag(setup.graph, |_| PoolId::new(0))?)?;
    let (body, call) = (setup.body, setup.body.behind_pointer());
    let mut calls = 0;
    let mut now = move || {
        calls += 1;
        Instant::from_nanos(calls)
    };
    Ok(Box::new(move |runs, samples| {
        let mut completed = true;
        fill(samples, || {
            for _ in 0..runs {
                let at = now();
                let released = scheduler.release(task, at);
                let mut action = Ok(scheduler.poll(at));
                while let Ok(Some(Action::Dispatch(next))) = action {
                    call(body, next.unit.node().index());
                    action = scheduler.complete_and_poll(next.unit, now());
                }
                completed &=
                    released.is_ok() && matches!(action, Ok(Some(Action::Ended(job))) if job.on_time());
                while black_box(&scheduler.take_event()).is_some() {}
            }
        });
        if completed { Ok(()) } else { Err(NotRun::Failed("RED left a job undone".to_owned())) }
    }))
}
