use super::*;

#[test]
fn releases_of_the_clock_are_those_before_the_end() {
    let task = TaskId::from_bits(0);
    let count = |first_ns, period_ns| {
        made_by_clock(&[Releases { task, first_ns, period_ns }], Duration::from_nanos(10))
    };
    assert_eq!([count(0, Some(5)), count(1, Some(5)), count(9, Some(1)), count(10, Some(1))], [2, 2, 1, 0]);
    assert_eq!([count(9, None), count(10, None)], [1, 0]);
}
