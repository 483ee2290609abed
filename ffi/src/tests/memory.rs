//! Memory that is lent, and handles of what is in it.

use super::{Block, Graph, Machine, config, node, ok};
use crate::capacity::Small;
use crate::dag::Lent;
use crate::*;
use core::ffi::c_void;
use core::ptr;

const BYTES: usize = RED_DAG_4X16X16_BYTES;

fn open(at: *mut c_void, bytes: usize) -> (red_status, red_dag) {
    let mut dag = red_dag::default();
    (red_dag_open_4x16x16(at, bytes, &raw mut dag), dag)
}

fn nodes(mut dag: red_dag) -> red_status {
    let mut summary = super::headed!(red_dag_summary {});
    red_dag_summarize(&raw mut dag, &raw mut summary)
}

#[test]
fn the_named_size_and_alignment_are_enough_and_so_is_what_is_needed_here() {
    for (bytes, align) in
        [(RED_SCHEDULER_4X16X16_BYTES, RED_ALIGN), (red_scheduler_bytes_4x16x16(), red_align())]
    {
        let mut machine = Machine::within(Block::aligned(bytes, align), config(red_preset::Redrt, 4));
        assert_eq!(machine.poll(0).kind, red_action_kind::Nothing as u32);
        machine.close();
    }
    for (bytes, align) in [(BYTES, RED_ALIGN), (size_of::<Lent<Small>>(), align_of::<Lent<Small>>())] {
        let mut graph = Graph::within(Block::aligned(bytes, align));
        assert_eq!((0..16).map(|i| graph.add(node(i))).last(), Some(15), "its last byte is used");
        graph.close();
    }
}

#[test]
fn memory_that_does_not_hold_it_is_not_touched() {
    // Far too short: what is read or written there is seen.
    let memory = Block::aligned(RED_ALIGN, RED_ALIGN);
    let least = size_of::<Lent<Small>>();
    assert_eq!(open(ptr::null_mut(), BYTES).0, red_status::NullPointer);
    assert_eq!(open(memory.lent(1), BYTES).0, red_status::Misaligned);
    assert_eq!(open(memory.lent(0), least - 1).0, red_status::TooShort);
    assert_eq!(open(memory.lent(0), 0).0, red_status::TooShort);
    assert_eq!(open(memory.lent(0), usize::MAX).0, red_status::TooLong);
    assert_eq!(red_dag_open_4x16x16(memory.lent(0), BYTES, ptr::null_mut()), red_status::NullPointer);
    let (wanted, mut scheduler) = (config(red_preset::Edf, 1), red_scheduler::default());
    let mut machine =
        |at, bytes| red_scheduler_open_4x16x16(at, bytes, &raw const wanted, &raw mut scheduler);
    assert_eq!(machine(ptr::null_mut(), RED_SCHEDULER_4X16X16_BYTES), red_status::NullPointer);
    assert_eq!(machine(memory.lent(4), RED_SCHEDULER_4X16X16_BYTES), red_status::Misaligned);
    assert_eq!(machine(memory.lent(0), red_scheduler_bytes_4x16x16() - 1), red_status::TooShort);
    assert_eq!(scheduler, red_scheduler::default());
}

#[test]
fn memory_of_something_open_is_not_lent_again() {
    let memory = Block::aligned(3 * BYTES, RED_ALIGN);
    let (opened, middle) = open(memory.lent(BYTES), BYTES);
    ok(opened);
    for from in [RED_ALIGN, BYTES, 2 * BYTES - RED_ALIGN] {
        assert_eq!(open(memory.lent(from), BYTES).0, red_status::Overlap);
    }
    let mut sides = [open(memory.lent(0), BYTES), open(memory.lent(2 * BYTES), BYTES)];
    for (opened, side) in &mut sides {
        ok(*opened);
        ok(red_dag_close(side));
    }
    ok(nodes(middle));
    let mut closed = middle;
    ok(red_dag_close(&raw mut closed));
}

#[test]
fn an_edit_does_not_go_into_its_schedulers_memory() {
    let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 1)), Graph::new());
    graph.add(node(1));
    let (task, mut edit) = (machine.add(&graph, 10), red_dag::default());
    let at = machine.memory.lent(0);
    assert_eq!(red_scheduler_edit(machine.at(), task, at, BYTES, &raw mut edit), red_status::Overlap);
    assert_eq!(edit, red_dag::default());
    machine.release(task, 0);
    graph.close();
    machine.close();
}

#[test]
fn closed_memory_takes_something_else_and_old_handles_find_neither() {
    let memory = Block::aligned(RED_SCHEDULER_4X16X16_BYTES, RED_ALIGN);
    let mut graph = Graph::within(memory);
    let first = graph.handle;
    graph.add(node(1));
    let mut machine = Machine::within(graph.close(), config(red_preset::Redrt, 2));
    let second = machine.handle;
    assert_eq!(nodes(first), red_status::Closed);
    assert_eq!(nodes(red_dag { bits: second.bits }), red_status::OtherKind);
    machine.poll(0);
    let graph = Graph::within(machine.close());
    let mut at = 0;
    assert_eq!(red_scheduler_poll_at(&raw const second, &raw mut at), red_status::Closed);
    let other = red_scheduler { bits: graph.handle.bits };
    assert_eq!(red_scheduler_poll_at(&raw const other, &raw mut at), red_status::OtherKind);
    ok(nodes(graph.handle));
    let mut copy = graph.handle;
    drop(graph.close());
    // The memory is gone, and none of these calls looks for it.
    assert_eq!(red_dag_close(&raw mut copy), red_status::Closed);
    assert_eq!(nodes(copy), red_status::Closed);
    assert_eq!(nodes(red_dag::default()), red_status::Closed);
    assert_eq!(nodes(red_dag { bits: copy.bits ^ 1 << 20 }), red_status::Foreign);
    assert_eq!(nodes(red_dag { bits: 255 }), red_status::Foreign);
}

#[test]
fn handles_and_memory_go_through_many_hands_between_calls() {
    let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 1)), Graph::new());
    for i in 0..4 {
        graph.add(node(1));
        // The handle lies elsewhere, and so does what says where the memory is; the memory itself stays.
        let Graph { handle, memory } = graph;
        graph = Graph { handle: *Box::new(handle), memory: *Box::new(memory) };
        ok(nodes(graph.handle));
        let task = machine.add(&graph, 100);
        machine.release(task, i);
        look_through(&graph.memory);
        look_through(&machine.memory);
        machine = *Box::new(machine);
        machine.poll(i);
    }
    // An address that C had as a number.
    let memory = Block::aligned(BYTES, RED_ALIGN);
    let at = memory.lent(0).map_addr(|address| address ^ 1);
    let (opened, mut dag) = open(at.map_addr(|address| address ^ 1), BYTES);
    ok(opened);
    ok(red_dag_close(&raw mut dag));
    graph.close();
    machine.close();
}

/// Copies all of it, as a debugger does, or what writes a core.
fn look_through(memory: &Block) {
    let mut copy = Box::<[u8]>::new_uninit_slice(memory.bytes());
    // SAFETY: both have as many bytes, of which nobody asks what they are.
    unsafe { copy.as_mut_ptr().copy_from_nonoverlapping(memory.pointer().cast(), memory.bytes()) };
}
