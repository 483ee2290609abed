//! One input of the scheduler and what it answered.

use crate::started::{Started, Starts};
use core::fmt;
use red_core::{
    Action, AddTaskError, Bytes, Capacity, Certificate, CommitError, CompleteError, Counters, Duration,
    Instant, JobId, LaneId, Node, NodeId, Outcome, PoolError, PoolId, Ppm, ReleaseError, Role, Scheduler,
    SensorError, SensorId, TaskId, UnitId,
};

/// A call on the scheduler. Its time is that of the [`Entry`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// `release_at`.
    Release {
        /// Whose job.
        task: TaskId,
        /// When it was released.
        at: Instant,
        /// The frame that it reads.
        capture: Option<u64>,
    },
    /// `complete`.
    Complete(UnitId),
    /// `fail`.
    Fail(UnitId),
    /// `poll_on` for this lane, or `poll`.
    Poll(Option<LaneId>),
    /// `take_outcome`, where there was one.
    TakeOutcome,
    /// `edit` and `commit` of the host's change of this number.
    Edit(u32),
    /// `retire_lane`.
    Retire(LaneId),
    /// `restore_lane`.
    Restore(LaneId),
    /// `remove_task`.
    Remove(TaskId),
    /// `stood_still`, for so long.
    StoodStill(Duration),
    /// `add_pool`.
    AddPool {
        /// How many lanes.
        lanes: u8,
        /// Its memory budget.
        memory: Option<Bytes>,
    },
    /// `dispatch_ahead`.
    DispatchAhead(PoolId),
    /// `lose_pool`.
    LosePool(PoolId),
    /// `observe_use`.
    ObserveUse(PoolId, Ppm),
    /// `add_sensor`, with its period.
    AddSensor(Duration),
    /// No call: a node of the graph of the next `AddTask` or `Commit`.
    Node {
        /// Its place.
        place: NodeId,
        /// What it is.
        node: Node,
    },
    /// No call: edges of that graph, after the node that they leave.
    Edges {
        /// The node.
        from: NodeId,
        /// Which 64 places: the first of them is 64 times this.
        group: u8,
        /// A bit for each of these places that one leads to.
        to: u64,
    },
    /// `add_task` of the graph before.
    AddTask {
        /// Relative deadline.
        deadline: Duration,
        /// Period.
        period: Option<Duration>,
        /// Value.
        value: u32,
        /// m and k of the floor.
        floor: [u8; 2],
    },
    /// `commit` of the graph before.
    Commit {
        /// Whose graph it is.
        task: TaskId,
        /// The number of commits after which it was begun.
        revision: u32,
    },
    /// No call: the end of the run, and what the scheduler was then. The last entry of every log.
    End,
}

/// What a call answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Of a release.
    Released(Result<JobId, ReleaseError>),
    /// Of a completion or failure.
    Reported(Result<(), CompleteError>),
    /// Of a poll, or of `take_outcome`: nothing is to be done. Of a part of a graph.
    Nothing,
    /// Of a poll: a unit starts.
    Started(Started),
    /// Of a poll: a unit is given to its lane and starts there later.
    Ahead(Started),
    /// Of a poll: a unit loses its lane.
    Preempted(UnitId),
    /// Of a poll, or of `take_outcome`: a job ended.
    Ended(Outcome),
    /// Of a poll: an action that this version of the format has no word for.
    Unknown,
    /// Of an edit.
    Edited(Result<(), CommitError>),
    /// Of the calls that answer yes or no.
    Done(bool),
    /// Of `add_pool`.
    Pool(Result<PoolId, PoolError>),
    /// Of `add_sensor`.
    Sensor(Result<SensorId, SensorError>),
    /// Of `add_task`.
    Task(Result<TaskId, AddTaskError>),
    /// Of `commit`.
    Committed(Result<Certificate, CommitError>),
    /// At the end.
    End(End),
}

