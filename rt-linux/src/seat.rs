//! Where a lane is handed its next unit: one cache line, that moves once while the lane is awake.
//!
//! # Protocol
//!
//! The holder of the scheduler's lock writes the work, then the unit, and wakes the lane if it sleeps. The lane
//! compares the unit with the last one that it took: another one is new, because no handle comes twice. So taking
//! stores nothing in the line, and the next hand-off finds it where the lane left it.
//!
//! # Why no work is overwritten before it was read
//!
//! The scheduler gives a lane its next unit only after the lane reported the last one, which it does under the
//! lock and after it read the work. There is one exception: a lane whose body hung is retired and gets a spare
//! thread. Nothing is handed to it until the spare has discarded what was there, under the lock. A thread that came
//! back late and was reading then has either taken the unit before, and so has read it, or takes it no more.

use crate::bell::{Bell, Woken};
use crate::handler::Work;
use crate::primitive::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use crate::sleeper::Sleeper;
use red_core::{NodeId, PoolId, TaskId, UnitId};

/// A lane's place. One thread at a time hands, and not before the unit of the time before was reported; only
/// the lane takes.
///
/// ```
/// use red_core::UnitId;
/// use red_rt::{handler::Work, seat::Seat};
/// let (seat, work) = (Seat::default(), Work { unit: UnitId::from_bits(7 << 16), ..Work::default() });
/// assert_eq!(seat.take(), None);
/// seat.hand(&work);
/// assert_eq!(seat.take(), Some(work));
/// assert_eq!(seat.take(), None); // once
/// ```
#[derive(Debug, Default)]
#[repr(C, align(128))]
pub struct Seat {
    // The line of the hand-off: 64 bytes, written by who hands and read by the lane.
    /// Wakes the lane.
    pub bell: Bell,
    /// The task's place, node, pool and output in 8, 8, 5 and 11 bits. The lane is in the unit's name.
    place: AtomicU32,
    unit: AtomicU64,
    /// The job in the low [`JOB_BITS`], above them which of those that had its place the task is.
    job: AtomicU64,
    times: [AtomicU64; 5],
    // What everybody reads and hardly anybody writes.
    /// The watchdog saw the body run past its bound.
    pub overdue: AtomicBool,
    /// How often the lane got another thread.
    pub threads: AtomicU64,
    own: Own,
}

/// As many as a unit's number has.
const JOB_BITS: u32 = 48;

/// What the lane alone writes, on lines that nobody else touches while all goes well.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Own {
    /// The unit that the lane gave itself last.
    kept: AtomicU64,
    /// The unit that was handed and taken last.
    taken: AtomicU64,
}

impl Seat {
    /// Hands the lane a unit; 0 is none. One system call if the lane sleeps, none otherwise.
    pub fn hand(&self, work: &Work) {
        self.write(work);
        // Release: partner of the Acquire in `take`, so that the work is there.
        self.unit.store(work.unit.to_bits(), Ordering::Release);
        self.bell.wake();
    }

    /// The unit that was handed, once.
    pub fn take(&self) -> Option<Work> {
        // Acquire: partner of the Release below. A thread that sees what another of its lane took must not see an older
        // unit than that, which would look new.
        let taken = self.own.taken.load(Ordering::Acquire);
        // Acquire: partner of the Release in `hand`.
        let unit = self.unit.load(Ordering::Acquire);
        if unit == taken {
            return None;
        }
        let work = self.read(UnitId::from_bits(unit));
        // Only one of a lane's threads wins. Release: partner of the Acquire above, and of that in `discard`, after which
        // the work may be overwritten; as no load of ours may take effect after that, this is about load buffering.
        let won = self.own.taken.compare_exchange(taken, unit, Ordering::Release, Ordering::Relaxed);
        won.is_ok().then_some(work)
    }

