//! Locked memory, swap, background work on pages, and the allocator.

use super::Finding;
use super::check::{Check, Setting};
use super::rights::{hard_limit, holds_ipc_lock};
use super::tree::{Tree, Unreadable};
use crate::setup::FIX_MEMLOCK;

pub(super) fn examine(tree: &Tree<'_>) -> Vec<Finding> {
    let mut findings = vec![locked(tree), available(tree), swap(tree)];
    findings.extend(SETTINGS.iter().map(|setting| setting.examine(tree)));
    findings.push(allocator(tree));
    findings.push(arenas(tree));
    findings
}

const SETTINGS: [Setting; 4] = [
    Setting {
        check: Check {
            id: "memory.swappiness",
            why: "the higher, the sooner the kernel takes pages from processes that did not lock them",
            fix: "sysctl -w vm.swappiness=1",
        },
        path: "proc/sys/vm/swappiness",
        good: |value| value.parse().is_ok_and(|value: u32| value <= 10),
        absent: None,
    },
    Setting {
        check: Check {
            id: "memory.huge_pages",
            why: "the kernel stops threads to merge their pages into huge ones",
            fix: "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled",
        },
        path: "sys/kernel/mm/transparent_hugepage/enabled",
        good: |value| value.contains("[never]") || value.contains("[madvise]"),
        absent: Some("absent: the kernel has none"),
    },
    Setting {
        check: Check {
            id: "memory.ksm",
            why: "merging equal pages makes later stores fault",
            fix: "echo 0 > /sys/kernel/mm/ksm/run",
        },
        path: "sys/kernel/mm/ksm/run",
        good: |value| value == "0",
        absent: Some("absent: the kernel has none"),
    },
    Setting {
        check: Check {
            id: "memory.numa_balancing",
            why: "it unmaps pages to see who uses them; the next access faults",
            fix: "sysctl -w kernel.numa_balancing=0",
        },
        path: "proc/sys/kernel/numa_balancing",
        good: |value| value == "0",
        absent: Some("absent: the kernel has none"),
    },
];

fn kibibytes(tree: &Tree<'_>, path: &str, name: &str) -> Result<u64, Unreadable> {
    let text = tree.field(path, name)?;
    let number = text.trim_end_matches("kB").trim();
    number.parse().map_err(|_| Unreadable::new(path, format!("{name}: {text}")))
}

fn locked(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "memory.locked",
        why: "locking fails when all that is mapped exceeds the limit; models come on top of it",
        fix: FIX_MEMLOCK,
    };
    const STATUS: &str = "proc/self/status";
    let read = || {
        let limit = if holds_ipc_lock(tree)? { None } else { hard_limit(tree, "Max locked memory")? };
        Ok((kibibytes(tree, STATUS, "VmLck")?, kibibytes(tree, STATUS, "VmSize")?, limit))
    };
    CHECK.on(read(), |(locked, mapped, limit)| {
        let now = format!("{locked} KiB locked of {mapped} KiB mapped");
        match limit {
            None => CHECK.pass(format!("{now}, no limit")),
            Some(limit) if mapped > limit / 1024 => CHECK.fail(format!("{now}, limit {} KiB", limit / 1024)),
            Some(limit) => CHECK.pass(format!("{now}, limit {} KiB", limit / 1024)),
        }
    })
}

fn available(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "memory.available",
        why: "locked models must fit; on a Jetson the GPU takes its memory from here too",
        fix: "stop other processes, or choose smaller models; `redrt plan` shows what the models need",
    };
    let read = || {
        let of = |name| kibibytes(tree, "proc/meminfo", name);
        Ok((of("MemAvailable")?, of("MemTotal")?))
    };
    CHECK.on(read(), |(available, total)| {
        CHECK.pass_if(available >= total / 4, format!("{} of {} MiB", available >> 10, total >> 10))
    })
}

fn swap(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "memory.swap",
        why: "a page that was swapped out comes back with a disk access",
        fix: "swapoff -a",
    };
    CHECK.on(tree.read("proc/swaps"), |table| {
        // The first line is the heading.
        let areas = table.lines().skip(1).count();
        CHECK.pass_if(areas == 0, format!("{areas} swap areas"))
    })
}

/// The value of a variable in the environment of this process.
pub(super) fn variable(tree: &Tree<'_>, name: &str) -> Result<Option<String>, Unreadable> {
    let environment = tree.read("proc/self/environ")?;
    let value = environment.split('\0').find_map(|entry| entry.strip_prefix(name)?.strip_prefix('='));
    Ok(value.map(str::to_owned))
}

fn allocator(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "memory.malloc",
        why: "the runtime tells glibc's allocator to keep its memory; another allocator does not hear it",
        fix: "unset LD_PRELOAD",
    };
    CHECK.on(variable(tree, "LD_PRELOAD"), |preloaded| {
        match preloaded.filter(|libraries| !libraries.is_empty()) {
            Some(libraries) => CHECK.warn(format!("LD_PRELOAD={libraries}")),
            None => CHECK.pass("glibc, set by the runtime at its start"),
        }
    })
}

fn arenas(tree: &Tree<'_>) -> Finding {
    const CHECK: Check = Check {
        id: "memory.arenas",
        why: "with fewer arenas than threads a lane waits for the allocator's lock of another thread",
        fix: "unset MALLOC_ARENA_MAX",
    };
    CHECK.on(variable(tree, "MALLOC_ARENA_MAX"), |limit| match limit {
        Some(limit) => CHECK.warn(format!("at most {limit}")),
        None => CHECK.pass("one per thread"),
    })
}
