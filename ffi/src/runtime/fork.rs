#![allow(unsafe_code, reason = "a call of the C library")]
//! A child of `fork` has the memory of its parent, and none of its threads: every call on a runtime is refused there.

use core::sync::atomic::{AtomicU32, Ordering};
use std::sync::Once;

static FORKS: AtomicU32 = AtomicU32::new(0);
static REGISTERED: Once = Once::new();

extern "C" fn in_child() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// How often this process's line forked since the first call; other numbers are other processes.
pub(crate) fn generation() -> u32 {
    REGISTERED.call_once(|| {
        // SAFETY: the function that is registered only counts. Without memory for it a child is not known as one.
        let _registered = unsafe { libc::pthread_atfork(None, None, Some(in_child)) };
    });
    FORKS.load(Ordering::Relaxed)
}
