//! The functions of graphs.

use std::ops::Range;

use red_core::{Bytes, DeadlineRule, Duration, Empty, Node, NodeId};
use red_ffi::*;

use crate::arguments::Lent;
use crate::sizes::{More, Sizes};
use crate::twin::{self, AnyDag, Large, Medium, Small};
use crate::values;
use crate::world::{Kind, Open, Thing, World};

/// Nodes of a graph at most, and pools.
const NODES: usize = 256;
const POOLS: usize = 32;

/// Where memory for a kind of thing of a class lies in the arena: from where, how large, how many.
pub(crate) const fn sites(kind: Kind, class: usize, crowd: bool) -> (usize, usize, usize) {
    const SMALL: usize = 3 * RED_SCHEDULER_4X16X16_BYTES;
    match (kind, class) {
        (Kind::Runtime, _) => (0, 0, 0),
        (Kind::Scheduler, 0) => (0, RED_SCHEDULER_4X16X16_BYTES, 3),
        (Kind::Scheduler, 1) => (MEDIUM, RED_SCHEDULER_8X64X32_BYTES, 2),
        (Kind::Scheduler, _) => (LARGE + 2 * RED_DAG_16X256X64_BYTES, RED_SCHEDULER_16X256X64_BYTES, 1),
        (Kind::Dag, 0) => (SMALL, RED_DAG_4X16X16_BYTES, if crowd { 265 } else { 5 }),
        (Kind::Dag, 1) => (MEDIUM + 2 * RED_SCHEDULER_8X64X32_BYTES, RED_DAG_8X64X32_BYTES, 3),
        (Kind::Dag, _) => (LARGE, RED_DAG_16X256X64_BYTES, 2),
    }
}

/// Where memory for the second class begins, and for the third: behind that of those before.
const MEDIUM: usize = 3 * RED_SCHEDULER_4X16X16_BYTES + 5 * RED_DAG_4X16X16_BYTES;
const LARGE: usize = MEDIUM + 2 * RED_SCHEDULER_8X64X32_BYTES + 3 * RED_DAG_8X64X32_BYTES;

/// The most that an execution needs.
pub(crate) const MOST: usize = LARGE + 2 * RED_DAG_16X256X64_BYTES + RED_SCHEDULER_16X256X64_BYTES;
const _: () = assert!(arena(Sizes { classes: 1, more: More::Crowd }) <= MOST, "room for a crowd");

/// How much of the arena an execution needs.
pub(crate) const fn arena(sizes: Sizes) -> usize {
    match (sizes.more, sizes.classes) {
        (More::Crowd, _) => MEDIUM + 260 * RED_DAG_4X16X16_BYTES,
        (More::Runtimes, _) => LARGE + 2 * RED_DAG_16X256X64_BYTES,
        (_, 1) => MEDIUM,
        (_, 2) => LARGE,
        _ => MOST,
    }
}

