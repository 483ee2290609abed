//! Structs that grow, arrays of them, and arguments that lie within each other.

use super::{Block, Graph, Machine, config, node, ok, sized};
use crate::boundary::{Growing, OutGrowing, plain, take_growing};
use crate::*;
use core::mem::offset_of;
use core::ptr;
use red_core::Empty;

const NODE: usize = size_of::<red_node>();

/// A struct of which there was a shorter version.
#[repr(C)]
#[derive(Clone, Copy)]
struct Grown {
    struct_size: u32,
    abi_version: u32,
    first: u64,
    second: u64,
    third: u64,
}
plain!(Grown { struct_size: u32, abi_version: u32, first: u64, second: u64, third: u64 });
impl Growing for Grown {
    const LEAST: usize = 16;
}
const GROWN: Grown = Grown { struct_size: 0, abi_version: 0, first: 1, second: 2 << 32, third: 3 };

fn add(graph: &mut Graph, node: *const red_node) -> red_status {
    let mut number = RED_NONE;
    let status = red_dag_add_node(graph.at_mut(), node, &raw mut number);
    assert_eq!(status == red_status::Ok, number != RED_NONE);
    status
}

/// Writes a word of what was given.
fn written(block: &Block<u64>, word: usize, value: u64) {
    assert!(word < block.bytes() / size_of::<u64>());
    // SAFETY: it lies in the block, as just seen.
    unsafe { block.pointer().wrapping_add(word).write(value) };
}

#[test]
fn what_an_older_program_gives_is_read_up_to_its_size() {
    for (size, second, third) in
        [(16, 0, 0), (20, 0, 0), (24, 2 << 32, 0), (32, 2 << 32, 3), (40, 2 << 32, 3)]
    {
        let given = sized(&GROWN, size);
        let read = take_growing::<Grown>(given.pointer().cast()).expect("a version");
        assert_eq!((read.first, read.second, read.third), (1, second, third));
    }
}

#[test]
fn what_an_older_program_wants_is_written_up_to_its_size() {
    for size in [16, 20, 24, 32, 48] {
        let wanted = sized(&Grown { first: 9, second: 9, third: 9, ..GROWN }, size);
        (4..size / 8).for_each(|i| written(&wanted, i, 9));
        OutGrowing::of(wanted.pointer().cast::<Grown>()).expect("a version").put(GROWN);
        let words: Vec<u64> = (0..size / 8).map(|i| wanted.get(i)).collect();
        assert_eq!(words[0] as u32 as usize, size, "its head stays");
        assert_eq!(words[1..], [1, 2 << 32, 3, 0, 0][..size / 8 - 1]);
    }
}

#[test]
fn what_a_newer_program_gives_has_zeros_behind_what_is_known() {
    let mut graph = Graph::new();
    for more in [0, 4, 8, 64, 4096 - NODE] {
        ok(add(&mut graph, sized(&node(7), NODE + more).pointer().cast()));
    }
    let unknown = sized(&node(7), NODE + 8);
    written(&unknown, NODE / 8, 1 << 63);
    assert_eq!(add(&mut graph, unknown.pointer().cast()), red_status::UnknownField);
    let told = sized(&red_node { bcet_ns: 7, ..node(7) }, NODE + 16);
    [NODE / 8, NODE / 8 + 1].into_iter().for_each(|i| written(&told, i, u64::MAX));
    ok(red_dag_node(graph.at(), 0, told.pointer().cast()));
    let back: Vec<u64> = (1..NODE / 8 + 2).map(|i| told.get(i)).collect();
    assert_eq!((back[0], back[1]), (7, 0));
    assert_eq!(back[NODE / 8 - 1..], [0, 0]);
    graph.close();
}

#[test]
fn of_a_struct_of_no_version_the_head_alone_is_read() {
    let mut graph = Graph::new();
    let mut refused = |head: &[u32; 2]| {
        let told = Block::<u64>::holding(&[u64::from(head[1]) << 32 | u64::from(head[0])]);
        let at = told.pointer();
        (add(&mut graph, at.cast()), red_dag_node(graph.at(), 0, at.cast()))
    };
    let wrong = [0, 8, 60, 66, 4100, 1 << 31, u32::MAX].map(|size| [size, RED_ABI_VERSION]);
    let sizes: Vec<_> = wrong.iter().map(&mut refused).collect();
    assert!(sizes.iter().all(|said| *said == (red_status::StructSize, red_status::StructSize)));
    let node = red_node { abi_version: RED_ABI_VERSION + 1, ..node(1) };
    assert_eq!(add(&mut graph, &raw const node), red_status::Version);
    let odd = Block::<u64>::of(NODE / 8 + 1).lent(4);
    assert_eq!(add(&mut graph, odd.cast()), red_status::Misaligned);
    assert_eq!(add(&mut graph, ptr::null()), red_status::NullPointer);
    graph.close();
}

