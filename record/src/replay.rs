//! A log fed to a scheduler again.

use crate::entry::{Answer, Call, End, Entry};
use crate::error::LogError;
use crate::graph::Parts;
use crate::header::Header;
use crate::reader::Reader;
use crate::started::Starts;
use core::fmt;
use red_core::{Capacity, CommitError, Dag, Duration, Event, Instant, Scheduler, Timing};
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

/// A log that cannot be replayed to its end. What comes before was fed, and there was no difference.
#[derive(Debug)]
pub struct Broken {
    /// Why.
    pub error: LogError,
    /// Inputs that were fed.
    pub inputs: u64,
    /// Actions among the answers.
    pub actions: u64,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, inputs, actions } = self;
        write!(f, "{error}")?;
        if *inputs > 0 {
            write!(f, " ({inputs} inputs before that were fed, {actions} actions compared: no difference)")?;
        }
        Ok(())
    }
}

impl std::error::Error for Broken {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.error)
    }
}

/// Feeds every input of a log to `scheduler`, which is set up as the recorded one was, and compares every answer.
/// `change` makes the host's graph change of a number; `watch` sees every entry that was as recorded.
///
/// # Errors
/// [`Broken`]: the log has other capacities, or ends early, or is damaged.
pub fn replay<C: Capacity, R: Read>(
    log: &mut Reader<R>,
    scheduler: &mut Scheduler<C>,
    change: impl FnMut(&mut Scheduler<C>, u32, Instant) -> Result<(), CommitError>,
    mut watch: impl FnMut(&Scheduler<C>, &Entry),
) -> Result<Replay, Broken> {
    replay_events(log, scheduler, change, |scheduler, entry, _| watch(scheduler, entry))
}

/// As [`replay`]; `watch` sees what the scheduler recorded at each entry, too.
///
/// # Errors
/// As [`replay`].
pub fn replay_events<C: Capacity, R: Read>(
    log: &mut Reader<R>,
    scheduler: &mut Scheduler<C>,
    mut change: impl FnMut(&mut Scheduler<C>, u32, Instant) -> Result<(), CommitError>,
    mut watch: impl FnMut(&Scheduler<C>, &Entry, &[Event]),
) -> Result<Replay, Broken> {
    let (found, expected) = (log.header().capacities, Header::capacities_of::<C>());
    if found != expected {
        let error = LogError::Capacities { found, expected };
        return Err(Broken { error, inputs: 0, actions: 0 });
    }
    let mut done = Replay { inputs: 0, actions: 0, difference: None };
    let mut before = VecDeque::with_capacity(CONTEXT);
    let mut events = Vec::new();
    // Here there is time to ask for the members of every unit.
    let mut so_far = SoFar { starts: Starts::new(true), parts: Parts::default() };
    loop {
        let (inputs, actions) = (done.inputs, done.actions);
        let Some(entry) = log.next_entry().map_err(|error| Broken { error, inputs, actions })? else {
            return Ok(done);
        };
        done.inputs += 1;
        let now = so_far.feed(scheduler, &entry, &mut change);
        let now = now.ok_or_else(|| Broken { error: log.no_graph(), inputs, actions })?;
        // No answer depends on them.
        events.clear();
        while let Some(event) = scheduler.take_event() {
            events.push(*event);
        }
        if now != entry.answer {
            let before = before.into_iter().collect();
            done.difference = Some(Difference { input: done.inputs, before, recorded: entry, now });
            return Ok(done);
        }
        done.actions += u64::from(now.is_action());
        watch(scheduler, &entry, &events);
        if before.len() == CONTEXT {
            before.pop_front();
        }
        before.push_back(entry);
    }
}

/// Feeds a log that needs no workload to `scheduler`, which is configured as the recorded one was; whatever it held is
/// forgotten. The caller chooses the capacities by those of the header ([`with_class`](crate::class::with_class)).
///
/// # Errors
/// As [`replay`]; [`LogError::NotByCalls`]: it needs a workload.
pub fn replay_calls<C: Capacity, R: Read>(
    log: &mut Reader<R>,
    scheduler: &mut Scheduler<C>,
    mut watch: impl FnMut(&Scheduler<C>, &Entry),
) -> Result<Replay, Broken> {
    replay_calls_events(log, scheduler, |scheduler, entry, _| watch(scheduler, entry))
}

