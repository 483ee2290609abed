use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::{Finding, RealTimeBudget, Severity, examine, group_without_budget};
use crate::setup::SetupError;
use nix::errno::Errno;

/// A machine made of files in a folder of its own, which goes with it.
struct Machine(PathBuf);

impl Machine {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let machine = Self(std::env::temp_dir().join(format!("red-preflight-{name}-{}", std::process::id())));
        for (path, text) in files {
            machine.write(path, text);
        }
        machine
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().expect("below the root")).expect("a writable temporary folder");
        fs::write(path, text).expect("a writable temporary folder");
    }

    fn finding(&self, id: &str) -> Finding {
        let found: Vec<_> = examine(&self.0).into_iter().filter(|finding| finding.id == id).collect();
        assert_eq!(found.len(), 1, "{id}: {found:?}");
        found.into_iter().next().expect("exactly one")
    }

    fn severity(&self, id: &str) -> Severity {
        self.finding(id).severity
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Everything as it should be, on four CPUs, without a GPU.
const GOOD: &[(&str, &str)] = &[
    ("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.12\n"),
    ("proc/sys/kernel/osrelease", "6.12-rt\n"),
    ("boot/config-6.12-rt", "CONFIG_HZ=1000\nCONFIG_HIGH_RES_TIMERS=y\n# CONFIG_RT_GROUP_SCHED is not set\n"),
    ("proc/cmdline", "quiet isolcpus=2,3 nohz_full=2,3 rcu_nocbs=2,3 irqaffinity=0 threadirqs\n"),
    ("proc/sys/kernel/sched_rt_runtime_us", "-1\n"),
    ("proc/sys/kernel/sched_rt_period_us", "1000000\n"),
    ("sys/kernel/debug/sched/fair_server/cpu0/runtime", "0\n"),
    ("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n"),
    ("proc/sys/kernel/timer_migration", "0\n"),
    ("proc/sys/kernel/nmi_watchdog", "0\n"),
    ("sys/devices/system/cpu/online", "0-1\n"),
    ("sys/devices/system/cpu/offline", "\n"),
    ("sys/devices/system/cpu/isolated", "1\n"),
    ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
    ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
    ("sys/devices/system/cpu/cpu0/cpufreq/scaling_min_freq", "2000\n"),
    ("sys/devices/system/cpu/cpu1/cpufreq/scaling_min_freq", "2000\n"),
    ("sys/devices/system/cpu/cpu0/cpufreq/scaling_max_freq", "2000\n"),
    ("sys/devices/system/cpu/cpu1/cpufreq/scaling_max_freq", "2000\n"),
    ("sys/devices/system/cpu/cpufreq/boost", "0\n"),
    ("sys/devices/system/cpu/cpu0/cpuidle/state0/latency", "0\n"),
    ("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "200\n"),
    ("sys/devices/system/cpu/cpu0/cpuidle/state1/name", "C6\n"),
    ("sys/devices/system/cpu/cpu0/cpuidle/state1/disable", "1\n"),
    ("dev/cpu_dma_latency", ""),
    ("proc/1/comm", "init\n"),
    (
        "proc/interrupts",
        "     CPU0 CPU1\n 24:  5 0 PCI-MSI 1-edge eth0-rx-0\n NMI: 0 0 Non-maskable interrupts\n",
    ),
    ("proc/irq/24/smp_affinity_list", "0\n"),
    ("sys/class/net/eth0/flags", "0x1003\n"),
    ("sys/class/net/lo/flags", "0x1009\n"),
    (
        "proc/self/limits",
        "Limit                     Soft Limit           Hard Limit           Units     \n\
         Max locked memory         65536                unlimited            bytes     \n\
         Max nice priority         0                    40                   \n\
         Max realtime priority     0                    99                   \n\
         Max realtime timeout      unlimited            unlimited            us        \n",
    ),
    (
        "proc/self/status",
        "Name:\tredrt\nVmSize:\t  20000 kB\nVmLck:\t       0 kB\nCapEff:\t0000000000804000\nCpus_allowed_list:\t0-1\n",
    ),
    ("proc/self/cgroup", "0::/\n"),
    ("proc/self/environ", "HOME=/root\0LANG=C\0"),
    ("proc/meminfo", "MemTotal:       8000000 kB\nMemAvailable:   7000000 kB\n"),
    ("proc/swaps", "Filename Type Size Used Priority\n"),
    ("proc/sys/vm/swappiness", "1\n"),
    ("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n"),
    ("proc/sys/net/core/rmem_max", "4194304\n"),
    ("sys/class/thermal/thermal_zone0/temp", "40000\n"),
];

fn good(name: &str) -> Machine {
    Machine::new(name, GOOD)
}

#[test]
fn a_good_machine_has_nothing_to_fix_but_the_gpu() {
    let machine = good("good");
    let bad: Vec<_> = examine(&machine.0).into_iter().filter(|f| f.severity != Severity::Pass).collect();
    assert_eq!(bad.iter().map(|finding| finding.id).collect::<Vec<_>>(), ["gpu.device"], "{bad:#?}");
}

#[test]
fn the_same_checks_are_made_on_every_machine_and_each_is_complete() {
    let ids = |root: &Path| examine(root).iter().map(|finding| finding.id).collect::<Vec<_>>();
    let machine = good("same");
    let here = ids(Path::new("/"));
    assert_eq!(here, ids(&machine.0));
    assert_eq!(here, ids(Path::new("/nonexistent")));
    assert_eq!(here.iter().collect::<HashSet<_>>().len(), here.len(), "two findings of one name");
    for finding in examine(Path::new("/")) {
        assert!(
            !finding.value.contains('\n') && !finding.why.is_empty() && !finding.fix.is_empty(),
            "{finding}"
        );
    }
}

#[test]
fn a_machine_that_tells_nothing_is_not_called_good() {
    for finding in examine(Path::new("/nonexistent")) {
        // What the absence of its file proves, or what needs no file.
        let said = ["cannot read", "nothing to check", "absent", "not needed", "not on", "no NVIDIA"];
        assert!(said.iter().any(|said| finding.value.contains(said)), "{finding}");
        assert!(finding.severity == Severity::Warn || !finding.value.contains("cannot read"), "{finding}");
    }
}

#[test]
fn each_fault_is_seen_by_its_check() {
    let machine = good("faults");
    let faults = [
        ("kernel.preempt_rt", "proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC", Severity::Warn),
        ("kernel.high_res_timers", "boot/config-6.12-rt", "CONFIG_HZ=100\n", Severity::Warn),
        ("kernel.isolcpus", "proc/cmdline", "quiet noisolcpus=1", Severity::Warn),
        ("kernel.rt_throttling", "proc/sys/kernel/sched_rt_runtime_us", "950000", Severity::Warn),
        ("kernel.rt_throttling", "proc/sys/kernel/sched_rt_runtime_us", "0", Severity::Fail),
        ("kernel.fair_server", "sys/kernel/debug/sched/fair_server/cpu0/runtime", "50000000", Severity::Warn),
        (
            "kernel.clocksource",
            "sys/devices/system/clocksource/clocksource0/current_clocksource",
            "hpet",
            Severity::Warn,
        ),
        ("cpu.governor", "sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave", Severity::Warn),
        (
            "cpu.frequency_range",
            "sys/devices/system/cpu/cpu1/cpufreq/scaling_min_freq",
            "800",
            Severity::Warn,
        ),
        ("cpu.turbo", "sys/devices/system/cpu/intel_pstate/no_turbo", "0", Severity::Warn),
        ("cpu.idle_states", "sys/devices/system/cpu/cpu0/cpuidle/state1/disable", "0", Severity::Warn),
        ("cpu.smt", "sys/devices/system/cpu/smt/active", "1", Severity::Warn),
        ("cpu.offline", "sys/devices/system/cpu/offline", "2-3", Severity::Warn),
        ("cpu.isolated", "sys/devices/system/cpu/isolated", "1-3", Severity::Warn),
        ("cpu.irqbalance", "proc/77/comm", "irqbalance\n", Severity::Warn),
        ("cpu.irq_affinity", "proc/irq/24/smp_affinity_list", "0-1", Severity::Warn),
        ("memory.swap", "proc/swaps", "Filename\n/dev/sda2 partition 1 0 -2", Severity::Warn),
        ("memory.swappiness", "proc/sys/vm/swappiness", "60", Severity::Warn),
        (
            "memory.huge_pages",
            "sys/kernel/mm/transparent_hugepage/enabled",
            "[always] madvise",
            Severity::Warn,
        ),
        ("memory.ksm", "sys/kernel/mm/ksm/run", "1", Severity::Warn),
        ("memory.malloc", "proc/self/environ", "A=1\0LD_PRELOAD=libjemalloc.so\0", Severity::Warn),
        ("memory.arenas", "proc/self/environ", "MALLOC_ARENA_MAX=1\0", Severity::Warn),
        ("network.rmem_max", "proc/sys/net/core/rmem_max", "212992", Severity::Warn),
        ("network.loopback_multicast", "sys/class/net/lo/flags", "0x9", Severity::Warn),
        ("rights.container", ".dockerenv", "", Severity::Warn),
    ];
    for (id, path, text, severity) in faults {
        machine.write(path, text);
        let finding = machine.finding(id);
        assert_eq!(finding.severity, severity, "{path} = {text}: {finding}");
    }
}

#[test]
fn a_missing_right_fails_where_nothing_stands_in_for_it() {
    let machine = good("rights");
    let status = "VmSize:\t 20000 kB\nVmLck:\t 0 kB\nCapEff:\t0000000000000000\nCpus_allowed_list:\t0\n";
    machine.write("proc/self/status", status);
    assert_eq!(machine.severity("rights.cap_sys_nice"), Severity::Warn);
    assert_eq!(machine.severity("rights.rtprio"), Severity::Pass, "the limit stands in");
    assert_eq!(machine.severity("rights.memlock"), Severity::Pass, "the limit stands in");

    let limits = "Max locked memory  8388608 8388608 bytes\nMax nice priority 0 0\nMax realtime priority 0 0\nMax realtime timeout 1 1 us\n";
    machine.write("proc/self/limits", limits);
    let finding = machine.finding("rights.rtprio");
    assert_eq!(finding.severity, Severity::Fail);
    assert!(finding.fix.contains("cap_sys_nice") && finding.fix.contains("docker"), "{finding}");
    assert_eq!(machine.severity("rights.memlock"), Severity::Fail);
    assert_eq!(machine.severity("memory.locked"), Severity::Fail);
    assert_eq!(machine.severity("rights.nice"), Severity::Warn);
    assert_eq!(machine.severity("rights.rttime"), Severity::Warn);
}

#[test]
fn the_container_trap_of_rt_group_scheduling_is_seen_in_both_versions() {
    let machine = good("groups");
    machine.write("boot/config-6.12-rt", "CONFIG_RT_GROUP_SCHED=y\n");
    assert_eq!(machine.severity("rights.rt_group_sched"), Severity::Pass, "the root group");
    machine.write("proc/self/cgroup", "0::/system.slice/docker-1.scope\n");
    assert_eq!(machine.severity("rights.rt_group_sched"), Severity::Pass, "no throttling, so no budgets");
    machine.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    assert_eq!(machine.severity("rights.rt_group_sched"), Severity::Fail);
    assert_eq!(machine.severity("rights.container"), Severity::Warn);
    machine.write("sys/fs/cgroup/system.slice/docker-1.scope/cpuset.cpus.partition", "member\n");
    assert_eq!(machine.severity("rights.cpuset"), Severity::Warn);
    machine.write("sys/fs/cgroup/system.slice/docker-1.scope/cpu.max", "50000 100000\n");
    assert_eq!(machine.severity("rights.cpu_quota"), Severity::Warn);

    machine.write("proc/self/cgroup", "4:cpu,cpuacct:/box\n0::/\n");
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "0\n");
    assert_eq!(machine.severity("rights.rt_group_sched"), Severity::Fail);
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "950000\n");
    assert_eq!(machine.severity("rights.rt_group_sched"), Severity::Pass);
    machine.write("sys/fs/cgroup/cpu/box/cpu.cfs_quota_us", "50000\n");
    assert_eq!(machine.severity("rights.cpu_quota"), Severity::Warn);
}

