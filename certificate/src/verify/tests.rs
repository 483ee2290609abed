use super::*;
use crate::by_hand::{ANY, Claims, certificate, graph, is_of, sealed, set, task, verdict};
use crate::{Proof, Rejected};

/// A diamond, its two graphs, and a task that is not proved.
fn stated() -> (Set, Certificate) {
    let mut diamond = task("diamond", 40, 100, &[1, 2, 3, 0], &[(0, 1), (0, 2), (1, 3), (2, 3)]);
    diamond.versions.push(graph(&[(4, 0)], &[]));
    let mut other = task("other", 10, 1_000, &[1], &[]);
    other.versions[0].nodes[0].cluster = 1;
    let set = set(&[2, 1], vec![diamond, other]);
    let first = Some((8, ANY));
    let claims: [Claims<'_>; 2] =
        [&[(&[0, 1, 0, 0], first), (&[7], Some((4, Proof::Paths { chains: 0 })))], &[(&[0], None)]];
    let certificate = certificate(&set, &claims);
    (set, certificate)
}

#[test]
fn numbers_of_a_graph_are_those_on_paper() {
    let (_, certificate) = stated();
    let VersionProof { work_ns, critical_path_ns, shortest_path_ns, hops, last_key_ns, .. } =
        certificate.tasks[0].versions[0];
    // The node of no cost counts as 1 in sums, and as none in its key.
    assert_eq!((work_ns, critical_path_ns, shortest_path_ns, hops, last_key_ns), (7, 5, 4, 3, 40));
    let (set, _) = stated();
    let shape = Shape::of(&set.tasks[0].versions[0], 40, &set).expect("a graph");
    let keys: Vec<i128> = shape.nodes.iter().map(|node| node.key).collect();
    assert_eq!(keys, [36, 38, 37, 40]);
}

#[test]
fn whatever_is_stated_is_checked() {
    let (set, good) = stated();
    assert_eq!(verify(&good, &set), Ok(()));
    type Change = fn(&mut Certificate);
    let changes: &[(&str, Change)] = &[
        ("version", |c| c.version = 2),
        ("rule", |c| c.rule = "deadline".to_owned()),
        ("workload_sha256", |c| c.workload_sha256 = c.sha256.clone()),
        ("number of tasks", |c| drop(c.tasks.pop())),
        ("name of task diamond", |c| c.tasks[0].name = "d".to_owned()),
        ("name of task diamond", |c| c.tasks.swap(0, 1)),
        ("deadline_ns of task", |c| c.tasks[0].deadline_ns += 1),
        ("number of versions", |c| drop(c.tasks[0].versions.pop())),
        ("work_ns of task", |c| c.tasks[0].versions[0].work_ns += 1),
        ("critical_path_ns", |c| c.tasks[0].versions[0].critical_path_ns -= 1),
        ("shortest_path_ns", |c| c.tasks[0].versions[0].shortest_path_ns += 1),
        ("hops", |c| c.tasks[0].versions[0].hops += 1),
        ("last_key_ns", |c| c.tasks[0].versions[0].last_key_ns = i64::MIN),
        ("length of chain_of", |c| c.tasks[0].versions[0].chain_of.push(0)),
        ("reachability", |c| c.tasks[0].versions[0].chain_of[1] = 0),
        ("number of response times", |c| c.tasks[0].versions[1].response_ns = None),
        ("number of response times", |c| c.tasks[0].response_ns = None),
        ("number of response times", |c| c.tasks[1].versions[0].response_ns = Some(1)),
        ("number of proofs", |c| c.tasks[0].versions[1].proof = None),
        ("number of proofs", |c| c.tasks[1].versions[0].proof = Some(ANY)),
        ("response_ns of task", |c| c.tasks[0].response_ns = Some(7)),
        ("response_ns of task", |c| c.tasks[0].response_ns = Some(9)),
        ("40 at most", |c| {
            c.tasks[0].response_ns = Some(41);
            c.tasks[0].versions[0].response_ns = Some(41);
        }),
        ("4 at least", |c| c.tasks[0].versions[1].response_ns = Some(3)),
        ("number of clusters", |c| drop(c.clusters.pop())),
        ("pool of cluster", |c| c.clusters[0].pool.push('x')),
        ("name of cluster", |c| c.clusters[0].name.push('x')),
        ("lanes of cluster", |c| c.clusters[0].lanes += 1),
        ("tasks of cluster", |c| c.clusters[0].tasks.clear()),
        ("tasks of cluster", |c| c.clusters[1].tasks.push("diamond".to_owned())),
        ("guarantee of cluster", |c| c.clusters[0].guarantee = Guarantee::BestEffort),
        ("guarantee of cluster", |c| c.clusters[1].guarantee = Guarantee::Analytic),
    ];
    for (place, change) in changes {
        let mut changed = good.clone();
        change(&mut changed);
        is_of(verify(&sealed(changed), &set), place);
    }
    let later: &[(&str, Change)] = &[
        ("margin_ns", |c| c.margin_ns = Some(31)),
        ("margin_ns", |c| c.margin_ns = None),
        ("binding", |c| c.binding = "other by A0".to_owned()),
    ];
    for (place, change) in later {
        let mut changed = good.clone();
        change(&mut changed);
        is_of(verify(&changed.sealed(), &set), place);
    }
    let mut open = good.clone();
    open.sha256.replace_range(0..1, if open.sha256.starts_with('0') { "1" } else { "0" });
    is_of(verify(&open, &set), "sha256");
    // What is as true as before: other names of chains, fewer nodes in one, and a longer time.
    let mut other = good;
    other.tasks[0].versions[0].chain_of = vec![9, 1, 9, 2];
    other.tasks[0].versions[0].response_ns = Some(20);
    other.tasks[0].response_ns = Some(20);
    assert_eq!(verify(&sealed(other), &set), Ok(()));
}

/// Of a set that was changed, with the certificate for it.
fn of_changed(change: fn(&mut Set)) -> Result<(), Rejected> {
    let (mut set, mut certificate) = stated();
    change(&mut set);
    certificate.workload_sha256 = set.digest();
    verify(&certificate.sealed(), &set)
}

#[test]
fn who_waits_for_more_than_lanes_is_not_proved() {
    assert_eq!(of_changed(|_| ()), Ok(()));
    is_of(of_changed(|set| set.tasks[0].waits = true), "response_ns of task diamond");
    let share = |set: &mut Set| set.tasks.iter_mut().for_each(|task| task.frames.push("w/f".to_owned()));
    is_of(of_changed(share), "response_ns of task diamond");
    assert_eq!(of_changed(|set| set.tasks[0].frames.push("w/f".to_owned())), Ok(()), "nobody else has it");
}

#[test]
fn a_cluster_has_no_guarantee_beside_a_task_without_proof() {
    assert_eq!(of_changed(|_| ()), Ok(()), "it has a cluster of its own");
    let share = |certificate: &mut Certificate| {
        certificate.clusters[1].guarantee = Guarantee::Analytic;
    };
    let (set, mut certificate) = stated();
    share(&mut certificate);
    is_of(verify(&certificate.sealed(), &set), "guarantee of cluster");
}

#[test]
fn a_set_that_is_none_proves_nothing() {
    let (good, certificate) = stated();
    type Change = fn(&mut Set);
    let changes: &[(&str, Change)] = &[
        ("a cluster without lanes", |s| s.clusters[1].lanes = 0),
        ("a task without a graph", |s| s.tasks[0].versions.clear()),
        ("a graph without nodes", |s| s.tasks[0].versions[1].nodes.clear()),
        ("a cluster that is not there", |s| s.tasks[0].versions[0].nodes[1].cluster = 2),
        ("an edge of a node that is not there", |s| s.tasks[0].versions[0].edges.push((0, 4))),
        ("a cycle", |s| s.tasks[0].versions[0].edges.push((3, 0))),
        ("a least time between releases", |s| s.tasks[1].period_ns = Some(0)),
    ];
    for (wrong, change) in changes {
        let mut set = good.clone();
        change(&mut set);
        let mut certificate = certificate.clone();
        certificate.workload_sha256 = set.digest();
        let error = verify(&certificate.sealed(), &set);
        assert!(matches!(error, Err(Rejected::Set { .. })), "{error:?}");
        is_of(error, wrong);
    }
    let mut long = set(&[1], vec![task("job", 1 << 42, 1 << 43, &[1], &[])]);
    assert_eq!(verdict(&long, &[(1, ANY)]), Ok(()));
    long.tasks[0].deadline_ns += 1;
    is_of(verdict(&long, &[(1, ANY)]), "73 minutes");
    // Without a proof there is nothing to refuse, however large the numbers are.
    let huge = set(&[u32::MAX], vec![task("job", u64::MAX, 1, &[u64::MAX, u64::MAX], &[(0, 1)])]);
    let mut nothing = crate::by_hand::certificate(&huge, &[&[(&[0, 0], None)]]);
    let VersionProof { work_ns, critical_path_ns, shortest_path_ns, .. } = &mut nothing.tasks[0].versions[0];
    (*work_ns, *critical_path_ns, *shortest_path_ns) = (u64::MAX, u64::MAX, u64::MAX);
    nothing.tasks[0].versions[0].last_key_ns = 0;
    assert_eq!(verify(&nothing.sealed(), &huge), Ok(()));
}