    /// Sleeps until there may be a unit to take, the lane is rung for another reason, or `until` (nanoseconds of
    /// `CLOCK_MONOTONIC`) less the spin lead has come; all as in [`Sleeper::sleep`].
    pub fn sleep(&self, sleeper: &mut Sleeper, until: Option<u64>, spin_ns: u64) -> Woken {
        sleeper.sleep(&self.bell, self.is_handed(), until, spin_ns)
    }

    /// Spins until there may be a unit to take, the lane is rung for another reason, or `until_ns` has come.
    pub fn spin(&self, until_ns: u64) -> Woken {
        self.bell.spin(self.is_handed(), until_ns)
    }

    /// Whether there is a unit to take.
    fn is_handed(&self) -> impl Fn() -> bool {
        let taken = self.own.taken.load(Ordering::Relaxed);
        // Relaxed: `take` acquires.
        move || self.unit.load(Ordering::Relaxed) != taken
    }

    /// The unit that was handed and not taken yet.
    pub(crate) fn waiting(&self) -> Option<UnitId> {
        // Relaxed: a guess, for who only wakes the lane.
        let unit = self.unit.load(Ordering::Relaxed);
        (unit != self.own.taken.load(Ordering::Relaxed)).then_some(UnitId::from_bits(unit))
    }

    /// Whatever was handed so far is not to be run any more. To be called under the scheduler's lock.
    pub fn discard(&self) {
        // Acquire: partner of the Release in `take`, against load buffering. Release: partner of the Acquire in `take`.
        self.own.taken.swap(self.unit.load(Ordering::Relaxed), Ordering::AcqRel);
    }

    /// Whether the lane still belongs to the thread of this number.
    pub fn is_of(&self, thread: u64) -> bool {
        // Relaxed: nothing is published with it.
        self.threads.load(Ordering::Relaxed) == thread
    }

    /// The lane gave itself a unit.
    pub fn keep(&self, unit: UnitId) {
        self.own.kept.store(unit.to_bits(), Ordering::Relaxed);
    }

    /// The unit that the lane was last given, for whoever has to fail it when its body does not return. To be
    /// called under the scheduler's lock, under which both words are written.
    pub fn running(&self) -> UnitId {
        // The scheduler numbers units upwards, in the high bits.
        let (unit, kept) = (self.unit.load(Ordering::Relaxed), self.own.kept.load(Ordering::Relaxed));
        UnitId::from_bits(unit.max(kept))
    }

    fn write(&self, work: &Work) {
        // A capacity has at most 255 tasks, 256 nodes and outputs, and 32 pools.
        let output = work.output.map_or(0, |output| u32::from(output) + 1);
        let (node, pool) = (work.node.index() as u32, work.pool.index() as u32);
        let task = work.task.to_bits();
        self.place.store(task << 24 | node << 16 | pool << 11 | output, Ordering::Relaxed);
        let job = work.job & ((1 << JOB_BITS) - 1) | u64::from(task >> 16) << JOB_BITS;
        self.job.store(job, Ordering::Relaxed);
        let times = [work.release_ns, work.deadline_ns, work.since_ns, work.sub_deadline_ns, work.wcet_ns];
        for (slot, time) in self.times.iter().zip(times) {
            slot.store(time, Ordering::Relaxed);
        }
    }

    fn read(&self, unit: UnitId) -> Work {
        let (place, job) = (self.place.load(Ordering::Relaxed), self.job.load(Ordering::Relaxed));
        let time = |i: usize| self.times[i].load(Ordering::Relaxed);
        Work {
            unit,
            task: TaskId::from_bits(((job >> JOB_BITS) as u32) << 16 | place >> 24),
            node: NodeId::new((place >> 16) as u8),
            pool: PoolId::new((place >> 11) as u8 & 0x1f),
            output: (place as u16 & 0x7ff).checked_sub(1),
            job: job & ((1 << JOB_BITS) - 1),
            release_ns: time(0),
            deadline_ns: time(1),
            since_ns: time(2),
            sub_deadline_ns: time(3),
            wcet_ns: time(4),
        }
    }
}

#[cfg(test)]
mod tests;
