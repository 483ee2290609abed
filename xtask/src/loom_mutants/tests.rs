use super::mutants_of;

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
