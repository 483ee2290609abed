//! Ticks of embassy's time driver and nanoseconds of the scheduler; 64-bit ticks of a 32-bit counter.

use core::cell::Cell;

use critical_section::Mutex;
use embassy_time_driver::TICK_HZ;
use red_core::Instant;

const NANOS_PER_SECOND: u64 = 1_000_000_000;

/// Makes 64-bit ticks of a counter that wraps after 2^32, by counting its wraps. For time drivers.
///
/// It has to be asked at least once between two wraps, best by the counter's own interrupt when it wraps.
///
/// ```
/// let ticks = red_embassy::TickExtension::new();
/// assert_eq!(ticks.extend(|| u32::MAX), 0xFFFF_FFFF);
/// assert_eq!(ticks.extend(|| 5), 0x1_0000_0005);
/// ```
#[derive(Debug)]
pub struct TickExtension(Mutex<Cell<u64>>);

impl TickExtension {
    /// No wrap yet.
    #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(0)))
    }

    /// The ticks now; `read` reads the counter. It is read inside the critical section: a value that another
    /// reader overtook would look like a wrap.
    pub fn extend(&self, read: impl FnOnce() -> u32) -> u64 {
        critical_section::with(|cs| {
            let seen = self.0.borrow(cs);
            let (wraps, last) = (seen.get() >> 32, seen.get() as u32);
            let count = read();
            let now = (wraps + u64::from(count < last)) << 32 | u64::from(count);
            seen.set(now);
            now
        })
    }
}

/// Now, on the scheduler's clock.
pub fn now() -> Instant {
    from_ticks(embassy_time_driver::now())
}

/// An instant of embassy's clock on the scheduler's, rounded down.
pub fn from_ticks(ticks: u64) -> Instant {
    Instant::from_nanos(nanos(ticks, TICK_HZ))
}

/// The first tick that is not before an instant: who wakes there finds that it has come.
pub fn ticks_until(at: Instant) -> u64 {
    ticks(at.as_nanos(), TICK_HZ, u64::div_ceil)
}

/// The last tick that is not after an instant: what deadlines are compared by.
pub(crate) fn deadline_ticks(at: Instant) -> u64 {
    ticks(at.as_nanos(), TICK_HZ, |a, b| a / b)
}

// Seconds and the rest apart: no division of 128 bits, which takes these processors long.

fn nanos(ticks: u64, hz: u64) -> u64 {
    let (seconds, rest) = (ticks / hz, ticks % hz);
    seconds.saturating_mul(NANOS_PER_SECOND).saturating_add(rest * NANOS_PER_SECOND / hz)
}

fn ticks(nanos: u64, hz: u64, divide: impl Fn(u64, u64) -> u64) -> u64 {
    let (seconds, rest) = (nanos / NANOS_PER_SECOND, nanos % NANOS_PER_SECOND);
    seconds.saturating_mul(hz).saturating_add(divide(rest * hz, NANOS_PER_SECOND))
}

#[cfg(test)]
mod tests;
