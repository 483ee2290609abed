//! At least m of any k consecutive jobs stay.

use proptest::prelude::*;
use red_core::Floor;
use red_tests::model::is_violated;

use super::cases;

/// Jobs that a floor remembers.
const MEMORY: u64 = 128;

proptest! {
    #![proptest_config(cases(512))]

    #[test]
    fn a_floor_spares_what_keeps_it_and_nothing_else(
        k in 1u32..=128, share in 0u32..=100, asked in prop::collection::vec((0u64..4, 0u64..12), 0..150)
    ) {
        let m = k * share / 100;
        let mut floor = Floor::new(m, k);
        let (mut newest, mut dropped) = (0, Vec::new());
        for (ahead, back) in asked {
            newest += ahead;
            let job = newest.saturating_sub(back);
            if dropped.contains(&job) {
                continue;
            }
            let after: Vec<u64> = dropped.iter().copied().chain([job]).collect();
            let spares = floor.spares(job);
            prop_assert!(!spares || !is_violated(&after, m, k), "job {job} after {dropped:?}");
            // What lies further back than a floor remembers is kept rather than judged.
            let last = dropped.iter().copied().max().unwrap_or(0);
            if last.saturating_sub(job) + u64::from(k) <= MEMORY {
                prop_assert_eq!(spares, !is_violated(&after, m, k));
            }
            if spares {
                floor.ended(job, true);
                dropped = after;
            }
        }
    }

    #[test]
    fn a_floor_over_a_long_window_is_kept_by_a_stricter_one(
        k in 129u32..=400, spare in 0u32..=20, asked in prop::collection::vec(0u64..40, 0..150)
    ) {
        let mut floor = Floor::new(k - spare, k);
        let (mut job, mut dropped) = (0, Vec::new());
        for ahead in asked {
            job += ahead + 1;
            if floor.spares(job) {
                floor.ended(job, true);
                dropped.push(job);
            }
        }
        prop_assert!(!is_violated(&dropped, k - spare, k));
    }
}
