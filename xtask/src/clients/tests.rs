use super::passed;

#[test]
fn a_run_without_tests_or_with_one_that_failed_did_not_pass() {
    assert_eq!(passed("x\n100% tests passed, 0 tests failed out of 37\n"), Some(37));
    assert_eq!(passed("100% tests passed, 0 tests failed out of 0\n"), None);
    assert_eq!(passed("97% tests passed, 1 tests failed out of 37\n"), None);
    assert_eq!(passed("No tests were found!!!\n"), None);
}
