use super::*;

/// A scheduler of the largest class passes over the stack when it is made.
const STACK: usize = 1 << 24;

fn written(seeds: u64, write: Task) -> String {
    let write_all = move || {
        let mut bytes = Vec::new();
        (0..seeds).for_each(|seed| write(&Script::draw(seed), &mut bytes).expect("memory takes everything"));
        String::from_utf8(bytes).expect("ASCII")
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(write_all);
    thread.expect("a thread").join().expect("no panic")
}

#[test]
fn the_workloads_reach_what_they_claim() {
    let text = written(160, run);
    let words = [
        "4x16x16",
        "8x64x32",
        "16x256x64",
        " edf",
        " red-fg",
        " red-ida",
        " red\n",
        " redrt",
        "EndToEnd",
        "LevelSum",
        "LevelGraham",
        "PathProportional",
        "LatestFinish",
        "LatestStart",
        "! Cycle",
        "! Duplicate",
        "! UnknownNode",
        "! UnknownPool",
        "! UnknownSensor",
        "! UnknownTask",
        "! SecondEncoder",
        "! WorkOverflow",
        "! NoDecoder",
        "! Unschedulable",
        "! Conflict",
        "! Busy",
        "! Full",
        "! Stale",
        "! NotRunning",
        "! Late",
        "! ZeroPeriod",
        " LongPath ",
        " SeveralPools ",
        " Graham ",
        "Refused",
        "Hit",
        "Preempted",
        "Overran",
        "Edited",
        "Evicted",
        "hopeless",
        "overload",
        "urgency",
        "late",
        "fault",
        "removed",
        "preempt ",
        "PollOn",
        "CompleteAndPoll",
        "retire",
    ];
    let missing: Vec<_> = words.iter().filter(|word| !text.contains(**word)).collect();
    assert!(missing.is_empty(), "not in 160 traces: {missing:?}");
    let merged = |line: &str| line.contains(" start ") && line.matches('@').count() > 2;
    assert!(text.lines().any(merged), "no merged unit");
    // Each of them ends by itself.
    assert_eq!(text.matches("\nend ").count(), 160);
}

#[test]
fn a_seed_is_one_workload() {
    assert_eq!(written(3, text::write), written(3, text::write));
    assert_ne!(written(1, text::write), written(2, text::write));
}
