use super::*;

#[test]
fn lines_break_between_words_and_long_words_stay_whole() {
    let path = "x".repeat(90);
    assert_eq!(wrap("short line", 2), "short line");
    assert_eq!(wrap(&format!("fix: {path} now"), 2), format!("fix:\n  {path}\n  now"));
    let wrapped = wrap(&"word ".repeat(40), 7);
    assert!(wrapped.lines().all(|line| line.len() <= COLUMNS), "{wrapped}");
}

#[test]
fn without_a_terminal_there_is_no_colour() {
    assert_eq!(Paint { on: false }.red("x"), "x");
    assert_eq!(Paint { on: true }.red("x"), "\x1b[31mx\x1b[0m");
    assert_eq!(Paint { on: true }.red(""), "");
}
