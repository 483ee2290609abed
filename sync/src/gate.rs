//! A gate: who goes in is counted, so that who closes it knows when all have left, and may take away what they used.
//!
//! *Rule.* One word has both, the count and whether it is closed. Whoever counts itself in looks at the same time whether it
//! is closed, and leaves again if so; after that nobody stays.

use crate::primitive::{AtomicU32, Ordering, constructor};

/// Closed; below it, how many are inside or find out that they may not.
const CLOSED: u32 = 1 << 31;

/// It is closed at first. Threads: any, at once; below 2^31 of them.
///
/// ```
/// let gate = red_sync::Gate::closed();
/// assert!(gate.enter().is_none());
/// gate.open();
/// let inside = gate.enter();
/// assert!(inside.is_some() && gate.close());
/// assert!(gate.enter().is_none() && !gate.close());
/// assert_eq!(gate.inside(), 1);
/// drop(inside);
/// assert_eq!(gate.inside(), 0);
///
/// gate.open();
/// let _of_the_parent = gate.enter();
/// gate.forget();
/// assert!(gate.enter().is_none() && gate.inside() == 0);
/// ```
#[derive(Debug)]
pub struct Gate(AtomicU32);

impl Gate {
    constructor! {
        /// Nobody is let in.
        pub fn closed() -> Self {
            Self(AtomicU32::new(CLOSED))
        }
    }

    /// Lets in who comes from now on. Wait-free.
    pub fn open(&self) {
        // Release: pairs with the Acquire in `enter`, so that what they use is there.
        self.0.fetch_and(!CLOSED, Ordering::Release);
    }

    /// Goes in, until what is answered is dropped; `None` if it is closed. Wait-free.
    pub fn enter(&self) -> Option<Inside<'_>> {
        // So that those who ask at a closed one are not counted all the time. Relaxed: the count below decides.
        if self.0.load(Ordering::Relaxed) & CLOSED != 0 {
            return None;
        }
        // Acquire: pairs with the Release in `open`.
        let found = self.0.fetch_add(1, Ordering::Acquire);
        let inside = Inside(self);
        (found & CLOSED == 0).then_some(inside)
    }

    /// Lets nobody in any more. Whether it was open: of several that close it, one did. Wait-free.
    #[must_use = "whoever did not close it must not take anything away"]
    pub fn close(&self) -> bool {
        self.0.fetch_or(CLOSED, Ordering::Relaxed) & CLOSED == 0
    }

    /// Forgets who was inside and closes it, where they are not any more: in the child of a fork. Wait-free.
    pub fn forget(&self) {
        self.0.store(CLOSED, Ordering::Relaxed);
    }

    /// How many are inside; who was refused may be counted for a moment. Wait-free.
    pub fn inside(&self) -> u32 {
        // Acquire: pairs with the Release in `Inside`, so that who finds nobody comes after all that they did.
        self.0.load(Ordering::Acquire) & !CLOSED
    }
}

/// Somebody is inside.
#[derive(Debug)]
#[must_use = "who drops it has left"]
pub struct Inside<'a>(&'a Gate);

impl Drop for Inside<'_> {
    fn drop(&mut self) {
        // Release: pairs with the Acquire in `Gate::inside`.
        self.0.0.fetch_sub(1, Ordering::Release);
    }
}
