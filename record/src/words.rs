//! Entries as words: what is expected costs one word, and a lane's usual turn one for all its calls (`turn.rs`).
//!
//! ```text
//! bits  0..4 call | 4..8 code of the answer | 8..14 lane | 14..20 other lane, or place of a job | 20..28 node
//!       28..64 time since before
//! ```
//!
//! A unit is expected when it is the next one of the scheduler (dispatched), or the last one of its lane (reported);
//! both sides keep the same books. Whatever is not expected follows in words of its own, and so does all of a set-up call
//! (`set_up.rs`).

mod codes;
mod figures;
mod polls;
mod set_up;
mod turn;

use crate::entry::{Answer, Call, Entry, back, then};
use crate::tape::Chunk;
use codes::{COMMIT, RELEASE, REPORT, code, result, tag};
use figures::{bits, numbers, put_outcome, take_end, take_outcome};
use red_core::{Duration, Instant, JobId, LaneId, TaskId, UnitId};
pub(crate) use set_up::Told;

/// Words that are written for one entry at most: what was held back, its time, its head and the end of the run.
pub(crate) const LONGEST: usize = 13;
/// Lanes of a scheduler at most.
const LANES: usize = 32;
/// Longest step of time that fits a head.
const STEP: u64 = 1 << 36;
/// In the place of a lane: none.
const NO_LANE: u64 = 63;
/// Jobs of a scheduler at most.
const JOBS: usize = 64;

/// What both sides know of the entries so far.
#[derive(Clone, Debug)]
pub(crate) struct Books {
    now: Instant,
    sequence: u64,
    lanes: [UnitId; LANES],
    /// The job that was released last in each place: units are of no other.
    jobs: [JobId; JOBS],
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
        Self { lane: place(lane), ..self }
    }

    /// Its word, so long after the entry before.
    const fn word(self, step: u64) -> u64 {
        self.tag | self.code << 4 | self.lane << 8 | self.other << 14 | self.node << 20 | step << 28
    }
}

impl Books {
    pub(crate) const fn new() -> Self {
        Self {
            now: Instant::ZERO,
            sequence: 0,
            lanes: [UnitId::from_bits(0); LANES],
            jobs: [JobId::from_bits(0); JOBS],
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
        let mut head = |h: Head| out.head(h.word(step), 1);
        match (&entry.call, &entry.answer) {
            (&Call::Complete(unit), &Answer::Reported(answer)) => {
                let h = Head::new(tag::COMPLETE, code(answer, &REPORT));
                if self.is_last(unit) {
                    head(h.on(unit.lane()));
                } else {
                    head(h);
                    out.more(unit.to_bits());
                }
            }
            (&Call::Fail(unit), &Answer::Reported(answer)) => {
                head(Head::new(tag::FAIL, code(answer, &REPORT)));
                out.more(unit.to_bits());
            }
            (&Call::Poll(lane), answer) => self.encode_poll((entry.now, step), lane, answer, out),
            (&Call::Release { task, at, capture }, &Answer::Released(answer)) => {
                let h = Head::new(tag::RELEASE, code(answer, &RELEASE));
                head(Head { other: u64::from(capture.is_some()), ..h });
                out.more(task.to_bits().into());
                out.more(back(entry.now, at));
                if let Ok(job) = answer {
                    out.more(job.to_bits().into());
                    self.released(job);
                }
                if let Some(capture) = capture {
                    out.more(capture);
                }
            }
            (Call::TakeOutcome, Answer::Nothing) => head(Head::new(tag::TAKE_OUTCOME, 0)),
            (Call::TakeOutcome, Answer::Ended(outcome)) => {
                head(Head::new(tag::TAKE_OUTCOME, 1));
                put_outcome(outcome, entry.now, out);
            }
            (&Call::Edit(number), &Answer::Edited(answer)) => {
                head(Head::new(tag::EDIT, code(answer, &COMMIT)));
                out.more(number.into());
            }
            (&Call::Retire(lane), &Answer::Done(yes)) => head(Head::new(tag::RETIRE, yes.into()).on(lane)),
            (&Call::Restore(lane), &Answer::Done(yes)) => head(Head::new(tag::RESTORE, yes.into()).on(lane)),
            (&Call::Remove(task), &Answer::Done(yes)) => {
                head(Head::new(tag::REMOVE, yes.into()));
                out.more(task.to_bits().into());
            }
            (&Call::StoodStill(time), Answer::Nothing) => {
                head(Head::new(tag::STOOD_STILL, 0));
                out.more(time.as_nanos());
            }
            (Call::End, Answer::End(end)) => {
                head(Head::new(tag::END, 0));
                numbers(end).into_iter().for_each(|number| out.more(number));
            }
            // No call has another's answer: `Recorder` makes the pairs.
            _ => set_up::put(&entry.call, &entry.answer, step, out),
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
            tag::TURN => asked.and_then(|lane| self.read_turn(code, lane, node, other)),
            tag::FAIL => {
                let call = Call::Fail(UnitId::from_bits(next()?));
                result(code, &REPORT).map(|answer| (call, Answer::Reported(answer)))
            }
            tag::POLL => self.decode_poll(asked, Head { tag: tag::POLL, code, lane, other, node }, next)?,
            tag::RELEASE => {
                let task = bits(next()?).map(TaskId::from_bits);
                let at = then(now, next()?);
                let answer = match result(code, &RELEASE) {
                    Some(Ok(())) => bits(next()?).map(|job| Ok(self.released(JobId::from_bits(job)))),
                    Some(Err(error)) => Some(Err(error)),
                    None => None,
                };
                let capture = if other != 0 { Some(next()?) } else { None };
                let call = task.map(|task| Call::Release { task, at, capture });
                call.zip(answer.map(Answer::Released))
            }
            tag::TAKE_OUTCOME if code == 0 => Some((Call::TakeOutcome, Answer::Nothing)),
            tag::TAKE_OUTCOME => {
                take_outcome(now, next)?.map(|outcome| (Call::TakeOutcome, Answer::Ended(outcome)))
            }
            tag::EDIT => {
                let call = bits(next()?).map(Call::Edit);
                call.zip(result(code, &COMMIT).map(Answer::Edited))
            }
            tag::RETIRE => asked.map(|lane| (Call::Retire(lane), yes)),
            tag::RESTORE => asked.map(|lane| (Call::Restore(lane), yes)),
            tag::REMOVE => bits(next()?).map(|task| (Call::Remove(TaskId::from_bits(task)), yes)),
            tag::STOOD_STILL => Some((Call::StoodStill(Duration::from_nanos(next()?)), Answer::Nothing)),
            tag::SET_UP => set_up::take(word & 0xFFF_FFFF, next)?,
            tag::END => Some((Call::End, Answer::End(take_end(next)?))),
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

    fn started(&mut self, unit: UnitId) {
        self.sequence = unit.to_bits() >> 16;
        self.lanes[unit.lane().index() % LANES] = unit;
    }

    const fn released(&mut self, job: JobId) -> JobId {
        self.jobs[job.index() % JOBS] = job;
        job
    }
}

/// No scheduler has a lane of 62, so all that a host makes up from there on are alike to it.
const fn place(lane: LaneId) -> u64 {
    let index = lane.index() as u64;
    if index < NO_LANE { index } else { NO_LANE - 1 }
}

#[cfg(test)]
mod tests;
