//! Whether a file is a whole shared object of this machine.
//!
//! The dynamic linker maps a file into memory without asking whether the file is as long as its own tables say; where
//! it is not, the process dies of SIGBUS. So the tables are read before.

use std::io::{Read, Seek, SeekFrom};

/// Sizes of the header and of an entry in the table of segments, of 64-bit objects.
const HEADER: usize = 64;
const ENTRY: usize = 56;
/// Segments of an object at most; linkers make about ten.
const MAX_SEGMENTS: u16 = 128;

/// Values of the fields, by the ELF specification.
const CLASS_64: u8 = 2;
const BYTE_ORDER: u8 = if cfg!(target_endian = "little") { 1 } else { 2 };
const SHARED_OBJECT: u16 = 3;
const LOADED: u32 = 1;
const DYNAMIC: u32 = 2;
const MACHINE: Option<u16> = if cfg!(target_arch = "x86_64") {
    Some(62)
} else if cfg!(target_arch = "aarch64") {
    Some(183)
} else if cfg!(target_arch = "riscv64") {
    Some(243)
} else {
    None
};

const CUT: &str = "it is cut short";
const DAMAGED: &str = "its table of segments is damaged";

/// Checks that a file of `size` bytes is a 64-bit shared object of this machine whose segments all lie in the file.
pub(super) fn check(file: &mut (impl Read + Seek), size: u64) -> Result<(), &'static str> {
    let header: [u8; HEADER] = read(file, 0)?;
    if !header.starts_with(b"\x7fELF") {
        return Err("it is no ELF file");
    }
    if header[4] != CLASS_64 || header[5] != BYTE_ORDER {
        return Err("it is not of 64 bits and this byte order");
    }
    if half(&header, 16) != SHARED_OBJECT {
        return Err("it is no shared object");
    }
    if MACHINE.is_some_and(|machine| half(&header, 18) != machine) {
        return Err("it is for another kind of processor");
    }
    let (table, count) = (long(&header, 32), half(&header, 56));
    if usize::from(half(&header, 54)) != ENTRY || count > MAX_SEGMENTS {
        return Err(DAMAGED);
    }
    let (mut mapped, mut dynamic) = (Vec::new(), None);
    for index in 0..u64::from(count) {
        let entry: [u8; ENTRY] = read(file, table.checked_add(index * ENTRY as u64).ok_or(CUT)?)?;
        let [offset, address, in_file, in_memory] = [8, 16, 32, 40].map(|field| long(&entry, field));
        let end = address.checked_add(in_memory).ok_or(DAMAGED)?;
        match word(&entry, 0) {
            LOADED if offset.checked_add(in_file).is_none_or(|end| end > size) => return Err(CUT),
            LOADED if in_file > in_memory => return Err(DAMAGED),
            LOADED => mapped.push(address..end),
            DYNAMIC => dynamic = Some(address..end),
            _ => {}
        }
    }
    // The linker follows it without a look at where it leads.
    let dynamic = dynamic.ok_or("it has nothing to link")?;
    let is_mapped = mapped.iter().any(|range| range.start <= dynamic.start && dynamic.end <= range.end);
    if is_mapped { Ok(()) } else { Err(DAMAGED) }
}

fn read<const N: usize>(file: &mut (impl Read + Seek), at: u64) -> Result<[u8; N], &'static str> {
    let mut bytes = [0; N];
    file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut bytes)).map_err(|_| CUT)?;
    Ok(bytes)
}

fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|index| bytes[at + index])
}

fn half(bytes: &[u8], at: usize) -> u16 {
    u16::from_ne_bytes(field(bytes, at))
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_ne_bytes(field(bytes, at))
}

fn long(bytes: &[u8], at: usize) -> u64 {
    u64::from_ne_bytes(field(bytes, at))
}

#[cfg(test)]
mod tests;
