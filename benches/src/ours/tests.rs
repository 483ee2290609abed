use super::*;
use crate::peers::tests::{machine, run};

#[test]
fn one_lane_completes_every_graph_bare_and_observed() {
    run(1, bare);
    run(1, observed);
}

#[test]
fn two_lanes_complete_every_graph() {
    run(2, two_lanes);
}

#[test]
fn a_frame_from_outside_completes() {
    run(1, from_outside);
}

#[test]
fn a_job_goes_from_lane_to_lane_and_back() {
    let mut samples = [0; 2];
    let ended = hand_off(machine()).and_then(|mut runner| runner(3, &mut samples));
    assert!(ended.is_ok(), "{ended:?}");
}
