#![allow(unsafe_code, reason = "names of C")]
//! Graphs: what they say.

use crate::boundary::{Array, Growing, OutGrowing, Room, plain, take};
use crate::config;
use crate::dag::node_id;
use crate::graph::{AnyGraph, MOST_NODES, MOST_POOLS, Placed, Share};
use crate::handles;
use crate::node::red_node;
use crate::proof::red_certificate;
use crate::status::{flat, red_status};
use crate::values::red_dag;
use red_core::{DeadlineRule, Duration, Empty};

/// What a graph says as a whole.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_dag_summary {
    /// RED_DAG_SUMMARY_INIT sets it.
    pub struct_size: u32,
    /// RED_DAG_SUMMARY_INIT sets it.
    pub abi_version: u32,
    /// Nodes.
    pub nodes: u32,
    /// Levels: the greatest height plus one.
    pub levels: u32,
    /// W: sum of all costs.
    pub work_ns: u64,
    /// L: cost of the critical path.
    pub critical_path_ns: u64,
}
plain!(red_dag_summary {
    struct_size: u32,
    abi_version: u32,
    nodes: u32,
    levels: u32,
    work_ns: u64,
    critical_path_ns: u64,
});
impl Growing for red_dag_summary {
    const LEAST: usize = 32;
}

/// Where a node stands in its graph, and when it is due. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_placed_node {
    /// Which node.
    pub node: u32,
    /// Its height: the longest chain of edges to it.
    pub height: u32,
    /// Longest path cost after it, excluding it.
    pub tail_ns: u64,
    /// When it should end, after the release; below 0 where the deadline is below the critical path.
    pub sub_deadline_ns: i64,
    /// What dispatch orders by: the sub-deadline, under RED_RULE_LATEST_START less the node's cost.
    pub key_ns: i64,
}
plain!(red_placed_node { node: u32, height: u32, tail_ns: u64, sub_deadline_ns: i64, key_ns: i64 });

/// What a level asks for and gets of a deadline. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_level {
    /// The cost of its nodes.
    pub cost_ns: u64,
    /// Graham's bound of it alone.
    pub graham_ns: u64,
    /// Length of its share.
    pub share_ns: u64,
    /// When its share ends, after the release; of the last level, the deadline exactly.
    pub end_ns: u64,
}
plain!(red_level { cost_ns: u64, graham_ns: u64, share_ns: u64, end_ns: u64 });

/// Makes a call on a graph that only looks.
fn look(dag: *const red_dag, call: impl FnOnce(&AnyGraph) -> Result<red_status, red_status>) -> red_status {
    flat(take(dag).and_then(|dag| call(handles::graph(dag.bits)?.look()?)))
}

/// Lanes by pool, as C gives them.
fn lanes_of(lanes: *const u32, pools: usize) -> Result<([u8; MOST_POOLS], usize), red_status> {
    let mut by_pool = [1; MOST_POOLS];
    let given = Array::of(lanes, pools, MOST_POOLS)?;
    for (pool, lanes) in by_pool.iter_mut().zip(given.iter()) {
        *pool = match u8::try_from(lanes) {
            Ok(0) => return Err(red_status::NoLane),
            Ok(lanes) => lanes,
            Err(_) => return Err(red_status::OutOfRange),
        };
    }
    Ok((by_pool, pools))
}

/// Nodes, levels, work and critical path of a graph.
///
/// Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes + edges). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_summarize(dag: *const red_dag, summary: *mut red_dag_summary) -> red_status {
    look(dag, |graph| {
        let out = OutGrowing::of(summary)?;
        let said = graph.summary();
        out.put(red_dag_summary {
            nodes: said.nodes as u32,
            levels: said.levels as u32,
            work_ns: said.work_ns,
            critical_path_ns: said.critical_path_ns,
            ..red_dag_summary::EMPTY
        });
        Ok(red_status::Ok)
    })
}

/// The data of a node.
///
/// Threads: any, while nobody changes the graph. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_NODE.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_node(dag: *const red_dag, node: u32, data: *mut red_node) -> red_status {
    look(dag, |graph| {
        let out = OutGrowing::of(data)?;
        out.put(red_node::of(graph.node(node_id(node)?).ok_or(red_status::UnknownNode)?));
        Ok(red_status::Ok)
    })
}

/// The direct successors of a node, smallest first: up to `room` into `nodes`, and how many there are into `count`. If they
/// are more than `room`, only `count` is written.
///
/// Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_NODE,
/// RED_STATUS_TOO_SHORT.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_successors(
    dag: *const red_dag,
    node: u32,
    nodes: *mut u32,
    room: usize,
    count: *mut usize,
) -> red_status {
    look(dag, |graph| {
        let out = Room::of(nodes, room, count)?;
        let node = node_id(node)?;
        let _there = graph.node(node).ok_or(red_status::UnknownNode)?;
        let (mut found, mut len) = ([0; MOST_NODES], 0);
        graph.successors(node, &mut |successor| {
            if let Some(free) = found.get_mut(len) {
                *free = successor.index() as u32;
                len += 1;
            }
        });
        Ok(out.fill(found.into_iter().take(len)))
    })
}

