//! Several threads: each with its own, one after another with the same, and all at once where they only look.

use super::{Block, Graph, Machine, config, headed, node, ok};
use crate::*;
use std::sync::Barrier;
use std::thread;

const ROUNDS: u64 = if cfg!(miri) { 4 } else { 100_000 };
const BYTES: usize = RED_DAG_4X16X16_BYTES;

/// Opens and closes a graph there.
fn come_and_go(memory: &Block, from: usize) {
    let mut dag = red_dag::default();
    ok(red_dag_open_4x16x16(memory.lent(from), BYTES, &raw mut dag));
    ok(red_dag_close(&raw mut dag));
}

#[test]
fn each_opens_and_closes_its_own_whatever_others_do() {
    // The middle one overlaps neither side, though both are lent in turn.
    let memory = Block::aligned(3 * BYTES, RED_ALIGN);
    let start = Barrier::new(2);
    thread::scope(|scope| {
        scope.spawn(|| {
            start.wait();
            (0..ROUNDS).for_each(|_| come_and_go(&memory, BYTES));
        });
        start.wait();
        for _ in 0..ROUNDS {
            come_and_go(&memory, 0);
            come_and_go(&memory, 2 * BYTES);
        }
    });
}

#[test]
fn each_runs_its_own_scheduler() {
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 1)), Graph::new());
                graph.add(node(1));
                let task = machine.add(&graph, 10);
                graph.close();
                for now_ns in 0..4 {
                    machine.release(task, now_ns);
                    let unit = machine.poll(now_ns).unit;
                    ok(red_scheduler_complete(machine.at_mut(), unit, now_ns));
                    assert_eq!(machine.poll(now_ns).kind, red_action_kind::Ended as u32);
                }
                machine.close();
            });
        }
    });
}

#[test]
fn several_look_at_once_and_then_another_goes_on() {
    let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 2)), Graph::new());
    graph.add(node(1));
    let task = machine.add(&graph, 10);
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let (mut figures, mut summary) = (headed!(red_figures {}), headed!(red_dag_summary {}));
                ok(red_scheduler_figures(machine.at(), &raw mut figures));
                ok(red_dag_summarize(graph.at(), &raw mut summary));
                assert_eq!((figures.lanes, summary.nodes), (2, 1));
            });
        }
    });
    let goes_on = thread::spawn(move || {
        machine.release(task, 0);
        (machine, graph.close())
    });
    let (mut machine, memory) = goes_on.join().expect("no panic");
    assert_eq!(machine.poll(0).kind, red_action_kind::Dispatch as u32);
    thread::spawn(move || machine.close()).join().expect("no panic");
    drop(memory);
}
