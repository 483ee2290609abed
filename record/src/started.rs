//! A unit that started, and whose it is. Its name has neither job nor members: two jobs of one task have the same nodes.

use red_core::{Capacity, JobId, Scheduler, Unit, UnitId};

/// Places for results of encoders at most.
const PLACES: usize = 255;

/// A unit that started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Started {
    /// The unit.
    pub unit: UnitId,
    /// The job of its first member, whose body runs.
    pub job: JobId,
    /// All its members, where it has several.
    pub members: Option<Members>,
}

/// Sub-jobs that share one execution. A place is that of one job as long as that is in flight, so the places say which
/// jobs they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Members {
    /// Places of their jobs, a bit each.
    pub jobs: u64,
    /// Their nodes in the order of `Scheduler::members`, each plus one, as the digits of a number to the base of 257: up
    /// to seven are told apart whatever they are, of more the number is a checksum.
    pub nodes: u64,
}

impl Started {
    /// What this unit is, which the scheduler started just now. Only encoders share an execution, and what writes or reads
    /// no result is none, unless the places for results were `full` once; so most units are not asked for their members,
    /// which would cost more than all the rest of recording.
    #[inline(always)]
    pub(crate) fn of<C: Capacity>(scheduler: &Scheduler<C>, unit: UnitId, full: &mut bool) -> Self {
        let Some(Unit { first, output, .. }) = scheduler.unit(unit) else {
            return Self { unit, job: JobId::default(), members: None };
        };
        let mut members = None;
        if output.is_some() | *full {
            // The lowest free place is taken, so the last one comes before there is none.
            *full |= output.is_some_and(|place| usize::from(place) + 1 >= C::NODES.min(PLACES));
            members = Members::of(scheduler, unit);
        }
        Self { unit, job: first.job, members }
    }
}

impl Members {
    /// Those of a unit; `None` where it is alone.
    #[inline(never)]
    fn of<C: Capacity>(scheduler: &Scheduler<C>, unit: UnitId) -> Option<Self> {
        scheduler.config().merge_skew?;
        scheduler.members(unit).nth(1)?;
        let mut all = Self { jobs: 0, nodes: 0 };
        for member in scheduler.members(unit) {
            // A scheduler has 64 places at most.
            all.jobs |= 1 << (member.job.index() % 64);
            all.nodes = all.nodes.wrapping_mul(257).wrapping_add(member.node.index() as u64 + 1);
        }
        Some(all)
    }
}
