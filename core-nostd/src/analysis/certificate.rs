//! What was proved about one task alone, by which bound, with which numbers: enough to check it again.

use crate::time::{Duration, Instant, SignedDuration};

crate::capacity::values! {
    /// Which bound a certificate rests on.
    #[non_exhaustive]
    pub enum Bound {
        /// Graham 1969: L + ceil((W - L) / m).
        Graham,
        /// L + ceil((W - len_0 - ... - len_j) / (m - j)), with this many disjoint paths after the longest.
        LongPath {
            /// j: paths peeled after the critical path.
            paths: u8,
        },
        /// Nodes in several pools: floor((1 - 1 / max m) * L) + 1 + the sum over pools of ceil(W_p / m_p).
        SeveralPools,
    }

    /// A bound on the response time of a job that has its pools to itself.
    ///
    /// It holds for every execution time up to the WCET, non-preemptive or not. It says nothing about other tasks
    /// on the same lanes: that takes a test over all of them, of which utilisation is the necessary part.
    #[must_use]
    pub struct Certificate {
        /// The bound that is smallest.
        pub bound: Bound,
        /// Lanes of the task's pool; the largest number where it uses several.
        pub lanes: u8,
        /// W: sum of all costs.
        pub work: Duration,
        /// L: critical path cost.
        pub critical_path: Duration,
        /// The bound's value.
        pub response: Duration,
        /// What it must not exceed: min(D, T).
        pub limit: Duration,
        /// Whether the memory budgets cannot make a ready node wait; if they can, the bound is not sufficient.
        pub memory_holds: bool,
    }
}

impl Certificate {
    /// Whether the bound is met.
    pub const fn fits(&self) -> bool {
        self.response.as_nanos() <= self.limit.as_nanos()
    }

    /// Limit less bound; negative by what is missing.
    pub const fn margin(&self) -> SignedDuration {
        Instant::from_nanos(self.limit.as_nanos()).minus(Instant::from_nanos(self.response.as_nanos()))
    }
}
