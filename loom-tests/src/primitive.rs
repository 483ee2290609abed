//! The modules `primitive` of `sync` and `rt-linux`, for the model checker: its atomics and cells, and a modelled
//! kernel.

pub(crate) use crate::atomics::{AtomicBool, AtomicI32, AtomicPtr, AtomicU8, AtomicU32, AtomicU64};
pub(crate) use crate::kernel::{futex_wait, futex_wake, now_ns};
pub(crate) use crate::mailbox::Mailbox;
pub(crate) type Cell<T> = loom::cell::UnsafeCell<T>;
pub(crate) use loom::sync::atomic::{Ordering, fence};
/// The checker's scheduler is unfair: a spin loop must give way.
pub(crate) use loom::thread::{yield_now, yield_now as spin_loop};

pub(crate) fn empty_cells<T, const N: usize>() -> [Cell<Option<T>>; N] {
    std::array::from_fn(|_| Cell::new(None))
}

pub(crate) fn null_words<const N: usize>() -> [AtomicPtr<()>; N] {
    std::array::from_fn(|_| AtomicPtr::new(std::ptr::null_mut()))
}

/// The checker's primitives have no `const` constructor.
macro_rules! constructor {
    ($($function:tt)*) => { $($function)* };
}
pub(crate) use constructor;
