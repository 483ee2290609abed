#![allow(unsafe_code, reason = "a runtime belongs to its handle")]
//! The runtime of a handle, which is there as long as calls on it last.

use super::engine::Engine;
use crate::handles::{self, Object, PLACES};
use crate::status::red_status;
use core::ops::Deref;
use red_sync::{Gate, Inside};
use std::thread;

/// Who is in a call on the runtime of each place.
static GATES: [Gate; PLACES] = [const { Gate::closed() }; PLACES];

/// Gives a runtime a handle.
pub(super) fn open(engine: Engine) -> Result<u64, red_status> {
    let engine = Box::into_raw(Box::new(engine));
    let opened = handles::open(&(0..0), || Object::Runtime(engine)).inspect_err(|_| {
        // SAFETY: nobody else knows of it.
        drop(unsafe { Box::from_raw(engine) });
    });
    opened.inspect(|bits| GATES.get(handles::place(*bits)).into_iter().for_each(Gate::open))
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
    let find = || match handles::object(bits) {
        Some(Object::Runtime(engine)) => Ok(engine),
        _ => Err(handles::refusal(bits)),
    };
    let _there = find()?;
    let gate = GATES.get(handles::place(bits)).ok_or(red_status::Foreign)?;
    let inside = gate.enter().ok_or(red_status::Closed)?;
    // Now nobody frees it; until here somebody may have, and opened another one in its place.
    let called = Called { bits, engine: find()?, gate, inside };
    if called.is_the_parents() { Err(red_status::Forked) } else { Ok(called) }
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
        let Self { bits, engine, gate, inside } = self;
        drop(inside);
        // Also those that are just being refused.
        while gate.inside() > 0 {
            thread::yield_now();
        }
        // SAFETY: made by `open`; nobody is in a call on it, and nobody comes in any more.
        drop(unsafe { Box::from_raw(engine) });
        handles::close(bits)
    }
}
