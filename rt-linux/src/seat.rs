//! Where a lane is handed its next unit: one store, and a ring if the lane sleeps.

use crate::bell::Bell;
use crate::handler::Work;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use red_core::{NodeId, UnitId};

/// A lane's place. Only the holder of the scheduler's lock hands, only the lane takes.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(crate) struct Seat {
    unit: AtomicU64,
    /// The unit that the lane runs, for whoever has to fail it when its body does not return.
    running: AtomicU64,
    work: [AtomicU64; 7],
    pub(crate) bell: Bell,
    /// The watchdog saw the body run past its bound.
    pub(crate) overdue: AtomicBool,
    /// How often the lane got another thread.
    pub(crate) threads: AtomicU64,
}

impl Seat {
    pub(crate) fn hand(&self, unit: UnitId, work: &Work) {
        self.write(work);
        self.running.store(unit.to_bits(), Ordering::Relaxed);
        // Release: pairs with the Acquire in `take`, so that the work is there.
        self.unit.store(unit.to_bits(), Ordering::Release);
        self.bell.ring();
    }

    /// The unit that was handed, once.
    pub(crate) fn take(&self) -> Option<(UnitId, Work)> {
        if self.unit.load(Ordering::Relaxed) == 0 {
            return None;
        }
        // Acquire: pairs with the Release in `hand`.
        let unit = self.unit.swap(0, Ordering::Acquire);
        (unit != 0).then(|| (UnitId::from_bits(unit), self.read()))
    }

    /// The lane gave itself a unit.
    pub(crate) fn keep(&self, unit: UnitId) {
        self.running.store(unit.to_bits(), Ordering::Relaxed);
    }

    /// The unit that the lane was last given.
    pub(crate) fn running(&self) -> UnitId {
        UnitId::from_bits(self.running.load(Ordering::Relaxed))
    }

    fn write(&self, work: &Work) {
        let output = work.output.map_or(0, |o| u64::from(o) + 1);
        let place = (work.task as u64) << 32 | (work.node.index() as u64) << 20 | output;
        let words = [
            place,
            work.job,
            work.release_ns,
            work.deadline_ns,
            work.since_ns,
            work.sub_deadline_ns,
            work.wcet_ns,
        ];
        for (slot, word) in self.work.iter().zip(words) {
            slot.store(word, Ordering::Relaxed);
        }
    }

    fn read(&self) -> Work {
        let word = |i: usize| self.work[i].load(Ordering::Relaxed);
        let place = word(0);
        Work {
            task: (place >> 32) as usize,
            node: NodeId::new((place >> 20) as u8),
            output: ((place & 0xf_ffff) as u16).checked_sub(1),
            job: word(1),
            release_ns: word(2),
            deadline_ns: word(3),
            since_ns: word(4),
            sub_deadline_ns: word(5),
            wcet_ns: word(6),
        }
    }
}
