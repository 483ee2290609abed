use super::*;

#[test]
fn burns_what_was_asked_for() {
    for duration_ns in [0, 2_000, 300_000] {
        let before = Clock::Thread.now_ns();
        Spin::new(duration_ns).run(&Call::default()).expect("a spin cannot fail");
        let burnt = Clock::Thread.now_ns() - before;
        // Only the lower side is a promise; the upper one guards against a wrong unit.
        assert!(burnt >= duration_ns, "{burnt} of {duration_ns} ns");
        assert!(burnt < duration_ns + 5_000_000, "{burnt} of {duration_ns} ns");
    }
}

#[test]
fn sleeping_is_not_burning() {
    // Other threads of this test compete for the CPU: what they take must not count.
    let rivals: Vec<_> = (0..4)
        .map(|_| {
            std::thread::spawn(|| Spin::new(5_000_000).run(&Call::default()).expect("a spin cannot fail"))
        })
        .collect();
    let before = Clock::Thread.now_ns();
    Spin::new(5_000_000).run(&Call::default()).expect("a spin cannot fail");
    assert!(Clock::Thread.now_ns() - before >= 5_000_000);
    for rival in rivals {
        rival.join().expect("a rival panicked");
    }
}
