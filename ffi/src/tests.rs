#![allow(unsafe_code, reason = "memory as C has it")]
//! The C ABI as C uses it: by raw pointers, in memory of exactly the size that is named, with nothing in it. The
//! interpreter sees every access that goes beyond; without it, the same tests compare answers.

mod graphs;
mod jobs;
mod memory;
mod schedulers;
mod structs;
mod threads;

use crate::boundary::Plain;
use crate::*;
use core::ffi::c_void;
use core::marker::PhantomData;
use std::alloc::{Layout, alloc, dealloc};

pub(crate) fn ok(status: red_status) {
    assert_eq!(status, red_status::Ok);
}

/// A struct that may grow, with its head.
macro_rules! headed {
    ($name:ident { $($field:ident: $value:expr),* $(,)? }) => {
        $name {
            struct_size: size_of::<$name>() as u32,
            abi_version: $crate::RED_ABI_VERSION,
            $($field: $value,)*
            ..<$name as red_core::Empty>::EMPTY
        }
    };
}
pub(crate) use headed;

/// Room for so many, as `aligned_alloc` gives it: not a byte more, and nothing in it.
pub(crate) struct Block<T = u8> {
    at: *mut u8,
    layout: Layout,
    holds: PhantomData<T>,
}

// SAFETY: a block is its own; who shares one takes turns, as C has to.
unsafe impl<T> Send for Block<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for Block<T> {}

impl Block {
    /// Bytes for something that is lent.
    pub(crate) fn aligned(bytes: usize, align: usize) -> Self {
        Self::new(Layout::from_size_align(bytes, align).expect("a size and an alignment"))
    }
}

impl<T: Copy> Block<T> {
    fn new(layout: Layout) -> Self {
        // SAFETY: no test asks for nothing.
        let at = unsafe { alloc(layout) };
        assert!(!at.is_null());
        Self { at, layout, holds: PhantomData }
    }

    /// An array.
    pub(crate) fn of(len: usize) -> Self {
        Self::new(Layout::array::<T>(len).expect("an array"))
    }

    /// An array with this in it.
    pub(crate) fn holding(values: &[T]) -> Self {
        let block = Self::of(values.len());
        for (i, value) in values.iter().enumerate() {
            // SAFETY: there is room for all of them.
            unsafe { block.pointer().wrapping_add(i).write(*value) };
        }
        block
    }

    pub(crate) const fn pointer(&self) -> *mut T {
        self.at.cast()
    }

    /// Where something is lent from here on.
    pub(crate) const fn lent(&self, from: usize) -> *mut c_void {
        self.at.wrapping_add(from).cast()
    }

    pub(crate) const fn bytes(&self) -> usize {
        self.layout.size()
    }

    /// What was written there.
    pub(crate) fn get(&self, i: usize) -> T {
        assert!(i < self.bytes() / size_of::<T>());
        // SAFETY: it is inside, and no test asks for what nobody wrote.
        unsafe { self.pointer().wrapping_add(i).read() }
    }
}

impl<T> Drop for Block<T> {
    fn drop(&mut self) {
        // SAFETY: it came from there, with this layout.
        unsafe { dealloc(self.at, self.layout) };
    }
}

/// A struct that may grow, of `size` bytes by its own account and in fact: cut short, or with zeros behind.
fn sized<T: Plain>(value: &T, size: usize) -> Block<u64> {
    let mut words = vec![0_u64; size.max(size_of::<T>()).div_ceil(8)];
    let to = words.as_mut_ptr().cast::<T>();
    // SAFETY: there is room for it, and words are aligned for all structs of the header.
    unsafe { to.write(*value) };
    let head = [size as u32, RED_ABI_VERSION];
    // SAFETY: all such structs begin with their head.
    unsafe { to.cast::<[u32; 2]>().write(head) };
    let block = Block::new(Layout::from_size_align(size, 8).expect("a size"));
    // SAFETY: both have as many bytes.
    unsafe { block.at.copy_from_nonoverlapping(words.as_ptr().cast(), size) };
    block
}

