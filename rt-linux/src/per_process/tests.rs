#![allow(unsafe_code, reason = "a child of fork")]

use super::PerProcess;
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::{ForkResult, alarm, fork};

static COUNT: PerProcess<u32> = PerProcess::new();

/// What a child of this process answers, which is ended if it waits.
fn in_child(answer: impl FnOnce() -> u8) -> WaitStatus {
    // SAFETY: of the parent's threads' locks the child takes the allocator's only, which the C library keeps usable.
    match unsafe { fork() }.expect("one more process") {
        ForkResult::Parent { child } => waitpid(child, None).expect("it is a child"),
        ForkResult::Child => {
            alarm::set(10);
            let answer = answer();
            // SAFETY: ends the child at once, with nothing of the parent's undone.
            unsafe { libc::_exit(answer.into()) }
        }
    }
}

#[test]
fn a_child_has_its_own_while_the_parent_keeps_its_own_locked() {
    let mut count = COUNT.lock();
    *count = 7;
    let child = in_child(|| {
        let first = *COUNT.lock();
        *COUNT.lock() += 1;
        u8::from(first == 0 && *COUNT.lock() == 1)
    });
    assert!(matches!(child, WaitStatus::Exited(_, 1)), "{child:?}");
    assert_eq!(*count, 7);
    drop(count);
    assert_eq!(*COUNT.lock(), 7);
}
