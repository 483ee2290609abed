//! Sleeping to an absolute time.

use crate::bell::{Bell, Woken};
use crate::primitive::now_ns;
use crate::spin_lead::SpinLead;

/// The waits of one thread: on time where the thread has its CPU to itself, without spinning where it shares it.
///
/// Times are absolute, so a signal or a stopped process never shifts a later wake-up.
#[derive(Clone, Debug)]
pub struct Sleeper {
    lead: Option<SpinLead>,
}

impl Sleeper {
    /// For a thread with a CPU of its own: spins the last, self-calibrated part of every wait.
    #[must_use]
    pub const fn spinning() -> Self {
        Self { lead: Some(SpinLead::new()) }
    }

    /// For a thread that shares its CPU: never spins, because it would take the time from whom it waits for.
    #[must_use]
    pub const fn yielding() -> Self {
        Self { lead: None }
    }

    /// Sleeps until `at_ns`; returns how late it is then, in nanoseconds.
    pub fn sleep_until(&mut self, at_ns: u64) -> u64 {
        let nobody = Bell::new();
        let Woken::TimedOut = self.wait(&nobody, || false, Some(at_ns), 0) else {
            unreachable!("nobody else knows this bell");
        };
        now_ns().saturating_sub(at_ns)
    }

    /// Waits until `bell` is rung, `ready` holds ([`Bell::wait_for`]) or `until` (nanoseconds of `CLOCK_MONOTONIC`)
    /// has come.
    ///
    /// `spin_ns` is for the ring: how long to spin for it before going to sleep. A yielding sleeper ignores it.
    pub fn wait(&mut self, bell: &Bell, ready: impl Fn() -> bool, until: Option<u64>, spin_ns: u64) -> Woken {
        match (self.sleep(bell, &ready, until, spin_ns), until) {
            (Woken::TimedOut, Some(at_ns)) => bell.spin(ready, at_ns),
            (woken, _) => woken,
        }
    }

    /// The first part of [`Sleeper::wait`]: ends the spin lead before `until`, for who has something to prepare for
    /// that time, and then spins with [`Bell::spin`].
    pub fn sleep(
        &mut self,
        bell: &Bell,
        ready: impl Fn() -> bool,
        until: Option<u64>,
        spin_ns: u64,
    ) -> Woken {
        let Some(lead) = &mut self.lead else {
            return bell.wait_for(ready, until, 0);
        };
        let Some(at_ns) = until else {
            return bell.wait_for(ready, None, spin_ns);
        };
        let early_ns = at_ns.saturating_sub(lead.begin(at_ns));
        let now = now_ns();
        if early_ns > now.saturating_add(spin_ns) {
            if bell.wait_for(ready, Some(early_ns), spin_ns) == Woken::Rung {
                return Woken::Rung;
            }
            lead.woke(now_ns().saturating_sub(early_ns));
        } else if at_ns > now {
            lead.skipped();
        }
        Woken::TimedOut
    }

    /// The present spin lead in nanoseconds; 0 for a yielding sleeper.
    #[must_use]
    pub fn lead_ns(&self) -> u64 {
        self.lead.as_ref().map_or(0, SpinLead::lead_ns)
    }
}

#[cfg(test)]
mod tests;
