//! What is open, the memory that it was opened in, and what must hold after every call.

use std::collections::BTreeSet;
use std::ops::Range;

use red_ffi::red_status;

use crate::bytes::Bytes;
use crate::desk::Desk;
use crate::ground::Ground;
use crate::header::{self, Statuses};
use crate::planted::{Bug, has};
use crate::sizes::{More, Sizes};
use crate::stream::Stream;
use crate::twin::{AnyDag, Twin};

/// What was never lent, and what was given back.
const NEVER_LENT: u8 = 0xA5;
pub(crate) const CLOSED: u8 = 0xDB;

/// What is looked at after each call, and how often the larger classes are.
const FEW: usize = 16;
const OFTEN: usize = 8;
/// Calls between two looks at what is large, while everything ends.
const RARELY: usize = 64;
/// Bytes of closed memory that are looked at after every call.
const SMALL: usize = 1 << 15;

/// Handles that the library's table has room for.
const MOST_OPEN: usize = 255;

/// What a handle is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scheduler,
    Runtime,
    Dag,
}

pub(crate) enum Thing {
    Scheduler(Box<dyn Twin>, Stream),
    Runtime(Box<dyn Twin>, Stream),
    /// With the handle of what it was begun on, if it is an edit.
    Dag(Box<dyn AnyDag>, u64),
}

impl Thing {
    pub(crate) const fn kind(&self) -> Kind {
        match self {
            Self::Scheduler(..) => Kind::Scheduler,
            Self::Runtime(..) => Kind::Runtime,
            Self::Dag(..) => Kind::Dag,
        }
    }
}

/// What is open.
pub(crate) struct Open {
    pub(crate) bits: u64,
    /// Which class.
    pub(crate) class: usize,
    /// Memory that was lent, and what of it the library may write.
    pub(crate) lent: Range<usize>,
    pub(crate) own: Range<usize>,
    pub(crate) thing: Thing,
    /// Whether the image of its memory is not as the memory is.
    pub(crate) is_stale: bool,
}

pub(crate) struct World<'a> {
    pub(crate) choices: Bytes<'a>,
    pub(crate) arena: &'a mut Ground,
    pub(crate) desk: Desk<'a>,
    pub(crate) open: Vec<Open>,
    /// Handles that were closed.
    pub(crate) graves: Vec<u64>,
    /// In an order that is the same in every process, as is then which code runs.
    seen: BTreeSet<u64>,
    pub(crate) now: u64,
    /// Nothing is made wrong.
    pub(crate) careful: bool,
    sizes: Sizes,
    name: &'static str,
    pub(crate) wrong: Statuses,
    /// Arguments that are made wrong, and the number of the next one.
    spoiled: [u8; 2],
    argument: u8,
    /// Where closed memory lies.
    closed: Option<Range<usize>>,
    /// Whether a log was begun, which has a thread of its own.
    pub(crate) is_logged: bool,
    /// How many calls there were.
    pub(crate) calls: usize,
    /// What is looked at after this call: the small, a few of many, the large now and then.
    watched: Vec<u64>,
}

impl<'a> World<'a> {
    pub(crate) fn new(choices: Bytes<'a>, arena: &'a mut Ground, desk: Desk<'a>, sizes: Sizes) -> Self {
        arena.reset(crate::graphs::arena(sizes), NEVER_LENT);
        Self {
            choices,
            arena,
            desk,
            open: Vec::new(),
            graves: Vec::new(),
            seen: BTreeSet::new(),
            now: 1_000_000,
            careful: false,
            sizes,
            name: "",
            wrong: Statuses::NONE,
            spoiled: [u8::MAX; 2],
            argument: 0,
            closed: None,
            is_logged: false,
            calls: 0,
            watched: Vec::new(),
        }
    }

    pub(crate) const fn classes(&self) -> usize {
        self.sizes.classes
    }

    pub(crate) fn has(&self, more: More) -> bool {
        self.sizes.more == more
    }

    /// Whether there are graphs of this class.
    pub(crate) fn has_graphs(&self, class: usize) -> bool {
        class < self.sizes.classes || class == 2 && self.has(More::Runtimes)
    }

    pub(crate) const fn arena_len(&self) -> usize {
        crate::graphs::arena(self.sizes)
    }

    /// Begins a call: which of its arguments will be wrong.
    pub(crate) fn begin(&mut self, name: &'static str) {
        self.name = name;
        self.wrong = Statuses::NONE;
        (self.spoiled, self.argument) = ([u8::MAX; 2], 0);
        self.desk.clear();
        self.calls += 1;
        self.watched.clear();
        let first = if self.open.len() > FEW { self.calls * FEW % self.open.len() } else { 0 };
        let often = self.calls.is_multiple_of(if self.careful { RARELY } else { OFTEN });
        for open in self.open.iter_mut().skip(first).take(FEW).filter(|open| open.class == 0 || often) {
            if std::mem::take(&mut open.is_stale) {
                self.arena.accept(open.own.clone());
            }
            self.watched.push(open.bits);
        }
        if self.careful {
            return;
        }
        match self.choices.byte() {
            0..200 => {}
            one @ 200..248 => self.spoiled[0] = one % 6,
            two => self.spoiled = [two % 6, self.choices.byte() % 6],
        }
    }

