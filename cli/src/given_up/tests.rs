use super::*;

#[test]
fn reasons_are_counted_and_explained_once() {
    let full: GivenUp = ["hopeless", "full", "full"].into_iter().collect();
    let (late, none): (GivenUp, _) = (["full"].into_iter().collect(), GivenUp::default());
    assert_eq!((full.to_string(), none.to_string()), ("full 2, hopeless 1".to_owned(), "-".to_owned()));
    assert_eq!(
        by_task([("a", &full), ("b", &none), ("c", &late)].into_iter()),
        "  a gave up: full 2, hopeless 1\n  c gave up: full 1\n  full: no place for a 65th job, and it had the lowest rank\n  \
         hopeless: not even its best case could end by the deadline"
    );
    assert_eq!(by_task([("b", &none)].into_iter()), "");
}
