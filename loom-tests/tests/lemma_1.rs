//! *Claim.* No sub-job starts before its predecessors ended (the paper's Lemma 1), none starts twice, none is
//! forgotten; no ready node waits beside an idle lane, and a lane makes its successors ready before it asks for work.
//!
//! *Threads.* A lane and who asks for the job; two lanes, one of which asks; two lanes and who asks.
//! *Bound.* None for a lane and who asks; for two lanes four preemptions with a fork and three with a diamond; few for
//! three threads: with the checker's lock in the place of the ticket lock. With the ticket lock three preemptions.
//! *Sources.* `sync/src/shared.rs`, `sync/src/mailbox.rs`, `sync/src/ticket_lock.rs`
#![cfg(loom)]

use red_core::Scheduler;
use red_loom_tests::Exclusive;
use red_loom_tests::lanes::{Edges, Host, IdealHost, Planted, Small, start};
use red_loom_tests::model::{explore, explore_within};
use red_loom_tests::ticket_lock::TicketLock;
use std::sync::Arc;

/// One, then two side by side, then one.
const DIAMOND: Edges = &[(0, 1), (0, 2), (1, 3), (2, 3)];

/// The caller asks for a job and is a lane itself.
fn two_lanes<L: Exclusive<Scheduler<Small>> + Send + Sync + 'static>(host: Host<L>) {
    let host = Arc::new(host);
    let other = start(&host, 1);
    host.request();
    host.lane(0);
    other.join().unwrap();
    host.check();
}

/// The caller asks for a job, and is no lane.
fn two_lanes_and_a_releaser(host: IdealHost) {
    let host = Arc::new(host);
    let lanes = [0, 1].map(|lane| start(&host, lane));
    host.request();
    lanes.into_iter().for_each(|lane| lane.join().unwrap());
    host.check();
}

#[test]
fn a_lane_runs_a_chain_that_somebody_asks_for() {
    explore(2, || {
        let host = Arc::new(IdealHost::new(&[(0, 1)], 1));
        // The other lane never gets anything: a lane that asks is given its own first.
        let lane = start(&host, 0);
        host.request();
        lane.join().unwrap();
        host.check();
    });
}

#[test]
fn two_lanes_run_a_fork() {
    explore_within(2, Some(4), || two_lanes(IdealHost::new(&[(0, 1), (0, 2)], 1)));
}

#[test]
fn two_lanes_run_a_diamond() {
    explore_within(2, Some(3), || two_lanes(IdealHost::new(DIAMOND, 1)));
}

#[test]
fn two_lanes_run_a_diamond_behind_the_ticket_lock() {
    explore_within(2, Some(3), || two_lanes(Host::<TicketLock<_>>::new(DIAMOND, 1)));
}

#[test]
fn two_lanes_run_a_diamond_that_somebody_asks_for() {
    explore(3, || two_lanes_and_a_releaser(IdealHost::new(DIAMOND, 1)));
}

#[test]
#[should_panic(expected = "waits beside an idle lane")]
fn a_lane_that_asks_before_it_reports_is_caught() {
    explore(2, || two_lanes(IdealHost::new(DIAMOND, 1).planted(Planted::ReportsLate)));
}

#[test]
#[should_panic(expected = "started before a predecessor ended")]
fn a_graph_without_an_edge_is_caught() {
    explore(2, || {
        // The scheduler does not know that the fourth node waits for the second.
        let host = IdealHost::new(&[(0, 1), (0, 2), (2, 3)], 1).planted(Planted::LosesEdges);
        host.act(|_, notes, _| notes.graph = DIAMOND);
        two_lanes(host);
    });
}
