use super::*;

#[test]
fn a_run_that_would_show_nothing_is_refused() {
    let wish =
        |words: &[&str]| Wish::of(words).map(|wish| (wish.target.map(|target| target.name), wish.executions));
    assert_eq!(wish(&[]), Ok((None, EXECUTIONS)));
    assert_eq!(wish(&["replay_log", "--executions", "100"]), Ok((Some("replay_log"), 100)));
    for few in [&["replay_log", "--executions", "0"][..], &["--executions", "99"], &["--executions"]] {
        assert_eq!(wish(few), Err("--executions takes a number of at least 100".to_owned()), "{few:?}");
    }
    assert!(wish(&["no-target"]).is_err_and(|why| why.contains("replay_log")));
}

#[test]
fn an_input_is_run_alone_with_a_bug_of_its_target() {
    let wish = |words: &[&str]| Wish::of(words).map(|_| ());
    assert_eq!(wish(&["abi_calls", "--input", "crash", "--planted", "lane"]), Ok(()));
    for wrong in [
        &["--input", "crash"][..],
        &["abi_calls", "--input"],
        &["abi_calls", "--planted", "lane"],
        &["workload", "--input", "crash", "--planted", "lane"],
    ] {
        assert!(wish(wrong).is_err(), "{wrong:?}");
    }
}

/// A log as libFuzzer and the standard library write it, shortened.
const LOG: &str = "\
#1024\tpulse  cov: 3051 ft: 3052 corp: 120/9Kb lim: 17 exec/s: 512 rss: 88Mb

thread '<unnamed>' (27746) panicked at fuzz_targets/abi_calls/world.rs:319:13:
assertion `left == right` failed: red_dag_refine answers
  left: Ok
 right: Closed
stack backtrace:
   0: __rustc::rust_begin_unwind
             at /rustc/library/std/src/panicking.rs:679:5
note: Some details are omitted, run with `RUST_BACKTRACE=full` for a verbose backtrace.
==27746== ERROR: libFuzzer: deadly signal
NOTE: libFuzzer has rudimentary signal handlers.
SUMMARY: libFuzzer: deadly signal
MS: 1 CrossOver-; base unit: 6d8b5923aaeff4e2f78d1e2d1f41e01978cfb7ea
artifact_prefix='fuzz/artifacts/abi_calls/'; Test unit written to fuzz/artifacts/abi_calls/crash-243128f5
stat::number_of_executed_units: 1036
";

#[test]
fn a_panic_is_found_in_a_log_with_its_place_and_all_its_lines() {
    let stop = Stop::of(LOG);
    let why = [
        "thread '<unnamed>' (27746) panicked at fuzz_targets/abi_calls/world.rs:319:13:",
        "assertion `left == right` failed: red_dag_refine answers",
        "  left: Ok",
        " right: Closed",
        "==27746== ERROR: libFuzzer: deadly signal",
        "SUMMARY: libFuzzer: deadly signal",
    ];
    assert_eq!(stop.why, why);
    assert_eq!(stop.input, Some("fuzz/artifacts/abi_calls/crash-243128f5"));
    assert_eq!(stop.line_with(&["another bug", "red_dag_refine answers"]), Some(why[1]));
    // Words of the log that are not why it stopped.
    assert_eq!(stop.line_with(&["rust_begin_unwind", "corp: "]), None);
}

#[test]
fn what_stops_a_fuzzer_without_a_panic_is_found() {
    let log = "ALARM: working on the last Unit for 1201 seconds\n\
        ==7== ERROR: libFuzzer: timeout after 1201 seconds\n    #0 0x1 in main\nSUMMARY: libFuzzer: timeout\n";
    let stop = Stop::of(log);
    let why = ["==7== ERROR: libFuzzer: timeout after 1201 seconds", "SUMMARY: libFuzzer: timeout"];
    assert_eq!((stop.why, stop.input), (why.to_vec(), None));
    assert!(Stop::of("error: could not compile `red-fuzz`\n").why.is_empty());
}

#[test]
fn a_run_that_ended_early_has_shown_nothing() {
    let came = |text: &str| came_so_far("workload", text, 1_000).map_err(|why| why.to_string());
    assert_eq!(came("stat::number_of_executed_units: 1000\n"), Ok(()));
    for (text, executions) in [("stat::number_of_executed_units: 999\n", "999"), ("Done\n", "0")] {
        assert!(came(text).is_err_and(|why| why.contains(&format!("after {executions} of 1000"))), "{text}");
    }
}
