//! Where and under which scheduling policy the measurements run.

use std::fmt;
use std::io;
use std::mem;
use std::time::Duration;

use crate::not_run::NotRun;

/// Priority of every measuring thread, and of cyclictest beside them.
pub(crate) const PRIORITY: i32 = 80;

/// The CPUs and rights that this process has.
pub(crate) struct Machine {
    /// CPU of each lane. Lane 0, the measuring thread, takes the last one, away from the interrupts that
    /// systems tend to route to the first.
    pub(crate) lanes: Vec<usize>,
    /// Whether threads may become SCHED_FIFO.
    pub(crate) realtime: bool,
}

impl Machine {
    /// The CPUs of this process, and no real-time rights.
    ///
    /// # Errors
    ///
    /// The affinity of this process cannot be read.
    pub(crate) fn best_effort() -> io::Result<Self> {
        let mut lanes = usable_cpus()?;
        lanes.reverse();
        Ok(Self { lanes, realtime: false })
    }

    /// Makes the calling thread lane 0, with real-time rights where it can have them.
    ///
    /// # Errors
    ///
    /// The affinity of this process cannot be read or set.
    pub(crate) fn enter() -> io::Result<Self> {
        let realtime = become_fifo().and_then(|()| lock_memory()).is_ok();
        let machine = Self { realtime, ..Self::best_effort()? };
        machine.become_lane(0)?;
        Ok(machine)
    }

    /// Whether so many lanes have a CPU each; without, their spinning threads would starve each other.
    ///
    /// # Errors
    ///
    /// How many CPUs are wanted.
    pub(crate) fn has_lanes(&self, lanes: usize) -> Result<(), NotRun> {
        let usable = self.lanes.len();
        if lanes <= usable {
            return Ok(());
        }
        Err(NotRun::Failed(format!("{lanes} lanes need as many usable CPUs, and there are {usable}")))
    }

    /// Pins the calling thread to the CPU of `lane`, with the priority of the measurement where rights allow.
    /// Lanes beyond the CPUs share the first.
    ///
    /// # Errors
    ///
    /// The kernel's refusal.
    pub(crate) fn become_lane(&self, lane: usize) -> io::Result<()> {
        allow(&[self.lanes[lane % self.lanes.len()]])?;
        if self.realtime { become_fifo() } else { Ok(()) }
    }

    /// Makes the calling thread an ordinary one on any CPU of this process.
    ///
    /// # Errors
    ///
    /// The kernel's refusal.
    pub(crate) fn become_ordinary(&self) -> io::Result<()> {
        set_policy(libc::SCHED_OTHER, 0)?;
        allow(&self.lanes)
    }
}

/// Processor time of all threads of this process, and of its children that have ended.
pub(crate) fn cpu_time() -> Duration {
    let used = |who| {
        let mut usage = mem::MaybeUninit::uninit();
        // SAFETY: the kernel writes one structure, for which there is room.
        let status = unsafe { libc::getrusage(who, usage.as_mut_ptr()) };
        assert_eq!(status, 0, "both subjects are known to every kernel");
        // SAFETY: the call has succeeded, so all of it was written.
        let usage: libc::rusage = unsafe { usage.assume_init() };
        let time = |time: libc::timeval| {
            Duration::from_secs(time.tv_sec as u64) + Duration::from_micros(time.tv_usec as u64)
        };
        time(usage.ru_utime) + time(usage.ru_stime)
    };
    used(libc::RUSAGE_SELF) + used(libc::RUSAGE_CHILDREN)
}

impl fmt::Display for Machine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "lanes on CPUs {:?}, ", self.lanes)?;
        if self.realtime {
            write!(out, "SCHED_FIFO {PRIORITY}, memory locked")
        } else {
            write!(
                out,
                "best effort: no real-time rights (run as root, or with CAP_SYS_NICE and CAP_IPC_LOCK)"
            )
        }
    }
}

fn check(status: libc::c_int) -> io::Result<()> {
    if status == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

fn empty_set() -> libc::cpu_set_t {
    // SAFETY: a CPU set is an array of integers, for which all zero is the empty set.
    unsafe { mem::zeroed() }
}

fn usable_cpus() -> io::Result<Vec<usize>> {
    let mut set = empty_set();
    // SAFETY: the kernel writes at most the size that is passed, into a set of that size.
    check(unsafe { libc::sched_getaffinity(0, mem::size_of_val(&set), &raw mut set) })?;
    // SAFETY: the index stays below the capacity of the set.
    let member = |&cpu: &usize| unsafe { libc::CPU_ISSET(cpu, &set) };
    Ok((0..libc::CPU_SETSIZE as usize).filter(member).collect())
}

fn allow(cpus: &[usize]) -> io::Result<()> {
    let mut set = empty_set();
    for &cpu in cpus {
        // SAFETY: `cpu` came out of a set of the same capacity.
        unsafe { libc::CPU_SET(cpu, &mut set) };
    }
    // SAFETY: the set is initialised and lives through the call.
    check(unsafe { libc::sched_setaffinity(0, mem::size_of_val(&set), &raw const set) })
}

fn set_policy(policy: libc::c_int, priority: libc::c_int) -> io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: the parameters live through the call.
    check(unsafe { libc::sched_setscheduler(0, policy, &raw const parameters) })
}

fn become_fifo() -> io::Result<()> {
    set_policy(libc::SCHED_FIFO, PRIORITY)
}

fn lock_memory() -> io::Result<()> {
    // SAFETY: takes no pointer.
    check(unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
}
