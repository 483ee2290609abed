#![allow(unsafe_code, reason = "objects in C's memory")]
//! What is open. A handle is a place in this table and the how-manieth that was opened there: one that was closed, made
//! up, or given to another copy of this library finds something else there and is refused, and no memory is touched.
//!
//! ```text
//! bits  0..8 place | 8..32 which copy of the library | 32..64 how-manieth
//! ```

use crate::graph::AnyGraph;
use crate::guard::Guarded;
use crate::machine::AnyMachine;
use crate::name::Name;
use crate::runtime::Engine;
use crate::status::red_status;
use core::cell::UnsafeCell;
use core::ops::Range;
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicU32, AtomicUsize, Ordering};

/// Places, of which the first stays empty: what was never opened is all zero, and finds it.
pub(crate) const PLACES: usize = if cfg!(target_os = "none") { 16 } else { 256 };

/// What a handle is for.
#[derive(Clone, Copy)]
pub(crate) enum Object {
    Nothing,
    Scheduler(*const AnyMachine),
    Dag(*const Guarded<AnyGraph>),
    #[cfg_attr(not(feature = "runtime"), expect(dead_code, reason = "the core alone opens none"))]
    Runtime(*mut Engine),
}

#[repr(C, align(64))] // One line of the cache, and no multiplication to find it.
struct Place {
    /// The handle of what is open here.
    name: Name,
    object: UnsafeCell<Object>,
    /// If it is a runtime, which may be closed, and another one opened here, while calls on it begin: its address.
    runtime: AtomicPtr<Engine>,
    /// Somebody opens here.
    claimed: AtomicU32,
    /// Addresses of the object's memory.
    start: AtomicUsize,
    end: AtomicUsize,
}

// SAFETY: `object` is written by who claimed the place, before it is open; calls on its handle read it, none of which goes on
// when a scheduler or a graph is closed, which is their caller's word.
unsafe impl Sync for Place {}

impl Place {
    const fn free() -> Self {
        Self {
            name: Name::none(),
            object: UnsafeCell::new(Object::Nothing),
            runtime: AtomicPtr::new(ptr::null_mut()),
            claimed: AtomicU32::new(0),
            start: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
        }
    }

    fn is_open(&self) -> bool {
        self.name.get() as u32 != 0
    }

    /// Whether what is open here lies in some of these addresses.
    fn overlaps(&self, range: &Range<usize>) -> bool {
        let name = self.name.get();
        // Acquire: pairs with the Release in `open`.
        let lies = || {
            self.start.load(Ordering::Acquire) < range.end && range.start < self.end.load(Ordering::Acquire)
        };
        // If it was closed meanwhile, start and end may be of two different ones.
        name as u32 != 0 && lies() && self.name.get() == name
    }

    /// Keeps everybody else from opening here.
    fn claim(&self) -> Option<Claim<'_>> {
        // Acquire: pairs with the Release in `Claim`.
        #[cfg(target_has_atomic = "32")]
        let claimed = self.claimed.compare_exchange(0, 1, Ordering::Acquire, Ordering::Relaxed).is_ok();
        // Without such an instruction there is one core, and who interrupts here is done before this goes on.
        #[cfg(not(target_has_atomic = "32"))]
        let claimed = self.claimed.load(Ordering::Acquire) == 0 && {
            self.claimed.store(1, Ordering::Relaxed);
            true
        };
        claimed.then(|| Claim(&self.claimed))
    }
}

struct Claim<'a>(&'a AtomicU32);

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        // Release: pairs with the Acquire in `Place::claim`.
        self.0.store(0, Ordering::Release);
    }
}

static TABLE: [Place; PLACES] = [const { Place::free() }; PLACES];

/// Which copy of the library this is: where its table lies, never 0.
fn copy() -> u32 {
    let address = (&raw const TABLE).addr();
    (((address >> 4) ^ (address >> 28)) as u32 | 1) << 8
}

