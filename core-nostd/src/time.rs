//! Integer time: instants, durations and signed differences in nanoseconds.
//!
//! There are no operators that could overflow: every sum says what happens at the end of the range. The
//! epoch is the host's; on Linux it is that of `CLOCK_MONOTONIC`.

use crate::capacity::Empty;
use core::fmt;

/// A point in time: nanoseconds since the host's epoch.
///
/// ```
/// use red_core::{Duration, Instant};
/// let release = Instant::from_nanos(5);
/// assert_eq!(release.saturating_add(Duration::from_nanos(2)), Instant::from_nanos(7));
/// assert_eq!(release.since(Instant::from_nanos(9)), Duration::ZERO);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Instant(u64);

/// A length of time in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Duration(u64);

/// A signed length of time in nanoseconds: lateness, laxity, time to a deadline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SignedDuration(i64);

/// Worst-case execution time. Only this may enter `analysis`.
///
/// ```
/// # use red_core::{Duration, Wcet};
/// assert_eq!(Wcet::from_millis(2).get(), Duration::from_micros(2_000));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wcet(Duration);

/// Delay that co-runners can add to an atomic node: the paper's Delta_cont.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contention(Duration);

/// What a node is expected to take, from its last executions. A mean is not a bound: it steers sub-deadlines
/// and never enters `analysis`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CostEstimate(Duration);

/// Memory in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bytes(pub u64);

/// A ratio in parts per million.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ppm(pub u32);

impl Instant {
    /// The epoch.
    pub const ZERO: Self = Self(0);
    /// The end of time.
    pub const MAX: Self = Self(u64::MAX);

    /// From nanoseconds since the epoch.
    pub const fn from_nanos(ns: u64) -> Self {
        Self(ns)
    }

    /// Nanoseconds since the epoch.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// `self + d`, or `None` beyond the end of time.
    #[must_use]
    pub const fn checked_add(self, d: Duration) -> Option<Self> {
        match self.0.checked_add(d.0) {
            Some(ns) => Some(Self(ns)),
            None => None,
        }
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
        SignedDuration(if self.0 >= other.0 {
            let d = self.0 - other.0;
            if d > i64::MAX as u64 { i64::MAX } else { d.cast_signed() }
        } else {
            let d = other.0 - self.0;
            if d > i64::MAX as u64 { i64::MIN } else { -d.cast_signed() }
        })
    }
}

impl Duration {
    /// No time.
    pub const ZERO: Self = Self(0);

    /// From nanoseconds.
    pub const fn from_nanos(ns: u64) -> Self {
        Self(ns)
    }

    /// From microseconds, saturating.
    pub const fn from_micros(us: u64) -> Self {
        Self(us.saturating_mul(1_000))
    }

    /// From milliseconds, saturating.
    pub const fn from_millis(ms: u64) -> Self {
        Self(ms.saturating_mul(1_000_000))
    }

    /// From seconds, saturating.
    pub const fn from_secs(s: u64) -> Self {
        Self(s.saturating_mul(1_000_000_000))
    }

    /// Nanoseconds.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// `self + other`, or `None` on overflow.
    #[must_use]
    pub const fn checked_add(self, other: Self) -> Option<Self> {
        match self.0.checked_add(other.0) {
            Some(ns) => Some(Self(ns)),
            None => None,
        }
    }

    /// `self + other`, saturating.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// `self - other`, at least zero.
    #[must_use]
    pub const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl SignedDuration {
    /// From nanoseconds.
    pub const fn from_nanos(ns: i64) -> Self {
        Self(ns)
    }

    /// Nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// The positive part: tardiness from lateness.
    pub const fn positive(self) -> Duration {
        Duration(if self.0 > 0 { self.0.cast_unsigned() } else { 0 })
    }
}

macro_rules! of_duration {
    ($($t:ident)*) => { $(
        impl $t {
            /// No time.
            pub const ZERO: Self = Self(Duration::ZERO);

            /// From a duration.
            pub const fn new(d: Duration) -> Self {
                Self(d)
            }

            /// From milliseconds, saturating.
            pub const fn from_millis(ms: u64) -> Self {
                Self(Duration::from_millis(ms))
            }

            /// From nanoseconds.
            pub const fn from_nanos(ns: u64) -> Self {
                Self(Duration::from_nanos(ns))
            }

            /// As a duration.
            pub const fn get(self) -> Duration {
                self.0
            }

            /// In nanoseconds.
            pub const fn as_nanos(self) -> u64 {
                self.0.as_nanos()
            }
        }
        impl Empty for $t { const EMPTY: Self = Self::ZERO; }
    )* };
}
of_duration!(Wcet Contention CostEstimate);

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

crate::capacity::empty!(Instant = Self::ZERO, Duration = Self::ZERO, Bytes = Self(0), Ppm = Self(0));

#[cfg(test)]
mod tests;
