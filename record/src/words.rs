//! Entries as words: what is expected costs one word, and a lane's usual turn one for all its calls (`turn.rs`).
//!
//! ```text
//! bits  0..4 call | 4..8 code of the answer | 8..14 lane | 14..20 other lane | 20..28 node | 28..64 time since before
//! ```
//!
//! A unit is expected when it is the next one of the scheduler (dispatched), or the last one of its lane (reported);
//! both sides keep the same books. Whatever is not expected follows in words of its own.

mod turn;

use crate::entry::{Answer, Call, Entry, back, then};
use crate::tape::Chunk;
use red_core::{
    Action, CommitError, CompleteError, Counters, Dispatch, Instant, JobId, LaneId, Outcome, ReleaseError,
    ShedReason, TaskId, UnitId,
};

/// Words that are written for one entry at most: what was held back, its time, its head and an outcome.
pub(crate) const LONGEST: usize = 12;
/// Lanes of a scheduler at most.
const LANES: usize = 32;
/// Longest step of time that fits a head.
const STEP: u64 = 1 << 36;
/// In the place of a lane: none.
const NO_LANE: u64 = 63;
/// In the place of the other lane: the unit follows.
const SPELLED: u64 = 62;
/// An answer that this version has no code for.
const UNKNOWN: u64 = 15;

const RELEASE: [ReleaseError; 3] = [ReleaseError::UnknownTask, ReleaseError::Full, ReleaseError::Overflow];
const REPORT: [CompleteError; 3] = [CompleteError::Stale, CompleteError::NotRunning, CompleteError::Late];
const COMMIT: [CommitError; 7] = [
    CommitError::UnknownTask,
    CommitError::Conflict,
    CommitError::Busy,
    CommitError::Empty,
    CommitError::UnknownPool,
    CommitError::Memory,
    CommitError::Unschedulable,
];
const SHED: [ShedReason; 7] = [
    ShedReason::Hopeless,
    ShedReason::Overload,
    ShedReason::Urgency,
    ShedReason::Full,
    ShedReason::Late,
    ShedReason::Fault,
    ShedReason::Removed,
];

/// The first four bits of a head. The numbers are the format.
mod tag {
    pub(super) const TIME: u64 = 0;
    pub(super) const RELEASE: u64 = 1;
    pub(super) const COMPLETE: u64 = 2;
    pub(super) const FAIL: u64 = 3;
    pub(super) const POLL: u64 = 4;
    pub(super) const TAKE_OUTCOME: u64 = 5;
    pub(super) const EDIT: u64 = 6;
    pub(super) const RETIRE: u64 = 7;
    pub(super) const RESTORE: u64 = 8;
    pub(super) const REMOVE: u64 = 9;
    pub(super) const END: u64 = 10;
    pub(super) const TURN: u64 = 11;
}

/// Codes of what a poll answers.
mod action {
    pub(super) const NOTHING: u64 = 0;
    pub(super) const DISPATCH: u64 = 1;
    pub(super) const PREEMPT: u64 = 2;
    pub(super) const ENDED: u64 = 3;
}

/// What both sides know of the entries so far.
#[derive(Clone, Debug)]
pub(crate) struct Books {
    now: Instant,
    sequence: u64,
    lanes: [UnitId; LANES],
    /// Writing: the head of a turn whose end has not come yet; 0 is none.
    turn: u64,
    /// Reading: what is left of a turn.
    rest: [Option<Entry>; 2],
}

/// The fields of a head but the time.
#[derive(Clone, Copy)]
struct Head {
    tag: u64,
    code: u64,
    lane: u64,
    other: u64,
    node: u64,
}

impl Head {
    const fn new(tag: u64, code: u64) -> Self {
        Self { tag, code, lane: NO_LANE, other: 0, node: 0 }
    }

    const fn on(self, lane: LaneId) -> Self {
        Self { lane: lane.index() as u64 & NO_LANE, ..self }
    }
}

