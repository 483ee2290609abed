//! What the concurrent protocols of this crate are made of.
//!
//! [`crate::bell`] takes its atomics, its clock and its two futex calls from here and from nowhere else, so
//! that a model checker drives the very same file over its own version of this module. Each look at the clock
//! is then a step at which the model may switch threads.

pub(crate) use core::sync::atomic::{AtomicU32, Ordering};

pub(crate) use crate::clock::now_ns;
pub(crate) use crate::sys::{futex_wait, futex_wake};

/// A `const` constructor. A macro, because the atomics of a model checker have no `const` one.
macro_rules! constructor {
    ($(#[$attribute:meta])* $visibility:vis fn $($function:tt)*) => {
        $(#[$attribute])*
        $visibility const fn $($function)*
    };
}
pub(crate) use constructor;
