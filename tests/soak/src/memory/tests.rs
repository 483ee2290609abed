use super::*;

/// Looks at these bytes in use, and as much as that resident.
fn of(live: impl Iterator<Item = usize>) -> Verdict {
    Memory { looks: live.map(|live| Look { live, resident_kib: live as u64 / 1024 }).collect() }.verdict()
}

#[test]
fn what_grows_by_a_kibibyte_a_workload_is_found_under_noise() {
    // Every fifth look sees a thread that still holds a quarter of a mebibyte.
    let noise = |i: usize| if i.is_multiple_of(5) { 256 << 10 } else { (i * 7919) % 512 };
    for count in [16, 60, 2_000] {
        assert!(matches!(of((0..count).map(|i| (1 << 20) + noise(i))), Verdict::Flat(_)), "{count}");
        let leak = |i: usize| (1 << 20) + noise(i) + 1024 * i;
        assert!(matches!(of((0..count).map(leak)), Verdict::Grows(_)), "{count}");
    }
}

#[test]
fn what_grows_at_the_start_and_what_shrinks_is_flat() {
    assert!(matches!(of((0..100).map(|i| (1 << 20) + i.min(20) * 100_000)), Verdict::Flat(_)));
    assert!(matches!(of((0..100).map(|i| (1 << 24) - i * 1_000)), Verdict::Flat(_)));
}

#[test]
fn few_looks_say_nothing() {
    assert_eq!(of((0..15).map(|i| i << 20)), Verdict::Unknown);
}

#[test]
fn memory_that_is_not_on_the_heap_counts_too() {
    let look = |i: u64| Look { live: 1 << 20, resident_kib: 10_000 + i * 2_000 };
    let grows = Memory { looks: (0..100).map(look).collect() }.verdict();
    assert!(matches!(grows, Verdict::Grows(_)), "{grows:?}");
}

#[test]
fn bytes_in_use_are_counted_and_so_are_those_that_come_back() {
    let kept = vec![1_u8; 64 << 20];
    let with = live_bytes();
    drop(kept);
    // Other tests take some meanwhile, and not so much.
    assert!(with >= 64 << 20 && live_bytes() < with - (32 << 20), "{with}, {}", live_bytes());
}
