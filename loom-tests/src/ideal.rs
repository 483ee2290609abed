//! The checker's own lock in the place of the real one: see the composition argument in `docs/loom.md`.

use crate::Exclusive;
use loom::sync::Mutex;

/// A lock that blocks instead of spinning, so that a model with it ends.
#[derive(Debug)]
pub struct Ideal<T>(Mutex<T>);

impl<T> Exclusive<T> for Ideal<T> {
    fn new(value: T) -> Self {
        Self(Mutex::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        f(&mut self.0.lock().expect("nobody panics under the lock"))
    }
}