impl World<'_> {
    /// Memory for something: free, or in that of something open.
    pub(crate) fn memory(&mut self, kind: Kind, class: usize, least: usize) -> Lent {
        let (start, size, count) = sites(kind, class, self.has(More::Crowd));
        let overlaps = |at: usize, open: &Open| open.lent.start < at + size && at < open.lent.end;
        let site = |i: usize| start + i * size;
        // Where many are open, the first ones are.
        let likely = self.open.len().min(count);
        let mut sites = (likely..count).chain(0..likely);
        let free = sites.find(|i| !self.open.iter().any(|open| overlaps(site(*i), open)));
        let at = match free {
            Some(free) if self.careful || !self.choices.chance(20) => site(free),
            _ => site(self.choices.below(count)),
        };
        if self.careful {
            return self.lent(at, size, least);
        }
        // Into the next site, or all of this one for less than it holds.
        match self.choices.byte() {
            0..4 if at + 2 * size <= self.arena_len() => {
                let more = red_align() * (1 + self.choices.below(8));
                self.lent(at + more, size, least)
            }
            4..8 if at + 2 * size <= self.arena_len() => self.lent(at, size + 64, least),
            _ => self.lent(at, size, least),
        }
    }

    pub(crate) fn dag(&mut self, at: usize) -> &mut dyn AnyDag {
        match &mut self.open[at].thing {
            Thing::Dag(dag, _) => &mut **dag,
            Thing::Scheduler(..) | Thing::Runtime(..) => panic!("place {at} is no graph's"),
        }
    }

    /// A node's number.
    pub(crate) fn node_number(&mut self) -> u32 {
        let number = if self.careful || !self.choices.chance(16) {
            self.choices.below(18) as u32
        } else {
            self.choices.number() as u32
        };
        if number > 255 {
            self.is_wrong(red_status::UnknownNode);
        }
        number
    }

    fn any_node(&mut self) -> red_node {
        let c = &mut self.choices;
        let cost = u64::from(c.byte()) * 10_000;
        let mut node = red_node { wcet_ns: cost, bcet_ns: cost / 2, sensor: RED_NONE, ..red_node::EMPTY };
        let kind = c.byte();
        node.memory_bytes = (kind >> 4).into();
        match kind % 16 {
            0..=5 => {}
            6..=8 => (node.role, node.weights, node.frame) = (1, c.byte() as u32 % 2, c.byte() as u32 % 2),
            9 => (node.role, node.sensor) = (1, c.byte() as u32 % 3),
            10 | 11 => node.role = 2,
            12 => (node.atomic, node.contention_ns) = (1, u64::from(c.byte()) * 1_000),
            13 => node.pool = c.byte() as u32 % 3,
            _ if self.careful => {}
            _ => {
                let number = c.number();
                let field = c.byte() % 12;
                let small = number as u32;
                match field {
                    0 => node.wcet_ns = number,
                    1 => node.bcet_ns = number,
                    2 => node.contention_ns = number,
                    3 => node.memory_bytes = number,
                    4 => node.pool = small,
                    5 => node.atomic = small,
                    6 => node.role = small,
                    7 => (node.role, node.weights) = (1, small),
                    8 => (node.role, node.frame) = (1, small),
                    9 => (node.role, node.sensor) = (1, small),
                    10 => (node.atomic, node.contention_ns) = (1, number),
                    _ => (node.wcet_ns, node.atomic, node.contention_ns) = (number, 1, number),
                }
            }
        }
        node
    }

    /// What a node is to the core.
    fn known(&mut self, node: &red_node) -> Node {
        values::node(node).unwrap_or_else(|wrong| {
            self.wrong = self.wrong.join(wrong);
            Node::new(red_core::Wcet::ZERO)
        })
    }

    /// Lanes by pool; what a rule takes them for.
    fn lanes(&mut self) -> (*const u32, usize, Vec<u8>) {
        let count = self.choices.below(5);
        let lanes: Vec<u32> = (0..count).map(|_| u32::from(self.choices.byte() % 5)).collect();
        let mut lanes: Vec<u32> = lanes.into_iter().map(|lanes| if lanes == 0 { 1 } else { lanes }).collect();
        if count > 0 && self.spoils() {
            let (wrong, status) = self.choices.one_of(&[
                (0, red_status::NoLane),
                (256, red_status::OutOfRange),
                (u32::MAX, red_status::OutOfRange),
            ]);
            lanes[count - 1] = wrong;
            self.is_wrong(status);
        }
        let pointer = self.numbers(&lanes);
        let length = self.length(count, POOLS);
        (pointer, length, lanes.into_iter().map(|lanes| lanes as u8).collect())
    }

    fn deadline(&mut self) -> u64 {
        let deadline = self.choices.number().wrapping_mul(if self.choices.chance(128) { 10_000 } else { 1 });
        if deadline > 1 << 62 {
            self.is_wrong(red_status::Deadline);
        }
        deadline
    }
}

fn open(w: &mut World<'_>, class: usize) {
    type Open = extern "C" fn(*mut std::ffi::c_void, usize, *mut red_dag) -> red_status;
    type Twin = fn() -> Box<dyn AnyDag>;
    const CLASSES: [(&str, Open, Twin); 3] = [
        ("red_dag_open_4x16x16", red_dag_open_4x16x16, twin::dag::<Small>),
        ("red_dag_open_8x64x32", red_dag_open_8x64x32, twin::dag::<Medium>),
        ("red_dag_open_16x256x64", red_dag_open_16x256x64, twin::dag::<Large>),
    ];
    let (name, open, twin) = CLASSES[class];
    w.begin(name);
    let lent = w.memory(Kind::Dag, class, 128);
    let out = w.out();
    let status = open(lent.pointer, lent.bytes, out.pointer);
    let expected = w.expected(|w| w.may_open(&lent.range));
    if expected.is_ok() && status == red_status::Ok {
        let bits = w.handle_in(out);
        w.opened_dag(bits, class, lent.range, (twin(), 0));
    }
    w.judge(status, expected, None);
}

