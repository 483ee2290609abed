use super::*;
use crate::scoreboard::drive::{Fate, Span};
use crate::scoreboard::overload::load::{Shape, Times};
use crate::scoreboard::overload::rules::Rule;
use crate::scoreboard::sets::{Graph, Task};
use red_workload::policy::Policy;

/// A task of value 2 whose only job, of two nodes of 10 ns, comes at 5 and is due at 30, and one of value 1.
fn set() -> Set {
    let mut set = Set::of(1, Times::Wcet);
    let high = Graph { costs: vec![10, 10], successors: vec![vec![1], Vec::new()] };
    let low = Graph { costs: vec![20], successors: vec![Vec::new()] };
    set.add(Task { graph: high, period_ns: 100, deadline_ns: 25 }, 2, None, vec![5], 0);
    set.add(Task { graph: low, period_ns: 100, deadline_ns: 100 }, 1, None, vec![0], 0);
    set
}

fn span(task: usize, node: usize, start: u64, end: u64) -> Span {
    Span { task, job: 0, node, start, end }
}

fn broken(spans: &[Span]) -> Ends {
    let late = Fate { on_time: false, at: 40 };
    let fates = vec![vec![late], vec![Fate { on_time: true, at: 40 }]];
    Ends { fates, spans: spans.to_vec(), ..Ends::default() }
}

#[test]
fn a_group_is_blocked_by_a_node_that_had_its_lane_before_the_job_came() {
    let ends = broken(&[span(1, 0, 0, 20), span(0, 0, 20, 30), span(0, 1, 30, 40)]);
    assert_eq!(fate(&set(), &[0], &ends), Group::Blocked);
}

#[test]
fn a_node_that_takes_its_lane_while_the_group_is_ready_is_no_excuse() {
    let after = broken(&[span(1, 0, 6, 26), span(0, 0, 26, 36)]);
    assert_eq!(fate(&set(), &[0], &after), Group::Broken);
    let between = broken(&[span(0, 0, 5, 15), span(1, 0, 15, 35), span(0, 1, 35, 45)]);
    assert_eq!(fate(&set(), &[0], &between), Group::Broken);
    let nobody = broken(&[span(0, 0, 25, 35), span(0, 1, 35, 45)]);
    assert_eq!(fate(&set(), &[0], &nobody), Group::Broken);
}

/// Two jobs of the group; the first one can wait for the lower node, and then the second one comes.
#[test]
fn a_node_that_takes_its_lane_while_the_group_can_wait_blocks_what_comes_next() {
    let of = |deadline_ns: u64, gap: u64| {
        let mut set = set();
        set.tasks[0].deadline_ns = deadline_ns;
        set.releases[0] = vec![5, 27];
        let second = |node, start| Span { job: 1, ..span(0, node, start, start + 10) };
        let spans = [
            span(1, 0, 6, 26),
            span(0, 0, 26, 36),
            span(0, 1, 36, 46),
            second(0, 46 + gap),
            second(1, 56 + gap),
        ];
        let fates = [Fate { on_time: true, at: 46 - gap }, Fate { on_time: false, at: 70 }];
        let ends = Ends {
            fates: vec![fates.to_vec(), vec![Fate::default()]],
            spans: spans.to_vec(),
            ..Ends::default()
        };
        fate(&set, &[0], &ends)
    };
    assert_eq!(of(41, 0), Group::Blocked, "due at 46 after 20 of the other and 20 of its own");
    assert_eq!(of(40, 0), Group::Broken);
    assert_eq!(of(41, 20), Group::Broken, "nothing of the group was in flight between the two");
}

#[test]
fn one_in_a_hundred_may_miss() {
    let mut many = set();
    many.releases[0] = (0..200).collect();
    let of = |late: usize| {
        let mut fates = vec![vec![Fate { on_time: true, at: 0 }; 200], vec![Fate::default()]];
        fates[0][..late].fill(Fate::default());
        fate(&many, &[0], &Ends { fates, ..Ends::default() })
    };
    assert_eq!((of(2), of(3)), (Group::Whole, Group::Broken));
}

#[test]
fn a_group_is_protected_by_a_deadline_that_the_longest_other_node_leaves() {
    let group = |deadline_ns| {
        let mut set = set();
        set.tasks[0].deadline_ns = deadline_ns;
        protected(&set).unwrap()
    };
    assert_eq!((group(39), group(40)), (vec![], vec![vec![0]]));
}

/// The measure tells rules apart: job-EDF, which knows no values, breaks groups that ours keeps.
#[test]
fn edf_breaks_groups() {
    let mut whole = [0; 2];
    for seed in 1..=10 {
        let set = Set::draw(Shape::Values, 1, 1.33, Times::Wcet, seed);
        for group in protected(&set).unwrap() {
            for (policy, whole) in [Policy::Redrt, Policy::Edf].into_iter().zip(&mut whole) {
                let ends = Rule::Ours(policy).run(&set).unwrap();
                *whole += usize::from(fate(&set, &group, &ends) == Group::Whole);
            }
        }
    }
    assert!(whole[0] > 2 * whole[1], "{whole:?}");
}