/// All nodes, smallest first, with their heights, tails, and sub-deadlines by `rule` (one of red_rule) for a deadline: up to
/// `room` into `nodes`, and how many there are into `count`. If they are more than `room`, only `count` is written.
/// `lanes` has the lanes of the first `pools` pools; others have one.
///
/// Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes * pools + edges).
/// Errors: RED_STATUS_OUT_OF_RANGE: the rule, or more than 255 lanes. RED_STATUS_DEADLINE: above 2^62 ns.
/// RED_STATUS_NO_LANE, RED_STATUS_TOO_SHORT.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_place(
    dag: *const red_dag,
    rule: u32,
    deadline_ns: u64,
    lanes: *const u32,
    pools: usize,
    nodes: *mut red_placed_node,
    room: usize,
    count: *mut usize,
) -> red_status {
    look(dag, |graph| {
        let out = Room::of(nodes, room, count)?;
        let (rule, deadline, (lanes, pools)) =
            (config::rule(rule)?, deadline(deadline_ns)?, lanes_of(lanes, pools)?);
        let mut filling = out.begin(graph.summary().nodes)?;
        graph.place(rule, deadline, lanes.get(..pools).unwrap_or_default(), &mut |placed| {
            let Placed { node, height, tail_ns, sub_deadline_ns, key_ns } = placed;
            let (node, height) = (node.index() as u32, height as u32);
            filling.put(red_placed_node { node, height, tail_ns, sub_deadline_ns, key_ns });
        });
        Ok(red_status::Ok)
    })
}

/// How a level rule divides a deadline among the levels of a graph: up to `room` into `levels`, and how many there are into
/// `count`. If they are more than `room`, only `count` is written. `rule` is RED_RULE_LEVEL_SUM or
/// RED_RULE_LEVEL_GRAHAM, `lanes` has the lanes of the first `pools` pools; others have one.
///
/// Threads: any, while nobody changes the graph. Real time: yes. Time: O(nodes * pools + edges).
/// Errors: as red_dag_place.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_share(
    dag: *const red_dag,
    rule: u32,
    deadline_ns: u64,
    lanes: *const u32,
    pools: usize,
    levels: *mut red_level,
    room: usize,
    count: *mut usize,
) -> red_status {
    look(dag, |graph| {
        let out = Room::of(levels, room, count)?;
        let (rule, deadline, (lanes, pools)) =
            (config::rule(rule)?, deadline(deadline_ns)?, lanes_of(lanes, pools)?);
        if !matches!(rule, DeadlineRule::LevelSum | DeadlineRule::LevelGraham) {
            return Err(red_status::OutOfRange);
        }
        let mut filling = out.begin(graph.summary().levels)?;
        graph.share(rule, deadline, lanes.get(..pools).unwrap_or_default(), &mut |level| {
            let Share { cost_ns, graham_ns, share_ns, end_ns } = level;
            filling.put(red_level { cost_ns, graham_ns, share_ns, end_ns });
        });
        Ok(red_status::Ok)
    })
}

/// Bounds the response time of a job of this graph that has its pools to itself. `lanes` and `memory_bytes` (RED_NONE_64:
/// unlimited) are of the first `pools` pools; others have one lane and unlimited memory.
///
/// Threads: any, while nobody changes the graph. Real time: no. Time: O(lanes * (nodes + edges)). Errors:
/// RED_STATUS_NO_LANE, RED_STATUS_OUT_OF_RANGE: more than 255 lanes.
#[unsafe(no_mangle)]
pub extern "C" fn red_dag_prove(
    dag: *const red_dag,
    limit_ns: u64,
    lanes: *const u32,
    memory_bytes: *const u64,
    pools: usize,
    certificate: *mut red_certificate,
) -> red_status {
    look(dag, |graph| {
        let out = OutGrowing::of(certificate)?;
        let (lanes, pools) = lanes_of(lanes, pools)?;
        let mut budgets = [None; MOST_POOLS];
        let given = Array::of(memory_bytes, pools, MOST_POOLS)?;
        budgets.iter_mut().zip(given.iter()).for_each(|(budget, bytes)| *budget = config::bytes(bytes));
        let limit = Duration::from_nanos(limit_ns);
        out.put(graph.prove(limit, lanes.get(..pools).unwrap_or_default(), &budgets).into());
        Ok(red_status::Ok)
    })
}

/// A deadline that a rule can divide.
fn deadline(ns: u64) -> Result<Duration, red_status> {
    if ns <= 1 << 62 { Ok(Duration::from_nanos(ns)) } else { Err(red_status::Deadline) }
}
