//! Two tests per level, by their names: the paper's condition (ii), and a sound one.
//!
//! *Background.* The paper asks S_h / rho <= D^(h) for every level. Under proportional shares that is one
//! inequality, W <= rho * D, for all levels, and it is not sufficient: rho = 4, a level with one node of 4, a
//! level with twelve nodes of 1, D = 4 passes, and the critical path is 5. *Rule.* Sound per level: g_h <=
//! D^(h), with Graham's g_h = max_h + ceil((S_h - max_h) / m).

use red_core::{Duration, LevelShare};

/// What the two tests say.
pub(super) struct LevelCapacity {
    /// The paper's condition (ii): W <= rho * D. Necessary.
    pub(super) paper_condition: bool,
    /// Every level's share covers its Graham bound.
    pub(super) levels_fit: bool,
}

/// Applies both tests to the shares of a graph's levels, of `work` nanoseconds in all, on `lanes` lanes.
pub(super) fn level_capacity(
    levels: &[LevelShare],
    work: u64,
    deadline: Duration,
    lanes: u8,
) -> LevelCapacity {
    LevelCapacity {
        paper_condition: u128::from(work) <= u128::from(lanes) * u128::from(deadline.as_nanos()),
        levels_fit: levels.iter().all(|level| level.graham <= level.share),
    }
}

#[cfg(test)]
mod tests {
    use super::level_capacity;
    use red_core::{Duration, LevelShare};

    #[test]
    fn the_papers_condition_passes_where_a_level_does_not_fit() {
        let level = |cost, graham, share| {
            let (mut level, end) = (<LevelShare as red_core::Empty>::EMPTY, share);
            (level.cost, level.graham, level.share, level.end) = (cost, graham, share, end);
            level
        };
        // The example of the module: shares of 1 and 3 of D = 4 on four lanes.
        let verdict = level_capacity(&[level(4, 4, 1), level(12, 3, 3)], 16, Duration::from_nanos(4), 4);
        assert!(verdict.paper_condition && !verdict.levels_fit);
        let verdict = level_capacity(&[level(4, 4, 4), level(12, 3, 12)], 16, Duration::from_nanos(16), 4);
        assert!(verdict.paper_condition && verdict.levels_fit);
    }
}
