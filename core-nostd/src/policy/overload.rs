//! The overload monitor's numbers and the paper's score.
//!
//! The paper calls its score criticality; in real-time theory that is a static assurance level, so the code
//! says urgency.

use crate::time::{Duration, Ppm};

crate::capacity::stored! {
    /// When the monitor speaks of overload: paper section 4.6, all of them hand-tuned there.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Overload {
        /// theta_u: busy share of all lanes in one tick; paper: 0.90.
        pub utilisation: Ppm,
        /// Q_max: ready sub-jobs; paper: 8.
        pub queue: u16,
        /// W: consecutive ticks; paper: 3.
        pub ticks: u8,
        /// One scheduler quantum; paper: about 5 ms on Orin.
        pub tick: Duration,
    }
}

impl Overload {
    /// The paper's numbers.
    pub const PAPER: Self =
        Self { utilisation: Ppm(900_000), queue: 8, ticks: 3, tick: Duration::from_millis(5) };

    /// q > Q_max or U > theta over `window` on `lanes` lanes.
    pub fn exceeded(&self, queued: usize, busy: Duration, window: Duration, lanes: u8) -> bool {
        let share = u128::from(busy.as_nanos()) * 1_000_000;
        let limit = u128::from(self.utilisation.0) * u128::from(lanes) * u128::from(window.as_nanos());
        queued > usize::from(self.queue) || share > limit
    }
}

/// C_i of the paper in parts per million: 0 just released, 1,000,000 at or past the sub-deadline.
///
/// ```
/// use red_core::{Duration, Urgency};
/// let half = Urgency::of(Duration::from_millis(10), Duration::from_millis(5));
/// assert_eq!(half.ppm(), 500_000);
/// assert_eq!(Urgency::of(Duration::ZERO, Duration::ZERO).ppm(), 1_000_000);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Urgency(u32);

impl Urgency {
    /// From the relative sub-deadline and the time since release.
    pub const fn of(sub_deadline: Duration, elapsed: Duration) -> Self {
        let (delta, e) = (sub_deadline.as_nanos(), elapsed.as_nanos());
        Self(if delta == 0 || e >= delta {
            1_000_000
        } else {
            (e as u128 * 1_000_000 / delta as u128) as u32
        })
    }

    /// In parts per million.
    pub const fn ppm(self) -> u32 {
        self.0
    }
}
