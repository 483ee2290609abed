//! Two tests per level, by their names: the paper's condition (ii), and a sound one.
//!
//! *Background.* The paper asks S_h / rho <= D^(h) for every level. Under proportional shares that is one
//! inequality, W <= rho * D, for all levels, and it is not sufficient: rho = 4, a level with one node of 4, a
//! level with twelve nodes of 1, D = 4 passes, and the critical path is 5. *Rule.* Sound per level: g_h <=
//! D^(h), with Graham's g_h = max_h + ceil((S_h - max_h) / m).

use crate::deadlines::LevelShare;
use crate::time::Duration;

crate::capacity::values! {
    /// What the two tests say.
    #[must_use]
    pub struct LevelCapacity {
        /// The paper's condition (ii): W <= rho * D. Necessary.
        pub paper: bool,
        /// First level whose share is below its Graham bound, and by how much. `None`: every level fits.
        pub first_short: Option<(u8, Duration)>,
    }
}

/// Applies both tests to the shares of a graph's levels, of `work` nanoseconds in all, on `lanes` lanes.
pub fn level_capacity(levels: &[LevelShare], work: u64, deadline: Duration, lanes: u8) -> LevelCapacity {
    let short = |(h, level): (usize, &LevelShare)| {
        let missing = level.graham.checked_sub(level.share).filter(|missing| *missing > 0)?;
        Some((h as u8, Duration::from_nanos(missing)))
    };
    LevelCapacity {
        paper: u128::from(work) <= u128::from(lanes) * u128::from(deadline.as_nanos()),
        first_short: levels.iter().enumerate().find_map(short),
    }
}
