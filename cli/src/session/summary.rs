//! A run in numbers.

use super::cuda::CudaSummary;
use super::drift::Drifted;
use super::host::Notes;
use super::record::LogSummary;
use super::{Options, Robot};
use red_core::{Instant, Scheduler};
use red_rt::report::{RunReport, Stopped};
use red_workload::metrics::{TaskMetrics, summarise};
use red_workload::model::Workload;
use serde::Serialize;
use std::path::Path;

/// Latency percentiles in nanoseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct DispatchLatency {
    /// Median.
    pub(crate) p50: u64,
    /// 99th percentile.
    pub(crate) p99: u64,
    /// 99.9th percentile.
    pub(crate) p999: u64,
    /// Largest.
    pub(crate) max: u64,
}

/// A run in numbers, as `run --json` prints it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RunSummary {
    /// The keys of `sim --json`, measured.
    #[serde(flatten)]
    pub(crate) report: red_sim::Report,
    /// What the streams did, of a workload that has some.
    #[serde(flatten)]
    pub(crate) cuda: Option<CudaSummary>,
    /// Whether lanes had SCHED_FIFO, locked memory and a CPU each.
    pub(crate) realtime: bool,
    /// Unit became dispatchable to body started.
    pub(crate) dispatch_ns: DispatchLatency,
    /// Time that lanes spent deciding, per unit.
    pub(crate) overhead_ns_per_unit: u64,
    /// Page faults of lanes after the start.
    pub(crate) page_faults: u64,
    /// Heap calls of lanes outside of bodies.
    pub(crate) allocations: u64,
    /// Bytes of scheduler state, the event record apart.
    pub(crate) scheduler_bytes: usize,
    /// Executions beyond the WCET.
    pub(crate) overruns: u64,
    /// Nodes that took longer and longer.
    pub(crate) cost_drift: Vec<Drifted>,
    /// Bodies that failed, panicked, or did not return within their bound.
    pub(crate) failed: u64,
    /// Lanes that were lost for good.
    pub(crate) lanes_lost: u64,
    /// Lane threads that ended by themselves, and were replaced.
    pub(crate) threads_died: u64,
    /// Times that a lane was found off its CPU and put back.
    pub(crate) pinned_again: u64,
    /// Times that the run got no CPU for 20 ms and more: halted, throttled, or out of its quota.
    pub(crate) standstills: u64,
    /// The longest of them.
    pub(crate) longest_standstill_ns: u64,
    /// How long lanes slept, all together, so that the kernel did not stop them.
    pub(crate) ordinary_ns: u64,
    /// How long the machine was suspended meanwhile.
    pub(crate) suspended_ns: u64,
    /// Whether the kernel is PREEMPT_RT; where it is not, latencies have no bound.
    pub(crate) preempt_rt: bool,
    /// Jobs or events that the tables had no room for.
    pub(crate) notes_dropped: u64,
    /// How much was recorded, if the run was.
    pub(crate) record: Option<LogSummary>,
    /// The signal that ended the run early.
    pub(crate) stopped_by: Option<&'static str>,
    /// Why the run ended itself early.
    pub(crate) gave_up: Option<String>,
}

impl RunSummary {
    /// A time that was measured per unit; `None` where there was no unit.
    pub(crate) fn measured(&self, ns: u64) -> Option<u64> {
        (self.report.units_dispatched > 0).then_some(ns)
    }
}

/// What the notes and the figures of a run say.
pub(super) fn summary(
    workload: &Workload,
    options: &Options<'_>,
    notes: &Notes,
    figures: &RunReport,
    record: Option<LogSummary>,
    end_ns: u64,
) -> RunSummary {
    let until = Instant::from_nanos(options.duration_ns.min(end_ns));
    let tasks: Vec<TaskMetrics> = workload
        .tasks
        .iter()
        .zip(&notes.logs)
        .enumerate()
        .map(|(number, (task, log))| TaskMetrics {
            nodes: notes.costs.nodes(number),
            ..summarise(task, log, until, Instant::from_nanos(end_ns))
        })
        .collect();
    let mut lanes = figures.busy_ns.iter();
    let pools = workload.pools.iter().map(|pool| red_sim::PoolMetrics {
        name: pool.name.clone(),
        lanes: pool.lanes,
        busy_ns: lanes.by_ref().take(pool.lanes as usize).sum(),
    });
    let latency = |q: f64| figures.dispatch_ns.value_at_quantile(q);
    RunSummary {
        report: red_sim::Report {
            policy: options.policy.name(),
            seed: 0,
            horizon_ns: until.as_nanos(),
            tasks,
            nodes_missed: figures.nodes_missed,
            units_dispatched: figures.counters.units,
            encoder_runs_saved: figures.counters.encoder_runs_saved,
            pools: pools.collect(),
            schedule: None,
            sheds: None,
            jobs: Vec::new(),
        },
        cuda: None,
        realtime: figures.realtime,
        dispatch_ns: DispatchLatency {
            p50: latency(0.5),
            p99: latency(0.99),
            p999: latency(0.999),
            max: figures.dispatch_ns.max(),
        },
        overhead_ns_per_unit: figures.overhead_ns_per_unit,
        page_faults: figures.page_faults,
        allocations: figures.allocations,
        scheduler_bytes: Scheduler::<Robot>::SIZE - Scheduler::<Robot>::RECORD_SIZE,
        overruns: figures.overruns,
        cost_drift: Vec::new(),
        failed: figures.failed + figures.hung,
        lanes_lost: figures.lanes_lost,
        threads_died: figures.threads_died,
        pinned_again: figures.pinned_again,
        standstills: figures.standstills,
        longest_standstill_ns: figures.longest_standstill_ns,
        ordinary_ns: figures.ordinary_ns,
        suspended_ns: figures.suspended_ns,
        preempt_rt: red_rt::preflight::is_preempt_rt(Path::new("/")),
        notes_dropped: notes.dropped + figures.events_dropped,
        record,
        stopped_by: figures.stopped_by.and_then(Stopped::signal),
        gave_up: figures.gave_up.map(|surrender| surrender.to_string()),
    }
}
