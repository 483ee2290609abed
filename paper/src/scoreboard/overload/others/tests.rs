use super::*;
use crate::scoreboard::overload::load::{Shape, Times};
use crate::scoreboard::overload::rules::Rule as Any;
use crate::scoreboard::sets::{Graph, Task};

/// Chains on one lane: costs, release, deadline and value of one job each.
fn set(jobs: &[(&[u64], u64, u64, u32)]) -> Set {
    let mut set = Set::of(1, Times::Wcet);
    for (costs, release, deadline_ns, value) in jobs {
        let mut graph = Graph { costs: costs.to_vec(), successors: vec![Vec::new(); costs.len()] };
        (1..costs.len()).for_each(|to| graph.link(to - 1, to));
        let task = Task { graph, period_ns: 1_000, deadline_ns: *deadline_ns };
        set.add(task, *value, None, vec![*release], 0);
    }
    set
}

fn on_time(set: &Set, other: Other) -> Vec<bool> {
    drive(set, other).fates.iter().map(|fates| fates[0].on_time).collect()
}

#[test]
fn the_highest_value_goes_first_and_the_highest_density_before_a_large_job() {
    let set = set(&[(&[9], 0, 10, 9), (&[1], 0, 10, 2), (&[1], 0, 10, 2)]);
    assert_eq!(on_time(&set, Other::Value), [true, true, false]);
    assert_eq!(on_time(&set, Other::Density), [false, true, true]);
}

#[test]
fn robust_edf_rejects_the_least_value_that_makes_room_and_takes_it_back_when_there_is_time() {
    let crowded = set(&[(&[5], 0, 8, 3), (&[5], 0, 9, 1), (&[5], 0, 10, 2)]);
    assert_eq!(on_time(&crowded, Other::Robust), [true, false, true]);
    // The second is late only if the first takes its mean, and the first takes half of it.
    let mut early = Set::of(1, Times::Bimodal);
    for (deadline_ns, value) in [(100, 2), (110, 1)] {
        let graph = Graph { costs: vec![100], successors: vec![Vec::new()] };
        early.add(Task { graph, period_ns: 1_000, deadline_ns }, value, None, vec![0], 0);
    }
    assert_eq!((early.time(0, 0, 0), early.mean(0, 0)), (50, 60), "of this seed");
    assert_eq!(on_time(&early, Other::Robust), [true, true]);
}

#[test]
fn d_over_changes_over_for_more_than_all_that_is_at_risk_and_else_gives_the_newcomer_up() {
    let of = |value| set(&[(&[5, 5], 0, 12, 1), (&[5], 1, 11, value)]);
    // k is 20 and 4, so that the newcomer has to be worth 5.5 and 3.
    assert_eq!(on_time(&of(10), Other::DOver), [false, true]);
    assert_eq!(on_time(&of(2), Other::DOver), [true, false]);
    // Where both fit, the one that is due first goes first.
    assert_eq!(on_time(&set(&[(&[5, 5], 0, 30, 1), (&[5], 1, 11, 1)]), Other::DOver), [true, true]);
}

/// What each schedule has to obey, those of the product too.
#[test]
fn no_schedule_has_more_nodes_than_lanes_or_one_before_its_predecessors() {
    for (seed, shape) in (1..=4).flat_map(|seed| Shape::ALL.map(|shape| (seed, shape))) {
        let (lanes, times) = ([1, 2, 4][seed as usize % 3], Times::ALL[seed as usize % 3]);
        let set = Set::draw(shape, lanes, 1.5, times, seed);
        for rule in Any::ALL {
            let (ends, at) = (rule.run(&set).unwrap(), format!("{rule:?} {shape:?} {seed}"));
            check(&set, &ends, &at);
        }
    }
}

fn check(set: &Set, ends: &Ends, at: &str) {
    let mut changes: Vec<(u64, i32)> =
        ends.spans.iter().flat_map(|span| [(span.start, 1), (span.end, -1)]).collect();
    changes.sort_unstable();
    let mut busy = 0;
    for (_, change) in changes {
        busy += change;
        assert!(busy <= set.lanes.into(), "{at}");
    }
    let mut found = std::collections::BTreeMap::new();
    for span in &ends.spans {
        assert_eq!(span.end - span.start, set.time(span.task, span.job, span.node), "{at}");
        assert!(span.start >= set.releases[span.task][span.job as usize], "{at}");
        assert!(found.insert((span.task, span.job, span.node), *span).is_none(), "twice: {at}");
    }
    let missed = ends.fates.iter().flatten().filter(|fate| !fate.on_time).count() as u64;
    assert_eq!((missed, ends.jobs), (ends.missed, set.jobs().count() as u64), "{at}");
    for (task, job) in set.jobs() {
        let graph = &set.tasks[task].graph;
        let of = |node: usize| found.get(&(task, job, node));
        for (from, to) in
            graph.successors.iter().enumerate().flat_map(|(from, to)| to.iter().map(move |to| (from, *to)))
        {
            assert!(of(to).is_none_or(|to| of(from).is_some_and(|from| from.end <= to.start)), "{at}");
        }
        let due = set.releases[task][job as usize] + set.tasks[task].deadline_ns;
        let is_done = (0..graph.costs.len()).all(|node| of(node).is_some_and(|span| span.end <= due));
        assert!(is_done || !ends.fates[task][job as usize].on_time, "{at}: {task} {job}");
    }
}
