//! What a target without an operating system lacks. Both names are nowhere defined, so that a call of them that is
//! left in the object is seen.

use core::panic::PanicInfo;

unsafe extern "C" {
    safe fn red_reached_panic() -> !;
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    red_reached_panic()
}

mod allocator {
    use core::alloc::{GlobalAlloc, Layout};

    struct Outside;

    unsafe extern "C" {
        safe fn malloc(bytes: usize) -> *mut u8;
        safe fn free(pointer: *mut u8);
    }

    #[global_allocator]
    static OUTSIDE: Outside = Outside;

    // SAFETY: never run; the names lead outside.
    unsafe impl GlobalAlloc for Outside {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            malloc(layout.size())
        }

        unsafe fn dealloc(&self, pointer: *mut u8, _: Layout) {
            free(pointer);
        }
    }
}
