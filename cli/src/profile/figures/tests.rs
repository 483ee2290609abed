use super::*;

#[test]
fn percentiles_are_nearest_rank() {
    let sample = Sample::of((1..=200).rev().collect());
    assert_eq!(sample, Sample { runs: 200, min_ns: 1, median_ns: 100, p99_ns: 198, max_ns: 200 });
    assert_eq!(Sample::of(vec![7]), Sample { runs: 1, min_ns: 7, median_ns: 7, p99_ns: 7, max_ns: 7 });
    assert_eq!(Sample::of(Vec::new()), Sample::default());
}

#[test]
fn what_is_written_bounds_what_was_seen() {
    assert_eq!((up(99_999), up(100_001), up(101_000)), (99_999, 101_000, 101_000));
    assert_eq!((down(99_999), down(100_999), down(0)), (99_999, 100_000, 0));
    assert_eq!(up(u64::MAX), u64::MAX);
}