    /// Whether the next argument is to be made wrong.
    pub(crate) fn spoils(&mut self) -> bool {
        self.argument += 1;
        self.spoiled.contains(&(self.argument - 1))
    }

    pub(crate) const fn is_wrong(&mut self, status: red_status) {
        self.wrong.add(status);
    }

    /// Whether nothing is wrong, as far as the border is to see.
    pub(crate) const fn is_right(&self) -> bool {
        self.wrong.is_empty()
    }

    /// Time goes on to then, if it has not come that far.
    pub(crate) fn pass_until(&mut self, then: u64) {
        self.now = self.now.max(then);
    }

    /// A time: mostly a little later, sometimes before the last one, rarely far away.
    pub(crate) fn clock(&mut self) -> u64 {
        if self.careful {
            return self.now;
        }
        match self.choices.byte() {
            still @ 0..160 => self.now = self.now.saturating_add(u64::from(still % 16) * 40_000),
            back @ 160..200 => return self.now.saturating_sub(u64::from(back) * 1_000),
            on @ 200..246 => self.now = self.now.saturating_add(u64::from(on) * 100_000),
            246..250 => self.now = self.now.saturating_add(1 << (self.choices.byte() % 64)),
            250..252 => return 0,
            252 => self.now = i64::MAX.cast_unsigned() - u64::from(self.choices.byte() % 2),
            253 => self.now = u64::MAX,
            _ => {}
        }
        self.now
    }

    /// The place of what is open under a handle, or what the library has to say to it.
    fn verdict(&self, bits: u64, want: Kind) -> Result<usize, red_status> {
        match self.open.iter().position(|open| open.bits == bits) {
            Some(at) if self.open[at].thing.kind() == want => Ok(at),
            Some(_) => Err(red_status::OtherKind),
            None if bits == 0 || self.is_ours(bits) => Err(red_status::Closed),
            None => Err(red_status::Foreign),
        }
    }

    /// Whether a handle names this copy of the library.
    fn is_ours(&self, bits: u64) -> bool {
        let copy = |bits: u64| bits as u32 >> 8;
        self.seen.iter().next().is_some_and(|one| copy(*one) == copy(bits))
    }

    /// A handle as argument: where it lies, and what is open under it where it is right.
    pub(crate) fn handle<T>(&mut self, want: Kind) -> (*mut T, usize) {
        let spoils = self.spoils();
        let of_kind = |kind| move |open: &&Open| open.thing.kind() == kind;
        let count = self.open.iter().filter(of_kind(want)).count();
        let mut bits = match count {
            0 => self.graves.last().copied().unwrap_or(0),
            _ if self.careful => self.open.iter().rfind(of_kind(want)).map_or(0, |open| open.bits),
            _ => {
                let which = self.choices.below(count);
                self.open.iter().filter(of_kind(want)).nth(which).map_or(0, |open| open.bits)
            }
        };
        let mut pointer = None;
        if spoils {
            match self.choices.byte() % 12 {
                0 => pointer = Some(0),
                1 => pointer = Some(1),
                2 => bits = 0,
                3 => bits ^= 0xff_0000,
                4 => bits = self.open.iter().find(|open| !of_kind(want)(open)).map_or(0, |open| open.bits),
                5 => bits = self.choices.number(),
                6 => bits = bits.wrapping_add(1 << 32),
                7 => {
                    bits = bits & !0xff | u64::from(self.choices.byte());
                    // How often a place was opened is what other inputs left.
                    if self.open.iter().any(|open| open.bits == bits) {
                        bits ^= 1 << 63;
                    }
                }
                8 if self.closed.is_some() => {
                    bits = u64::from_ne_bytes([CLOSED; 8]);
                    pointer = Some(2);
                }
                _ => {
                    bits = self.graves.get(self.choices.below(self.graves.len().max(1))).copied().unwrap_or(0)
                }
            }
        }
        let found = self.verdict(bits, want);
        let given = match found {
            Err(red_status::Closed) if has(Bug::Generation) => {
                self.open.iter().find(|open| open.bits as u32 == bits as u32).map_or(bits, |open| open.bits)
            }
            _ => bits,
        };
        let at = self.desk.input(&given.to_ne_bytes());
        let (pointer, wrong) = match (pointer, &self.closed) {
            (Some(0), _) => (std::ptr::null_mut(), Some(red_status::NullPointer)),
            (Some(1), _) => {
                let odd = at + 1 + usize::from(self.choices.byte() % 7);
                (self.desk.pointer(odd), Some(red_status::Misaligned))
            }
            (Some(_), Some(closed)) => (self.arena.pointer(closed.start), found.err()),
            _ => (self.desk.pointer(at), found.err()),
        };
        wrong.into_iter().for_each(|status| self.is_wrong(status));
        (pointer, found.unwrap_or(0))
    }

