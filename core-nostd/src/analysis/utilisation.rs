//! The necessary test over several tasks: no pool may be asked for more than its lanes can do.
//!
//! It is not sufficient, whatever the slack: it ignores deadlines, blocking and carried-in work.

use crate::time::Duration;

/// What one task asks of one pool: `work` in every `period`; `None` for a task that is released once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Work on this pool per job.
    pub work: Duration,
    /// Period or minimum inter-arrival time.
    pub period: Option<Duration>,
}

/// Idle lane time per second that `demands` leave on `lanes` lanes, in nanoseconds; negative when they ask for
/// more than there is. Rounded towards "does not fit", by less than one nanosecond per demand.
///
/// ```
/// use red_core::{Demand, Duration, utilisation_slack};
/// let half = Demand { work: Duration::from_millis(5), period: Some(Duration::from_millis(10)) };
/// assert_eq!(utilisation_slack([half; 3], 2), 500_000_000);
/// assert_eq!(utilisation_slack([half; 3], 1), -500_000_000);
/// ```
pub fn utilisation_slack(demands: impl IntoIterator<Item = Demand>, lanes: u8) -> i64 {
    const SECOND: u128 = 1_000_000_000;
    let mut asked = 0u128;
    for demand in demands {
        if let Some(period) = demand.period {
            let scaled = u128::from(demand.work.as_nanos()) * SECOND;
            asked = asked.saturating_add(scaled.div_ceil(u128::from(period.as_nanos().max(1))));
        }
    }
    let there = u128::from(lanes) * SECOND;
    let magnitude = |x: u128| i64::try_from(x).unwrap_or(i64::MAX);
    if there >= asked { magnitude(there - asked) } else { -magnitude(asked - there) }
}
