//! Atomics, the cell and the spin hint: the real ones, or those of the model checker. The only file that knows.

#[cfg(not(loom))]
mod chosen {
    pub(crate) use core::hint::spin_loop as spin;
    #[cfg(target_has_atomic = "32")]
    pub(crate) use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
    // A processor without compare-and-swap does it inside the program's critical section.
    #[cfg(not(target_has_atomic = "32"))]
    pub(crate) use portable_atomic::{AtomicU8, AtomicU32, Ordering};

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
}

#[cfg(loom)]
mod chosen {
    pub(crate) use loom::cell::UnsafeCell as Cell;
    pub(crate) use loom::sync::atomic::{AtomicU8, AtomicU32, Ordering};
    /// The checker's scheduler is unfair: a spin loop must give way.
    pub(crate) use loom::thread::yield_now as spin;
}

pub(crate) use chosen::{AtomicU8, AtomicU32, Cell, Ordering, spin};

/// Constructors that are `const` where the primitives' are: the checker's are not.
macro_rules! constructor {
    ($(#[$doc:meta])* $vis:vis fn $($rest:tt)*) => {
        $(#[$doc])* #[cfg(not(loom))] #[must_use] $vis const fn $($rest)*
        $(#[$doc])* #[cfg(loom)] #[must_use] $vis fn $($rest)*
    };
}
pub(crate) use constructor;
