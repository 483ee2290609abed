//! After set-up the scheduler allocates nothing: not at releases, completions, edits, merges, hits or sheds.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use red_tests::drive::{Blind, Drive};
use red_tests::rng::{Shape, random_workload};
use red_workload::policy::Policy;

thread_local! {
    /// Calls of the allocator while this thread was armed; `None` while it is not.
    static CALLS: Cell<Option<u32>> = const { Cell::new(None) };
}

/// The system's allocator, counted while the calling thread is armed.
struct Armed;

#[global_allocator]
static ALLOCATOR: Armed = Armed;

fn count() {
    // A thread that ends frees its own storage after this variable is gone.
    let _gone = CALLS.try_with(|calls| calls.set(calls.get().map(|n| n + 1)));
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Armed {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) };
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// How often `f` calls the allocator.
fn allocations(f: impl FnOnce()) -> u32 {
    CALLS.set(Some(0));
    f();
    CALLS.take().expect("armed above")
}

#[test]
fn a_planted_allocation_is_caught() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(7)))), 2);
    assert_eq!(allocations(|| drop(std::hint::black_box(Vec::<u8>::new()))), 0);
}

#[test]
fn no_call_of_the_scheduler_allocates() {
    let shape = Shape { load_percent: (80, 200), ..Shape::default() };
    let (mut edits, mut sheds, mut saved) = (0, 0, 0);
    for seed in 0..60 {
        let workload = random_workload(seed, &shape);
        for policy in Policy::NAMED {
            let mut drive = Drive::new(&workload, policy.config(), (40, 120), seed);
            let calls = allocations(|| drive.run(200_000_000, &mut Blind));
            assert_eq!(calls, 0, "seed {seed} under {policy}");
            edits += drive.edits;
            sheds += drive.sheds;
            saved += drive.scheduler.counters().encoder_runs_saved;
        }
    }
    assert!(
        edits > 0 && sheds > 0 && saved > 0,
        "nothing was tried: {edits} edits, {sheds} sheds, {saved} saved"
    );
}
