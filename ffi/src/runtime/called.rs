#![allow(unsafe_code, reason = "a runtime belongs to its handle")]
//! The runtime of a handle, which is there as long as calls on it last.

use super::engine::Engine;
use super::fork;
use crate::handles::{self, Object, PLACES};
use crate::status::red_status;
use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};
use red_sync::{Gate, Inside};

/// Where calls on the runtime of a place come in.
struct Door {
    /// The process that opened it.
    forks: AtomicU32,
    gate: Gate,
}

static DOORS: [Door; PLACES] = [const { Door { forks: AtomicU32::new(0), gate: Gate::closed() } }; PLACES];

impl Door {
    fn open(&self) {
        let forks = fork::generation();
        // Relaxed: nobody else has the handle yet.
        if self.forks.swap(forks, Ordering::Relaxed) != forks {
            self.gate.forget();
        }
        self.gate.open();
    }
}

/// Gives a runtime a handle.
pub(super) fn open(engine: Engine) -> Result<u64, red_status> {
    let engine = Box::into_raw(Box::new(engine));
    let opened = handles::open(&(0..0), || Object::Runtime(engine)).inspect_err(|_| {
        // SAFETY: nobody else knows of it.
        drop(unsafe { Box::from_raw(engine) });
    });
    opened.inspect(|bits| DOORS.get(handles::place(*bits)).into_iter().for_each(Door::open))
}

/// A call on a runtime.
pub(crate) struct Called {
    bits: u64,
    engine: *mut Engine,
    gate: &'static Gate,
    inside: Inside<'static>,
}

impl Deref for Called {
    type Target = Engine;

    fn deref(&self) -> &Engine {
        // SAFETY: it was leaked at `open`, and is freed when nobody is inside any more.
        unsafe { &*self.engine }
    }
}

/// Begins a call on the runtime of a handle.
pub(crate) fn engine(bits: u64) -> Result<Called, red_status> {
    let _there = handles::runtime(bits)?;
    let Door { forks, gate } = DOORS.get(handles::place(bits)).ok_or(red_status::Foreign)?;
    // Before the gate, which the parent may have closed.
    if forks.load(Ordering::Relaxed) != fork::generation() {
        return Err(red_status::Forked);
    }
    let inside = gate.enter().ok_or(red_status::Closed)?;
    // Now nobody frees it; until here somebody may have, and opened another one in its place.
    Ok(Called { bits, engine: handles::runtime(bits)?, gate, inside })
}

impl Called {
    /// Lets no other call begin. One alone closes it.
    pub(super) fn shut(&self) -> Result<(), red_status> {
        if self.gate.close() { Ok(()) } else { Err(red_status::Closed) }
    }

    /// Whether no other call goes on; if nobody else can begin one, it stays so.
    pub(super) fn is_alone(&self) -> bool {
        self.gate.inside() == 1
    }

    /// Frees a runtime that is shut, when no other call goes on, and then its handle.
    pub(super) fn free(self) -> Result<(), red_status> {
        if self.gate.enter().is_some() {
            return Err(red_status::Internal);
        }
        // What is freed is the address that `open` had: a reference to it only looks.
        let Self { bits, engine, inside, .. } = self;
        drop(inside);
        // SAFETY: made by `open`; nobody is in a call on it, and nobody comes in any more. Who is just being refused is
        // counted at the door, which stays.
        drop(unsafe { Box::from_raw(engine) });
        handles::close(bits)
    }
}