#[test]
fn a_refused_priority_is_put_down_to_the_group_only_where_the_right_is_there() {
    let machine = good("refused");
    let refused = |call| SetupError::NotPermitted { call, errno: Errno::EPERM, fix: "get the right" };
    let of_group =
        |call, priority| group_without_budget(&machine.0, &refused(call), priority).map(|finding| finding.id);
    let (fifo, group) = ("sched_setscheduler(SCHED_FIFO)", Some("rights.rt_group_sched"));
    assert_eq!(of_group(fifo, 70), None, "no group scheduling");
    machine.write("proc/self/cgroup", "4:cpu,cpuacct:/box\n0::/\n");
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "0\n");
    assert_eq!(of_group(fifo, 70), None, "no throttling, so no budgets");
    machine.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    assert_eq!(of_group(fifo, 70), group);
    assert_eq!(of_group("mlockall(MCL_CURRENT | MCL_FUTURE)", 70), None, "the group grants no memory");
    // By its limit, without the capability.
    machine.write("proc/self/status", "CapEff:\t0000000000000000\n");
    machine.write("proc/self/limits", "Max realtime priority     80                   80\n");
    assert_eq!([70, 80, 81].map(|priority| of_group(fifo, priority)), [group, group, None]);
    machine.write("proc/self/limits", "Max realtime priority     0                    0\n");
    assert_eq!(of_group(fifo, 70), None, "the right is missing");
    machine.write("proc/self/limits", "Max realtime priority     unlimited            unlimited\n");
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "950000\n");
    assert_eq!(of_group(fifo, 70), None, "there is a budget");
}

