//! The three capacity classes, named by what they hold: tasks x nodes of a task x jobs in flight. The sizes are
//! budgets: what is in them may grow up to them, and a build in which it would not fit stops.

use crate::dag::Lent;
use crate::machine::Shared;
use red_core::Caps;

/// 4 tasks of 16 nodes, 16 jobs in flight; 4 lanes in 2 pools, 64 events.
pub(crate) type Small = Caps<4, 16, 16, 4, 2, 1, 64>;
/// 8 tasks of 64 nodes, 32 jobs in flight; 8 lanes in 4 pools, 256 events.
pub(crate) type Medium = Caps<8, 64, 32, 8, 4, 1, 256>;
/// 16 tasks of 256 nodes, 64 jobs in flight; 32 lanes in 32 pools, 1,024 events.
pub(crate) type Large = Caps<16, 256, 64, 32, 32, 4, 1024>;

/// Alignment of all memory that is lent to this library.
pub const RED_ALIGN: usize = 64;

/// Bytes of a scheduler of 4 tasks of 16 nodes and 16 jobs in flight; 4 lanes in 2 pools, 64 events.
pub const RED_SCHEDULER_4X16X16_BYTES: usize = 20_480;
/// Bytes of a graph for that scheduler.
pub const RED_DAG_4X16X16_BYTES: usize = 2_048;
/// Bytes of a scheduler of 8 tasks of 64 nodes and 32 jobs in flight; 8 lanes in 4 pools, 256 events.
pub const RED_SCHEDULER_8X64X32_BYTES: usize = 131_072;
/// Bytes of a graph for that scheduler.
pub const RED_DAG_8X64X32_BYTES: usize = 8_192;
/// Bytes of a scheduler of 16 tasks of 256 nodes and 64 jobs in flight; 32 lanes in 32 pools, 1,024 events.
pub const RED_SCHEDULER_16X256X64_BYTES: usize = 1_048_576;
/// Bytes of a graph for that scheduler.
pub const RED_DAG_16X256X64_BYTES: usize = 32_768;

const fn fits<T>(bytes: usize) {
    assert!(size_of::<T>() <= bytes, "the budget holds it");
    assert!(align_of::<T>() <= RED_ALIGN, "the alignment holds it");
}

const _: () = {
    fits::<Shared<Small>>(RED_SCHEDULER_4X16X16_BYTES);
    fits::<Shared<Medium>>(RED_SCHEDULER_8X64X32_BYTES);
    fits::<Shared<Large>>(RED_SCHEDULER_16X256X64_BYTES);
    fits::<Lent<Small>>(RED_DAG_4X16X16_BYTES);
    fits::<Lent<Medium>>(RED_DAG_8X64X32_BYTES);
    fits::<Lent<Large>>(RED_DAG_16X256X64_BYTES);
};
