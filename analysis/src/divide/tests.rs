use super::*;
use crate::world::{Rng, random, set, task};

#[test]
fn lanes_of_their_own_prove_what_a_common_pool_does_not() {
    // Two long ones may have both lanes when a short one comes.
    let tasks = vec![
        task("long", 100, Some(100), &[30], &[]),
        task("longer", 100, Some(100), &[40], &[]),
        task("short", 10, Some(100), &[5], &[]),
    ];
    let set = set(2, tasks);
    let (divided, certificate) = divide(&set, &prove(&set), |_, _| true).expect("a division");
    assert!(certificate.is_analytic());
    let clusters: Vec<(&str, u32)> = divided.clusters.iter().map(|c| (&*c.name, c.lanes)).collect();
    assert_eq!(clusters, [("c1", 1), ("c2", 1)]);
    let of = |i: usize| divided.tasks[i].versions[0].nodes[0].cluster;
    assert!(of(0) == of(1) && of(0) != of(2));
}

#[test]
fn what_is_proved_stays_as_it_is() {
    let set = set(2, vec![task("a", 100, Some(100), &[5], &[]), task("b", 100, Some(100), &[5], &[])]);
    assert_eq!(divide(&set, &prove(&set), |_, _| true), None);
}

#[test]
fn a_division_keeps_lanes_and_tasks_and_the_other_pools() {
    let (rng, mut found) = (&mut Rng(11), 0);
    for _ in 0..300 {
        let mut set = random(rng, 1, 70, 100);
        set.clusters[0].lanes += 1;
        let mut other = task("other", 50, Some(50), &[5], &[]);
        other.versions[0].nodes[0].cluster = 1;
        set.tasks.push(other);
        set.clusters.push(Cluster { pool: "z".to_owned(), name: "z".to_owned(), lanes: 1 });
        let Some((divided, certificate)) = divide(&set, &prove(&set), |_, _| true) else { continue };
        found += 1;
        let lanes = |set: &Set| set.clusters.iter().map(|cluster| cluster.lanes).sum::<u32>();
        assert_eq!((lanes(&divided), divided.tasks.len()), (lanes(&set), set.tasks.len()));
        let last = divided.clusters.len() - 1;
        assert_eq!(divided.clusters[last], set.clusters[1]);
        assert_eq!(divided.tasks[set.tasks.len() - 1].versions[0].nodes[0].cluster, last);
        assert_eq!(certificate, prove(&divided));
    }
    assert!(found > 10, "{found}");
}

#[test]
fn a_division_that_is_refused_leaves_the_other_one() {
    let (rng, mut found) = (&mut Rng(5), 0);
    for _ in 0..200 {
        let mut set = random(rng, 1, 70, 100);
        set.clusters[0].lanes += 1;
        let proved = prove(&set);
        let Some(first) = divide(&set, &proved, |_, _| true) else { continue };
        let other = divide(&set, &proved, |divided, _| *divided != first.0);
        assert_ne!(other.as_ref().map(|(divided, _)| divided), Some(&first.0));
        found += usize::from(other.is_some());
        assert_eq!(divide(&set, &proved, |_, _| false), None);
    }
    assert!(found > 0);
}
