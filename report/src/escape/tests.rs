use super::*;

#[test]
fn no_tag_can_begin_in_foreign_text() {
    assert_eq!(
        html("</script><b a='1' c=\"2\">&"),
        "&lt;/script&gt;&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;"
    );
}

#[test]
fn what_hides_or_reorders_text_is_shown() {
    assert_eq!(html("a\u{202e}b\u{7}"), "a\\u{202e}b\\u{7}");
    assert_eq!(string("a\u{202e}\n\"\\"), "\"a\\u202e\\u000a\\\"\\\\\"");
}

#[test]
fn json_in_a_script_has_no_tag_and_the_same_value() {
    assert_eq!(script(r#"{"a":"</script><!--&"}"#), r#"{"a":"\u003c/script\u003e\u003c!--\u0026"}"#);
}
