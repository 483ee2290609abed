use super::{VertexSet, find_cycle};

fn graph(vertices: usize, edges: &[(usize, usize)]) -> Vec<VertexSet> {
    let mut successors = vec![VertexSet::default(); vertices];
    for (from, to) in edges {
        successors[*from].insert(*to);
    }
    successors
}

#[test]
fn a_graph_without_cycle_has_none() {
    assert_eq!(find_cycle(&[]), None);
    assert_eq!(find_cycle(&graph(4, &[(0, 1), (0, 2), (1, 3), (2, 3)])), None);
    let all: Vec<_> = (0..256).flat_map(|from| (from + 1..256).map(move |to| (from, to))).collect();
    assert_eq!(find_cycle(&graph(256, &all)), None);
}

#[test]
fn a_cycle_is_given_in_the_order_of_its_edges() {
    assert_eq!(find_cycle(&graph(3, &[(0, 1), (1, 2), (2, 1)])), Some(vec![1, 2]));
    let ring: Vec<_> = (0..256).map(|vertex| (vertex, (vertex + 1) % 256)).collect();
    assert_eq!(find_cycle(&graph(256, &ring)), Some((0..256).collect()));
    assert_eq!(find_cycle(&graph(130, &[(129, 64), (64, 129), (0, 1)])), Some(vec![64, 129]));
}
