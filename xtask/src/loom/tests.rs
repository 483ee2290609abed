use super::{Model, Row, Verdict};

fn read(output: &str, succeeded: bool) -> Row {
    let model = Model { binary: String::new(), family: "bell".into(), name: "a_model".into() };
    Row::read(&model, output.into(), succeeded)
}

#[test]
fn a_model_that_did_not_end_is_not_explored() {
    let line = |end: &str| {
        format!("running 1 test\n\nmodel a_model: 3 threads, bound 2, 70 executions, 1.5 s, {end}\n")
    };
    let explored = read(&line("explored"), true);
    assert_eq!((explored.verdict, explored.executions()), (Verdict::Explored, 70));
    assert_eq!(read(&line("NOT EXPLORED in 120 s"), false).verdict, Verdict::NotExplored);
    assert_eq!(read(&line("explored"), false).verdict, Verdict::Failed);
    assert_eq!(read("panicked", false).verdict, Verdict::Failed);
    assert_eq!(read("test a_model - should panic ... ok", true).verdict, Verdict::Caught);
}
