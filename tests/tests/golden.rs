//! Small scenarios whose schedules were worked out by hand: `tests/golden/NAME.toml` says what is to be seen,
//! `NAME.trace` is what the simulator does, one action per line, in milliseconds.
//!
//! `UPDATE_GOLDEN=1` writes the traces anew; read the difference before keeping it.

use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs, thread};

use red_sim::{Execution, Options, Report, Row, simulate};
use red_workload::policy::Policy;

const PLAIN: &[Run] = &[Run { policy: Policy::Redrt, preempt: false }];

#[test]
fn the_worked_example_is_due_at_30_60_and_120() {
    golden("worked_example", &[Run { policy: Policy::RedFg, preempt: false }], 200);
}

#[test]
fn an_obstacle_appears_and_leaves() {
    let edf = Run { policy: Policy::Edf, preempt: false };
    golden("cruise", &[edf, PLAIN[0]], 250);
}

#[test]
fn encoders_of_one_frame_are_one_unit() {
    let red_ida = Run { policy: Policy::RedIda, preempt: false };
    golden("merged_unit", &[red_ida, PLAIN[0]], 100);
}

#[test]
fn a_result_serves_later_tasks_while_it_is_kept() {
    golden("frame_cache", PLAIN, 100);
}

#[test]
fn as_many_as_there_are_lanes_overtake_a_head_that_does_not_fit() {
    golden("memory_overtaking", PLAIN, 100);
}

#[test]
fn a_result_in_the_way_of_the_head_is_made_again() {
    golden("memory_eviction", PLAIN, 100);
}

#[test]
fn encoders_do_not_throw_each_others_results_away_for_ever() {
    golden("memory_encoders", &[PLAIN[0], Run { preempt: true, ..PLAIN[0] }], 100);
}

#[test]
fn an_encoder_that_runs_again_waits_for_the_one_before_it() {
    golden("memory_chain", PLAIN, 100);
}

#[test]
fn an_encoder_that_waits_for_a_frame_waits_for_the_one_before_it_again() {
    golden("memory_parked", PLAIN, 100);
}

#[test]
fn a_floor_keeps_jobs_from_being_dropped() {
    golden("overload_floors", &[Run { policy: Policy::Red, preempt: false }], 60);
}

#[test]
fn the_least_valuable_goes_first_under_overload() {
    golden("overload_values", PLAIN, 300);
}

#[test]
fn markers_take_no_time() {
    let edf = Run { policy: Policy::Edf, preempt: false };
    golden("markers", &[edf, PLAIN[0]], 100);
}

#[test]
fn a_smaller_key_takes_the_lane() {
    golden("preemption", &[PLAIN[0], Run { preempt: true, ..PLAIN[0] }], 100);
}

#[derive(Clone, Copy)]
struct Run {
    policy: Policy,
    preempt: bool,
}

/// Compares the runs of a scenario with its trace.
fn golden(name: &str, runs: &[Run], horizon_ms: u64) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden");
    let workload =
        red_workload::load(&folder.join(format!("{name}.toml"))).expect("a scenario is a workload");
    let trace = |run: &Run| {
        let options = Options {
            policy: run.policy,
            horizon_ns: horizon_ms * 1_000_000,
            seed: 1,
            execution: Execution::Wcet,
            preempt: run.preempt,
            schedule: true,
        };
        let heading = if run.preempt { "preempt " } else { "" };
        format!("{heading}{}\n{}", run.policy, lines(simulate(&workload, &options).expect("a scenario fits")))
    };
    // A scheduler for the largest workload file does not fit the stack that a test's thread gets.
    let found = thread::scope(|scope| {
        let all = || runs.iter().map(trace).collect::<Vec<_>>().join("\n");
        let thread = thread::Builder::new().stack_size(64 << 20).spawn_scoped(scope, all);
        thread.expect("a thread for the test").join().expect("the simulation ends")
    });
    let path = folder.join(format!("{name}.trace"));
    if env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(&path, &found).expect("the trace can be written");
    }
    let expected = fs::read_to_string(&path).expect("a scenario has a trace");
    assert_eq!(found, expected, "{name}: expected the trace on the right");
}

/// `start..finish lane task/job/node` or `at shed task/job reason`, in order of time, sheds of an instant first.
fn lines(report: Report) -> String {
    let sheds = report.sheds.unwrap_or_default().into_iter();
    let mut all: Vec<(u64, String)> = sheds
        .map(|shed| {
            (shed.at_ns, format!("{} shed {}/{} {}", ms(shed.at_ns), shed.task, shed.job, shed.reason))
        })
        .collect();
    all.extend(report.schedule.unwrap_or_default().iter().map(|row| (row.start_ns, line(row))));
    all.sort_by_key(|(at, _)| *at);
    all.into_iter().fold(String::new(), |mut text, (_, line)| {
        writeln!(text, "  {line}").expect("a string takes everything");
        text
    })
}

fn line(row: &Row) -> String {
    let lane = row.lane.map_or("hit".to_owned(), |lane| format!("{}:{lane}", row.pool));
    let span = format!("{}..{}", ms(row.start_ns), ms(row.finish_ns));
    format!("{span} {lane} {}/{}/{}", row.task, row.job, row.node)
}

fn ms(ns: u64) -> String {
    assert!(ns.is_multiple_of(1_000_000), "a scenario keeps to whole milliseconds, not {ns} ns");
    (ns / 1_000_000).to_string()
}
