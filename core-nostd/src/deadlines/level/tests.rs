use super::*;
use crate::{Caps, Dag, Node, PoolId, Wcet};

type Small = Caps<1, 16, 1, 4, 2>;

fn layered(levels: &[&[u64]]) -> Dag<Small> {
    let mut dag = Dag::new();
    let mut before = Vec::new();
    for level in levels {
        let here: Vec<_> =
            level.iter().map(|c| dag.add_node(Node::new(Wcet::from_nanos(*c))).unwrap()).collect();
        for from in &before {
            for to in &here {
                dag.add_edge(*from, *to).unwrap();
            }
        }
        before = here;
    }
    dag
}

fn ends(dag: &Dag<Small>, rule: DeadlineRule, d: u64, lanes: &[u8]) -> Vec<u64> {
    let levels = Levels::of(dag);
    let shares = shares(&levels, rule, Duration::from_nanos(d), lanes);
    (0..levels.count()).map(|h| shares[h].end).collect()
}

#[test]
fn shares_of_an_indivisible_budget_still_sum_to_it() {
    let dag = layered(&[&[1], &[1], &[1]]);
    assert_eq!(ends(&dag, DeadlineRule::LevelSum, 100, &[1]), [33, 66, 100]);
}

#[test]
fn zero_costs_weigh_one_per_level() {
    let dag = layered(&[&[0], &[0], &[0, 0]]);
    assert_eq!(ends(&dag, DeadlineRule::LevelSum, 9, &[1]), [3, 6, 9]);
    assert_eq!(ends(&dag, DeadlineRule::LevelGraham, 9, &[2]), [3, 6, 9]);
}

#[test]
fn graham_shares_cover_the_bound_of_each_level_and_divide_the_rest() {
    // m = 2: level 0: g = 4, w = 8; level 1: g = 2 + 1 = 3, w = 2 * 2 + 2 = 6; D = 14 leaves 7.
    let dag = layered(&[&[4], &[2, 2]]);
    assert_eq!(ends(&dag, DeadlineRule::LevelGraham, 14, &[2]), [8, 14]);
    // D = 6 is below the sum of the bounds: divided by w alone.
    assert_eq!(ends(&dag, DeadlineRule::LevelGraham, 6, &[2]), [3, 6]);
}

#[test]
fn a_task_in_two_pools_takes_the_larger_bound_of_each_level() {
    let mut dag = Dag::<Small>::new();
    let cpu = dag.add_node(Node::new(Wcet::from_nanos(6))).unwrap();
    let gpu = dag.add_node(Node::new(Wcet::from_nanos(4)).in_pool(PoolId::new(1))).unwrap();
    let last = dag.add_node(Node::new(Wcet::from_nanos(2))).unwrap();
    dag.add_edge(cpu, last).unwrap();
    dag.add_edge(gpu, last).unwrap();
    // Level 0: max(6, 4) = 6, level 1: 2; D = 16 leaves 8, divided 6 : 2.
    assert_eq!(ends(&dag, DeadlineRule::LevelGraham, 16, &[1, 1]), [12, 16]);
}
