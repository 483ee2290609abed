//! A scheduler whose inputs are recorded.

mod set_up;

use crate::entry::{Answer, Call, End, Entry};
use crate::started::Started;
use crate::tape::Tape;
use core::hint::cold_path;
use core::ops::Deref;
use red_core::{
    Action, Capacity, CommitError, CompleteError, Duration, Event, Instant, JobId, LaneId, Outcome,
    ReleaseError, Scheduler, TaskId, UnitId, Warning,
};

/// The calls of a scheduler, each written to the tape if there is one. What only looks is asked of the scheduler
/// itself; what changes it can only be asked here, so nothing is forgotten.
///
/// ```
/// use red_core::{Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
/// use red_record::Recorder;
/// let mut dag = Dag::<Caps<1, 8, 4>>::new();
/// dag.add_node(Node::new(Wcet::from_millis(2)))?;
/// let mut scheduler = Scheduler::new(Config::REDRT);
/// let mut recorded = Recorder::new(&mut scheduler, None);
/// let task = recorded.add_task(&dag, Timing::new(Duration::from_millis(50)))?;
/// recorded.release_at(task, Instant::ZERO, None, Instant::ZERO)?;
/// assert_eq!(recorded.jobs_in_flight(), 1);
/// let mut edit = Scheduler::edit(&recorded, task).expect("the task is there");
/// edit.add_node(Node::new(Wcet::from_millis(1)))?;
/// assert!(recorded.commit(&edit, Instant::ZERO)?.fits());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recorder<'a, C: Capacity> {
    scheduler: &'a mut Scheduler<C>,
    tape: Option<&'a mut Tape>,
}

impl<C: Capacity> Deref for Recorder<'_, C> {
    type Target = Scheduler<C>;

    fn deref(&self) -> &Scheduler<C> {
        self.scheduler
    }
}

impl<'a, C: Capacity> Recorder<'a, C> {
    /// For one turn of whoever has the scheduler.
    pub const fn new(scheduler: &'a mut Scheduler<C>, tape: Option<&'a mut Tape>) -> Self {
        Self { scheduler, tape }
    }

    /// [`Scheduler::release_at`]. Errors: as there.
    #[inline(always)]
    pub fn release_at(
        &mut self,
        task: TaskId,
        at: Instant,
        capture: Option<u64>,
        now: Instant,
    ) -> Result<JobId, ReleaseError> {
        let answer = self.scheduler.release_at(task, at, capture, now);
        self.put(now, Call::Release { task, at, capture }, Answer::Released(answer));
        answer
    }

    /// [`Scheduler::complete`]. Errors: as there.
    #[inline(always)]
    pub fn complete(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        let answer = self.scheduler.complete(unit, now);
        if let Some(tape) = &mut self.tape
            && !(answer.is_ok() && tape.completed(unit, now))
        {
            cold_path();
            self.put(now, Call::Complete(unit), Answer::Reported(answer));
        }
        answer
    }

