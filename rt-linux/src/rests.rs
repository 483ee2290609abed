//! Rests: a lane that is always busy sleeps a little after bodies, before the kernel stops it for long.
//!
//! *Background.* Of each period (1 s) the kernel lets the real-time threads of a CPU run for 950 ms, unless told otherwise. Who
//! has used this up stands still until the period is over: 50 ms at once, in which every job of a shorter deadline is lost,
//! whatever its value. See sched(7) and the kernel's `sched-rt-group.rst`.
//! *Rule.* A leaky bucket: what a lane uses of its CPU flows in, and a little less than what the kernel allows flows out. After
//! a body that makes it overflow the lane sleeps until it does no more.
//! *Why it holds.* In no time of a period's length is more used than flows out, the bucket holds, and one body makes it overflow
//! by; whenever the kernel's periods begin. By the usual limit that is enough for bodies of up to 60 ms.
//! *Cost.* By the usual limit a lane that is always busy runs for 94 % of the time, in slices; one that idles for 6 % of any
//! 80 ms never rests.

use crate::clock::{now_ns, thread_ns};
use crate::preflight::RealTimeBudget;
use core::time::Duration;

/// Not worth a look, nor a sleep.
const SHORTEST_NS: u64 = 200_000;

/// What a lane used of its CPU, and how long it rests.
#[derive(Debug)]
pub(crate) struct Rests {
    /// What it uses of each period if it never idles.
    budget_ns: u64,
    period_ns: u64,
    /// What the bucket holds before it overflows.
    room_ns: u64,
    level_ns: u64,
    /// The last look.
    seen: Reading,
    /// How long it rested so far.
    pub(crate) rested_ns: u64,
}

/// The present, and the CPU time that the thread had until then.
#[derive(Clone, Copy, Debug)]
struct Reading {
    now_ns: u64,
    used_ns: u64,
}

impl Rests {
    /// Of the calling thread, from now on. `None`: the kernel never stops it.
    pub(crate) fn of_thread(budget: RealTimeBudget) -> Option<Self> {
        Self::new(budget, Reading { now_ns: now_ns(), used_ns: thread_ns() })
    }

    fn new(RealTimeBudget { runtime_ns, period_ns }: RealTimeBudget, start: Reading) -> Option<Self> {
        // For the bucket, and for other real-time threads: the watchdog.
        let kept_ns = (period_ns / 100).min(runtime_ns / 5);
        (0 < kept_ns && runtime_ns < period_ns).then(|| Self {
            budget_ns: runtime_ns - kept_ns,
            period_ns,
            room_ns: kept_ns / 2,
            level_ns: 0,
            seen: start,
            rested_ns: 0,
        })
    }

    /// Sleeps, if it is time for it, after a body that ended at about `now_ns` of `CLOCK_MONOTONIC`. Whether it did.
    pub(crate) fn rest(&mut self, now_ns: u64) -> bool {
        if now_ns.saturating_sub(self.seen.now_ns) < SHORTEST_NS {
            return false;
        }
        let rest_ns = self.owed(Reading { now_ns, used_ns: thread_ns() });
        if rest_ns > 0 {
            std::thread::sleep(Duration::from_nanos(rest_ns));
        }
        rest_ns > 0
    }

    /// How long it has to rest now.
    fn owed(&mut self, now: Reading) -> u64 {
        let used_ns = now.used_ns.saturating_sub(self.seen.used_ns);
        let passed_ns = now.now_ns.saturating_sub(self.seen.now_ns);
        self.seen = now;
        let out = |time_ns: u64| scaled(time_ns, self.budget_ns, self.period_ns);
        // It idled first: what flowed out of an empty bucket is nothing for the body to fill.
        self.level_ns = self.level_ns.saturating_sub(out(passed_ns.saturating_sub(used_ns)));
        // A body that runs for longer than a period is stopped by the kernel itself: it does not have to rest for all of it.
        let most_ns = self.room_ns + self.period_ns - self.budget_ns;
        self.level_ns = self.level_ns.saturating_add(used_ns - out(used_ns)).min(most_ns);
        let over_ns = self.level_ns.saturating_sub(self.room_ns);
        let rest_ns = scaled(over_ns, self.period_ns, self.budget_ns);
        if rest_ns < SHORTEST_NS {
            return 0;
        }
        self.rested_ns += rest_ns;
        rest_ns
    }
}

/// `time * by / of`.
fn scaled(time_ns: u64, by: u64, of: u64) -> u64 {
    u64::try_from(u128::from(time_ns) * u128::from(by) / u128::from(of)).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
