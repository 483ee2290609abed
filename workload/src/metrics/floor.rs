//! Whether a task's floor was kept: at least `m` of any `k` consecutive jobs on time.

use serde::Serialize;

/// A floor, and the worst that became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FloorMetrics {
    /// Jobs of each window that are to be on time.
    pub m: u32,
    /// Consecutive jobs of a window.
    pub k: u32,
    /// The fewest that were on time in a window. Jobs before the first and after the last count as on time.
    pub worst: u32,
    /// Whether that is `m` at least.
    pub kept: bool,
}

impl FloorMetrics {
    /// Of jobs in the order of their releases: whether each was on time. Time bound: O(jobs).
    #[must_use]
    pub fn of(m: u32, k: u32, on_time: impl Iterator<Item = bool>) -> Self {
        let lost: Vec<bool> = on_time.map(|on_time| !on_time).collect();
        let (mut inside, mut most) = (0u32, 0);
        for (newest, is_lost) in lost.iter().enumerate() {
            let gone = newest.checked_sub(k as usize).is_some_and(|oldest| lost[oldest]);
            inside = inside + u32::from(*is_lost) - u32::from(gone);
            most = most.max(inside);
        }
        let worst = k.saturating_sub(most);
        Self { m, k, worst, kept: worst >= m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worst window of 3 of 4, one letter a job: `.` on time, `x` not.
    fn worst(jobs: &str) -> (u32, bool) {
        let floor = FloorMetrics::of(3, 4, jobs.chars().map(|job| job == '.'));
        (floor.worst, floor.kept)
    }

    #[test]
    fn the_worst_window_decides() {
        assert_eq!(worst(""), (4, true));
        assert_eq!(worst("x"), (3, true));
        assert_eq!(worst("x...x...x"), (3, true));
        assert_eq!(worst("x..x...."), (2, false));
        assert_eq!(worst("....xxxx...."), (0, false));
    }
}