/// Nodes so many bytes apart; the last one says that it is of another size.
fn nodes(count: usize, size: usize, last: usize) -> Block<u64> {
    let words = size.div_ceil(8);
    let mut all = vec![0; words * (count - 1) + NODE / 8];
    for (i, place) in all.chunks_mut(words).enumerate() {
        let one = sized(&node(1), size);
        (0..place.len()).for_each(|at| place[at] = one.get(at));
        let said = if i + 1 == count { last } else { size };
        place[0] = u64::from(RED_ABI_VERSION) << 32 | said as u64;
    }
    let block = Block::holding(&all);
    assert_eq!(block.bytes(), words * 8 * (count - 1) + NODE, "no more than it is");
    block
}

#[test]
fn structs_in_an_array_lie_as_far_apart_as_the_first_says() {
    let mut graph = Graph::new();
    graph.add(node(1));
    let encoder = red_node { role: red_role::SharedEncoder as u32, ..node(1) };
    let mut refine = |decoders: *const u64, count| {
        let mut number = RED_NONE;
        let at = graph.at_mut();
        red_dag_refine(at, 0, &raw const encoder, decoders.cast(), count, &raw mut number)
    };
    assert_eq!(refine(ptr::null(), 1), red_status::NullPointer);
    assert_eq!(refine(ptr::null(), 0), red_status::NoDecoder);
    assert_eq!(refine(ptr::null(), 257), red_status::TooLong);
    assert_eq!(refine(nodes(2, NODE, NODE + 8).pointer(), 2), red_status::StructSize, "beyond the end");
    assert_eq!(refine(nodes(2, NODE + 16, NODE).pointer(), 2), red_status::StructSize);
    assert_eq!(
        refine(sized(&node(1), NODE + 4).pointer(), 1),
        red_status::StructSize,
        "the next is not aligned"
    );
    ok(refine(sized(&node(1), NODE + 24).pointer(), 1));
    ok(refine(nodes(3, NODE, NODE).pointer(), 3));
    let mut summary = super::headed!(red_dag_summary {});
    ok(red_dag_summarize(graph.at(), &raw mut summary));
    assert_eq!(summary.nodes, 5);
    graph.close();
}

#[test]
fn an_output_may_lie_in_an_input() {
    let mut graph = Graph::new();
    graph.add(node(1));
    let mut both = red_node { pool: 0, ..node(2) };
    let at = &raw mut both;
    let number = at.wrapping_byte_add(offset_of!(red_node, pool)).cast();
    ok(red_dag_add_node(graph.at_mut(), at, number));
    assert_eq!(both.pool, 1);
    // What is asked for, and how many there are, in the same words.
    graph.edge(0, 1);
    let words = Block::<usize>::holding(&[7, 7]);
    let (first, second) = (words.pointer(), words.pointer().wrapping_add(1));
    ok(red_dag_successors(graph.at(), 0, second.cast(), 1, first));
    assert_eq!((words.get(0), words.get(1) as u32), (1, 1));
    ok(red_dag_place(
        graph.at(),
        0,
        10,
        first.cast(),
        1,
        Block::<red_placed_node>::of(2).pointer(),
        2,
        first,
    ));
    assert_eq!(words.get(0), 2);
    graph.close();
}

#[test]
fn a_configuration_may_lie_where_its_scheduler_is_made() {
    let memory = Block::aligned(red_scheduler_bytes_4x16x16(), RED_ALIGN);
    let (at, mut scheduler) = (memory.lent(0).cast::<red_config>(), red_scheduler::default());
    // SAFETY: there is room for it, and more.
    unsafe { at.write(config(red_preset::Red, 3)) };
    ok(red_scheduler_open_4x16x16(at.cast(), memory.bytes(), at, &raw mut scheduler));
    let machine = Machine { handle: scheduler, memory };
    let mut told = super::headed!(red_config {});
    ok(red_scheduler_config(machine.at(), &raw mut told));
    assert_eq!((told.lanes, told.rule), (3, red_rule::LevelSum as u32));
    machine.close();
}

#[test]
fn an_array_of_nothing_is_nowhere() {
    let (mut count, graph) = (7, Graph::new());
    ok(red_dag_place(graph.at(), 0, 10, ptr::null(), 0, ptr::null_mut(), 0, &raw mut count));
    assert_eq!(count, 0);
    let too_long =
        red_dag_place(graph.at(), 0, 10, ptr::null(), 0, ptr::dangling_mut(), usize::MAX, &raw mut count);
    assert_eq!(too_long, red_status::TooLong);
    let mut event = red_event::EMPTY;
    let mut machine = Machine::new(config(red_preset::Redrt, 1));
    let none = red_scheduler_take_events(machine.at_mut(), ptr::null_mut(), 1, &raw mut count);
    assert_eq!(none, red_status::NullPointer);
    ok(red_scheduler_take_events(machine.at_mut(), &raw mut event, 1, &raw mut count));
    graph.close();
    machine.close();
}
