//! Who waits for a running encoder of its frame is lost, or saved, by what is left of that one.

use red_core::{
    Action, BestCase, Caps, Config, Dag, Duration, Frame, Instant, Node, Scheduler, ShedReason, TaskId,
    Timing, UnitId, Wcet,
};
use red_sim::{Execution, Options, simulate};
use red_tests::oracle;
use red_workload::policy::Policy;
use red_workload::{Format, parse};

const MS: u64 = 1_000_000;

/// A task of one stage, which reads the same frame as the others.
struct Stage {
    encoder_ms: u64,
    decoder_ms: u64,
    deadline_ms: u64,
    offset_ms: u64,
}

const FIVE: Stage = Stage { encoder_ms: 5, decoder_ms: 1, deadline_ms: 100, offset_ms: 0 };

impl Stage {
    fn named(&self, name: &str) -> String {
        let Self { encoder_ms, decoder_ms, deadline_ms, offset_ms } = self;
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
                decoders = [{{ name = "decoder", wcet = "{decoder_ms}ms" }}] }}
            "#
        )
    }
}

fn lanes(lanes: u64) -> String {
    format!("[[pool]]\nname = 'gpu'\nlanes = {lanes}\n[[sensor]]\nname = 'front'\nperiod = '100ms'\n")
}

/// Runs T1 and T2 on one lane. The sheds, as `task at`, in microseconds.
fn sheds(t1: &Stage, t2: &Stage) -> Vec<String> {
    sheds_in(&format!("{}{}{}", lanes(1), t1.named("T1"), t2.named("T2")))
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
    assert!(sheds(&FIVE, &Stage { encoder_ms: 20, decoder_ms: 1, deadline_ms: 10, offset_ms: 1 }).is_empty());
}

#[test]
fn a_job_that_would_be_in_time_by_its_own_encoder_is_lost_by_the_running_one() {
    // 1 ms of its own would end by 5 ms; it has to wait for the running one until then.
    assert_eq!(
        sheds(&FIVE, &Stage { encoder_ms: 1, decoder_ms: 1, deadline_ms: 4, offset_ms: 1 }),
        ["T2 1000"]
    );
}

#[test]
fn a_job_in_flight_is_lost_when_a_longer_encoder_of_its_frame_starts() {
    // Both are released at 0, T1 has the smaller key, and T2 cannot wait for its 20 ms. By themselves both are in
    // time until 10 ms and later; but the first tick after the start knows.
    let t1 = Stage { encoder_ms: 20, decoder_ms: 1, deadline_ms: 31, offset_ms: 0 };
    assert_eq!(
        sheds(&t1, &Stage { encoder_ms: 1, decoder_ms: 1, deadline_ms: 15, offset_ms: 0 }),
        ["T2 5000"]
    );
}

#[test]
fn a_node_that_takes_no_time_ends_in_an_instant_that_is_looked_at_again() {
    // As above, but z starts and ends at 0, after the encoder of 20 ms started: T2 is known to be lost at 0.
    let t1 = Stage { encoder_ms: 20, decoder_ms: 79, deadline_ms: 100, offset_ms: 0 };
    let t2 = Stage { encoder_ms: 1, decoder_ms: 4, deadline_ms: 10, offset_ms: 0 };
    let marker =
        "[[task]]\nname = 'Z'\ndeadline = '200ms'\nonce = true\nnode = [{ name = 'z', wcet = '0ns' }]\n";
    assert_eq!(sheds_in(&format!("{}{}{}{marker}", lanes(3), t1.named("T1"), t2.named("T2"))), ["T2 0"]);
}