    /// What a call that opens something has to answer, where its arguments are right.
    pub(crate) fn may_open(&self, lent: &Range<usize>) -> Result<(), red_status> {
        let overlaps = |open: &Open| open.lent.start < lent.end && lent.start < open.lent.end;
        if self.open.iter().any(overlaps) {
            return Err(red_status::Overlap);
        }
        if self.open.len() < MOST_OPEN { Ok(()) } else { Err(red_status::TooManyOpen) }
    }

    /// Something was opened; its handle is nobody else's.
    pub(crate) fn opened(&mut self, open: Open) {
        assert!(self.seen.insert(open.bits) && open.bits as u32 != 0, "a handle was given out twice");
        assert_eq!(open.bits as u32 >> 8, self.seen.iter().next().map_or(0, |one| *one as u32 >> 8));
        self.arena.accept(open.own.clone());
        let (before, behind) = (open.lent.start..open.own.start, open.own.end..open.lent.end);
        [before, behind].into_iter().for_each(|part| self.is_untouched(part));
        let is_used = |closed: &Range<usize>| closed.start < open.lent.end && open.lent.start < closed.end;
        self.closed = self.closed.take().filter(|closed| !is_used(closed));
        self.open.push(open);
    }

    /// Something was closed: its memory has another content from now on.
    pub(crate) fn closed(&mut self, at: usize) {
        let Open { bits, lent, own, .. } = self.open.swap_remove(at);
        self.graves.push(bits);
        self.is_untouched(own.end.min(lent.end)..lent.end);
        self.arena.fill(lent.clone(), CLOSED);
        self.closed = Some(lent).filter(|lent| !lent.is_empty()).or(self.closed.take());
    }

    /// Whether its memory is looked at after this call. A runtime has none.
    fn is_seen(&self, open: &Open) -> bool {
        self.watched.contains(&open.bits) && !open.own.is_empty()
    }

    /// What must hold after every call. `changed` is what a call may have changed, if it may.
    pub(crate) fn judge(
        &mut self,
        status: red_status,
        expected: Result<(), red_status>,
        changed: Option<usize>,
    ) {
        let (name, wrong) = (self.name, self.wrong);
        let status =
            if has(Bug::Status) && status == red_status::Stale { red_status::UnknownJob } else { status };
        assert!(header::allows(name, status), "the header does not list it: {name} answers {status:?}");
        if self.is_right() {
            let said = expected.err().unwrap_or(red_status::Ok);
            assert_eq!(status, said, "the core itself says something else to {name}");
        } else {
            assert!(wrong.has(status), "{name} answers {status:?}, wrong is {wrong:?}");
        }
        if status != red_status::Ok && has(Bug::Output) {
            self.desk.poke_last();
        }
        if let Some(at) = self.desk.difference() {
            panic!("{name}, {status:?}: not what its outputs are to be, at byte {at} of its arguments");
        }
        if let Some(closed) = self.closed.clone().filter(|_| has(Bug::Closed)) {
            self.arena.poke(closed.end - 1, &[0]);
        }
        if has(Bug::Refused)
            && !self.is_right()
            && let Some(open) = self.open.iter().find(|open| self.is_seen(open))
        {
            self.arena.poke(open.own.start, &[0x77]);
        }
        // Time is told even where a call of the loop is refused.
        let may_change = self.is_right() && (status == red_status::Ok || LISTENS.contains(&name));
        let changed = changed.filter(|_| may_change);
        for (at, open) in self.open.iter().enumerate().filter(|(_, open)| self.is_seen(open)) {
            if changed != Some(at)
                && let Some(at) = self.arena.difference_in(open.own.clone())
            {
                let at = at - open.own.start;
                panic!(
                    "{name}, {status:?}: wrote to something open that it may not change, at its byte {at}"
                );
            }
        }
        changed.into_iter().for_each(|at| self.open[at].is_stale = true);
        // What was written there stays to be seen.
        let is_due = |closed: &&Range<usize>| closed.len() <= SMALL || self.calls.is_multiple_of(OFTEN);
        if let Some(closed) = self.closed.as_ref().filter(is_due) {
            self.is_untouched(closed.clone());
        }
    }

    /// Memory that is not lent is as it was.
    pub(crate) fn is_untouched(&self, range: Range<usize>) {
        if let Some(at) = self.arena.difference_in(range) {
            panic!("{}: wrote to memory that is not lent, at byte {at}", self.name);
        }
    }

    /// All memory but what calls were there to change.
    pub(crate) fn nothing_else_was_written(&mut self) {
        for open in &mut self.open {
            if std::mem::take(&mut open.is_stale) {
                self.arena.accept(open.own.clone());
            }
        }
        self.is_untouched(0..self.arena_len());
    }

    /// What is asked of the twin only where the border lets the call through.
    pub(crate) fn expected<T>(
        &mut self,
        ask: impl FnOnce(&mut Self) -> Result<T, red_status>,
    ) -> Result<T, red_status> {
        if self.is_right() { ask(self) } else { Err(red_status::Ok) }
    }
}

/// Functions that hear `now_ns` even if they refuse.
const LISTENS: &[&str] = &[
    "red_scheduler_release",
    "red_scheduler_release_at",
    "red_scheduler_complete",
    "red_scheduler_complete_and_poll",
    "red_scheduler_fail",
];