fn code<T, E: PartialEq>(result: Result<T, E>, errors: &[E]) -> u64 {
    match result {
        Ok(_) => 0,
        Err(error) => errors.iter().position(|e| *e == error).map_or(UNKNOWN, |at| at as u64 + 1),
    }
}

fn result<E: Copy>(code: u64, errors: &[E]) -> Option<Result<(), E>> {
    match code.checked_sub(1) {
        None => Some(Ok(())),
        Some(at) => errors.get(usize::try_from(at).ok()?).copied().map(Err),
    }
}

impl Books {
    pub(crate) const fn new() -> Self {
        Self {
            now: Instant::ZERO,
            sequence: 0,
            lanes: [UnitId::from_bits(0); LANES],
            turn: 0,
            rest: [None; 2],
        }
    }

    /// The time of the last entry.
    pub(crate) const fn now(&self) -> Instant {
        self.now
    }

    /// Whether a head has room for the time since the last entry; never for a step back.
    #[inline(always)]
    pub(crate) const fn is_near(&self, now: Instant) -> bool {
        now.as_nanos().wrapping_sub(self.now.as_nanos()) < STEP
    }

    /// Spells a time that is not near; the next entry is of that time.
    pub(crate) fn spell(&mut self, now: Instant, out: &mut Chunk) {
        self.break_turn(out);
        out.more(tag::TIME);
        out.more(now.as_nanos());
        self.now = now;
    }

    /// Writes an entry whose time is near.
    pub(crate) fn encode(&mut self, entry: &Entry, out: &mut Chunk) {
        self.break_turn(out);
        let step = entry.now.as_nanos().wrapping_sub(self.now.as_nanos());
        self.now = entry.now;
        let mut head = |h: Head| {
            out.head(h.tag | h.code << 4 | h.lane << 8 | h.other << 14 | h.node << 20 | step << 28, 1);
        };
        match (entry.call, entry.answer) {
            (Call::Complete(unit), Answer::Reported(answer)) => {
                let h = Head::new(tag::COMPLETE, code(answer, &REPORT));
                if self.is_last(unit) {
                    head(h.on(unit.lane()));
                } else {
                    head(h);
                    out.more(unit.to_bits());
                }
            }
            (Call::Fail(unit), Answer::Reported(answer)) => {
                head(Head::new(tag::FAIL, code(answer, &REPORT)));
                out.more(unit.to_bits());
            }
            (Call::Poll(lane), Answer::Polled(answer)) => {
                let h = Head { lane: lane.map_or(NO_LANE, place), ..Head::new(tag::POLL, action::NOTHING) };
                match answer {
                    None => head(h),
                    Some(Action::Dispatch(Dispatch { unit, .. })) if self.is_next(unit) => {
                        let (other, node) = (place(unit.lane()), unit.node().index() as u64);
                        head(Head { code: action::DISPATCH, other, node, ..h });
                    }
                    Some(Action::Dispatch(Dispatch { unit, .. })) => {
                        head(Head { code: action::DISPATCH, other: SPELLED, ..h });
                        out.more(unit.to_bits());
                    }
                    Some(Action::Preempt(Dispatch { unit, .. })) => {
                        head(Head { code: action::PREEMPT, ..h });
                        out.more(unit.to_bits());
                    }
                    Some(Action::Ended(outcome)) => {
                        head(Head { code: action::ENDED, ..h });
                        put_outcome(&outcome, entry.now, out);
                    }
                    Some(_) => head(Head { code: UNKNOWN, ..h }),
                }
                if let Some(Action::Dispatch(started)) = answer {
                    self.started(started.unit);
                }
            }
            (Call::Release { task, at, capture }, Answer::Released(answer)) => {
                let h = Head::new(tag::RELEASE, code(answer, &RELEASE));
                head(Head { other: u64::from(capture.is_some()), ..h });
                out.more(task.to_bits().into());
                out.more(back(entry.now, at));
                if let Ok(job) = answer {
                    out.more(job.to_bits().into());
                }
                if let Some(capture) = capture {
                    out.more(capture);
                }
            }
            (Call::TakeOutcome, Answer::Outcome(answer)) => {
                head(Head::new(tag::TAKE_OUTCOME, answer.is_some().into()));
                if let Some(outcome) = answer {
                    put_outcome(&outcome, entry.now, out);
                }
            }
            (Call::Edit(number), Answer::Edited(answer)) => {
                head(Head::new(tag::EDIT, code(answer, &COMMIT)));
                out.more(number.into());
            }
            (Call::Retire(lane), Answer::Done(yes)) => head(Head::new(tag::RETIRE, yes.into()).on(lane)),
            (Call::Restore(lane), Answer::Done(yes)) => head(Head::new(tag::RESTORE, yes.into()).on(lane)),
            (Call::Remove(task), Answer::Done(yes)) => {
                head(Head::new(tag::REMOVE, yes.into()));
                out.more(task.to_bits().into());
            }
            (Call::End, Answer::Counters(counters)) => {
                head(Head::new(tag::END, 0));
                numbers(&counters).into_iter().for_each(|number| out.more(number));
            }
            // No call has another's answer: `Recorded` makes the pairs.
            _ => {}
        }
    }

