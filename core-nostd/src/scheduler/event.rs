//! The event record: what happened, when, to whom. A ring of `C::EVENTS`; when it is full the newest event is
//! dropped and counted, so that what is kept is a gapless beginning.

use super::{Scheduler, action::ShedReason};
use crate::capacity::{Capacity, Empty};
use crate::id::{LaneId, NodeId, TaskId};
use crate::time::Instant;

crate::capacity::values! {
    /// What happened.
    #[repr(u8)] // The first one is zero bits, which a niche of the reason would not be.
    #[non_exhaustive]
    pub enum EventKind {
        /// A job was released.
        Released,
        /// A release found no place.
        Refused,
        /// A sub-job started on `lane`; each member of a unit has its own event.
        Started,
        /// A sub-job that ran on `lane` completed.
        Completed,
        /// An encoder completed without executing: its result was there.
        Hit,
        /// A sub-job lost its lane to a smaller key.
        Preempted,
        /// A sub-job took longer than its WCET.
        Overran,
        /// All nodes of a job completed.
        Ended,
        /// A job was given up.
        Shed(ShedReason),
        /// A task has a new graph.
        Edited,
        /// A kept result was thrown away for memory.
        Evicted,
        /// A job will miss its deadline, as far as is known now: [`take_warning`](Scheduler::take_warning) says by how
        /// much and because of whom.
        Warned,
    }

    /// One event. Fields that do not apply are 0.
    pub struct Event {
        /// When.
        pub at: Instant,
        /// Which job of the task, from 0.
        pub job: u64,
        /// What.
        pub kind: EventKind,
        /// Whose.
        pub task: TaskId,
        /// Which node.
        pub node: NodeId,
        /// Which lane.
        pub lane: LaneId,
    }
}

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Record<C: Capacity> {
        ring: C::Events<Event>,
        /// Events ever kept and ever taken, and how many may be kept until the next is taken.
        kept: u64,
        taken: u64,
        limit: u64,
        pub(super) dropped: u64,
    }
}

impl<C: Capacity> Record<C> {
    fn place(count: u64) -> usize {
        (count % C::EVENTS.max(1) as u64) as usize
    }

    /// To be called once, on a record that is empty.
    pub(super) const fn open(&mut self) {
        self.limit = C::EVENTS as u64;
    }

    #[inline(always)]
    fn push(&mut self, event: Event) {
        match self.ring.as_mut().get_mut(Self::place(self.kept)) {
            _ if C::EVENTS == 0 => {}
            Some(free) if self.kept != self.limit => {
                *free = event;
                self.kept += 1;
            }
            _ => self.dropped += 1,
        }
    }

    #[inline]
    pub(super) fn take(&mut self) -> Option<&Event> {
        let taken = self.taken;
        if taken == self.kept {
            return None;
        }
        self.taken += 1;
        self.limit += 1;
        self.ring.as_ref().get(Self::place(taken))
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Records an event of a sub-job, given by its rank.
    pub(super) fn note(&mut self, kind: EventKind, slot: usize, rank: usize, lane: usize) {
        self.note_node(kind, slot, NodeId::new(self.version(slot).order[rank]), lane);
    }

    /// Records an event of a sub-job whose node is known.
    pub(super) fn note_node(&mut self, kind: EventKind, slot: usize, node: NodeId, lane: usize) {
        let (job, lane) = (&self.jobs[slot], LaneId::new(lane as u8));
        self.record.push(Event { at: self.now, job: job.index, kind, task: job.task, node, lane });
    }

    /// Records an event of a job, or of a task (`job` 0).
    pub(super) fn note_task(&mut self, kind: EventKind, task: usize, job: u64) {
        let task = TaskId::new(task, self.tasks[task].generation);
        self.record.push(Event { at: self.now, job, kind, task, ..Event::EMPTY });
    }
}
