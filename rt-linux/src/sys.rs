#![allow(unsafe_code, reason = "the system calls that nix lacks")]
//! Every libc call that nix lacks, each behind a safe function.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::AtomicU32;

use libc::c_int;
use nix::errno::Errno;
use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal};
use nix::unistd::Pid;

/// Sleeps while `word` is `expected`, until somebody wakes it or `until` (nanoseconds of `CLOCK_MONOTONIC`) has
/// come. Returns whether the time came. May return early for no reason.
pub(crate) fn futex_wait(word: &AtomicU32, expected: u32, until: Option<u64>) -> bool {
    let time = until.map(timespec);
    let time = time.as_ref().map_or(ptr::null(), ptr::from_ref);
    // Not FUTEX_WAIT, whose time-out is relative and would grow by every signal.
    let operation = libc::FUTEX_WAIT_BITSET | libc::FUTEX_PRIVATE_FLAG;
    // SAFETY: `word` is borrowed for the call and aligned; `time` is null or points to a timespec that lives
    // until the end of this function; the fifth argument is ignored by this operation.
    let result = unsafe {
        libc::syscall(
            libc::SYS_futex,
            word.as_ptr(),
            operation,
            expected,
            time,
            ptr::null::<u32>(),
            libc::FUTEX_BITSET_MATCH_ANY,
        )
    };
    result == -1 && Errno::last() == Errno::ETIMEDOUT
}

/// Wakes one thread that sleeps on `word`.
pub(crate) fn futex_wake(word: &AtomicU32) {
    // SAFETY: the kernel uses the address as a key only; `word` is borrowed for the call.
    unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), libc::FUTEX_WAKE | libc::FUTEX_PRIVATE_FLAG, 1) };
}

fn timespec(at_ns: u64) -> libc::timespec {
    // u64::MAX nanoseconds are 585 years: both parts fit their types on every 64-bit Linux.
    libc::timespec {
        tv_sec: (at_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (at_ns % 1_000_000_000).cast_signed(),
    }
}

/// Whether so many bytes more of address space can be had. Nothing is touched, and they are given back.
pub(crate) fn has_address_space(bytes: usize) -> bool {
    let (flags, access) = (libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE, libc::PROT_NONE);
    // SAFETY: a mapping of its own, at an address that the kernel chooses.
    let at = unsafe { libc::mmap(ptr::null_mut(), bytes, access, flags, -1, 0) };
    if at == libc::MAP_FAILED {
        return false;
    }
    // SAFETY: mapped above, and nobody else knows of it.
    unsafe { libc::munmap(at, bytes) };
    true
}

/// How the kernel picks when a thread runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Policy {
    /// `SCHED_FIFO` at this priority.
    Fifo(u8),
    /// `SCHED_OTHER`.
    Ordinary,
    /// `SCHED_IDLE`: only when nobody else wants the CPU.
    Idle,
}

/// Sets the policy of the thread `thread`; 0 is the calling one.
pub(crate) fn set_policy(thread: Pid, policy: Policy) -> Result<(), Errno> {
    let (policy, priority) = match policy {
        Policy::Fifo(priority) => (libc::SCHED_FIFO, priority),
        Policy::Ordinary => (libc::SCHED_OTHER, 0),
        Policy::Idle => (libc::SCHED_IDLE, 0),
    };
    let parameters = libc::sched_param { sched_priority: c_int::from(priority) };
    // Children of a lane start as ordinary threads. Set for every policy, because taking the flag back needs
    // a right that the demotion of a hung lane must not depend on.
    let policy = policy | libc::SCHED_RESET_ON_FORK;
    // SAFETY: `parameters` lives for the call and is only read.
    let result = unsafe { libc::sched_setscheduler(thread.as_raw(), policy, &raw const parameters) };
    Errno::result(result).map(drop)
}

/// Gives the calling thread the least nice value, if it may have that.
pub(crate) fn least_nice() {
    // SAFETY: takes three integers; of the calling thread, since Linux has these values by thread.
    let _refused = unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, -20) };
}

/// Sets one option of the C library's allocator; returns whether it knows it.
pub(crate) fn set_malloc_option(option: c_int, value: c_int) -> bool {
    // SAFETY: takes two integers and guards its own state.
    unsafe { libc::mallopt(option, value) == 1 }
}

/// Has the C library's allocator give to the kernel what nobody uses.
pub(crate) fn trim_heap() {
    // SAFETY: takes an integer and guards its own state.
    let _something_was = unsafe { libc::malloc_trim(0) };
}

