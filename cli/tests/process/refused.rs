//! What every refusal has in common.

/// Refused with `status`: nothing on standard output, and a message of bounded length that is fit for a terminal and
/// says all of `words`. The message.
pub(crate) fn refused((found, out, err): (i32, String, String), status: i32, words: &[&str]) -> String {
    assert_eq!((found, &*out), (status, ""), "{words:?}: {err}");
    assert!(err.chars().count() <= 2_000 && !err.contains("panicked"), "{err}");
    assert!(!err.contains(|c: char| c != '\n' && c.is_control()), "{err:?}");
    for word in words {
        assert!(err.contains(word), "no `{word}` in: {err}");
    }
    err
}
