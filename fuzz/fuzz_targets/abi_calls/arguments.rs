//! Arguments, right and wrong. What is wrong for sure is noted; then the call has to answer one of that.

use std::ffi::c_char;
use std::ops::Range;
use std::path::Path;

use red_core::Empty;
use red_ffi::{RED_ABI_VERSION, red_status};

use crate::ground::bytes_of;
use crate::world::World;

/// The size and version that a struct begins with.
const HEAD: usize = 8;

/// Where a value comes out.
#[derive(Clone, Copy)]
pub(crate) struct Out<T> {
    at: usize,
    pub(crate) pointer: *mut T,
}

/// Where a struct comes out of which C knows so many bytes.
#[derive(Clone, Copy)]
pub(crate) struct OutGrowing<T> {
    at: usize,
    size: usize,
    pub(crate) pointer: *mut T,
}

/// Room for an array that comes out, and for how many there are.
#[derive(Clone, Copy)]
pub(crate) struct Room<T> {
    to: usize,
    pub(crate) pointer: *mut T,
    pub(crate) room: usize,
    pub(crate) count: Out<usize>,
}

/// Memory that is lent.
#[derive(Clone)]
pub(crate) struct Lent {
    pub(crate) pointer: *mut std::ffi::c_void,
    pub(crate) bytes: usize,
    pub(crate) range: Range<usize>,
}

