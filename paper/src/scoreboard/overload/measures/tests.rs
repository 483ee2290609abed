use super::*;
use crate::scoreboard::drive::Fate;
use crate::scoreboard::overload::load::{Shape, Times};
use crate::scoreboard::overload::rules::Rule;
use crate::scoreboard::sets::{Graph, Task};

fn fates(of: &[&str]) -> Ends {
    let fate = |c: char| Fate { on_time: c == '+', at: 0 };
    Ends { fates: of.iter().map(|of| of.chars().map(fate).collect()).collect(), ..Ends::default() }
}

fn set(tasks: &[(u64, u32, usize)]) -> Set {
    let mut set = Set::of(1, Times::Wcet);
    for (cost, value, jobs) in tasks {
        let graph = Graph { costs: vec![*cost], successors: vec![Vec::new()] };
        let task = Task { graph, period_ns: 100, deadline_ns: 100 };
        set.add(task, *value, Some((1, 2)), vec![0; *jobs], 0);
    }
    set
}

#[test]
fn the_bound_takes_what_is_worth_most_for_its_work_and_the_last_in_part() {
    // 100 ns of one lane: three of 20 ns and value 4, then 40 of the 80 ns that are worth 8.
    let set = set(&[(80, 8, 1), (20, 4, 3)]);
    assert_eq!(bound(&set), 16.0);
    assert_eq!(value(&set, &fates(&["+", "-+-"])), 12.0);
}

#[test]
fn the_least_share_stands_over_the_greatest_and_windows_are_counted() {
    assert_eq!(fairness(&fates(&["++++", "+--+"])), Some(0.5));
    assert_eq!(fairness(&fates(&["--", "---"])), None);
    let set = set(&[(1, 1, 5), (1, 1, 2)]);
    assert_eq!(floors(&set, &fates(&["+--++", "--"])), Some(3.0 / 5.0));
}

#[test]
fn no_rule_has_more_than_the_bound() {
    for (seed, shape) in (1..=3).flat_map(|seed| Shape::ALL.map(|shape| (seed, shape))) {
        let set = Set::draw(shape, 2, 1.33, Times::Uniform, seed);
        for rule in Rule::ALL {
            let value = value(&set, &rule.run(&set).unwrap());
            assert!(value <= bound(&set) + 1e-6, "{rule:?} {shape:?} {seed}");
        }
    }
}
