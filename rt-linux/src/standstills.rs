//! Times in which the whole run got no CPU: the process was halted, throttled, or out of its quota.
//!
//! *How it is seen.* The watchdog, the most urgent thread, says when it will look next. Where that instant has passed by
//! more than [`SHORTEST_NS`] and no lane took a turn since, nothing ran. Who notices first counts it: the watchdog, or a lane
//! whose body has just come back.
//! *What follows.* No body is blamed: the time is left out of its bound, its overruns and its estimate. Deadlines stay.

use core::sync::atomic::{AtomicU64, Ordering};

/// A look that comes later than this was kept from its CPU: longer than what one thread of higher priority takes.
pub(crate) const SHORTEST_NS: u64 = 20_000_000;

/// What was seen of them so far.
#[derive(Debug, Default)]
pub(crate) struct Standstills {
    count: AtomicU64,
    longest_ns: AtomicU64,
    total_ns: AtomicU64,
    /// When the watchdog will look next, on `CLOCK_MONOTONIC`; 0: it does not yet.
    due_ns: AtomicU64,
}

impl Standstills {
    /// How many, and the longest in nanoseconds.
    pub(crate) fn told(&self) -> (u64, u64) {
        (self.count.load(Ordering::Relaxed), self.longest_ns.load(Ordering::Relaxed))
    }

    /// All of them together, in nanoseconds.
    pub(crate) fn total_ns(&self) -> u64 {
        // Acquire: partner of the Release in `look`; who waits for a look that is counted sees its time.
        self.total_ns.load(Ordering::Acquire)
    }

    /// The watchdog will look at this instant.
    pub(crate) fn expect(&self, due_ns: u64) {
        self.due_ns.store(due_ns, Ordering::Relaxed);
    }

    /// Counts the standstill that ends now, if there is one that nobody counted. `last_turn` says when a lane last took a
    /// turn; it is asked only where a look is late.
    pub(crate) fn look(&self, now_ns: u64, last_turn: impl FnOnce() -> u64) {
        let due = self.due_ns.load(Ordering::Relaxed);
        if due == 0 || now_ns.saturating_sub(due) <= SHORTEST_NS {
            return;
        }
        let stood_ns = now_ns.saturating_sub(due.max(last_turn()));
        let is_first =
            || self.due_ns.compare_exchange(due, now_ns, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if stood_ns > SHORTEST_NS && is_first() {
            self.count.fetch_add(1, Ordering::Relaxed);
            self.longest_ns.fetch_max(stood_ns, Ordering::Relaxed);
            self.total_ns.fetch_add(stood_ns, Ordering::Release);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_standstill_is_counted_once_by_whoever_sees_it_first() {
        let standstills = Standstills::default();
        standstills.look(500 * MS, || 0);
        assert_eq!(standstills.told(), (0, 0), "before the watchdog looks");
        standstills.expect(1_000 * MS);
        standstills.look(1_020 * MS, || 0);
        assert_eq!(standstills.told(), (0, 0), "as late as a thread of higher priority makes it");
        standstills.look(1_300 * MS, || 900 * MS);
        standstills.look(1_301 * MS, || 900 * MS);
        assert_eq!((standstills.told(), standstills.total_ns()), ((1, 300 * MS), 300 * MS));
    }

    #[test]
    fn where_a_lane_took_a_turn_not_all_stood_still() {
        let standstills = Standstills::default();
        standstills.expect(1_000 * MS);
        standstills.look(1_100 * MS, || 1_090 * MS);
        assert_eq!(standstills.told(), (0, 0), "the watchdog alone was kept from its CPU");
        standstills.look(1_100 * MS, || 1_040 * MS);
        assert_eq!(standstills.told(), (1, 60 * MS));
    }
}
