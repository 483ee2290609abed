use super::*;

fn trace(seed: u64, order: Order) -> String {
    let mut text = String::new();
    write_trace(seed, order, &mut text).expect("a string takes everything");
    text
}

fn traces(count: u64) -> String {
    (0..count).map(|seed| trace(seed, Order::ByLane)).collect()
}

#[test]
fn a_tie_broken_the_other_way_is_seen() {
    let same = |seed| trace(seed, Order::ByLane) == trace(seed, Order::LastLaneFirst);
    assert!((0..10).any(|seed| !same(seed)));
}

#[test]
fn the_workloads_reach_what_they_claim() {
    let text = traces(100);
    let words = [
        "edf",
        "red-fg",
        "red-ida",
        " red\n",
        "redrt",
        "Released",
        "Refused",
        "Started",
        "Completed",
        "Hit",
        "Preempted",
        "Overran",
        "Ended",
        "Shed(Hopeless)",
        "Shed(Overload)",
        "Shed(Urgency)",
        "Shed(Late)",
        "Shed(Fault)",
        "Edited",
        "Evicted",
        "Warned",
        "Err(Stale)",
        "Err(Late)",
        "Err(Busy)",
        "Err(Full)",
        "Ok(())",
    ];
    for word in words {
        assert!(text.contains(word), "no {word} in 100 traces");
    }
    let merged = |line: &str| line.contains(" start ") && line.matches('@').count() > 1;
    assert!(text.lines().any(merged), "no merged unit in 100 traces");
    let steps_back =
        |line: &str| line.contains("clock_steps_back: ") && !line.contains("clock_steps_back: 0,");
    assert!(text.lines().any(steps_back), "no step back");
}

#[test]
fn a_command_line_that_is_not_understood_is_refused() {
    let mut text = String::new();
    for words in ["", "many", "1 first-lane-first", "1 last-lane-first more"] {
        assert_eq!(run(words.split_whitespace(), &mut text), Err(fmt::Error), "{words:?}");
    }
    assert_eq!(run(["2"].into_iter(), &mut text), Ok(()));
    assert_eq!(text, traces(2));
}
