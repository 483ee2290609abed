//! Integer time in nanoseconds. There are no operators that could overflow: every sum says what happens at the end
//! of the range. The epoch is the host's; on Linux it is that of `CLOCK_MONOTONIC`.

use core::fmt;

crate::capacity::numbers! {
    /// A point in time: nanoseconds since the host's epoch.
    ///
    /// ```
    /// use red_core::{Duration, Instant};
    /// let release = Instant::from_nanos(5);
    /// assert_eq!(release.saturating_add(Duration::from_nanos(2)), Instant::from_nanos(7));
    /// assert_eq!(release.since(Instant::from_nanos(9)), Duration::ZERO);
    /// ```
    pub struct Instant(u64);

    /// A length of time.
    pub struct Duration(u64);

    /// A signed length of time: lateness, laxity, time to a deadline.
    pub struct SignedDuration(i64);

    /// Worst-case execution time. Only this may enter `analysis`.
    pub struct Wcet(u64);

    /// Delay that co-runners can add to an atomic node: the paper's Delta_cont.
    pub struct Contention(u64);

    /// What a node is expected to take by its last executions: no bound. It never enters `analysis`.
    pub struct CostEstimate(u64);

    /// Memory in bytes.
    pub struct Bytes(pub u64);

    /// A ratio in parts per million.
    pub struct Ppm(pub u32);
}

macro_rules! nanoseconds {
    ($($t:ident($int:ty))*) => { $(impl $t {
        /// The epoch, or no time.
        pub const ZERO: Self = Self(0);

        /// From nanoseconds.
        pub const fn from_nanos(ns: $int) -> Self {
            Self(ns)
        }

        /// From milliseconds, saturating.
        pub const fn from_millis(ms: $int) -> Self {
            Self(ms.saturating_mul(1_000_000))
        }

        /// In nanoseconds.
        pub const fn as_nanos(self) -> $int {
            self.0
        }
    })* };
}
nanoseconds!(Instant(u64) Duration(u64) SignedDuration(i64) Wcet(u64) Contention(u64) CostEstimate(u64));

impl Instant {
    /// The end of time.
    pub const MAX: Self = Self(u64::MAX);

    /// `self + d`, or `None` beyond the end of time.
    #[must_use]
    pub fn checked_add(self, d: Duration) -> Option<Self> {
        self.0.checked_add(d.0).map(Self)
    }

    /// `self + d`, at most [`Instant::MAX`].
    #[must_use]
    pub const fn saturating_add(self, d: Duration) -> Self {
        Self(self.0.saturating_add(d.0))
    }

    /// Time from `earlier` to `self`; zero when `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }

    /// `self - other`, with its sign, saturating.
    #[must_use]
    pub const fn minus(self, other: Self) -> SignedDuration {
        SignedDuration(match self.0.checked_signed_diff(other.0) {
            Some(ns) => ns,
            None if self.0 < other.0 => i64::MIN,
            None => i64::MAX,
        })
    }
}

impl Duration {
    /// From microseconds, saturating.
    pub const fn from_micros(us: u64) -> Self {
        Self(us.saturating_mul(1_000))
    }

    /// From seconds, saturating.
    pub const fn from_secs(s: u64) -> Self {
        Self(s.saturating_mul(1_000_000_000))
    }

    /// `self + other`, saturating.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Wcet {
    /// As a duration.
    pub const fn get(self) -> Duration {
        Duration(self.0)
    }
}

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, name) = match self.0 {
            ns if ns >= 1_000_000_000 => (1_000_000_000, "s"),
            ns if ns >= 1_000_000 => (1_000_000, "ms"),
            ns if ns >= 1_000 => (1_000, "us"),
            _ => return write!(f, "{} ns", self.0),
        };
        write!(f, "{}.{:03} {name}", self.0 / unit, self.0 % unit * 1_000 / unit)
    }
}

#[cfg(test)]
mod tests;
