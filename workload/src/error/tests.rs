use super::{Fault, LoadError, Place, Refusal, shown, shown_path};

#[test]
fn foreign_text_is_escaped_and_cut() {
    assert_eq!(shown("it's \"plain\""), "it's \"plain\"");
    assert_eq!(shown("\u{1b}[31m\n\u{202e}\u{200b}"), "\\u{1b}[31m\\n\\u{202e}\\u{200b}");
    assert_eq!(shown(&"a".repeat(64)), "a".repeat(64));
    assert_eq!(shown(&"a".repeat(65)), format!("{}…", "a".repeat(63)));
    for text in ["é".repeat(4_000_000), "\u{7}".repeat(100), "a\u{202e}".repeat(30)] {
        assert!(shown(&text).chars().count() <= 64);
    }
}

#[test]
fn a_long_path_keeps_its_end() {
    let path = format!("{}/robot.toml", "d/".repeat(100));
    let shown = shown_path(path.as_ref());
    assert!(shown.starts_with('…') && shown.ends_with("/robot.toml"), "{shown}");
    assert_eq!(shown.chars().count(), 64);
    assert_eq!(shown_path("a\nb.toml".as_ref()), "a\\nb.toml");
}

#[test]
fn places_count_lines_and_characters() {
    let text = "a\r\nbé = 1\n".as_bytes();
    assert_eq!(Place::of(text, 0), Place { line: 1, column: 1 });
    assert_eq!(Place::of(text, 3), Place { line: 2, column: 1 });
    assert_eq!(Place::of(text, 7), Place { line: 2, column: 4 });
    assert_eq!(Place::of(text, usize::MAX), Place { line: 3, column: 1 });
}

#[test]
fn the_nearest_name_is_near() {
    let nearest = |wanted: &str| {
        let fault = Fault::new(0, Refusal::UnknownKey, "", "");
        let nearest = fault.with_nearest(wanted, ["deadline", "period", "wcet"]).nearest;
        nearest.map(|nearest| (nearest.name, nearest.is_like)).expect("there are three")
    };
    assert_eq!(nearest("dedline"), ("deadline".to_owned(), true));
    assert_eq!(nearest("WCET"), ("wcet".to_owned(), true));
    assert_eq!(nearest("weight"), ("wcet".to_owned(), false));
    assert!(!nearest(&"x".repeat(4_000_000)).1);
}

#[test]
fn the_message_names_place_problem_and_cure() {
    let fault = Fault::new(4, Refusal::UnknownKey, "a pool has no key `lane`", "one of `lanes`");
    let error = LoadError::inside("w.toml", b"abc\nlane = 1", fault.with_nearest("lane", ["lanes"]));
    assert_eq!(
        error.to_string(),
        "w.toml:2:1: a pool has no key `lane`; expected one of `lanes`; did you mean `lanes`?"
    );
    let fault = Fault::new(4, Refusal::Reference, "`pool` is the text `gpu`", "the name of a pool");
    let error = LoadError::inside("w.toml", b"", fault.with_nearest("gpu", ["camera"]));
    assert!(error.to_string().ends_with("expected the name of a pool; the nearest name is `camera`"));
}
