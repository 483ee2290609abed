//! Every sequence of eight operations on the ready queue, from an empty queue and from one that is two levels deep,
//! against a list that is searched.

use red_core::{ReadyQueue, Table};

const SLOTS: usize = 16;
const LENGTH: u32 = 8;

type Ready = ReadyQueue<u64, Table<u64, SLOTS>, Table<u16, SLOTS>>;

/// What both sides can do.
trait Queue: Copy {
    fn push(&mut self, slot: usize, key: u64);
    fn pop(&mut self) -> Option<(usize, u64)>;
    fn rekey(&mut self, slot: usize, key: u64) -> bool;
    fn remove(&mut self, slot: usize) -> Option<u64>;
    fn contains(&self, slot: usize) -> bool;
    fn peek(&self) -> Option<(usize, u64)>;
    fn len(&self) -> usize;
}

impl Queue for Ready {
    fn push(&mut self, slot: usize, key: u64) {
        self.push(slot, key);
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        self.pop()
    }
    fn rekey(&mut self, slot: usize, key: u64) -> bool {
        self.rekey(slot, key)
    }
    fn remove(&mut self, slot: usize) -> Option<u64> {
        self.remove(slot)
    }
    fn contains(&self, slot: usize) -> bool {
        self.contains(slot)
    }
    fn peek(&self) -> Option<(usize, u64)> {
        self.peek()
    }
    fn len(&self) -> usize {
        self.len()
    }
}

/// The key of each slot that is queued.
#[derive(Clone, Copy)]
struct List([Option<u64>; SLOTS]);

impl Queue for List {
    fn push(&mut self, slot: usize, key: u64) {
        self.0[slot] = Some(key);
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        let first = self.peek()?;
        self.0[first.0] = None;
        Some(first)
    }
    fn rekey(&mut self, slot: usize, key: u64) -> bool {
        let there = self.contains(slot);
        self.0[slot] = there.then_some(key);
        there
    }
    fn remove(&mut self, slot: usize) -> Option<u64> {
        self.0[slot].take()
    }
    fn contains(&self, slot: usize) -> bool {
        self.0[slot].is_some()
    }
    fn peek(&self) -> Option<(usize, u64)> {
        let queued = (0..SLOTS).filter_map(|slot| Some((slot, self.0[slot]?)));
        queued.min_by_key(|(_, key)| *key)
    }
    fn len(&self) -> usize {
        self.0.iter().flatten().count()
    }
}

/// A queue with a bug: a key that grows stays where it is.
#[derive(Clone, Copy)]
struct NeverSinks(Ready);

impl Queue for NeverSinks {
    fn push(&mut self, slot: usize, key: u64) {
        self.0.push(slot, key);
    }
    fn pop(&mut self) -> Option<(usize, u64)> {
        self.0.pop()
    }
    fn rekey(&mut self, slot: usize, key: u64) -> bool {
        let there = self.0.remove(slot);
        there.map(|old| self.0.push(slot, old.min(key))).is_some()
    }
    fn remove(&mut self, slot: usize) -> Option<u64> {
        self.0.remove(slot)
    }
    fn contains(&self, slot: usize) -> bool {
        self.0.contains(slot)
    }
    fn peek(&self) -> Option<(usize, u64)> {
        self.0.peek()
    }
    fn len(&self) -> usize {
        self.0.len()
    }
}

/// Operations name slots by what is queued, so that few of them reach every shape of the heap.
#[derive(Clone, Copy, Debug)]
enum Operation {
    /// The lowest slot that is free, below, among or above the others.
    Push(u64),
    Pop,
    /// The lowest slot that is queued.
    RekeyFirst(u64),
    RemoveFirst,
    /// The highest.
    RemoveLast,
}

const ALPHABET: [Operation; 8] = [
    Operation::Push(0),
    Operation::Push(1),
    Operation::Push(2),
    Operation::Pop,
    Operation::RekeyFirst(0),
    Operation::RekeyFirst(2),
    Operation::RemoveFirst,
    Operation::RemoveLast,
];

/// Keys of a slot differ from those of all others, so that the order is total.
fn key(level: u64, slot: usize) -> u64 {
    level * 100 + slot as u64
}

/// The same operation on both; what they answered, by the first difference.
fn apply<Q: Queue>(operation: Operation, queue: &mut Q, list: &mut List) -> Result<(), String> {
    let first = (0..SLOTS).find(|slot| list.contains(*slot));
    let last = (0..SLOTS).rev().find(|slot| list.contains(*slot));
    let same = match (operation, first, last) {
        (Operation::Push(level), ..) => {
            let free = (0..SLOTS).find(|slot| !list.contains(*slot)).expect("more slots than pushes");
            queue.push(free, key(level, free));
            list.push(free, key(level, free));
            true
        }
        (Operation::Pop, ..) => queue.pop() == list.pop(),
        (Operation::RekeyFirst(level), slot, _) => {
            // Of an empty queue, a slot that is not there.
            let slot = slot.unwrap_or(0);
            queue.rekey(slot, key(level, slot)) == list.rekey(slot, key(level, slot))
        }
        (Operation::RemoveFirst, slot, _) | (Operation::RemoveLast, _, slot) => {
            let slot = slot.unwrap_or(0);
            queue.remove(slot) == list.remove(slot)
        }
    };
    let looks_same = queue.peek() == list.peek()
        && queue.len() == list.len()
        && (0..SLOTS).all(|slot| queue.contains(slot) == list.contains(slot));
    if same && looks_same {
        Ok(())
    } else {
        Err(format!("{operation:?}: {:?}, not {:?}", queue.peek(), list.peek()))
    }
}

/// Empties both.
fn drain<Q: Queue>(mut queue: Q, mut list: List) -> Result<(), String> {
    while let Some(expected) = list.pop() {
        let found = queue.pop();
        if found != Some(expected) {
            return Err(format!("emptied: {found:?}, not {expected:?}"));
        }
    }
    Ok(())
}

/// Goes through every sequence of `left` operations; how many ended, or the first that differs.
fn explore<Q: Queue>(left: u32, queue: Q, list: List) -> Result<u64, String> {
    if left == 0 {
        return drain(queue, list).map(|()| 1);
    }
    let mut sequences = 0;
    for operation in ALPHABET {
        let (mut queue, mut list) = (queue, list);
        let after = apply(operation, &mut queue, &mut list).and_then(|()| explore(left - 1, queue, list));
        sequences += after.map_err(|difference| format!("{operation:?}, {difference}"))?;
    }
    Ok(sequences)
}

/// From an empty queue, and from one of seven entries: a root, four children, and two below the first of these.
fn explore_all<Q: Queue>(empty: Q, length: u32) -> Result<u64, String> {
    let (mut queue, mut list) = (empty, List([None; SLOTS]));
    let from_empty = explore(length, queue, list)?;
    for slot in 0..7 {
        queue.push(slot, key(1, slot));
        list.push(slot, key(1, slot));
    }
    Ok(from_empty + explore(length, queue, list)?)
}

#[test]
fn the_ready_queue_is_a_sorted_list_in_every_sequence_of_eight_operations() {
    let sequences = explore_all(Ready::new(), LENGTH).unwrap_or_else(|difference| panic!("{difference}"));
    println!("{sequences} sequences of {LENGTH} operations");
    assert_eq!(sequences, 2 * (ALPHABET.len() as u64).pow(LENGTH));
}

#[test]
fn a_queue_that_never_sinks_is_found() {
    let found = explore_all(NeverSinks(Ready::new()), 4);
    assert!(found.as_ref().is_err_and(|difference| difference.contains("RekeyFirst(2)")), "{found:?}");
}
