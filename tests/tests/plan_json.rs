//! The integers that `redrt plan --json` prints against an independent implementation of the specification, on
//! random workloads: stages, markers, atomic nodes, several pools, tight and loose deadlines.

use red_sim::{Execution, Lab, Options, simulate};
use red_tests::plan as reference;
use red_tests::rng::{Shape, random_workload};
use red_workload::Format;
use red_workload::model::Workload;
use red_workload::plan::{Guarantee, NodePlan, TaskPlan, plan};
use red_workload::policy::Policy;

fn nodes(planned: &[NodePlan]) -> Vec<reference::PlanNode> {
    let unsigned = |ns: i64| u64::try_from(ns).expect("a sub-deadline by level or path is not negative");
    let node = |node: &NodePlan| reference::PlanNode {
        name: node.name.clone(),
        height: node.height,
        cost_ns: node.cost_ns,
        level_sum_ns: unsigned(node.level_sum_ns),
        level_graham_ns: unsigned(node.level_graham_ns),
        path_proportional_ns: unsigned(node.path_proportional_ns),
        latest_finish_ns: node.latest_finish_ns,
        latest_start_ns: node.latest_start_ns,
    };
    planned.iter().map(node).collect()
}

fn compare(planned: &TaskPlan, expected: &reference::TaskPlan, context: &str) {
    assert_eq!(planned.work_ns, expected.work_ns, "{context}: work");
    assert_eq!(planned.critical_path_ns, expected.critical_path_ns, "{context}: critical path");
    let levels = planned.levels.iter().map(|level| reference::Level {
        cost_ns: level.cost_ns,
        share_ns: level.share_ns,
        graham_ns: level.graham_ns,
    });
    assert_eq!(levels.collect::<Vec<_>>(), expected.levels, "{context}: levels");
    assert_eq!(nodes(&planned.nodes), expected.nodes, "{context}: nodes");
    let base = &planned.certificate.base;
    assert_eq!(base.limit_ns, expected.limit_ns, "{context}: limit");
    assert_eq!(planned.certificate.levels_fit, expected.levels_fit, "{context}: levels fit");
    let bound = expected.long_path_ns.map_or(expected.graham_ns, |long| long.min(expected.graham_ns));
    assert_eq!(base.response_ns, bound, "{context}: response");
}

fn check(seed: u64, workload: &Workload) {
    let planned = plan::<Lab>(workload).expect("a random workload is valid");
    for (task, planned) in workload.tasks.iter().zip(&planned.tasks) {
        compare(planned, &reference::plan(workload, task), &format!("seed {seed}, task {}", task.name));
        assert_eq!((&planned.name, planned.deadline_ns), (&task.name, task.deadline_ns));
    }
    let bounds_hold = planned.tasks.iter().all(|task| {
        let certificate = &task.certificate;
        certificate.base.fits && certificate.changes.iter().all(|proof| proof.fits)
    });
    let admission = &planned.admission;
    assert!(!admission.fits || bounds_hold, "seed {seed}: fits although a bound does not hold");
    assert_eq!(admission.fits, admission.margin_ns >= 0, "seed {seed}: {admission:?}");
}

#[test]
fn plans_equal_the_reference_on_random_workloads() {
    let mut graphs = 0;
    for seed in 0..300 {
        let workload = random_workload(seed, &Shape::default());
        graphs += workload.tasks.len();
        check(seed, &workload);
    }
    assert!(graphs >= 300);
}

#[test]
fn plans_equal_the_reference_when_a_deadline_is_tight() {
    for seed in 1_000..1_150 {
        let mut workload = random_workload(seed, &Shape::default());
        for (i, task) in workload.tasks.iter_mut().enumerate() {
            task.deadline_ns = [1, 7, task.deadline_ns / 3 + 1][(seed as usize + i) % 3];
        }
        check(seed, &workload);
    }
}

/// What is proved holds for every execution time up to the WCET, before and after events.
#[test]
fn what_is_proved_never_misses() {
    let shape = Shape { tasks: 2, pools: 2, load_percent: (10, 70), ..Shape::default() };
    let mut proved = 0;
    for seed in 0..1_500 {
        let workload = random_workload(seed, &shape);
        if plan::<Lab>(&workload).expect("valid").admission.guarantee != Guarantee::Analytic {
            continue;
        }
        proved += 1;
        for execution in [Execution::Wcet, Execution::Uniform { low_ppm: 0, high_ppm: 1_000_000 }] {
            let horizon_ns = 2_000_000_000;
            let options = Options {
                policy: Policy::Redrt,
                horizon_ns,
                seed,
                execution,
                preempt: false,
                schedule: false,
            };
            let report = simulate(&workload, &options).expect("valid");
            let missed: u64 = report.tasks.iter().map(|task| task.missed).sum();
            assert_eq!(missed, 0, "seed {seed}, {execution:?}");
        }
    }
    assert!(proved >= 100, "only {proved} random workloads are proved");
}

/// On two lanes the bound is 22 ms, but `q.encoder`, which would take 1 ms itself, waits 9 ms for the same result.
const UNEVEN: &str = r#"
pool = [{ name = "gpu", lanes = 2 }]
[[task]]
name = "t"
deadline = "22ms"
period = "40ms"
[[task.node]]
name = "p"
mimonet = { weights = "w", frame = "f", encoder = { wcet = "10ms" }, decoders = [{ name = "d", wcet = "1ms" }] }
[[task.node]]
name = "x"
wcet = "1ms"
[[task.node]]
name = "q"
after = ["x"]
mimonet = { weights = "w", frame = "f", encoder = { wcet = "1ms" }, decoders = [{ name = "d", wcet = "20ms" }] }
"#;

#[test]
fn a_wait_for_a_slower_encoder_of_the_same_key_is_not_proved() {
    let workload = red_workload::parse(UNEVEN.as_bytes(), Format::Toml, "uneven").expect("valid");
    let plan = plan::<Lab>(&workload).expect("valid");
    assert_eq!(plan.tasks[0].certificate.base.response_ns, 22_000_000);
    assert_ne!(plan.admission.guarantee, Guarantee::Analytic);
    let options = Options {
        policy: Policy::Redrt,
        horizon_ns: 40_000_000,
        seed: 1,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    };
    assert_eq!(simulate(&workload, &options).expect("valid").tasks[0].missed, 1);
}
