//! Runs whose schedulers were set up by calls: without a workload, so with numbers for names.

use super::Log;
use super::collect::Collector;
use red_core::{Capacity, Empty, Scheduler};
use red_record::class::ForClass;
use red_record::{Broken, Replay, replay_calls_events};

/// Follows one with a scheduler of its class.
pub(super) struct Followed<'a> {
    pub(super) log: &'a mut Log,
    pub(super) collector: &'a mut Collector,
}

impl ForClass for Followed<'_> {
    type Output = Result<Replay, Broken>;

    fn with<C: Capacity>(self) -> Self::Output {
        let Self { log, collector } = self;
        let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
        replay_calls_events(log, &mut scheduler, |scheduler, entry, events| {
            collector.watch(scheduler, entry, events);
        })
    }
}
