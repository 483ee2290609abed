//! The overload monitor's numbers and the paper's score. The paper calls it criticality; in real-time theory
//! that is a static assurance level, so the code says urgency.

use crate::time::{Duration, Ppm};

crate::capacity::values! {
    /// When the monitor speaks of overload: paper section 4.6, all of them hand-tuned there.
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
    pub(crate) fn exceeded(&self, queued: usize, busy: Duration, window: Duration, lanes: u8) -> bool {
        let share = u128::from(busy.as_nanos()) * 1_000_000;
        let limit = u128::from(self.utilisation.0) * u128::from(lanes) * u128::from(window.as_nanos());
        queued > usize::from(self.queue) || share > limit
    }
}

/// C_i of the paper: 0 just released, 1,000,000 at or past the sub-deadline, which is relative to the release.
pub(crate) fn urgency(sub_deadline: Duration, elapsed: Duration) -> Ppm {
    let (delta, e) = (u128::from(sub_deadline.as_nanos()), u128::from(elapsed.as_nanos()));
    Ppm((e.min(delta) * 1_000_000).checked_div(delta).unwrap_or(1_000_000) as u32)
}

#[cfg(test)]
mod tests;