impl World<'_> {
    pub(crate) fn opened_dag(
        &mut self,
        bits: u64,
        class: usize,
        lent: Range<usize>,
        (dag, begun_on): (Box<dyn AnyDag>, u64),
    ) {
        let size = sites(Kind::Dag, class, false).1;
        let own = lent.start..lent.start + size.min(lent.len());
        self.opened(Open { bits, class, lent, own, thing: Thing::Dag(dag, begun_on), is_stale: false });
    }
}

pub(crate) fn open_small(w: &mut World<'_>) {
    open(w, 0);
}

pub(crate) fn open_medium(w: &mut World<'_>) {
    if w.has_graphs(1) {
        open(w, 1);
    }
}

pub(crate) fn open_large(w: &mut World<'_>) {
    if w.has_graphs(2) {
        open(w, 2);
    }
}

pub(crate) fn close(w: &mut World<'_>) {
    w.begin("red_dag_close");
    let (handle, at) = w.handle(Kind::Dag);
    let status = red_dag_close(handle);
    if w.is_right() {
        w.desk.expect_last(&[0; 8]);
        w.closed(at);
    }
    w.judge(status, Ok(()), None);
}

pub(crate) fn add_node(w: &mut World<'_>) {
    w.begin("red_dag_add_node");
    let (handle, at) = w.handle(Kind::Dag);
    let given = w.any_node();
    let node = w.known(&given);
    let given = w.given(&given);
    let number = w.out();
    let status = red_dag_add_node(handle, given, number.pointer);
    let added = w.expected(|w| w.dag(at).add_node(node)).map(|id| w.put(number, &id));
    w.judge(status, added, Some(at));
}

pub(crate) fn add_edge(w: &mut World<'_>) {
    w.begin("red_dag_add_edge");
    let (handle, at) = w.handle(Kind::Dag);
    let (from, to) = (w.node_number(), w.node_number());
    let status = red_dag_add_edge(handle, from, to);
    let added = w.expected(|w| w.dag(at).add_edge(NodeId::new(from as u8), NodeId::new(to as u8)));
    w.judge(status, added, Some(at));
}

pub(crate) fn remove_node(w: &mut World<'_>) {
    w.begin("red_dag_remove_node");
    let (handle, at) = w.handle(Kind::Dag);
    let node = w.node_number();
    let status = red_dag_remove_node(handle, node);
    let removed = w.expected(|w| w.dag(at).remove_node(NodeId::new(node as u8)));
    w.judge(status, removed, Some(at));
}

pub(crate) fn remove_edge(w: &mut World<'_>) {
    w.begin("red_dag_remove_edge");
    let (handle, at) = w.handle(Kind::Dag);
    let (from, to) = (w.node_number(), w.node_number());
    let status = red_dag_remove_edge(handle, from, to);
    let removed = w.expected(|w| w.dag(at).remove_edge(NodeId::new(from as u8), NodeId::new(to as u8)));
    w.judge(status, removed, Some(at));
}

pub(crate) fn refine(w: &mut World<'_>) {
    w.begin("red_dag_refine");
    let (handle, at) = w.handle(Kind::Dag);
    let stage = w.node_number();
    let encoder = red_node { role: 1, ..w.any_node() };
    let mut parts = vec![w.known(&encoder)];
    let encoder = w.given(&encoder);
    let count = if w.choices.chance(8) { w.choices.byte().into() } else { w.choices.below(5) };
    let decoders: Vec<_> = (0..count).map(|_| w.any_node()).collect();
    parts.extend(decoders.iter().map(|decoder| w.known(decoder)));
    let decoders = w.given_array(&decoders);
    let length = w.length(count, NODES);
    let number = w.out();
    if !w.is_right() {
        // Whether there is room is asked before decoders are looked at, and what pools there are with them.
        let pools = parts.iter().any(|part| part.pool().index() > 0);
        [(count > 16, red_status::NodesFull), (pools, red_status::UnknownPool)]
            .into_iter()
            .filter(|(may_be, _)| *may_be)
            .for_each(|(_, status)| w.is_wrong(status));
    }
    let status = red_dag_refine(handle, stage, encoder, decoders, length, number.pointer);
    let stage = NodeId::new(stage as u8);
    let refined = w.expected(|w| w.dag(at).refine(stage, parts[0], &parts[1..])).map(|id| w.put(number, &id));
    w.judge(status, refined, Some(at));
}

