//! Allowance: a lane that is always busy runs some bodies as an ordinary thread, before the kernel stops it for long.
//!
//! *Background.* Of each period (1 s) the kernel lets the real-time threads of a CPU run for 950 ms, unless told otherwise. Who
//! has used this up stands still until the period is over: 50 ms at once, in which every job of a shorter deadline is lost,
//! whatever its value. See sched(7) and the kernel's `sched-rt-group.rst`.
//! *Rule.* A leaky bucket: what a lane uses of its CPU under SCHED_FIFO flows in, and a little less than what the kernel allows
//! flows out. A body that begins while it overflows runs under SCHED_OTHER, with the least nice value that is granted. The
//! lane's turns with the scheduler do not: other lanes would wait for a lock that an ordinary thread holds.
//! *Why it holds.* In no time of a period's length is more used than flows out, the bucket holds, and one body makes it overflow
//! by; whenever the kernel's periods begin. By the usual limit that is enough for bodies of up to 60 ms.
//! *Cost.* By the usual limit ordinary threads on the CPU of a lane that is always busy can delay a body of 10 ms in every
//! 100 ms, and 6 % of shorter ones. On a lane that idles for 6 % of any 80 ms they never can.

use crate::clock::{now_ns, thread_ns};
use crate::preflight::RealTimeBudget;
use crate::sys::{self, Policy};
use nix::unistd::Pid;

/// Not worth a look.
const SHORTEST_NS: u64 = 200_000;

/// What a lane has used of what the kernel allows it, and when it does without.
#[derive(Debug)]
pub(crate) struct Allowance {
    /// What it uses of each period under SCHED_FIFO if it never idles.
    budget_ns: u64,
    period_ns: u64,
    /// What the bucket holds before it overflows.
    room_ns: u64,
    level_ns: u64,
    /// The last look.
    seen: Reading,
    priority: u8,
    /// Whether it is under SCHED_FIFO.
    is_fifo: bool,
    /// CPU time of bodies that ran under SCHED_OTHER.
    pub(crate) ordinary_ns: u64,
}

/// The present, and the CPU time that the thread had until then.
#[derive(Clone, Copy, Debug)]
struct Reading {
    now_ns: u64,
    used_ns: u64,
}

impl Allowance {
    /// Of the calling thread, which has this priority, from now on. `None`: the kernel never stops it.
    pub(crate) fn of_thread(budget: RealTimeBudget, priority: u8) -> Option<Self> {
        let allowance = Self::new(budget, priority, Reading { now_ns: now_ns(), used_ns: thread_ns() });
        // Without the right to it, ordinary threads get the half of such bodies' time.
        allowance.inspect(|_| sys::least_nice())
    }

    fn new(
        RealTimeBudget { runtime_ns, period_ns }: RealTimeBudget,
        priority: u8,
        start: Reading,
    ) -> Option<Self> {
        // For the bucket, and for other real-time threads: the watchdog.
        let kept_ns = (period_ns / 100).min(runtime_ns / 5);
        (0 < kept_ns && runtime_ns < period_ns).then(|| Self {
            budget_ns: runtime_ns - kept_ns,
            period_ns,
            room_ns: kept_ns / 2,
            level_ns: 0,
            seen: start,
            priority,
            is_fifo: true,
            ordinary_ns: 0,
        })
    }

    /// Before a body that begins at about `now_ns` of `CLOCK_MONOTONIC`: leaves SCHED_FIFO for it, if need be.
    pub(crate) fn before_body(&mut self, now_ns: u64) {
        if self.is_fifo
            && now_ns.saturating_sub(self.seen.now_ns) >= SHORTEST_NS
            && self.is_used_up(Reading { now_ns, used_ns: thread_ns() })
        {
            self.is_fifo = sys::set_policy(Pid::from_raw(0), Policy::Ordinary).is_err();
        }
    }

    /// After a body that ended at about `now_ns`: back to SCHED_FIFO. Where that is refused by now, the next body tries again.
    pub(crate) fn after_body(&mut self, now_ns: u64) {
        if !self.is_fifo {
            self.ran_ordinary(Reading { now_ns, used_ns: thread_ns() });
            self.is_fifo = sys::set_policy(Pid::from_raw(0), Policy::Fifo(self.priority)).is_ok();
        }
    }

    /// Whether a body is to run under SCHED_OTHER.
    fn is_used_up(&mut self, now: Reading) -> bool {
        let used_ns = now.used_ns.saturating_sub(self.seen.used_ns);
        let passed_ns = now.now_ns.saturating_sub(self.seen.now_ns);
        self.seen = now;
        // It idled first: what flowed out of an empty bucket is nothing for the body to fill.
        self.level_ns = self.level_ns.saturating_sub(self.out(passed_ns.saturating_sub(used_ns)));
        // A body that runs for longer than a period is stopped by the kernel itself: not all of it is to be made up for.
        let most_ns = self.room_ns + self.period_ns - self.budget_ns;
        self.level_ns = self.level_ns.saturating_add(used_ns - self.out(used_ns)).min(most_ns);
        self.level_ns > self.room_ns
    }

    fn ran_ordinary(&mut self, now: Reading) {
        self.ordinary_ns += now.used_ns.saturating_sub(self.seen.used_ns);
        self.level_ns = self.level_ns.saturating_sub(self.out(now.now_ns.saturating_sub(self.seen.now_ns)));
        self.seen = now;
    }

    /// What flows out in a time.
    fn out(&self, time_ns: u64) -> u64 {
        let out = u128::from(time_ns) * u128::from(self.budget_ns) / u128::from(self.period_ns);
        u64::try_from(out).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests;
