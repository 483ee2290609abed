//! The allocator's settings belong to the whole process, so this test has one of its own.

use std::hint::black_box;

use red_rt::setup::malloc_for_real_time;
use red_rt::usage::Usage;

/// What a node body might do: blocks small and large, all of them written, all of them freed.
fn body() {
    for bytes in [100, 10_000, 1_000_000, 8_000_000] {
        let mut block = vec![0_u8; bytes];
        block.fill(black_box(1));
        black_box(&block);
    }
}

#[test]
fn after_a_warm_up_a_body_that_allocates_faults_no_page() {
    malloc_for_real_time().expect("glibc knows its settings");
    body();
    let before = Usage::of_thread();
    for _ in 0..10 {
        body();
    }
    let added = Usage::of_thread().since(before);
    // Without the settings each of the large blocks is mapped anew: 22,000 faults.
    assert!(added.minor_faults < 10, "{added:?}");
}
