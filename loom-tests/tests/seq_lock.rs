//! *Claim.* Who reads a sequence lock while it is written has the words of one write, or nothing; who reads it after a
//! write has that one's.
//!
//! *Threads.* A writer and a reader; then two writers that take turns, and a reader.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `sync/src/seq_lock.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use loom::thread;
use red_loom_tests::atomics::{AtomicPtr, AtomicU32};
use red_loom_tests::model::explore;
use red_loom_tests::seq_lock::SeqLock;
use std::ptr::{null_mut, without_provenance_mut as word};
use std::sync::Arc;

/// What the claims are about.
trait Pair: Send + Sync + 'static {
    fn new() -> Self;
    fn write(&self, words: [*mut (); 2]);
    fn read(&self) -> Option<[*mut (); 2]>;
}

impl Pair for SeqLock<2> {
    fn new() -> Self {
        Self::new()
    }

    fn write(&self, words: [*mut (); 2]) {
        self.write(words);
    }

    fn read(&self) -> Option<[*mut (); 2]> {
        self.read()
    }
}

/// Each write has one number in both words.
fn seen<P: Pair>(pair: &P) -> Option<usize> {
    pair.read().map(|[first, second]| {
        assert_eq!(first, second, "torn");
        first.addr()
    })
}

/// A write after another one, while somebody reads twice.
fn is_read_whole<P: Pair>() {
    let pair = Arc::new(P::new());
    pair.write([word(1); 2]);
    let writer = {
        let pair = pair.clone();
        thread::spawn(move || pair.write([word(2); 2]))
    };
    let found = [seen(&*pair), seen(&*pair)];
    assert!(found.iter().flatten().is_sorted(), "back to an older write: {found:?}");
    writer.join().unwrap();
    assert_eq!(seen(&*pair), Some(2), "nothing, though nobody writes");
}

#[test]
fn words_are_of_one_write() {
    explore(2, is_read_whole::<SeqLock<2>>);
}

#[test]
fn writers_that_take_turns_are_one() {
    explore(3, || {
        let (pair, turn) = (Arc::new(SeqLock::<2>::new()), Arc::new(Mutex::new(())));
        let writers = [1, 2].map(|number| {
            let (pair, turn) = (pair.clone(), turn.clone());
            thread::spawn(move || {
                let _mine = turn.lock().unwrap();
                pair.write([word(number); 2]);
            })
        });
        let found = seen(&*pair);
        assert!(found.is_none_or(|number| number <= 2));
        for writer in writers {
            writer.join().unwrap();
        }
        assert!(matches!(seen(&*pair), Some(1 | 2)), "nothing, though nobody writes");
    });
}

/// A lock that is even throughout: a reader in the midst of a write sees nothing of it.
struct Even {
    version: AtomicU32,
    words: [AtomicPtr<()>; 2],
}

impl Pair for Even {
    fn new() -> Self {
        let null = || AtomicPtr::new(null_mut());
        Self { version: AtomicU32::new(0), words: [null(), null()] }
    }

    fn write(&self, words: [*mut (); 2]) {
        let version = self.version.load(Relaxed);
        for (place, word) in self.words.iter().zip(words) {
            place.store(word, Relaxed);
        }
        self.version.store(version + 2, Release);
    }

    fn read(&self) -> Option<[*mut (); 2]> {
        let version = self.version.load(Acquire);
        let words = [0, 1].map(|i: usize| self.words[i].load(Relaxed));
        loom::sync::atomic::fence(Acquire);
        (self.version.load(Relaxed) == version).then_some(words)
    }
}

#[test]
#[should_panic(expected = "torn")]
fn a_write_that_does_not_say_when_it_begins_is_caught() {
    explore(2, is_read_whole::<Even>);
}