/// As [`replay_calls`]; `watch` sees what the scheduler recorded at each entry, too.
///
/// # Errors
/// As [`replay_calls`].
pub fn replay_calls_events<C: Capacity, R: Read>(
    log: &mut Reader<R>,
    scheduler: &mut Scheduler<C>,
    watch: impl FnMut(&Scheduler<C>, &Entry, &[Event]),
) -> Result<Replay, Broken> {
    let no_workload = Broken { error: LogError::NotByCalls, inputs: 0, actions: 0 };
    scheduler.configure(log.header().config.ok_or(no_workload)?);
    // Nobody knows what a number stands for.
    replay_events(log, scheduler, |_, _, _| Err(CommitError::UnknownTask), watch)
}

/// What entries before the next one left.
struct SoFar {
    starts: Starts,
    parts: Parts,
}

impl SoFar {
    /// What the scheduler answers now. `None`: the parts of a graph before the entry, or in it, are of none.
    fn feed<C: Capacity>(
        &mut self,
        scheduler: &mut Scheduler<C>,
        entry: &Entry,
        change: &mut impl FnMut(&mut Scheduler<C>, u32, Instant) -> Result<(), CommitError>,
    ) -> Option<Answer> {
        let now = entry.now;
        self.starts.told(&entry.call);
        let parts = self.parts.before(&entry.call)?;
        Some(match entry.call {
            Call::Release { task, at, capture } => {
                Answer::Released(scheduler.release_at(task, at, capture, now))
            }
            Call::Complete(unit) => Answer::Reported(scheduler.complete(unit, now)),
            Call::Fail(unit) => Answer::Reported(scheduler.fail(unit, now)),
            Call::Poll(None) => {
                let action = scheduler.poll(now);
                Answer::of_poll(scheduler, action, &mut self.starts)
            }
            Call::Poll(Some(lane)) => {
                let action = scheduler.poll_on(lane, now);
                Answer::of_poll(scheduler, action, &mut self.starts)
            }
            Call::TakeOutcome => scheduler.take_outcome().map_or(Answer::Nothing, Answer::Ended),
            Call::Edit(number) => Answer::Edited(change(scheduler, number, now)),
            Call::Retire(lane) => Answer::Done(scheduler.retire_lane(lane)),
            Call::Restore(lane) => Answer::Done(scheduler.restore_lane(lane)),
            Call::StoodStill(time) => {
                scheduler.stood_still(time, now);
                Answer::Nothing
            }
            Call::Remove(task) => Answer::Done(scheduler.remove_task(task, now)),
            Call::AddPool { lanes, memory } => Answer::Pool(scheduler.add_pool(lanes, memory)),
            Call::DispatchAhead(pool) => Answer::Done(scheduler.dispatch_ahead(pool)),
            Call::ObserveUse(pool, used) => Answer::Done(scheduler.observe_use(pool, used)),
            Call::LosePool(pool) => Answer::Done(scheduler.lose_pool(pool, now)),
            Call::AddSensor(period) => Answer::Sensor(scheduler.add_sensor(period)),
            Call::Node { .. } | Call::Edges { .. } => Answer::Nothing,
            Call::AddTask { deadline, period, value, floor: [m, k] } => {
                let timing = Timing::new(deadline).value(value).floor(m.into(), k.into());
                let timing = period.map_or(timing, |period: Duration| timing.every(period));
                Answer::Task(scheduler.add_task(&parts.onto(Dag::new())?, timing))
            }
            Call::Commit { task, revision } => Answer::Committed(match scheduler.edit(task) {
                // These two are refused before anybody looks at the graph, which then is of no version that there is.
                None => Err(CommitError::UnknownTask),
                Some(newest) if newest.origin().1 != revision => Err(CommitError::Conflict),
                Some(newest) => scheduler.commit(&parts.onto(newest)?, now),
            }),
            Call::End => Answer::End(End::of(scheduler, &self.starts)),
        })
    }
}
