//! What makes a thread and a process fit for real time. Each step on its own, each with a typed error.
//!
//! In the process, once, before the lanes start: [`malloc_for_real_time`], [`lock_memory`],
//! [`hold_cpu_dma_latency`]. In each lane, first: [`Fifo::apply`] (or [`best_effort`]) and [`prefault_stack`].

use core::fmt;
use core::hint::black_box;
use std::fs::File;
use std::io::{self, Write};

use nix::errno::Errno;
use nix::sys::mman::{MlockAllFlags, mlockall, munlockall};
use nix::sys::prctl::set_timerslack;
use nix::sys::resource::{Resource, getrlimit, setrlimit};
use nix::sys::signal::Signal;
use nix::unistd::Pid;

use crate::placement::{pin_thread, usable_cpus};
use crate::sys::{self, Policy};

/// Where the kernel takes latency requests for its idle states.
pub(crate) const CPU_DMA_LATENCY: &str = "/dev/cpu_dma_latency";

/// The cure where the right to a real-time priority is missing.
pub(crate) const FIX_RTPRIO: &str = "sudo setcap cap_sys_nice,cap_ipc_lock=ep $(which redrt); or add \
    `* - rtprio 99` and `* - nice -20` to /etc/security/limits.conf and log in again; \
    in a container: docker run --cap-add SYS_NICE --ulimit rtprio=99";

/// The cure where the right to lock memory is missing.
pub(crate) const FIX_MEMLOCK: &str = "sudo setcap cap_sys_nice,cap_ipc_lock=ep $(which redrt); or add \
    `* - memlock unlimited` to /etc/security/limits.conf and log in again; \
    in a container: docker run --cap-add IPC_LOCK --ulimit memlock=-1";

/// The cure where the latency device is closed to this user.
pub(crate) const FIX_DMA_LATENCY: &str = "sudo chmod o+w /dev/cpu_dma_latency, for good by the udev rule \
    KERNEL==\"cpu_dma_latency\", MODE=\"0666\"; in a container: docker run --device /dev/cpu_dma_latency";

/// A step that did not succeed: where, why, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SetupError {
    /// The user lacks a right. The one kind after which a best-effort run may go on.
    NotPermitted {
        /// The call that was refused.
        call: &'static str,
        /// The kernel's answer.
        errno: Errno,
        /// How to get the right.
        fix: &'static str,
    },
    /// The kernel or its configuration does not do this.
    System {
        /// The call that failed.
        call: &'static str,
        /// The kernel's answer.
        errno: Errno,
        /// What to change.
        fix: &'static str,
    },
    /// There are more lanes than CPUs to give each its own.
    MoreLanesThanCpus {
        /// Lanes asked for.
        lanes: usize,
        /// The CPUs that this process may use.
        usable: Vec<usize>,
    },
    /// A lane was to be pinned to a CPU that is offline or outside the affinity mask or cgroup.
    CpuNotUsable {
        /// The CPU asked for.
        cpu: usize,
        /// The CPUs that this process may use.
        usable: Vec<usize>,
    },
    /// A run was set up with other lanes than its scheduler has.
    OtherLanes {
        /// Lanes of the set-up.
        lanes: usize,
        /// Lanes over all pools of the scheduler.
        of_scheduler: usize,
    },
    /// A run was set up with a scheduler that preempts, and no lane can interrupt a body.
    Preempts,
    /// A run in real time was set up with too few or too many CPUs, or with one twice.
    NotACpuEach {
        /// Lanes of the set-up.
        lanes: usize,
        /// Its CPUs.
        cpus: Vec<usize>,
    },
    /// CPUs of a run in real time have lanes of another one of this process.
    CpusHeld {
        /// These.
        cpus: Vec<usize>,
    },
    /// More stack was to be prefaulted than the thread has.
    StackTooSmall {
        /// Bytes asked for.
        wanted: usize,
        /// Bytes that may be touched.
        room: usize,
    },
}

impl SetupError {
    /// The system starts no thread.
    #[must_use]
    pub fn no_thread(call: &'static str, error: &io::Error) -> Self {
        let errno = Errno::from_raw(error.raw_os_error().unwrap_or_default());
        Self::System { call, errno, fix: "raise the limit of processes (ulimit -u) or free memory" }
    }

