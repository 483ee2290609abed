//! Reads of the kernel's clocks.

/// Which clock.
#[derive(Clone, Copy)]
#[repr(i32)]
pub(crate) enum Clock {
    /// Time since boot, steady.
    Monotonic = libc::CLOCK_MONOTONIC,
    /// CPU time that the calling thread has used.
    Thread = libc::CLOCK_THREAD_CPUTIME_ID,
}

impl Clock {
    /// Nanoseconds since the clock's epoch.
    pub(crate) fn now_ns(self) -> u64 {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `time` is a live timespec. Both clocks exist on every Linux, so the call cannot fail.
        unsafe { libc::clock_gettime(self as i32, &raw mut time) };
        time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
    }
}
