#![allow(unsafe_code, reason = "an allocator is an unsafe trait to implement")]
//! Counts the bytes that are in use on the heap. What the process has from the kernel says less: allocators keep for
//! later what was given back.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

static LIVE: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, with a count of the bytes that were taken and not given back.
pub(crate) struct LiveBytes;

/// Bytes in use now, as their owners asked for them.
pub(crate) fn live_bytes() -> usize {
    LIVE.load(Ordering::Relaxed)
}

fn taken(block: *mut u8, size: usize) -> *mut u8 {
    if !block.is_null() {
        LIVE.fetch_add(size, Ordering::Relaxed);
    }
    block
}

// SAFETY: every call is passed to the system's allocator unchanged.
unsafe impl GlobalAlloc for LiveBytes {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's contract is the same.
        taken(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's contract is the same.
        taken(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's contract is the same.
        unsafe { System.dealloc(block, layout) };
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's contract is the same.
        let moved = taken(unsafe { System.realloc(block, layout, size) }, size);
        if !moved.is_null() {
            LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        }
        moved
    }
}
