#![allow(unsafe_code, reason = "objects of C's memory, used by one call at a time")]
//! What is open. A handle is a place in this table and the how-manieth that was opened there: one that was closed, made
//! up, or given to another copy of this library finds something else there and is refused, and no memory is touched.
//!
//! ```text
//! bits  0..8 place | 8..32 which copy of the library | 32..64 how-manieth
//! ```
//!
//! *One call at a time.* A call that changes something marks its place, and another one meanwhile is `Busy`: exactly so
//! where it comes from below (a callback, a signal handler, an interrupt), and as far as it is seen where two threads
//! forget to take turns, which is theirs to do: the mark is a load and a store, because a locked instruction would cost
//! as much as a tenth of a call.

use crate::graph::AnyGraph;
use crate::machine::AnyMachine;
use crate::status::red_status;
use core::cell::UnsafeCell;
use core::ops::Range;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

/// Handles that may be open at once.
#[cfg(not(target_os = "none"))]
const OPEN_MAX: usize = 256;
/// Handles that may be open at once.
#[cfg(target_os = "none")]
const OPEN_MAX: usize = 8;

/// What a handle is for.
#[derive(Clone, Copy)]
pub(crate) enum Object {
    Nothing,
    Scheduler(*mut AnyMachine),
    Dag(*mut AnyGraph),
}

/// One place of the table.
struct Place {
    /// Odd while something is open; grows when it is opened and when it is closed.
    generation: AtomicU32,
    busy: AtomicU32,
    /// Addresses of the object's memory.
    start: AtomicUsize,
    end: AtomicUsize,
    object: UnsafeCell<Object>,
}

// SAFETY: `object` is written by who opened or closed the place and holds its mark, and read by calls on its handle.
unsafe impl Sync for Place {}

impl Place {
    const fn free() -> Self {
        Self {
            generation: AtomicU32::new(0),
            busy: AtomicU32::new(0),
            start: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
            object: UnsafeCell::new(Object::Nothing),
        }
    }
}

static TABLE: [Place; OPEN_MAX] = [const { Place::free() }; OPEN_MAX];

/// Which copy of the library this is: where its table lies, never 0.
#[inline(always)]
fn copy() -> u32 {
    let address = (&raw const TABLE).addr();
    ((address >> 4) as u32 ^ (address >> 28) as u32) & 0xff_ffff | 1
}

fn name(place: usize, generation: u32) -> u64 {
    u64::from(generation) << 32 | u64::from(copy()) << 8 | place as u64
}

/// The mark of a call that goes on.
struct Mark<'a>(&'a AtomicU32);

impl Drop for Mark<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        // Release: pairs with the Acquire in `find`, so that the next call sees what this one did.
        self.0.store(0, Ordering::Release);
    }
}

/// The open place of a handle, while no call changes what is there.
#[inline(always)]
fn find(bits: u64) -> Result<&'static Place, red_status> {
    let refuse = || if bits == 0 { red_status::Closed } else { red_status::Foreign };
    if (bits >> 8) as u32 & 0xff_ffff != copy() {
        return Err(refuse());
    }
    let place = TABLE.get(bits as usize & 0xff).ok_or(red_status::Foreign)?;
    // Acquire: pairs with the Release in `open`, so that the object is there.
    let generation = place.generation.load(Ordering::Acquire);
    if generation != (bits >> 32) as u32 || generation % 2 == 0 {
        return Err(red_status::Closed);
    }
    // Acquire: pairs with the Release in `Mark`.
    if place.busy.load(Ordering::Acquire) != 0 {
        return Err(red_status::Busy);
    }
    Ok(place)
}

#[inline(always)]
fn mark(place: &Place) -> Mark<'_> {
    place.busy.store(1, Ordering::Relaxed);
    Mark(&place.busy)
}