pub(crate) fn summarize(w: &mut World<'_>) {
    w.begin("red_dag_summarize");
    let (handle, at) = w.handle(Kind::Dag);
    let out = w.out_growing();
    let status = red_dag_summarize(handle, out.pointer);
    let said = w.expected(|w| Ok(w.dag(at).summary())).map(|(nodes, levels, work_ns, critical_path_ns)| {
        let (nodes, levels) = (nodes as u32, levels as u32);
        w.put_growing(out, &red_dag_summary { nodes, levels, work_ns, critical_path_ns, ..Empty::EMPTY });
    });
    w.judge(status, said, None);
}

pub(crate) fn node(w: &mut World<'_>) {
    w.begin("red_dag_node");
    let (handle, at) = w.handle(Kind::Dag);
    let node = w.node_number();
    let out = w.out_growing();
    let status = red_dag_node(handle, node, out.pointer);
    let said = w.expected(|w| w.dag(at).node(NodeId::new(node as u8)));
    let said = said.map(|node| w.put_growing(out, &values::of_node(&node)));
    w.judge(status, said, None);
}

pub(crate) fn successors(w: &mut World<'_>) {
    w.begin("red_dag_successors");
    let (handle, at) = w.handle(Kind::Dag);
    let node = w.node_number();
    let room = w.room(20);
    let status = red_dag_successors(handle, node, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|w| w.dag(at).successors(NodeId::new(node as u8)));
    let said = said.and_then(|nodes| w.fill(room, &nodes));
    w.judge(status, said, None);
}

/// A call that writes what a deadline rule gives into rows of the caller's.
type ByRule<T> =
    extern "C" fn(*const red_dag, u32, u64, *const u32, usize, *mut T, usize, *mut usize) -> red_status;

/// Calls it with the rule of this number, if there is one; `twin` says what the rows have to be.
fn by_rule<T: Empty + Copy>(
    w: &mut World<'_>,
    (number, rule): (u32, Option<DeadlineRule>),
    call: ByRule<T>,
    twin: fn(&dyn AnyDag, DeadlineRule, Duration, &[u8]) -> Vec<T>,
) {
    let (handle, at) = w.handle(Kind::Dag);
    if rule.is_none() {
        w.is_wrong(red_status::OutOfRange);
    }
    let deadline = w.deadline();
    let (lanes, pools, by_pool) = w.lanes();
    let room = w.room(20);
    let status = call(handle, number, deadline, lanes, pools, room.pointer, room.room, room.count.pointer);
    let said = w.expected(|w| {
        let rule = rule.ok_or(red_status::OutOfRange)?;
        Ok(twin(w.dag(at), rule, Duration::from_nanos(deadline), &by_pool))
    });
    let said = said.and_then(|rows| w.fill(room, &rows));
    w.judge(status, said, None);
}

pub(crate) fn place(w: &mut World<'_>) {
    w.begin("red_dag_place");
    let number = if w.choices.chance(16) { w.choices.number() as u32 } else { w.choices.below(6) as u32 };
    by_rule(w, (number, values::rule(number)), red_dag_place, |dag, rule, due, lanes| {
        dag.place(rule, due, lanes)
    });
}

pub(crate) fn share(w: &mut World<'_>) {
    w.begin("red_dag_share");
    let number = if w.choices.chance(24) { w.choices.byte().into() } else { 1 + w.choices.below(2) as u32 };
    let rule = values::rule(number).filter(|rule| rule.is_level());
    by_rule(w, (number, rule), red_dag_share, |dag, rule, due, lanes| dag.share(rule, due, lanes));
}

pub(crate) fn prove(w: &mut World<'_>) {
    w.begin("red_dag_prove");
    let (handle, at) = w.handle(Kind::Dag);
    let limit = w.choices.number();
    let (lanes, pools, by_pool) = w.lanes();
    let budgets: Vec<u64> = by_pool
        .iter()
        .map(|_| if w.choices.chance(128) { RED_NONE_64 } else { w.choices.number() })
        .collect();
    let memory = w.numbers(&budgets);
    let out = w.out_growing();
    let status = red_dag_prove(handle, limit, lanes, memory, pools, out.pointer);
    let proof = w.expected(|w| {
        let mut budgets: Vec<_> = budgets.iter().map(|b| (*b != RED_NONE_64).then_some(Bytes(*b))).collect();
        budgets.resize(POOLS, None);
        Ok(w.dag(at).prove(Duration::from_nanos(limit), &by_pool, &budgets))
    });
    let proof = proof.map(|proof| w.put_growing(out, &values::of_certificate(&proof)));
    w.judge(status, proof, None);
}
