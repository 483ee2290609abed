use super::*;
use red_core::{Empty, Instant, LaneId, NodeId, TaskId};

/// An event of node `node` of the first job at `at` on lane 0.
fn event(at: u64, kind: EventKind, node: u8) -> Event {
    Event {
        at: Instant::from_nanos(at),
        job: 0,
        kind,
        task: TaskId::EMPTY,
        node: NodeId::new(node),
        lane: LaneId::new(0),
    }
}

#[test]
fn a_slice_follows_its_predecessors_also_through_an_encoder_that_was_a_hit() {
    // 0 -> 1 -> 2, and 0 -> 2.
    let edges = [vec![(0, 1), (1, 2), (0, 2)]];
    let events = [
        event(10, EventKind::Started, 0),
        event(20, EventKind::Completed, 0),
        event(20, EventKind::Hit, 1),
        event(25, EventKind::Started, 2),
        event(40, EventKind::Completed, 2),
    ];
    let slices = slices(&events, &edges, |_, _| 99);
    let shown: Vec<_> = slices.iter().map(|s| (s.of.2, s.start_ns, s.end_ns, s.after.clone())).collect();
    assert_eq!(shown, [(0, 10, 20, vec![]), (2, 25, 40, vec![0])]);
    assert!(slices.iter().all(|s| s.completed));
}

#[test]
fn what_did_not_complete_is_drawn_to_the_end_of_its_job() {
    let slices = slices(&[event(10, EventKind::Started, 0)], &[vec![]], |_, _| 30);
    assert_eq!((slices[0].end_ns, slices[0].completed), (30, false));
}
