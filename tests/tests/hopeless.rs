//! Who waits for a running encoder of its frame is lost, or saved, by what is left of that one.

use red_sim::{Execution, Options, simulate};
use red_tests::oracle;
use red_workload::policy::Policy;
use red_workload::{Format, parse};

const MS: u64 = 1_000_000;

/// A stage with an encoder and a decoder of 1 ms.
struct Stage {
    encoder_ms: u64,
    deadline_ms: u64,
    offset_ms: u64,
}

const FIVE: Stage = Stage { encoder_ms: 5, deadline_ms: 100, offset_ms: 0 };

/// Runs T1 and T2, which read the same frame, on one lane. The sheds, as `task at`, in microseconds.
fn sheds(t1: &Stage, t2: &Stage) -> Vec<String> {
    let task = |name: &str, Stage { encoder_ms, deadline_ms, offset_ms }: &Stage| {
        format!(
            r#"
            [[task]]
            name = "{name}"
            deadline = "{deadline_ms}ms"
            offset = "{offset_ms}ms"
            once = true
            [[task.node]]
            name = "stage"
            mimonet = {{ weights = "w", frame = "front", encoder = {{ wcet = "{encoder_ms}ms" }},
                decoders = [{{ name = "decoder", wcet = "1ms" }}] }}
            "#
        )
    };
    let pools = "[[pool]]\nname = 'gpu'\nlanes = 1\n[[sensor]]\nname = 'front'\nperiod = '100ms'\n";
    sheds_in(&format!("{pools}{}{}", task("T1", t1), task("T2", t2)))
}

/// Runs a file for 50 ms, which the oracle has to do in the same way. The sheds, as `task at`, in microseconds.
fn sheds_in(text: &str) -> Vec<String> {
    let workload = parse(text.as_bytes(), Format::Toml, "stages.toml").unwrap_or_else(|e| panic!("{e}"));
    let options = Options {
        policy: Policy::Redrt,
        horizon_ns: 50 * MS,
        seed: 1,
        execution: Execution::Wcet,
        preempt: false,
        schedule: true,
    };
    let report = simulate(&workload, &options).expect("the tasks fit");
    let found = report.sheds.unwrap_or_default();
    let found: Vec<String> = found.iter().map(|s| format!("{} {}", s.task, s.at_ns / 1_000)).collect();
    let expected = oracle::simulate(&workload, oracle::Policy::Redrt, 50 * MS).sheds;
    assert_eq!(found, expected.iter().map(|s| format!("{} {}", s.task, s.at_ns / 1_000)).collect::<Vec<_>>());
    found
}

#[test]
fn a_job_that_would_be_late_by_its_own_encoder_lives_on_the_running_one() {
    // 20 ms of its own would end after 11 ms; the hit at 5 ms and the decoder end at 7 ms.
    assert!(sheds(&FIVE, &Stage { encoder_ms: 20, deadline_ms: 10, offset_ms: 1 }).is_empty());
}

#[test]
fn a_job_that_would_be_in_time_by_its_own_encoder_is_lost_by_the_running_one() {
    // 1 ms of its own would end by 5 ms; it has to wait for the running one until then.
    assert_eq!(sheds(&FIVE, &Stage { encoder_ms: 1, deadline_ms: 4, offset_ms: 1 }), ["T2 1000"]);
}

#[test]
fn a_job_in_flight_is_lost_when_a_longer_encoder_of_its_frame_starts() {
    // Both are released at 0, T1 has the smaller key, and T2 cannot wait for its 20 ms. By themselves both are in
    // time until 10 ms and later; but the first tick after the start knows.
    let t1 = Stage { encoder_ms: 20, deadline_ms: 31, offset_ms: 0 };
    assert_eq!(sheds(&t1, &Stage { encoder_ms: 1, deadline_ms: 15, offset_ms: 0 }), ["T2 5000"]);
}

#[test]
fn a_node_that_takes_no_time_ends_in_an_instant_that_is_looked_at_again() {
    // As above, but z starts and ends at 0, after the encoder of 20 ms started: T2 is known to be lost at 0.
    let text = r#"
        [[pool]]
        name = "gpu"
        lanes = 3
        [[sensor]]
        name = "front"
        period = "100ms"
        [[task]]
        name = "T1"
        deadline = "100ms"
        once = true
        [[task.node]]
        name = "stage"
        mimonet = { weights = "w", frame = "front", encoder = { wcet = "20ms" },
            decoders = [{ name = "decoder", wcet = "79ms" }] }
        [[task]]
        name = "T2"
        deadline = "10ms"
        once = true
        [[task.node]]
        name = "stage"
        mimonet = { weights = "w", frame = "front", encoder = { wcet = "1ms" },
            decoders = [{ name = "decoder", wcet = "4ms" }] }
        [[task]]
        name = "Z"
        deadline = "200ms"
        once = true
        [[task.node]]
        name = "z"
        wcet = "0ns"
    "#;
    assert_eq!(sheds_in(text), ["T2 0"]);
}

#[test]
fn a_job_whose_result_was_thrown_away_is_lost_at_the_next_event() {
    // At 47 ms the result of the job released at 20 ms goes to make room for a decoder of 2 ms, and its 5 + 10 ms
    // do not fit before 60 ms any more. An eviction is no event, so that the end of that decoder tells.
    let text = r#"
        [[pool]]
        name = "gpu"
        lanes = 1
        memory = "50000B"
        [[task]]
        name = "T"
        deadline = "40ms"
        period = "10ms"
        [[task.node]]
        name = "stage"
        memory = "20000B"
        mimonet = { weights = "w", frame = "rear", encoder = { wcet = "5ms" }, decoders = [
            { name = "p", wcet = "2ms" }, { name = "q", wcet = "10ms" }, { name = "o", wcet = "0ns" }] }
    "#;
    assert_eq!(sheds_in(text).last().map(String::as_str), Some("T 49000"));
}
