use std::sync::atomic::AtomicU32;

use nix::errno::Errno;

use super::{PiMutex, futex_wait, futex_wake, has_address_space, stack_room, timespec};

#[test]
fn a_futex_that_has_changed_does_not_sleep() {
    assert!(!futex_wait(&AtomicU32::new(1), 0, None));
}

#[test]
fn a_futex_reports_the_time() {
    assert!(futex_wait(&AtomicU32::new(0), 0, Some(0)));
}

#[test]
fn there_is_address_space_and_not_any_amount_of_it() {
    assert!(has_address_space(1 << 20) && !has_address_space(usize::MAX >> 1));
}

#[test]
fn waking_nobody_is_harmless() {
    futex_wake(&AtomicU32::new(0));
}

#[test]
fn the_largest_time_is_a_valid_timespec() {
    let end = timespec(u64::MAX);
    assert_eq!((end.tv_sec, end.tv_nsec), (18_446_744_073, 709_551_615));
}

#[test]
fn a_mutex_tells_its_misuse() {
    let mutex = PiMutex::new().expect("the kernel has priority inheritance");
    assert_eq!(mutex.unlock(), Err(Errno::EPERM));
    mutex.lock().expect("free");
    assert_eq!(mutex.lock(), Err(Errno::EDEADLK));
    mutex.unlock().expect("held");
}

#[test]
fn the_room_shrinks_by_what_the_callers_use() {
    const FRAME: usize = 64 * 1024;

    #[inline(never)]
    fn deeper() -> usize {
        let frame = std::hint::black_box([0_u8; FRAME]);
        let room = stack_room().expect("a thread knows its stack");
        std::hint::black_box(&frame);
        room
    }

    let room = stack_room().expect("a thread knows its stack");
    assert!(deeper() + FRAME <= room);
}
