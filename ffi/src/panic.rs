#![allow(unsafe_code, reason = "names of C")]
//! The end that nothing reaches: that no call of the core panics is checked on what is linked.

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Named by the tables of unwinding that the compiler's own arithmetic has on some processors. Nothing unwinds here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