    /// Whether no entry of the last turn that was read is left.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.rest[0].is_none()
    }

    /// Reads the entry that begins with the next word. `None`: no entry is like that.
    pub(crate) fn decode<E>(&mut self, mut next: impl FnMut() -> Result<u64, E>) -> Result<Option<Entry>, E> {
        if let Some(entry) = self.rest[0].take() {
            self.rest.swap(0, 1);
            return Ok(Some(entry));
        }
        let mut word = next()?;
        if word == tag::TIME {
            self.now = Instant::from_nanos(next()?);
            word = next()?;
        }
        self.now = Instant::from_nanos(self.now.as_nanos().wrapping_add(word >> 28));
        let (now, code) = (self.now, word >> 4 & 15);
        let (lane, other, node) = (word >> 8 & 63, word >> 14 & 63, word >> 20 & 255);
        let asked = u8::try_from(lane).ok().filter(|_| lane != NO_LANE).map(LaneId::new);
        let yes = Answer::Done(code != 0);
        let pair = match word & 15 {
            tag::COMPLETE => {
                let last = asked.map(|lane| self.lanes[lane.index() % LANES]);
                let unit = if asked.is_some() { last } else { Some(UnitId::from_bits(next()?)) };
                unit.zip(result(code, &REPORT)).map(|(u, r)| (Call::Complete(u), Answer::Reported(r)))
            }
            tag::TURN => asked.and_then(|lane| self.read_turn(code, lane, node)),
            tag::FAIL => {
                let call = Call::Fail(UnitId::from_bits(next()?));
                result(code, &REPORT).map(|answer| (call, Answer::Reported(answer)))
            }
            tag::POLL => {
                let unit = match code {
                    action::DISPATCH if other != SPELLED => self.expected(other, node),
                    action::DISPATCH | action::PREEMPT => UnitId::from_bits(next()?),
                    _ => UnitId::from_bits(0),
                };
                let dispatch = Dispatch { unit, lane: unit.lane() };
                let answer = match code {
                    action::NOTHING => Some(None),
                    action::DISPATCH => {
                        self.started(unit);
                        Some(Some(Action::Dispatch(dispatch)))
                    }
                    action::PREEMPT => Some(Some(Action::Preempt(dispatch))),
                    action::ENDED => {
                        take_outcome(now, &mut next)?.map(|outcome| Some(Action::Ended(outcome)))
                    }
                    _ => None,
                };
                answer.map(|answer| (Call::Poll(asked), Answer::Polled(answer)))
            }
            tag::RELEASE => {
                let task = bits(next()?).map(TaskId::from_bits);
                let at = then(now, next()?);
                let answer = match result(code, &RELEASE) {
                    Some(Ok(())) => bits(next()?).map(|job| Ok(JobId::from_bits(job))),
                    Some(Err(error)) => Some(Err(error)),
                    None => None,
                };
                let capture = if other != 0 { Some(next()?) } else { None };
                let call = task.map(|task| Call::Release { task, at, capture });
                call.zip(answer.map(Answer::Released))
            }
            tag::TAKE_OUTCOME if code == 0 => Some((Call::TakeOutcome, Answer::Outcome(None))),
            tag::TAKE_OUTCOME => take_outcome(now, &mut next)?
                .map(|outcome| (Call::TakeOutcome, Answer::Outcome(Some(outcome)))),
            tag::EDIT => {
                let call = bits(next()?).map(Call::Edit);
                call.zip(result(code, &COMMIT).map(Answer::Edited))
            }
            tag::RETIRE => asked.map(|lane| (Call::Retire(lane), yes)),
            tag::RESTORE => asked.map(|lane| (Call::Restore(lane), yes)),
            tag::REMOVE => bits(next()?).map(|task| (Call::Remove(TaskId::from_bits(task)), yes)),
            tag::END => {
                let mut counters = Counters::default();
                counters.units = next()?;
                counters.encoder_runs_saved = next()?;
                counters.overruns = next()?;
                counters.clock_steps_back = next()?;
                counters.late_completions = next()?;
                counters.evictions = next()?;
                Some((Call::End, Answer::Counters(counters)))
            }
            _ => None,
        };
        Ok(pair.map(|(call, answer)| Entry { now, call, answer }))
    }

    fn is_last(&self, unit: UnitId) -> bool {
        self.lanes[unit.lane().index() % LANES] == unit
    }

    /// Units of the scheduler's own making are on one of its lanes.
    const fn is_next(&self, unit: UnitId) -> bool {
        unit.to_bits() >> 16 == self.sequence.wrapping_add(1)
    }

    /// The next unit, of this lane and node.
    const fn expected(&self, lane: u64, node: u64) -> UnitId {
        UnitId::from_bits(self.sequence.wrapping_add(1) << 16 | node << 8 | lane)
    }

    fn started(&mut self, unit: UnitId) {
        self.sequence = unit.to_bits() >> 16;
        self.lanes[unit.lane().index() % LANES] = unit;
    }
}

