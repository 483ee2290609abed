//! `CLOCK_MONOTONIC`, the only clock that the runtime goes by, and what tells of its absence.

use nix::time::{ClockId, clock_gettime};

/// The present, in nanoseconds of `CLOCK_MONOTONIC`.
///
/// The clock counts from boot, never jumps, and stands still while the machine is suspended. One call costs
/// about 20 ns where the clock source is the CPU's counter and no system call is needed.
///
/// # Panics
///
/// On a kernel without `CLOCK_MONOTONIC`, which Linux has had since 2.6.
#[must_use]
pub fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::CLOCK_MONOTONIC).expect("every supported Linux has CLOCK_MONOTONIC");
    // Time since boot: neither part is ever negative.
    now.tv_sec().unsigned_abs() * 1_000_000_000 + now.tv_nsec().unsigned_abs()
}

/// How long the calling thread has run, in nanoseconds. One call is a system call.
///
/// # Panics
///
/// On a kernel without `CLOCK_THREAD_CPUTIME_ID`, which Linux has had since 2.6.12.
pub(crate) fn thread_ns() -> u64 {
    let used = clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .expect("every supported Linux has CLOCK_THREAD_CPUTIME_ID");
    used.tv_sec().unsigned_abs() * 1_000_000_000 + used.tv_nsec().unsigned_abs()
}

/// How long the machine was suspended since boot, in nanoseconds: what `CLOCK_MONOTONIC` leaves out. Two readings tell
/// of a suspension between them; a difference of microseconds is that of their own two clocks.
///
/// # Panics
///
/// On a kernel without `CLOCK_BOOTTIME`, which Linux has had since 2.6.39.
#[must_use]
pub fn suspended_ns() -> u64 {
    let boot = clock_gettime(ClockId::CLOCK_BOOTTIME).expect("every supported Linux has CLOCK_BOOTTIME");
    (boot.tv_sec().unsigned_abs() * 1_000_000_000 + boot.tv_nsec().unsigned_abs()).saturating_sub(now_ns())
}

#[cfg(test)]
mod tests;
