use super::super::plan;
use super::super::tests::{Lab, independent};
use super::*;

const MS: u64 = 1_000_000;

/// Says what the tests of admission say, but for what it is told to refuse.
struct Told<F>(F);

impl<F: Fn(&Workload) -> bool> Judge for Told<F> {
    fn may_fit(&mut self, _: &Workload) -> bool {
        true
    }

    fn fits(&mut self, workload: &Workload) -> bool {
        passes::<Lab>(workload) && !self.0(workload)
    }
}

fn found(workload: &Workload, refuses: impl Fn(&Workload) -> bool) -> Cures {
    cures::<Lab>(workload, &plan::<Lab>(workload).unwrap(), &mut Told(refuses))
}

#[test]
fn what_fits_needs_no_cure() {
    assert_eq!(found(&independent(1, &[(1, 10, 10)]), |_| false), Cures::default());
}

#[test]
fn a_deadline_below_the_bound_is_cured_by_time_or_cost() {
    let cures = found(&independent(1, &[(12, 10, 20)]), |_| false).single;
    let stretch = Stretch { task: "t0".to_owned(), deadline_ns: Some(12 * MS), period_ns: None };
    let node = Cure::Node { task: "t0".to_owned(), node: "n".to_owned(), wcet_ns: 9_996_000 };
    assert_eq!(
        cures,
        [Cure::Times(vec![stretch]), node, Cure::Costs(833)],
        "neither lanes nor periods shorten one node"
    );
    assert_eq!(cures[0].to_string(), "task `t0`: deadline 12.000 ms");
    assert_eq!(cures[2].to_string(), "all costs at 83.3 % of what they are");
}

#[test]
fn an_overloaded_pool_is_cured_by_periods_lanes_or_costs() {
    let cures = found(&independent(1, &[(6, 10, 10), (6, 10, 10)]), |_| false).single;
    let period = Stretch { task: "t0".to_owned(), deadline_ns: None, period_ns: Some(15 * MS) };
    let node = Cure::Node { task: "t0".to_owned(), node: "n".to_owned(), wcet_ns: 3_996_000 };
    let lanes = Cure::Lanes { pool: "gpu".to_owned(), lanes: 2, of: 2 };
    assert_eq!(cures, [Cure::Times(vec![period]), Cure::Periods(1_200), lanes, node, Cure::Costs(833)]);
}

#[test]
fn a_change_that_the_judge_refuses_goes_on_until_it_does_not() {
    let workload = independent(1, &[(6, 10, 10), (6, 10, 10)]);
    let cures = found(&workload, |changed| period_ns(&changed.tasks[0]).unwrap() < 13 * MS).single;
    assert!(cures.contains(&Cure::Periods(1_300)), "{cures:?}");
    assert!(!cures.iter().any(|cure| matches!(cure, Cure::Lanes { .. } | Cure::Costs(_))), "{cures:?}");
}

#[test]
fn where_no_single_change_helps_all_are_slowed_down() {
    let workload = independent(1, &[(12, 10, 10)]);
    let both = |changed: &Workload| {
        let task = &changed.tasks[0];
        task.deadline_ns < 15 * MS || period_ns(task).unwrap() < 15 * MS
    };
    let cures = found(&workload, both);
    assert_eq!(cures, Cures { single: Vec::new(), together: Some(Cure::Pace(1_500)) });
    assert_eq!(found(&workload, |_| true), Cures::default());
}

#[test]
fn bisection_finds_the_border() {
    for border in 1..=9 {
        assert_eq!(first(1, 9, |n| n >= border), border);
    }
}
