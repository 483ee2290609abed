//! *Claim.* No job sees half a graph: one that is released before a commit runs the old graph whole, one after it the
//! new graph whole, whoever dispatches meanwhile.
//!
//! *Threads.* A lane and who edits; then two lanes, and who edits and asks for jobs.
//! *Bound.* Three preemptions for two; two preemptions for three threads, three with `--deep`, with the checker's lock.
//! *Sources.* `sync/src/shared.rs`, `sync/src/mailbox.rs`
#![cfg(loom)]

use red_core::{Node, NodeId, Wcet};
use red_loom_tests::lanes::{Edges, IdealHost, start};
use red_loom_tests::model::{explore, explore_within};
use std::sync::Arc;

const BEFORE: Edges = &[(0, 1)];
/// A node comes between the two.
const AFTER: Edges = &[(0, 2), (2, 1)];

fn edit(host: &IdealHost, tells: bool) {
    host.act(|scheduler, notes, now| {
        let mut edit = scheduler.edit(host.task).expect("the task is there");
        let [first, second] = [0, 1].map(NodeId::new);
        let between = edit.add_node(Node::new(Wcet::from_millis(1))).expect("there is room");
        assert!(edit.remove_edge(first, second));
        edit.add_edge(first, between).expect("no cycle");
        edit.add_edge(between, second).expect("no cycle");
        let _proof = scheduler.commit(&edit, now).expect("nothing stands against it");
        if tells {
            notes.graph = AFTER;
        }
    });
}

fn no_job_sees_half_a_graph(lanes: usize, tells: bool) {
    let host = Arc::new(IdealHost::new(BEFORE, 2));
    let lanes: Vec<_> = (0..lanes).map(|lane| start(&host, lane)).collect();
    host.request();
    edit(&host, tells);
    host.request();
    lanes.into_iter().for_each(|lane| lane.join().unwrap());
    host.check();
}

#[test]
fn a_lane_and_an_editor() {
    explore_within(2, Some(3), || {
        // Of two lanes of the scheduler one is the editor's, so that it gives out what the other does not take.
        let host = Arc::new(IdealHost::new(BEFORE, 2));
        let lane = start(&host, 1);
        host.request();
        edit(&host, true);
        host.request();
        host.lane(0);
        lane.join().unwrap();
        host.check();
    });
}

#[test]
fn two_lanes_and_an_editor() {
    explore(3, || no_job_sees_half_a_graph(2, true));
}

#[test]
#[should_panic(expected = "nodes of one version")]
fn a_job_with_another_graph_than_its_version_is_caught() {
    explore(3, || no_job_sees_half_a_graph(2, false));
}
