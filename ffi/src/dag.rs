#![allow(unsafe_code, reason = "names of C")]
//! Graphs: made, and changed.

use crate::boundary::{GrowingArray, Memory, Out, Place, take, take_growing};
use crate::capacity::{Large, Medium, Small};
use crate::graph::{AnyGraph, Held, MOST_NODES};
use crate::guard::Guarded;
use crate::handles::{self, Object};
use crate::node::red_node;
use crate::status::{flat, red_status, status};
use crate::values::red_dag;
use core::ffi::c_void;
use red_core::{Capacity, Dag, NodeId};

/// A node of this number; none has another.
pub(crate) fn node_id(number: u32) -> Result<NodeId, red_status> {
    u8::try_from(number).map(NodeId::new).map_err(|_| red_status::UnknownNode)
}

/// A graph in memory of C's.
pub(crate) type Lent<C> = Guarded<Held<C>>;

/// Makes a graph in memory of C's, opens it and answers its handle: an edit that was begun on `begun_on`, or none.
pub(crate) fn open_dag<C: Capacity>(
    place: &Place<Lent<C>>,
    dag: Dag<C>,
    begun_on: u64,
    out: Out<red_dag>,
) -> Result<(), red_status> {
    place.apart_from(&out)?;
    let make = || {
        place.make(Guarded::new(Held { dag, begun_on }));
        Object::Dag(place.pointer())
    };
    out.put(red_dag { bits: handles::open(&place.range(), make)? });
    Ok(())
}

fn open<C: Capacity>(memory: *mut c_void, bytes: usize, dag: *mut red_dag) -> red_status {
    flat(Out::of(dag).and_then(|out| {
        open_dag(&Memory::of(memory, bytes).room_for::<Lent<C>>()?, Dag::new(), 0, out)?;
        Ok(red_status::Ok)
    }))
}

/// Makes a call on a graph that changes it.
fn change(
    dag: *const red_dag,
    call: impl FnOnce(&mut AnyGraph) -> Result<red_status, red_status>,
) -> red_status {
    flat(take(dag).and_then(|dag| call(&mut *handles::graph(dag.bits)?.enter()?)))
}

/// Opens a graph without nodes, for schedulers of 4 tasks of 16 nodes and 16 jobs. `memory`, of
/// RED_DAG_4X16X16_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
///
/// Threads: any, at once. Real time: yes. Time: O(nodes). Errors: RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED,
/// RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_open_4x16x16(memory: *mut c_void, bytes: usize, dag: *mut red_dag) -> red_status {
    open::<Small>(memory, bytes, dag)
}

/// Opens a graph without nodes, for schedulers of 8 tasks of 64 nodes and 32 jobs. `memory`, of
/// RED_DAG_8X64X32_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
///
/// Threads: any, at once. Real time: yes. Time: O(nodes). Errors: as red_dag_open_4x16x16.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_open_8x64x32(memory: *mut c_void, bytes: usize, dag: *mut red_dag) -> red_status {
    open::<Medium>(memory, bytes, dag)
}

/// Opens a graph without nodes, for schedulers of 16 tasks of 256 nodes and 64 jobs, and for the runtime. `memory`, of
/// RED_DAG_16X256X64_BYTES and aligned to RED_ALIGN, is the library's until red_dag_close.
///
/// Threads: any, at once. Real time: yes. Time: O(nodes). Errors: as red_dag_open_4x16x16.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_open_16x256x64(memory: *mut c_void, bytes: usize, dag: *mut red_dag) -> red_status {
    open::<Large>(memory, bytes, dag)
}

/// Closes a graph; its memory is the caller's again. Nothing that was made of it is touched.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(1). Errors: RED_STATUS_CLOSED.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_close(dag: *mut red_dag) -> red_status {
    flat(Out::of(dag).and_then(|out| {
        let bits = take(dag)?.bits;
        let _alone = handles::graph(bits)?.enter()?;
        handles::close(bits)?;
        out.put(red_dag::default());
        Ok(red_status::Ok)
    }))
}

/// Adds a node; nodes are numbered from 0.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_NODES_FULL,
/// RED_STATUS_WORK_OVERFLOW, RED_STATUS_OUT_OF_RANGE: role, atomic, weights or frame, or contention without atomic,
/// RED_STATUS_UNKNOWN_POOL: the class has none of this number, RED_STATUS_UNKNOWN_SENSOR: an encoder's, above 255; whether the
/// scheduler has them is for it to say.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_add_node(dag: *mut red_dag, node: *const red_node, number: *mut u32) -> red_status {
    change(dag, |graph| {
        let number = Out::of(number)?;
        let node = take_growing(node)?.read()?;
        Ok(status(graph.add_node(node), |id| number.put(id.index() as u32)))
    })
}

/// Adds an edge: `to` starts after `from` has completed.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_CYCLE,
/// RED_STATUS_DUPLICATE_EDGE, RED_STATUS_SECOND_ENCODER, RED_STATUS_UNKNOWN_NODE.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_add_edge(dag: *mut red_dag, from: u32, to: u32) -> red_status {
    change(dag, |graph| Ok(status(graph.add_edge(node_id(from)?, node_id(to)?), drop)))
}

/// Removes a node and its edges. Other nodes keep their numbers. In an edit its number is given again after the commit only,
/// as jobs in flight may have it.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_NODE.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_remove_node(dag: *mut red_dag, node: u32) -> red_status {
    change(dag, |graph| {
        let removed = graph.remove_node(node_id(node)?);
        Ok(if removed { red_status::Ok } else { red_status::UnknownNode })
    })
}

/// Removes an edge.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_EDGE,
/// RED_STATUS_UNKNOWN_NODE.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_remove_edge(dag: *mut red_dag, from: u32, to: u32) -> red_status {
    change(dag, |graph| {
        let removed = graph.remove_edge(node_id(from)?, node_id(to)?);
        Ok(if removed { red_status::Ok } else { red_status::UnknownEdge })
    })
}

/// Replaces a node by a shared encoder and its decoders (paper Def. 6, Alg. 1). Edges into it lead to the encoder, edges
/// out of it leave every decoder. Later nodes move up: decoder j is node `encoder_number` + 1 + j. So a graph that
/// an edit gave is no edit any more: its commit is refused.
///
/// Threads: one at a time on a graph. Real time: yes. Time: O(nodes + edges * decoders). Errors: RED_STATUS_UNKNOWN_NODE,
/// RED_STATUS_NO_DECODER, RED_STATUS_NODES_FULL, RED_STATUS_WORK_OVERFLOW, and those of the nodes.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_refine(
    dag: *mut red_dag,
    stage: u32,
    encoder: *const red_node,
    decoders: *const red_node,
    decoder_count: usize,
    encoder_number: *mut u32,
) -> red_status {
    change(dag, |graph| {
        let number = Out::of(encoder_number)?;
        let encoder = take_growing(encoder)?.read()?;
        let decoders = GrowingArray::of(decoders, decoder_count, MOST_NODES)?;
        let mut each = (0..decoder_count).map(|i| decoders.get(i)?.read());
        number.put(graph.refine(node_id(stage)?, encoder, &mut each)?.index() as u32);
        Ok(red_status::Ok)
    })
}
