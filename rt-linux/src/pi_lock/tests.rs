use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

use super::PiLock;

#[test]
fn one_thread_at_a_time_is_inside() {
    const ROUNDS: u64 = 20_000;
    let lock = PiLock::new(0_u64).expect("the kernel has priority inheritance");
    thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                for _ in 0..ROUNDS {
                    let mut value = lock.lock();
                    let seen = *value;
                    *value = std::hint::black_box(seen) + 1;
                }
            });
        }
    });
    assert_eq!(*lock.lock(), 3 * ROUNDS);
}

#[test]
fn locking_twice_panics_and_leaves_the_lock_usable() {
    let lock = PiLock::new(1).expect("the kernel has priority inheritance");
    let twice = catch_unwind(AssertUnwindSafe(|| {
        let _first = lock.lock();
        let _second = lock.lock();
    }));
    assert!(twice.is_err());
    assert_eq!(*lock.lock(), 1);
}
