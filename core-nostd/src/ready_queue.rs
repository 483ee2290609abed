//! The EDF ready queue: a 4-ary heap with a position index.
//!
//! *Background.* EDF needs the smallest key; re-assignment and edits need to re-key and to remove an entry that
//! is already queued, by name. *Rule.* Entries are (key, slot); `position` knows where each slot's entry is.
//! *Why it holds.* Sifting keeps every parent at or below its children and writes `position` with every move.
//! Ties are the key's business: the scheduler's keys are total.
//! Time bound: push, pop, re-key, remove O(log4 N); peek O(1).

use crate::capacity::{Empty, Store};
use core::hint::select_unpredictable;

/// One queued slot.
#[derive(Clone, Copy, Debug)]
pub struct Entry<K> {
    key: K,
    slot: u16,
}

impl<K: Empty> Empty for Entry<K> {
    const EMPTY: Self = Self { key: K::EMPTY, slot: 0 };
}

/// An indexed priority queue of at most one entry per slot. Slots are small integers.
///
/// ```
/// use red_core::{Table, ReadyQueue};
/// let mut queue = ReadyQueue::<u64, Table<_, 8>, Table<_, 8>>::new();
/// queue.push(3, 30);
/// queue.push(5, 10);
/// queue.rekey(3, 5);
/// assert_eq!(queue.pop(), Some((3, 5)));
/// assert_eq!(queue.remove(5), Some(10));
/// assert!(queue.is_empty());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ReadyQueue<K, E: Store<Entry<K>>, P: Store<u16>>
where
    K: Copy + Ord + Empty + core::fmt::Debug,
{
    entries: E,
    /// Slot to place in `entries`, plus one; 0 is "not queued".
    position: P,
    len: u16,
    key: core::marker::PhantomData<K>,
}

/// Children per node. Four keep a small heap two deep and their keys on neighbouring cache lines.
const ARITY: usize = 4;

impl<K, E: Store<Entry<K>>, P: Store<u16>> ReadyQueue<K, E, P>
where
    K: Copy + Ord + Empty + core::fmt::Debug,
{
    /// An empty queue.
    #[must_use]
    pub const fn new() -> Self {
        Self { entries: E::EMPTY, position: P::EMPTY, len: 0, key: core::marker::PhantomData }
    }

    /// Whether nothing is queued.
    #[inline(always)]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many are queued.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether the slot is queued.
    #[must_use]
    pub fn contains(&self, slot: usize) -> bool {
        self.position[slot] != 0
    }

    /// The smallest key and its slot.
    #[inline(always)]
    #[must_use]
    pub fn peek(&self) -> Option<(usize, K)> {
        (self.len > 0).then(|| (usize::from(self.entries[0].slot), self.entries[0].key))
    }

    /// Queues a slot; one that is queued already is re-keyed.
    #[inline]
    pub fn push(&mut self, slot: usize, key: K) {
        if self.position[slot] != 0 {
            self.rekey(slot, key);
            return;
        }
        let end = self.len();
        self.len += 1;
        self.rise(end, key, slot as u16);
    }

    /// Takes the smallest key's slot.
    #[inline]
    pub fn pop(&mut self) -> Option<(usize, K)> {
        let (slot, key) = self.peek()?;
        self.take(0);
        self.position[slot] = 0;
        Some((slot, key))
    }

    /// Gives a queued slot another key; `false` if it is not queued.
    #[inline]
    pub fn rekey(&mut self, slot: usize, key: K) -> bool {
        let place = self.position[slot];
        if place == 0 {
            return false;
        }
        self.settle(usize::from(place - 1), key, slot as u16);
        true
    }

    /// Takes a slot out, wherever it is.
    #[inline(always)]
    pub fn remove(&mut self, slot: usize) -> Option<K> {
        let place = self.position[slot].checked_sub(1)?;
        Some(self.remove_at(usize::from(place), slot))
    }

    #[inline(never)]
    fn remove_at(&mut self, place: usize, slot: usize) -> K {
        let key = self.entries[place].key;
        self.take(place);
        self.position[slot] = 0;
        key
    }

    /// Fills the hole at `place` with the last entry.
    #[inline(always)]
    fn take(&mut self, place: usize) {
        self.len -= 1;
        let end = self.len();
        if place < end {
            let last = &self.entries[end];
            let (key, slot) = (last.key, last.slot);
            self.settle(place, key, slot);
        }
    }

    /// Puts an entry into the hole at `place`, or where it belongs from there.
    #[inline(always)]
    fn settle(&mut self, place: usize, key: K, slot: u16) {
        let parent = (place.max(1) - 1) / ARITY;
        if place > 0 && key < self.entries[parent].key {
            self.rise(place, key, slot);
        } else {
            self.sink(place, key, slot);
        }
    }

    /// Key and slot are stored one by one: an entry that is copied whole is loaded by one wide load, which waits
    /// for narrow stores before it.
    #[inline(always)]
    fn put(&mut self, place: usize, key: K, slot: u16) {
        let entry = &mut self.entries[place];
        entry.key = key;
        entry.slot = slot;
        self.position[usize::from(slot)] = place as u16 + 1;
    }

    #[inline(always)]
    fn rise(&mut self, mut hole: usize, key: K, slot: u16) {
        while hole > 0 {
            let parent = (hole - 1) / ARITY;
            let Entry { key: above, slot: its_slot } = self.entries[parent];
            if above <= key {
                break;
            }
            self.put(hole, above, its_slot);
            hole = parent;
        }
        self.put(hole, key, slot);
    }

    #[inline(always)]
    fn sink(&mut self, mut hole: usize, key: K, slot: u16) {
        let len = self.len();
        loop {
            let first = hole * ARITY + 1;
            let at = |place: usize, child: &Entry<K>| (first + place, child.key);
            let (least, below) = match self.entries.as_ref().get(first..(first + ARITY).min(len)) {
                Some([a, b, c, d]) => lesser(lesser(at(0, a), at(1, b)), lesser(at(2, c), at(3, d))),
                Some([a, rest @ ..]) => rest
                    .iter()
                    .enumerate()
                    .fold(at(0, a), |least, (i, child)| lesser(least, at(i + 1, child))),
                _ => break,
            };
            if key <= below {
                break;
            }
            let its_slot = self.entries[least].slot;
            self.put(hole, below, its_slot);
            hole = least;
        }
        self.put(hole, key, slot);
    }
}

/// The one with the smaller key, the first of equals. Which one it is cannot be predicted, so no branch.
#[inline(always)]
fn lesser<K: Copy + Ord>(one: (usize, K), other: (usize, K)) -> (usize, K) {
    let is_less = other.1 < one.1;
    (select_unpredictable(is_less, other.0, one.0), select_unpredictable(is_less, other.1, one.1))
}

impl<K, E: Store<Entry<K>>, P: Store<u16>> Default for ReadyQueue<K, E, P>
where
    K: Copy + Ord + Empty + core::fmt::Debug,
{
    fn default() -> Self {
        Self::new()
    }
}

impl<K, E: Store<Entry<K>>, P: Store<u16>> Empty for ReadyQueue<K, E, P>
where
    K: Copy + Ord + Empty + core::fmt::Debug,
{
    const EMPTY: Self = Self::new();
}

#[cfg(test)]
mod tests;
