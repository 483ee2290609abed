#![allow(unsafe_code, reason = "a ring shared by one producer and one consumer")]
//! A mailbox: a bounded ring with one producer and one consumer, wait-free on both sides.
//!
//! *Rule.* The producer alone moves `head`, the consumer alone moves `tail`; a place belongs to the producer
//! while head - tail < N, and to the consumer while it is not 0. A full box refuses; nothing is overwritten.

use crate::primitive::{AtomicU8, AtomicU32, Cell, Ordering, constructor, empty_cells};

/// A ring of `N` letters; `N` is a power of two.
///
/// ```
/// let mailbox = red_sync::Mailbox::<u32, 2>::new();
/// let post = mailbox.claim().expect("nobody else has it");
/// assert!(mailbox.claim().is_none()); // one producer
/// assert_eq!([1, 2, 3].map(|letter| post.push(letter)), [Ok(()), Ok(()), Err(3)]); // full is told
/// assert_eq!(mailbox.pop(), Some(1));
/// ```
#[derive(Debug)]
#[repr(align(128))]
pub struct Mailbox<T, const N: usize> {
    head: AtomicU32,
    tail: AtomicU32,
    claimed: AtomicU8,
    reading: AtomicU8,
    letters: [Cell<Option<T>>; N],
}

/// The right to push: one at a time per mailbox. Dropping it gives it back.
#[derive(Debug)]
pub struct Post<'a, T, const N: usize>(&'a Mailbox<T, N>);

// SAFETY: the protocol gives each letter's place to one side at a time, so sharing the mailbox only moves
// letters between threads.
unsafe impl<T: Send, const N: usize> Sync for Mailbox<T, N> {}

impl<T, const N: usize> Mailbox<T, N> {
    constructor! {
        /// An empty mailbox.
        #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
        pub fn new() -> Self {
            const { assert!(N.is_power_of_two() && N <= 1 << 16, "a mailbox has 2^k places") };
            Self {
                head: AtomicU32::new(0),
                tail: AtomicU32::new(0),
                claimed: AtomicU8::new(0),
                reading: AtomicU8::new(0),
                letters: empty_cells(),
            }
        }
    }

    /// Becomes the producer; `None` while another has the right.
    pub fn claim(&self) -> Option<Post<'_, T, N>> {
        // Acquire: pairs with the Release in `Post::drop`, so that the next producer sees the last one's head.
        let won = self.claimed.compare_exchange(0, 1, Ordering::Acquire, Ordering::Relaxed);
        won.is_ok().then(|| Post(self))
    }

    /// Takes the oldest letter. One reader at a time; a second one gets `None`.
    pub fn pop(&self) -> Option<T> {
        // Acquire: pairs with the Release below, so that the next reader sees this one's tail.
        self.reading.compare_exchange(0, 1, Ordering::Acquire, Ordering::Relaxed).ok()?;
        let tail = self.tail.load(Ordering::Relaxed);
        // Acquire: pairs with the Release in `push`, so that the letter is there.
        let mut letter = None;
        if self.head.load(Ordering::Acquire) != tail {
            letter = self.letters[tail as usize % N].with_mut(|place| {
                // SAFETY: head != tail, so the place at `tail` is the consumer's until `tail` moves.
                unsafe { (*place).take() }
            });
            // Release: pairs with the Acquire in `push`, which may reuse the place.
            self.tail.store(tail.wrapping_add(1), Ordering::Release);
        }
        self.reading.store(0, Ordering::Release);
        letter
    }
}

impl<T, const N: usize> Post<'_, T, N> {
    /// Posts a letter. Time bound: O(1), no waiting. Errors: the letter, when the box is full.
    pub fn push(&self, letter: T) -> Result<(), T> {
        let mailbox = self.0;
        let head = mailbox.head.load(Ordering::Relaxed);
        // Acquire: pairs with the Release in `pop`, so that the place was read before it is written again.
        if head.wrapping_sub(mailbox.tail.load(Ordering::Acquire)) as usize >= N {
            return Err(letter);
        }
        mailbox.letters[head as usize % N].with_mut(|place| {
            // SAFETY: head - tail < N, so the place at `head` is the producer's until `head` moves.
            unsafe { *place = Some(letter) };
        });
        // Release: pairs with the Acquire in `pop`.
        mailbox.head.store(head.wrapping_add(1), Ordering::Release);
        Ok(())
    }
}

impl<T, const N: usize> Drop for Post<'_, T, N> {
    fn drop(&mut self) {
        self.0.claimed.store(0, Ordering::Release);
    }
}

#[cfg(test)]
mod tests;
