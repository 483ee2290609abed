#![allow(unsafe_code, reason = "the one place where pointers from C are followed")]
//! Pointers from C, looked at before they are used: NULL, misaligned, too short, of another version.
//!
//! *Rule.* Nothing here keeps a pointer or makes a reference of one: values are copied in and out, so that arguments
//! which overlap do no harm. What cannot be seen is whether an address may be read or written at all; that it may is
//! what the header asks of C, and what every SAFETY comment here rests on.

use crate::status::red_status;
use crate::values::RED_ABI_VERSION;
use core::ffi::c_void;
use core::hint::cold_path;
use red_core::Empty;

/// A struct of integers without gaps: every pattern of bits is one.
///
/// # Safety
/// All fields are integers, and the layout has no padding.
pub(crate) unsafe trait Plain: Copy + Empty + 'static {}

// SAFETY: integers.
unsafe impl Plain for u8 {}
// SAFETY: integers.
unsafe impl Plain for u32 {}
// SAFETY: integers.
unsafe impl Plain for u64 {}
// SAFETY: integers.
unsafe impl Plain for i64 {}

/// A struct that begins with its size and the version of the ABI, and may get more fields at its end.
pub(crate) trait Growing: Plain {
    /// Size of the first version.
    const LEAST: usize;
}

/// What a struct may grow to.
const MOST: usize = 4096;
/// What begins every struct that may grow.
const HEAD: usize = 8;

/// Declares a struct of the header that is plain, without gaps.
macro_rules! plain {
    ($name:ident { $($field:ident: $t:ty),* $(,)? }) => {
        // SAFETY: all fields are integers or plain; the assertion below says that there are no gaps.
        unsafe impl $crate::boundary::Plain for $name {}
        const _: () = assert!(size_of::<$name>() == 0 $(+ size_of::<$t>())*, "no gaps");
        impl red_core::Empty for $name {
            const EMPTY: Self = Self { $($field: <$t as red_core::Empty>::EMPTY),* };
        }
    };
}
pub(crate) use plain;

/// Declares a struct with addresses plain: what they lead to is C's business.
#[cfg(feature = "runtime")]
macro_rules! vouched {
    ($name:ident) => {
        // SAFETY: integers and addresses, which may have any bits; a function's may be NULL, and else C vouches for it.
        unsafe impl $crate::boundary::Plain for $name {}
    };
}
#[cfg(feature = "runtime")]
pub(crate) use vouched;

fn aligned<T>(address: usize) -> Result<(), red_status> {
    if address == 0 {
        cold_path();
        return Err(red_status::NullPointer);
    }
    if !address.is_multiple_of(align_of::<T>()) {
        cold_path();
        return Err(red_status::Misaligned);
    }
    Ok(())
}

/// A value that C gives.
pub(crate) fn take<T: Plain>(from: *const T) -> Result<T, red_status> {
    aligned::<T>(from.addr())?;
    // SAFETY: C says that it may be read; it is not NULL and aligned, and any bits are a `T`.
    Ok(unsafe { from.read() })
}

/// The size and version that a struct from C begins with.
fn head<T: Growing>(at: *const T) -> Result<usize, red_status> {
    aligned::<T>(at.addr())?;
    // SAFETY: C says that it may be read up to the size that is read here; the head is part of every such struct.
    let [size, version] = unsafe { at.cast::<[u32; 2]>().read() };
    let size = size as usize;
    if size < T::LEAST || size > MOST || !size.is_multiple_of(4) {
        return Err(red_status::StructSize);
    }
    if version != RED_ABI_VERSION { Err(red_status::Version) } else { Ok(size) }
}

/// A struct that C gives. What it has beyond what is known here must be zero, what it lacks is.
pub(crate) fn take_growing<T: Growing>(from: *const T) -> Result<T, red_status> {
    let size = head(from)?;
    let known = size.min(size_of::<T>());
    let mut value = T::EMPTY;
    // SAFETY: C says that `size` bytes may be read, and `known` are at most that; `value` has room for them.
    unsafe { from.cast::<u8>().copy_to_nonoverlapping((&raw mut value).cast::<u8>(), known) };
    for at in known..size {
        // SAFETY: `at` is below `size`.
        let byte = unsafe { from.cast::<u8>().wrapping_add(at).read() };
        if byte != 0 {
            return Err(red_status::UnknownField);
        }
    }
    Ok(value)
}

