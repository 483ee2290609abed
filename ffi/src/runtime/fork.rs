#![allow(unsafe_code, reason = "a call of the C library")]
//! A child of `fork` has the memory of its parent, and none of its threads: every call on a runtime is refused there.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

static FORKS: AtomicU32 = AtomicU32::new(0);
static IS_COUNTED: AtomicBool = AtomicBool::new(false);

extern "C" fn in_child() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// How often this process's line forked since the first call; other numbers are other processes.
pub(crate) fn generation() -> u32 {
    // Not by one thread for all: a child in which that thread is not would wait for it. Where several do so a fork counts as
    // several, which is another number all the same.
    if !IS_COUNTED.load(Ordering::Relaxed) {
        // SAFETY: the function that is registered only counts. Without memory for it a child is not known as one.
        let _registered = unsafe { libc::pthread_atfork(None, None, Some(in_child)) };
        IS_COUNTED.store(true, Ordering::Relaxed);
    }
    FORKS.load(Ordering::Relaxed)
}
