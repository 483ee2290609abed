//! Which CPUs the lanes get.

use std::fs;
use std::path::Path;

use nix::errno::Errno;
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::unistd::Pid;

use crate::setup::SetupError;

/// The CPUs on which the calling thread may run, ascending: online, in its affinity mask and in its cgroup.
///
/// # Errors
///
/// [`SetupError::System`] if the kernel has more CPUs than the 1024 of the C library's mask.
pub fn usable_cpus() -> Result<Vec<usize>, SetupError> {
    cpus_of(Pid::from_raw(0)).map_err(|errno| SetupError::System {
        call: "sched_getaffinity",
        errno,
        fix: "boot with at most 1024 CPUs (maxcpus=1024)",
    })
}

/// The CPUs on which a thread may run, ascending; `ESRCH` if it has ended.
pub(crate) fn cpus_of(thread: Pid) -> Result<Vec<usize>, Errno> {
    let mask = sched_getaffinity(thread)?;
    Ok((0..CpuSet::count()).filter(|&cpu| mask.is_set(cpu) == Ok(true)).collect())
}

/// Allows a thread to run on `cpu` only.
pub(crate) fn pin_thread(thread: Pid, cpu: usize) -> Result<(), Errno> {
    let mut mask = CpuSet::new();
    mask.set(cpu)?;
    sched_setaffinity(thread, &mask)
}

/// One CPU of `usable` for each of `lanes` lanes, ascending. CPU 0, where the kernel does most of its own work,
/// is given away only when all others are.
///
/// # Errors
///
/// [`SetupError::MoreLanesThanCpus`]: lanes spin for each other's lock, and two on one CPU would spin forever.
pub fn choose_cpus(lanes: usize, usable: &[usize]) -> Result<Vec<usize>, SetupError> {
    if lanes > usable.len() {
        return Err(SetupError::MoreLanesThanCpus { lanes, usable: usable.to_vec() });
    }
    let mut cpus = usable.to_vec();
    cpus.sort_unstable_by_key(|&cpu| (cpu == 0, cpu));
    cpus.truncate(lanes);
    cpus.sort_unstable();
    Ok(cpus)
}

/// The pairs of `cpus` that are hardware threads of one core and so slow each other down. `root` is the root of
/// the file system, `/` but for tests.
///
/// CPUs of which the kernel tells no siblings count as cores of their own.
#[must_use]
pub fn shared_cores(root: &Path, cpus: &[usize]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for (i, &cpu) in cpus.iter().enumerate() {
        let path = format!("sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list");
        let siblings =
            fs::read_to_string(root.join(path)).map(|list| parse_cpu_list(&list)).unwrap_or_default();
        pairs
            .extend(cpus[i + 1..].iter().filter(|other| siblings.contains(other)).map(|&other| (cpu, other)));
    }
    pairs
}

/// Reads the kernel's notation `0-2,5`; what is not a number is left out.
pub(crate) fn parse_cpu_list(list: &str) -> Vec<usize> {
    let mut cpus = Vec::new();
    for part in list.trim().split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        if let (Ok(first), Ok(last)) = (first.parse::<usize>(), last.parse::<usize>()) {
            // Bounded by the mask, whatever the text says.
            cpus.extend(first..=last.min(CpuSet::count() - 1));
        }
    }
    cpus
}

#[cfg(test)]
mod tests;
