//! Schedulers: pools, sensors, tasks and their edits.

use super::{Graph, Machine, config, headed, node, ok};
use crate::*;

fn commit(machine: &mut Machine, edit: &Graph, now_ns: u64) -> (red_status, red_certificate) {
    let mut proof = headed!(red_certificate {});
    (red_scheduler_commit(machine.at_mut(), edit.at(), now_ns, &raw mut proof), proof)
}

#[test]
fn pools_and_sensors_are_added_and_used() {
    let mut machine = Machine::new(config(red_preset::Redrt, 2));
    let (mut pool, mut sensor, mut used) = (RED_NONE, RED_NONE, RED_NONE_64);
    let at = machine.at_mut();
    assert_eq!(red_scheduler_add_pool(at, 3, RED_NONE_64, &raw mut pool), red_status::PoolsFull);
    ok(red_scheduler_add_pool(at, 2, 1000, &raw mut pool));
    ok(red_scheduler_add_sensor(at, 33, &raw mut sensor));
    assert_eq!((pool, sensor), (1, 0));
    let mut graph = Graph::new();
    let role = red_role::SharedEncoder as u32;
    graph.add(red_node { role, sensor, pool, memory_bytes: 10, ..node(5) });
    let task = machine.add(&graph, 100);
    machine.release(task, 0);
    let action = machine.poll(0);
    assert_eq!((action.kind, action.lane), (red_action_kind::Dispatch as u32, 2));
    ok(red_scheduler_memory_used(machine.at(), pool, &raw mut used));
    assert_eq!(used, 10);
    assert_eq!(red_scheduler_memory_used(machine.at(), 2, &raw mut used), red_status::UnknownPool);
    let at = machine.at_mut();
    assert_eq!(red_scheduler_retire_lane(at, 2), red_status::UnknownLane, "it runs something");
    ok(red_scheduler_retire_lane(at, 3));
    ok(red_scheduler_restore_lane(at, 3));
    let mut told = headed!(red_config {});
    ok(red_scheduler_config(machine.at(), &raw mut told));
    assert_eq!((told.lanes, told.rule), (2, red_rule::LatestStart as u32));
    graph.close();
    machine.close();
}

#[test]
fn a_task_is_admitted_or_not() {
    let enforced = red_config { admission: red_admission::Enforce as u32, ..config(red_preset::Redrt, 1) };
    let (mut machine, mut graph) = (Machine::new(enforced), Graph::new());
    let mut admit = |graph: &Graph, deadline_ns| {
        let timing = headed!(red_timing { deadline_ns: deadline_ns, value: 1 });
        let mut task = RED_NONE;
        red_scheduler_add_task(machine.at_mut(), graph.at(), &raw const timing, &raw mut task)
    };
    assert_eq!(admit(&graph, 9), red_status::EmptyGraph);
    graph.add(node(8));
    assert_eq!(admit(&graph, 7), red_status::Unschedulable);
    (0..4).for_each(|_| ok(admit(&graph, 9)));
    assert_eq!(admit(&graph, 9), red_status::TasksFull);
    graph.close();
    machine.close();
}

#[test]
fn an_edit_is_of_the_scheduler_that_it_was_begun_on() {
    let (mut one, mut other, mut graph) = (
        Machine::new(config(red_preset::Redrt, 1)),
        Machine::new(config(red_preset::Redrt, 1)),
        Graph::new(),
    );
    graph.add(node(4));
    let task = one.add(&graph, 50);
    assert_eq!(other.add(&graph, 50), task, "tasks have the same names");
    let edit = Graph::edit(&other, task);
    assert_eq!(commit(&mut one, &edit, 1).0, red_status::Conflict);
    ok(commit(&mut other, &edit, 1).0);
    graph.close();
    edit.close();
    one.close();
    other.close();
}

#[test]
fn an_edit_is_committed_while_a_job_of_the_old_graph_runs() {
    let (mut machine, mut graph) = (Machine::new(config(red_preset::Redrt, 2)), Graph::new());
    graph.add(node(4));
    let task = machine.add(&graph, 50);
    machine.release(task, 0);
    let old = machine.poll(0).unit;
    let (mut edit, other) = (Graph::edit(&machine, task), Graph::edit(&machine, task));
    let added = edit.add(node(6));
    edit.edge(0, added);
    let (committed, proof) = commit(&mut machine, &edit, 1);
    ok(committed);
    assert_eq!((proof.work_ns, proof.limit_ns), (10, 50));
    assert_eq!(commit(&mut machine, &other, 1).0, red_status::Conflict);
    assert_eq!(commit(&mut machine, &graph, 1).0, red_status::Conflict, "it never was an edit");
    let third = Graph::edit(&machine, task);
    assert_eq!(commit(&mut machine, &third, 1).0, red_status::Draining);
    let mut kept = headed!(red_certificate {});
    ok(red_scheduler_certificate(machine.at(), task, &raw mut kept));
    assert_eq!(kept.work_ns, 10);
    machine.release(task, 2);
    ok(red_scheduler_complete(machine.at_mut(), old, 3));
    ok(red_scheduler_remove_task(machine.at_mut(), task, 4));
    assert_eq!(commit(&mut machine, &third, 4).0, red_status::UnknownTask);
    for closed in [graph, edit, other, third] {
        closed.close();
    }
    machine.close();
}
