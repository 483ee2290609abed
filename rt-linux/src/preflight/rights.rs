//! Limits, capabilities, control groups and containers.

use super::check::Check;
use super::tree::{Tree, Unreadable};
use super::{Finding, RealTimeBudget, Severity};
use crate::setup::{FIX_MEMLOCK, FIX_RTPRIO};

const VERSION_1: &str = "sys/fs/cgroup/cpu";
const VERSION_2: &str = "sys/fs/cgroup";
const LIMITS: &str = "proc/self/limits";
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    vec![
        capability(tree, &SYS_NICE, CAP_SYS_NICE),
        priority(tree),
        nice(tree),
        capability(tree, &IPC_LOCK, CAP_IPC_LOCK),
        locked_memory(tree),
        real_time_limit(tree),
        group_scheduling(tree),
        quota(tree),
        cpuset(tree),
        container(tree),
    ]
}

const SYS_NICE: Check = Check {
    id: "rights.cap_sys_nice",
    why: "it gives every real-time priority; rights.rtprio can stand in for it",
    fix: FIX_RTPRIO,
};

const IPC_LOCK: Check = Check {
    id: "rights.cap_ipc_lock",
    why: "it allows to lock any amount of memory; rights.memlock can stand in for it",
    fix: FIX_MEMLOCK,
};

pub(super) fn holds_ipc_lock(tree: &Tree<'_>) -> Result<bool, Unreadable> {
    holds(tree, CAP_IPC_LOCK)
}

fn holds(tree: &Tree<'_>, capability: u32) -> Result<bool, Unreadable> {
    const STATUS: &str = "proc/self/status";
    let effective = tree.field(STATUS, "CapEff")?;
    let bits =
        u64::from_str_radix(&effective, 16).map_err(|error| Unreadable::new(STATUS, error.to_string()))?;
    Ok(bits >> capability & 1 == 1)
}

/// The hard limit, to which the runtime raises the soft one; `None` is unlimited.
pub(super) fn hard_limit(tree: &Tree<'_>, name: &str) -> Result<Option<u64>, Unreadable> {
    let text = tree.read(LIMITS)?;
    let hard = text.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().nth(1));
    match hard {
        Some("unlimited") => Ok(None),
        Some(number) => {
            number.parse().map(Some).map_err(|_| Unreadable::new(LIMITS, format!("{name}: {number}")))
        }
        None => Err(Unreadable::new(LIMITS, format!("no line {name}"))),
    }
}

fn capability(tree: &Tree<'_>, check: &Check, bit: u32) -> Finding {
    check.on(holds(tree, bit), |held| check.pass_if(held, if held { "held" } else { "not held" }))
}

fn priority(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.rtprio",
        why: "lanes need a SCHED_FIFO priority P and the watchdog P + 1; without, only best effort is left",
        fix: FIX_RTPRIO,
    };
    let both = || Ok((hard_limit(tree, "Max realtime priority")?, holds(tree, CAP_SYS_NICE)?));
    CHECK.on(both(), |(limit, capable)| match limit {
        _ if capable => CHECK.pass("every priority, by CAP_SYS_NICE"),
        None | Some(99..) => CHECK.pass("every priority, by RLIMIT_RTPRIO"),
        Some(0..=1) => CHECK.fail("none: RLIMIT_RTPRIO is too small and CAP_SYS_NICE missing"),
        Some(highest) => CHECK.warn(format!("up to {highest} by RLIMIT_RTPRIO")),
    })
}

fn nice(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.nice",
        why: "a lane that the watchdog demoted takes its priority back only with this right",
        fix: FIX_RTPRIO,
    };
    /// The limit is 20 minus the lowest nice value; ordinary threads have 0.
    const ORDINARY: u64 = 20;
    let both = || Ok((hard_limit(tree, "Max nice priority")?, holds(tree, CAP_SYS_NICE)?));
    CHECK.on(both(), |(limit, capable)| match limit {
        _ if capable => CHECK.pass("by CAP_SYS_NICE"),
        Some(limit) if limit < ORDINARY => {
            CHECK.warn(format!("RLIMIT_NICE is {limit} and CAP_SYS_NICE missing"))
        }
        _ => CHECK.pass("by RLIMIT_NICE"),
    })
}

