//! Early warning: a job that will miss its deadline is told of as soon as that is known, and because of whom.
//!
//! *Rule.* A job is warned of once: when the forward schedule ends it late, when it goes so that another is in time, or
//! when it is lost for certain. A slot keeps its warning until it is taken, or until another job has the slot.

use super::{Scheduler, bits, event::EventKind, forward::Forward, standing::Standing};
use crate::capacity::Capacity;
use crate::id::{JobId, TaskId};
use crate::time::{Duration, Instant};

crate::capacity::values! {
    /// A predicted deadline miss.
    pub struct Warning {
        /// The job; it is given up already where its outcome says so.
        pub job: JobId,
        /// Its task.
        pub task: TaskId,
        /// The index of the job in its task, from 0.
        pub index: u64,
        /// When it is due.
        pub deadline: Instant,
        /// How long after that it would end, by the estimates of now, and where it is lost for certain by best cases; in whole
        /// microseconds, rounded up. The longest time: it never ends, or more than an hour later. 0: it would not be late, but
        /// goes so that the other job is in time.
        pub by: Duration,
        /// Task and index of the job that takes the lanes it needs. `None`: it is late on its own.
        pub because: Option<(TaskId, u64)>,
    }
}

crate::capacity::stored! {
    /// What a job was warned of.
    #[derive(Clone, Copy, Debug)]
    #[repr(Rust, packed(2))] // Jobs hold many of these: more would pad each.
    pub(super) struct Late {
        /// In microseconds, rounded up; the largest number where it never ends.
        by: u32,
        /// Slot of the job that is in its way plus one; 0 is nobody.
        because: u8,
        /// Whether the job was warned of.
        is_known: bool,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Takes one warning. Warnings are known since the last `poll` or, where all lanes were busy, since the last event: take them after
    /// these and before the next release, because a job that takes the slot of a warned one takes its warning's place too. A release into a full table may do so in the
    /// call in which it was warned of. Only `Shed::Hopeless` looks
    /// ahead; other configurations never warn. Time bound: O(1).
    pub fn take_warning(&mut self) -> Option<Warning> {
        let slot = bits(self.warnings).next()?;
        self.warnings &= !(1 << slot);
        let (job, late) = (&self.jobs[slot], self.jobs[slot].late);
        let because = usize::from(late.because).checked_sub(1).map(|cause| {
            let cause = &self.jobs[cause];
            (cause.task, cause.index)
        });
        let by = if late.by == u32::MAX {
            Duration::from_nanos(u64::MAX)
        } else {
            Duration::from_micros(late.by.into())
        };
        let (task, index, deadline) = (job.task, job.index, job.deadline);
        Some(Warning { job: self.id_in(slot), task, index, deadline, by, because })
    }

    /// Another job takes a slot: what was to be told of the last one is not told any more.
    pub(super) fn forget_warnings_of(&mut self, slot: usize) {
        self.warnings &= !(1 << slot);
        for other in bits(self.warnings) {
            let because = &mut self.jobs[other].late.because;
            *because = if usize::from(*because) == slot + 1 { 0 } else { *because };
        }
    }

    /// The job that is, or was last, in a slot.
    fn id_in(&self, slot: usize) -> JobId {
        let is_taken = (self.in_flight | self.ended) >> slot & 1 != 0;
        // The generation goes on when an outcome is taken.
        JobId::new(slot, self.jobs[slot].generation.wrapping_sub(u16::from(!is_taken)))
    }

    /// A job will end so late because of another one, unless that was known.
    pub(super) fn warn(&mut self, slot: usize, by: u64, because: Option<usize>) {
        if self.is_warned_of(slot) {
            return;
        }
        let by = u32::try_from(by.div_ceil(1_000)).unwrap_or(u32::MAX);
        self.jobs[slot].late =
            Late { by, because: because.map_or(0, |cause| cause as u8 + 1), is_known: true };
        self.warnings |= 1 << slot;
    }

    /// Whether it was told, or is to be told, that a job will be late.
    pub(super) fn is_warned_of(&self, slot: usize) -> bool {
        self.jobs[slot].late.is_known
    }

    /// A job need not go after all.
    pub(super) fn withdraw_warning(&mut self, slot: usize) {
        self.warnings &= !(1 << slot);
        self.jobs[slot].late.is_known = false;
    }

    /// Records the warnings that were added to some.
    pub(super) fn note_warnings(&mut self, before: u64) {
        for slot in bits(self.warnings & !before) {
            let (task, index) = (self.jobs[slot].task.index(), self.jobs[slot].index);
            self.note_task(EventKind::Warned, task, index);
        }
    }

    /// Because of whom a job is late in a forward schedule: of those in its way the one that goes last, and where
    /// there is none, the one that holds a lane it needs for the longest time.
    pub(super) fn cause_of(
        &self,
        slot: usize,
        forward: &Forward<C>,
        among: u64,
        standings: &C::Jobs<Option<Standing>>,
    ) -> Option<usize> {
        let others = among & !(1 << slot);
        let in_the_way = forward.in_the_way(slot, others);
        let holds = |lane: usize| {
            let members = self.lanes[lane].members & others;
            let is_needed = forward.needs(slot, 1 << self.lanes[lane].pool);
            bits(members).next().filter(|_| is_needed).map(|other| (self.left_on(lane), other))
        };
        let holders = (0..self.lanes()).filter(|lane| self.lanes[*lane].is_busy()).filter_map(holds);
        bits(in_the_way)
            .max_by_key(|other| standings[*other])
            .or_else(|| holders.max().map(|(_, other)| other))
    }
}
