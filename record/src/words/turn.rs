//! A lane's usual turn in one word: it completes its unit, gets the next one for itself or none, and finds nothing more,
//! all at one time. Nearly every call is in such a turn, so this is what recording costs.
//!
//! The word is held back until the turn is over. Any other entry breaks it: then its calls are written one by one.

use super::codes::{action, tag};
use super::{Books, LANES, NO_LANE, STEP, place};
use crate::entry::{Answer, Call, Entry};
use crate::started::Started;
use crate::tape::Chunk;
use red_core::{Instant, LaneId, UnitId};

/// Code of a turn after which the lane has nothing.
const IDLE: u64 = 0;
/// Code of a turn after which it has its next unit.
const GOES_ON: u64 = 1;

impl Books {
    /// A lane completed its unit: holds that back as the beginning of a turn. Whether it could.
    #[inline(always)]
    pub(crate) fn begin_turn(&mut self, unit: UnitId, now: Instant) -> bool {
        let step = now.as_nanos().wrapping_sub(self.now.as_nanos());
        let begins = (self.turn == 0) & (step < STEP) & (self.lanes[unit.lane().index() % LANES] == unit);
        if begins {
            self.now = now;
            self.turn = tag::TURN | place(unit.lane()) << 8 | step << 28;
        }
        begins
    }

    /// It got its next unit: that is the middle of the turn. Whether it is.
    #[inline(always)]
    pub(crate) fn go_on_turn(&mut self, lane: LaneId, started: &Started, now: Instant) -> bool {
        let unit = started.unit;
        let Some(job) = self.place_of(started) else { return false };
        let goes_on = self.is_turn(IDLE, lane, now) & (unit.lane() == lane) & self.is_next(unit);
        if goes_on {
            self.turn |= GOES_ON << 4 | job << 14 | (unit.node().index() as u64) << 20;
            self.started(unit);
        }
        goes_on
    }

    /// It found nothing more: the turn is over and written. Whether there was one.
    #[inline(always)]
    pub(crate) fn end_turn(&mut self, lane: LaneId, now: Instant, out: &mut Chunk) -> bool {
        let code = self.turn >> 4 & 1;
        let ends = self.is_turn(code, lane, now);
        if ends {
            out.head(self.turn, 2 + code);
            self.turn = 0;
        }
        ends
    }

    /// Whether there is a turn, this far, of this lane, at this time.
    const fn is_turn(&self, code: u64, lane: LaneId, now: Instant) -> bool {
        let head = tag::TURN | code << 4 | place(lane) << 8;
        self.turn & (15 | 15 << 4 | NO_LANE << 8) == head && now.as_nanos() == self.now.as_nanos()
    }

    /// The turn went another way than most: what was held back of it is written as it is.
    pub(crate) fn break_turn(&mut self, out: &mut Chunk) {
        let (held, lane) = (core::mem::take(&mut self.turn), NO_LANE << 8);
        if held != 0 {
            out.head(tag::COMPLETE | held & lane | held >> 28 << 28, 1);
            if held >> 4 & 1 == GOES_ON {
                let started = held & (NO_LANE << 8 | 63 << 14 | 255 << 20);
                out.head(tag::POLL | action::OWN << 4 | started, 1);
            }
        }
    }

    /// The calls of a turn: the first is answered, the others wait in `rest`.
    pub(super) fn read_turn(
        &mut self,
        code: u64,
        lane: LaneId,
        node: u64,
        job: u64,
    ) -> Option<(Call, Answer)> {
        let (now, done) = (self.now, self.lanes[lane.index() % LANES]);
        let poll = |answer| Some(Entry { now, call: Call::Poll(Some(lane)), answer });
        self.rest = match code {
            IDLE => [poll(Answer::Nothing), None],
            GOES_ON => [poll(self.start(place(lane), node, job)?), poll(Answer::Nothing)],
            _ => return None,
        };
        Some((Call::Complete(done), Answer::Reported(Ok(()))))
    }
}
