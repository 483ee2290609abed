//! A log, entry by entry. Nothing in the file is believed: sizes are bounded before memory is taken, checksums are
//! compared before a byte is used.

use crate::entry::Entry;
use crate::error::LogError;
use crate::header::{FORMAT, Header, MAGIC};
use crate::tape::CHUNK;
use crate::words::Books;
use crate::writer::{CLOSED, TOTALS, Totals};
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
    totals: Totals,
    books: Books,
    block: Block,
    read: u64,
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
    /// Reads the beginning of a log.
    ///
    /// # Errors
    /// [`LogError`]: it is no log, of another format, damaged, not closed, or some inputs are missing in it.
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
        let header =
            serde_json::from_slice(&text).map_err(|_| LogError::Damaged { at, what: "the header" })?;
        let totals = read_totals(&mut source)?;
        Ok(Self { source, header, totals, books: Books::new(), block: Block::default(), read: 0 })
    }

    /// What was recorded.
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// How much was recorded.
    pub const fn totals(&self) -> Totals {
        self.totals
    }

    /// The next entry; `None` at the end.
    ///
    /// # Errors
    /// [`LogError`]: truncated or damaged.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, LogError> {
        if self.block.entries == 0 {
            if self.block.next != self.block.bytes.len() || !self.books.is_at_rest() {
                return Err(self.damaged());
            }
            if self.read == self.totals.entries {
                return self.end();
            }
            self.next_block()?;
        }
        let (block, books) = (&mut self.block, &mut self.books);
        let entry = books.decode(|| block.word().ok_or(())).ok().flatten();
        let entry = entry.ok_or_else(|| self.damaged())?;
        self.block.entries -= 1;
        self.read += 1;
        Ok(Some(entry))
    }

    fn next_block(&mut self) -> Result<(), LogError> {
        let at = self.source.at;
        let (entries, length, crc) = (self.source.int()?, self.source.int()?, self.source.int()?);
        if entries == 0 || length > LARGEST_BLOCK {
            return Err(LogError::Damaged { at, what: "a block" });
        }
        self.source.checked(length, crc, "a block", &mut self.block.bytes)?;
        self.block = Block { at, next: 0, entries, bytes: std::mem::take(&mut self.block.bytes) };
        Ok(())
    }

    fn end(&mut self) -> Result<Option<Entry>, LogError> {
        match self.source.take::<1>() {
            Err(LogError::Truncated { .. }) => Ok(None),
            Err(e) => Err(e),
            Ok(_) => Err(LogError::Damaged { at: self.source.at - 1, what: "what follows the last block" }),
        }
    }

    const fn damaged(&self) -> LogError {
        LogError::Damaged { at: self.block.at, what: "a block" }
    }
}

fn read_totals<R: Read>(source: &mut Counted<R>) -> Result<Totals, LogError> {
    let at = source.at;
    let bytes: [u8; TOTALS] = source.take()?;
    let long = |from: usize| {
        let mut word = [0; 8];
        word.iter_mut().zip(bytes.iter().skip(from)).for_each(|(place, byte)| *place = *byte);
        u64::from_le_bytes(word)
    };
    let (state, crc) = (long(16) as u32, (long(16) >> 32) as u32);
    if crc != crc32fast::hash(bytes.get(..TOTALS - 4).unwrap_or_default()) {
        return Err(LogError::Damaged { at, what: "the totals" });
    }
    let totals = Totals { entries: long(0), dropped: long(8), bytes: 0 };
    match (state, totals.dropped) {
        (CLOSED, 0) => Ok(totals),
        (CLOSED, dropped) => Err(LogError::Incomplete { dropped }),
        _ => Err(LogError::NotClosed),
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
