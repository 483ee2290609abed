//! Several words that are read as one: a sequence lock (Boehm, "Can seqlocks get along with programming language memory
//! models?", MSPC 2012).
//!
//! *Rule.* The version is odd while somebody writes. A reader that finds it odd, or another one behind the words than
//! before them, has nothing. Nobody waits.

use crate::primitive::{AtomicPtr, AtomicU32, Ordering, constructor, fence, null_words};

/// `N` words, which may be pointers. One thread at a time writes; any may read meanwhile.
///
/// ```
/// use core::ptr::without_provenance_mut as word;
/// let pair = red_sync::SeqLock::<2>::new();
/// pair.write([word(1), word(2)]);
/// assert_eq!(pair.read(), Some([word(1), word(2)]));
/// ```
#[derive(Debug)]
pub struct SeqLock<const N: usize> {
    version: AtomicU32,
    words: [AtomicPtr<()>; N],
}

impl<const N: usize> SeqLock<N> {
    constructor! {
        /// Null words.
        #[expect(clippy::new_without_default, reason = "the checker's has no constant one")]
        pub fn new() -> Self {
            Self { version: AtomicU32::new(0), words: null_words() }
        }
    }

    /// Writes all words. Time bound: O(N), no waiting.
    pub fn write(&self, words: [*mut (); N]) {
        let version = self.version.load(Ordering::Relaxed);
        self.version.store(version.wrapping_add(1), Ordering::Relaxed);
        // Release: pairs with the Acquire fence in `read`, which then sees the odd version if it saw what follows.
        fence(Ordering::Release);
        for (place, word) in self.words.iter().zip(words) {
            place.store(word, Ordering::Relaxed);
        }
        // Release: pairs with the Acquire in `read`.
        self.version.store(version.wrapping_add(2), Ordering::Release);
    }

    /// The words of one `write`; `None` if another one came between. Time bound: O(N), no waiting.
    ///
    /// Exact as long as no reader is overtaken by 2^31 writes.
    pub fn read(&self) -> Option<[*mut (); N]> {
        // Acquire: pairs with the Release at the end of `write`.
        let version = self.version.load(Ordering::Acquire);
        let words = core::array::from_fn(|i| self.words[i].load(Ordering::Relaxed));
        // Acquire: pairs with the Release fence in `write`.
        fence(Ordering::Acquire);
        (version.is_multiple_of(2) && self.version.load(Ordering::Relaxed) == version).then_some(words)
    }
}
