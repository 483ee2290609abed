use super::*;

#[test]
fn urgency_is_the_elapsed_share_of_the_time_to_the_sub_deadline() {
    let of =
        |sub_deadline, elapsed| urgency(Duration::from_nanos(sub_deadline), Duration::from_nanos(elapsed)).0;
    assert_eq!([of(10, 0), of(10, 5), of(10, 10), of(10, 11)], [0, 500_000, 1_000_000, 1_000_000]);
    assert_eq!([of(0, 0), of(u64::MAX, u64::MAX - 1)], [1_000_000, 999_999]);
}