fn locked_memory(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.memlock",
        why: "memory that is not locked may have to be fetched from a disk in the middle of a node",
        fix: FIX_MEMLOCK,
    };
    /// A process of the runtime with small models.
    const LEAST: u64 = 256 << 20;
    let both = || Ok((hard_limit(tree, "Max locked memory")?, holds_ipc_lock(tree)?));
    CHECK.on(both(), |(limit, capable)| match limit {
        _ if capable => CHECK.pass("any amount, by CAP_IPC_LOCK"),
        None => CHECK.pass("any amount, by RLIMIT_MEMLOCK"),
        Some(bytes) => {
            let severity = if bytes < LEAST { Severity::Fail } else { Severity::Warn };
            CHECK.finding(severity, format!("{} MiB by RLIMIT_MEMLOCK", bytes >> 20))
        }
    })
}

fn real_time_limit(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.rttime",
        why: "the kernel kills a real-time thread that runs this long (us) without sleeping",
        fix: "ulimit -R unlimited; under systemd LimitRTTIME=infinity",
    };
    CHECK.on(hard_limit(tree, "Max realtime timeout"), |limit| match limit {
        None => CHECK.pass("unlimited"),
        Some(microseconds) => CHECK.warn(format!("{microseconds} us")),
    })
}

/// `file` of the group at `path` in the hierarchy below `mount`.
fn in_group(mount: &str, path: &str, file: &str) -> String {
    if path.is_empty() { format!("{mount}/{file}") } else { format!("{mount}/{path}/{file}") }
}

/// The path of this process in the hierarchy of `controller`; the empty name is version 2.
fn group(tree: &Tree<'_>, controller: &str) -> Result<Option<String>, Unreadable> {
    let text = tree.read("proc/self/cgroup")?;
    Ok(text.lines().find_map(|line| {
        let mut parts = line.splitn(3, ':');
        let (_, names, path) = (parts.next()?, parts.next()?, parts.next()?);
        names.split(',').any(|name| name == controller).then(|| path.trim_matches('/').to_owned())
    }))
}

fn group_scheduling(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.rt_group_sched",
        why: "with RT group scheduling a control group without RT budget gets no real-time priority, even as root",
        fix: "give the group a budget (echo 950000 > its cpu.rt_runtime_us, those above it first; docker run \
            --cpu-rt-runtime=950000), move the process to the root group, have the kernel ask for none (sysctl -w \
            kernel.sched_rt_runtime_us=-1), or use a kernel without CONFIG_RT_GROUP_SCHED (boot parameter rt_group_sched=0)",
    };
    let judge = || -> Result<Finding, Unreadable> {
        if tree.read("proc/sys/kernel/sched_rt_runtime_us").is_ok_and(|runtime| runtime == "-1") {
            return Ok(CHECK.pass("no throttling, so the kernel asks no group for a budget"));
        }
        if let Some(path) = group(tree, "cpu")? {
            let file = in_group(VERSION_1, &path, "cpu.rt_runtime_us");
            return Ok(match tree.read(&file) {
                Ok(runtime) if runtime == "0" => CHECK.fail(format!("/{file} = 0")),
                Ok(runtime) => CHECK.pass(format!("/{file} = {runtime}")),
                Err(Unreadable { absent: true, .. }) => CHECK.pass("no RT group scheduling"),
                Err(unreadable) => return Err(unreadable),
            });
        }
        if !tree.kernel_config()?.contains("CONFIG_RT_GROUP_SCHED=y") {
            return Ok(CHECK.pass("no RT group scheduling"));
        }
        Ok(match group(tree, "")?.as_deref() {
            Some("") => CHECK.pass("RT group scheduling, and this is the root group"),
            path => {
                CHECK.fail(format!("RT group scheduling, and this is group /{}", path.unwrap_or_default()))
            }
        })
    };
    CHECK.on(judge(), |finding| finding)
}