    fn of(call: &'static str, errno: Errno, right: &'static str, otherwise: &'static str) -> Self {
        match errno {
            Errno::EPERM | Errno::EACCES => Self::NotPermitted { call, errno, fix: right },
            _ => Self::System { call, errno, fix: otherwise },
        }
    }
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPermitted { call, errno, fix } | Self::System { call, errno, fix } => {
                write!(f, "{call}: {} ({errno:?}); fix: {fix}", errno.desc())
            }
            Self::MoreLanesThanCpus { lanes, usable } => write!(
                f,
                "{lanes} lanes need a CPU each, and there are {} usable CPUs {usable:?}; fix: configure at most \
                 {} lanes, or widen the affinity mask (taskset, cpuset)",
                usable.len(),
                usable.len()
            ),
            Self::CpuNotUsable { cpu, usable } => write!(
                f,
                "CPU {cpu} is offline or not allowed for this process, usable are {usable:?}; fix: choose one of \
                 them, or bring it in: echo 1 > /sys/devices/system/cpu/cpu{cpu}/online, taskset, cpuset"
            ),
            Self::OtherLanes { lanes, of_scheduler } => write!(
                f,
                "the set-up has {lanes} lanes and the scheduler's pools {of_scheduler}; fix: give both the same"
            ),
            Self::Preempts => f.write_str(
                "a lane cannot interrupt a body, and the scheduler preempts; fix: set preempt to false in its Config",
            ),
            Self::NotACpuEach { lanes, cpus } => write!(
                f,
                "{lanes} lanes in real time need a CPU each, and were given {cpus:?}; fix: name {lanes} different CPUs"
            ),
            Self::CpusHeld { cpus } => write!(
                f,
                "CPUs {cpus:?} have lanes of another run of this process; fix: pin lanes to others, or end that run \
                 first"
            ),
            Self::StackTooSmall { wanted, room } => write!(
                f,
                "prefaulting {wanted} bytes of a stack with {room} bytes left; fix: give the thread a larger \
                 stack, or prefault less"
            ),
        }
    }
}

impl core::error::Error for SetupError {}

/// A FIFO priority on one CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fifo {
    /// 1 (lowest) to 99. Lanes take at most 98, because the watchdog is one above.
    pub priority: u8,
    /// The CPU, by the kernel's number.
    pub cpu: usize,
}

impl Fifo {
    /// Pins the calling thread to the CPU and gives it the priority. Threads it starts later are ordinary ones.
    ///
    /// # Errors
    ///
    /// [`SetupError::CpuNotUsable`], [`SetupError::NotPermitted`], or [`SetupError::System`] for a priority
    /// outside 1 to 99. The thread keeps its old policy then, but may be pinned.
    pub fn apply(self) -> Result<(), SetupError> {
        pin(self.cpu)?;
        raise_soft_limit(Resource::RLIMIT_RTPRIO);
        // Leaving SCHED_IDLE, where the watchdog may have put this thread, counts as a lower nice value.
        raise_soft_limit(Resource::RLIMIT_NICE);
        sys::set_policy(Pid::from_raw(0), Policy::Fifo(self.priority)).map_err(|errno| {
            let otherwise = "choose a priority from 1 to 98";
            SetupError::of("sched_setscheduler(SCHED_FIFO)", errno, FIX_RTPRIO, otherwise)
        })
    }
}

/// Makes the calling thread an ordinary one that shares its CPU, with timers as exact as that allows.
///
/// # Errors
///
/// [`SetupError::NotPermitted`] under a seccomp filter that forbids it.
pub fn best_effort() -> Result<(), SetupError> {
    let allow = "allow sched_setscheduler and prctl in the seccomp filter of the container";
    sys::set_policy(Pid::from_raw(0), Policy::Ordinary)
        .map_err(|errno| SetupError::of("sched_setscheduler(SCHED_OTHER)", errno, allow, allow))?;
    // Ordinary threads' timers may be merged within 50 us; real-time threads have no slack to begin with.
    set_timerslack(1).map_err(|errno| SetupError::of("prctl(PR_SET_TIMERSLACK)", errno, allow, allow))
}

/// Allows the calling thread to run on `cpu` only.
///
/// # Errors
///
/// [`SetupError::CpuNotUsable`].
pub fn pin(cpu: usize) -> Result<(), SetupError> {
    pin_thread(Pid::from_raw(0), cpu)
        .or_else(|_| Err(SetupError::CpuNotUsable { cpu, usable: usable_cpus()? }))
}

/// Locks all present and future memory of the process, so that no page is ever fetched or reclaimed in a lane.
/// Thread stacks and heap that come later are then in memory from the start.
///
/// # Errors
///
/// [`SetupError::NotPermitted`] if the limit is below what the process has mapped and `CAP_IPC_LOCK` is missing.
pub fn lock_memory() -> Result<(), SetupError> {
    raise_soft_limit(Resource::RLIMIT_MEMLOCK);
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE).map_err(|errno| {
        let call = "mlockall(MCL_CURRENT | MCL_FUTURE)";
        match errno {
            // What the kernel says when the limit is not zero but too small.
            Errno::ENOMEM => SetupError::NotPermitted { call, errno, fix: FIX_MEMLOCK },
            _ => SetupError::of(
                call,
                errno,
                FIX_MEMLOCK,
                "free memory until everything fits, then start again",
            ),
        }
    })
}

/// Whether threads that take so many bytes together, their stacks for the most part, can be started, as far as the limit
/// of the process's address space goes. What other threads take at this moment is not known.
#[must_use]
pub fn has_room_for_threads(bytes: usize) -> bool {
    sys::has_address_space(bytes)
}