/// A graph of the smallest class, in memory of its own.
struct Graph {
    handle: red_dag,
    memory: Block,
}

impl Graph {
    fn new() -> Self {
        Self::within(Block::aligned(RED_DAG_4X16X16_BYTES, RED_ALIGN))
    }

    fn within(memory: Block) -> Self {
        let mut handle = red_dag::default();
        ok(red_dag_open_4x16x16(memory.lent(0), memory.bytes(), &raw mut handle));
        Self { handle, memory }
    }

    /// One that the newest of a task becomes.
    fn edit(scheduler: &Machine, task: u32) -> Self {
        let memory = Block::aligned(RED_DAG_4X16X16_BYTES, RED_ALIGN);
        let mut handle = red_dag::default();
        ok(red_scheduler_edit(scheduler.at(), task, memory.lent(0), memory.bytes(), &raw mut handle));
        Self { handle, memory }
    }

    fn add(&mut self, node: red_node) -> u32 {
        let mut number = RED_NONE;
        ok(red_dag_add_node(&raw mut self.handle, &raw const node, &raw mut number));
        number
    }

    fn edge(&mut self, from: u32, to: u32) {
        ok(red_dag_add_edge(&raw mut self.handle, from, to));
    }

    const fn at(&self) -> *const red_dag {
        &raw const self.handle
    }

    const fn at_mut(&mut self) -> *mut red_dag {
        &raw mut self.handle
    }

    /// Closes it; its memory is ours again.
    fn close(mut self) -> Block {
        ok(red_dag_close(self.at_mut()));
        assert_eq!(self.handle, red_dag::default());
        self.memory
    }
}

/// A node of so many nanoseconds.
fn node(wcet_ns: u64) -> red_node {
    headed!(red_node { wcet_ns: wcet_ns, sensor: RED_NONE })
}

/// A scheduler of the smallest class, in memory of its own.
struct Machine {
    handle: red_scheduler,
    memory: Block,
}

impl Machine {
    fn new(config: red_config) -> Self {
        Self::within(Block::aligned(red_scheduler_bytes_4x16x16(), red_align()), config)
    }

    fn within(memory: Block, config: red_config) -> Self {
        let mut handle = red_scheduler::default();
        let (at, bytes) = (memory.lent(0), memory.bytes());
        ok(red_scheduler_open_4x16x16(at, bytes, &raw const config, &raw mut handle));
        Self { handle, memory }
    }

    fn add(&mut self, graph: &Graph, deadline_ns: u64) -> u32 {
        let timing = headed!(red_timing { deadline_ns: deadline_ns, value: 1 });
        let mut task = RED_NONE;
        ok(red_scheduler_add_task(self.at_mut(), graph.at(), &raw const timing, &raw mut task));
        task
    }

    fn release(&mut self, task: u32, now_ns: u64) -> u32 {
        let mut job = RED_NONE;
        ok(red_scheduler_release(self.at_mut(), task, now_ns, &raw mut job));
        job
    }

    fn poll(&mut self, now_ns: u64) -> red_action {
        let mut action = <red_action as red_core::Empty>::EMPTY;
        ok(red_scheduler_poll(self.at_mut(), now_ns, &raw mut action));
        action
    }

    const fn at(&self) -> *const red_scheduler {
        &raw const self.handle
    }

    const fn at_mut(&mut self) -> *mut red_scheduler {
        &raw mut self.handle
    }

    /// Closes it; its memory is ours again.
    fn close(mut self) -> Block {
        ok(red_scheduler_close(self.at_mut()));
        assert_eq!(self.handle, red_scheduler::default());
        self.memory
    }
}

/// A named configuration of so many lanes.
fn config(preset: red_preset, lanes: u32) -> red_config {
    let mut config = headed!(red_config {});
    ok(red_config_preset(preset as u32, &raw mut config));
    red_config { lanes, ..config }
}
