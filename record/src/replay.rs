//! A log fed to a scheduler again.

use crate::entry::{Answer, Call, Entry};
use crate::error::LogError;
use crate::header::Header;
use crate::reader::Reader;
use red_core::{Capacity, CommitError, Instant, Scheduler};
use std::collections::VecDeque;
use std::io::Read;

/// Entries that are shown before a difference.
const CONTEXT: usize = 8;

/// How a replay went.
#[derive(Debug)]
pub struct Replay {
    /// Inputs that were fed.
    pub inputs: u64,
    /// Actions among the answers.
    pub actions: u64,
    /// The first answer that was not as recorded; nothing was fed after it.
    pub difference: Option<Difference>,
}

/// An answer that was not as recorded.
#[derive(Debug)]
pub struct Difference {
    /// The how-manieth input, from 1.
    pub input: u64,
    /// The last inputs before it, oldest first.
    pub before: Vec<Entry>,
    /// What was recorded.
    pub recorded: Entry,
    /// What the call answers now.
    pub now: Answer,
}

/// Feeds every input of a log to `scheduler`, which is set up as the recorded one was, and compares every answer.
/// `change` makes the host's graph change of a number; `watch` sees every entry that was as recorded.
///
/// # Errors
/// [`LogError`]: the log has other capacities, or ends early, or is damaged.
pub fn replay<C: Capacity, R: Read>(
    log: &mut Reader<R>,
    scheduler: &mut Scheduler<C>,
    mut change: impl FnMut(&mut Scheduler<C>, u32, Instant) -> Result<(), CommitError>,
    mut watch: impl FnMut(&Scheduler<C>, &Entry),
) -> Result<Replay, LogError> {
    let (found, expected) = (log.header().capacities, Header::capacities_of::<C>());
    if found != expected {
        return Err(LogError::Capacities { found, expected });
    }
    let mut done = Replay { inputs: 0, actions: 0, difference: None };
    let mut before = VecDeque::with_capacity(CONTEXT);
    while let Some(entry) = log.next_entry()? {
        done.inputs += 1;
        let now = feed(scheduler, &entry, &mut change);
        // Nothing depends on them.
        while scheduler.take_event().is_some() {}
        if now != entry.answer {
            let before = before.into_iter().collect();
            done.difference = Some(Difference { input: done.inputs, before, recorded: entry, now });
            return Ok(done);
        }
        done.actions += u64::from(matches!(now, Answer::Polled(Some(_)) | Answer::Outcome(Some(_))));
        watch(scheduler, &entry);
        if before.len() == CONTEXT {
            before.pop_front();
        }
        before.push_back(entry);
    }
    Ok(done)
}

fn feed<C: Capacity>(
    scheduler: &mut Scheduler<C>,
    entry: &Entry,
    change: &mut impl FnMut(&mut Scheduler<C>, u32, Instant) -> Result<(), CommitError>,
) -> Answer {
    let now = entry.now;
    match entry.call {
        Call::Release { task, at, capture } => Answer::Released(scheduler.release_at(task, at, capture, now)),
        Call::Complete(unit) => Answer::Reported(scheduler.complete(unit, now)),
        Call::Fail(unit) => Answer::Reported(scheduler.fail(unit, now)),
        Call::Poll(None) => Answer::Polled(scheduler.poll(now)),
        Call::Poll(Some(lane)) => Answer::Polled(scheduler.poll_on(lane, now)),
        Call::TakeOutcome => Answer::Outcome(scheduler.take_outcome()),
        Call::Edit(number) => Answer::Edited(change(scheduler, number, now)),
        Call::Retire(lane) => Answer::Done(scheduler.retire_lane(lane)),
        Call::Restore(lane) => Answer::Done(scheduler.restore_lane(lane)),
        Call::Remove(task) => Answer::Done(scheduler.remove_task(task, now)),
        Call::End => Answer::Counters(scheduler.counters()),
    }
}
