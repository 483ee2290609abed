//! Layer 4: policies as pure functions. A policy sees values, changes nothing, and is tested alone.

pub(crate) mod floor;
pub(crate) mod frame_cache;
pub(crate) mod merge;
pub(crate) mod overload;

pub use floor::Floor;
pub use overload::Overload;
