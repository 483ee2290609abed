//! A unit that started, and whose it is. Its name has neither job nor members: two jobs of one task have the same nodes.

use crate::entry::Call;
use crate::words::Told;
use red_core::{Capacity, JobId, Member, Scheduler, Unit, UnitId};

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

/// What is known of all starts so far.
#[derive(Debug)]
pub(crate) struct Starts {
    /// Whether units are asked for their members even if no result is involved: the places for results were full once.
    pub(crate) full: bool,
    sum: u64,
}

impl Starts {
    pub(crate) const fn new(full: bool) -> Self {
        Self { full, sum: 0 }
    }

    /// A checksum of what a host was told with each start beyond what an entry has: where its result is, how long it may
    /// take, and by when it should end.
    pub(crate) const fn sum(&self) -> u64 {
        self.sum
    }

    /// The host set something up. Of most of it no answer tells whether it was the same, so it is in the checksum.
    pub(crate) fn told(&mut self, call: &Call) {
        let words = Told::of(call);
        words
            .iter()
            .flat_map(Told::words)
            .for_each(|word| self.sum = folded(self.sum ^ FIRST, word ^ SECOND));
    }

    /// Two multiplications, the one of which does not wait for the start before.
    #[inline(always)]
    const fn add(&mut self, id: UnitId, unit: &Unit) {
        let Unit { first: Member { job, sub_deadline, .. }, wcet, output, .. } = *unit;
        // An output is below 2^16 and a number of its own if there is none.
        let output = if let Some(output) = output { output as u64 + 1 } else { 0 };
        let times = folded(wcet.as_nanos() ^ FIRST, sub_deadline.as_nanos() ^ SECOND);
        self.sum = folded(self.sum ^ id.to_bits(), times ^ (output << 32 | job.to_bits() as u64));
    }
}

/// Digits of pi, so that what is usual, small numbers and zero, is no factor.
const FIRST: u64 = 0x243F_6A88_85A3_08D3;
const SECOND: u64 = 0x1319_8A2E_0370_7344;

/// Every bit of both in every bit.
const fn folded(one: u64, other: u64) -> u64 {
    let product = one as u128 * other as u128;
    product as u64 ^ (product >> 64) as u64
}

impl Started {
    /// What this unit is, which the scheduler started just now; asked once for each start, as the checksum is. Only encoders
    /// share an execution, and what writes or reads no result is none, unless the places for results were `full` once; so
    /// most units are not asked for their members, which would cost more than all the rest of recording.
    #[inline(always)]
    pub(crate) fn of<C: Capacity>(scheduler: &Scheduler<C>, unit: UnitId, starts: &mut Starts) -> Self {
        let Some(known) = scheduler.unit(unit) else {
            return Self { unit, job: JobId::default(), members: None };
        };
        starts.add(unit, &known);
        let Unit { first, output, .. } = known;
        let mut members = None;
        if output.is_some() | starts.full {
            // The lowest free place is taken, so the last one comes before there is none.
            starts.full |= output.is_some_and(|place| usize::from(place) + 1 >= C::NODES.min(PLACES));
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
