use super::*;

/// FNV-1a over the edges in the order of their sources, then of their insertion.
fn fingerprint(graph: &Graph) -> u64 {
    let edges = graph.successors.iter().enumerate();
    let words = edges.flat_map(|(from, list)| list.iter().flat_map(move |&to| [from as u64, u64::from(to)]));
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x100_0000_01b3))
}

#[test]
fn graphs_are_those_that_the_published_figures_were_taken_on() {
    let found: Vec<_> = Graph::all().iter().map(|g| (g.name, g.nodes(), fingerprint(g))).collect();
    assert_eq!(
        found,
        [
            ("chain256", 256, 0x4b3d_fa59_7489_2b62),
            ("forkjoin64", 66, 0x3ac0_3ec6_4372_0de5),
            ("layered256", 256, 0x856e_3c1c_b354_c155),
            ("mimonet6", 6, 0x828d_bd71_7a81_1899),
        ]
    );
}

#[test]
fn ideal_of_two_lanes_halves_only_the_parallel_part() {
    let makespan = |name| Graph::named(name).map(|graph| graph.makespan(2));
    assert_eq!(makespan("forkjoin64"), Some(34));
    assert_eq!(makespan("mimonet6"), Some(4));
    assert_eq!(makespan("chain256"), Some(256));
}
