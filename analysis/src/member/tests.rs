use super::*;
use crate::world::{graph, set, task};

#[test]
fn a_bound_of_two_graphs_bounds_each() {
    let mut both = task("both", 100, Some(100), &[4, 6, 6], &[(0, 1), (0, 2)]);
    both.versions.push(graph(&[9, 1, 1, 1], &[]));
    let set = set(2, vec![both]);
    let member = Member::of(&set.clusters, &set.tasks[0]);
    let bound = member.parts[0].as_ref().expect("it is here");
    assert_eq!(bound.chains, [10, 6, 1, 1]);
    for shape in &member.shapes {
        let part = shape.parts[0].as_ref().expect("it is here");
        assert!((0..20).all(|x| bound.f(x) >= part.f(x) && bound.capped(x) >= part.capped(x)));
        assert!(part.nodes.iter().all(|node| bound.nodes.contains(node)));
        assert!(part.groups.iter().all(|group| bound.groups.contains(group)));
    }
    assert_eq!((member.cut_at(), bound.work, member.only_cluster()), (110, 16, Some(0)));
}
