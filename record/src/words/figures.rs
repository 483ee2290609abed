//! How jobs ended, and how the run did, as words.

use super::codes::SHED;
use crate::entry::{End, back, then};
use crate::tape::Chunk;
use red_core::{Counters, Instant, JobId, Outcome, TaskId};

/// An id of 32 bits.
pub(super) fn bits(word: u64) -> Option<u32> {
    u32::try_from(word).ok()
}

pub(super) fn numbers(end: &End) -> [u64; 8] {
    let c = &end.counters;
    let [units, late] = [c.units, c.late_completions];
    let (jobs, starts) = (end.jobs_in_flight, end.starts);
    [units, c.encoder_runs_saved, c.overruns, c.clock_steps_back, late, c.evictions, jobs, starts]
}

pub(super) fn put_outcome(outcome: &Outcome, now: Instant, out: &mut Chunk) {
    out.more(outcome.job.to_bits().into());
    let shed = SHED.iter().position(|reason| outcome.shed == Some(*reason)).map_or(0, |at| at as u64 + 1);
    out.more(u64::from(outcome.task.to_bits()) << 4 | shed);
    out.more(outcome.index);
    out.more(back(now, outcome.release));
    out.more(back(outcome.release, outcome.deadline));
    out.more(back(now, outcome.at));
}

pub(super) fn take_end<E>(mut next: impl FnMut() -> Result<u64, E>) -> Result<End, E> {
    let mut counters = Counters::default();
    counters.units = next()?;
    counters.encoder_runs_saved = next()?;
    counters.overruns = next()?;
    counters.clock_steps_back = next()?;
    counters.late_completions = next()?;
    counters.evictions = next()?;
    Ok(End { counters, jobs_in_flight: next()?, starts: next()? })
}

pub(super) fn take_outcome<E>(
    now: Instant,
    mut next: impl FnMut() -> Result<u64, E>,
) -> Result<Option<Outcome>, E> {
    let (job, word, index) = (bits(next()?), next()?, next()?);
    let release = then(now, next()?);
    // The deadline counts from the release: the same distance for all jobs of a task.
    let deadline = then(release, next()?);
    let at = then(now, next()?);
    let shed = match (word & 15).checked_sub(1) {
        None => Some(None),
        Some(reason) => SHED.get(reason as usize).map(|reason| Some(*reason)),
    };
    let ids = job.zip(bits(word >> 4));
    Ok(ids.zip(shed).map(|((job, task), shed)| Outcome {
        job: JobId::from_bits(job),
        task: TaskId::from_bits(task),
        index,
        release,
        deadline,
        at,
        shed,
    }))
}
