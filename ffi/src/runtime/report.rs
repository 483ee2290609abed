//! What a run says about itself.

use crate::boundary::{Growing, plain};
use crate::values::RED_NONE_64;
use red_core::Empty;
use red_rt::cuda::Cuda;
use red_rt::report::{RunReport, Surrender};

/// Why a run ended itself.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_surrender {
    /// It did not.
    No = 0,
    /// No lane is left: bodies never returned, or their threads died.
    NoLane = 1,
    /// A lane's CPU was taken away.
    CpuGone = 2,
    /// For a reason that this header has no word for.
    Other = 3,
}

/// What a runtime did. What is marked "at the end" is RED_NONE_64, or 0 where it is of 32 bits, before the end, and where there was
/// no run.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_report {
    /// RED_REPORT_INIT sets it.
    pub struct_size: u32,
    /// RED_REPORT_INIT sets it.
    pub abi_version: u32,
    /// One of red_runtime_state.
    pub state: u32,
    /// At the end. 1: lanes had SCHED_FIFO, locked memory and a CPU each. 0: not, so no promise.
    pub realtime: u32,
    /// At the end: one of red_surrender. Unless it is 0 the process is to be started anew.
    pub surrender: u32,
    /// At the end. 1: red_runtime_stop ended it. 0: its duration did, or it itself.
    pub stopped: u32,
    /// Jobs released. Those that are neither on time nor missed at the end were in flight when it was stopped
    /// or drain_ns ran out.
    pub released: u64,
    /// Jobs that completed by their deadlines.
    pub on_time: u64,
    /// Jobs that completed late or were given up.
    pub missed: u64,
    /// Jobs that were given up, those that found no room at their release included.
    pub shed: u64,
    /// Bodies out of which a C++ exception came.
    pub threw: u64,
    /// Outcomes, and events, that nobody took in time.
    pub outcomes_dropped: u64,
    /// See outcomes_dropped.
    pub events_dropped: u64,
    /// At the end: bodies that failed or threw.
    pub failed: u64,
    /// At the end: executions beyond the WCET.
    pub overruns: u64,
    /// At the end: bodies that ran past ten times their WCET and 100 ms.
    pub hung: u64,
    /// At the end: lanes that were lost.
    pub lanes_lost: u64,
    /// At the end: lane threads that ended though nobody asked them to.
    pub threads_died: u64,
    /// At the end: units that ended after their sub-deadlines.
    pub nodes_missed: u64,
    /// At the end: units dispatched.
    pub units: u64,
    /// At the end: encoder sub-jobs that completed without executing.
    pub encoder_runs_saved: u64,
    /// At the end: heap calls of lanes outside of bodies.
    pub allocations: u64,
    /// At the end: page faults of lanes.
    pub page_faults: u64,
    /// At the end: times that nobody got a CPU for 20 ms and more.
    pub standstills: u64,
    /// At the end: the longest of them.
    pub longest_standstill_ns: u64,
    /// At the end: time that lanes spent deciding, per unit.
    pub overhead_ns_per_unit: u64,
    /// At the end: unit became dispatchable to body started, median.
    pub dispatch_p50_ns: u64,
    /// At the end: as dispatch_p50_ns, 99 of 100.
    pub dispatch_p99_ns: u64,
    /// At the end: as dispatch_p50_ns, the longest.
    pub dispatch_max_ns: u64,
    /// At the end, if it was recorded: inputs that found no room in the log, which then is not whole;
    /// red_runtime_message says why if the system did not take it.
    pub log_dropped: u64,
    /// At the end, with a pool of CUDA streams: waits of one stream for another.
    pub event_waits_issued: u64,
    /// At the end, with a pool of CUDA streams: predecessors on the device that needed no such wait.
    pub event_waits_avoided: u64,
    /// At the end, with a pool of CUDA streams: units that were given to their streams while what they wait for ran.
    pub submissions_ahead: u64,
    /// At the end, with a pool of CUDA streams: how much less of the device's memory is free than at the start, whoever took it.
    /// The whole device waits where that is done late.
    pub late_memory_bytes: u64,
    /// At the end: the error of the CUDA driver that ended the device for this process, so that nothing ran on it since; 0: it
    /// works.
    pub device_error: u64,
}
plain!(red_report {
    struct_size: u32,
    abi_version: u32,
    state: u32,
    realtime: u32,
    surrender: u32,
    stopped: u32,
    released: u64,
    on_time: u64,
    missed: u64,
    shed: u64,
    threw: u64,
    outcomes_dropped: u64,
    events_dropped: u64,
    failed: u64,
    overruns: u64,
    hung: u64,
    lanes_lost: u64,
    threads_died: u64,
    nodes_missed: u64,
    units: u64,
    encoder_runs_saved: u64,
    allocations: u64,
    page_faults: u64,
    standstills: u64,
    longest_standstill_ns: u64,
    overhead_ns_per_unit: u64,
    dispatch_p50_ns: u64,
    dispatch_p99_ns: u64,
    dispatch_max_ns: u64,
    log_dropped: u64,
    event_waits_issued: u64,
    event_waits_avoided: u64,
    submissions_ahead: u64,
    late_memory_bytes: u64,
    device_error: u64,
});
impl Growing for red_report {
    const LEAST: usize = 256;
}

