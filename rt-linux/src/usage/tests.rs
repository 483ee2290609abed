use super::Usage;

#[test]
fn touching_fresh_memory_counts_as_minor_faults() {
    const PAGES: usize = 1_024;
    let before = Usage::of_thread();
    // From the kernel directly: above the size from which the allocator maps anew.
    let mut fresh = vec![0_u8; PAGES * 4_096];
    for page in fresh.chunks_mut(4_096) {
        page[0] = std::hint::black_box(1);
    }
    std::hint::black_box(&fresh);
    let added = Usage::of_thread().since(before);
    assert!(added.minor_faults > 0, "{added:?}");
    assert!(Usage::of_process().minor_faults >= added.minor_faults);
}

#[test]
fn a_difference_never_goes_below_zero() {
    let some = Usage { minor_faults: 1, major_faults: 2, involuntary_switches: 3 };
    assert_eq!(Usage::default().since(some), Usage::default());
}