/// Bytes between the caller's frame and the end of its stack.
pub(crate) fn stack_room() -> Result<usize, Errno> {
    let mut attributes = MaybeUninit::<libc::pthread_attr_t>::uninit();
    // SAFETY: no precondition.
    let this = unsafe { libc::pthread_self() };
    // SAFETY: a running thread's handle and room for its attributes.
    check(unsafe { libc::pthread_getattr_np(this, attributes.as_mut_ptr()) })?;
    let (mut lowest, mut size) = (ptr::null_mut(), 0);
    // SAFETY: initialised by the successful call above; both results have their places.
    let read =
        check(unsafe { libc::pthread_attr_getstack(attributes.as_ptr(), &raw mut lowest, &raw mut size) });
    // SAFETY: initialised above, and not used again.
    unsafe { libc::pthread_attr_destroy(attributes.as_mut_ptr()) };
    read?;
    let here = ptr::from_ref(&attributes).addr();
    Ok(here.saturating_sub(lowest.addr()))
}

/// Directs SIGINT or SIGTERM to [`crate::stop::received`]; returns what was there before.
pub(crate) fn catch(signal: Signal) -> Result<SigAction, Errno> {
    extern "C" fn handler(signal: c_int) {
        // The interrupted code may be between a failed call and its look at errno.
        let errno = Errno::last_raw();
        crate::stop::received(signal);
        Errno::set_raw(errno);
    }
    let action = SigAction::new(SigHandler::Handler(handler), SaFlags::SA_RESTART, SigSet::empty());
    // SAFETY: the handler calls only what is async-signal-safe: atomics and one futex system call.
    unsafe { nix::sys::signal::sigaction(signal, &action) }
}

/// Nothing happens where the signal comes; what caused it fails by itself.
pub(crate) fn ignore(signal: Signal) -> Result<(), Errno> {
    let action = SigAction::new(SigHandler::SigIgn, SaFlags::empty(), SigSet::empty());
    // SAFETY: no handler runs.
    unsafe { nix::sys::signal::sigaction(signal, &action) }.map(drop)
}

/// Puts back what [`catch`] returned.
pub(crate) fn restore(signal: Signal, previous: &SigAction) {
    // SAFETY: `previous` was in force before, so its handler is as good as it was then. The call fails only
    // for signals that `catch` refuses too.
    let _ = unsafe { nix::sys::signal::sigaction(signal, previous) };
}

/// A pthread mutex that lends the waiter's priority to its holder.
///
/// Error-checking, so that a thread that locks twice gets an error and not a deadlock, and one that unlocks
/// what it does not hold an error and not undefined behaviour. Boxed, because it must not move.
pub(crate) struct PiMutex(Box<UnsafeCell<libc::pthread_mutex_t>>);

// SAFETY: a pthread mutex may be used from any thread; nothing else is inside.
unsafe impl Send for PiMutex {}
// SAFETY: as above; all access goes through the pthread calls.
unsafe impl Sync for PiMutex {}

impl PiMutex {
    pub(crate) fn new() -> Result<Self, Errno> {
        let mut attributes = MaybeUninit::<libc::pthread_mutexattr_t>::uninit();
        // SAFETY: room for the attributes.
        check(unsafe { libc::pthread_mutexattr_init(attributes.as_mut_ptr()) })?;
        let mutex = Self(Box::new(UnsafeCell::new(libc::PTHREAD_MUTEX_INITIALIZER)));
        // SAFETY: initialised above.
        let made = check(unsafe {
            libc::pthread_mutexattr_setprotocol(attributes.as_mut_ptr(), libc::PTHREAD_PRIO_INHERIT)
        })
        .and_then(|()| {
            // SAFETY: initialised above.
            check(unsafe {
                libc::pthread_mutexattr_settype(attributes.as_mut_ptr(), libc::PTHREAD_MUTEX_ERRORCHECK)
            })
        })
        .and_then(|()| {
            // SAFETY: a fresh mutex at its final address, and initialised attributes.
            check(unsafe { libc::pthread_mutex_init(mutex.0.get(), attributes.as_ptr()) })
        });
        // SAFETY: initialised above, and not used again.
        unsafe { libc::pthread_mutexattr_destroy(attributes.as_mut_ptr()) };
        made.map(|()| mutex)
    }

    /// Fails with `EDEADLK` if the caller holds it already.
    pub(crate) fn lock(&self) -> Result<(), Errno> {
        // SAFETY: initialised by `new`.
        check(unsafe { libc::pthread_mutex_lock(self.0.get()) })
    }

    /// Fails with `EPERM` if the caller does not hold it.
    pub(crate) fn unlock(&self) -> Result<(), Errno> {
        // SAFETY: initialised by `new`.
        check(unsafe { libc::pthread_mutex_unlock(self.0.get()) })
    }
}

impl Drop for PiMutex {
    fn drop(&mut self) {
        // SAFETY: nobody else refers to it; a mutex that is still locked is left alone with an error.
        unsafe { libc::pthread_mutex_destroy(self.0.get()) };
    }
}

/// pthread calls return the error instead of setting errno.
fn check(result: c_int) -> Result<(), Errno> {
    if result == 0 { Ok(()) } else { Err(Errno::from_raw(result)) }
}

#[cfg(test)]
mod tests;
