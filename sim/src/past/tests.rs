use super::*;
use crate::{Execution, Options, simulate, simulate_past};
use red_workload::Format;
use red_workload::build::{Plan, admit};
use red_workload::model::{SyncGrid, Workload};
use red_workload::policy::Policy;

const FILE: &str = r#"
pool = [{ name = "cpu", lanes = 1 }]
[[task]]
name = "t"
deadline = "100ms"
period = "20ms"
[[task.node]]
name = "see"
mimonet = { weights = "w", frame = "f", encoder = { wcet = "4ms" }, decoders = [{ name = "one", wcet = "3ms" }, { name = "two", wcet = "1ms" }] }
"#;

fn workload() -> Workload {
    red_workload::parse(FILE.as_bytes(), Format::Toml, "test").unwrap()
}

/// The nodes of the task under a policy.
fn nodes(policy: Policy) -> Vec<Numbered> {
    nodes_of(&workload(), policy)
}

fn nodes_of(workload: &Workload, policy: Policy) -> Vec<Numbered> {
    use red_core::{Empty, Scheduler};
    let mut scheduler: Box<Scheduler<crate::Lab>> = Box::new(Scheduler::EMPTY);
    let (plan, _): (Plan<crate::Lab>, _) = admit(&mut scheduler, workload, policy.config()).unwrap();
    plan.nodes.into_iter().next().unwrap()
}

fn options(policy: Policy) -> Options {
    let execution = Execution::Wcet;
    Options { policy, horizon_ns: 1_000_000_000, seed: 0, execution, preempt: false, schedule: true }
}

#[test]
fn a_stage_that_ran_as_one_node_gives_each_part_its_share_and_loses_nothing() {
    let mut past = Past::new(1);
    past.executed(0, 0, &nodes(Policy::Edf)[0], 4_001);
    let parts: Vec<u64> = nodes(Policy::Redrt).iter().map(|node| past.time(0, 0, node).0).collect();
    assert_eq!(parts, [2_000, 1_500, 501]);
    assert_eq!(past.time(0, 0, &nodes(Policy::Edf)[0]), (4_001, true));
}

#[test]
fn what_did_not_run_takes_its_mean_and_what_never_ran_its_wcet() {
    let mut past = Past::new(1);
    let nodes = nodes(Policy::Redrt);
    past.executed(0, 0, &nodes[1], 10);
    past.executed(0, 2, &nodes[1], 21);
    let times: Vec<u64> = (0..4).map(|job| past.time(0, job, &nodes[1]).0).collect();
    assert_eq!(times, [10, 15, 21, 15]);
    assert_eq!(past.time(0, 0, &nodes[0]), (4_000_000, false));
}

#[test]
fn an_encoder_whose_result_was_always_there_takes_what_its_like_took_in_every_policy() {
    let other = FILE.replace("name = \"see\"", "name = \"again\"");
    let (_, other) = other.split_once("[[task.node]]").unwrap();
    let workload =
        red_workload::parse(format!("{FILE}[[task.node]]{other}").as_bytes(), Format::Toml, "test").unwrap();
    let (ran, mut past) = (nodes_of(&workload, Policy::Redrt), Past::new(1));
    past.released(0, 0);
    // The second encoder, the fourth node, is the one that never ran.
    for node in [0, 1, 2, 4, 5] {
        past.executed(0, 0, &ran[node], 300_000);
    }
    assert_eq!(past.time(0, 0, &ran[3]), (300_000, true));
    let (report, unknown) = simulate_past(&workload, &past, &options(Policy::Edf)).unwrap();
    assert_eq!((report.tasks[0].response_ns.max, unknown), (Some(1_800_000), vec![]));
    // Nothing of the second stage at all: its encoder is known, its decoders are not.
    let (mut past, first) = (Past::new(1), &nodes_of(&workload, Policy::Edf)[0]);
    past.released(0, 0);
    past.executed(0, 0, first, 800_000);
    let (report, unknown) = simulate_past(&workload, &past, &options(Policy::Edf)).unwrap();
    assert_eq!((report.tasks[0].response_ns.max, unknown), (Some(5_200_000), vec!["t.again".to_owned()]));
}

#[test]
fn a_body_that_failed_fails_again_whether_its_stage_is_one_node_or_several() {
    let workload = workload();
    for recorded in [Policy::Edf, Policy::Redrt] {
        let (ran, mut past) = (nodes(recorded), Past::new(1));
        past.released(0, 0);
        past.released(0, 20_000_000);
        ran.iter().for_each(|node| past.executed(0, 0, node, 1_000_000));
        past.failed(0, 1, &ran[0], 7_000_000);
        for policy in [Policy::Edf, Policy::Redrt] {
            let task = &simulate_past(&workload, &past, &options(policy)).unwrap().0.tasks[0];
            assert_eq!((task.completed, task.shed), (1, 1), "{recorded:?}, {policy:?}");
            let first = &nodes(policy)[0];
            // Nothing is known of the next job but what the first one took.
            assert_eq!((past.time(0, 1, first).0, past.fails(0, 2, first)), (7_000_000, false));
        }
    }
}

#[test]
fn what_finds_no_room_is_told_and_not_kept() {
    let mut past = Past { kept: Past::LARGEST - 1, ..Past::new(1) };
    past.released(0, 5);
    assert!(!past.is_cut());
    past.released(0, 6);
    assert!(past.is_cut());
    assert_eq!((past.release(0, 0), past.release(0, 1)), (Some(5), None));
}

#[test]
fn a_run_had_no_grid() {
    let mut workload = workload();
    let (ran, mut past) = (nodes(Policy::Edf), Past::new(1));
    past.released(0, 0);
    past.executed(0, 0, &ran[0], 3_000_000);
    let response = |workload: &Workload| {
        simulate_past(workload, &past, &options(Policy::Edf)).unwrap().0.tasks[0].response_ns.max
    };
    let without = response(&workload);
    workload.sync = Some(SyncGrid { grid_ns: 5_000_000, cost_ns: 200_000 });
    assert_eq!((without, response(&workload)), (Some(3_000_000), Some(3_000_000)));
}

#[test]
fn a_past_of_worst_cases_is_the_simulation_of_worst_cases() {
    for policy in [Policy::Edf, Policy::Redrt] {
        let (workload, nodes, mut past) = (workload(), nodes(policy), Past::new(1));
        for job in 0..50 {
            past.released(0, job * 20_000_000);
            for node in &nodes {
                let took = Execution::Wcet.draw(0, 0, job, node);
                past.executed(0, job, node, took);
            }
        }
        let bytes = |report| serde_json::to_string(&report).unwrap();
        let (again, _) = simulate_past(&workload, &past, &options(policy)).unwrap();
        assert_eq!(bytes(again), bytes(simulate(&workload, &options(policy)).unwrap()), "{policy}");
    }
}

#[test]
fn releases_of_one_instant_all_come() {
    let mut past = Past::new(1);
    [5, 5, 5, 9].into_iter().for_each(|at| past.released(0, at));
    let (report, _) = simulate_past(&workload(), &past, &options(Policy::Redrt)).unwrap();
    assert_eq!((report.tasks[0].released, report.tasks[0].completed), (4, 4));
}
