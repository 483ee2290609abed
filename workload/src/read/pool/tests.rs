use crate::Refusal::{Conflict, Range, Reference};
use crate::fixtures::{accepted, refused};
use crate::model::Work;

/// A workload with a divided pool, an undivided one, and a task with a node in each.
fn divided(clusters: &str, cluster: &str) -> String {
    format!(
        "[[pool]]\nname = \"gpu\"\nlanes = 3\ncpus = [4, 5, 6]\n{clusters}\n[[pool]]\nname = \"cpu\"\nlanes = 1\n\
         [[task]]\nname = \"t\"\ndeadline = \"1s\"\nperiod = \"1s\"\n{cluster}\n\
         node = [{{ name = \"a\", wcet = \"1ms\" }}, {{ name = \"b\", wcet = \"1ms\", pool = \"cpu\" }}]\n\
         [[event]]\nat = \"1s\"\ntask = \"t\"\nadd = [{{ name = \"c\", wcet = \"1ms\", pool = \"gpu\" }}]\n"
    )
}

const CLUSTERS: &str = "clusters = [{ name = \"near\", lanes = 1 }, { name = \"far\", lanes = 2 }]";

#[test]
fn a_cluster_is_a_pool_of_its_own_with_its_share_of_lanes_and_cpus() {
    let workload = accepted(&divided(CLUSTERS, "cluster = \"far\""));
    let pools: Vec<_> = workload.pools.iter().map(|p| (&*p.name, p.lanes, &p.cpus[..])).collect();
    assert_eq!(pools, [("gpu.near", 1, &[4][..]), ("gpu.far", 2, &[5, 6][..]), ("cpu", 1, &[][..])]);
    let pool = |work: &Work| match work {
        Work::Plain(part) => part.pool,
        Work::Stage(stage) => stage.encoder.pool,
    };
    let nodes: Vec<usize> = workload.tasks[0].nodes.iter().map(|node| pool(&node.work)).collect();
    assert_eq!((nodes, pool(&workload.events[0].add[0].work)), (vec![1, 2], 1));
}

#[test]
fn a_task_that_names_no_cluster_is_in_the_first() {
    let workload = accepted(&divided(CLUSTERS, ""));
    assert!(matches!(&workload.tasks[0].nodes[0].work, Work::Plain(part) if part.pool == 0));
}

#[test]
fn clusters_have_the_lanes_of_their_pool_and_no_budget() {
    let less = "clusters = [{ name = \"near\", lanes = 1 }]";
    let more = "clusters = [{ name = \"near\", lanes = 2 }, { name = \"far\", lanes = 2 }]";
    let budget = format!("memory = \"1MiB\"\n{CLUSTERS}");
    for (clusters, kind) in [(less, Range), (more, Range), (&*budget, Conflict), ("clusters = []", Range)] {
        assert_eq!(refused(&divided(clusters, "")).refusal, kind, "{clusters}");
    }
}

#[test]
fn a_cluster_that_is_not_there_is_named_with_the_nearest() {
    let error = refused(&divided(CLUSTERS, "cluster = \"fat\""));
    assert!(error.refusal == Reference && error.to_string().contains("`far`"), "{error}");
    assert_eq!(refused(&divided("", "cluster = \"far\"")).refusal, Reference);
}
