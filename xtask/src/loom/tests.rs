use super::{Model, Row, Verdict, Wish};

fn read(name: &str, output: &str, succeeded: bool) -> Row {
    let model = Model { binary: String::new(), family: "bell".into(), name: name.into() };
    Row::read(&model, output.into(), succeeded)
}

#[test]
fn a_model_that_did_not_end_is_not_explored() {
    let line = |end: &str, passed: u32| {
        format!(
            "running 1 test\n\nmodel a_model: 3 threads, bound 2, 70 executions, 1.5 s, {end}\n\
             test result: ok. {passed} passed; 0 failed\n"
        )
    };
    let explored = read("a_model", &line("explored", 1), true);
    assert_eq!((explored.verdict, explored.executions()), (Verdict::Explored, 70));
    assert_eq!(read("a_model", &line("NOT EXPLORED in 120 s", 0), false).verdict, Verdict::NotExplored);
    assert_eq!(
        read("a_fault_is_caught", &line("NOT EXPLORED in 120 s", 1), true).verdict,
        Verdict::NotExplored
    );
    assert_eq!(read("a_model", &line("explored", 1), false).verdict, Verdict::Failed);
    assert_eq!(read("a_model", "panicked", false).verdict, Verdict::Failed);
}

#[test]
fn only_a_planted_fault_that_ran_is_caught() {
    let ok = "test a_fault_is_caught - should panic ... ok\ntest result: ok. 1 passed; 0 failed\n";
    assert_eq!(read("a_fault_is_caught", ok, true).verdict, Verdict::Caught);
    assert_eq!(read("a_model_that_explores_nothing", ok, true).verdict, Verdict::Failed);
    let ignored = "test a_fault_is_caught ... ignored\ntest result: ok. 0 passed; 0 failed; 1 ignored\n";
    assert_eq!(read("a_fault_is_caught", ignored, true).verdict, Verdict::Failed);
}

#[test]
fn flags_may_stand_anywhere_and_are_no_names() {
    let deep = Wish { mutants: false, deep: true, names: vec!["handler"] };
    assert_eq!(Wish::of(&["handler", "--deep"]), Ok(deep));
    let mutants = Wish { mutants: true, deep: false, names: vec!["bell", "slot"] };
    assert_eq!(Wish::of(&["bell", "--mutants", "slot"]), Ok(mutants));
    for (words, told) in [(&["--depe"][..], "--depe"), (&["--deep", "--mutants"], "never deep")] {
        let refused = Wish::of(words).expect_err("it is no wish");
        assert!(refused.contains(told), "{refused}");
    }
}
