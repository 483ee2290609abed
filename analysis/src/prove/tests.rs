use super::*;
use crate::world::{Rng, random, responses, set, task};

fn bounds(set: &Set) -> Vec<Option<u64>> {
    prove(set).tasks.iter().map(|task| task.response_ns).collect()
}

/// Proves random sets, and runs what is proved. (proved sets, tasks that were proved, runs that met their bound exactly)
fn trial(seed: u64, sets: u64, clusters: usize, most_deadline: u64) -> (u64, u64, u64) {
    scaled_trial(seed, sets, clusters, most_deadline, 1)
}

/// With times in units of so many nanoseconds.
fn scaled_trial(seed: u64, sets: u64, clusters: usize, most_deadline: u64, unit: u64) -> (u64, u64, u64) {
    let rng = &mut Rng(seed);
    let (mut proved, mut tasks, mut exact) = (0, 0, 0);
    for nth in 0..sets {
        let load = rng.within(10, 80);
        let set = in_units_of(unit, random(rng, clusters, load, most_deadline));
        let certificate = prove(&set);
        let kept: Vec<bool> = certificate.tasks.iter().map(|task| task.response_ns.is_some()).collect();
        proved += u64::from(certificate.is_analytic());
        tasks += kept.iter().filter(|kept| **kept).count() as u64;
        if !kept.contains(&true) {
            continue;
        }
        for _ in 0..6 {
            for (task, worst) in certificate.tasks.iter().zip(responses(rng, &set, &kept)) {
                let Some(bound) = task.response_ns else { continue };
                assert!(
                    worst <= bound,
                    "seed {seed}, set {nth}: {worst} > {bound} of {} in {set:?}: {task:?}",
                    task.name
                );
                exact += u64::from(worst == bound);
            }
        }
    }
    (proved, tasks, exact)
}

fn in_units_of(unit: u64, mut set: Set) -> Set {
    for task in &mut set.tasks {
        task.deadline_ns *= unit;
        task.period_ns = task.period_ns.map(|period| period * unit);
        let nodes = task.versions.iter_mut().flat_map(|graph| &mut graph.nodes);
        nodes.for_each(|node| node.cost_ns *= unit);
    }
    set
}

/// Whether runs show that bounds of a search which lacks something are too short.
fn shows(lacks: impl Fn(&mut Search)) -> bool {
    let rng = &mut Rng(5);
    (0..2_000).any(|_| {
        let load = rng.within(20, 60);
        let set = random(rng, 1, load, 100);
        let mut search = Search::of(&set);
        lacks(&mut search);
        let (bounds, proofs) = search.run();
        let kept: Vec<bool> = proofs.iter().map(Option::is_some).collect();
        (0..4).any(|_| {
            let worst = responses(rng, &set, &kept);
            (0..bounds.len()).any(|k| kept[k] && i128::from(worst[k]) > bounds[k])
        })
    })
}

#[test]
fn what_a_proof_leaves_out_shows_in_runs() {
    assert!(!shows(|_| ()));
    let parts = |search: &mut Search, of: fn(&mut Part)| {
        search.members.iter_mut().flat_map(|member| &mut member.parts).flatten().for_each(of);
    };
    assert!(shows(|search| parts(search, |part| part.nodes.clear())), "nodes of lower rank that had started");
    assert!(shows(|search| parts(search, |part| part.groups.truncate(1))), "nodes of later groups");
    let more = |search: &mut Search| search.lanes.iter_mut().for_each(|lanes| *lanes += 1);
    assert!(shows(more), "a lane that is not there");
    let shorter = |search: &mut Search| {
        search.members.iter_mut().flat_map(|member| &mut member.shapes).for_each(|shape| shape.longest /= 2);
    };
    assert!(shows(shorter), "half of the longest path");
    let rarer = |search: &mut Search| {
        search.members.iter_mut().for_each(|member| member.period = member.period.map(|period| 2 * period));
    };
    assert!(shows(rarer), "every other job");
}

#[test]
fn times_in_nanoseconds_are_proved_as_well_as_small_numbers() {
    let (small, large) = (trial(9, 400, 1, 100), scaled_trial(9, 400, 1, 100, 1_000_003));
    assert!(large.0 * 100 >= small.0 * 98, "{small:?} {large:?}");
}

#[test]
fn no_response_is_longer_than_what_is_proved_in_one_cluster() {
    let (proved, tasks, exact) = trial(1, 3_000, 1, 100);
    assert!(proved > 300 && tasks > 2_000 && exact > 300, "{proved} {tasks} {exact}");
}

#[test]
fn no_response_is_longer_than_what_is_proved_where_jobs_overlap() {
    let (proved, tasks, exact) = trial(2, 2_000, 1, 250);
    assert!(proved > 100 && tasks > 500 && exact > 10, "{proved} {tasks} {exact}");
}

#[test]
fn no_response_is_longer_than_what_is_proved_in_several_clusters() {
    let (proved, tasks, exact) = trial(3, 2_000, 2, 100);
    assert!(proved > 50 && tasks > 300 && exact > 10, "{proved} {tasks} {exact}");
}

#[test]
fn a_task_alone_has_grahams_bound_or_a_better_one() {
    // L = 5, W = 13 on two lanes: 5 + (13 - 5) / 2 = 9.
    let graph = task("alone", 20, Some(20), &[5, 4, 4], &[]);
    assert_eq!(bounds(&set(2, vec![graph])), [Some(9)]);
    // Chains of 4, 4 and 4 on two lanes: the second has the other lane, so 4 + 4.
    assert_eq!(bounds(&set(2, vec![task("alone", 20, Some(20), &[4, 4, 4], &[])])), [Some(8)]);
}

