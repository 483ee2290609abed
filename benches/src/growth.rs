//! What one call costs as the graph grows, with a capacity that is fitted to each size. Four calls are timed
//! together, and what the clock itself takes is subtracted.

use std::time::{Duration, Instant as Clock};

use red_core::{Action, Capacity, Caps, Config, Instant, PoolId, Scheduler, TaskId};

use crate::graphs::Graph;
use crate::measure::{Entry, Runner};
use crate::not_run::NotRun;
use crate::ours;

/// Calls that are timed together: as many lanes and jobs, and as many nodes in a layer.
pub(crate) const CALLS: usize = 4;

/// The reference.
pub(crate) const SMALLEST: &str = "8 nodes";

/// Which calls are timed; the others between them are not.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Called {
    Release,
    Poll,
    Complete,
}

/// Every call and its name.
pub(crate) const CALLED: [(&str, Called); 3] =
    [("release", Called::Release), ("poll", Called::Poll), ("complete", Called::Complete)];

/// The sizes at the start line.
pub(crate) fn field(called: Called) -> Vec<Entry> {
    let entry = |name: &str, ours, runner| Entry { name: name.to_owned(), ours, runner };
    vec![
        entry(SMALLEST, false, build::<Caps<1, 8, CALLS>>(called, 8)),
        entry("64 nodes", true, build::<Caps<1, 64, CALLS>>(called, 64)),
        entry("256 nodes", true, build::<Caps<1, 256, CALLS, 4, 1, 4>>(called, 256)),
    ]
}

struct Calls<C: Capacity> {
    scheduler: Box<Scheduler<C>>,
    task: TaskId,
    now: u64,
    units: [Option<Action>; CALLS],
}

impl<C: Capacity> Calls<C> {
    fn instant(&mut self) -> Instant {
        self.now += 1;
        Instant::from_nanos(self.now)
    }

    fn release(&mut self, jobs: usize) -> Result<(), NotRun> {
        for _ in 0..jobs {
            let now = self.instant();
            self.scheduler.release(self.task, now).map_err(ours::failed)?;
        }
        Ok(())
    }

    fn poll(&mut self) {
        for lane in 0..CALLS {
            let now = self.instant();
            self.units[lane] = self.scheduler.poll(now);
        }
    }

    fn complete(&mut self) -> Result<(), NotRun> {
        for lane in 0..CALLS {
            let now = self.instant();
            if let Some(Action::Dispatch(unit)) = self.units[lane] {
                self.scheduler.complete(unit.unit, now).map_err(ours::failed)?;
            }
        }
        Ok(())
    }

    /// Runs to the end what is released; for a call other than the release, what it takes in layer `timed`.
    fn run(&mut self, called: Called, timed: usize) -> Result<Duration, NotRun> {
        let start = Clock::now();
        self.release(if called == Called::Release { CALLS } else { 1 })?;
        let mut spent = start.elapsed();
        let mut layer = 0;
        while self.scheduler.jobs_in_flight() > 0 {
            let start = Clock::now();
            self.poll();
            let polled = Clock::now();
            self.complete()?;
            let completed = Clock::now();
            match called {
                Called::Poll if layer == timed => spent = polled - start,
                Called::Complete if layer == timed => spent = completed - polled,
                _ => {}
            }
            // What has ended is taken here, so that a poll has nothing to do but to start units.
            while self.scheduler.take_outcome().is_some() {}
            layer += 1;
        }
        Ok(spent)
    }
}

fn build<C: Capacity>(called: Called, nodes: usize) -> Result<Runner, NotRun> {
    let dag = ours::dag::<C>(&Graph::lattice(nodes, CALLS), |_| PoolId::new(0))?;
    let mut scheduler = Box::new(Scheduler::new(Config::REDRT.with_lanes(CALLS as u8)));
    let task = ours::admit(&mut scheduler, &dag)?;
    let mut calls = Calls { scheduler, task, now: 0, units: [None; CALLS] };
    let clock = (0..1_000).map(|_| Clock::now().elapsed()).min().unwrap_or_default();
    // The last layer has no successors, which no other size would have in the same proportion.
    let layers = nodes / CALLS - 1;
    Ok(Box::new(move |runs, samples| {
        for sample in samples {
            let mut spent = Duration::ZERO;
            for run in 0..runs {
                spent += calls.run(called, run % layers)?.saturating_sub(clock);
            }
            *sample = spent.as_nanos() as u64;
        }
        Ok(())
    }))
}