/// What a user may raise without any right, from the soft to the hard limit. Where that is not enough, the call
/// that needs it says so.
fn raise_soft_limit(resource: Resource) {
    let _ = getrlimit(resource).and_then(|(_, hard)| setrlimit(resource, hard, hard));
}

/// Touches the next `bytes` of the calling thread's stack, so that no lane faults its own stack in.
///
/// Time: one page fault for each 4 KiB that was not touched before.
///
/// # Errors
///
/// [`SetupError::StackTooSmall`] instead of a crash on the guard page.
pub fn prefault_stack(bytes: usize) -> Result<(), SetupError> {
    const FRAME: usize = 16 * 1024;
    /// What the calls below and a signal handler need beyond the frames.
    const RESERVE: usize = 64 * 1024;

    #[inline(never)]
    fn touch(frames: usize) {
        let mut frame = [0_u8; FRAME];
        black_box(&mut frame);
        if frames > 1 {
            touch(frames - 1);
        }
        // After the call, so that it is not turned into a loop over one frame.
        black_box(&mut frame);
    }

    let room = sys::stack_room().map_err(|errno| {
        let otherwise = "mount /proc, from which the stack of the main thread is read";
        SetupError::of("pthread_getattr_np", errno, otherwise, otherwise)
    })?;
    // An unoptimised build keeps two copies of a frame.
    let room = room.saturating_sub(RESERVE) / 2;
    if bytes > room {
        return Err(SetupError::StackTooSmall { wanted: bytes, room });
    }
    if bytes > 0 {
        touch(bytes.div_ceil(FRAME));
    }
    Ok(())
}

/// Makes the C library's allocator keep what it has, for node bodies that allocate: freed memory never returns
/// to the kernel, and large blocks come from the heap instead of a mapping of their own. After a warm-up,
/// allocation then makes no system call and faults no page.
///
/// Each thread keeps its own arena, because one arena would let an ordinary thread that holds its lock delay a
/// lane. Call it before the first thread starts. Another allocator (`LD_PRELOAD`) is not affected.
///
/// # Errors
///
/// [`SetupError::System`] if the C library does not know the settings.
pub fn malloc_for_real_time() -> Result<(), SetupError> {
    for (option, value) in [(libc::M_TRIM_THRESHOLD, -1), (libc::M_MMAP_MAX, 0)] {
        if !sys::set_malloc_option(option, value) {
            let fix = "run with glibc's allocator, which has these settings; that of a sanitizer has not";
            return Err(SetupError::System { call: "mallopt", errno: Errno::EINVAL, fix });
        }
    }
    Ok(())
}

/// Undoes [`lock_memory`] and [`malloc_for_real_time`]: nothing is locked, the two settings of glibc's allocator are the
/// documented defaults, and it gives back what it kept. Soft limits stay raised. Takes a moment for each MiB that was kept.
pub(crate) fn memory_by_default() {
    // Neither fails where the other way went well.
    let _unlocked = munlockall();
    for (option, value) in [(libc::M_TRIM_THRESHOLD, 128 << 10), (libc::M_MMAP_MAX, 1 << 16)] {
        sys::set_malloc_option(option, value);
    }
    sys::trim_heap();
}

/// Makes a write beyond the limit of file sizes (`ulimit -f`) an error, as on a full disk, instead of the end of the
/// process in the middle of a run. For the whole process; to be called at its start.
///
/// # Errors
///
/// [`SetupError::System`] if the kernel refuses it.
pub fn file_size_limit_is_an_error() -> Result<(), SetupError> {
    let fix = "allow sigaction in the seccomp filter of the container";
    sys::ignore(Signal::SIGXFSZ).map_err(|errno| SetupError::System {
        call: "sigaction(SIGXFSZ)",
        errno,
        fix,
    })
}

/// While it lives, no CPU enters an idle state that takes time to leave.
#[derive(Debug)]
#[must_use = "the request ends when this is dropped"]
pub struct CpuDmaLatency {
    _request: File,
}

/// Asks the kernel to keep all CPUs in idle states that are left at once. Costs power and heat.
///
/// # Errors
///
/// [`SetupError::NotPermitted`] for an ordinary user, [`SetupError::System`] where the device does not exist.
pub fn hold_cpu_dma_latency() -> Result<CpuDmaLatency, SetupError> {
    let hold = || -> io::Result<CpuDmaLatency> {
        let mut request = File::options().write(true).open(CPU_DMA_LATENCY)?;
        // Microseconds, in the kernel's binary form.
        request.write_all(&0_i32.to_ne_bytes())?;
        Ok(CpuDmaLatency { _request: request })
    };
    hold().map_err(|error| {
        let errno = Errno::from_raw(error.raw_os_error().unwrap_or_default());
        let otherwise = "use a kernel with CONFIG_CPU_IDLE and PM QoS, or boot with processor.max_cstate=1";
        SetupError::of("open(/dev/cpu_dma_latency)", errno, FIX_DMA_LATENCY, otherwise)
    })
}

#[cfg(test)]
mod tests;