/// How a run left its scheduler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// Its counters.
    pub counters: Counters,
    /// Jobs that had not ended.
    pub jobs_in_flight: u64,
    /// A checksum of every start: its unit and job, the number of its encoder's result, its worst-case execution time and
    /// its sub-deadline; and of everything that was set up by calls.
    pub starts: u64,
}

impl End {
    pub(crate) fn of<C: Capacity>(scheduler: &Scheduler<C>, starts: &Starts) -> Self {
        Self {
            counters: scheduler.counters(),
            jobs_in_flight: scheduler.jobs_in_flight() as u64,
            starts: starts.sum(),
        }
    }
}

/// An input with its time and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The time that the call was given; calls without one have that of the call before.
    pub now: Instant,
    /// The call.
    pub call: Call,
    /// What it answered.
    pub answer: Answer,
}

impl Call {
    /// The unit that it reports.
    #[must_use]
    pub const fn unit(&self) -> Option<UnitId> {
        match self {
            Self::Complete(unit) | Self::Fail(unit) => Some(*unit),
            _ => None,
        }
    }
}

impl Answer {
    /// What a poll of this scheduler answered just now.
    pub(crate) fn of_poll<C: Capacity>(
        scheduler: &Scheduler<C>,
        action: Option<Action>,
        starts: &mut Starts,
    ) -> Self {
        match action {
            None => Self::Nothing,
            Some(Action::Dispatch(dispatch)) => Self::Started(Started::of(scheduler, dispatch.unit, starts)),
            Some(Action::Ahead(dispatch)) => Self::Ahead(Started::of(scheduler, dispatch.unit, starts)),
            Some(Action::Preempt(dispatch)) => Self::Preempted(dispatch.unit),
            Some(Action::Ended(outcome)) => Self::Ended(outcome),
            Some(_) => Self::Unknown,
        }
    }

    /// The unit that it starts, gives or stops.
    #[must_use]
    pub const fn unit(&self) -> Option<UnitId> {
        match self {
            Self::Started(started) | Self::Ahead(started) => Some(started.unit),
            Self::Preempted(unit) => Some(*unit),
            _ => None,
        }
    }

