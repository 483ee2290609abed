use super::*;

#[test]
fn the_last_line_of_a_test_program_is_counted() {
    let mut tally = Tally::default();
    tally.read("running 3 tests");
    tally.read(
        "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.1s",
    );
    tally.read("test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out");
    assert_eq!(tally, Tally { passed: 15, failed: 2, ignored: 1 });
}

#[test]
fn an_ignored_test_fails_its_step() {
    let skipped = Tally { passed: 3, failed: 0, ignored: 1 };
    assert_eq!(Tally::of(&Ok(skipped)).failed, 1);
}

#[test]
fn a_step_without_tests_counts_once() {
    assert_eq!(Tally::of(&Ok(Tally::default())).passed, 1);
    let failure = Failure::Wrong("planted".into());
    assert_eq!(Tally::of(&Err(failure)), Tally { passed: 0, failed: 1, ignored: 0 });
}
