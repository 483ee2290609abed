//! The side under the lock: entries into chunks, full chunks into a mailbox.

use crate::entry::Entry;
use crate::started::{Started, Starts};
use crate::words::{Books, LONGEST};
use core::hint::cold_path;
use red_core::{Instant, LaneId, UnitId};
use red_sync::Mailbox;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Words of a chunk: some thousand entries.
pub(crate) const CHUNK: usize = 8192;
/// Chunks of a tape: 4 MiB, or a second of one lane whose bodies take two microseconds, a word for each.
pub(crate) const CHUNKS: usize = 64;

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

    /// The word of so many entries, or the first of one. There has to be room; the remainder is for the compiler, which
    /// then looks no more.
    #[inline(always)]
    pub(crate) fn head(&mut self, word: u64, entries: u64) {
        self.words[self.len % CHUNK] = word;
        self.len += 1;
        self.entries += entries;
    }

    /// Another word of an entry.
    pub(crate) fn more(&mut self, word: u64) {
        self.head(word, 0);
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

    pub(crate) const fn has_room(&self) -> bool {
        // Two for a turn that is broken off at the end.
        self.len <= CHUNK - LONGEST - 2
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
    /// The writer has nothing to do and asks for what there is, full or not.
    pub(crate) wanted: AtomicBool,
}

/// Takes the entries of one scheduler, under whatever lock that has.
///
/// Time bound: O(1) for an entry, no system call, no allocation, no waiting. When all chunks are on their way and the
/// last one is full, the tape is at its end: later entries are counted and not kept, so that what is kept has no gaps.
pub struct Tape {
    exchange: Arc<Exchange>,
    chunk: Chunk,
    books: Books,
    dropped: u64,
    starts: Starts,
}

impl Tape {
    /// A tape and the exchange that its chunks go through.
    pub(crate) fn new() -> (Self, Arc<Exchange>) {
        let exchange = Arc::new(Exchange {
            full: Mailbox::new(),
            empty: Mailbox::new(),
            wanted: AtomicBool::new(false),
        });
        if let Some(post) = exchange.empty.claim() {
            while post.push(Chunk::new()).is_ok() {}
        }
        let chunk = exchange.empty.pop().unwrap_or_else(Chunk::new);
        let (books, starts) = (Books::new(), Starts::new(false));
        (Self { exchange: exchange.clone(), chunk, books, dropped: 0, starts }, exchange)
    }

    /// The time of the last entry, for calls that are given none.
    pub(crate) const fn now(&self) -> Instant {
        self.books.now()
    }

    /// For [`Started::of`].
    pub(crate) const fn starts(&mut self) -> &mut Starts {
        &mut self.starts
    }

    /// A call whose answer is as nearly always: the beginning of a turn.
    #[inline(always)]
    pub(crate) fn completed(&mut self, unit: UnitId, now: Instant) -> bool {
        self.chunk.has_room() && self.books.begin_turn(unit, now)
    }

    /// Its middle.
    #[inline(always)]
    pub(crate) fn dispatched(&mut self, lane: LaneId, started: &Started, now: Instant) -> bool {
        self.books.go_on_turn(lane, started, now)
    }

    /// Its end. Nothing was written since it began, so that there is still room.
    #[inline(always)]
    pub(crate) fn found_nothing(&mut self, lane: LaneId, now: Instant) -> bool {
        let ends = self.books.end_turn(lane, now, &mut self.chunk);
        if ends && self.exchange.wanted.load(Ordering::Relaxed) {
            cold_path();
            self.hand_over();
        }
        ends
    }

    /// Any entry.
    #[inline(never)]
    pub(crate) fn put(&mut self, entry: &Entry) {
        // A writer that does not come along asks for nothing: half empty chunks are no reason for a drop.
        if !self.chunk.has_room() || self.exchange.wanted.load(Ordering::Relaxed) {
            self.hand_over();
        }
        if !self.chunk.has_room() {
            self.dropped += 1;
            return;
        }
        if !self.books.is_near(entry.now) {
            self.books.spell(entry.now, &mut self.chunk);
        }
        self.books.encode(entry, &mut self.chunk);
    }

    /// The chunk is full or wanted: another one, if there is one, and else a full one is the end.
    #[inline(never)]
    fn hand_over(&mut self) {
        self.exchange.wanted.store(false, Ordering::Relaxed);
        // Once an entry was dropped none is taken any more: it would be freed here.
        if self.dropped == 0
            && let Some(empty) = self.exchange.empty.pop()
        {
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
        self.books.break_turn(&mut self.chunk);
        let last = Chunk::new();
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
