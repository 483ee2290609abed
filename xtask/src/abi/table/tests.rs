use super::*;

#[test]
fn the_table_stands_between_its_marks_whatever_was_there() {
    let manual = format!("before\n\n{BEGIN}old\n{END}\nafter\n");
    let once = inserted(&manual, "| new |\n").unwrap();
    assert_eq!(once, format!("before\n\n{BEGIN}\n| new |\n\n{END}\nafter\n"));
    assert_eq!(inserted(&once, "| new |\n"), Ok(once.clone()));
    assert!(inserted("no marks", "").is_err());
}

#[test]
fn the_compiler_is_asked_for_every_field() {
    let fields = ["first", "second"].map(str::to_owned).to_vec();
    let text = program_of(&[Struct { name: "red_pair".into(), fields }]);
    assert!(
        text.contains("sizeof(red_pair), _Alignof(red_pair), \"first\", offsetof(red_pair, first)"),
        "{text}"
    );
    assert_eq!(text.matches("%s %zu").count(), 2);
}
