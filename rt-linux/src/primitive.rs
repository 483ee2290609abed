//! What the concurrent protocols of this crate are made of.
//!
//! [`crate::bell`], [`crate::seat`], [`crate::waiting`], [`crate::spares`], [`crate::slot`] and [`crate::errands`] take
//! their atomics, their clock and their calls of the kernel from here and from nowhere else, so that a model checker drives the
//! very same files over its own version of this module. Each look at the clock is then a step at which the model may
//! switch threads.

pub(crate) use core::hint::spin_loop;
pub(crate) use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};
pub(crate) use red_sync::Mailbox;
pub(crate) use std::thread::yield_now;

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
