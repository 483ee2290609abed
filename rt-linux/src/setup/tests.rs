use nix::errno::Errno;

use super::{Fifo, SetupError, best_effort, pin, prefault_stack};
use crate::placement::usable_cpus;
use crate::usage::Usage;

/// On a thread of its own, because the steps change the thread.
fn on_a_thread<T: Send + 'static>(body: impl FnOnce() -> T + Send + 'static) -> T {
    std::thread::Builder::new()
        .stack_size(1 << 20)
        .spawn(body)
        .expect("one more thread")
        .join()
        .expect("the body does not panic")
}

#[test]
fn every_error_names_the_place_and_the_cure() {
    let call = "sched_setscheduler(SCHED_FIFO)";
    let denied = SetupError::of(call, Errno::EPERM, "get the right", "other");
    assert!(matches!(denied, SetupError::NotPermitted { errno: Errno::EPERM, .. }));
    assert_eq!(denied.to_string(), format!("{call}: Operation not permitted (EPERM); fix: get the right"));
    let broken = SetupError::of(call, Errno::EINVAL, "get the right", "other");
    assert!(broken.to_string().ends_with("fix: other"));
}

#[test]
fn a_cpu_that_does_not_exist_is_refused_before_the_priority() {
    for cpu in [1023, 1024, usize::MAX] {
        let error = on_a_thread(move || Fifo { priority: 1, cpu }.apply()).unwrap_err();
        let usable = usable_cpus().unwrap();
        assert_eq!(error, SetupError::CpuNotUsable { cpu, usable });
    }
}

#[test]
fn a_pinned_thread_has_one_cpu() {
    let cpu = *usable_cpus().unwrap().last().expect("at least one CPU");
    let after = on_a_thread(move || {
        pin(cpu).expect("a usable CPU");
        usable_cpus().unwrap()
    });
    assert_eq!(after, [cpu]);
}

#[test]
fn a_prefaulted_stack_does_not_fault_again() {
    const BYTES: usize = 256 * 1024;
    let added = on_a_thread(|| {
        prefault_stack(BYTES).expect("a quarter of the stack");
        let before = Usage::of_thread();
        prefault_stack(BYTES).expect("a quarter of the stack");
        Usage::of_thread().since(before)
    });
    // pthread_getattr_np allocates the CPU mask; nothing else may fault.
    assert!(added.minor_faults < 8, "{added:?}");
}

#[test]
fn more_stack_than_there_is_is_an_error_and_not_a_crash() {
    // A new thread may get the stack of an ended one, up to four times as large.
    for wanted in [8 << 20, usize::MAX] {
        let error = on_a_thread(move || prefault_stack(wanted)).unwrap_err();
        assert!(
            matches!(error, SetupError::StackTooSmall { wanted: w, room } if w == wanted && room < wanted)
        );
    }
    assert_eq!(on_a_thread(|| prefault_stack(0)), Ok(()));
}

#[test]
fn best_effort_needs_no_right() {
    assert_eq!(on_a_thread(best_effort), Ok(()));
}
