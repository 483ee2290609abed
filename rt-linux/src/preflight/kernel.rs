//! Preemption, timers, throttling and the kernel's command line.

use super::check::{Check, Setting};
use super::tree::Tree;
use super::{Finding, Severity};

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    let config = [(&HIGH_RES, "CONFIG_HIGH_RES_TIMERS=y"), (&HZ, "CONFIG_HZ=")];
    let mut findings = vec![preemption(tree)];
    findings.extend(config.map(|(check, option)| configured(tree, check, option)));
    findings.extend(COMMAND_LINE.iter().map(|(check, option)| on_command_line(tree, check, option)));
    findings.push(throttling(tree));
    findings.push(fair_server(tree));
    findings.extend(SETTINGS.iter().map(|setting| setting.examine(tree)));
    findings
}

const SETTINGS: [Setting; 3] = [
    Setting {
        check: Check {
            id: "kernel.clocksource",
            why: "with another source every look at the clock is slow or a system call",
            fix: "boot with clocksource=tsc tsc=reliable; in a virtual machine, have the host pass its counter on",
        },
        path: "sys/devices/system/clocksource/clocksource0/current_clocksource",
        good: |source| ["tsc", "arch_sys_counter"].contains(&source),
        absent: None,
    },
    Setting {
        check: Check {
            id: "kernel.timer_migration",
            why: "a lane's timer may be moved to another CPU, whose interrupt then has to wake the lane",
            fix: "sysctl -w kernel.timer_migration=0",
        },
        path: "proc/sys/kernel/timer_migration",
        good: |value| value == "0",
        absent: Some("absent: the kernel does not move timers"),
    },
    Setting {
        check: Check {
            id: "kernel.nmi_watchdog",
            why: "its interrupts come every few seconds and cannot be masked",
            fix: "sysctl -w kernel.nmi_watchdog=0",
        },
        path: "proc/sys/kernel/nmi_watchdog",
        good: |value| value == "0",
        absent: Some("absent: the kernel has none"),
    },
];

const VERSION: &str = "proc/sys/kernel/version";

const HIGH_RES: Check = Check {
    id: "kernel.high_res_timers",
    why: "without them a lane wakes at the next tick, milliseconds late",
    fix: "use a kernel built with CONFIG_HIGH_RES_TIMERS=y",
};

const HZ: Check = Check {
    id: "kernel.hz",
    why: "ordinary threads that share a CPU are switched at this rate; lanes are not bound to it",
    fix: "use a kernel built with CONFIG_HZ=1000 if best-effort runs are to be finer",
};

const COMMAND_LINE: [(Check, &str); 5] = [
    (
        Check {
            id: "kernel.isolcpus",
            why: "ordinary threads may run on the lanes' CPUs and fill their caches",
            fix: "add isolcpus=domain,managed_irq,<lane CPUs> to the kernel command line and reboot",
        },
        "isolcpus",
    ),
    (
        Check {
            id: "kernel.nohz_full",
            why: "the tick interrupts a lane that runs alone on its CPU",
            fix: "add nohz_full=<lane CPUs> to the kernel command line and reboot",
        },
        "nohz_full",
    ),
    (
        Check {
            id: "kernel.rcu_nocbs",
            why: "RCU callbacks run on the lanes' CPUs",
            fix: "add rcu_nocbs=<lane CPUs> to the kernel command line and reboot",
        },
        "rcu_nocbs",
    ),
    (
        Check {
            id: "kernel.irqaffinity",
            why: "new interrupts may be served on the lanes' CPUs",
            fix: "add irqaffinity=0 to the kernel command line and reboot",
        },
        "irqaffinity",
    ),
    (
        Check {
            id: "kernel.threadirqs",
            why: "interrupt handlers that are no threads run above every lane (PREEMPT_RT threads them by itself)",
            fix: "add threadirqs to the kernel command line and reboot",
        },
        "threadirqs",
    ),
];

fn preemption(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "kernel.preempt_rt",
        why: "without it the kernel may delay a lane for milliseconds; no bound is claimed then",
        fix: "install a PREEMPT_RT kernel: apt install linux-image-rt-amd64, or pro enable realtime-kernel",
    };
    CHECK.on(tree.read(VERSION), |version| CHECK.pass_if(is_preempt_rt(tree), version))
}

/// Whether the kernel says of itself that it is PREEMPT_RT.
pub(super) fn is_preempt_rt(tree: &Tree<'_>) -> bool {
    let flag = tree.read("sys/kernel/realtime").is_ok_and(|flag| flag == "1");
    flag || tree.read(VERSION).is_ok_and(|version| version.contains("PREEMPT_RT"))
}

/// `option` ends with `=` where the value is only shown.
fn configured(tree: &Tree<'_>, check: &Check, option: &str) -> Finding {
    check.on(tree.kernel_config(), |config| match config.lines().find(|line| line.starts_with(option)) {
        Some(line) => check.pass(line),
        None => check.warn(format!("no {option} in the configuration of the kernel")),
    })
}

fn on_command_line(tree: &Tree<'_>, check: &Check, option: &str) -> Finding {
    check.on(tree.read("proc/cmdline"), |line| {
        let found = line.split_whitespace().find(|word| word.split('=').next() == Some(option));
        check.pass_if(found.is_some(), found.unwrap_or("not on the kernel command line"))
    })
}

fn throttling(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "kernel.rt_throttling",
        why: "real-time threads that use up this much of a period (us) are stopped for the rest of it",
        fix: "sysctl -w kernel.sched_rt_runtime_us=-1, with the watchdog of the runtime on",
    };
    CHECK.on(tree.read("proc/sys/kernel/sched_rt_runtime_us"), |runtime| {
        let period =
            tree.read("proc/sys/kernel/sched_rt_period_us").unwrap_or_else(|error| error.to_string());
        let severity = match runtime.as_str() {
            "-1" => Severity::Pass,
            "0" => Severity::Fail,
            _ => Severity::Warn,
        };
        CHECK.finding(severity, format!("runtime {runtime} of period {period}"))
    })
}

fn fair_server(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "kernel.fair_server",
        why: "from Linux 6.12 on it takes up to this much of a period (ns) from real-time threads for ordinary ones",
        fix: "as root: mount -t debugfs none /sys/kernel/debug; then echo 0 > each \
            /sys/kernel/debug/sched/fair_server/cpu*/runtime",
    };
    const FOLDER: &str = "sys/kernel/debug/sched/fair_server";
    CHECK.on(tree.names(FOLDER), |cpus| {
        let runtime = |cpu: &String| tree.read(&format!("{FOLDER}/{cpu}/runtime")).ok();
        let runtimes: Vec<_> = cpus.iter().filter_map(runtime).collect();
        let off = runtimes.iter().all(|runtime| runtime == "0");
        CHECK.pass_if(off, format!("runtime of each CPU: {}", runtimes.join(" ")))
    })
}
