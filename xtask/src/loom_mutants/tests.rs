use super::*;

#[test]
fn every_ordering_is_weakened_by_one_step() {
    let text = "// Ordering::SeqCst in words\n\
                word.store(1, Ordering::Release); // Ordering::Acquire\n\
                word.load(Ordering::Relaxed);\n\
                // Only for load buffering.\n\
                word.swap(other.load(Ordering::Relaxed), Ordering::AcqRel);\n\
                word.load(Ordering::SeqCst);\n";
    let found: Vec<_> = mutants_of("a.rs", text)
        .into_iter()
        .map(|m| {
            assert_eq!(&text[m.at.0..m.at.1], m.strong);
            (m.line, m.strong, m.weak, m.is_beyond)
        })
        .collect();
    let wanted = [
        (2, "Release", "Relaxed", false),
        (5, "AcqRel", "Acquire", true),
        (5, "AcqRel", "Release", true),
        (6, "SeqCst", "Acquire", false),
    ];
    assert_eq!(found, wanted);
}

fn row(name: &str, end: &str) -> Row {
    let model = Model { binary: String::new(), family: "slot".into(), name: name.into() };
    let output =
        format!("model {name}: 3 threads, bound 2, 70 executions, 12.3 s, {end}\ntest result: ok. 1 passed");
    Row::read(&model, output, end == "explored")
}

#[test]
fn models_that_do_not_pass_where_nothing_is_weakened_catch_nothing() {
    let key = |name: &str| ("slot".to_owned(), name.to_owned());
    let passed = costs(&[row("a_model", "explored")]).ok();
    assert_eq!(passed, Some(Costs::from([(key("a_model"), 123)])));
    for end in ["panicked", "NOT EXPLORED in 120 s"] {
        let refused = costs(&[row("a_model", "explored"), row("another", end)]);
        let Err(Failure::Wrong(why)) = refused else { panic!("{end:?} is accepted") };
        assert!(why.contains("slot: another") && !why.contains("a_model"), "{why}");
    }
    assert!(costs(&[]).is_err());
}

#[test]
fn a_planted_fault_is_no_model_that_catches() {
    let model = |name: &str| Model { binary: String::new(), family: "slot".into(), name: name.into() };
    let left = without_planted(vec![model("a_fault_is_caught"), model("a_model")]);
    assert_eq!(left.iter().map(|model| &*model.name).collect::<Vec<_>>(), ["a_model"]);
}
