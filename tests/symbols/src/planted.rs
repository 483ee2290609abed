//! Bugs that the check must see: it looks at them apart.

extern crate alloc;

crate::entries! { "planted";
    fn panic(row: &[u64; 4], i: usize) -> u64 { row[i] }
    fn allocation(value: u64) -> alloc::boxed::Box<u64> { alloc::boxed::Box::new(value) }
}