/// Marks a free place, so that nobody else opens there.
fn claim(place: &Place) -> bool {
    // Acquire: pairs with the Release in `close`.
    #[cfg(target_has_atomic = "32")]
    let claimed = place.busy.compare_exchange(0, 1, Ordering::Acquire, Ordering::Relaxed).is_ok();
    // Without such an instruction there is one core, and who interrupts here is done before this goes on.
    #[cfg(not(target_has_atomic = "32"))]
    let claimed = place.busy.load(Ordering::Acquire) == 0 && {
        place.busy.store(1, Ordering::Relaxed);
        true
    };
    claimed
}

/// Opens what `make` makes in memory of these addresses; its handle.
pub(crate) fn open(range: Range<usize>, make: impl FnOnce() -> Object) -> Result<u64, red_status> {
    let is_open = |place: &&Place| place.generation.load(Ordering::Acquire) % 2 == 1;
    let overlaps = |place: &Place| {
        place.start.load(Ordering::Relaxed) < range.end && range.start < place.end.load(Ordering::Relaxed)
    };
    if TABLE.iter().filter(is_open).any(overlaps) {
        return Err(red_status::Overlap);
    }
    for (i, place) in TABLE.iter().enumerate() {
        if is_open(&place) || !claim(place) {
            continue;
        }
        let _mark = Mark(&place.busy);
        // Another one may have opened and closed it since.
        let generation = place.generation.load(Ordering::Acquire);
        if generation % 2 == 1 {
            continue;
        }
        place.start.store(range.start, Ordering::Relaxed);
        place.end.store(range.end, Ordering::Relaxed);
        // SAFETY: the place is free and its mark is ours, so nobody else looks at it.
        unsafe { *place.object.get() = make() };
        let generation = generation.wrapping_add(1);
        // Release: pairs with the Acquire in `find`.
        place.generation.store(generation, Ordering::Release);
        return Ok(name(i, generation));
    }
    Err(red_status::TooManyOpen)
}

/// What a handle can be for.
pub(crate) trait Kind: 'static {
    fn of(object: Object) -> Option<*mut Self>;
}

impl Kind for AnyMachine {
    #[inline(always)]
    fn of(object: Object) -> Option<*mut Self> {
        if let Object::Scheduler(machine) = object { Some(machine) } else { None }
    }
}

impl Kind for AnyGraph {
    #[inline(always)]
    fn of(object: Object) -> Option<*mut Self> {
        if let Object::Dag(graph) = object { Some(graph) } else { None }
    }
}

#[inline(always)]
fn object<T: Kind + ?Sized>(place: &Place) -> Result<*mut T, red_status> {
    // SAFETY: the place is open, so its object was written before, and is not written until it is closed.
    let object = unsafe { *place.object.get() };
    T::of(object).ok_or(red_status::OtherKind)
}

/// Makes a call that changes what is open.
#[inline(always)]
pub(crate) fn change<T: Kind + ?Sized, R>(
    bits: u64,
    call: impl FnOnce(&mut T) -> R,
) -> Result<R, red_status> {
    let place = find(bits)?;
    let object = object::<T>(place)?;
    let _mark = mark(place);
    // SAFETY: it was made at `open` and lives until `close`; the mark keeps other calls out, as far as callers that
    // do not take turns let it.
    Ok(call(unsafe { &mut *object }))
}

/// Makes a call that only looks; several may at once.
#[inline(always)]
pub(crate) fn look<T: Kind + ?Sized, R>(bits: u64, call: impl FnOnce(&T) -> R) -> Result<R, red_status> {
    let place = find(bits)?;
    let object = object::<T>(place)?;
    // SAFETY: as in `change`, and calls that look change nothing.
    Ok(call(unsafe { &*object }))
}

/// Closes what is open: `end` is called with it, and its memory is C's again.
pub(crate) fn close<T: Kind + ?Sized>(bits: u64, end: impl FnOnce(*mut T)) -> Result<(), red_status> {
    let place = find(bits)?;
    let object = object::<T>(place)?;
    let _mark = mark(place);
    let generation = (bits >> 32) as u32;
    end(object);
    place.start.store(0, Ordering::Relaxed);
    place.end.store(0, Ordering::Relaxed);
    // Release: pairs with the Acquire in `open`, which may use the place again.
    place.generation.store(generation.wrapping_add(1), Ordering::Release);
    Ok(())
}
