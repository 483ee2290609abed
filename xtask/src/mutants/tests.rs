use super::*;

#[test]
fn a_sample_has_each_once_and_its_seed_decides() {
    let all: Vec<String> = (0..50).map(|n| n.to_string()).collect();
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let mut whole = sample(&all, 80, 3);
    assert_eq!(sample(&all, 10, 3), whole[..10]);
    assert_ne!(sample(&all, 10, 4), whole[..10]);
    whole.sort_unstable();
    whole.dedup();
    assert_eq!(whole.len(), 50);
}

#[test]
fn the_bound_is_wilsons() {
    let percent = |hits, of| (1_000.0 * lower_bound(hits, of)).round();
    assert_eq!([percent(90, 100), percent(360, 400), percent(20, 20)], [840.0, 873.0, 881.0]);
    assert_eq!(lower_bound(0, 0), 0.0);
}

#[test]
fn a_name_means_itself() {
    assert_eq!(escaped("a.rs:1:2: replace + with - in f"), r"a\.rs:1:2: replace \+ with \- in f");
}
