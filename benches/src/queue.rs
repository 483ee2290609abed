//! Ready queues: pop and push (the hold model) and re-keying, from 8 to 1,024 entries.

use std::hint::black_box;

use orx_priority_queue::{DaryHeapOfIndices, PriorityQueue, PriorityQueueDecKey};
use red_core::Table;

use crate::graphs::splitmix64;
use crate::measure::{Entry, Runner, timed};

/// Numbers of entries that are measured.
pub(crate) const SIZES: [usize; 4] = [8, 64, 256, 1024];

/// An indexed priority queue of the entries 0 to `capacity` - 1, smallest key first.
pub(crate) trait ReadyQueue: 'static {
    /// An empty queue.
    fn with_capacity(capacity: usize) -> Self;
    /// Adds an entry that is not in the queue.
    fn push(&mut self, entry: usize, key: u64);
    /// Takes the entry with the smallest key out.
    fn pop(&mut self) -> Option<(usize, u64)>;
    /// Gives an entry of the queue another key.
    fn rekey(&mut self, entry: usize, key: u64);
}

/// A row of the queue tables.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    pub(crate) ours: bool,
    /// The two operations on a queue that holds so many entries.
    pub(crate) hold: fn(usize) -> Runner,
    pub(crate) rekey: fn(usize) -> Runner,
}

impl Contestant {
    const fn peer<Q: ReadyQueue>(name: &'static str) -> Self {
        Self { name, ours: false, hold: hold::<Q>, rekey: rekey::<Q> }
    }

    /// This contestant at the start line of one of its operations.
    pub(crate) fn enter(&self, runner: Runner) -> Entry {
        Entry { name: self.name.to_owned(), ours: self.ours, runner: Ok(runner) }
    }
}

/// The reference: orx's heap under keys of one word, its faster form.
pub(crate) const ORX: &str = "orx 4-ary, u64";

/// Queues that are measured.
pub(crate) const CONTESTANTS: &[Contestant] = &[
    Contestant::peer::<Orx<u64>>(ORX),
    Contestant::peer::<Orx<u128>>("orx 4-ary, u128"),
    Contestant { name: "RED", ours: true, hold: hold_ours, rekey: rekey_ours },
];

/// The core's heap, whose capacity is in its type.
type Ours<const N: usize> = red_core::ReadyQueue<u64, Table<u64, N>, Table<u16, N>>;

impl<const N: usize> ReadyQueue for Ours<N> {
    fn with_capacity(capacity: usize) -> Self {
        assert!(capacity <= N, "the queue holds {N} entries");
        Self::new()
    }
    fn push(&mut self, entry: usize, key: u64) {
        Self::push(self, entry, key);
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        Self::pop(self)
    }
    fn rekey(&mut self, entry: usize, key: u64) {
        Self::rekey(self, entry, key);
    }
}

fn hold_ours(entries: usize) -> Runner {
    match entries {
        ..=8 => hold::<Ours<8>>(entries),
        9..=64 => hold::<Ours<64>>(entries),
        65..=256 => hold::<Ours<256>>(entries),
        _ => hold::<Ours<1024>>(entries),
    }
}

fn rekey_ours(entries: usize) -> Runner {
    match entries {
        ..=8 => rekey::<Ours<8>>(entries),
        9..=64 => rekey::<Ours<64>>(entries),
        65..=256 => rekey::<Ours<256>>(entries),
        _ => rekey::<Ours<1024>>(entries),
    }
}

/// orx's indexed 4-ary heap. `u128` keys carry the entry in their lower half and so break ties.
struct Orx<K: PartialOrd + Clone>(DaryHeapOfIndices<usize, K, 4>);

impl ReadyQueue for Orx<u64> {
    fn with_capacity(capacity: usize) -> Self {
        Self(DaryHeapOfIndices::with_index_bound(capacity))
    }
    fn push(&mut self, entry: usize, key: u64) {
        self.0.push(entry, key);
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        self.0.pop()
    }
    fn rekey(&mut self, entry: usize, key: u64) {
        self.0.update_key(&entry, key);
    }
}

impl ReadyQueue for Orx<u128> {
    fn with_capacity(capacity: usize) -> Self {
        Self(DaryHeapOfIndices::with_index_bound(capacity))
    }
    fn push(&mut self, entry: usize, key: u64) {
        self.0.push(entry, with_tie(entry, key));
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        self.0.pop().map(|(entry, key)| (entry, (key >> 64) as u64))
    }
    fn rekey(&mut self, entry: usize, key: u64) {
        self.0.update_key(&entry, with_tie(entry, key));
    }
}

fn with_tie(entry: usize, key: u64) -> u128 {
    u128::from(key) << 64 | entry as u128
}

/// Increments of keys, drawn beforehand so that the generator is not measured.
fn increments() -> Vec<u64> {
    let mut state = 7;
    (0..4096).map(|_| splitmix64(&mut state) % 1_000_000).collect()
}

fn filled<Q: ReadyQueue>(entries: usize, keys: &[u64]) -> Q {
    let mut queue = Q::with_capacity(entries);
    (0..entries).for_each(|entry| queue.push(entry, keys[entry % keys.len()]));
    queue
}

/// Pops the smallest entry and pushes it back with a later key.
fn hold<Q: ReadyQueue>(entries: usize) -> Runner {
    let increments = increments();
    let mut queue: Q = filled(entries, &increments);
    let mut turn = 0;
    timed(move |operations| {
        for _ in 0..operations {
            if let Some((entry, key)) = queue.pop() {
                queue.push(entry, key + increments[turn % increments.len()]);
            }
            turn += 1;
        }
        black_box(&mut queue);
    })
}

/// Gives one entry after the other, in an order that is random to the queue, a random key.
fn rekey<Q: ReadyQueue>(entries: usize) -> Runner {
    let keys = increments();
    let mut queue: Q = filled(entries, &keys);
    let mut turn = 0;
    timed(move |operations| {
        for _ in 0..operations {
            let drawn = keys[turn % keys.len()];
            // An odd offset, so that one pass over the draws does not pair an entry with the draw that chose it.
            queue.rekey(drawn as usize % entries, keys[(turn + 1367) % keys.len()]);
            turn += 1;
        }
        black_box(&mut queue);
    })
}

#[cfg(test)]
mod tests;