const fn place(lane: LaneId) -> u64 {
    lane.index() as u64 & NO_LANE
}

/// An id of 32 bits.
fn bits(word: u64) -> Option<u32> {
    u32::try_from(word).ok()
}

fn numbers(c: &Counters) -> [u64; 6] {
    [c.units, c.encoder_runs_saved, c.overruns, c.clock_steps_back, c.late_completions, c.evictions]
}

fn put_outcome(outcome: &Outcome, now: Instant, out: &mut Chunk) {
    out.more(outcome.job.to_bits().into());
    let shed = SHED.iter().position(|reason| outcome.shed == Some(*reason)).map_or(0, |at| at as u64 + 1);
    out.more(u64::from(outcome.task.to_bits()) << 4 | shed);
    out.more(outcome.index);
    out.more(back(now, outcome.release));
    out.more(back(outcome.release, outcome.deadline));
    out.more(back(now, outcome.at));
}

fn take_outcome<E>(now: Instant, mut next: impl FnMut() -> Result<u64, E>) -> Result<Option<Outcome>, E> {
    let (job, word, index) = (bits(next()?), next()?, next()?);
    let release = then(now, next()?);
    // The deadline counts from the release: the same distance for all jobs of a task.
    let deadline = then(release, next()?);
    let at = then(now, next()?);
    let shed = match (word & 15).checked_sub(1) {
        None => Some(None),
        Some(reason) => SHED.get(reason as usize).map(|reason| Some(*reason)),
    };
    let ids = job.zip(bits(word >> 4));
    Ok(ids.zip(shed).map(|((job, task), shed)| Outcome {
        job: JobId::from_bits(job),
        task: TaskId::from_bits(task),
        index,
        release,
        deadline,
        at,
        shed,
    }))
}

#[cfg(test)]
mod tests;
