use super::*;
use crate::oracle::Policy;

#[test]
fn the_first_numbers_of_seed_0_are_the_published_ones() {
    let mut rng = Rng::new(0);
    assert_eq!([rng.bits(), rng.bits()], [0xE220_A839_7B1D_CDAF, 0x6E78_9E6A_A1B9_65F4]);
}

#[test]
fn equal_seeds_give_equal_workloads() {
    let shape = Shape::default();
    assert_eq!(random_workload(3, &shape), random_workload(3, &shape));
    assert_ne!(random_workload(3, &shape), random_workload(4, &shape));
}

/// Every version of every graph, whole and refined, is acyclic and no larger than allowed.
#[test]
fn graphs_are_valid_under_every_policy() {
    for seed in 0..300 {
        let workload = random_workload(seed, &Shape::default());
        for (index, task) in workload.tasks.iter().enumerate() {
            let mut nodes = task.nodes.clone();
            for event in workload.events.iter().filter(|event| event.task == index) {
                nodes = crate::graph::edited(&nodes, &[event]);
                for policy in Policy::ALL {
                    assert!(Graph::of(&nodes, policy.refines()).nodes.len() <= 256);
                }
            }
        }
    }
}

#[test]
fn everything_that_a_shape_allows_appears() {
    let all: Vec<Workload> = (0..200).map(|seed| random_workload(seed, &Shape::default())).collect();
    let some = |what: fn(&Workload) -> bool| all.iter().any(what);
    assert!(some(|workload| workload.pools.len() == 2));
    assert!(some(|workload| workload.pools.iter().any(|pool| pool.memory_bytes.is_some())));
    assert!(some(|workload| !workload.events.is_empty()));
    assert!(some(|workload| workload.sync.is_some()));
    assert!(some(|workload| !workload.sensors.is_empty()));
    assert!(some(|workload| workload.tasks.iter().any(|task| task.floor.is_some())));
    assert!(some(|workload| workload.tasks.iter().any(|task| task.arrival == Arrival::Once)));
    let stages = |task: &Task| task.nodes.iter().any(|node| matches!(node.work, Work::Stage(_)));
    assert!(all.iter().any(|workload| workload.tasks.iter().any(stages)));
}
