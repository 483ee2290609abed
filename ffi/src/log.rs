#![allow(unsafe_code, reason = "names of C")]
//! A log of every input of a scheduler that C drives itself.

use crate::boundary::Out;
use crate::machine::Host;
use crate::room::{OF_A_LOG, room};
use crate::runtime::{fork, text};
use crate::scheduler::change;
use crate::status::red_status;
use crate::values::red_scheduler;
use core::ffi::c_char;
use nix::errno::Errno;
use red_core::{Capacity, Instant, Scheduler};
use red_record::{Cut, Header, Recorder, Tape, Writer};
use std::io;
use std::path::Path;

/// What calls are made on.
#[inline(always)]
pub(crate) const fn calls<'a, C: Capacity>(
    scheduler: &'a mut Scheduler<C>,
    tape: Option<&'a mut Tape>,
) -> Recorder<'a, C> {
    Recorder::new(scheduler, tape)
}

/// The system's own words are what helps here: it says them as it does in C, by `errno`.
pub(crate) fn no_file(why: Option<io::Error>) -> red_status {
    let code = why.and_then(|why| why.raw_os_error()).map_or(Errno::EIO, Errno::from_raw);
    code.set();
    red_status::LogFile
}

/// A scheduler of any class that can have a log.
pub(crate) trait Logged {
    fn begin_log(&mut self, path: &str) -> Result<(), red_status>;
    fn end_log(&mut self, now: Instant) -> Result<u64, red_status>;
    fn drop_log(&mut self);
}

impl<C: Capacity> Logged for Host<C> {
    fn begin_log(&mut self, path: &str) -> Result<(), red_status> {
        if self.is_begun || self.scheduler.now() > Instant::ZERO {
            return Err(red_status::LogLate);
        }
        self.log.begin(&self.scheduler, path)
    }

    fn end_log(&mut self, now: Instant) -> Result<u64, red_status> {
        self.log.end(&mut self.scheduler, now)
    }

    fn drop_log(&mut self) {
        if let Some(log) = self.log.0.take_if(|log| log.forks != fork::generation()) {
            // Its thread is the parent's.
            core::mem::forget(log);
        }
        self.log = Log::NONE;
    }
}

/// Where inputs go, if they go anywhere.
pub(crate) struct Log(Option<Box<Open>>);

/// A log that was begun.
struct Open {
    tape: Tape,
    writer: Writer,
    /// A child of fork has no writer.
    forks: u32,
}

impl Log {
    pub(crate) const NONE: Self = Self(None);

    /// Where calls are written down.
    #[inline(always)]
    pub(crate) fn tape(&mut self) -> Option<&mut Tape> {
        self.0.as_mut().map(|log| &mut log.tape)
    }

    /// Begins a log of a scheduler that was just opened.
    fn begin<C: Capacity>(&mut self, scheduler: &Scheduler<C>, path: &str) -> Result<(), red_status> {
        if self.0.is_some() {
            return Err(red_status::LogLate);
        }
        let program = concat!("libred ", env!("CARGO_PKG_VERSION"));
        let header = Header::by_calls::<C>(program, "custom", *scheduler.config());
        let (writer, tape) =
            Writer::start(Path::new(path), &header).map_err(|why| no_file(Some(why.into())))?;
        self.0 = Some(Box::new(Open { tape, writer, forks: fork::generation() }));
        Ok(())
    }

    /// Ends it, and waits until it is written. How many inputs found no room.
    fn end<C: Capacity>(&mut self, scheduler: &mut Scheduler<C>, now: Instant) -> Result<u64, red_status> {
        let Some(log) = self.0.take_if(|log| log.forks == fork::generation()) else {
            return Err(if self.0.is_some() { red_status::Forked } else { red_status::Idle });
        };
        let Open { mut tape, writer, .. } = *log;
        Recorder::new(scheduler, Some(&mut tape)).end(now);
        drop(tape);
        let (totals, failed) = writer.finish();
        let is_lost = failed.is_some() || totals.cut == Some(Cut::Panicked);
        if is_lost { Err(no_file(failed)) } else { Ok(totals.dropped) }
    }
}

/// Records every input of a scheduler from here on in a log at `path` (UTF-8), which `redrt replay` feeds to a scheduler again.
/// Directly after the scheduler was opened: before it was set up, a lane retired, or time passed. Writing is done by a thread of its own; calls on the scheduler write to memory.
/// Part of libred, not of libred_core.
///
/// Threads: one at a time on a scheduler. Real time: no. Time: one file is created. Errors: RED_STATUS_TEXT,
/// RED_STATUS_LOG_LATE, RED_STATUS_LOG_FILE: errno says why, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_record_begin(scheduler: *mut red_scheduler, path: *const c_char) -> red_status {
    change(scheduler, |machine| {
        room(OF_A_LOG)?;
        machine.begin_log(&text::take(path)?)?;
        Ok(red_status::Ok)
    })
}

/// Ends the log of a scheduler at `now_ns`, and waits until it is written. A log without this end is not whole, and is refused
/// by `redrt replay` after all that it has. `dropped` is how many inputs found no room; 0: the log is whole. Part of libred,
/// not of libred_core.
///
/// Threads: one at a time on a scheduler. Real time: no. Time: until it is written. Errors: RED_STATUS_IDLE: there is no log;
/// RED_STATUS_LOG_FILE: it could not be written to its end, errno says why, and it is ended all the same;
/// RED_STATUS_FORKED: it is the parent's.
#[unsafe(no_mangle)]
pub extern "C" fn red_record_end(
    scheduler: *mut red_scheduler,
    now_ns: u64,
    dropped: *mut u64,
) -> red_status {
    change(scheduler, |machine| {
        let out = Out::of(dropped)?;
        out.put(machine.end_log(Instant::from_nanos(now_ns))?);
        Ok(red_status::Ok)
    })
}
