//! The side under the lock: entries into chunks, full chunks into a mailbox.

use crate::entry::Entry;
use crate::words::{Books, LONGEST};
use red_core::{Duration, Instant};
use red_sync::Mailbox;
use std::sync::Arc;

/// Words of a chunk: some thousand entries.
pub(crate) const CHUNK: usize = 8192;
/// Chunks of a tape: 4 MiB, or what 40 lanes write in a tenth of a second when every body takes two microseconds.
pub(crate) const CHUNKS: usize = 64;
/// A chunk is handed over when it is so old, full or not, so that little is lost with the process.
const AGE: Duration = Duration::from_millis(100);

/// Words on their way to the file.
pub(crate) struct Chunk {
    words: Box<[u64; CHUNK]>,
    len: usize,
    entries: u64,
}

impl Chunk {
    /// An empty one, its memory touched.
    pub(crate) fn new() -> Self {
        // Not zero, which the kernel would give without a page of its own.
        Self { words: Box::new([u64::MAX; CHUNK]), len: 0, entries: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, word: u64) {
        if let Some(place) = self.words.get_mut(self.len) {
            *place = word;
            self.len += 1;
        }
    }

    pub(crate) fn words(&self) -> &[u64] {
        self.words.get(..self.len).unwrap_or_default()
    }

    pub(crate) const fn entries(&self) -> u64 {
        self.entries
    }

    pub(crate) const fn clear(&mut self) {
        (self.len, self.entries) = (0, 0);
    }

    const fn has_room(&self) -> bool {
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
/// Time bound: O(1) for an entry, no system call, no allocation, no waiting. When all chunks are on their way the
/// tape is at its end: later entries are counted and not kept, so that what is kept has no gaps.
pub struct Tape {
    exchange: Arc<Exchange>,
    chunk: Option<Chunk>,
    books: Books,
    /// Time of the last entry, and of the chunk's first.
    now: Instant,
    since: Instant,
    dropped: u64,
}

impl Tape {
    /// A tape and the exchange that its chunks go through.
    pub(crate) fn new() -> (Self, Arc<Exchange>) {
        let exchange = Arc::new(Exchange { full: Mailbox::new(), empty: Mailbox::new() });
        if let Some(post) = exchange.empty.claim() {
            while post.push(Chunk::new()).is_ok() {}
        }
        let chunk = exchange.empty.pop();
        let new = Self {
            exchange: exchange.clone(),
            chunk,
            books: Books::new(),
            now: Instant::ZERO,
            since: Instant::ZERO,
            dropped: 0,
        };
        (new, exchange)
    }

    /// The time of the last entry, for calls that are given none.
    pub(crate) const fn now(&self) -> Instant {
        self.now
    }

    #[inline(always)]
    pub(crate) fn put(&mut self, entry: &Entry) {
        self.now = entry.now;
        let Some(chunk) = &mut self.chunk else {
            self.dropped += 1;
            return;
        };
        self.books.encode(entry, chunk);
        chunk.entries += 1;
        if !chunk.has_room() || entry.now.since(self.since) >= AGE {
            self.hand_over();
        }
    }

    #[cold]
    fn hand_over(&mut self) {
        self.since = self.now;
        if let (Some(chunk), Some(post)) = (self.chunk.take(), self.exchange.full.claim()) {
            // There are fewer chunks than places.
            let _posted = post.push(Letter::Chunk(chunk));
            self.chunk = self.exchange.empty.pop();
        }
    }
}

impl Drop for Tape {
    fn drop(&mut self) {
        self.hand_over();
        if let Some(post) = self.exchange.full.claim() {
            let _posted = post.push(Letter::End(self.dropped));
        }
    }
}

impl core::fmt::Debug for Tape {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Tape").field("dropped", &self.dropped).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
