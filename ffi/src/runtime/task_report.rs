//! What became of the jobs of one task of a runtime.

use crate::boundary::{Growing, plain};
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use red_core::{Floor, Outcome, ShedReason, TaskId, Timing};

/// What became of a task's jobs so far. Begin with RED_TASK_REPORT_INIT.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_task_report {
    /// RED_TASK_REPORT_INIT sets it.
    pub struct_size: u32,
    /// RED_TASK_REPORT_INIT sets it.
    pub abi_version: u32,
    /// Jobs released. Those that are neither on time nor missed are in flight.
    pub released: u64,
    /// Jobs that completed by their deadlines.
    pub on_time: u64,
    /// Jobs that completed late or were given up.
    pub missed: u64,
    /// Jobs given up as RED_SHED_HOPELESS.
    pub hopeless: u64,
    /// Jobs given up as RED_SHED_OVERLOAD.
    pub overload: u64,
    /// Jobs given up as RED_SHED_URGENCY.
    pub urgency: u64,
    /// Jobs given up as RED_SHED_FULL, those that found no place at their release included.
    pub full: u64,
    /// Jobs given up as RED_SHED_LATE.
    pub late: u64,
    /// Jobs given up as RED_SHED_FAULT.
    pub fault: u64,
    /// Jobs given up as RED_SHED_REMOVED.
    pub removed: u64,
    /// Value of the jobs that were on time.
    pub value_on_time: u64,
    /// Value of all jobs released.
    pub value_released: u64,
    /// Jobs whose miss was predicted; red_runtime_take_warnings tells of each.
    pub warned: u64,
    /// Of a task with a floor: the fewest jobs that were on time in a window of floor_of consecutive ones. Jobs before the
    /// first and after the last count as on time. A window of more than 128 jobs is kept as a stricter one of 128, and judged
    /// as that.
    pub floor_worst: u32,
    /// 1: the task has no floor, or floor_worst is at least what it keeps. 0: it was broken.
    pub floor_kept: u32,
}
plain!(red_task_report {
    struct_size: u32,
    abi_version: u32,
    released: u64,
    on_time: u64,
    missed: u64,
    hopeless: u64,
    overload: u64,
    urgency: u64,
    full: u64,
    late: u64,
    fault: u64,
    removed: u64,
    value_on_time: u64,
    value_released: u64,
    warned: u64,
    floor_worst: u32,
    floor_kept: u32,
});
impl Growing for red_task_report {
    const LEAST: usize = 120;
}

const REASONS: usize = 7;

/// The same while lanes run: written under the scheduler's lock, read by anybody.
#[derive(Debug)]
pub(crate) struct TaskNotes {
    /// Its id in bits plus one; 0 where there was none.
    task: AtomicU64,
    released: AtomicU64,
    on_time: AtomicU64,
    late: AtomicU64,
    /// By reason.
    shed: [AtomicU64; REASONS],
    warned: AtomicU64,
    value: AtomicU64,
    /// m and k.
    floor: [AtomicU64; 2],
    /// The most jobs of a window that were lost.
    most_lost: AtomicU64,
    /// Whether no job of the task was told of yet.
    is_fresh: AtomicBool,
}

fn count(of: &AtomicU64) {
    of.fetch_add(1, Ordering::Relaxed);
}

fn read(of: &AtomicU64) -> u64 {
    of.load(Ordering::Relaxed)
}

impl TaskNotes {
    #[expect(clippy::declare_interior_mutable_const, reason = "each task has one of its own")]
    pub(crate) const NEW: Self = Self {
        task: AtomicU64::new(0),
        released: AtomicU64::new(0),
        on_time: AtomicU64::new(0),
        late: AtomicU64::new(0),
        shed: [const { AtomicU64::new(0) }; REASONS],
        warned: AtomicU64::new(0),
        value: AtomicU64::new(0),
        floor: [const { AtomicU64::new(0) }; 2],
        most_lost: AtomicU64::new(0),
        is_fresh: AtomicBool::new(false),
    };

    /// A task has this place from now on.
    pub(crate) fn begin(&self, task: TaskId, timing: &Timing) {
        self.task.store(u64::from(task.to_bits()) + 1, Ordering::Relaxed);
        let (_, _, value, floor) = timing.parts();
        for counter in [&self.released, &self.on_time, &self.late, &self.warned, &self.most_lost] {
            counter.store(0, Ordering::Relaxed);
        }
        self.shed.iter().for_each(|counter| counter.store(0, Ordering::Relaxed));
        self.value.store(value.into(), Ordering::Relaxed);
        self.is_fresh.store(true, Ordering::Relaxed);
        for (place, number) in self.floor.iter().zip(floor) {
            place.store(number.into(), Ordering::Relaxed);
        }
    }

    pub(crate) fn released(&self) {
        count(&self.released);
    }

    pub(crate) fn warned(&self) {
        count(&self.warned);
    }

    /// The job that was released last found no place.
    pub(crate) fn refused(&self, floor: &mut Floor) {
        count(&self.shed[ShedReason::Full as usize - 1]);
        self.judged(read(&self.released).saturating_sub(1), true, floor);
    }

    pub(crate) fn ended(&self, outcome: &Outcome, floor: &mut Floor) {
        match outcome.shed {
            Some(reason) => count(&self.shed[reason as usize - 1]),
            None if outcome.on_time() => count(&self.on_time),
            None => count(&self.late),
        }
        self.judged(outcome.index, !outcome.on_time(), floor);
    }

    fn judged(&self, index: u64, is_lost: bool, floor: &mut Floor) {
        if self.is_fresh.swap(false, Ordering::Relaxed) {
            let [m, k] = self.floor.each_ref().map(|number| read(number) as u32);
            *floor = Floor::new(m, k);
        }
        floor.ended(index, is_lost);
        if is_lost {
            self.most_lost.fetch_max(floor.most_lost_around(index).into(), Ordering::Relaxed);
        }
    }

    /// Of the task that has, or had last, this place.
    pub(crate) fn report(&self, task: TaskId) -> Option<red_task_report> {
        if read(&self.task) != u64::from(task.to_bits()) + 1 {
            return None;
        }
        let [hopeless, overload, urgency, full, late, fault, removed] = self.shed.each_ref().map(read);
        let (released, on_time, value) = (read(&self.released), read(&self.on_time), read(&self.value));
        let given_up = hopeless + overload + urgency + full + late + fault + removed;
        let [m, k] = self.floor.each_ref().map(read);
        let worst = k.saturating_sub(read(&self.most_lost));
        Some(red_task_report {
            released,
            on_time,
            missed: read(&self.late) + given_up,
            hopeless,
            overload,
            urgency,
            full,
            late,
            fault,
            removed,
            value_on_time: on_time.saturating_mul(value),
            value_released: released.saturating_mul(value),
            warned: read(&self.warned),
            floor_worst: worst as u32,
            floor_kept: (worst >= m).into(),
            ..red_core::Empty::EMPTY
        })
    }
}
