use super::*;

#[test]
fn the_bound_is_wilsons() {
    let percent = |hits, of| (1_000.0 * lower_bound(hits, of)).round();
    assert_eq!([percent(90, 100), percent(360, 400), percent(20, 20)], [840.0, 873.0, 881.0]);
    assert_eq!(lower_bound(0, 0), 0.0);
}

#[test]
fn words_are_pairs_of_a_name_and_a_number() {
    let wish = |words: &[&str]| Wish::of(words).map(|wish| (wish.sample, wish.seed));
    assert_eq!(wish(&[]), Ok((400, 1)));
    assert_eq!(wish(&["--seed", "7", "--sample", "20"]), Ok((20, 7)));
    let files = |words: &[&str]| Wish::of(words).map(|wish| wish.files);
    assert_eq!(files(&["--file", "a.rs", "--file", "b"]), Ok(vec!["a.rs".to_owned(), "b".to_owned()]));
    assert!(files(&["--file"]).is_err());
    assert!(
        wish(&["--seed"]).is_err() && wish(&["--sample", "x"]).is_err() && wish(&["--all", "1"]).is_err()
    );
}

#[test]
fn what_is_kept_is_read_again() {
    let missed = vec!["a.rs:1: + for -".into(), "b.rs:2: 0".into()];
    let found = Found { noticed: 38, unviable: 1, tests: u64::MAX, missed };
    assert_eq!(Found::read(&found.text()), Some(found));
    assert_eq!(Found::read(""), None);
}

#[test]
fn each_test_program_that_is_named_is_there() {
    let manifest = include_str!("../../../tests/Cargo.toml");
    let is_there = |name: &str| manifest.contains(&format!("[[test]]\nname = \"{name}\"\n"));
    let named: Vec<&str> = QUICK.targets.iter().filter_map(|target| target.strip_prefix("--test=")).collect();
    assert!(!named.is_empty() && named.iter().all(|name| is_there(name)) && !is_there("golden"), "{named:?}");
}
