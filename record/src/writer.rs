//! The side off the real-time path: chunks into a file.
//!
//! # The file
//!
//! ```text
//! "REDLOG"  format u16  header: length u32, crc u32, JSON
//! totals: entries u64, dropped u64, state u32, crc u32     written last, in place
//! blocks: entries u32, length u32, crc u32, words          one per chunk, to the end of the file
//! ```
//!
//! Integers are little-endian, checksums CRC-32, words of entries LEB128. A log whose state is not [`CLOSED`] belongs to
//! a program that was killed, or that still runs.

use crate::header::{FORMAT, Header, MAGIC};
use crate::tape::{Chunk, Exchange, Letter, Tape};
use serde::Serialize;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// State of a log whose totals are final.
pub(crate) const CLOSED: u32 = u32::from_le_bytes(*b"DONE");
/// Bytes of the totals.
pub(crate) const TOTALS: usize = 24;
/// A log grows to so many bytes and then drops.
const LARGEST: u64 = 1 << 32;
/// Between two looks for chunks.
const LOOK: Duration = Duration::from_millis(5);

/// How much was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Totals {
    /// Inputs in the log.
    #[serde(rename = "inputs")]
    pub entries: u64,
    /// Inputs that are not in the log, all of them after those that are.
    pub dropped: u64,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Writes a log on a thread of its own.
#[derive(Debug)]
pub struct Writer {
    thread: JoinHandle<(Totals, Option<io::Error>)>,
}

impl Writer {
    /// Begins a log at `path`. The tape is for whoever has the scheduler; dropping it ends the log.
    ///
    /// # Errors
    /// The file cannot be created or written, or no thread can be started.
    pub fn start(path: &Path, header: &Header) -> io::Result<(Self, Tape)> {
        let mut file = File::create(path)?;
        let head = head(header)?;
        file.write_all(&head)?;
        file.write_all(&totals(Totals::default(), 0))?;
        let (tape, exchange) = Tape::new();
        let at = head.len() as u64;
        let log =
            Log { file, at, totals: Totals { bytes: at + TOTALS as u64, ..Totals::default() }, failed: None };
        let thread = thread::Builder::new().name("record".into()).spawn(move || log.fill(&exchange))?;
        Ok((Self { thread }, tape))
    }

    /// Waits until everything is written; the tape has to be dropped before. What could not be written is in the
    /// totals, and why in the second place.
    #[must_use]
    pub fn finish(self) -> (Totals, Option<io::Error>) {
        self.thread
            .join()
            .unwrap_or_else(|_| (Totals::default(), Some(io::Error::other("the writer panicked"))))
    }
}

fn head(header: &Header) -> io::Result<Vec<u8>> {
    let text = serde_json::to_vec(header)?;
    let mut head = Vec::with_capacity(text.len() + 16);
    head.extend(MAGIC);
    head.extend(FORMAT.to_le_bytes());
    head.extend((text.len() as u32).to_le_bytes());
    head.extend(crc32fast::hash(&text).to_le_bytes());
    head.extend(text);
    Ok(head)
}

fn totals(totals: Totals, state: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(TOTALS);
    bytes.extend(totals.entries.to_le_bytes());
    bytes.extend(totals.dropped.to_le_bytes());
    bytes.extend(state.to_le_bytes());
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// Seven bits a byte, lowest first, the eighth bit where more follow.
fn leb128(mut word: u64, out: &mut Vec<u8>) {
    while word >= 128 {
        out.push(word as u8 | 128);
        word >>= 7;
    }
    out.push(word as u8);
}

struct Log {
    file: File,
    /// Where the totals lie.
    at: u64,
    totals: Totals,
    /// After this nothing is written any more.
    failed: Option<io::Error>,
}

impl Log {
    fn fill(mut self, exchange: &Arc<Exchange>) -> (Totals, Option<io::Error>) {
        let mut block = Vec::new();
        loop {
            match exchange.full.pop() {
                Some(Letter::Chunk(mut chunk)) => {
                    self.add(&chunk, &mut block);
                    chunk.clear();
                    if let Some(post) = exchange.empty.claim() {
                        // There are as many places as chunks.
                        let _posted = post.push(chunk);
                    }
                }
                Some(Letter::End(dropped)) => {
                    self.totals.dropped += dropped;
                    break;
                }
                None => thread::sleep(LOOK),
            }
        }
        if let Err(e) = self.close() {
            self.failed.get_or_insert(e);
        }
        (self.totals, self.failed)
    }

    /// Appends a chunk, or counts it as dropped.
    fn add(&mut self, chunk: &Chunk, block: &mut Vec<u8>) {
        if chunk.entries() == 0 {
            return;
        }
        block.clear();
        block.extend([0; 12]);
        chunk.words().iter().for_each(|word| leb128(*word, block));
        let length = (block.len() - 12) as u32;
        let crc = crc32fast::hash(block.get(12..).unwrap_or_default());
        let head = [chunk.entries() as u32, length, crc].map(u32::to_le_bytes);
        block.iter_mut().zip(head.as_flattened()).for_each(|(place, byte)| *place = *byte);
        if self.failed.is_none() {
            let written = if self.totals.bytes + block.len() as u64 > LARGEST {
                Err(io::Error::new(io::ErrorKind::FileTooLarge, "the log has reached 4 GiB"))
            } else {
                self.file.write_all(block)
            };
            self.failed = written.err();
        }
        if self.failed.is_none() {
            self.totals.entries += chunk.entries();
            self.totals.bytes += block.len() as u64;
        } else {
            self.totals.dropped += chunk.entries();
        }
    }

    /// Cuts off what was half written, and writes the totals in place: that needs no room on the disk.
    fn close(&mut self) -> io::Result<()> {
        self.file.set_len(self.totals.bytes)?;
        self.file.seek(SeekFrom::Start(self.at))?;
        self.file.write_all(&totals(self.totals, CLOSED))?;
        self.file.sync_data()
    }
}
