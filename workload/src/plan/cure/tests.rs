use super::super::plan;
use super::super::tests::{Lab, independent};
use super::*;

const MS: u64 = 1_000_000;

fn cures_of(workload: &Workload) -> Vec<Cure> {
    cures::<Lab>(workload, &plan::<Lab>(workload).unwrap())
}

#[test]
fn what_fits_needs_no_cure() {
    assert_eq!(cures_of(&independent(1, &[(1, 10, 10)])), []);
}

#[test]
fn a_deadline_below_the_bound_is_cured_by_time_or_cost() {
    let cures = cures_of(&independent(1, &[(12, 10, 20)]));
    let stretch = Stretch { task: "t0".to_owned(), deadline_ns: Some(12 * MS), period_ns: None };
    assert_eq!(cures, [Cure::Times(vec![stretch]), Cure::Costs(833)], "lanes do not shorten one node");
    assert_eq!(cures[0].to_string(), "task `t0`: deadline 12.000 ms");
    assert_eq!(cures[1].to_string(), "all costs at 83.3 % of what they are");
}

#[test]
fn an_overloaded_pool_is_cured_by_periods_lanes_or_costs() {
    let lanes = Cure::Lanes { pool: "gpu".to_owned(), lanes: 2 };
    let cures = cures_of(&independent(1, &[(6, 10, 10), (6, 10, 10)]));
    assert_eq!(cures, [Cure::Periods(1_200), lanes, Cure::Costs(833)]);
}

#[test]
fn times_are_printed_rounded_up() {
    let stretch =
        Stretch { task: "t".to_owned(), deadline_ns: Some(12_000_001), period_ns: Some(1_000_000_001) };
    assert_eq!(Cure::Times(vec![stretch]).to_string(), "task `t`: deadline 12.001 ms and period 1.001 s");
}

#[test]
fn bisection_finds_the_border() {
    for border in 1..=9 {
        assert_eq!(smallest(1..=9, |n| n >= border), Some(border));
    }
    assert_eq!(smallest(1..=9, |_| false), None);
    let empty = std::ops::RangeInclusive::new(5, 4);
    assert_eq!(smallest(empty, |_| true), None);
}
