use super::*;

#[test]
fn messages_end_somewhere() {
    assert_eq!(cut(&"é".repeat(9_000)), "é".repeat(MESSAGE_CHARACTERS));
    assert_eq!(cut("short"), "short");
}