/// The finding on a group without a budget, where it alone forbids this priority.
pub(super) fn group_without_budget(tree: &Tree<'_>, priority: u8) -> Option<Finding> {
    let within = |limit: Option<u64>| limit.is_none_or(|highest| highest >= u64::from(priority));
    let is_granted = holds(tree, CAP_SYS_NICE).unwrap_or(false)
        || hard_limit(tree, "Max realtime priority").is_ok_and(within);
    Some(group_scheduling(tree)).filter(|group| is_granted && group.severity == Severity::Fail)
}

/// What the kernel leaves real-time threads of each CPU, by its own limit or that of the control group.
pub(super) fn real_time_budget(tree: &Tree<'_>) -> Option<RealTimeBudget> {
    let of = |runtime: &str, period: &str| {
        let microseconds = |file: &str| tree.read(file).ok()?.parse::<u64>().ok()?.checked_mul(1_000);
        Some(RealTimeBudget { runtime_ns: microseconds(runtime)?, period_ns: microseconds(period)? })
    };
    // Minus one, and so no number here: no limit, for no group either.
    let own = of("proc/sys/kernel/sched_rt_runtime_us", "proc/sys/kernel/sched_rt_period_us")?;
    let path = group(tree, "cpu").ok().flatten();
    let of_group = path.and_then(|path| {
        let file = |name| in_group(VERSION_1, &path, name);
        of(&file("cpu.rt_runtime_us"), &file("cpu.rt_period_us"))
    });
    let share = |budget: &RealTimeBudget| {
        u128::from(budget.runtime_ns) * u128::from(u64::MAX) / u128::from(budget.period_ns.max(1))
    };
    [Some(own), of_group].into_iter().flatten().min_by_key(share)
}

fn quota(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.cpu_quota",
        why: "a control group that has used up its quota stands still until its next period",
        fix: "echo max > cpu.max of the group; in a container: docker run without --cpus",
    };
    let file = || {
        Ok(match group(tree, "cpu")? {
            Some(path) => in_group(VERSION_1, &path, "cpu.cfs_quota_us"),
            None => in_group(VERSION_2, &group(tree, "")?.unwrap_or_default(), "cpu.max"),
        })
    };
    CHECK.on(file(), |file| match tree.read(&file) {
        Ok(quota) => CHECK.pass_if(quota.starts_with("max") || quota == "-1", format!("/{file} = {quota}")),
        Err(Unreadable { absent: true, .. }) => CHECK.pass("no quota on this group"),
        Err(unreadable) => CHECK.warn(unreadable.to_string()),
    })
}

fn cpuset(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.cpuset",
        why: "an isolated partition keeps all other groups off the lanes' CPUs, without a reboot",
        fix: "echo isolated > cpuset.cpus.partition of the group; in a container: docker run --cpuset-cpus",
    };
    CHECK.on(group(tree, ""), |path| match path.as_deref() {
        None | Some("") => CHECK.pass("root group: all CPUs"),
        Some(path) => CHECK.on(tree.read(&in_group(VERSION_2, path, "cpuset.cpus.partition")), |partition| {
            CHECK.pass_if(["isolated", "root"].contains(&partition.as_str()), partition)
        }),
    })
}

fn container(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "rights.container",
        why: "a container starts without the rights of its user outside",
        fix: "docker run --cap-add SYS_NICE --cap-add IPC_LOCK --ulimit rtprio=99 --ulimit memlock=-1 \
            --device /dev/cpu_dma_latency --cpuset-cpus <lane CPUs>",
    };
    CHECK.on(tree.read("proc/self/cgroup"), |groups| {
        let mark = ["docker", "kubepods", "containerd", "libpod", "lxc"];
        let inside = ["/.dockerenv", "/run/.containerenv"].iter().any(|file| tree.exists(&file[1..]))
            || mark.iter().any(|mark| groups.contains(mark));
        CHECK.pass_if(!inside, if inside { "inside a container" } else { "none" })
    })
}