#[test]
fn the_real_time_budget_is_the_kernels_or_less() {
    let machine = good("budget");
    let budget =
        || RealTimeBudget::of_process(&machine.0).map(|budget| (budget.runtime_ns, budget.period_ns));
    assert_eq!(budget(), None, "no throttling");
    machine.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    machine.write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    assert_eq!(budget(), Some((950_000_000, 1_000_000_000)));
    machine.write("proc/self/cgroup", "4:cpu,cpuacct:/box\n0::/\n");
    assert_eq!(budget(), Some((950_000_000, 1_000_000_000)), "no group scheduling");
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "80000\n");
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_period_us", "100000\n");
    assert_eq!(budget(), Some((80_000_000, 100_000_000)));
    machine.write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "99000\n");
    assert_eq!(budget(), Some((950_000_000, 1_000_000_000)), "the kernel allows less");
    machine.write("proc/sys/kernel/sched_rt_runtime_us", "-1\n");
    assert_eq!(budget(), None, "groups are not asked either");
}

#[test]
fn a_desktop_gpu_is_judged_by_its_driver() {
    let machine = good("desktop");
    machine.write("dev/nvidia0", "");
    assert_eq!(machine.severity("gpu.device"), Severity::Pass);
    assert_eq!(machine.severity("gpu.libcuda"), Severity::Fail);
    machine.write("opt/own/libcuda.so.1", "");
    machine.write("proc/self/environ", "LD_LIBRARY_PATH=relative:/opt/own\0");
    assert_eq!(machine.finding("gpu.libcuda").value, "/opt/own/libcuda.so.1");
    machine.write("usr/lib/x86_64-linux-gnu/libnvidia-ml.so.1", "");
    assert_eq!(machine.severity("gpu.nvml"), Severity::Pass);
    for (version, severity) in
        [("535.104.05", Severity::Pass), ("390.157", Severity::Warn), ("", Severity::Warn)]
    {
        let line = format!("NVRM version: NVIDIA UNIX x86_64 Kernel Module  {version}  Sat Aug 19 01:15:15");
        machine.write("proc/driver/nvidia/version", &line);
        assert_eq!(machine.severity("gpu.driver"), severity, "{version}");
    }
    assert_eq!(machine.severity("gpu.compute_mode"), Severity::Warn, "not read is not passed");
    machine.write("proc/500/comm", "nvidia-cuda-mps\n");
    assert_eq!(machine.severity("gpu.mps"), Severity::Warn);
}