impl red_report {
    /// What is not known before the end.
    pub(crate) const BEFORE_THE_END: Self = Self {
        failed: RED_NONE_64,
        overruns: RED_NONE_64,
        hung: RED_NONE_64,
        lanes_lost: RED_NONE_64,
        threads_died: RED_NONE_64,
        nodes_missed: RED_NONE_64,
        units: RED_NONE_64,
        encoder_runs_saved: RED_NONE_64,
        allocations: RED_NONE_64,
        page_faults: RED_NONE_64,
        standstills: RED_NONE_64,
        longest_standstill_ns: RED_NONE_64,
        overhead_ns_per_unit: RED_NONE_64,
        dispatch_p50_ns: RED_NONE_64,
        dispatch_p99_ns: RED_NONE_64,
        dispatch_max_ns: RED_NONE_64,
        log_dropped: RED_NONE_64,
        event_waits_issued: RED_NONE_64,
        event_waits_avoided: RED_NONE_64,
        submissions_ahead: RED_NONE_64,
        late_memory_bytes: RED_NONE_64,
        device_error: RED_NONE_64,
        ..Self::EMPTY
    };

    /// What is known at the end.
    pub(crate) fn of(run: &RunReport) -> Self {
        Self {
            realtime: run.realtime.into(),
            surrender: match run.gave_up {
                None => red_surrender::No,
                Some(Surrender::NoLane) => red_surrender::NoLane,
                Some(Surrender::CpuGone { .. }) => red_surrender::CpuGone,
                Some(_) => red_surrender::Other,
            } as u32,
            stopped: run.stopped_by.is_some().into(),
            failed: run.failed,
            overruns: run.overruns,
            hung: run.hung,
            lanes_lost: run.lanes_lost,
            threads_died: run.threads_died,
            nodes_missed: run.nodes_missed,
            units: run.counters.units,
            encoder_runs_saved: run.counters.encoder_runs_saved,
            allocations: run.allocations,
            page_faults: run.page_faults,
            standstills: run.standstills,
            longest_standstill_ns: run.longest_standstill_ns,
            overhead_ns_per_unit: run.overhead_ns_per_unit,
            dispatch_p50_ns: run.dispatch_ns.value_at_quantile(0.5),
            dispatch_p99_ns: run.dispatch_ns.value_at_quantile(0.99),
            dispatch_max_ns: run.dispatch_ns.max(),
            submissions_ahead: run.ahead,
            ..Self::EMPTY
        }
    }

    /// With what its streams did.
    pub(crate) fn on(self, cuda: &Cuda) -> Self {
        let streams = cuda.figures();
        Self {
            event_waits_issued: streams.event_waits_issued,
            event_waits_avoided: streams.event_waits_avoided,
            late_memory_bytes: streams.late_memory_bytes,
            device_error: cuda.lost().map_or(0, |error| error.code().unsigned_abs().into()),
            ..self
        }
    }
}