#[test]
fn on_one_lane_it_is_the_test_of_non_preemptive_edf() {
    // C = 2, 3, 4 with D = T = 7, 12, 20 (U = 0.736): with latest-start keys of single nodes EDF by deadline less cost.
    let of = |name: &str, cost, period| task(name, period, Some(period), &[cost], &[]);
    let found = bounds(&set(1, vec![of("a", 2, 7), of("b", 3, 12), of("c", 4, 20)]));
    // The fast one waits for the longest of the others, which began a moment before: 4 - 1 + 2 = 5 would be the least.
    assert!(found[0] >= Some(6) && found.iter().all(Option::is_some), "{found:?}");
}

#[test]
fn what_began_when_the_chain_moved_on_is_counted() {
    // Two lanes, a chain of two nodes; a low job released after it takes lane 2, a high node arrives as the first one ends.
    let chain = task("chain", 40, Some(100), &[5, 5], &[(0, 1)]);
    let low = task("low", 90, Some(100), &[30], &[]);
    let high = task("high", 12, Some(100), &[10], &[]);
    let found = bounds(&set(2, vec![chain, low, high]));
    assert!(
        found[0] >= Some(20),
        "5 of its own, 10 of the high one beside 30 of the low one, 5 again: {found:?}"
    );
}

#[test]
fn an_unproved_task_does_not_take_the_proof_of_others() {
    // The second cannot be in time at all; it is cut at its deadline.
    let good = task("good", 100, Some(100), &[5], &[]);
    let bad = task("bad", 10, Some(100), &[11], &[]);
    let found = bounds(&set(1, vec![good, bad]));
    assert!(found[0].is_some() && found[1].is_none(), "{found:?}");
    let certificate = prove(&set(1, vec![task("bad", 10, Some(100), &[11], &[])]));
    assert_eq!(certificate.clusters[0].guarantee, Guarantee::BestEffort);
}

#[test]
fn numbers_beyond_what_sums_can_hold_prove_nothing() {
    let of = |ns: u64| bounds(&set(1, vec![task("long", ns, Some(ns), &[ns / 2], &[])]));
    assert_eq!(of(1 << 42), [Some(1 << 41)]);
    assert_eq!(of((1 << 42) + 1), [None]);
    assert_eq!(bounds(&set(1, vec![task("heavy", 1 << 62, None, &[u64::MAX, u64::MAX], &[])])), [None]);
}

#[test]
fn a_scheduler_that_may_be_full_proves_nothing() {
    let often = |jobs| {
        let mut set = set(1, vec![task("often", 95, Some(10), &[1], &[])]);
        set.most_jobs = jobs;
        bounds(&set)
    };
    assert!(often(1) == [Some(1)] && often(0) == [None]);
}

#[test]
fn tasks_that_share_a_result_are_proved_together_or_not_at_all() {
    let good = || task("good", 100, Some(100), &[5], &[]);
    let bad = || task("bad", 10, Some(100), &[11], &[]);
    let mut sharing = [good(), bad()];
    sharing.iter_mut().for_each(|task| task.frames.push("mimo/front".to_owned()));
    assert!(bounds(&set(1, vec![good(), bad()]))[0].is_some());
    assert_eq!(bounds(&set(1, sharing.to_vec())), [None, None]);
}

#[test]
fn nothing_is_proved_of_a_task_that_waits_for_something_else() {
    let waits = certificate::Task { waits: true, ..task("waits", 100, Some(100), &[5], &[]) };
    assert_eq!(bounds(&set(1, vec![waits])), [None]);
}

#[test]
fn beside_a_task_without_proof_only_other_lanes_are_safe() {
    let of = |cluster| {
        let good = task("good", 100, Some(100), &[5], &[]);
        let mut bad = task("bad", 10, Some(100), &[11], &[]);
        bad.versions[0].nodes[0].cluster = cluster;
        let mut set = set(1, vec![good, bad]);
        set.clusters.push(certificate::Cluster { name: "other".to_owned(), ..set.clusters[0].clone() });
        prove(&set).clusters.iter().map(|cluster| cluster.guarantee).collect::<Vec<_>>()
    };
    assert_eq!(of(0)[0], Guarantee::BestEffort);
    assert_eq!(of(1), [Guarantee::Analytic, Guarantee::BestEffort]);
}

#[test]
fn a_certificate_is_sealed() {
    let certificate = prove(&set(1, vec![task("alone", 20, Some(20), &[5], &[])]));
    assert_eq!(certificate.sha256, certificate.checksum());
    let changed = Certificate { rule: "other".to_owned(), ..certificate.clone() };
    assert_ne!(changed.sha256, changed.checksum());
}

#[test]
fn two_chains_on_one_lane_are_proved_whatever_the_unit_of_time() {
    for unit in [1, 1_000, 1_000_000] {
        let of = |name: &str, period: u64| {
            task(name, period * unit, Some(period * unit), &[2 * unit, 3 * unit], &[(0, 1)])
        };
        let found = bounds(&set(1, vec![of("fast", 20), of("slow", 40)]));
        assert_eq!(found, [Some(8 * unit), Some(10 * unit)], "{unit}");
    }
}
