//! The side under the lock: entries into chunks, full chunks into a mailbox.

use crate::entry::Entry;
use crate::words::{Books, LONGEST};
use red_core::{Duration, Instant};
use red_sync::Mailbox;
use std::sync::Arc;

/// Words of a chunk: some thousand entries.
pub(crate) const CHUNK: usize = 8192;
/// Chunks of a tape: 4 MiB, or some 0.3 s of one lane whose bodies take two microseconds.
pub(crate) const CHUNKS: usize = 64;
/// A chunk is handed over when it is so old, full or not, so that little is lost with the process.
const AGE: Duration = Duration::from_millis(100);

/// Words on their way to the file.
pub(crate) struct Chunk {
    words: Box<[u64; CHUNK]>,
    len: usize,
    /// Words that are not the head of an entry.
    more: usize,
}

impl Chunk {
    /// An empty one, its memory touched.
    pub(crate) fn new() -> Self {
        // Not zero, which the kernel would give without a page of its own.
        Self { words: Box::new([u64::MAX; CHUNK]), len: 0, more: 0 }
    }

    /// Begins an entry. There has to be room; the mask is for the compiler, which then looks no more.
    #[inline(always)]
    pub(crate) fn head(&mut self, word: u64) {
        self.words[self.len % CHUNK] = word;
        self.len += 1;
    }

    /// Another word of the entry, or one before it.
    pub(crate) fn more(&mut self, word: u64) {
        self.head(word);
        self.more += 1;
    }

    pub(crate) fn words(&self) -> &[u64] {
        self.words.get(..self.len).unwrap_or_default()
    }

    pub(crate) const fn entries(&self) -> u64 {
        (self.len - self.more) as u64
    }

    pub(crate) const fn clear(&mut self) {
        (self.len, self.more) = (0, 0);
    }

    pub(crate) const fn has_room(&self) -> bool {
        self.len + LONGEST <= CHUNK
    }
}

/// What the tape hands over.
pub(crate) enum Letter {
    /// Entries.
    Chunk(Chunk),
    /// The tape ended, and so many entries did not find room.
    End(u64),
}

/// Full chunks go one way, empty ones the other.
pub(crate) struct Exchange {
    pub(crate) full: Mailbox<Letter, { 2 * CHUNKS }>,
    pub(crate) empty: Mailbox<Chunk, CHUNKS>,
}

/// Takes the entries of one scheduler, under whatever lock that has.
///
/// Time bound: O(1) for an entry, no system call, no allocation, no waiting. When all chunks are on their way and the
/// last one is full, the tape is at its end: later entries are counted and not kept, so that what is kept has no gaps.
pub struct Tape {
    exchange: Arc<Exchange>,
    chunk: Chunk,
    books: Books,
    /// When the chunk is handed over though it has room.
    due: Instant,
    dropped: u64,
}

impl Tape {
    /// A tape and the exchange that its chunks go through.
    pub(crate) fn new() -> (Self, Arc<Exchange>) {
        let exchange = Arc::new(Exchange { full: Mailbox::new(), empty: Mailbox::new() });
        if let Some(post) = exchange.empty.claim() {
            while post.push(Chunk::new()).is_ok() {}
        }
        let chunk = exchange.empty.pop().unwrap_or_else(Chunk::new);
        let due = Instant::ZERO.saturating_add(AGE);
        (Self { exchange: exchange.clone(), chunk, books: Books::new(), due, dropped: 0 }, exchange)
    }

    /// The time of the last entry, for calls that are given none.
    pub(crate) const fn now(&self) -> Instant {
        self.books.now()
    }

    #[inline(always)]
    pub(crate) fn put(&mut self, entry: &Entry) {
        // One branch for all that is seldom.
        let is_usual = self.chunk.has_room() & (entry.now < self.due) & self.books.is_near(entry.now);
        if is_usual || self.prepare(entry.now) {
            self.books.encode(entry, &mut self.chunk);
        }
    }

    /// Makes room, hands over what is old, spells a time that is far. Whether the entry is kept.
    #[cold]
    fn prepare(&mut self, now: Instant) -> bool {
        if now >= self.due {
            self.due = now.saturating_add(AGE);
            self.hand_over();
        } else if !self.chunk.has_room() {
            self.hand_over();
        }
        if self.dropped > 0 || !self.chunk.has_room() {
            self.dropped += 1;
            return false;
        }
        if !self.books.is_near(now) {
            self.books.spell(now, &mut self.chunk);
        }
        true
    }

    /// Full or old, for an empty one; if there is none, it is filled up, and that is the end.
    fn hand_over(&mut self) {
        if let (0, Some(empty)) = (self.dropped, self.exchange.empty.pop()) {
            let chunk = core::mem::replace(&mut self.chunk, empty);
            self.exchange.send(Letter::Chunk(chunk));
        }
    }
}

impl Exchange {
    /// There are fewer letters than places.
    fn send(&self, letter: Letter) {
        let _sent = self.full.claim().map(|post| post.push(letter));
    }
}

impl Drop for Tape {
    fn drop(&mut self) {
        let last = Chunk { words: Box::new([0; CHUNK]), len: 0, more: 0 };
        self.exchange.send(Letter::Chunk(core::mem::replace(&mut self.chunk, last)));
        self.exchange.send(Letter::End(self.dropped));
    }
}

impl core::fmt::Debug for Tape {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Tape").field("dropped", &self.dropped).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
