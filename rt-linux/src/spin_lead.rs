//! How long before a wake-up time to stop sleeping and start spinning.
//!
//! # Background
//!
//! A sleeping thread runs again some time after its timer expired: 10 to 100 us, depending on the machine, its
//! idle states and its load. A thread that sleeps to `at - lead` and spins the rest is on time whenever the
//! lateness of that sleep was below `lead`. No constant fits two machines, so the lead is learned.
//!
//! # Rule
//!
//! `lead = min(late99, typical + 3 % of interval, 250 us)`
//!
//! * `late99` follows the 99th percentile of the lateness. A wake-up above it raises it by 99 steps, one below
//!   lowers it by one; at rest the two balance, which is when one in a hundred is above. A step is 1/1024 of the
//!   value, so it converges at the same pace on every machine and forgets in about a thousand wake-ups. The
//!   size of an outlier does not matter, only that it happened.
//! * `typical` is the running mean of `min(lateness, lead)`: the part of the lead that is spent asleep.
//! * `interval` is the running mean of the time from one wake-up to the next.
//!
//! # Why it holds
//!
//! A wake-up that was `late` spins `lead - min(late, lead)`, on average `lead - typical`. The second term of
//! the minimum therefore keeps the mean spin at or below 3 % of the interval: 30 us at 1 kHz. A wait so short
//! that it is not worth sleeping spins at most the lead and counts as a lateness of 0, which lowers `typical`
//! until such waits sleep. The third term bounds one spin when wake-ups are rare.

/// Spin time over elapsed time, at most.
const SHARE_PERCENT: u64 = 3;
/// One spin, at most, in nanoseconds.
const MAX_LEAD_NS: u64 = 250_000;
/// Before anything was measured: enough for a quiet virtual machine.
const FIRST_LEAD_NS: u64 = 50_000;
/// An interval above this changes nothing, because [`MAX_LEAD_NS`] binds first.
const MAX_INTERVAL_NS: u64 = MAX_LEAD_NS * 100 / SHARE_PERCENT;

/// The learned lead of one thread. Integers only, no allocation, a few instructions per call.
#[derive(Clone, Debug)]
pub struct SpinLead {
    late99_ns: u64,
    typical: Mean,
    interval: Mean,
    at_ns: u64,
    previous_at_ns: Option<u64>,
}

impl SpinLead {
    /// A lead of 50 us for 1 kHz, to be corrected by what is observed.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            late99_ns: FIRST_LEAD_NS,
            typical: Mean::of(FIRST_LEAD_NS / 2),
            interval: Mean::of(1_000_000),
            at_ns: 0,
            previous_at_ns: None,
        }
    }

    /// The present lead in nanoseconds.
    #[must_use]
    pub fn lead_ns(&self) -> u64 {
        let affordable = self.typical.get() + self.interval.get() * SHARE_PERCENT / 100;
        self.late99_ns.min(affordable).min(MAX_LEAD_NS)
    }

    /// A wait to `at_ns` begins; returns the lead for it in nanoseconds. A wait that then ends before its time
    /// teaches nothing.
    pub fn begin(&mut self, at_ns: u64) -> u64 {
        self.at_ns = at_ns;
        self.lead_ns()
    }

    /// The sleep of this wait ended `late_ns` after its time.
    pub fn woke(&mut self, late_ns: u64) {
        self.came();
        self.typical.add(late_ns.min(self.lead_ns()));
        let step = self.late99_ns / 1024 + 1;
        self.late99_ns = if late_ns > self.late99_ns {
            (self.late99_ns + 99 * step).min(MAX_LEAD_NS)
        } else {
            self.late99_ns.saturating_sub(step)
        };
    }

    /// The wait was too short to sleep.
    pub fn skipped(&mut self) {
        self.came();
        self.typical.add(0);
    }

    fn came(&mut self) {
        if let Some(previous) = self.previous_at_ns.replace(self.at_ns) {
            self.interval.add(self.at_ns.saturating_sub(previous).min(MAX_INTERVAL_NS));
        }
    }
}

impl Default for SpinLead {
    fn default() -> Self {
        Self::new()
    }
}

/// Exponential mean with weight 1/16, kept 16-fold so that small differences are not rounded away.
#[derive(Clone, Debug)]
struct Mean(u64);

impl Mean {
    const fn of(value: u64) -> Self {
        Self(value * 16)
    }

    const fn get(&self) -> u64 {
        self.0 / 16
    }

    fn add(&mut self, value: u64) {
        self.0 = self.0 - self.0 / 16 + value;
    }
}

#[cfg(test)]
mod tests;