    /// [`Scheduler::fail`]. Errors: as there.
    pub fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        let answer = self.scheduler.fail(unit, now);
        self.put(now, Call::Fail(unit), Answer::Reported(answer));
        answer
    }

    /// [`Scheduler::poll`].
    #[must_use = "an action that is not carried out is lost"]
    #[inline(always)]
    pub fn poll(&mut self, now: Instant) -> Option<Action> {
        let answer = self.scheduler.poll(now);
        if let Some(tape) = &mut self.tape {
            let answer = Answer::of_poll(self.scheduler, answer, tape.starts());
            tape.put(&Entry { now, call: Call::Poll(None), answer });
        }
        answer
    }

    /// [`Scheduler::poll_on`].
    #[must_use = "an action that is not carried out is lost"]
    #[inline(always)]
    pub fn poll_on(&mut self, lane: LaneId, now: Instant) -> Option<Action> {
        let answer = self.scheduler.poll_on(lane, now);
        if let Some(tape) = &mut self.tape {
            let unusual = match answer {
                None if tape.found_nothing(lane, now) => None,
                Some(Action::Dispatch(dispatch)) => {
                    let started = Started::of(self.scheduler, dispatch.unit, tape.starts());
                    (!tape.dispatched(lane, &started, now)).then_some(Answer::Started(started))
                }
                _ => Some(Answer::of_poll(self.scheduler, answer, tape.starts())),
            };
            if let Some(answer) = unusual {
                cold_path();
                tape.put(&Entry { now, call: Call::Poll(Some(lane)), answer });
            }
        }
        answer
    }

    /// [`Scheduler::complete_and_poll`]; in a log it is both calls. Errors: as there.
    #[inline(always)]
    pub fn complete_and_poll(&mut self, unit: UnitId, now: Instant) -> Result<Option<Action>, CompleteError> {
        if self.tape.is_none() {
            return self.scheduler.complete_and_poll(unit, now);
        }
        self.complete(unit, now)?;
        // A step back of the clock was counted by the first of them.
        let now = self.scheduler.now();
        Ok(self.poll_on(unit.lane(), now))
    }

    /// [`Scheduler::take_outcome`].
    #[inline(always)]
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        let answer = self.scheduler.take_outcome();
        // Finding none changes nothing.
        if let Some(outcome) = answer {
            self.untimed(Call::TakeOutcome, Answer::Ended(outcome));
        }
        answer
    }

    /// Makes the host's graph change of this number: `change` does so on the scheduler, and does the same whenever it is
    /// called with that number. For changes that a workload file lists; others are [`commit`](Self::commit)s. Errors:
    /// those of `change`.
    pub fn edit(
        &mut self,
        number: u32,
        now: Instant,
        change: impl FnOnce(&mut Scheduler<C>) -> Result<(), CommitError>,
    ) -> Result<(), CommitError> {
        let answer = change(self.scheduler);
        self.put(now, Call::Edit(number), Answer::Edited(answer));
        answer
    }

    /// [`Scheduler::remove_task`].
    pub fn remove_task(&mut self, task: TaskId, now: Instant) -> bool {
        let answer = self.scheduler.remove_task(task, now);
        self.put(now, Call::Remove(task), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::retire_lane`].
    pub fn retire_lane(&mut self, lane: LaneId) -> bool {
        let answer = self.scheduler.retire_lane(lane);
        self.untimed(Call::Retire(lane), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::restore_lane`].
    pub fn restore_lane(&mut self, lane: LaneId) -> bool {
        let answer = self.scheduler.restore_lane(lane);
        self.untimed(Call::Restore(lane), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::stood_still`].
    pub fn stood_still(&mut self, time: Duration, now: Instant) {
        self.scheduler.stood_still(time, now);
        self.put(now, Call::StoodStill(time), Answer::Nothing);
    }

    /// [`Scheduler::take_event`]: no input, for nothing that the scheduler does depends on it.
    #[inline(always)]
    pub fn take_event(&mut self) -> Option<&Event> {
        self.scheduler.take_event()
    }

    /// [`Scheduler::take_warning`]: no input either.
    pub fn take_warning(&mut self) -> Option<Warning> {
        self.scheduler.take_warning()
    }

    /// The run ended at `now`: that and how it left the scheduler are the last entry. A log without it is refused.
    pub fn end(&mut self, now: Instant) {
        if let Some(tape) = &mut self.tape {
            let answer = Answer::End(End::of(self.scheduler, tape.starts()));
            tape.put(&Entry { now, call: Call::End, answer });
        }
    }

    fn put(&mut self, now: Instant, call: Call, answer: Answer) {
        if let Some(tape) = &mut self.tape {
            tape.put(&Entry { now, call, answer });
        }
    }

    fn untimed(&mut self, call: Call, answer: Answer) {
        if let Some(tape) = &mut self.tape {
            let now = tape.now();
            tape.put(&Entry { now, call, answer });
        }
    }
}
