//! What the synchronizers are made of: atomics, the cell and the spin hint, taken from here and from nowhere else, so
//! that a model checker drives the very same files over its own version of this module.

pub(crate) use core::hint::spin_loop;
pub(crate) use core::sync::atomic::fence;
#[cfg(target_has_atomic = "32")]
pub(crate) use core::sync::atomic::{AtomicPtr, AtomicU8, AtomicU32, Ordering};
// A processor without compare-and-swap does it inside the program's critical section.
#[cfg(not(target_has_atomic = "32"))]
pub(crate) use portable_atomic::{AtomicPtr, AtomicU8, AtomicU32, Ordering};

/// A cell whose exclusive access the caller guarantees.
#[derive(Debug)]
pub(crate) struct Cell<T>(core::cell::UnsafeCell<T>);

impl<T> Cell<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(core::cell::UnsafeCell::new(value))
    }

    /// Runs `f` with a pointer to the value; the model checker sees one write access.
    #[inline(always)]
    pub(crate) fn with_mut<R>(&self, f: impl FnOnce(*mut T) -> R) -> R {
        f(self.0.get())
    }
}

/// Cells with nothing in them.
pub(crate) const fn empty_cells<T, const N: usize>() -> [Cell<Option<T>>; N] {
    [const { Cell::new(None) }; N]
}

/// Words without a value.
pub(crate) const fn null_words<const N: usize>() -> [AtomicPtr<()>; N] {
    [const { AtomicPtr::new(core::ptr::null_mut()) }; N]
}

/// A `const` constructor. A macro, because the primitives of a model checker have no `const` one.
macro_rules! constructor {
    ($(#[$attribute:meta])* $visibility:vis fn $($function:tt)*) => {
        $(#[$attribute])*
        #[must_use]
        $visibility const fn $($function)*
    };
}
pub(crate) use constructor;
