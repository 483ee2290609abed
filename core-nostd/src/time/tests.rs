use super::*;

#[test]
fn differences_keep_their_sign_and_saturate() {
    let (a, b) = (Instant::from_nanos(3), Instant::from_nanos(10));
    assert_eq!(a.minus(b).as_nanos(), -7);
    assert_eq!(b.minus(a).as_nanos(), 7);
    assert_eq!(Instant::MAX.minus(Instant::ZERO).as_nanos(), i64::MAX);
    assert_eq!(Instant::ZERO.minus(Instant::MAX).as_nanos(), i64::MIN);
}

#[test]
fn sums_refuse_overflow() {
    assert_eq!(Instant::MAX.checked_add(Duration::from_nanos(1)), None);
    assert_eq!(Duration::from_secs(u64::MAX).as_nanos(), u64::MAX);
}
