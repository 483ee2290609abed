//! Room on the heap, asked for before what needs some is begun: collections of Rust end the process where there is none.

use crate::status::red_status;
use core::hint::black_box;

/// What a call takes at most, a copy of a graph and of its bodies among it. A test holds calls to it.
pub(crate) const OF_A_CALL: usize = 64 << 10;
/// What is written to until the log's thread comes to it, and that thread.
pub(crate) const OF_A_LOG: usize = 7 << 20;

/// Whether so many bytes can be had. What other threads take at this moment is not known.
pub(crate) fn room(bytes: usize) -> Result<(), red_status> {
    let mut room = Vec::<u8>::new();
    let is_there = room.try_reserve_exact(bytes).is_ok();
    // Else nobody would ask the allocator for what nobody uses.
    black_box(&room);
    if is_there { Ok(()) } else { Err(red_status::NoMemory) }
}
