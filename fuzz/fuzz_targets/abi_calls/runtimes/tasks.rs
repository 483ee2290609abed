//! Tasks of runtimes, with their bodies.

use std::ffi::{c_int, c_void};

use red_core::{Certificate, Empty, Instant, NodeId};
use red_ffi::*;

use crate::planted::{Bug, has};
use crate::twin::{Answer, AnyDag, Twin, or};
use crate::values;
use crate::world::{Kind, Thing, World};

/// Nodes of a graph at most.
const NODES: usize = 256;

extern "C" fn never(_user: *mut c_void, _context: *const red_context) -> c_int {
    panic!("a body runs, and no lane was started")
}

fn callback(node: u32) -> red_callback {
    red_callback { node, reserved: 0, body: Some(never), user: std::ptr::null_mut() }
}

impl World<'_> {
    /// The graph behind a handle, where that is right.
    fn graph(&self, dag: usize) -> Option<&dyn AnyDag> {
        match self.open.get(dag).map(|open| &open.thing) {
            Some(Thing::Dag(dag, _)) => Some(&**dag),
            _ => None,
        }
    }

    /// Bodies of these nodes; or too few, too many, or another's.
    fn callbacks(&mut self, nodes: &[NodeId]) -> Vec<red_callback> {
        let mut all: Vec<_> = nodes.iter().map(|node| callback(node.index() as u32)).collect();
        if !self.careful && self.choices.chance(60) {
            let (kind, which) = (self.choices.byte() % 5, self.choices.below(all.len().max(1)));
            match (kind, all.get(which).copied()) {
                (0, Some(_)) => _ = all.swap_remove(which),
                (1, Some(again)) => all.push(again),
                (2, Some(_)) => all[which].body = None,
                (3, _) => all.reverse(),
                _ => all.insert(which, callback(self.choices.number() as u32)),
            }
            all.truncate(NODES);
        }
        all
    }
}

/// What bodies for a graph's nodes are refused for.
fn are_of(dag: &dyn AnyDag, callbacks: &[red_callback]) -> Answer<()> {
    let nodes = dag.nodes();
    for (i, given) in callbacks.iter().enumerate() {
        let is_there = nodes.iter().any(|node| node.index() as u32 == given.node) || has(Bug::Body);
        let is_first = callbacks[..i].iter().all(|before| before.node != given.node);
        or(is_there && is_first, red_status::UnknownNode)?;
        or(given.body.is_some(), red_status::NoBody)?;
    }
    Ok(())
}

fn has_body(callbacks: &[red_callback], node: NodeId) -> bool {
    callbacks.iter().any(|given| given.node == node.index() as u32)
}

pub(crate) fn add_task(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_add_task");
    let (graph, dag) = w.handle(Kind::Dag);
    let nodes = w.graph(dag).map_or(Vec::new(), AnyDag::nodes);
    let callbacks = w.callbacks(&nodes);
    let given = w.numbers(&callbacks);
    let count = w.length(callbacks.len(), NODES);
    let timing = w.any_timing();
    let known = values::timing(&timing);
    known.err().into_iter().for_each(|wrong| w.join(wrong));
    let timing = w.given(&timing);
    let out = w.out();
    let status = red_runtime_add_task(handle, graph, given, count, timing, out.pointer);
    let added = w.expected(|w| {
        let timing = known.map_err(|_| red_status::OutOfRange)?;
        w.both(at, dag, |twin, dag| {
            twin.takes(dag)?;
            are_of(dag, &callbacks)?;
            or(dag.nodes().iter().all(|node| has_body(&callbacks, *node)), red_status::NoBody)?;
            twin.add_task(dag, timing)
        })
    });
    let added = added.map(|task| {
        let floor = known.map_or(0, |timing| timing.parts().3[1].into());
        w.twin(at).1.tasks.push(task);
        w.twin(at).1.floors.push((task, floor));
        w.put(out, &task);
    });
    w.judge(status, added, None);
}

pub(crate) fn remove_task(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_remove_task");
    let task = w.task(at);
    let status = red_runtime_remove_task(handle, task);
    let removed = w.expected(|w| w.twin(at).0.remove_task(task, Instant::ZERO));
    w.judge(status, removed, None);
}