#[test]
fn a_job_that_is_behind_is_looked_at_again_where_its_best_case_grows_within_its_worst() {
    // By its own encoder T2 takes 3 ms at best and 4.5 at worst, which is late. It has to wait for one of 3 ms, so that
    // it takes 4 ms: known as soon as z ends.
    let stage = |name: &str, deadline: &str, wcet: &str, contention: &str| {
        format!(
            r#"
            [[task]]
            name = "{name}"
            deadline = "{deadline}"
            once = true
            [[task.node]]
            name = "stage"
            mimonet = {{ weights = "w", frame = "front", decoders = [{{ name = "decoder", wcet = "1ms" }}],
                encoder = {{ wcet = "{wcet}", contention = "{contention}", atomic = true }} }}
            "#
        )
    };
    let marker =
        "[[task]]\nname = 'Z'\ndeadline = '200ms'\nonce = true\nnode = [{ name = 'z', wcet = '200us' }]\n";
    let (t1, t2) = (stage("T1", "4500us", "3ms", "10ms"), stage("T2", "3500us", "2ms", "1500us"));
    assert_eq!(sheds_in(&format!("{}{t1}{t2}{marker}", lanes(2))), ["T2 200"]);
}

type Robot = Caps<3, 4, 4>;

/// What happens to the marker's task and its unit, at instant 0.
type Happening = fn(&mut Scheduler<Robot>, TaskId, UnitId);

#[test]
fn where_the_clock_stands_still_any_event_looks_at_what_a_start_made_longer() {
    let happenings: [(&str, Option<Happening>); 5] = [
        ("nothing", None),
        ("complete", Some(|s, _, unit| s.complete(unit, Instant::ZERO).expect("it runs"))),
        ("fail", Some(|s, _, unit| s.fail(unit, Instant::ZERO).expect("it runs"))),
        ("release", Some(|s, task, _| assert!(s.release(task, Instant::ZERO).is_ok()))),
        (
            "commit",
            Some(|s, task, _| {
                let edit = s.edit(task).expect("it is there");
                let _fits = s.commit(&edit, Instant::ZERO).expect("nothing changes");
            }),
        ),
    ];
    for (best_case, (what, happens)) in [BestCase::Observed, BestCase::Declared]
        .into_iter()
        .flat_map(|best_case| happenings.map(|happening| (best_case, happening)))
    {
        let mut scheduler = Scheduler::<Robot>::new(Config { best_case, ..Config::REDRT.with_lanes(3) });
        let sensor = scheduler.add_sensor(Duration::from_millis(100)).expect("there is room");
        let frame = Frame { weights: 0, frame: 0, sensor: Some(sensor) };
        let mut add = |nodes: &[Node], deadline_ms| {
            let mut dag = Dag::new();
            let ids: Vec<_> = nodes.iter().map(|node| dag.add_node(*node).expect("it fits")).collect();
            ids.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).expect("a chain"));
            let timing = Timing::new(Duration::from_millis(deadline_ms));
            let task = scheduler.add_task(&dag, timing).expect("there is room");
            scheduler.release(task, Instant::ZERO).expect("there is room");
            task
        };
        let stage = |encoder_ms, decoder_ms| {
            let exact = |node: Node| node.best_case(node.wcet().get());
            let encoder = Node::shared_encoder(Wcet::from_millis(encoder_ms), frame);
            [encoder, Node::decoder(Wcet::from_millis(decoder_ms))].map(exact)
        };
        add(&stage(20, 79), 100);
        let lost = add(&stage(1, 4), 10);
        let marker = add(&[Node::new(Wcet::ZERO)], 200);
        let mut unit = None;
        while let Some(action) = scheduler.poll(Instant::ZERO) {
            let Action::Dispatch(started) = action else { panic!("{what}: {action:?} too early") };
            unit = Some(started.unit);
        }
        let unit = unit.expect("the marker starts last");
        if let Some(happens) = happens {
            happens(&mut scheduler, marker, unit);
        }
        let ended = std::iter::from_fn(|| scheduler.poll(Instant::ZERO));
        let given_up = ended.filter_map(|action| match action {
            Action::Ended(job) if job.task == lost => job.shed,
            _ => None,
        });
        let expected: &[_] = if happens.is_some() { &[ShedReason::Hopeless] } else { &[] };
        assert_eq!(given_up.collect::<Vec<_>>(), expected, "{what}, {best_case:?}");
    }
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
