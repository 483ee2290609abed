//! What happened to a run besides its jobs, in words: what its machine did to it, and why it gave up.

use crate::outcome::Failure;
use crate::session::RunSummary;
use crate::session::cuda::CudaSummary;
use crate::table::time;

/// A line for each kind of thing that should not have happened, with its cure.
pub(crate) fn notes(summary: &RunSummary) -> Vec<String> {
    let mut notes = Vec::new();
    let mut note = |happened: bool, words: &dyn Fn() -> String| notes.extend(happened.then(words));
    note(summary.standstills > 0, &|| {
        format!(
            "standstills: {}, the longest of {}: the run was halted, throttled by the kernel, or out of its CPU quota; \
             see kernel.rt_throttling and rights.cpu_quota of `redrt doctor`",
            summary.standstills,
            time(Some(summary.longest_standstill_ns))
        )
    });
    note(summary.ordinary_ns > 0, &|| {
        format!(
            "bodies ran outside of real time for {} in all: their lanes were always busy, and the kernel stops real-time \
             threads that are; see kernel.rt_throttling of `redrt doctor`",
            time(Some(summary.ordinary_ns))
        )
    });
    note(summary.suspended_ns >= SUSPENSION_NS, &|| {
        let length = time(Some(summary.suspended_ns));
        format!(
            "the machine was suspended for {length}, which deadlines do not count; keep robots awake while they run"
        )
    });
    note(summary.threads_died > 0, &|| {
        format!(
            "lane threads that ended by themselves: {}; a body called pthread_exit, or it was killed",
            summary.threads_died
        )
    });
    note(summary.pinned_again > 0, &|| {
        format!(
            "lanes that were moved off their CPUs and put back: {} times; keep taskset and cpuset off this process",
            summary.pinned_again
        )
    });
    note(summary.realtime && summary.page_faults > 0, &|| {
        format!("page faults while running: {}; allocate in `_open`, and not in a step", summary.page_faults)
    });
    for drifted in summary.cost_drift.iter().take(MOST_DRIFTED) {
        notes.push(format!(
            "cost drift: node `{}.{}` took {} in the beginning and {} from {} on: throttled by heat or a lower clock, or by \
             other work; cool it and fix its clocks (nvidia-smi -lgc, jetson_clocks, cpupower), then measure it again with \
             `redrt profile`",
            drifted.task,
            drifted.node,
            time(Some(drifted.before_ns)),
            time(Some(drifted.after_ns)),
            time(Some(drifted.at_ns)),
        ));
    }
    if summary.cost_drift.len() > MOST_DRIFTED {
        notes.push(format!("cost drift: {} nodes more", summary.cost_drift.len() - MOST_DRIFTED));
    }
    if let Some(cuda) = &summary.cuda {
        if cuda.late_memory_bytes > 0 {
            notes.push(format!(
                "{} bytes less of the device's memory are free than at the start: allocate in `_open`, for the whole \
                 device waits for an allocation; or another process did",
                cuda.late_memory_bytes
            ));
        }
        if cuda.late_allocations > 0 {
            notes.push(format!(
                "made on the device while running: {} times, which may make all of it wait",
                cuda.late_allocations
            ));
        }
    }
    notes
}

/// Nodes that are told one by one.
const MOST_DRIFTED: usize = 4;

/// Two readings of two clocks differ by less.
const SUSPENSION_NS: u64 = 1_000_000;

/// A run that ended itself is no answer, though its figures are: its process has to be started anew.
///
/// # Errors
/// [`Failure::Machine`] with the reason.
pub(crate) fn went_on(summary: &RunSummary) -> Result<(), Failure> {
    if let Some(CudaSummary { device_lost: Some(error), is_gone, .. }) = &summary.cuda {
        let cure = if *is_gone {
            "wait a while before each start, and give up after a few (systemd: RestartSec=10, StartLimitBurst=5)"
        } else {
            "start the process again, and mend the kernel"
        };
        return Err(Failure::Machine(format!(
            "the device was lost, and nothing ran on it since: {error}; this process does not get it back: {cure}"
        )));
    }
    if let Some(cuda) = summary.cuda.as_ref().filter(|cuda| !cuda.pools_lost.is_empty()) {
        return Err(Failure::Machine(format!(
            "no stream of pool `{}` is left, and what needs it was given up; start the process again, and mend the kernel \
             that did not come to its end",
            cuda.pools_lost.join("`, `")
        )));
    }
    match &summary.gave_up {
        Some(why) => Err(Failure::Machine(format!("the run gave up: {why}"))),
        None => Ok(()),
    }
}
