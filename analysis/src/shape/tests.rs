use super::*;
use crate::world::{graph, set};

fn shape(costs: &[u64], edges: &[(usize, usize)]) -> Shape {
    Shape::of(&set(2, Vec::new()).clusters, 100, &graph(costs, edges))
}

#[test]
fn a_diamond_has_its_paths_chains_and_keys() {
    let diamond = shape(&[2, 5, 3, 4], &[(0, 1), (0, 2), (1, 3), (2, 3)]);
    assert_eq!((diamond.longest, diamond.shortest, diamond.hops), (11, 9, 3));
    let part = diamond.parts[0].as_ref().expect("it is here");
    assert_eq!((part.work, &part.chains[..]), (14, &[11, 3][..]));
    assert_eq!(diamond.chain_of, [0, 0, 1, 0]);
    // Keys 89, 91, 93, 96: the last is that of the sink.
    assert_eq!(diamond.last_key, 96);
    assert_eq!(part.groups, [(89, 2), (91, 7), (93, 10), (96, 14)]);
}

#[test]
fn chains_never_run_twice_at_once() {
    let part = shape(&[4, 4, 2], &[]).parts.remove(0).expect("it is here");
    // In 3: two lanes are busy for 6, and chains give 3 + 3 + 2.
    assert_eq!((part.f(3), part.capped(3), part.beyond(3)), (6, 8, 1));
    assert_eq!((part.f(0), part.f(-1), part.f(100)), (0, 0, 10));
}
