//! The core alone has no runtime.

/// None.
pub(crate) enum Engine {}
