//! What a host may ask: counters, queues, time.

use super::{Scheduler, event::Event};
use crate::capacity::Capacity;
use crate::config::Config;
use crate::time::Instant;

crate::capacity::values! {
    /// What happened so far, in numbers.
    #[derive(Default)]
    #[non_exhaustive]
    pub struct Counters {
        /// Units dispatched.
        pub units: u64,
        /// Encoder sub-jobs that completed without executing: members of a unit beyond the first, and hits.
        pub encoder_runs_saved: u64,
        /// Executions beyond the WCET.
        pub overruns: u64,
        /// Calls whose `now` was before an earlier one.
        pub clock_steps_back: u64,
        /// Completions of units whose jobs had been given up.
        pub late_completions: u64,
        /// Results thrown away for memory; their encoders run again.
        pub evictions: u64,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// The configuration.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Lanes over all pools, retired ones too.
    pub const fn lanes(&self) -> usize {
        self.lane_count as usize
    }

    /// Latest time seen: time never goes back.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// What happened so far, in numbers.
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Jobs in flight.
    pub const fn jobs_in_flight(&self) -> usize {
        self.in_flight.count_ones() as usize
    }

    /// Sub-jobs that are ready and wait for a lane.
    pub fn ready_sub_jobs(&self) -> usize {
        self.slots().map(|slot| self.jobs[slot].ready.len()).sum()
    }

    /// Units that run, whether or not their jobs still want them.
    pub fn running_units(&self) -> usize {
        (0..self.lanes()).filter(|l| self.lanes[*l].is_busy()).count()
    }

    /// Takes the oldest event of the record.
    pub fn take_event(&mut self) -> Option<&Event> {
        self.record.take()
    }

    /// Events that the record had to drop because nobody took them; exact.
    pub const fn events_dropped(&self) -> u64 {
        self.record.dropped
    }
}