#[test]
fn a_jetson_is_judged_by_its_power_mode_and_clocks() {
    let machine = good("jetson");
    machine.write("dev/nvhost-gpu", "");
    machine.write("proc/device-tree/model", "NVIDIA Jetson AGX Orin\0");
    machine.write("etc/nv_tegra_release", "# R35 (release), REVISION: 4.1\nmore\n");
    machine.write("var/lib/nvpmodel/status", "pmode:0000");
    machine.write("sys/class/devfreq/17000000.ga10b/min_freq", "306000000");
    machine.write("sys/class/devfreq/17000000.ga10b/max_freq", "1300500000");
    machine.write("sys/class/devfreq/17000000.ga10b/device/load", "15");
    assert_eq!(machine.finding("gpu.jetson_model").value, "NVIDIA Jetson AGX Orin");
    assert_eq!(machine.finding("gpu.driver").value, "# R35 (release), REVISION: 4.1");
    assert_eq!(machine.severity("gpu.nvpmodel"), Severity::Pass);
    assert_eq!(machine.severity("gpu.jetson_clocks"), Severity::Warn);
    assert_eq!(machine.finding("gpu.load_node").value, "15");
    machine.write("var/lib/nvpmodel/status", "pmode:0002");
    assert_eq!(machine.severity("gpu.nvpmodel"), Severity::Warn);

    machine.write("sys/class/thermal/thermal_zone1/temp", "99500");
    machine.write("sys/class/thermal/thermal_zone1/trip_point_0_type", "critical");
    machine.write("sys/class/thermal/thermal_zone1/trip_point_1_type", "passive");
    machine.write("sys/class/thermal/thermal_zone1/trip_point_1_temp", "99000");
    let finding = machine.finding("gpu.thermal");
    assert_eq!(
        (finding.severity, finding.value.as_str()),
        (Severity::Warn, "thermal_zone1 at 99500 of 99000 millidegrees")
    );
}

#[test]
fn a_finding_is_one_line_that_ends_with_the_fix() {
    let finding = |severity| Finding { id: "a.b", severity, value: "1".into(), why: "so", fix: "do".into() };
    assert_eq!(finding(Severity::Pass).to_string(), "PASS a.b: 1");
    assert_eq!(finding(Severity::Fail).to_string(), "FAIL a.b: 1; so; fix: do");
}
