//! One scheduler for many lanes: the paper's synchronizers (section 4.4). The scheduler itself knows no threads.
//! What shares it stands here, on the atomics of `primitive` alone, so that a model checker can put its own in their
//! place.
//!
//! | who | may call |
//! |---|---|
//! | lanes, each pinned to its own CPU, all of one priority | [`TicketLock`] |
//! | anybody, one thread per [`Mailbox`] | [`Post::push`]: wait-free |
//! | the holder of the lock | [`Mailbox::pop`] |
//! | a handler and one observer | [`HandlerCell`] |
//! | one writer at a time, any readers | [`SeqLock`]: wait-free |
//! | who uses something, and who takes it away | [`Gate`]: wait-free |
//!
//! Under SCHED_FIFO a thread that spins on a lock whose holder it has preempted on the same CPU never returns. So a
//! lane's CPU has no other contender. Hosts whose lanes share CPUs bring a priority-inheriting [`Exclusive`].
#![cfg_attr(not(test), no_std)]
#![deny(unsafe_code)]

mod exclusive;
mod gate;
mod handler;
mod mailbox;
mod primitive;
mod seq_lock;
mod shared;
mod ticket_lock;

pub use exclusive::Exclusive;
pub use gate::{Gate, Inside};
pub use handler::{HandlerCell, HandlerState, TransitionError};
pub use mailbox::{Mailbox, Post};
pub use seq_lock::SeqLock;
pub use shared::{Request, Requests, SharedScheduler};
pub use ticket_lock::TicketLock;
