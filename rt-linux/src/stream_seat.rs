//! Where a lane with a stream is handed units, also ahead, while it waits for what it has given.
//!
//! # Protocol
//!
//! The holder of the scheduler's lock hands; the lane takes. All of its units come this way, for by two ways one could
//! overtake another: a stream runs them in the order in which it is given them. Two units may lie here: a second is
//! handed only once the first counts as started, and a third once the first was reported, by the lane or by one that
//! ran after it, so after the lane took and submitted it. They lie in turns in two [`Seat`]s, each of which so is
//! handed to only when empty.
//!
//! A lane that waits for its stream sleeps on this bell, which the driver rings when the stream comes to the end of a
//! unit, and who hands wakes. One that has nothing in its stream sleeps on its seat's, which who hands has to ring.

use crate::bell::Bell;
use crate::handler::Work;
use crate::primitive::{AtomicU32, AtomicU64, Ordering};
use crate::seat::Seat;
use red_core::UnitId;

/// Lanes besides one's own, at most.
const OTHERS: usize = 31;

/// A unit that was handed ahead.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// The unit.
    pub work: Work,
    after: [UnitId; OTHERS],
    count: usize,
    /// The longest WCET of what it waits for.
    pub wait_ns: u64,
}

impl Ahead {
    /// A unit that waits for nothing.
    #[must_use]
    pub const fn at_once(work: Work) -> Self {
        Self { work, after: [UnitId::from_bits(0); OTHERS], count: 0, wait_ns: 0 }
    }

    /// A unit that waits for these of other lanes, which take at most so long.
    pub fn new(work: Work, after: impl Iterator<Item = (UnitId, u64)>) -> Self {
        let mut new = Self::at_once(work);
        for ((unit, wcet_ns), place) in after.zip(&mut new.after) {
            *place = unit;
            new.count += 1;
            new.wait_ns = new.wait_ns.max(wcet_ns);
        }
        new
    }

    /// Units of other lanes that it has to start after.
    #[must_use]
    pub fn after(&self) -> &[UnitId] {
        self.after.get(..self.count).unwrap_or_default()
    }
}

/// Places for two units.
#[derive(Debug, Default)]
pub struct StreamSeat {
    /// Wakes the lane while its stream has something.
    pub bell: Bell,
    /// How many were handed; how many the lane has taken, which alone says whose turn it is: the second unit may be seen
    /// before the first.
    handed: AtomicU32,
    taken: AtomicU32,
    places: [Place; 2],
}

#[derive(Debug, Default)]
struct Place {
    unit: Seat,
    after: [AtomicU64; OTHERS],
    count: AtomicU32,
    wait_ns: AtomicU64,
}

impl StreamSeat {
    /// Hands a unit. To be called under the scheduler's lock; the bell of the lane's own seat has to be rung after it.
    pub fn hand(&self, ahead: &Ahead) {
        // Relaxed, as all that follows: the seat publishes it.
        let turn = self.handed.fetch_add(1, Ordering::Relaxed);
        let place = &self.places[turn as usize % 2];
        for (unit, word) in ahead.after().iter().zip(&place.after) {
            word.store(unit.to_bits(), Ordering::Relaxed);
        }
        place.count.store(ahead.count as u32, Ordering::Relaxed);
        place.wait_ns.store(ahead.wait_ns, Ordering::Relaxed);
        place.unit.hand(&ahead.work);
        self.bell.wake();
    }

    /// The unit that was handed first and not taken, once.
    pub fn take(&self) -> Option<Ahead> {
        let place = self.next();
        let work = place.unit.take()?;
        self.taken.fetch_add(1, Ordering::Relaxed);
        let count = place.count.load(Ordering::Relaxed) as usize;
        let after = place.after.iter().map(|word| UnitId::from_bits(word.load(Ordering::Relaxed)));
        let wait_ns = place.wait_ns.load(Ordering::Relaxed);
        Some(Ahead::new(work, after.take(count).map(|unit| (unit, wait_ns))))
    }

    /// Whether there is a unit to take.
    #[must_use]
    pub fn is_handed(&self) -> bool {
        self.next().unit.waiting().is_some()
    }

    fn next(&self) -> &Place {
        // Relaxed: the lane's own.
        &self.places[self.taken.load(Ordering::Relaxed) as usize % 2]
    }

    /// Units that were handed last, for whoever has to fail them. To be called under the scheduler's lock.
    pub fn units(&self) -> [UnitId; 2] {
        [self.places[0].unit.running(), self.places[1].unit.running()]
    }

    /// Whatever was handed so far is not to be run any more. To be called under the scheduler's lock.
    pub fn discard(&self) {
        self.places.iter().for_each(|place| place.unit.discard());
        self.taken.store(self.handed.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}
