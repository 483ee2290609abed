//! The checker's atomics, explored in full.
//!
//! The checker remembers only the last access of an atomic, and takes loads for independent of each other. So a thread
//! that loads and then stores hides an earlier load of another thread behind its own, and the orders in which the
//! store comes first are never tried (tokio-rs/loom, reports 166 and 392). Here each load is preceded by a relaxed
//! read-modify-write of another atomic, `turn`: it synchronises nothing, but it depends on that of every other load,
//! so that both orders of two loads are tried, and the store is in one of them before the other thread's load.

use loom::sync::atomic::{self, Ordering};

macro_rules! atomics {
    ($($name:ident($value:ty))*) => { $(
        #[derive(Debug, Default)]
        pub struct $name {
            turn: atomic::AtomicU8,
            word: atomic::$name,
        }

        impl $name {
            pub fn new(value: $value) -> Self {
                Self { turn: atomic::AtomicU8::new(0), word: atomic::$name::new(value) }
            }

            pub fn load(&self, order: Ordering) -> $value {
                self.turn.swap(0, Ordering::Relaxed);
                self.word.load(order)
            }

            pub fn store(&self, value: $value, order: Ordering) {
                self.word.store(value, order);
            }

            pub fn swap(&self, value: $value, order: Ordering) -> $value {
                self.word.swap(value, order)
            }

            pub fn fetch_or(&self, value: $value, order: Ordering) -> $value {
                self.word.fetch_or(value, order)
            }

            pub fn fetch_and(&self, value: $value, order: Ordering) -> $value {
                self.word.fetch_and(value, order)
            }

            pub fn compare_exchange(
                &self,
                current: $value,
                new: $value,
                success: Ordering,
                failure: Ordering,
            ) -> Result<$value, $value> {
                self.word.compare_exchange(current, new, success, failure)
            }

            pub fn fetch_update(
                &self,
                set: Ordering,
                fetch: Ordering,
                mut next: impl FnMut($value) -> Option<$value>,
            ) -> Result<$value, $value> {
                let mut before = self.load(fetch);
                while let Some(value) = next(before) {
                    match self.compare_exchange(before, value, set, fetch) {
                        Ok(before) => return Ok(before),
                        Err(other) => before = other,
                    }
                }
                Err(before)
            }
        }
    )* };
}
atomics! { AtomicBool(bool) AtomicU8(u8) AtomicU32(u32) AtomicI32(i32) AtomicU64(u64) }

#[derive(Debug)]
pub struct AtomicPtr<T> {
    turn: atomic::AtomicU8,
    word: atomic::AtomicPtr<T>,
}

impl<T> AtomicPtr<T> {
    pub fn new(value: *mut T) -> Self {
        Self { turn: atomic::AtomicU8::new(0), word: atomic::AtomicPtr::new(value) }
    }

    pub fn load(&self, order: Ordering) -> *mut T {
        self.turn.swap(0, Ordering::Relaxed);
        self.word.load(order)
    }

    pub fn store(&self, value: *mut T, order: Ordering) {
        self.word.store(value, order);
    }
}

impl AtomicU32 {
    pub fn fetch_add(&self, value: u32, order: Ordering) -> u32 {
        self.word.fetch_add(value, order)
    }

    pub fn fetch_sub(&self, value: u32, order: Ordering) -> u32 {
        self.word.fetch_sub(value, order)
    }
}
