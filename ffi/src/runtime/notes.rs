//! Jobs that ended and events, until somebody takes them. Written under the scheduler's lock, without waiting.

use super::task_report::TaskNotes;
use crate::action::red_outcome;
use crate::event::red_event;
use crate::warning::red_warning;
use core::sync::atomic::{AtomicU64, Ordering};
use red_core::{Capacity, Event, Floor, Instant, JobId, Outcome, ReleaseError, Warning};
use red_record::class::Large;
use red_rt::timeline::Host;
use red_sync::Mailbox;
use std::sync::Arc;

/// Outcomes, warnings and events that wait to be taken at most.
const OUTCOMES: usize = 1024;
const WARNINGS: usize = 1024;
const EVENTS: usize = 8192;

/// What a runtime tells.
pub(crate) struct Notes {
    outcomes: Mailbox<red_outcome, OUTCOMES>,
    warnings: Mailbox<red_warning, WARNINGS>,
    events: Mailbox<red_event, EVENTS>,
    pub(crate) tasks: [TaskNotes; Large::TASKS],
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
        warnings: Mailbox::new(),
        events: Mailbox::new(),
        tasks: [const { TaskNotes::NEW }; Large::TASKS],
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

    /// The oldest warning. One thread at a time; a second one gets none.
    pub(crate) fn take_warning(&self) -> Option<red_warning> {
        let mut warning = self.warnings.pop()?;
        let origin = self.origin_ns.load(Ordering::Relaxed);
        for time in [&mut warning.deadline_ns, &mut warning.at_ns] {
            *time = time.saturating_add(origin);
        }
        Some(warning)
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
pub(crate) struct Teller {
    notes: Arc<Notes>,
    floors: [Floor; Large::TASKS],
}

impl Teller {
    pub(crate) fn new(notes: Arc<Notes>) -> Self {
        Self { notes, floors: [const { Floor::new(0, 0) }; Large::TASKS] }
    }
}

impl Host<Large> for Teller {
    fn released(&mut self, task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        if taken.is_err_and(|error| error != ReleaseError::Full) {
            return;
        }
        let (notes, is_taken) = (&self.notes, taken.is_ok());
        count(&notes.released);
        if !is_taken {
            count(&notes.shed);
            count(&notes.missed);
        }
        if let (Some(of_task), Some(floor)) = (notes.tasks.get(task), self.floors.get_mut(task)) {
            of_task.released();
            if !is_taken {
                of_task.refused(floor);
            }
        }
    }

    fn ended(&mut self, outcome: &Outcome) {
        let notes = &self.notes;
        count(if outcome.on_time() { &notes.on_time } else { &notes.missed });
        if outcome.shed.is_some() {
            count(&notes.shed);
        }
        let task = outcome.task.index();
        if let (Some(of_task), Some(floor)) = (notes.tasks.get(task), self.floors.get_mut(task)) {
            of_task.ended(outcome, floor);
        }
        let posted = notes.outcomes.claim().is_some_and(|post| post.push((*outcome).into()).is_ok());
        if !posted {
            count(&notes.outcomes_dropped);
        }
    }

    fn warned(&mut self, warning: &Warning, now: Instant) {
        if let Some(of_task) = self.notes.tasks.get(warning.task.index()) {
            of_task.warned();
        }
        let post = self.notes.warnings.claim();
        let posted = post.is_some_and(|post| post.push(red_warning::of(warning, now)).is_ok());
        if !posted {
            count(&self.notes.events_dropped);
        }
    }

    fn event(&mut self, event: &Event) {
        let posted = self.notes.events.claim().is_some_and(|post| post.push(event.into()).is_ok());
        if !posted {
            count(&self.notes.events_dropped);
        }
    }
}
