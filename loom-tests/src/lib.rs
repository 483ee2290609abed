//! What the models of `tests` share. Empty without `--cfg loom`; `cargo xtask loom` runs them.
//!
//! The synchronizers and the protocols of the Linux host are the very files of `sync/src` and `rt-linux/src`, over
//! `primitive` in the place of those packages' modules of the same name.
#![cfg(loom)]
#![allow(missing_docs, reason = "the checker's atomics are documented by those of the language")]
#![allow(dead_code, reason = "not all that the included files have is in a model")]
#![allow(unexpected_cfgs, reason = "features are those of the packages that the files are from")]

pub mod atomics;
pub mod ideal;
pub mod kernel;
pub mod lanes;
pub mod model;
mod primitive;

/// Modules at their paths. In a macro, because rustfmt would look for their tests beside this file.
macro_rules! included {
    ($($name:ident: $file:literal,)*) => { $(#[path = $file] pub mod $name;)* };
}
included! {
    exclusive: "../../sync/src/exclusive.rs",
    gate: "../../sync/src/gate.rs",
    handler_cell: "../../sync/src/handler.rs",
    mailbox: "../../sync/src/mailbox.rs",
    seq_lock: "../../sync/src/seq_lock.rs",
    shared: "../../sync/src/shared.rs",
    ticket_lock: "../../sync/src/ticket_lock.rs",
    bell: "../../rt-linux/src/bell.rs",
    errands: "../../rt-linux/src/errands.rs",
    handler: "../../rt-linux/src/handler.rs",
    seat: "../../rt-linux/src/seat.rs",
    sleeper: "../../rt-linux/src/sleeper.rs",
    slot: "../../rt-linux/src/slot.rs",
    spares: "../../rt-linux/src/spares.rs",
    stream: "../../rt-linux/src/stream.rs",
    stream_seat: "../../rt-linux/src/stream_seat.rs",
    spin_lead: "../../rt-linux/src/spin_lead.rs",
    waiting: "../../rt-linux/src/waiting.rs",
}

pub use exclusive::Exclusive;
pub use mailbox::{Mailbox, Post};
