//! What a lock has to be, whoever brings it.

/// Something that lets one caller at a time have a value.
pub trait Exclusive<T> {
    /// Wraps a value.
    fn new(value: T) -> Self;

    /// Runs `f` alone with the value.
    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R;
}
