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
//! The JSON is `Header`: with `config` the log is one by calls and needs no workload, without it there is the workload's
//! text. Entries (`words.rs`) are the same in both; a graph is an entry for each node and its edges before the call that
//! takes it.
//!
//! Integers are little-endian, checksums CRC-32, words of entries LEB128. The state says whether the log is whole, or why
//! not (`totals.rs`). One that is still open belongs to a program that was killed, or that still runs; so that its
//! inputs up to then are there, a block is asked for once a second even if its chunk is not full.

use crate::error::StartError;
use crate::header::{FORMAT, Header, MAGIC};
use crate::tape::{Chunk, Exchange, Letter, Tape};
use crate::totals::{Cut, LARGEST, TOTALS, Totals};
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Between two looks for chunks.
const LOOK: Duration = Duration::from_millis(5);

/// So many looks apart, what is in a chunk is asked for.
const LOOKS: u32 = 200;

/// Writes a log on a thread of its own.
#[derive(Debug)]
pub struct Writer {
    thread: JoinHandle<(Totals, Option<io::Error>)>,
}

impl Writer {
    /// Begins a log at `path`. The tape is for whoever has the scheduler; dropping it ends the log.
    ///
    /// # Errors
    /// [`StartError`]: the file cannot be created or written, or no thread can be started.
    pub fn start(path: &Path, header: &Header) -> Result<(Self, Tape), StartError> {
        Self::start_in(File::create(path)?, header)
    }

    /// The same in a file that is open for writing, and empty.
    ///
    /// # Errors
    /// [`StartError`]: the file cannot be written, or no thread can be started.
    pub fn start_in(mut file: File, header: &Header) -> Result<(Self, Tape), StartError> {
        let head = head(header)?;
        file.write_all(&head)?;
        file.write_all(&Totals::to_bytes(None))?;
        let (tape, exchange) = Tape::new();
        let at = head.len() as u64;
        let log =
            Log { file, at, totals: Totals { bytes: at + TOTALS as u64, ..Totals::default() }, failed: None };
        let thread = thread::Builder::new().name("record".into()).spawn(move || log.fill(&exchange));
        Ok((Self { thread: thread.map_err(StartError::Thread)? }, tape))
    }

    /// Waits until everything is written; the tape has to be dropped before. What could not be written is in the
    /// totals, and why in the second place.
    #[must_use]
    pub fn finish(self) -> (Totals, Option<io::Error>) {
        self.thread
            .join()
            .unwrap_or_else(|_| (Totals { cut: Some(Cut::Panicked), ..Totals::default() }, None))
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
        let mut looks = 0;
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
                    if dropped > 0 {
                        self.totals.dropped += dropped;
                        self.totals.cut.get_or_insert(Cut::Slow);
                    }
                    break;
                }
                None => {
                    looks += 1;
                    if looks == LOOKS {
                        looks = 0;
                        exchange.wanted.store(true, Ordering::Relaxed);
                    }
                    thread::sleep(LOOK);
                }
            }
        }
        self.close();
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
            if let Some(e) = &self.failed {
                let is_too_large = e.kind() == io::ErrorKind::FileTooLarge;
                self.totals.cut = Some(if is_too_large { Cut::TooLarge } else { Cut::Failed });
            }
        }
        if self.failed.is_none() {
            self.totals.entries += chunk.entries();
            self.totals.bytes += block.len() as u64;
        } else {
            self.totals.dropped += chunk.entries();
        }
    }

    /// Cuts off what was half written, and writes the totals, after all that they vouch for is on the disk. Whatever fails
    /// of that is in the totals in the end, or else the log stays open.
    fn close(&mut self) {
        let kept = self.file.set_len(self.totals.bytes).and_then(|()| self.file.sync_data());
        self.goes_on(kept);
        let closed = self.put_totals();
        if !self.goes_on(closed) {
            let _or_open = self.put_totals();
        }
    }

    /// Into their place, which they have had since the beginning: most disks that are full take them all the same.
    fn put_totals(&mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.at))?;
        self.file.write_all(&Totals::to_bytes(Some(self.totals)))?;
        self.file.sync_data()
    }

    /// Whether that was done; else it is why the log is not whole.
    fn goes_on(&mut self, done: io::Result<()>) -> bool {
        let is_done = done.is_ok();
        if let Err(e) = done {
            self.totals.cut.get_or_insert(Cut::Failed);
            self.failed.get_or_insert(e);
        }
        is_done
    }
}