/// Where C wants a value.
#[derive(Clone, Copy)]
pub(crate) struct Out<T>(*mut T);

impl<T: Plain> Out<T> {
    #[inline(always)]
    pub(crate) fn of(to: *mut T) -> Result<Self, red_status> {
        aligned::<T>(to.addr())?;
        Ok(Self(to))
    }

    #[inline(always)]
    pub(crate) fn put(self, value: T) {
        // SAFETY: C says that it may be written; it is not NULL and aligned.
        unsafe { self.0.write(value) };
    }
}

impl<T> Out<T> {
    /// As a struct that `T` begins with.
    #[inline(always)]
    pub(crate) const fn cast<H>(self) -> Out<H> {
        const { assert!(size_of::<H>() <= size_of::<T>() && align_of::<H>() <= align_of::<T>(), "inside") };
        Out(self.0.cast())
    }
}

/// Where C wants a struct, of which it knows so many bytes.
#[derive(Clone, Copy)]
pub(crate) struct OutGrowing<T>(*mut T, usize);

impl<T: Growing> OutGrowing<T> {
    pub(crate) fn of(to: *mut T) -> Result<Self, red_status> {
        Ok(Self(to, head(to)?))
    }

    /// Writes what C knows of it, but its size and version; what is not known here becomes zero.
    pub(crate) fn put(self, value: T) {
        let (to, from) = (self.0.cast::<u8>(), (&raw const value).cast::<u8>());
        let known = self.1.min(size_of::<T>());
        // SAFETY: both have `known` bytes, at least those of the first version, and `value` is here.
        unsafe { to.wrapping_add(HEAD).copy_from_nonoverlapping(from.wrapping_add(HEAD), known - HEAD) };
        // SAFETY: C says that as many bytes as its size says may be written.
        unsafe { to.wrapping_add(known).write_bytes(0, self.1 - known) };
    }
}

/// An array that C gives.
#[derive(Clone, Copy)]
pub(crate) struct Array<T>(*const T, usize);

impl<T: Plain> Array<T> {
    /// Of `len`, at most `most`; NULL where it is empty.
    pub(crate) fn of(from: *const T, len: usize, most: usize) -> Result<Self, red_status> {
        if len > most {
            return Err(red_status::TooLong);
        }
        if len > 0 {
            aligned::<T>(from.addr())?;
        }
        Ok(Self(from, len))
    }

    pub(crate) fn iter(self) -> impl ExactSizeIterator<Item = T> {
        (0..self.1).map(move |i| {
            // SAFETY: C says that as many may be read as it gave the number of; they are aligned, and any bits are a `T`.
            unsafe { self.0.wrapping_add(i).read() }
        })
    }
}

/// An array of structs that may grow: they lie as far apart as the first one's size says.
#[derive(Clone, Copy)]
pub(crate) struct GrowingArray<T> {
    first: *const T,
    len: usize,
    size: usize,
}

impl<T: Growing> GrowingArray<T> {
    pub(crate) fn of(first: *const T, len: usize, most: usize) -> Result<Self, red_status> {
        if len > most {
            return Err(red_status::TooLong);
        }
        let size = if len > 0 { head(first)? } else { 0 };
        if !size.is_multiple_of(align_of::<T>()) {
            return Err(red_status::StructSize);
        }
        Ok(Self { first, len, size })
    }

    pub(crate) fn get(&self, i: usize) -> Result<T, red_status> {
        if i >= self.len {
            return Err(red_status::OutOfRange);
        }
        let at = self.first.wrapping_byte_add(i * self.size);
        // Before it is read: one that says that it is longer than the others would be read beyond its place.
        if head(at)? != self.size {
            return Err(red_status::StructSize);
        }
        take_growing(at)
    }
}

/// Room for an array that C wants, and where it wants to know how many there are.
#[derive(Clone, Copy)]
pub(crate) struct Room<T> {
    to: *mut T,
    room: usize,
    count: *mut usize,
}

