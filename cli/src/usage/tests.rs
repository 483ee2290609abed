use super::*;

fn with(argument: &str) -> String {
    message(&format!("error: unexpected argument '{argument}' found\n"), &["redrt".into(), argument.into()])
}

#[test]
fn plain_arguments_stay_as_they_are() {
    assert_eq!(with("--polcy"), "error: unexpected argument '--polcy' found\n");
}

#[test]
fn long_and_unprintable_arguments_are_cut_and_escaped() {
    let long = with(&"x".repeat(5_000));
    assert!(long.contains(&format!("'{}…'", "x".repeat(63))), "{long}");
    assert_eq!(with("\u{1b}[31m"), "error: unexpected argument '\\u{1b}[31m' found\n");
}

#[test]
fn values_after_an_equals_sign_are_cut_too() {
    let value = "y".repeat(100);
    let text = message(&format!("error: invalid value '{value}'"), &[format!("--policy={value}")]);
    assert!(text.chars().count() < 100, "{text}");
}

#[test]
fn messages_end_somewhere() {
    assert_eq!(message(&"z".repeat(9_000), &[]).chars().count(), MESSAGE_CHARACTERS);
}
