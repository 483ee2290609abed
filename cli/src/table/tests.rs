use super::*;

#[test]
fn columns_are_as_wide_as_their_widest_cell() {
    let mut table = Table::new(&["node", "cost"]);
    table.row(["a".to_owned(), "12.000 ms".to_owned()]);
    table.row(["control".to_owned(), "-".to_owned()]);
    assert_eq!(table.to_string(), "  node          cost\n  a        12.000 ms\n  control          -");
}

#[test]
fn times_keep_their_sign() {
    assert_eq!(signed(-1_500_000), "-1.500 ms");
    assert_eq!(signed(250), "250 ns");
    assert_eq!(time(None), "-");
}

#[test]
fn times_beyond_64_bits_are_exact() {
    let half = 1_i128 << 64;
    assert_eq!(signed(half - 1), "18446744073.709 s");
    assert_eq!(signed(-half), "-18446744073.709 s");
    assert_eq!(signed(-(half << 40)), "-20282409603651670423947.251 s");
}
