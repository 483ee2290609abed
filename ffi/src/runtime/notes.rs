//! Jobs that ended and events, until somebody takes them. Written under the scheduler's lock, without waiting.

use crate::action::red_outcome;
use crate::event::red_event;
use core::sync::atomic::{AtomicU64, Ordering};
use red_core::{Event, Instant, JobId, Outcome, ReleaseError};
use red_record::class::Large;
use red_rt::timeline::Host;
use red_sync::Mailbox;
use std::sync::Arc;

/// Outcomes, and events, that wait to be taken at most.
const OUTCOMES: usize = 1024;
const EVENTS: usize = 8192;

/// What a runtime tells.
pub(crate) struct Notes {
    outcomes: Mailbox<red_outcome, OUTCOMES>,
    events: Mailbox<red_event, EVENTS>,
    pub(crate) released: AtomicU64,
    pub(crate) on_time: AtomicU64,
    pub(crate) missed: AtomicU64,
    pub(crate) shed: AtomicU64,
    pub(crate) outcomes_dropped: AtomicU64,
    pub(crate) events_dropped: AtomicU64,
    /// Start of the run, in nanoseconds of CLOCK_MONOTONIC: what comes out counts from boot.
    pub(crate) origin_ns: AtomicU64,
}

impl Notes {
    /// A constant, so that it is made where it lies: it is larger than many stacks.
    #[expect(clippy::declare_interior_mutable_const, reason = "each runtime has one of its own")]
    const NEW: Self = Self {
        outcomes: Mailbox::new(),
        events: Mailbox::new(),
        released: AtomicU64::new(0),
        on_time: AtomicU64::new(0),
        missed: AtomicU64::new(0),
        shed: AtomicU64::new(0),
        outcomes_dropped: AtomicU64::new(0),
        events_dropped: AtomicU64::new(0),
        origin_ns: AtomicU64::new(0),
    };

    pub(crate) fn new() -> Arc<Self> {
        Box::write(Box::new_uninit(), Self::NEW).into()
    }

    /// The oldest outcome. One thread at a time; a second one gets none.
    pub(crate) fn take_outcome(&self) -> Option<red_outcome> {
        let mut outcome = self.outcomes.pop()?;
        let origin = self.origin_ns.load(Ordering::Relaxed);
        for time in [&mut outcome.release_ns, &mut outcome.deadline_ns, &mut outcome.at_ns] {
            *time = time.saturating_add(origin);
        }
        Some(outcome)
    }

    /// The oldest event. One thread at a time; a second one gets none.
    pub(crate) fn take_event(&self) -> Option<red_event> {
        let event = self.events.pop()?;
        Some(red_event { at_ns: event.at_ns.saturating_add(self.origin_ns.load(Ordering::Relaxed)), ..event })
    }
}

fn count(of: &AtomicU64) {
    of.fetch_add(1, Ordering::Relaxed);
}

/// The host of the lanes.
pub(crate) struct Teller(pub(crate) Arc<Notes>);

impl Host<Large> for Teller {
    fn released(&mut self, _task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        match taken {
            Ok(_) => count(&self.0.released),
            Err(ReleaseError::Full) => {
                count(&self.0.released);
                count(&self.0.shed);
                count(&self.0.missed);
            }
            Err(_) => {}
        }
    }

    fn ended(&mut self, outcome: &Outcome) {
        count(if outcome.on_time() { &self.0.on_time } else { &self.0.missed });
        if outcome.shed.is_some() {
            count(&self.0.shed);
        }
        let posted = self.0.outcomes.claim().is_some_and(|post| post.push((*outcome).into()).is_ok());
        if !posted {
            count(&self.0.outcomes_dropped);
        }
    }

    fn event(&mut self, event: &Event) {
        let posted = self.0.events.claim().is_some_and(|post| post.push(event.into()).is_ok());
        if !posted {
            count(&self.0.events_dropped);
        }
    }
}
