//! *Claim.* Every letter of a mailbox arrives once and in order, a letter is refused only when the box is full, the
//! right to post goes from one producer to the next with all that was posted, and a second reader gets nothing.
//!
//! *Threads.* A producer and a reader; then two of either.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `sync/src/mailbox.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::atomic::{AtomicU32, Ordering};
use loom::thread;
use red_loom_tests::Mailbox;
use red_loom_tests::model::explore;
use std::sync::Arc;

/// What the claims are about.
trait Letters: Send + Sync + 'static {
    fn new() -> Self;
    /// As the only producer.
    fn post(&self, letters: &[u32]) -> usize;
    fn pop(&self) -> Option<u32>;
}

/// A box of two.
impl Letters for Mailbox<u32, 2> {
    fn new() -> Self {
        Self::new()
    }

    fn post(&self, letters: &[u32]) -> usize {
        let post = self.claim().expect("nobody else posts");
        letters.iter().take_while(|letter| post.push(**letter).is_ok()).count()
    }

    fn pop(&self) -> Option<u32> {
        self.pop()
    }
}

/// Three letters for a box of two, while the reader looks twice; then the rest is read.
fn delivers_each_once<M: Letters>() {
    let mailbox = Arc::new(M::new());
    let producer = {
        let mailbox = mailbox.clone();
        thread::spawn(move || mailbox.post(&[1, 2, 3]))
    };
    let mut read: Vec<u32> = (0..2).filter_map(|_| mailbox.pop()).collect();
    let early = read.len();
    let posted = producer.join().unwrap();
    read.extend(std::iter::from_fn(|| mailbox.pop()));
    assert!(posted >= 2, "refused though there was room");
    assert!(posted == 2 || early > 0, "three letters in a box of two");
    assert_eq!(read, (1..=posted as u32).collect::<Vec<_>>(), "lost, twice or out of order");
}

#[test]
fn every_letter_arrives_once_and_in_order() {
    explore(2, delivers_each_once::<Mailbox<u32, 2>>);
}

#[test]
fn the_next_producer_goes_on_where_the_last_one_left() {
    explore(2, || {
        let mailbox = Arc::new(Mailbox::<u32, 2>::new());
        let post = |mailbox: &Mailbox<u32, 2>, letter| {
            mailbox.claim().map(|post| post.push(letter).expect("there is room"))
        };
        let other = {
            let mailbox = mailbox.clone();
            thread::spawn(move || post(&mailbox, 1).is_some())
        };
        // Tried again, so that the first try, which may fail, has to leave the right where it is.
        let second = (0..2).any(|_| post(&mailbox, 2).is_some());
        let first = other.join().unwrap();
        let mut read: Vec<_> = std::iter::from_fn(|| mailbox.pop()).collect();
        read.sort_unstable();
        let posted = [(first, 1), (second, 2)].into_iter().filter_map(|(is, letter)| is.then_some(letter));
        assert_eq!(read, posted.collect::<Vec<_>>(), "one producer wrote over the other");
        assert!(first || second, "nobody had the right");
    });
}

/// Two readers of two letters: what one does not get the other does, or nobody yet.
fn lets_one_reader_in<M: Letters>(threads: usize) {
    let mailbox = Arc::new(M::new());
    if threads == 2 {
        mailbox.post(&[1, 2]);
    }
    let others: Vec<_> = (1..threads)
        .map(|number| {
            let mailbox = mailbox.clone();
            thread::spawn(
                move || if number == 2 { Some(mailbox.post(&[1, 2]) as u32) } else { mailbox.pop() },
            )
        })
        .collect();
    let mut read = Vec::from_iter(mailbox.pop());
    let mut theirs = others.into_iter().map(|other| other.join().unwrap());
    read.extend(theirs.next().flatten());
    assert!(theirs.flatten().all(|posted| posted == 2), "refused though there was room");
    read.extend(std::iter::from_fn(|| mailbox.pop()));
    read.sort_unstable();
    assert_eq!(read, [1, 2], "lost or twice");
}

#[test]
fn a_second_reader_gets_nothing() {
    explore(2, || lets_one_reader_in::<Mailbox<u32, 2>>(2));
}

#[test]
fn two_readers_and_a_producer_agree() {
    explore(3, || lets_one_reader_in::<Mailbox<u32, 2>>(3));
}

/// A mailbox of two with planted faults: one that takes `ROOM` letters, and lets any number of readers in.
struct Planted<const ROOM: u32> {
    head: AtomicU32,
    tail: AtomicU32,
    letters: [UnsafeCell<u32>; 2],
}

// SAFETY: as much as a mailbox with planted faults is.
unsafe impl<const ROOM: u32> Sync for Planted<ROOM> {}
// SAFETY: the letters go with it.
unsafe impl<const ROOM: u32> Send for Planted<ROOM> {}

impl<const ROOM: u32> Letters for Planted<ROOM> {
    fn new() -> Self {
        let letters = [UnsafeCell::new(0), UnsafeCell::new(0)];
        Self { head: AtomicU32::new(0), tail: AtomicU32::new(0), letters }
    }

    fn post(&self, letters: &[u32]) -> usize {
        let push = |letter: &&u32| {
            let head = self.head.load(Ordering::Relaxed);
            if head - self.tail.load(Ordering::Acquire) >= ROOM {
                return false;
            }
            // SAFETY: the checker says when this place is not the producer's.
            self.letters[head as usize % 2].with_mut(|place| unsafe { *place = **letter });
            self.head.store(head + 1, Ordering::Release);
            true
        };
        letters.iter().take_while(push).count()
    }

    fn pop(&self) -> Option<u32> {
        let tail = self.tail.load(Ordering::Relaxed);
        if self.head.load(Ordering::Acquire) == tail {
            return None;
        }
        // SAFETY: the checker says when this place is not the reader's.
        let letter = self.letters[tail as usize % 2].with(|place| unsafe { *place });
        self.tail.store(tail + 1, Ordering::Release);
        Some(letter)
    }
}

#[test]
#[should_panic(expected = "three letters in a box of two")]
fn a_box_that_takes_one_too_many_is_caught() {
    explore(2, delivers_each_once::<Planted<3>>);
}

#[test]
#[should_panic(expected = "refused though there was room")]
fn a_box_that_refuses_too_early_is_caught() {
    explore(2, delivers_each_once::<Planted<1>>);
}

#[test]
#[should_panic(expected = "lost or twice")]
fn a_box_with_two_readers_is_caught() {
    explore(2, || lets_one_reader_in::<Planted<2>>(2));
}