impl<T: Plain> Room<T> {
    /// For at most `room`; NULL where that is zero.
    pub(crate) fn of(to: *mut T, room: usize, count: *mut usize) -> Result<Self, red_status> {
        aligned::<usize>(count.addr())?;
        if room > 0 {
            aligned::<T>(to.addr())?;
        }
        if room > isize::MAX as usize / size_of::<T>() {
            return Err(red_status::TooLong);
        }
        Ok(Self { to, room, count })
    }

    /// Writes as many as find room and are there.
    pub(crate) fn take(self, mut next: impl FnMut() -> Option<T>) {
        let mut count = 0;
        while count < self.room
            && let Some(value) = next()
        {
            // SAFETY: C says that `room` of them may be written, and `count` is below that.
            unsafe { self.to.wrapping_add(count).write(value) };
            count += 1;
        }
        // SAFETY: C says that it may be written; it is not NULL and aligned.
        unsafe { self.count.write(count) };
    }

    /// Writes those that find room, all or nothing: if there are more, only how many.
    pub(crate) fn fill(self, values: impl Iterator<Item = T> + Clone) -> red_status {
        match self.begin(values.clone().count()) {
            Ok(mut filling) => values.for_each(|value| filling.put(value)),
            Err(status) => return status,
        }
        red_status::Ok
    }

    /// As [`Self::fill`], for so many that come one by one.
    pub(crate) fn begin(self, count: usize) -> Result<Filling<T>, red_status> {
        // SAFETY: C says that it may be written; it is not NULL and aligned.
        unsafe { self.count.write(count) };
        if count > self.room { Err(red_status::TooShort) } else { Ok(Filling { to: self.to, left: count }) }
    }
}

/// Room for so many more.
pub(crate) struct Filling<T> {
    to: *mut T,
    left: usize,
}

impl<T: Plain> Filling<T> {
    /// The next one; there are no more than were counted.
    pub(crate) fn put(&mut self, value: T) {
        if self.left > 0 {
            // SAFETY: C says that as many of them may be written as there is room for, of which `left` are.
            unsafe { self.to.write(value) };
            (self.to, self.left) = (self.to.wrapping_add(1), self.left - 1);
        }
    }
}

/// Memory that C lends until it is given back.
#[derive(Clone, Copy)]
pub(crate) struct Memory {
    at: *mut c_void,
    bytes: usize,
}

impl Memory {
    pub(crate) const fn of(at: *mut c_void, bytes: usize) -> Self {
        Self { at, bytes }
    }

    /// Where a `T` goes, if it fits.
    pub(crate) fn room_for<T>(self) -> Result<Place<T>, red_status> {
        aligned::<T>(self.at.addr())?;
        if self.bytes < size_of::<T>() {
            return Err(red_status::TooShort);
        }
        let end = self.at.addr().checked_add(self.bytes).ok_or(red_status::TooLong)?;
        Ok(Place { at: self.at.cast(), end })
    }
}

/// Room for a `T`, aligned and large enough.
pub(crate) struct Place<T> {
    at: *mut T,
    /// Where the memory ends that was lent.
    end: usize,
}

impl<T> Place<T> {
    /// All of the memory that was lent.
    pub(crate) fn range(&self) -> core::ops::Range<usize> {
        self.at.addr()..self.end
    }

    pub(crate) const fn pointer(&self) -> *mut T {
        self.at
    }

    /// What is answered goes elsewhere: it would be written over what is made here.
    pub(crate) fn apart_from<O>(&self, out: &Out<O>) -> Result<(), red_status> {
        let answer = out.0.addr()..out.0.addr().saturating_add(size_of::<O>());
        let is_within = answer.start < self.end && self.at.addr() < answer.end;
        if is_within { Err(red_status::Overlap) } else { Ok(()) }
    }

    /// Makes a `T` there.
    #[inline(always)]
    pub(crate) fn make(&self, value: T) {
        // SAFETY: `Memory` saw that it fits and is aligned; C says that it may be written and is used by nobody else.
        unsafe { self.at.write(value) };
    }

    /// Sets up the `T` that was made there.
    pub(crate) fn set_up(&self, how: impl FnOnce(&mut T)) {
        // SAFETY: it was made there, and is used by nobody else.
        how(unsafe { &mut *self.at });
    }
}
