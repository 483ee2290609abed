use super::*;

#[test]
fn jobs_that_overlap_have_rows_of_their_own_and_rows_are_used_again() {
    let spans = [(0, 25), (10, 12), (20, 30), (25, 40), (40, 40)];
    assert_eq!(rows(spans.into_iter()), [0, 1, 1, 0, 0]);
}
