//! Whole runs on random workloads under REDRT.

use proptest::prelude::*;
use proptest::sample::select;
use red_core::{
    Action, Caps, Config, Dag, DeadlineRule, Duration, Frame, Gate, Instant, Node, NodeId, Scheduler, Timing,
    Wcet,
};
use red_tests::drive::{Blind, Drive, Watch};
use red_tests::model::Model;
use red_tests::rng::{Shape, random_workload};
use red_workload::model::{Part, Work, Workload};
use red_workload::policy::Policy;

use super::cases;
use super::graphs::random_graph;

/// In these a late job waits for its equals, as the new graph of its task takes too long.
const GREW_TOO_LONG: [u64; 10] = [2896, 3122, 3558, 5429, 6511, 7951, 9731, 9848, 10201, 11550];

/// Long enough for several jobs of most tasks.
const HORIZON_NS: u64 = 300_000_000;

fn parts(workload: &mut Workload) -> impl Iterator<Item = &mut Part> {
    let of_tasks = workload.tasks.iter_mut().flat_map(|task| &mut task.nodes);
    let of_events = workload.events.iter_mut().flat_map(|event| &mut event.add);
    of_tasks.chain(of_events).flat_map(|node| match &mut node.work {
        Work::Plain(part) => vec![part],
        Work::Stage(stage) => {
            let decoders = stage.decoders.iter_mut().map(|(_, part)| part);
            std::iter::once(&mut stage.encoder).chain(decoders).collect()
        }
    })
}

fn judged(workload: &Workload, seed: u64) -> (u32, u32) {
    let mut model = Model::new(workload);
    let mut drive = Drive::new(workload, Config::REDRT, (100, 100), seed);
    drive.run(HORIZON_NS, &mut model);
    model.finish(&drive.scheduler);
    (model.dispatches, model.merges)
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn precedence_key_order_memory_and_merges_hold(seed: u64) {
        judged(&random_workload(seed, &Shape::default()), seed);
    }

    #[test]
    fn they_hold_under_overload_too(seed: u64) {
        judged(&random_workload(seed, &Shape { load_percent: (150, 300), ..Shape::default() }), seed);
    }

    #[test]
    fn they_hold_among_equals_whose_graphs_change(seed in prop_oneof![select(&GREW_TOO_LONG[..]), any::<u64>()]) {
        let shape = Shape { nodes: 8, memory: false, load_percent: (150, 600), ..Shape::default() };
        let mut workload = random_workload(seed, &shape);
        workload.tasks.iter_mut().for_each(|task| (task.value, task.floor) = (1, None));
        judged(&workload, seed);
    }

    #[test]
    fn jobs_that_cost_nothing_end_when_they_are_released(seed: u64) {
        let mut workload = random_workload(seed, &Shape { memory: false, ..Shape::default() });
        parts(&mut workload).for_each(|part| (part.wcet_ns, part.bcet_ns, part.contention_ns) = (0, 0, 0));
        for policy in Policy::ALL {
            let mut drive = Drive::new(&workload, policy.config(), (100, 100), seed);
            drive.run(HORIZON_NS, &mut AtOnce);
            prop_assert_eq!((drive.sheds, drive.scheduler.jobs_in_flight()), (0, 0));
        }
    }

    #[test]
    fn no_run_of_a_lone_job_exceeds_its_certificate(seed: u64, lanes in 1u8..=8, percent in 0u64..=100) {
        type Lone = Caps<1, 80, 1, 8, 1, 2>;
        let dag: Dag<Lone> = random_graph(seed, 1);
        for config in [Config::EDF, Config::REDRT] {
            let mut scheduler = Scheduler::<Lone>::new(config.with_lanes(lanes));
            let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(1 << 61))).unwrap();
            let bound = scheduler.certificate(task).unwrap().response;
            scheduler.release(task, Instant::ZERO).unwrap();
            let mut running = Vec::new();
            let mut now = Instant::ZERO;
            let ended = loop {
                match scheduler.poll(now) {
                    Some(Action::Dispatch(started)) => {
                        let wcet = scheduler.unit(started.unit).unwrap().wcet.as_nanos();
                        // Some nodes are shorter than they may be: no anomaly may break the bound.
                        let took = if started.unit.node().index() % 3 == 0 { wcet / 100 * percent } else { wcet };
                        running.push((now.saturating_add(Duration::from_nanos(took)), started.unit));
                    }
                    Some(Action::Ended(outcome)) => break outcome,
                    Some(other) => panic!("nobody asked for {other:?}"),
                    None => {
                        running.sort_by_key(|(at, unit)| (*at, unit.to_bits()));
                        let (at, unit) = running.remove(0);
                        now = at;
                        scheduler.complete(unit, now).unwrap();
                    }
                }
            };
            prop_assert!(ended.at.since(Instant::ZERO) <= bound);
        }
    }
}

