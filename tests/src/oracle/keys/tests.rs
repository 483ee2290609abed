use std::rc::Rc;

use super::*;
use crate::fixtures::{MS, node};
use crate::oracle::band;

/// The paper's chain, released at 0, due at 120 ms.
fn chain_job() -> Job {
    let graph = Rc::new(Graph::of(&[node("a", 20, &[]), node("b", 20, &["a"]), node("c", 40, &["b"])], true));
    Job {
        task: 0,
        index: 0,
        release: 0,
        due: i128::from(120 * MS),
        version: 0,
        heights: graph.heights(|_| true),
        state: vec![State::Waiting; 3],
        started: false,
        fortune: 0,
        band: band::NEW,
        keys: at_release(Policy::RedIda, &graph, 0, 120 * MS),
        latest_finish: vec![0; 3],
        frames: vec![None; 3],
        graph,
    }
}

fn ms(keys: &[i128]) -> Vec<i128> {
    keys.iter().map(|key| key / i128::from(MS)).collect()
}

#[test]
fn level_shares_at_release() {
    assert_eq!(ms(&chain_job().keys), [30, 60, 120]);
}

#[test]
fn what_remains_shares_what_is_left() {
    let mut job = chain_job();
    job.state[0] = State::Done;
    reassign(&mut job, 60 * MS);
    // 60 ms left for 20 and 40.
    assert_eq!(ms(&job.keys), [30, 80, 120]);
}

#[test]
fn a_running_node_counts_what_is_left_and_keeps_its_key() {
    let mut job = chain_job();
    job.state[0] = State::Running(0);
    reassign(&mut job, 10 * MS);
    // 110 ms left for 10, 20 and 40: 10 + 110 * 30 / 70.
    assert_eq!(ms(&job.keys), [30, 57, 120]);
    reassign(&mut job, 60 * MS);
    // The running node is over its estimate and counts 1 ns.
    assert_eq!(job.keys[1], i128::from(60 * MS + 60 * MS * (20 * MS + 1) / (60 * MS + 1)));
}

#[test]
fn a_late_job_is_due_at_its_deadline() {
    let mut job = chain_job();
    reassign(&mut job, 120 * MS);
    assert_eq!(ms(&job.keys), [120, 120, 120]);
    reassign(&mut job, 500 * MS);
    assert_eq!(ms(&job.keys), [120, 120, 120]);
}

#[test]
fn latest_start_keys_may_lie_before_the_release() {
    let graph = Graph::of(&[node("a", 20, &[]), node("b", 20, &["a"])], true);
    assert_eq!(ms(&at_release(Policy::Redrt, &graph, 5 * MS, 10 * MS)), [-25, -5]);
    assert_eq!(ms(&at_release(Policy::Edf, &graph, 5 * MS, 10 * MS)), [15, 15]);
}
