//! Graphs: made, changed, looked at.

use super::{Block, Graph, headed, node, ok};
use crate::*;
use core::ptr;

fn encoder() -> red_node {
    red_node { role: red_role::SharedEncoder as u32, ..node(4) }
}

fn decoder() -> red_node {
    red_node { role: red_role::Decoder as u32, ..node(1) }
}

/// What leaves a node, into room for so many.
fn successors(graph: &Graph, node: u32, room: usize) -> (red_status, usize, Vec<u32>) {
    let (found, mut count) = (Block::<u32>::of(room), 0);
    let status = red_dag_successors(graph.at(), node, found.pointer(), room, &raw mut count);
    let written = if status == red_status::Ok { count } else { 0 };
    (status, count, (0..written).map(|i| found.get(i)).collect())
}

#[test]
fn edges_and_nodes_come_and_go() {
    let mut graph = Graph::new();
    let (camera, network) = (graph.add(node(2)), graph.add(node(8)));
    graph.edge(camera, network);
    let at = graph.at_mut();
    assert_eq!(red_dag_add_edge(at, camera, network), red_status::DuplicateEdge);
    assert_eq!(red_dag_add_edge(at, network, camera), red_status::Cycle);
    assert_eq!(red_dag_add_edge(at, network, RED_NONE), red_status::UnknownNode);
    assert_eq!(red_dag_remove_edge(at, network, camera), red_status::UnknownEdge);
    ok(red_dag_remove_edge(at, camera, network));
    ok(red_dag_remove_node(at, network));
    assert_eq!(red_dag_remove_node(at, network), red_status::UnknownNode);
    let (one, other, reader) = (graph.add(encoder()), graph.add(encoder()), graph.add(decoder()));
    graph.edge(one, reader);
    assert_eq!(red_dag_add_edge(graph.at_mut(), other, reader), red_status::SecondEncoder);
    let mut number = 0;
    while red_dag_add_node(graph.at_mut(), &raw const WEIGHTLESS, &raw mut number) == red_status::Ok {}
    let mut summary = headed!(red_dag_summary {});
    ok(red_dag_summarize(graph.at(), &raw mut summary));
    assert_eq!((summary.nodes, summary.levels, summary.work_ns, summary.critical_path_ns), (16, 2, 11, 5));
    graph.close();
}

static WEIGHTLESS: red_node = headed!(red_node { sensor: RED_NONE });

#[test]
fn a_stage_is_refined() {
    let mut graph = Graph::new();
    let (camera, stage, control) = (graph.add(node(1)), graph.add(node(9)), graph.add(node(1)));
    graph.edge(camera, stage);
    graph.edge(stage, control);
    let decoders = Block::holding(&[decoder(), red_node { wcet_ns: 2, ..decoder() }]);
    let (from, mut number, shared) = (decoders.pointer(), RED_NONE, encoder());
    ok(red_dag_refine(graph.at_mut(), stage, &raw const shared, from, 2, &raw mut number));
    assert_eq!(number, stage);
    assert_eq!(successors(&graph, stage, 2), (red_status::Ok, 2, vec![2, 3]));
    assert_eq!(successors(&graph, stage, 1), (red_status::TooShort, 2, vec![]));
    assert_eq!(successors(&graph, 9, 1).0, red_status::UnknownNode);
    let mut told = headed!(red_node {});
    ok(red_dag_node(graph.at(), 3, &raw mut told));
    assert_eq!((told.role, told.wcet_ns), (red_role::Decoder as u32, 2));
    graph.close();
}

#[test]
fn a_deadline_is_divided_and_proved() {
    let mut graph = Graph::new();
    for (i, cost) in [20, 20, 40].into_iter().enumerate() {
        graph.add(node(cost));
        if let Some(before) = (i as u32).checked_sub(1) {
            graph.edge(before, before + 1);
        }
    }
    let (placed, levels) = (Block::<red_placed_node>::of(3), Block::<red_level>::of(3));
    let (lanes, budgets, mut count) = (Block::holding(&[1, 2]), Block::holding(&[RED_NONE_64, 5]), 0);
    let (rule, by_pool, at) = (red_rule::LevelSum as u32, lanes.pointer(), graph.at());
    ok(red_dag_place(at, rule, 120, by_pool, 2, placed.pointer(), 3, &raw mut count));
    assert_eq!(((0..3).map(|i| placed.get(i).sub_deadline_ns)).collect::<Vec<_>>(), [30, 60, 120]);
    ok(red_dag_share(at, rule, 120, ptr::null(), 0, levels.pointer(), 3, &raw mut count));
    assert_eq!((count, levels.get(2).end_ns), (3, 120));
    let short = Block::<red_level>::of(2);
    let status = red_dag_share(at, rule, 120, by_pool, 1, short.pointer(), 2, &raw mut count);
    assert_eq!((status, count), (red_status::TooShort, 3));
    let mut proof = headed!(red_certificate {});
    ok(red_dag_prove(at, 120, by_pool, budgets.pointer(), 2, &raw mut proof));
    assert_eq!((proof.fits, proof.response_ns, proof.margin_ns), (1, 80, 40));
    let no_budgets = red_dag_prove(at, 120, by_pool, ptr::null(), 2, &raw mut proof);
    assert_eq!(no_budgets, red_status::NullPointer);
    graph.close();
}

#[test]
fn while_a_call_goes_on_another_one_is_busy() {
    let mut graph = Graph::new();
    {
        let _call = crate::handles::graph(graph.handle.bits).and_then(|graph| graph.enter());
        assert_eq!(red_dag_add_edge(graph.at_mut(), 0, 1), red_status::Busy);
        assert_eq!(successors(&graph, 0, 1).0, red_status::Busy);
        assert_eq!(red_dag_close(graph.at_mut()), red_status::Busy);
    }
    graph.add(node(1));
    graph.close();
}
