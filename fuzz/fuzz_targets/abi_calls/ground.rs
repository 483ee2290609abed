#![allow(unsafe_code, reason = "memory that both sides use")]
//! Memory that the library and this target use, with an image of what is in it: what nobody may have written is found.
//!
//! Only addresses leave this file, and only copies come in: no reference lives while the library is called.

use std::alloc::{Layout, alloc_zeroed, handle_alloc_error};
use std::ops::Range;

/// More than any alignment that is asked for.
const ALIGN: usize = 4096;

/// Memory by offsets, and its image.
pub(crate) struct Ground {
    at: *mut u8,
    image: Vec<u8>,
    /// How much of it takes part.
    active: usize,
}

impl Ground {
    /// It is never given back: handles that the library might still have lead here.
    pub(crate) fn new(bytes: usize) -> Self {
        let layout = Layout::from_size_align(bytes, ALIGN).expect("a size of this target");
        // SAFETY: the size is not 0.
        let at = unsafe { alloc_zeroed(layout) };
        if at.is_null() {
            handle_alloc_error(layout);
        }
        Self { at, image: vec![0; bytes], active: bytes }
    }

    /// Begins anew with this much of it, all of one byte.
    pub(crate) fn reset(&mut self, active: usize, byte: u8) {
        self.active = active.min(self.image.len());
        self.fill(0..self.active, byte);
    }

    /// So much of it takes part; what is new is for the caller to fill.
    pub(crate) fn activate(&mut self, active: usize) {
        assert!(active <= self.image.len(), "room for all arguments of a call");
        self.active = active;
    }

    pub(crate) fn pointer<T>(&self, offset: usize) -> *mut T {
        self.at.wrapping_add(offset).cast()
    }

    /// Bytes of this target's: they are in memory and image.
    pub(crate) fn write(&mut self, offset: usize, bytes: &[u8]) {
        self.poke(offset, bytes);
        self.expect(offset, bytes);
    }

    pub(crate) fn fill(&mut self, range: Range<usize>, byte: u8) {
        self.image[range.clone()].fill(byte);
        // SAFETY: the image is as long as the memory, and `range` lies in it.
        unsafe { self.at.add(range.start).write_bytes(byte, range.len()) };
    }

    /// Bytes in the memory alone, as if the library had written them.
    pub(crate) fn poke(&self, offset: usize, bytes: &[u8]) {
        assert!(offset + bytes.len() <= self.image.len());
        // SAFETY: it lies in the memory, as just seen.
        unsafe { self.at.add(offset).copy_from(bytes.as_ptr(), bytes.len()) };
    }

    /// Bytes that the library should have written.
    pub(crate) fn expect(&mut self, offset: usize, bytes: &[u8]) {
        self.image[offset..offset + bytes.len()].copy_from_slice(bytes);
    }

    /// What the library has written there is right.
    pub(crate) fn accept(&mut self, range: Range<usize>) {
        let to = &mut self.image[range.clone()];
        // SAFETY: `range` lies in the image, so in the memory, and nobody writes there now.
        unsafe { to.as_mut_ptr().copy_from(self.at.add(range.start), range.len()) };
    }

    pub(crate) fn word(&self, offset: usize) -> u64 {
        let mut bytes = [0; 8];
        assert!(offset + 8 <= self.image.len());
        // SAFETY: it lies in the memory, as just seen, and nobody writes there now.
        unsafe { bytes.as_mut_ptr().copy_from(self.at.add(offset), 8) };
        u64::from_ne_bytes(bytes)
    }

    /// The first place where memory and image differ.
    pub(crate) fn difference(&self) -> Option<usize> {
        self.difference_in(0..self.active)
    }

    pub(crate) fn difference_in(&self, part: Range<usize>) -> Option<usize> {
        let image = &self.image[part.clone()];
        // SAFETY: `part` lies in the image, so in the memory, and nobody writes there now.
        let memory = unsafe { std::slice::from_raw_parts(self.at.add(part.start), part.len()) };
        if memory == image {
            return None;
        }
        memory.iter().zip(image).position(|(a, b)| a != b).map(|at| part.start + at)
    }
}

/// The bytes of a struct of the header.
pub(crate) fn bytes_of<T: red_core::Empty + Copy>(value: &T) -> &[u8] {
    // SAFETY: structs of the header are integers without gaps, which the library asserts of each.
    unsafe { std::slice::from_raw_parts((&raw const *value).cast(), size_of::<T>()) }
}
