//! What a run says about itself besides its jobs.

use crate::panics::BodyPanic;
use crate::usage::Usage;
use core::fmt;
use hdrhistogram::Histogram;
use red_core::NodeId;

/// Figures of a run.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Whether lanes had SCHED_FIFO, locked memory and a CPU each.
    pub realtime: bool,
    /// Unit became dispatchable to its body started, in nanoseconds.
    pub dispatch_ns: Histogram<u64>,
    /// Time that lanes spent deciding, per unit, in nanoseconds.
    pub overhead_ns_per_unit: u64,
    /// Page faults of lane threads after the start.
    pub page_faults: u64,
    /// Heap calls of lane threads outside of node bodies; 0 also where no counting allocator is installed.
    pub allocations: u64,
    /// Executions beyond the WCET.
    pub overruns: u64,
    /// Bodies that ran past their bound, and units of streams that did.
    pub hung: u64,
    /// Of these, units of streams. Their lanes are lost.
    pub stream_hangs: Vec<StreamHang>,
    /// Pools that are lost, a bit each: their device is gone, or none of their streams is left.
    pub pools_lost: u32,
    /// Lanes that were lost, because no spare thread could be started, or too many never came back or died.
    pub lanes_lost: u64,
    /// Of these, lanes that left their streams.
    pub streams_left: u64,
    /// Lane threads that ended though nobody asked them to.
    pub threads_died: u64,
    /// Times that a lane was found off its CPU and put back.
    pub pinned_again: u64,
    /// Times that the watchdog, and so most likely every thread, got no CPU for 20 ms and more.
    pub standstills: u64,
    /// The longest of them, in nanoseconds.
    pub longest_standstill_ns: u64,
    /// CPU time of bodies that ran under SCHED_OTHER, all together and in nanoseconds, so that the kernel did not stop lanes that
    /// were always busy for having used up what it lets real-time threads run of each second.
    pub ordinary_ns: u64,
    /// How long the machine was suspended meanwhile, in nanoseconds. The run's clock stood still.
    pub suspended_ns: u64,
    /// Bodies that panicked or failed.
    pub failed: u64,
    /// What the first bodies that panicked said, at most [`PANICS`] of each lane thread.
    pub panics: Vec<BodyPanic>,
    /// Units that ended after their sub-deadlines.
    pub nodes_missed: u64,
    /// The scheduler's own counters.
    pub counters: red_core::Counters,
    /// Events that the record had to drop.
    pub events_dropped: u64,
    /// Lane time in bodies, by lane, in nanoseconds.
    pub busy_ns: Vec<u64>,
    /// Units that were given to their lanes while their predecessors ran.
    pub ahead: u64,
    /// Who ended the run early.
    pub stopped_by: Option<Stopped>,
    /// Why the run ended itself early.
    pub gave_up: Option<Surrender>,
}

/// A unit that did not come to its end on its stream, which is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamHang {
    /// The lane whose stream it is.
    pub lane: usize,
    /// The task, by its place.
    pub task: usize,
    /// The node.
    pub node: NodeId,
    /// The how-manieth job of its task, from 0.
    pub job: u64,
}

/// Who stopped a run before its time was over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The signal of this name.
    Signal(&'static str),
    /// Whoever called [`Control::stop`](crate::control::Control::stop).
    Caller,
}

impl Stopped {
    /// The signal's name, if it was one.
    #[must_use]
    pub const fn signal(self) -> Option<&'static str> {
        match self {
            Self::Signal(name) => Some(name),
            Self::Caller => None,
        }
    }
}

/// Why a run cannot go on: its process has to be started anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Surrender {
    /// Every lane is lost to bodies that never returned, or to threads that died.
    NoLane,
    /// A lane's CPU was taken away. Elsewhere it could spin for the lock on the CPU of the lane that holds it.
    CpuGone {
        /// The lane.
        lane: usize,
        /// Its CPU.
        cpu: usize,
    },
}

impl fmt::Display for Surrender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLane => f.write_str("no lane is left, because bodies never returned or their threads died; mend the bodies and start again"),
            Self::CpuGone { lane, cpu } => write!(
                f,
                "CPU {cpu} was taken from lane {lane} (offline, or out of the cpuset); give it back and start again"
            ),
        }
    }
}

/// What one lane measured; folded into the report at the end.
#[derive(Debug)]
pub(crate) struct LaneFigures {
    pub(crate) dispatch_ns: Histogram<u64>,
    pub(crate) deciding_ns: u64,
    pub(crate) units: u64,
    pub(crate) busy_ns: u64,
    pub(crate) failed: u64,
    pub(crate) panics: Vec<BodyPanic>,
    pub(crate) stream_hangs: Vec<StreamHang>,
    pub(crate) overruns: u64,
    pub(crate) nodes_missed: u64,
    pub(crate) ordinary_ns: u64,
    pub(crate) faults: u64,
    pub(crate) baseline: Usage,
}

/// Panics that a lane's thread keeps the words of; the first ones tell most.
pub const PANICS: usize = 8;
/// Longest latency that is told apart: an hour.
const LONGEST_NS: u64 = 3_600_000_000_000;

/// A histogram of fixed size: three significant digits up to an hour.
pub(crate) fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, LONGEST_NS, 3)
        .unwrap_or_else(|_| Histogram::new(3).expect("3 digits are legal"))
}

impl LaneFigures {
    pub(crate) fn new() -> Self {
        Self {
            dispatch_ns: histogram(),
            deciding_ns: 0,
            units: 0,
            busy_ns: 0,
            failed: 0,
            panics: Vec::with_capacity(PANICS),
            // After it the stream is left.
            stream_hangs: Vec::with_capacity(1),
            overruns: 0,
            nodes_missed: 0,
            ordinary_ns: 0,
            faults: 0,
            baseline: Usage::of_thread(),
        }
    }

    /// Takes in another lane's figures.
    pub(crate) fn add(&mut self, other: Self) {
        // The histograms have the same bounds.
        let _added = self.dispatch_ns.add(&other.dispatch_ns);
        self.deciding_ns += other.deciding_ns;
        self.units += other.units;
        self.failed += other.failed;
        self.panics.extend(other.panics);
        self.stream_hangs.extend(other.stream_hangs);
        self.overruns += other.overruns;
        self.nodes_missed += other.nodes_missed;
        self.ordinary_ns += other.ordinary_ns;
        self.faults += other.faults;
    }

    /// Keeps a panic where there is room, and takes no memory under real time for it.
    pub(crate) fn panicked(&mut self, panic: BodyPanic) {
        if self.panics.len() < self.panics.capacity() {
            self.panics.push(panic);
        }
    }

    pub(crate) fn dispatched(&mut self, latency_ns: u64) {
        self.dispatch_ns.saturating_record(latency_ns.clamp(1, LONGEST_NS));
    }
}
