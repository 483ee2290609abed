//! The EDF ready queue: a 4-ary heap with a position index.
//!
//! *Background.* EDF needs the smallest key; re-assignment and edits need to re-key and to remove an entry that
//! is already queued, by name. *Rule.* Entries are (key, slot); `places` knows where each slot's entry is.
//! *Why it holds.* Sifting keeps every parent at or below its children and writes `places` with every move.
//! Ties are the key's business. Time bound: push, pop, re-key, remove O(log4 N); peek O(1).

use crate::capacity::{Empty, Item, Store};
use core::hint::select_unpredictable;

/// An indexed priority queue of at most one entry per slot. Slots are small integers.
///
/// ```
/// let mut queue = red_core::ReadyQueue::<u64, red_core::Table<_, 8>, red_core::Table<_, 8>>::new();
/// queue.push(3, 30);
/// queue.push(5, 10);
/// queue.rekey(3, 5);
/// assert_eq!(queue.pop(), Some((3, 5)));
/// assert_eq!(queue.remove(5), Some(10));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ReadyQueue<K: Item + Ord, T: Store<K>, S: Store<u16>> {
    /// By place; the slots apart, so that the keys of four children are one load each from a dense row.
    keys: T,
    slots: S,
    /// By slot: its place plus one; 0 is "not queued".
    places: S,
    len: u16,
    key: core::marker::PhantomData<K>,
}

/// Children per node. Four keep a small heap two deep and their keys on neighbouring cache lines.
const ARITY: usize = 4;

impl<K: Item + Ord, T: Store<K>, S: Store<u16>> ReadyQueue<K, T, S> {
    /// An empty queue.
    #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
    pub const fn new() -> Self {
        Self { keys: T::EMPTY, slots: S::EMPTY, places: S::EMPTY, len: 0, key: core::marker::PhantomData }
    }

    /// Whether nothing is queued.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many are queued.
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether the slot is queued.
    pub fn contains(&self, slot: usize) -> bool {
        self.places[slot] != 0
    }

    /// The smallest key and its slot.
    pub fn peek(&self) -> Option<(usize, K)> {
        (self.len > 0).then(|| (usize::from(self.slots[0]), self.keys[0]))
    }

    /// Queues a slot; one that is queued already is re-keyed.
    #[inline]
    pub fn push(&mut self, slot: usize, key: K) {
        if !self.rekey(slot, key) {
            let end = self.len();
            self.len += 1;
            self.rise(end, key, slot as u16);
        }
    }

    /// Takes the smallest key's slot.
    #[inline]
    pub fn pop(&mut self) -> Option<(usize, K)> {
        let (slot, _) = self.peek()?;
        Some((slot, self.take(0, slot)))
    }

    /// Gives a queued slot another key; `false` if it is not queued.
    #[inline]
    pub fn rekey(&mut self, slot: usize, key: K) -> bool {
        let place = self.places[slot];
        if place == 0 {
            return false;
        }
        self.settle(usize::from(place - 1), key, slot as u16);
        true
    }

    /// Takes a slot out, wherever it is.
    #[inline(always)]
    pub fn remove(&mut self, slot: usize) -> Option<K> {
        let place = self.places[slot].checked_sub(1)?;
        Some(self.remove_at(usize::from(place), slot))
    }

    #[inline(never)]
    fn remove_at(&mut self, place: usize, slot: usize) -> K {
        self.take(place, slot)
    }

    /// Takes the entry of `slot` from its place, and fills the hole with the last entry.
    #[inline(always)]
    fn take(&mut self, place: usize, slot: usize) -> K {
        let key = self.keys[place];
        self.len -= 1;
        let end = self.len();
        if place < end {
            self.settle(place, self.keys[end], self.slots[end]);
        }
        self.places[slot] = 0;
        key
    }

    /// Puts an entry into the hole at `place`, or where it belongs from there.
    #[inline(always)]
    fn settle(&mut self, place: usize, key: K, slot: u16) {
        if place > 0 && key < self.keys[parent(place)] {
            self.rise(place, key, slot);
        } else {
            self.sink(place, key, slot);
        }
    }

    fn put(&mut self, place: usize, key: K, slot: u16) {
        self.keys[place] = key;
        self.slots[place] = slot;
        self.places[usize::from(slot)] = place as u16 + 1;
    }

    #[inline(always)]
    fn rise(&mut self, mut hole: usize, key: K, slot: u16) {
        while hole > 0 && key < self.keys[parent(hole)] {
            let above = parent(hole);
            self.put(hole, self.keys[above], self.slots[above]);
            hole = above;
        }
        self.put(hole, key, slot);
    }

    #[inline(always)]
    fn sink(&mut self, mut hole: usize, key: K, slot: u16) {
        let len = self.len();
        loop {
            let first = hole * ARITY + 1;
            let (least, below) = match self.keys.as_ref().get(first..(first + ARITY).min(len)) {
                Some(&[a, b, c, d]) => {
                    let (ab, cd) = (usize::from(b < a), usize::from(d < c));
                    lesser((first + ab, b.min(a)), (first + 2 + cd, d.min(c)))
                }
                Some([a, rest @ ..]) => {
                    let others = (first + 1..).zip(rest);
                    others.fold((first, *a), |least, (place, k)| lesser(least, (place, *k)))
                }
                _ => break,
            };
            if key <= below {
                break;
            }
            self.put(hole, below, self.slots[least]);
            hole = least;
        }
        self.put(hole, key, slot);
    }
}

/// The place above; of the root itself.
const fn parent(place: usize) -> usize {
    place.saturating_sub(1) / ARITY
}

/// The one with the smaller key, the first of equals. Which one it is cannot be predicted, so no branch.
fn lesser<K: Copy + Ord>(one: (usize, K), other: (usize, K)) -> (usize, K) {
    let is_less = other.1 < one.1;
    (select_unpredictable(is_less, other.0, one.0), select_unpredictable(is_less, other.1, one.1))
}

impl<K: Item + Ord, T: Store<K>, S: Store<u16>> Empty for ReadyQueue<K, T, S> {
    const EMPTY: Self = Self::new();
}

#[cfg(test)]
mod tests;