impl World<'_> {
    /// A pointer made NULL or misaligned; what it was else.
    fn pointer<T>(&mut self, at: usize, spoils: bool) -> *mut T {
        let odd = if align_of::<T>() > 1 { 1 + self.odd(spoils) % (align_of::<T>() - 1) } else { 0 };
        match (spoils, odd % 2) {
            (false, _) => self.desk.pointer(at),
            (true, 0) => {
                self.is_wrong(red_status::NullPointer);
                std::ptr::null_mut()
            }
            (true, _) => {
                self.is_wrong(red_status::Misaligned);
                self.desk.pointer(at + odd)
            }
        }
    }

    fn odd(&mut self, spoils: bool) -> usize {
        if spoils { self.choices.byte().into() } else { 0 }
    }

    pub(crate) fn out<T: Empty + Copy>(&mut self) -> Out<T> {
        let spoils = self.spoils();
        // An output may lie where an input was, which is read before.
        if spoils && size_of::<T>() <= 8 && self.choices.chance(128) {
            let which = self.choices.byte().into();
            if let Some(at) = self.desk.shared(which, size_of::<T>()) {
                return Out { at, pointer: self.desk.pointer(at) };
            }
        }
        let at = self.desk.place(size_of::<T>());
        Out { at, pointer: self.pointer(at, spoils) }
    }

    pub(crate) fn put<T: Empty + Copy>(&mut self, out: Out<T>, value: &T) {
        self.desk.expect(out.at, bytes_of(value));
    }

    /// The first bytes of a value.
    pub(crate) fn put_some<T: Empty + Copy>(&mut self, out: Out<T>, value: &T, bytes: usize) {
        self.desk.expect(out.at, &bytes_of(value)[..bytes]);
    }

    /// What came out, of a handle.
    pub(crate) fn handle_in<T>(&mut self, out: Out<T>) -> u64 {
        let bits = self.desk.word(out.at);
        self.desk.expect(out.at, &bits.to_ne_bytes());
        bits
    }

    /// A struct with its head, which may be wrong, and what is behind it.
    fn growing<T: Empty + Copy>(&mut self, value: &T, is_read: bool) -> (usize, usize, *mut T) {
        let spoils = self.spoils();
        let kind = if spoils { self.choices.byte() % 16 } else { 0 };
        let known = size_of::<T>();
        let size = match kind {
            4 => self.choices.one_of(&[0, 4, 8, known - 8, known - 4, known - 1, known + 2]),
            5 => self.choices.one_of(&[4_097, 4_100, 1 << 31, u32::MAX as usize]),
            6..=8 => self.choices.one_of(&[known + 4, known + 8, known + 64, 4_096]),
            9 => self.choices.one_of(&[known + 4, known + 72]),
            _ => known,
        };
        if size < known || size > 4_096 || size % 4 != 0 {
            self.is_wrong(red_status::StructSize);
        }
        let version = if kind == 3 { self.choices.one_of(&[0, 2, u32::MAX]) } else { RED_ABI_VERSION };
        if version != RED_ABI_VERSION && kind == 3 {
            self.is_wrong(red_status::Version);
        }
        let mut bytes = bytes_of(value).to_vec();
        bytes[..4].copy_from_slice(&(size as u32).to_ne_bytes());
        bytes[4..HEAD].copy_from_slice(&version.to_ne_bytes());
        if is_read {
            bytes.resize(size.clamp(known, 4_096), 0);
            if kind == 9 {
                let at = known + self.choices.below(size - known);
                bytes[at] = 1;
                self.is_wrong(red_status::UnknownField);
            }
        }
        let at = if is_read {
            self.desk.input(&bytes)
        } else {
            let at = self.desk.place(size.clamp(known, 4_096));
            self.desk.write(at, &bytes[..HEAD]);
            at
        };
        let pointer = self.pointer(at, kind == 1 || kind == 2);
        (at, size, pointer)
    }

    pub(crate) fn given<T: Empty + Copy>(&mut self, value: &T) -> *const T {
        self.growing(value, true).2
    }

    pub(crate) fn out_growing<T: Empty + Copy>(&mut self) -> OutGrowing<T> {
        let (at, size, pointer) = self.growing(&T::EMPTY, false);
        OutGrowing { at, size, pointer }
    }

    /// All of the value but its head; what is not known comes out as zero.
    pub(crate) fn put_growing<T: Empty + Copy>(&mut self, out: OutGrowing<T>, value: &T) {
        let mut bytes = bytes_of(value)[HEAD..].to_vec();
        bytes.resize(out.size - HEAD, 0);
        self.desk.expect(out.at + HEAD, &bytes);
    }

    /// Structs that may grow, as far apart as the first one's size says.
    pub(crate) fn given_array<T: Empty + Copy>(&mut self, values: &[T]) -> *const T {
        let spoils = self.spoils();
        let kind = if spoils { self.choices.byte() % 8 } else { 0 };
        let known = size_of::<T>();
        let stride = if kind == 3 { known + 8 * (1 + self.choices.below(8)) } else { known };
        let stride = if kind == 4 && !values.is_empty() { known + 4 } else { stride };
        let mut bytes = vec![0; stride * values.len()];
        let another =
            if kind == 5 && values.len() > 1 { 1 + self.choices.below(values.len() - 1) } else { usize::MAX };
        for (i, value) in values.iter().enumerate() {
            let size = if i == another { known + 8 } else { stride };
            let room = &mut bytes[i * stride..][..known];
            room.copy_from_slice(bytes_of(value));
            room[..4].copy_from_slice(&(size as u32).to_ne_bytes());
            room[4..HEAD].copy_from_slice(&RED_ABI_VERSION.to_ne_bytes());
        }
        if kind == 4 && !values.is_empty() {
            self.is_wrong(red_status::StructSize);
        }
        if another != usize::MAX {
            // What follows it is looked at as if it belonged to it.
            self.is_wrong(red_status::StructSize);
            self.is_wrong(red_status::UnknownField);
        }
        bytes.resize(bytes.len() + 16, 0);
        let at = self.desk.input(&bytes);
        self.pointer(at, !values.is_empty() && (kind == 1 || kind == 2))
    }

    /// Numbers, whose length is another argument.
    pub(crate) fn numbers<T: Empty + Copy>(&mut self, values: &[T]) -> *const T {
        let spoils = self.spoils();
        let bytes: Vec<u8> = values.iter().flat_map(bytes_of).copied().collect();
        let at = self.desk.input(&bytes);
        if values.is_empty() && spoils {
            return if self.choices.chance(128) { std::ptr::null() } else { self.desk.pointer(at + 1) };
        }
        self.pointer(at, spoils)
    }

    /// A length that may be more than anything could have.
    pub(crate) fn length(&mut self, right: usize, most: usize) -> usize {
        if !self.spoils() {
            return right;
        }
        self.is_wrong(red_status::TooLong);
        self.choices.one_of(&[most + 1, 1 << 32, usize::MAX, usize::MAX / 8 + 1])
    }

    pub(crate) fn room<T: Empty + Copy>(&mut self, most: usize) -> Room<T> {
        let spoils = self.spoils();
        let mut room =
            if self.careful || self.choices.chance(200) { most } else { self.choices.below(most + 1) };
        let to = self.desk.place(size_of::<T>() * room);
        let kind = if spoils { self.choices.byte() % 3 } else { 2 };
        let pointer = if room == 0 && kind < 2 {
            if kind == 0 { std::ptr::null_mut() } else { self.desk.pointer(to + 1) }
        } else {
            self.pointer(to, kind < 2)
        };
        if spoils && kind == 2 {
            room = self.choices.one_of(&[
                usize::MAX,
                usize::MAX / 2 + 1,
                isize::MAX as usize / size_of::<T>() + 1,
            ]);
            self.is_wrong(red_status::TooLong);
        }
        let count = self.desk.place(8);
        let wrong = self.spoils();
        let count = Out { at: count, pointer: self.pointer(count, wrong) };
        Room { to, pointer, room, count }
    }

    /// All or nothing: if they are more than there is room for, only how many.
    pub(crate) fn fill<T: Empty + Copy>(&mut self, room: Room<T>, values: &[T]) -> Result<(), red_status> {
        self.desk.expect(room.count.at, &values.len().to_ne_bytes());
        if values.len() > room.room {
            return Err(red_status::TooShort);
        }
        self.take(room, values);
        Ok(())
    }

    /// As many as there are.
    pub(crate) fn take<T: Empty + Copy>(&mut self, room: Room<T>, values: &[T]) {
        self.desk.expect(room.count.at, &values.len().to_ne_bytes());
        let bytes: Vec<u8> = values.iter().flat_map(bytes_of).copied().collect();
        self.desk.expect(room.to, &bytes);
    }

    /// A text that names a file, or that is none.
    pub(crate) fn path(&mut self, right: &Path) -> *const c_char {
        let mut text = right.as_os_str().as_encoded_bytes().to_vec();
        if self.spoils() {
            match self.choices.byte() % 4 {
                0 => {
                    self.is_wrong(red_status::NullPointer);
                    return std::ptr::null();
                }
                1 => text.clear(),
                2 => text[0] = 0xff,
                _ => text.resize(4_096 + self.choices.below(8), b'x'),
            }
            self.is_wrong(red_status::Text);
        }
        text.push(0);
        let at = self.desk.input(&text);
        self.desk.pointer(at)
    }

    /// Memory of the arena from `at` on, `bytes` of it, or wrong.
    pub(crate) fn lent(&mut self, at: usize, bytes: usize, least: usize) -> Lent {
        let spoils = self.spoils();
        let kind = if spoils { self.choices.byte() % 6 } else { 0 };
        let mut pointer = self.arena.pointer(at);
        let bytes = match kind {
            1 => {
                self.is_wrong(red_status::NullPointer);
                pointer = std::ptr::null_mut();
                bytes
            }
            2 => {
                self.is_wrong(red_status::Misaligned);
                pointer = self.arena.pointer(at + self.choices.one_of(&[1, 2, 4]));
                bytes
            }
            3 => {
                self.is_wrong(red_status::TooShort);
                self.choices.one_of(&[0, 1, least - 1])
            }
            4 => {
                self.is_wrong(red_status::TooLong);
                usize::MAX - self.choices.below(64)
            }
            _ => bytes,
        };
        Lent { pointer, bytes, range: at..at.saturating_add(bytes) }
    }
}
