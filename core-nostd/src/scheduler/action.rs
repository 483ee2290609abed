//! What the host has to do.

use crate::id::{JobId, LaneId, TaskId, UnitId};
use crate::time::{Instant, SignedDuration};

/// One answer of `poll`.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Action {
    /// Start this unit on its lane, and report it with `complete` or `fail`.
    Dispatch(Dispatch),
    /// Take the lane from this unit; `suspend` was applied already. Only under `Config::preempt`.
    Preempt(Dispatch),
    /// Give this unit to its lane, which starts it after what it runs and after
    /// [`waits_for`](crate::Scheduler::waits_for); report it as any other, in the order of its lane. Only in pools that
    /// [dispatch ahead](crate::Scheduler::dispatch_ahead).
    Ahead(Dispatch),
    /// A job ended. Nothing is left to do for it, but a lane that still runs one of its units must report.
    Ended(Outcome),
}

crate::capacity::values! {
    /// A unit and its lane. Ask [`Scheduler::unit`](crate::Scheduler::unit) for what it is.
    pub struct Dispatch {
        /// Handle for `complete` and `fail`.
        pub unit: UnitId,
        /// Where it runs.
        pub lane: LaneId,
    }

    /// How a job ended.
    pub struct Outcome {
        /// The job; its place may be reused from now on.
        pub job: JobId,
        /// Its task.
        pub task: TaskId,
        /// The how-manieth job of its task, from 0.
        pub index: u64,
        /// When it was released.
        pub release: Instant,
        /// When it was due.
        pub deadline: Instant,
        /// When it ended.
        pub at: Instant,
        /// `None`: all its nodes completed. Otherwise it was given up.
        pub shed: Option<ShedReason>,
    }
}

impl Outcome {
    /// Finish less deadline; negative when early.
    pub const fn lateness(&self) -> SignedDuration {
        self.at.minus(self.deadline)
    }

    /// Whether all nodes completed by the deadline.
    pub const fn on_time(&self) -> bool {
        self.shed.is_none() && self.at.as_nanos() <= self.deadline.as_nanos()
    }
}

crate::capacity::values! {
    /// Why a job was given up.
    #[repr(u8)]
    pub enum ShedReason {
        /// Not even its best case could end by the deadline.
        Hopeless = 1,
        /// Another job would have been late beside it.
        Overload,
        /// Lasting overload under the paper's rule; it had the lowest urgency.
        Urgency,
        /// No place for another job: at its own release, or at that of a job of a higher rank.
        Full,
        /// It was past its deadline, and the late policy is to abort.
        Late,
        /// One of its nodes failed.
        Fault,
        /// Its task was removed.
        Removed,
    }
}

impl ShedReason {
    /// The word that programs read.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hopeless => "hopeless",
            Self::Overload => "overload",
            Self::Urgency => "urgency",
            Self::Full => "full",
            Self::Late => "late",
            Self::Fault => "fault",
            Self::Removed => "removed",
        }
    }
}