/// Of a task that has not run, also one that was removed: no job, and a floor that nobody broke.
pub(crate) fn report(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_task_report");
    let task = w.task(at);
    let out = w.out_growing();
    let status = red_runtime_task_report(handle, task, out.pointer);
    let known = w.expected(|w| {
        let all = &w.twin(at).1.floors;
        let in_place = all.iter().rev().find(|(other, _)| other & 0xFFFF == task & 0xFFFF);
        in_place.filter(|(other, _)| *other == task).map(|(_, k)| *k).ok_or(red_status::UnknownTask)
    });
    let said = known.map(|floor_worst| {
        w.put_growing(out, &red_task_report { floor_worst, floor_kept: 1, ..red_task_report::EMPTY });
    });
    w.judge(status, said, None);
}

pub(crate) fn certificate(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_certificate");
    let task = w.task(at);
    let out = w.out_growing();
    let status = red_runtime_certificate(handle, task, out.pointer);
    let proof = w.expected(|w| w.twin(at).0.certificate(task));
    let proof = proof.map(|proof| w.put_growing(out, &values::of_certificate(&proof)));
    w.judge(status, proof, None);
}

pub(crate) fn edit(w: &mut World<'_>) {
    // Among many there is room for small ones only.
    let class = if w.has_graphs(2) { 2 } else { 0 };
    let (handle, at) = w.runtime("red_runtime_edit");
    let task = w.task(at);
    let lent = w.memory(Kind::Dag, class, 128);
    let out = w.out();
    let status = red_runtime_edit(handle, task, lent.pointer, lent.bytes, out.pointer);
    let begun = w.expected(|w| {
        or(class == 2, red_status::TooShort)?;
        let dag = w.twin(at).0.edit(task)?;
        w.may_open(&lent.range)?;
        Ok(dag)
    });
    let begun = begun.map(|dag| {
        if status == red_status::Ok {
            let bits = w.handle_in(out);
            let begun_on = w.open[at].bits;
            w.opened_dag(bits, class, lent.range, (dag, begun_on));
        }
    });
    w.judge(status, begun, None);
}

/// Nodes of an edit that its task has not.
fn new_nodes(twin: &dyn Twin, dag: &dyn AnyDag) -> Vec<NodeId> {
    let task = dag.origin().0.to_bits();
    dag.nodes().into_iter().filter(|node| twin.executions(task, *node).is_err()).collect()
}

/// Which nodes are new says nothing where an edit is of a graph that is no more.
fn commits(
    twin: &mut dyn Twin,
    dag: &dyn AnyDag,
    of_this: Answer<()>,
    callbacks: &[red_callback],
) -> Answer<Certificate> {
    twin.takes(dag)?;
    are_of(dag, callbacks)?;
    of_this?;
    let new = new_nodes(twin, dag);
    for node in dag.nodes() {
        let wrong = match (new.contains(&node), has_body(callbacks, node)) {
            (true, false) => red_status::NoBody,
            (false, true) => red_status::HasBody,
            _ => continue,
        };
        let newest = twin.edit(dag.origin().0.to_bits())?;
        or(newest.origin() == dag.origin(), red_status::Conflict)?;
        return Err(wrong);
    }
    twin.commit(dag, Instant::ZERO)
}

pub(crate) fn commit(w: &mut World<'_>) {
    let (handle, at) = w.runtime("red_runtime_commit");
    let (graph, dag) = w.handle(Kind::Dag);
    let new = match (w.open.get(at).map(|open| &open.thing), w.graph(dag)) {
        (Some(Thing::Runtime(twin, _)), Some(dag)) => new_nodes(&**twin, dag),
        _ => Vec::new(),
    };
    let callbacks = w.callbacks(&new);
    let given = w.numbers(&callbacks);
    let count = w.length(callbacks.len(), NODES);
    let out = w.out_growing();
    let status = red_runtime_commit(handle, graph, given, count, out.pointer);
    let proof = w.expected(|w| {
        let of_this = w.may_change(at, dag);
        w.both(at, dag, |twin, dag| commits(twin, dag, of_this, &callbacks))
    });
    let proof = proof.map(|proof| w.put_growing(out, &values::of_certificate(&proof)));
    w.judge(status, proof, None);
}
