//! Frequencies, idle states, hardware threads, and which CPUs there are.

use super::Finding;
use super::check::{Check, Setting};
use super::tree::{Tree, Unreadable};
use crate::placement::parse_cpu_list;
use crate::setup::{CPU_DMA_LATENCY, FIX_DMA_LATENCY};

const CPUS: &str = "sys/devices/system/cpu";

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    let mut findings =
        vec![governor(tree), frequency(tree), turbo(tree), idle_states(tree), latency_request(tree)];
    findings.extend(SETTINGS.iter().map(|setting| setting.examine(tree)));
    findings.push(isolated(tree));
    findings
}

const SETTINGS: [Setting; 2] = [
    Setting {
        check: Check {
            id: "cpu.smt",
            why: "two hardware threads of one core slow each other down by an amount nobody bounds",
            fix: "echo off > /sys/devices/system/cpu/smt/control, or leave the siblings of lane CPUs idle",
        },
        path: "sys/devices/system/cpu/smt/active",
        good: |active| active == "0",
        absent: Some("absent: one hardware thread per core"),
    },
    Setting {
        check: Check {
            id: "cpu.offline",
            why: "lanes cannot be pinned to a CPU that is offline",
            fix: "echo 1 > /sys/devices/system/cpu/cpu<N>/online",
        },
        path: "sys/devices/system/cpu/offline",
        good: str::is_empty,
        absent: None,
    },
];

/// The text of `file` of every CPU that is online.
fn each(tree: &Tree<'_>, file: &str) -> Result<Vec<String>, Unreadable> {
    let online = parse_cpu_list(&tree.read(&format!("{CPUS}/online"))?);
    online.iter().map(|cpu| tree.read(&format!("{CPUS}/cpu{cpu}/{file}"))).collect()
}

fn governor(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.governor",
        why: "another governor lowers the clock of a CPU that slept, and the next node runs slower than profiled",
        fix: "cpupower frequency-set -g performance (in a virtual machine: on the host)",
    };
    CHECK.on(each(tree, "cpufreq/scaling_governor"), |mut governors| {
        let good = governors.iter().all(|governor| governor == "performance");
        governors.dedup();
        CHECK.pass_if(good, governors.join(" "))
    })
}

fn frequency(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.frequency_range",
        why: "while the range is open the clock, and with it every WCET, moves",
        fix: "cpupower frequency-set -d <F> -u <F> with one frequency (in a virtual machine: on the host)",
    };
    let range = || Ok((each(tree, "cpufreq/scaling_min_freq")?, each(tree, "cpufreq/scaling_max_freq")?));
    CHECK.on(range(), |(lowest, highest)| {
        let mut ranges: Vec<_> =
            lowest.iter().zip(&highest).map(|(low, high)| format!("{low}-{high} kHz")).collect();
        ranges.dedup();
        CHECK.pass_if(lowest == highest, ranges.join(" "))
    })
}

fn turbo(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.turbo",
        why: "a clock that depends on temperature and on the neighbours makes measured WCETs unrepeatable",
        fix: "echo 1 > /sys/devices/system/cpu/intel_pstate/no_turbo, or echo 0 > \
            /sys/devices/system/cpu/cpufreq/boost",
    };
    if let Ok(off) = tree.read(&format!("{CPUS}/intel_pstate/no_turbo")) {
        return CHECK.pass_if(off == "1", format!("intel_pstate/no_turbo = {off}"));
    }
    CHECK.on(tree.read(&format!("{CPUS}/cpufreq/boost")), |boost| {
        CHECK.pass_if(boost == "0", format!("cpufreq/boost = {boost}"))
    })
}

fn idle_states(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.idle_states",
        why: "a CPU in a deep idle state wakes this much later; the runtime holds it awake where \
            cpu.dma_latency passes",
        fix: "cpupower idle-set -D 10, or boot with processor.max_cstate=1 intel_idle.max_cstate=0",
    };
    const DEEP_US: u64 = 10;
    let folder = format!("{CPUS}/cpu0/cpuidle");
    CHECK.on(tree.names(&folder), |states| {
        let deep: Vec<_> = states
            .iter()
            .filter_map(|state| {
                let read = |file: &str| tree.read(&format!("{folder}/{state}/{file}")).ok();
                let latency: u64 = read("latency")?.parse().ok()?;
                let enabled = read("disable").is_none_or(|disabled| disabled == "0");
                (latency > DEEP_US && enabled)
                    .then(|| format!("{} {latency} us", read("name").unwrap_or_default()))
            })
            .collect();
        if deep.is_empty() {
            CHECK.pass(format!("none deeper than {DEEP_US} us of {} states", states.len()))
        } else {
            CHECK.warn(deep.join(", "))
        }
    })
}

fn latency_request(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.dma_latency",
        why: "through this device the runtime keeps the CPUs out of deep idle states while it runs",
        fix: FIX_DMA_LATENCY,
    };
    let device = CPU_DMA_LATENCY.trim_start_matches('/');
    CHECK.on(tree.open_for_writing(device), |_| CHECK.pass("can be held"))
}

fn isolated(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "cpu.isolated",
        why: "isolated CPUs are the best ones for lanes, and ordinary processes are not allowed on them",
        fix: "taskset -c <isolated CPUs and one other> redrt ...",
    };
    let both = || {
        let isolated = tree.read(&format!("{CPUS}/isolated"))?;
        Ok((isolated, tree.field("proc/self/status", "Cpus_allowed_list")?))
    };
    CHECK.on(both(), |(isolated, allowed)| {
        let usable = parse_cpu_list(&allowed);
        let good = parse_cpu_list(&isolated).iter().all(|cpu| usable.contains(cpu));
        CHECK.pass_if(good, format!("isolated: {isolated:?}; allowed for this process: {allowed}"))
    })
}
