//! Polls as words. A unit that is the next one and alone needs a place for its job only, which is in the head where the
//! unit is for the lane that asked.

use super::codes::{UNKNOWN, action, tag};
use super::figures::{bits, put_outcome, take_outcome};
use super::{Books, Head, JOBS, place};
use crate::entry::{Answer, Call};
use crate::started::{Members, Started};
use crate::tape::Chunk;
use red_core::{Instant, JobId, LaneId, UnitId};

impl Books {
    /// Writes a poll at `now` for this lane, so long after the entry before.
    pub(super) fn encode_poll(
        &mut self,
        (now, step): (Instant, u64),
        asked: Option<LaneId>,
        answer: &Answer,
        out: &mut Chunk,
    ) {
        let head = |code| Head { lane: asked.map_or(super::NO_LANE, place), ..Head::new(tag::POLL, code) };
        match answer {
            Answer::Nothing => out.head(head(action::NOTHING).word(step), 1),
            Answer::Started(started) => {
                let (unit, job) = (started.unit, self.place_of(started));
                let node = unit.node().index() as u64;
                match job.filter(|_| self.is_next(unit)) {
                    Some(other) if asked == Some(unit.lane()) => {
                        out.head(Head { other, node, ..head(action::OWN) }.word(step), 1);
                    }
                    Some(job) => {
                        let other = place(unit.lane());
                        out.head(Head { other, node, ..head(action::HANDED) }.word(step), 1);
                        out.more(job);
                    }
                    None => {
                        out.head(head(action::SPELLED).word(step), 1);
                        let Members { jobs, nodes } =
                            started.members.unwrap_or(Members { jobs: 0, nodes: 0 });
                        let words = [unit.to_bits(), started.job.to_bits().into(), jobs, nodes];
                        words.into_iter().for_each(|word| out.more(word));
                    }
                }
                self.started(unit);
            }
            Answer::Ahead(Started { unit, job, .. }) => {
                out.head(head(action::AHEAD).word(step), 1);
                out.more(unit.to_bits());
                out.more(job.to_bits().into());
                self.started(*unit);
            }
            Answer::Preempted(unit) => {
                out.head(head(action::PREEMPTED).word(step), 1);
                out.more(unit.to_bits());
            }
            Answer::Ended(outcome) => {
                out.head(head(action::ENDED).word(step), 1);
                put_outcome(outcome, now, out);
            }
            _ => out.head(head(UNKNOWN).word(step), 1),
        }
    }

    /// Reads a poll whose head has these fields. `None`: no poll is like that.
    pub(super) fn decode_poll<E>(
        &mut self,
        asked: Option<LaneId>,
        head: Head,
        mut next: impl FnMut() -> Result<u64, E>,
    ) -> Result<Option<(Call, Answer)>, E> {
        let answer = match head.code {
            action::NOTHING => Some(Answer::Nothing),
            action::OWN => asked.and_then(|lane| self.start(place(lane), head.node, head.other)),
            action::HANDED => self.start(head.other, head.node, next()?),
            action::SPELLED => {
                let (unit, job) = (UnitId::from_bits(next()?), bits(next()?).map(JobId::from_bits));
                let all = Members { jobs: next()?, nodes: next()? };
                self.started(unit);
                let members = (all.jobs != 0).then_some(all);
                job.map(|job| Answer::Started(Started { unit, job, members }))
            }
            action::AHEAD => {
                let (unit, job) = (UnitId::from_bits(next()?), bits(next()?).map(JobId::from_bits));
                self.started(unit);
                job.map(|job| Answer::Ahead(Started { unit, job, members: None }))
            }
            action::PREEMPTED => Some(Answer::Preempted(UnitId::from_bits(next()?))),
            action::ENDED => take_outcome(self.now, next)?.map(Answer::Ended),
            _ => None,
        };
        Ok(answer.map(|answer| (Call::Poll(asked), answer)))
    }

    /// The next unit starts, alone and of the job in this place.
    pub(super) fn start(&mut self, lane: u64, node: u64, job: u64) -> Option<Answer> {
        let unit = UnitId::from_bits(self.sequence.wrapping_add(1) << 16 | node << 8 | lane);
        let job = *self.jobs.get(usize::try_from(job).ok()?)?;
        self.started(unit);
        Some(Answer::Started(Started { unit, job, members: None }))
    }

    /// The place of a unit's only job, where that is the one that was released last in it.
    #[inline(always)]
    pub(super) fn place_of(&self, started: &Started) -> Option<u64> {
        let place = started.job.index() % JOBS;
        (started.members.is_none() && self.jobs[place] == started.job).then_some(place as u64)
    }
}
