use super::*;

#[test]
fn a_run_that_would_show_nothing_is_refused() {
    let wish =
        |words: &[&str]| Wish::of(words).map(|wish| (wish.target.map(|target| target.name), wish.executions));
    assert_eq!(wish(&[]), Ok((None, EXECUTIONS)));
    assert_eq!(wish(&["replay_log", "--executions", "100"]), Ok((Some("replay_log"), 100)));
    for few in [&["replay_log", "--executions", "0"][..], &["--executions", "99"], &["--executions"]] {
        assert_eq!(wish(few), Err("--executions takes a number of at least 100".to_owned()), "{few:?}");
    }
    assert!(wish(&["no-target"]).is_err_and(|why| why.contains("replay_log")));
}
