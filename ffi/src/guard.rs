#![allow(unsafe_code, reason = "one call at a time on what callers share")]
//! One call at a time on an object.
//!
//! *Rule.* A call that changes something marks the object, and another one meanwhile is `Busy`: exactly so where it comes
//! from below (a callback, a signal handler, an interrupt), and as far as it is seen where two threads forget to take
//! turns, which is theirs to do. The mark is a load and a store: a locked instruction would cost a fifth of a call.

use crate::status::red_status;
use core::cell::UnsafeCell;
use core::hint::cold_path;
use core::ops::{Deref, DerefMut};
use core::sync::atomic::{AtomicU32, Ordering};

/// An object and its mark.
pub(crate) struct Guarded<T: ?Sized> {
    busy: AtomicU32,
    object: UnsafeCell<T>,
}

// SAFETY: one call at a time changes the object, and none looks meanwhile; callers that do not take turns break the
// rule of the header.
unsafe impl<T: ?Sized> Sync for Guarded<T> {}

impl<T> Guarded<T> {
    pub(crate) const fn new(object: T) -> Self {
        Self { busy: AtomicU32::new(0), object: UnsafeCell::new(object) }
    }

    /// The object, of which nobody knows yet.
    pub(crate) const fn get_mut(&mut self) -> &mut T {
        self.object.get_mut()
    }
}

impl<T: ?Sized> Guarded<T> {
    /// For a call that changes the object.
    #[inline(always)]
    pub(crate) fn enter(&self) -> Result<Entered<'_, T>, red_status> {
        self.idle()?;
        self.busy.store(1, Ordering::Relaxed);
        Ok(Entered(self))
    }

    /// For a call that only looks; several may at once.
    #[inline(always)]
    pub(crate) fn look(&self) -> Result<&T, red_status> {
        self.idle()?;
        // SAFETY: no call changes it, and none may begin to before this one is over.
        Ok(unsafe { &*self.object.get() })
    }

    #[inline(always)]
    fn idle(&self) -> Result<(), red_status> {
        // Acquire: pairs with the Release in `Entered::drop`, so that this call sees what the last one did.
        if self.busy.load(Ordering::Acquire) != 0 {
            cold_path();
            return Err(red_status::Busy);
        }
        Ok(())
    }
}

/// A call that changes the object.
pub(crate) struct Entered<'a, T: ?Sized>(&'a Guarded<T>);

impl<T: ?Sized> Deref for Entered<'_, T> {
    type Target = T;

    #[inline(always)]
    fn deref(&self) -> &T {
        // SAFETY: the object is marked, so that this call alone has it.
        unsafe { &*self.0.object.get() }
    }
}

impl<T: ?Sized> DerefMut for Entered<'_, T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: the object is marked, so that this call alone has it.
        unsafe { &mut *self.0.object.get() }
    }
}

impl<T: ?Sized> Drop for Entered<'_, T> {
    #[inline(always)]
    fn drop(&mut self) {
        // Release: pairs with the Acquire in `idle`.
        self.0.busy.store(0, Ordering::Release);
    }
}
