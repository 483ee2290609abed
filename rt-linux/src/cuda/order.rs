//! Which events a stream has to wait for, and for which it need not because an earlier wait implies them.
//!
//! *Background.* A stream keeps its order, and what it was told to wait for, all that it is given later waits for too.
//! *Rule.* Each stream marks the end of each of its units, by turns. It knows of every other stream up to which turn it
//! follows it (a vector clock), and notes that with its own marks: who waits for a mark knows what the mark knew. A unit
//! waits for the mark of a predecessor only where its stream does not follow that turn already; among several, the
//! youngest is looked at first, because it may imply the others.
//! *Why nothing is missed.* A stream follows a turn only by its own order, by a wait, or by what it waited for followed.
//! *Paper reference.* On-demand synchronisation, section 3.4; vector clocks: Fidge 1988, Mattern 1989.
//!
//! # Marks by turns
//!
//! The mark of a turn is used again after [`MARKS`] others. A lane has three units under way at most, so what a mark said
//! before is long done then; who waits for it all the same waits for a later turn of a stream that waits for nobody
//! younger, which is too long and never for ever.

use core::sync::atomic::{AtomicU64, Ordering};
use red_core::UnitId;

/// Lanes of a run, at most.
pub const LANES: usize = 32;
/// Marks of a stream.
pub const MARKS: usize = 16;

/// Turns by stream.
type Turns = [u64; LANES];

/// The marks of all streams of a device; `E` is its event.
#[derive(Debug)]
pub struct Order<E> {
    streams: Vec<Option<Stream<E>>>,
}

#[derive(Debug)]
struct Stream<E> {
    /// The unit that was marked last.
    newest: AtomicU64,
    marks: Vec<Mark<E>>,
}

#[derive(Debug)]
struct Mark<E> {
    event: E,
    /// Whose end it is; 0 while it changes.
    unit: AtomicU64,
    turn: AtomicU64,
    follows: [AtomicU64; LANES],
}

/// What one stream knows of the others; its lane's alone.
#[derive(Clone, Debug)]
pub struct Own {
    lane: usize,
    follows: Turns,
}

/// Waits for the marks of one unit's predecessors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waits {
    /// Marks that are waited for, by stream: their turns, 0 for none.
    pub turns: Turns,
    /// How many were.
    pub issued: u64,
    /// How many were implied.
    pub avoided: u64,
}

impl Own {
    /// Of the stream of this lane, which follows nobody yet.
    #[must_use]
    pub const fn of(lane: usize) -> Self {
        Self { lane, follows: [0; LANES] }
    }
}

impl<E> Order<E> {
    /// For the streams of these lanes, a bit each.
    ///
    /// # Errors
    /// Those of `event`.
    pub fn new<X>(lanes: u32, mut event: impl FnMut() -> Result<E, X>) -> Result<Self, X> {
        let mut mark = || {
            let follows = [const { AtomicU64::new(0) }; LANES];
            Ok(Mark { event: event()?, unit: AtomicU64::new(0), turn: AtomicU64::new(0), follows })
        };
        let mut stream = |lane: usize| {
            let is_meant = lanes >> lane & 1 != 0;
            let mut marks = || (0..MARKS).map(|_| mark()).collect::<Result<_, X>>();
            is_meant.then(|| Ok(Stream { newest: AtomicU64::new(0), marks: marks()? })).transpose()
        };
        Ok(Self { streams: (0..LANES).map(&mut stream).collect::<Result<_, X>>()? })
    }

    /// Has the stream `own` wait for the marks of `after`, by `wait`, so far as it does not follow them. `None`, and
    /// nothing was done: one of them is not marked yet.
    ///
    /// # Errors
    /// Those of `wait`.
    pub fn wait_for<X>(
        &self,
        own: &mut Own,
        after: &[UnitId],
        mut wait: impl FnMut(&E) -> Result<(), X>,
    ) -> Result<Option<Waits>, X> {
        // Units are numbered upwards, and so are those of each lane.
        // Acquire: partner of the Release in `mark`.
        let is_marked = |unit: &UnitId| {
            self.stream(*unit).is_some_and(|s| s.newest.load(Ordering::Acquire) >= unit.to_bits())
        };
        if !after.iter().all(is_marked) {
            return Ok(None);
        }
        let (mut waits, mut last) = (Waits::default(), u64::MAX);
        // The youngest first.
        while let Some(unit) = after.iter().filter(|unit| unit.to_bits() < last).max() {
            last = unit.to_bits();
            let lane = unit.lane().index() % LANES;
            let Some((mark, turn, known)) = self.read(*unit) else {
                // Its mark is another turn's by now.
                waits.avoided += 1;
                continue;
            };
            if own.follows[lane] >= turn {
                waits.avoided += 1;
                continue;
            }
            wait(&mark.event)?;
            waits.issued += 1;
            waits.turns[lane] = turn;
            own.follows.iter_mut().zip(known).for_each(|(own, known)| *own = (*own).max(known));
            own.follows[lane] = own.follows[lane].max(turn);
        }
        Ok(Some(waits))
    }

    /// Marks the end of a unit in the stream `own`, by `record`. Its turn.
    ///
    /// # Errors
    /// Those of `record`; the unit counts as marked all the same, for nobody may wait for ever for that.
    pub fn mark<X>(
        &self,
        own: &mut Own,
        unit: UnitId,
        record: impl FnOnce(&E) -> Result<(), X>,
    ) -> Result<u64, X> {
        own.follows[own.lane] += 1;
        let turn = own.follows[own.lane];
        let Some(stream) = self.streams[own.lane].as_ref() else { return Ok(turn) };
        let mark = &stream.marks[turn as usize % MARKS];
        // Relaxed: who reads anything of what follows acquires it, and so sees this, too.
        mark.unit.store(0, Ordering::Relaxed);
        let recorded = record(&mark.event);
        mark.turn.store(turn, Ordering::Release);
        for (place, known) in mark.follows.iter().zip(own.follows) {
            place.store(known, Ordering::Release);
        }
        // Release: partners of the Acquire in `read` and in `wait_for`.
        mark.unit.store(unit.to_bits(), Ordering::Release);
        stream.newest.store(unit.to_bits(), Ordering::Release);
        recorded.map(|()| turn)
    }

    /// The event of a turn of a lane's stream; `None` where its mark is a later turn's.
    pub fn event(&self, lane: usize, turn: u64) -> Option<&E> {
        let mark = &self.streams[lane % LANES].as_ref()?.marks[turn as usize % MARKS];
        // Acquire: partner of the Release in `mark`; its own lane needs none.
        (mark.turn.load(Ordering::Acquire) == turn).then_some(&mark.event)
    }

    /// The mark of a unit, its turn, and what its stream followed then.
    fn read(&self, unit: UnitId) -> Option<(&Mark<E>, u64, Turns)> {
        // Acquire: partner of the Release in `mark`.
        let is_it = |mark: &&Mark<E>| mark.unit.load(Ordering::Acquire) == unit.to_bits();
        let mark = self.stream(unit)?.marks.iter().find(is_it)?;
        let turn = mark.turn.load(Ordering::Acquire);
        let mut known = [0; LANES];
        for (known, place) in known.iter_mut().zip(&mark.follows) {
            // Acquire, as above: partner of the Release in `mark`, so that the look below sees a change of what was read.
            *known = place.load(Ordering::Acquire);
        }
        is_it(&mark).then_some((mark, turn, known))
    }

    fn stream(&self, unit: UnitId) -> Option<&Stream<E>> {
        self.streams.get(unit.lane().index())?.as_ref()
    }
}

#[cfg(test)]
mod tests;
