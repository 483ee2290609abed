//! A log, entry by entry. Nothing in the file is believed: sizes are bounded before memory is taken, checksums are
//! compared before a byte is used.

use crate::entry::{Call, Entry};
use crate::error::LogError;
use crate::header::{FORMAT, Header, LONGEST_RUN_NS, MAGIC};
use crate::tape::CHUNK;
use crate::totals::Totals;
use crate::words::Books;
use std::io::{self, Read};

/// A header holds a workload of at most 4 MiB, as JSON text.
const LARGEST_HEADER: u32 = 32 << 20;
/// Every word of a chunk in its longest form.
const LARGEST_BLOCK: u32 = CHUNK as u32 * 10;

/// A log that is read.
#[derive(Debug)]
pub struct Reader<R> {
    source: Counted<R>,
    header: Header,
    /// Of a log that is closed.
    totals: Option<Totals>,
    books: Books,
    block: Block,
    read: u64,
    /// The end of the run was read.
    ended: bool,
}

/// The words of one block that are not read yet.
#[derive(Debug, Default)]
struct Block {
    /// Where its words begin in the file.
    at: u64,
    bytes: Vec<u8>,
    next: usize,
    /// Entries left in it.
    entries: u32,
}

#[derive(Debug)]
struct Counted<R> {
    source: R,
    at: u64,
}

impl<R: Read> Counted<R> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], LogError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), LogError> {
        self.source.read_exact(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => LogError::Truncated { at: self.at },
            _ => LogError::Read(e),
        })?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn int(&mut self) -> Result<u32, LogError> {
        self.take().map(u32::from_le_bytes)
    }

    /// So many bytes whose checksum this is.
    fn checked(
        &mut self,
        length: u32,
        crc: u32,
        what: &'static str,
        into: &mut Vec<u8>,
    ) -> Result<(), LogError> {
        let at = self.at;
        into.clear();
        // Not before they are there: a wrong length takes no memory.
        let taken = (&mut self.source).take(length.into()).read_to_end(into).map_err(LogError::Read)?;
        self.at += taken as u64;
        if taken as u64 != u64::from(length) {
            return Err(LogError::Truncated { at: self.at });
        }
        if crc32fast::hash(into) == crc { Ok(()) } else { Err(LogError::Damaged { at, what }) }
    }
}

impl<R: Read> Reader<R> {
    /// Reads the beginning of a log. Whether the log is whole is known at its end.
    ///
    /// # Errors
    /// [`LogError`]: it is no log, of another format, or damaged.
    pub fn new(source: R) -> Result<Self, LogError> {
        let mut source = Counted { source, at: 0 };
        let magic = source.take().map_err(|e| match e {
            LogError::Truncated { .. } => LogError::NotALog,
            other => other,
        })?;
        if magic != MAGIC {
            return Err(LogError::NotALog);
        }
        match u16::from_le_bytes(source.take()?) {
            FORMAT => {}
            older if older < FORMAT => return Err(LogError::Older(older)),
            newer => return Err(LogError::Newer(newer)),
        }
        let (length, crc, at) = (source.int()?, source.int()?, source.at);
        if length > LARGEST_HEADER {
            return Err(LogError::Damaged { at, what: "the header" });
        }
        let mut text = Vec::new();
        source.checked(length, crc, "the header", &mut text)?;
        let header: Option<Header> = serde_json::from_slice(&text).ok();
        let header = header.filter(|header| header.duration_ns <= LONGEST_RUN_NS);
        let header = header.ok_or(LogError::Damaged { at, what: "the header" })?;
        let at = source.at;
        let totals = Totals::from_bytes(&source.take()?, at)?;
        let (books, block) = (Books::new(), Block::default());
        Ok(Self { source, header, totals, books, block, read: 0, ended: false })
    }

    /// What was recorded.
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// How much was recorded; `None` in a log that is not closed.
    pub const fn totals(&self) -> Option<Totals> {
        self.totals
    }

    /// The next entry; `None` at the end of the run. Entries that come before an error are as they were recorded.
    ///
    /// # Errors
    /// [`LogError`]: truncated, damaged, not closed, or some inputs are missing in it.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, LogError> {
        if self.block.entries == 0 {
            if self.block.next != self.block.bytes.len() || !self.books.is_at_rest() {
                return Err(self.damaged());
            }
            if self.totals.is_some_and(|totals| totals.entries == self.read) || !self.next_block()? {
                return self.end();
            }
        }
        let (block, books) = (&mut self.block, &mut self.books);
        let entry = books.decode(|| block.word().ok_or(())).ok().flatten().filter(|_| !self.ended);
        let entry = entry.ok_or_else(|| self.damaged())?;
        self.block.entries -= 1;
        self.read += 1;
        self.ended = entry.call == Call::End;
        Ok(Some(entry))
    }

    /// Reads the next block; `false` where a log that is not closed ends without one, or in the middle of it.
    fn next_block(&mut self) -> Result<bool, LogError> {
        match self.whole_block() {
            Err(LogError::Truncated { .. }) if self.totals.is_none() => Ok(false),
            read => read.map(|()| true),
        }
    }

    fn whole_block(&mut self) -> Result<(), LogError> {
        let at = self.source.at;
        let (entries, length, crc) = (self.source.int()?, self.source.int()?, self.source.int()?);
        if entries == 0 || length > LARGEST_BLOCK {
            return Err(LogError::Damaged { at, what: "a block" });
        }
        self.source.checked(length, crc, "a block", &mut self.block.bytes)?;
        self.block = Block { at, next: 0, entries, bytes: std::mem::take(&mut self.block.bytes) };
        Ok(())
    }

    /// No block is left: whether that is the end of the run.
    fn end(&mut self) -> Result<Option<Entry>, LogError> {
        let Some(totals) = self.totals else { return Err(LogError::NotClosed) };
        match self.source.take::<1>() {
            Err(LogError::Truncated { .. }) => {}
            Err(e) => return Err(e),
            Ok(_) => {
                let at = self.source.at - 1;
                return Err(LogError::Damaged { at, what: "what follows the last block" });
            }
        }
        match totals.cut {
            Some(cut) => Err(LogError::Incomplete { dropped: totals.dropped, cut }),
            None if self.ended => Ok(None),
            None => Err(LogError::Unended),
        }
    }

    const fn damaged(&self) -> LogError {
        LogError::Damaged { at: self.block.at, what: "a block" }
    }

    /// The parts of a graph in this block are of none.
    pub(crate) const fn no_graph(&self) -> LogError {
        LogError::Damaged { at: self.block.at, what: "a graph in the block" }
    }
}

impl Block {
    /// The next word, in its only form.
    fn word(&mut self) -> Option<u64> {
        let mut word = 0;
        for shift in (0..64).step_by(7) {
            let byte = *self.bytes.get(self.next)?;
            self.next += 1;
            let seven = u64::from(byte & 127);
            word |= seven.checked_shl(shift).filter(|shifted| shifted >> shift == seven)?;
            if byte < 128 {
                return Some(word);
            }
        }
        None
    }
}
