//! The handle of what is open in a place, read by every call. The low half is 0 while nothing is; the high half stays, so
//! that the next handle of the place is another one.

#[cfg(target_has_atomic = "64")]
mod whole {
    use core::sync::atomic::{AtomicU64, Ordering};

    pub(crate) struct Name(AtomicU64);

    impl Name {
        pub(crate) const fn none() -> Self {
            Self(AtomicU64::new(0))
        }

        #[inline(always)]
        pub(crate) fn get(&self) -> u64 {
            // Acquire: pairs with the Release in `set`, so that the object is there.
            self.0.load(Ordering::Acquire)
        }

        pub(crate) fn set(&self, name: u64) {
            // Release: pairs with the Acquire in `get`.
            self.0.store(name, Ordering::Release);
        }

        /// Ends this name, if it is still that one.
        pub(crate) fn end(&self, name: u64) -> bool {
            // Release: pairs with the Acquire in `get`, so that who opens comes after all calls on what was there.
            self.0.compare_exchange(name, name >> 32 << 32, Ordering::Release, Ordering::Relaxed).is_ok()
        }
    }
}

/// Where a processor has no atomic of 64 bits: the low half says whether the high one holds.
#[cfg(not(target_has_atomic = "64"))]
mod halves {
    use core::sync::atomic::{AtomicU32, Ordering};

    pub(crate) struct Name {
        low: AtomicU32,
        high: AtomicU32,
    }

    impl Name {
        pub(crate) const fn none() -> Self {
            Self { low: AtomicU32::new(0), high: AtomicU32::new(0) }
        }

        #[inline(always)]
        pub(crate) fn get(&self) -> u64 {
            // Acquire: pairs with the Release in `set`, so that the high half and the object are there.
            let low = self.low.load(Ordering::Acquire);
            u64::from(self.high.load(Ordering::Relaxed)) << 32 | u64::from(low)
        }

        pub(crate) fn set(&self, name: u64) {
            self.high.store((name >> 32) as u32, Ordering::Relaxed);
            // Release: pairs with the Acquire in `get`.
            self.low.store(name as u32, Ordering::Release);
        }

        /// Ends this name, if it is still that one. Who interrupts here does not close what this call closes.
        pub(crate) fn end(&self, name: u64) -> bool {
            let is_it = self.get() == name;
            if is_it {
                // Release: pairs with the Acquire in `get`, so that who opens comes after all calls on what was there.
                self.low.store(0, Ordering::Release);
            }
            is_it
        }
    }
}

#[cfg(not(target_has_atomic = "64"))]
pub(crate) use halves::Name;
#[cfg(target_has_atomic = "64")]
pub(crate) use whole::Name;
