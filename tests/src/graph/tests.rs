use super::*;
use crate::fixtures::{adding, node, stage, written};
use red_workload::model::{Node, Work};

fn edges(graph: &Graph) -> Vec<String> {
    let nodes = &graph.nodes;
    let into =
        |v: &SubNode| v.preds.iter().map(|&u| format!("{}>{}", nodes[u].name, v.name)).collect::<Vec<_>>();
    nodes.iter().flat_map(into).collect()
}

fn pipeline() -> Vec<Node> {
    vec![
        node("camera", 2, &[]),
        stage("see", 12, &[("lane", 4), ("segment", 6)], &["camera"]),
        node("steer", 1, &["see.lane"]),
        node("control", 3, &["see", "see.lane"]),
    ]
}

#[test]
fn a_stage_is_entered_at_its_encoder_and_left_at_its_decoders() {
    let graph = Graph::of(&pipeline(), true);
    let expected = [
        "camera>see.encoder",
        "see.encoder>see.lane",
        "see.encoder>see.segment",
        "see.lane>steer",
        "see.lane>control",
        "see.segment>control",
    ];
    assert_eq!(edges(&graph), expected);
    assert_eq!(graph.heights(|_| true), [0, 1, 2, 2, 3, 3]);
}

#[test]
fn a_whole_stage_costs_all_its_parts() {
    let graph = Graph::of(&pipeline(), false);
    assert_eq!(edges(&graph), ["camera>see", "see>steer", "see>control"]);
    assert_eq!(graph.nodes[1].wcet_ns, 22_000_000);
}

#[test]
fn a_whole_stage_holds_its_encoder_and_its_largest_decoder() {
    let Work::Stage(mut inner) = stage("see", 1, &[("a", 1), ("b", 1)], &[]).work else { unreachable!() };
    inner.encoder.memory_bytes = 60;
    inner.decoders[0].1.memory_bytes = 10;
    inner.decoders[1].1.memory_bytes = 25;
    let graph = Graph::of(&[written("see", &[], Work::Stage(inner))], false);
    assert_eq!(graph.nodes[0].memory_bytes, 85);
}

#[test]
fn contention_is_in_the_cost_and_not_in_the_execution() {
    let mut atomic = node("a", 5, &[]);
    if let Work::Plain(part) = &mut atomic.work {
        (part.atomic, part.contention_ns) = (true, 2_000_000);
    }
    let graph = Graph::of(&[atomic], true);
    assert_eq!((graph.nodes[0].wcet_ns, graph.nodes[0].cost_ns), (5_000_000, 7_000_000));
}

#[test]
fn an_added_node_comes_last_and_a_removed_one_takes_its_edges() {
    let mut detect = node("detect", 9, &["camera"]);
    detect.before = vec!["control".to_owned(), "see".to_owned()];
    let more = edited(&pipeline(), &[&adding(0, 0, detect)]);
    let graph = Graph::of(&more, true);
    assert_eq!(graph.nodes.last().map(|node| node.name.as_str()), Some("detect"));
    assert!(edges(&graph).contains(&"detect>see.encoder".to_owned()));

    let mut event = adding(1, 0, node("late", 1, &[]));
    event.remove = vec!["detect".to_owned(), "see".to_owned()];
    let less = Graph::of(&edited(&more, &[&event]), true);
    assert_eq!(edges(&less), Vec::<String>::new());
}

#[test]
fn paths_of_a_diamond() {
    let nodes = [node("a", 1, &[]), node("b", 5, &["a"]), node("c", 2, &["a"]), node("d", 3, &["b", "c"])];
    let graph = Graph::of(&nodes, true);
    let ms = |values: Vec<u64>| values.into_iter().map(|value| value / 1_000_000).collect::<Vec<_>>();
    assert_eq!(ms(graph.heads(&graph.costs())), [1, 6, 3, 9]);
    assert_eq!(ms(graph.tails(&graph.costs())), [8, 3, 3, 0]);
}