    /// Whether the host has something to do.
    #[must_use]
    pub const fn is_action(&self) -> bool {
        matches!(
            self,
            Self::Started(_) | Self::Ahead(_) | Self::Preempted(_) | Self::Ended(_) | Self::Unknown
        )
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Release { task, at, capture } => {
                write!(f, "release task {} at {}", task.index(), Time(*at))?;
                capture.map_or(Ok(()), |capture| write!(f, " capture {capture}"))
            }
            Self::Complete(unit) => write!(f, "complete {}", Named(*unit)),
            Self::Fail(unit) => write!(f, "fail {}", Named(*unit)),
            Self::Poll(Some(lane)) => write!(f, "poll for lane {}", lane.index()),
            Self::Poll(None) => f.write_str("poll"),
            Self::TakeOutcome => f.write_str("take outcome"),
            Self::Edit(number) => write!(f, "edit {number}"),
            Self::Retire(lane) => write!(f, "retire lane {}", lane.index()),
            Self::StoodStill(time) => write!(f, "stood still for {} ns", time.as_nanos()),
            Self::Restore(lane) => write!(f, "restore lane {}", lane.index()),
            Self::Remove(task) => write!(f, "remove task {}", task.index()),
            Self::AddPool { lanes, memory } => {
                write!(f, "add pool of {lanes} lanes")?;
                memory.map_or(Ok(()), |bytes| write!(f, " and {} bytes", bytes.0))
            }
            Self::DispatchAhead(pool) => write!(f, "dispatch ahead in pool {}", pool.index()),
            Self::ObserveUse(pool, used) => write!(f, "observe {} ppm of pool {}", used.0, pool.index()),
            Self::LosePool(pool) => write!(f, "lose pool {}", pool.index()),
            Self::AddSensor(period) => write!(f, "add sensor of period {} ns", period.as_nanos()),
            Self::Node { place, node } => node_in(f, *place, node),
            Self::Edges { from, group, to } => {
                write!(f, "edges of node {} to", from.index())?;
                let places = (0..64u32).filter(|bit| to >> bit & 1 != 0);
                places.into_iter().try_for_each(|bit| write!(f, " {}", u32::from(*group) * 64 + bit))
            }
            Self::AddTask { deadline, .. } => write!(f, "add task of deadline {} ns", deadline.as_nanos()),
            Self::Commit { task, revision } => {
                write!(f, "commit to task {} what was begun after commit {revision}", task.index())
            }
            Self::End => f.write_str("end"),
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Released(Ok(job)) => write!(f, "job {:#x}", job.to_bits()),
            Self::Released(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Reported(Ok(())) | Self::Edited(Ok(())) => f.write_str("done"),
            Self::Reported(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Edited(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Nothing => f.write_str("nothing"),
            Self::Started(started) => started_unit(f, started),
            Self::Ahead(started) => {
                f.write_str("ahead: ")?;
                started_unit(f, started)
            }
            Self::Preempted(unit) => write!(f, "preempt {}", Named(*unit)),
            Self::Ended(outcome) => ended(f, outcome),
            Self::Unknown => f.write_str("an action that this version does not know"),
            Self::Pool(Ok(pool)) => write!(f, "pool {}", pool.index()),
            Self::Pool(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Sensor(Ok(sensor)) => write!(f, "sensor {}", sensor.index()),
            Self::Sensor(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Task(Ok(task)) => write!(f, "task {:#x}", task.to_bits()),
            Self::Task(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Committed(Ok(proof)) => write!(f, "{proof:?}"),
            Self::Committed(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Done(yes) => f.write_str(if *yes { "yes" } else { "no" }),
            Self::End(End { counters, jobs_in_flight, starts }) => {
                write!(f, "{counters:?}, jobs in flight {jobs_in_flight}, checksum of all starts {starts:#x}")
            }
        }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}  {} -> {}", Time(self.now), self.call, self.answer)
    }
}

fn node_in(f: &mut fmt::Formatter<'_>, place: NodeId, node: &Node) -> fmt::Result {
    let role = match node.role() {
        Role::Ordinary => "",
        Role::SharedEncoder(_) => ", encoder",
        Role::Decoder => ", decoder",
    };
    let (pool, wcet) = (node.pool().index(), node.wcet().as_nanos());
    write!(f, "node {}{role} of {wcet} ns in pool {pool}", place.index())
}

fn started_unit(f: &mut fmt::Formatter<'_>, started: &Started) -> fmt::Result {
    write!(f, "start {} of job {:#x}", Named(started.unit), started.job.to_bits())?;
    started.members.map_or(Ok(()), |all| {
        write!(f, ", members of the jobs in places {:#b}, their nodes {:#x}", all.jobs, all.nodes)
    })
}

fn ended(f: &mut fmt::Formatter<'_>, outcome: &Outcome) -> fmt::Result {
    write!(f, "job {} of task {} ended at {}", outcome.index, outcome.task.index(), Time(outcome.at))?;
    outcome.shed.map_or(Ok(()), |reason| write!(f, ", given up: {}", reason.name()))
}

struct Time(Instant);

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns", self.0.as_nanos())
    }
}

struct Named(UnitId);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(unit) = self;
        write!(
            f,
            "unit {} (node {}, lane {})",
            unit.to_bits() >> 16,
            unit.node().index(),
            unit.lane().index()
        )
    }
}

/// Time between two instants with its sign, in 64 bits whatever they are.
pub(crate) const fn back(now: Instant, then: Instant) -> u64 {
    let apart = now.as_nanos().wrapping_sub(then.as_nanos());
    // Small for both signs.
    apart << 1 ^ (if apart >> 63 == 1 { u64::MAX } else { 0 })
}

/// The reverse of [`back`].
pub(crate) const fn then(now: Instant, back: u64) -> Instant {
    let apart = back >> 1 ^ (if back & 1 == 1 { u64::MAX } else { 0 });
    Instant::from_nanos(now.as_nanos().wrapping_sub(apart))
}
