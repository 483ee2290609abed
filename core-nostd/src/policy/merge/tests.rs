use super::*;

fn at(ns: u64) -> Instant {
    Instant::from_nanos(ns)
}

#[test]
fn windows_are_anchored_at_their_first_member() {
    let releases = [at(0), at(80), at(150), at(260)];
    let window = |head| window_of(head, Duration::from_nanos(100), &releases.into_iter());
    assert_eq!([0, 80, 150, 260].map(|r| window(at(r)).as_nanos()), [0, 0, 150, 260]);
}

#[test]
fn a_release_at_the_very_end_of_a_window_is_in_it() {
    let releases = [at(0), at(100), at(101)];
    let window = |head| window_of(head, Duration::from_nanos(100), &releases.into_iter());
    assert_eq!([0, 100, 101].map(|r| window(at(r)).as_nanos()), [0, 0, 101]);
}

#[test]
fn equal_costs_join_even_when_late_and_others_only_in_time() {
    let unit = Candidate { cost: 10, latest_finish: 5 };
    assert!(join(unit, Candidate { cost: 10, latest_finish: -3 }, at(100)).is_some());
    assert!(join(unit, Candidate { cost: 4, latest_finish: 500 }, at(100)).is_none());
    let early = Candidate { cost: 10, latest_finish: 200 };
    let both = join(early, Candidate { cost: 40, latest_finish: 500 }, at(100)).unwrap();
    assert_eq!((both.cost, both.latest_finish), (40, 200));
    assert!(join(early, Candidate { cost: 101, latest_finish: 500 }, at(100)).is_none());
}
