use super::*;

/// One CPU for both lanes, so that the tests need no second one.
fn machine() -> &'static Machine {
    let machine = Machine::best_effort().map(|found| Machine { lanes: vec![found.lanes[0]; 2], ..found });
    Box::leak(Box::new(machine.expect("the affinity of this process can be read")))
}

fn run(lanes: usize, build: fn(&Setup<'_>) -> Result<Runner, NotRun>) {
    for graph in Graph::all() {
        let setup = Setup { graph: &graph, lanes, body: Body::EMPTY, machine: machine() };
        let mut samples = [0; 2];
        let ended = build(&setup).and_then(|mut runner| runner(3, &mut samples));
        assert!(ended.is_ok(), "{}: {ended:?}", graph.name);
    }
}

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
