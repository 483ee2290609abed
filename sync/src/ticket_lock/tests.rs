use super::*;

/// Fewer where each takes an interpreter.
const ROUNDS: u32 = if cfg!(miri) { 50 } else { 10_000 };

#[test]
fn increments_of_two_threads_all_count() {
    let counter = TicketLock::new(0u32);
    std::thread::scope(|s| {
        for _ in 0..2 {
            s.spawn(|| (0..ROUNDS).for_each(|_| counter.with(|n| *n += 1)));
        }
    });
    assert_eq!(counter.with(|n| *n), 2 * ROUNDS);
}

#[test]
fn a_panic_inside_does_not_block_the_next() {
    let lock = TicketLock::new(0);
    let panicked =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| lock.with(|_| panic!("planted"))));
    assert!(panicked.is_err());
    assert_eq!(lock.with(|n| *n), 0);
}
