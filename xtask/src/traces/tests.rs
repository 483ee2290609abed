use super::*;

#[test]
fn equal_texts_have_no_difference() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
}

#[test]
fn a_difference_is_shown_with_what_came_before() {
    let shown = first_difference("a\nb\nc\n", "a\nb\nd\n").expect("c is not d");
    assert_eq!(shown, "      a\n      b\nhere  c\nthere d\n(line 3)");
}

#[test]
fn a_text_that_ends_early_differs() {
    let shown = first_difference("a\nb\n", "a\n").expect("b is missing");
    assert!(shown.ends_with("here  b\nthere (nothing more)\n(line 2)"), "{shown}");
}

#[test]
fn a_count_is_a_positive_number() {
    assert_eq!(count(&[]), Some(QUICK));
    assert_eq!(count(&["--count", "7"]), Some(7));
    for words in [&["7"][..], &["--count"], &["--count", "0"], &["--count", "x"], &["--count", "7", "8"]] {
        assert_eq!(count(words), None, "{words:?}");
    }
}
