use super::*;

#[test]
fn long_share_agrees_with_division_where_both_apply() {
    for (a, b, c) in
        [(7u64, 3u128, 5u128), (u64::MAX, 1 << 60, 1 << 61), (1 << 62, 12_345, 99_999), (9, 5, 5)]
    {
        assert_eq!(u128::from(long_share(a, b, c)), u128::from(a) * b / c);
    }
}

#[test]
fn wide_products_do_not_wrap() {
    let whole = (1u128 << 69) - 1;
    assert_eq!(share(1 << 62, whole, whole), 1 << 62);
    assert_eq!(share(1 << 62, 1 << 68, 1 << 69), 1 << 61);
}
