//! What only a running real-time thread can tell.

use core::time::Duration;
use std::path::Path;
use std::thread;

use nix::time::{ClockId, clock_getres};

use super::check::Check;
use super::{Finding, group_without_budget};
use crate::clock::now_ns;
use crate::placement::{choose_cpus, usable_cpus};
use crate::setup::{
    FIX_MEMLOCK, FIX_RTPRIO, Fifo, SetupError, best_effort, hold_cpu_dma_latency, lock_memory, prefault_stack,
};
use crate::sleeper::Sleeper;
use crate::usage::Usage;

const PERIOD_NS: u64 = 1_000_000;
/// Above what other programs usually take, below the kernel's own threads of priority 99.
const PRIORITY: u8 = 80;
/// Far below the 950 ms of each second after which the kernel stops real-time threads.
const LONGEST_SPIN_NS: u64 = 50_000_000;
const STACK_BYTES: usize = 256 * 1024;

const LOCK: Check = Check {
    id: "measure.mlockall",
    why: "memory that is not locked may have to be fetched from a disk in the middle of a node",
    fix: FIX_MEMLOCK,
};

const FIFO: Check = Check {
    id: "measure.fifo",
    why: "the lanes are SCHED_FIFO threads; without, only best effort is left",
    fix: FIX_RTPRIO,
};

const WAKE_UP: Check = Check {
    id: "measure.wake_up",
    why: "a node starts this late after its release time, before the lane's spin makes up for it",
    fix: "follow the kernel.*, cpu.* and rights.* findings above; then cyclictest -m -p80 for an hour under load",
};

const PAGE_FAULTS: Check = Check {
    id: "measure.page_faults",
    why: "each one is a visit to the kernel, and a major one waits for a disk",
    fix: FIX_MEMLOCK,
};

const SWITCHES: Check = Check {
    id: "measure.involuntary_switches",
    why: "something with a higher priority took the CPU from a real-time thread",
    fix: "look for it: ps -eLo rtprio,psr,comm --sort=-rtprio; move it to another CPU with taskset -p",
};

const GAP: Check = Check {
    id: "measure.gap",
    why: "a spinning real-time thread was stopped this long: by interrupts, firmware (SMI) or the host of a \
        virtual machine",
    fix: "hwlatdetect --duration=60 for firmware; in a virtual machine pin its CPUs on the host",
};

/// What the thread saw.
struct Observed {
    fifo: Result<(), SetupError>,
    /// Lateness of each wake-up in nanoseconds, ascending.
    late_ns: Vec<u64>,
    usage: Usage,
    gap_ns: u64,
}

/// Runs a real-time thread with a period of 1 ms for `duration` (at least 10 ms) and reports its wake-ups, page
/// faults and interruptions. Without the right to a real-time priority it measures an ordinary thread and says so.
///
/// All memory of the process is locked meanwhile and afterwards, as in a run.
#[must_use]
pub fn measure(duration: Duration) -> Vec<Finding> {
    let mut findings = vec![timer_resolution()];
    findings.push(match lock_memory() {
        Ok(()) => LOCK.pass("all memory locked"),
        Err(error) => LOCK.fail(error.to_string()),
    });
    let duration_ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
    let thread = thread::Builder::new().name("red-measure".into()).spawn(move || observe(duration_ns));
    match thread.map(thread::JoinHandle::join) {
        Ok(Ok(observed)) => findings.extend(report(&observed)),
        Ok(Err(_)) => findings.push(WAKE_UP.fail("the measuring thread panicked")),
        Err(error) => findings.push(WAKE_UP.fail(format!("cannot start a thread: {error}"))),
    }
    findings
}

fn observe(duration_ns: u64) -> Observed {
    // As in a run; cpu.dma_latency has reported whether it can be held.
    let _awake = hold_cpu_dma_latency();
    let fifo = become_lane();
    if fifo.is_err() {
        // Pinning may have succeeded; the timers at least are as exact as they can be.
        let _ = best_effort();
    }
    let _ = prefault_stack(STACK_BYTES);

    let periods = (duration_ns / PERIOD_NS).clamp(10, 1_000_000);
    let mut late_ns: Vec<u64> = Vec::with_capacity(usize::try_from(periods).unwrap_or_default());
    let mut sleeper = Sleeper::yielding();
    let before = Usage::of_thread();
    let start = now_ns();
    late_ns.extend((1..=periods).map(|period| sleeper.sleep_until(start + period * PERIOD_NS)));
    let gap_ns = longest_gap((duration_ns / 10).min(LONGEST_SPIN_NS));
    let usage = Usage::of_thread().since(before);
    late_ns.sort_unstable();
    Observed { fifo, late_ns, usage, gap_ns }
}

/// The place that a single lane would get.
fn become_lane() -> Result<(), SetupError> {
    let cpu = choose_cpus(1, &usable_cpus()?)?[0];
    Fifo { priority: PRIORITY, cpu }.apply()
}

/// The longest time between two looks at the clock within `spin_ns`.
fn longest_gap(spin_ns: u64) -> u64 {
    let end = now_ns() + spin_ns;
    let (mut previous, mut longest) = (now_ns(), 0);
    while previous < end {
        let now = now_ns();
        longest = longest.max(now - previous);
        previous = now;
    }
    longest
}

fn report(observed: &Observed) -> [Finding; 5] {
    const GOOD_WAKE_UP_NS: u64 = 100_000;
    const GOOD_GAP_NS: u64 = 50_000;
    let Observed { fifo, late_ns, usage, gap_ns } = observed;
    let per_mille = |share: usize| late_ns[(late_ns.len() - 1) * share / 1_000];
    let (median, late99, worst) = (per_mille(500), per_mille(990), per_mille(1_000));
    let class = if fifo.is_ok() { "SCHED_FIFO" } else { "an ordinary thread" };
    let wakes = late_ns.len();
    [
        match fifo {
            Ok(()) => FIFO.pass(format!("priority {PRIORITY}")),
            Err(error) => match group_without_budget(Path::new("/"), error, PRIORITY) {
                Some(group) => Finding {
                    fix: group.fix,
                    ..FIFO.fail("refused, although the right to it is there: rights.rt_group_sched says why")
                },
                None => FIFO.fail(error.to_string()),
            },
        },
        WAKE_UP.pass_if(
            fifo.is_ok() && worst <= GOOD_WAKE_UP_NS,
            format!("{wakes} of {class}: median {median} ns, 99 % {late99} ns, max {worst} ns"),
        ),
        PAGE_FAULTS.pass_if(
            usage.minor_faults + usage.major_faults == 0,
            format!("{} minor, {} major", usage.minor_faults, usage.major_faults),
        ),
        SWITCHES.pass_if(usage.involuntary_switches == 0, usage.involuntary_switches.to_string()),
        GAP.pass_if(*gap_ns <= GOOD_GAP_NS, format!("{gap_ns} ns at most between two looks at the clock")),
    ]
}

fn timer_resolution() -> Finding {
    const CHECK: Check = Check {
        id: "measure.timer_resolution",
        why: "lanes cannot wake more exactly than this",
        fix: "use a kernel with CONFIG_HIGH_RES_TIMERS=y and boot without highres=off",
    };
    match clock_getres(ClockId::CLOCK_MONOTONIC) {
        Ok(step) => CHECK.pass_if(
            step.tv_sec() == 0 && step.tv_nsec() == 1,
            format!("{} s {} ns", step.tv_sec(), step.tv_nsec()),
        ),
        Err(errno) => CHECK.warn(format!("clock_getres: {}", errno.desc())),
    }
}