/// Which place a handle is of.
#[inline(always)]
pub(crate) const fn place(bits: u64) -> usize {
    bits as usize & 0xff
}

/// The object of a handle.
#[inline(always)]
fn object(bits: u64) -> Option<Object> {
    let place = TABLE.get(place(bits))?;
    // SAFETY: the place is open, so its object was written before, and is not written until it is closed.
    (place.name.get() == bits).then(|| unsafe { *place.object.get() })
}

/// Why a handle is not of what it should be.
#[cold]
pub(crate) fn refusal(bits: u64) -> red_status {
    match TABLE.get(place(bits)) {
        _ if bits == 0 => red_status::Closed,
        Some(place) if place.name.get() == bits => red_status::OtherKind,
        _ if bits as u32 & !0xff == copy() => red_status::Closed,
        _ => red_status::Foreign,
    }
}

/// The runtime of a handle, which may be closed at any time.
#[cfg_attr(not(feature = "runtime"), expect(dead_code, reason = "the core alone opens none"))]
pub(crate) fn runtime(bits: u64) -> Result<*mut Engine, red_status> {
    let place = TABLE.get(place(bits)).filter(|place| place.name.get() == bits);
    // Relaxed: `Name::get` comes after what was stored before the name.
    let runtime = place.map(|place| place.runtime.load(Ordering::Relaxed));
    runtime.filter(|runtime| !runtime.is_null()).ok_or_else(|| refusal(bits))
}

/// The scheduler of a handle.
#[inline(always)]
pub(crate) fn scheduler(bits: u64) -> Result<&'static AnyMachine, red_status> {
    match object(bits) {
        // SAFETY: it was made at `open` and lives until `close`.
        Some(Object::Scheduler(machine)) => Ok(unsafe { &*machine }),
        _ => Err(refusal(bits)),
    }
}

/// The graph of a handle.
pub(crate) fn graph(bits: u64) -> Result<&'static Guarded<AnyGraph>, red_status> {
    match object(bits) {
        // SAFETY: it was made at `open` and lives until `close`.
        Some(Object::Dag(graph)) => Ok(unsafe { &*graph }),
        _ => Err(refusal(bits)),
    }
}

/// Opens what `make` makes in memory of these addresses; its handle.
pub(crate) fn open(range: &Range<usize>, make: impl FnOnce() -> Object) -> Result<u64, red_status> {
    if TABLE.iter().any(|place| place.overlaps(range)) {
        return Err(red_status::Overlap);
    }
    for (i, place) in TABLE.iter().enumerate().skip(1) {
        if place.is_open() {
            continue;
        }
        let Some(_claim) = place.claim() else { continue };
        // Another one may have opened it since.
        if place.is_open() {
            continue;
        }
        // Release: pairs with the Acquire in `Place::overlaps`, which then sees that the name before is gone.
        place.start.store(range.start, Ordering::Release);
        place.end.store(range.end, Ordering::Release);
        let object = make();
        let runtime = if let Object::Runtime(engine) = object { engine } else { ptr::null_mut() };
        place.runtime.store(runtime, Ordering::Relaxed);
        // SAFETY: nothing is open here and the claim is ours, so nobody else looks at it.
        unsafe { *place.object.get() = object };
        let name = (place.name.get() >> 32).wrapping_add(1) << 32 | u64::from(copy()) | i as u64;
        place.name.set(name);
        return Ok(name);
    }
    Err(red_status::TooManyOpen)
}

/// Closes the handle of what was just found; its memory is C's again. It waits for nobody: who opens may have claimed the
/// place, and then sees that it is not free.
pub(crate) fn close(bits: u64) -> Result<(), red_status> {
    let place = TABLE.get(place(bits)).ok_or(red_status::Foreign)?;
    if place.name.end(bits) { Ok(()) } else { Err(refusal(bits)) }
}

#[cfg(test)]
mod tests;