/// Nothing costs anything: whatever ends, ends at its release.
struct AtOnce;

impl Watch for AtOnce {
    fn ended(&mut self, outcome: &red_core::Outcome) {
        assert_eq!((outcome.at, outcome.shed), (outcome.release, None));
    }
}

#[test]
fn the_judge_has_seen_merges_evictions_edits_and_sheds() {
    let (mut dispatches, mut merges, mut edits, mut sheds, mut evictions) = (0, 0, 0, 0, 0);
    for seed in 0..200 {
        let workload = random_workload(seed, &Shape { load_percent: (80, 250), ..Shape::default() });
        let (started, merged) = judged(&workload, seed);
        let mut drive = Drive::new(&workload, Config::REDRT, (100, 100), seed);
        drive.run(HORIZON_NS, &mut Blind);
        dispatches += started;
        merges += merged;
        edits += drive.edits;
        sheds += drive.sheds;
        evictions += drive.scheduler.counters().evictions;
    }
    assert!(
        dispatches > 1_000 && merges > 10 && edits > 10 && sheds > 10 && evictions > 0,
        "{dispatches} dispatches, {merges} merges, {edits} edits, {sheds} sheds, {evictions} evictions"
    );
}

#[test]
fn a_merged_unit_is_no_sample_of_a_member_that_costs_less() {
    type Pair = Caps<2, 2, 2>;
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let mut scheduler = Scheduler::<Pair>::new(Config::REDRT);
    let tasks = [2, 5].map(|cost| {
        let mut dag = Dag::new();
        let encoder = dag.add_node(Node::shared_encoder(Wcet::from_millis(cost), frame)).unwrap();
        let decoder = dag.add_node(Node::decoder(Wcet::from_millis(1))).unwrap();
        dag.add_edge(encoder, decoder).unwrap();
        scheduler.add_task(&dag, Timing::new(Duration::from_millis(50 + cost))).unwrap()
    });
    for task in tasks {
        scheduler.release_at(task, Instant::ZERO, Some(1), Instant::ZERO).unwrap();
    }
    let Some(Action::Dispatch(started)) = scheduler.poll(Instant::ZERO) else { panic!("an encoder starts") };
    assert_eq!(scheduler.members(started.unit).count(), 2);
    scheduler.complete(started.unit, Instant::from_nanos(5_000_000)).unwrap();
    assert_eq!(scheduler.counters().overruns, 0);
    let sample = scheduler.task_node(tasks[0], NodeId::new(0)).unwrap().1.mean();
    assert_eq!(sample, None, "it did not execute alone");
}

#[test]
fn the_judge_catches_another_order_an_idle_lane_and_an_overrun() {
    let caught = |config: Config, percent| {
        let speaks = |seed| {
            let workload = random_workload(seed, &Shape::default());
            let run = || {
                let mut model = Model::new(&workload);
                Drive::new(&workload, config, (percent, percent), seed).run(HORIZON_NS, &mut model);
            };
            std::panic::catch_unwind(run).is_err()
        };
        (0..20).any(speaks)
    };
    assert!(!caught(Config::REDRT, 100));
    assert!(caught(Config { rule: DeadlineRule::LatestFinish, ..Config::REDRT }, 100));
    assert!(caught(Config { gate: Gate::Level, ..Config::REDRT }, 100));
    assert!(caught(Config::REDRT, 101));
}
